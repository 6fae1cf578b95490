"""verify/mutants/made/: what the operators make of a small text, and what the compiler makes of that."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

TOP = os.path.abspath(__file__)
for _ in range(4):
    TOP = os.path.dirname(TOP)
MADE = os.path.join(TOP, "verify/mutants/made")
sys.path.insert(0, MADE)

import again  # noqa: E402
import emit  # noqa: E402
import judge  # noqa: E402
import listing  # noqa: E402
import neutral  # noqa: E402
import runs  # noqa: E402
import scores  # noqa: E402

TEXT = """struct Vec { float x, y, z; };
struct Sizes { unsigned first, second; double other; };
constexpr int kTable[2 + 1] = {1, 2, 3};
static_assert(kTable[0] + 1 == 2);
inline int min(int a, int b) { return a < b ? a : b; }
template <class T> T after(T t) { return t; }
void wait();
void barrier() {}
void wait() {}
int pick(int count, const int* of, bool ok) {
    int sum = 0;
    for (int i = 0; i < count; ++i) {
        if (ok && of[i] != 3) sum += of[i];
    }
    wait();
    barrier();  // a comment
    switch (sum) { case 7: return 1; default: break; }
    return min(sum, count);
}
float length(const Vec& v, const Sizes& s) { return v.x * v.x + static_cast<float>(s.first); }
#include <cstdio>
int main() {
    const int of[] = {1, 3, 5};
    std::printf("%d\\n", pick(3, of, true));
}
"""


class Project(unittest.TestCase):
    """A project of one file, with a build folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = folder.name
        self.path = "reference/contract/f.cpp"
        self.source = os.path.join(self.top, self.path)
        os.makedirs(os.path.dirname(self.source))
        with open(self.source, "w", encoding="utf-8") as file:
            file.write(TEXT)
        command = f"c++ -std=c++20 -o scotty_contract.dir/f.o -c {self.source}".replace(" scotty_", " x/scotty_")
        with open(os.path.join(self.top, "compile_commands.json"), "w", encoding="utf-8") as file:
            json.dump([{"file": self.source, "directory": self.top, "command": command}], file)
        listed = listing.list_faults(self.top, self.top, 1)
        self.assertEqual(listed["errors"], [])
        self.faults = [fault | {"number": i + 1} for i, fault in enumerate(listed["faults"])]

    def made(self):
        return {(f["operator"], f["original"], f["text"]) for f in self.faults}

    def test_every_operator_has_its_place(self):
        made = self.made()
        for expected in (("relational", "i < count", "i <= count"), ("relational", "of[i] != 3", "of[i] == 3"),
                         ("arithmetic", "sum += of[i]", "sum -= of[i]"), ("arithmetic", "v.x * v.x", "v.x / v.x"),
                         ("logical", "ok && of[i] != 3", "ok || of[i] != 3"), ("component", "v.x", "v.y"),
                         ("condition", "ok && of[i] != 3", "!(ok && of[i] != 3)"),
                         ("condition", "i < count", "((void)(i < count), false)"),
                         ("constant", "0", "static_cast<int>(0 + 1)"), ("constant", "3", "static_cast<int>(3 - 1)"),
                         ("statement", "wait();", ""), ("barrier", "barrier();", ""), ("statement", "sum += of[i];", ""),
                         ("extreme", "min(sum, count)", "max(sum, count)"), ("sibling", "s.first", "s.second"),
                         ("sibling", "count", "sum"), ("early-return", "", "return {};"),
                         ("initialisation", "0", "::scotty::made::unwritten(0)")):
            self.assertIn(expected, made)
        self.assertTrue(any(operator == "ulp" for operator, _, _ in made))

    def test_constant_expressions_have_none(self):
        lines = {f["line"] for f in self.faults}
        self.assertFalse(lines & {1, 2, 3, 4}, "declarations and static assertions")
        self.assertNotIn("7", {f["original"] for f in self.faults}, "a case label")
        # An endless loop tells nothing.
        self.assertNotIn(("condition", "i < count", "!(i < count)"), self.made())

    def test_keys_are_unique_and_outlive_edits_elsewhere(self):
        keys = [f["key"] for f in self.faults]
        self.assertEqual(len(keys), len(set(keys)))
        with open(self.source, "w", encoding="utf-8") as file:
            file.write("// a line more\nint other(int a) { return a + 1; }\n" + TEXT)
        after = {f["key"] for f in listing.list_faults(self.top, self.top, 1)["faults"]}
        self.assertEqual(set(keys) - after, set())

    def test_samples_are_stable(self):
        one, more = (listing.sample(self.faults, count, 7) for count in (5, 9))
        self.assertEqual(len(one), 5)
        self.assertTrue({f["key"] for f in one} < {f["key"] for f in more})
        self.assertNotEqual({f["key"] for f in listing.sample(self.faults, 5, 8)}, {f["key"] for f in one})
        self.assertEqual(listing.sample(self.faults, 5, 7, "gpu/*"), [])

    def test_neutral_edits_are_other_forms_of_the_same(self):
        edits = neutral.neutral_edits(self.faults, listing.Reader(self.top))
        made = {(e["original"], e["text"]) for e in edits}
        self.assertIn(("i < count", "count > i"), made)
        self.assertIn(("of[i] != 3", "3 != of[i]"), made)
        self.assertEqual(len({e["key"] for e in edits}), len(edits))

    def test_assignments_change_places_only_where_neither_sees_the_other(self):
        def swapped(one, two):
            return neutral.reordered({"original": one}, {"original": two}, "\n    ")

        self.assertEqual(swapped("a.x = b.x;", "a.y = b.y;"), "a.y = b.y; a.x = b.x;")
        for one, two in (("a = b;", "c = a;"), ("a = b;", "a = c;"), ("a = b;", "b = c;"), ("a = f();", "c = d;")):
            self.assertIsNone(swapped(one, two), (one, two))

    def compiled(self):
        emitter = emit.Emitter(TEXT.encode(), [f for f in self.faults if emit.can_be_written(f) and f["function"] != "min"
                                               and f["text"] != "max(sum, count)" and "/" not in f["text"]])
        text = emitter.run()
        self.assertEqual(emitter.left_out, [])
        self.assertEqual(text.count(b"\n"), TEXT.count("\n"), "lines stay those of the original")
        copied = os.path.join(self.top, "copy.cpp")
        with open(copied, "wb") as file:
            file.write(text)
        program = os.path.join(self.top, "program")
        ran = subprocess.run(["c++", "-std=c++20", "-w", "-include", os.path.join(MADE, "made.h"), copied, "-o", program],
                             capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return program

    def test_the_copy_runs_as_the_original_until_a_fault_is_switched_on(self):
        program = self.compiled()
        step = runs.measure(runs.Step("all", [program]), self.top, self.top, 60)
        self.assertEqual(runs.run([program], self.top, 10).output, "3\n")
        numbers = {(f["operator"], f["original"], f["text"]): f["number"] for f in self.faults}
        for fault, says in ((("logical", "ok && of[i] != 3", "ok || of[i] != 3"), "3\n"),
                            (("arithmetic", "sum += of[i]", "sum -= of[i]"), "-6\n"),
                            (("relational", "of[i] != 3", "of[i] == 3"), "3\n"), (("statement", "sum += of[i];", ""), "0\n")):
            self.assertIn(numbers[fault], step.executes)
            self.assertEqual(runs.run([program], self.top, 10, numbers[fault]).output, says, fault)
        self.assertNotIn(numbers[("component", "v.x", "v.y")], step.executes, "nothing calls length()")

    def test_an_error_is_put_down_to_its_fault(self):
        text = b"int a;\nint b = (MADE(4) ? (x) : (MADE(5) ? (y) : (1)));\n"
        ranges = [(15, 52, 4), (15, 31, 4), (31, 52, 5)]
        self.assertEqual(emit.at_error(text, ranges, 2, 10), [4])
        self.assertEqual(set(emit.at_error(text, ranges, 2, 1)), {4, 5})
        self.assertEqual(emit.at_error(text, ranges, 1, 2), [])


class Runs(unittest.TestCase):
    def test_outcomes_are_told_apart(self):
        def outcome(script):
            return runs.run(["bash", "-c", script], "/tmp", 1).kind

        self.assertEqual(outcome("exit 0"), "passed")
        self.assertEqual(outcome("exit 1"), "failed")
        self.assertEqual(outcome("exit 70"), "crashed")
        self.assertEqual(outcome("kill -SEGV $$"), "crashed")
        self.assertEqual(outcome("while :; do :; done"), "timed-out")


class Judge(unittest.TestCase):
    def test_the_runs_that_execute_a_fault_judge_it(self):
        steps = {"emulator": [runs.Step("quick", [], frozenset({1}))], "simt": [runs.Step("simt-quick", [], frozenset({1, 2}))]}
        for path, number, tier in (("reference/a.h", 1, "emulator"), ("gpu/a.h", 1, "simt"), ("emulation/execution/a.h", 2, "simt"),
                                   ("reference/a.h", 3, "emulator")):
            self.assertEqual(judge.tier_of({"path": path, "number": number}, steps), tier, path)


class Again(unittest.TestCase):
    def test_what_killed_a_fault_is_recorded_and_asked_again(self):
        with tempfile.TemporaryDirectory() as folder:
            killed = os.path.join(folder, "killed.json")
            common = {"path": "gpu/a.h", "operator": "constant"}
            again.record(killed, [common | {"key": "a", "verdict": "failed", "verdict_by": "simt-quick"},
                                  common | {"key": "b", "verdict": "passed", "suite": "failed", "suite_by": "test_x", "test": "x: y"},
                                  common | {"key": "c", "verdict": "passed", "suite": "passed"},
                                  common | {"key": "d", "verdict": "failed", "verdict_by": "quick", "operator": "neutral"}])
            known = again.load(killed)
            self.assertEqual({key for key in known if "by" in known[key]}, {"a", "b"})
            self.assertEqual(again.command_of(known["a"], "/b")[:2], ["/b/bin/scotty", "verify"])
            self.assertEqual(again.command_of(known["b"], "/b"), ["/b/bin/test_x", "x: y", "--abort"])
            again.record(killed, [common | {"key": "a", "verdict": "passed"},
                                  common | {"key": "c", "verdict": "crashed", "verdict_by": "quick"}])
            known = again.load(killed)
            self.assertEqual(known["c"], {"file": "gpu/a.h", "by": "quick", "former": True})
            faults = [{"key": key, "path": "gpu/a.h", "begin": 0, "end": 1} for key in "abc"]
            self.assertEqual([f["key"] for f in again.chosen(faults, known, 5, 1)], ["c", "b"])
            self.assertEqual([f["key"] for f in again.chosen(faults, known, 0, 1)], ["c"])

    def test_a_run_that_does_nothing_any_more_has_timed_out(self):
        idle, runs.IDLE = runs.IDLE, 1.0
        try:
            self.assertEqual(runs.run(["sleep", "60"], "/", 60).kind, "timed-out")
            self.assertEqual(runs.run(["sh", "-c", "while :; do :; done"], "/", 1).kind, "timed-out")
            self.assertEqual(runs.run(["sh", "-c", "exit 1"], "/", 60).kind, "failed")
            self.assertIsNone(runs.measure(runs.Step("too long", ["sh", "-c", "while :; do :; done"]), "/", None, 1))
        finally:
            runs.IDLE = idle

    def test_a_fault_that_survives_what_killed_it_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "bin"))
            program = os.path.join(folder, "bin/test_x")
            with open(program, "w", encoding="utf-8") as file:
                file.write("#!/bin/sh\n[ \"$SCOTTY_MADE\" != 1 ]\n")
            os.chmod(program, 0o755)
            copy = type("Copy", (), {"build": folder, "source": folder})
            fault = {"key": "a", "number": 1, "path": "a", "line": 1, "original": "x", "text": "y"}
            killed = {"a": {"by": "test_x", "test": "t"}, "gone": {"by": "test_x"}}
            self.assertEqual(again.judge_all([fault], killed, copy, 1, lambda _: None), 0)
            self.assertEqual(again.judge_all([fault | {"number": 2}], killed, copy, 1, lambda _: None), 1)


