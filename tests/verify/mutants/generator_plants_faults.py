"""verify/mutants/generate.py: what it writes, and what it refuses."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

TOP = os.path.abspath(__file__)
for _ in range(4):
    TOP = os.path.dirname(TOP)
GENERATE = os.path.join(TOP, "verify/mutants/generate.py")
TEXT = "#pragma once\nint f(int a) {\n    wait();\n    return a + 1;\n}\nint g(int a) { return a * 2; }\n"


def fault(name, find, replace, **more):
    return {"name": name, "what": "?", "file": "k/f.h", "find": find, "replace": replace, "run": "coil",
            "expect": {"check": "?", "stage": "?"}, **more}


class Generator(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.mkdir(os.path.join(self.folder, "k"))
        with open(os.path.join(self.folder, "k/f.h"), "w", encoding="utf-8") as file:
            file.write(TEXT)

    def generate(self, faults, *arguments):
        registry = os.path.join(self.folder, "registry.json")
        with open(registry, "w", encoding="utf-8") as file:
            json.dump({"faults": faults, "hostile": []}, file)
        return subprocess.run([sys.executable, GENERATE, os.path.join(self.folder, "out"), *arguments, "--registry", registry,
                               "--top", self.folder], capture_output=True, text=True, check=False)

    def copy(self, *faults):
        ran = self.generate(list(faults), "k/f.h")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        with open(os.path.join(self.folder, "out/k/f.h"), encoding="utf-8") as file:
            return file.read()

    def refused(self, said, *faults):
        ran = self.generate(list(faults), "k/f.h")
        self.assertNotEqual(ran.returncode, 0)
        self.assertIn(said, ran.stderr)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "out/registry.cpp")))

    def test_an_expression_gets_a_switch(self):
        self.assertIn("return (SCOTTY_PLANTED(1) ? (a + 2) : (a + 1));", self.copy(fault("one", "a + 1", "a + 2")))

    def test_a_statement_says_where_the_switch_is(self):
        self.assertIn("if (!SCOTTY_PLANTED(2)) wait();\n",
                      self.copy(fault("one", "a * 2", "a"), fault("two", "wait();", "if (!PLANTED) wait();")))

    def test_several_faults_share_an_expression(self):
        self.assertIn("(SCOTTY_PLANTED(2) ? (3) : ((SCOTTY_PLANTED(1) ? (2) : (a + 1))))",
                      self.copy(fault("one", "a + 1", "2"), fault("two", "a + 1", "3")))

    def test_lines_stay_those_of_the_original(self):
        text = self.copy(fault("one", "wait();\n    return a + 1;", "if (!PLANTED) wait(); return a + 1;"))
        head, body = text.split(f'#line 1 "{self.folder}/k/f.h"\n')
        self.assertEqual(head, '#include "verify/mutants/planted.h"\n')
        self.assertEqual(body.count("\n"), TEXT.count("\n"))
        self.assertEqual(body.split("\n")[5], TEXT.split("\n")[5])

    def test_one_alone_is_always_on(self):
        ran = self.generate([fault("one", "a + 1", "2"), fault("two", "a * 2", "3")], "--alone", "two")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        with open(os.path.join(self.folder, "out/k/f.h"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("return (true ? (3) : (a * 2));", text)
        self.assertIn("return a + 1;", text)

    def left_out(self, said, broken):
        """The build goes on, with the other faults, under their own numbers; the registry says why this one is not there."""
        ran = self.generate([broken, fault("two", "a * 2", "a")], "k/f.h")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn(said, ran.stderr)
        with open(os.path.join(self.folder, "out/registry.cpp"), encoding="utf-8") as file:
            self.assertIn('"unapplied": "' + said, file.read())
        with open(os.path.join(self.folder, "out/k/f.h"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("(SCOTTY_PLANTED(2) ? (a) : (a * 2))", text)
        self.assertNotIn("SCOTTY_PLANTED(1)", text)

    def test_a_text_that_is_not_there_any_more_is_left_out(self):
        self.left_out("found 0 times in k/f.h", fault("one", "a + 7", "2"))

    def test_a_text_that_is_there_twice_is_left_out(self):
        self.left_out("found 2 times in k/f.h", fault("one", "return a", "return 2"))

    def test_one_alone_that_does_not_apply_is_refused(self):
        ran = self.generate([fault("one", "a + 7", "2")], "--alone", "one")
        self.assertNotEqual(ran.returncode, 0)
        self.assertIn("one: found 0 times", ran.stderr)

    def test_faults_that_overlap_are_refused(self):
        self.refused("two: overlaps one", fault("one", "wait();\n    return", "PLANTED"), fault("two", "return a + 1", "return 2"))

    def test_statements_do_not_share_a_place(self):
        self.refused("two: a statement's place cannot be shared, with one",
                     fault("one", "wait();", ";"), fault("two", "wait();", "if (PLANTED) wait();"))

    def test_a_name_that_is_there_twice_is_refused(self):
        self.refused("one: a name is", fault("one", "a + 1", "2"), fault("one", "a * 2", "3"))

    def test_a_missing_entry_is_refused(self):
        broken = fault("one", "a + 1", "2")
        del broken["expect"]
        self.refused("one: missing or unknown: expect", broken)

    def test_a_fault_of_a_file_that_is_gone_is_left_out(self):
        self.left_out("k/other.h is not one of the files", fault("one", "a + 1", "2", file="k/other.h"))

    def test_preprocessor_lines_and_comments_are_refused(self):
        self.refused("no preprocessor lines", fault("one", "a + 1", "2 // why"))


if __name__ == "__main__":
    unittest.main()