class Scores(unittest.TestCase):
    def test_crashes_and_equivalents_are_counted_apart(self):
        def result(key, verdict, path="gpu/a.h", **more):
            return {"key": key, "verdict": verdict, "verdict_by": "quick", "path": path, "operator": "constant",
                    "tried": ["quick", "default"], **more}

        results = [result("a", "failed"), result("b", "crashed"), result("c", "passed", suite="failed"),
                   result("d", "not-executed", suite="passed"), result("e", "failed", path="scenes/b.cpp"),
                   result("f", "passed") | {"operator": "neutral"}]
        made = scores.scores(results, {"d": "no input shows it"})
        self.assertEqual((made["run"], made["equivalent"], made["verdict_score"], made["verdict_detected"]), (5, 1, 0.4, 0.6))
        self.assertEqual((made["verdict_score_adjusted"], made["suite_score"], made["suite_score_adjusted"]), (0.5, 0.8, 1.0))
        self.assertEqual(made["folders"]["scenes"]["verdict_score"], 1.0)
        self.assertEqual(made["emulation+gpu+reference"]["run"], 4)
        self.assertEqual(made["neutral"], {"run": 1, "not_executed": 0, "false_alarms": 0})

    def test_a_score_is_a_lower_bound_before_all_verdicts_are_in(self):
        result = {"key": "a", "path": "gpu/a.h", "operator": "constant", "verdict": "passed", "tried": ["simt-two-scenes"]}
        made = scores.scores([result], {})
        self.assertEqual((made["verdicts_pending"], made["suite_pending"], made["verdict_score"]), (1, 1, 0.0))
        self.assertEqual(scores.badge(made)["message"], "at least 0 % of 1 faults")
        self.assertEqual(scores.badge(scores.scores([], {}))["message"], "not measured")

    def test_what_two_sweeps_found_at_once_is_joined(self):
        known = {"key": "a", "verdict": "passed", "tried": ["quick"]}
        lines = [known | {"suite": "failed"}, known | {"verdict": "crashed", "verdict_by": "default", "tried": ["default"]},
                 known | {"verdict": "not-executed", "tried": ["golden"]}]
        with tempfile.NamedTemporaryFile("w") as file:
            file.write("".join(json.dumps(line) + "\n" for line in lines) + "{")
            file.flush()
            found = scores.load_results(file.name)
        self.assertEqual(found, [{"key": "a", "verdict": "crashed", "verdict_by": "default", "suite": "failed",
                                  "tried": ["quick", "default", "golden"]}])

    def test_a_neutral_edit_that_is_seen_is_a_false_alarm(self):
        result = {"key": "a", "path": "gpu/a.h", "operator": "neutral", "verdict": "crashed", "verdict_by": "quick", "tried": []}
        unseen = result | {"verdict": "not-executed"}
        self.assertEqual(scores.scores([result, unseen], {})["neutral"], {"run": 1, "not_executed": 1, "false_alarms": 1})


if __name__ == "__main__":
    unittest.main()
