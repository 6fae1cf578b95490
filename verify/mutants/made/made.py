#!/usr/bin/env python3
"""Faults made by a machine: `./run mutants --made`. Enumerates all that the operators can make in the project's text,
builds a copy that has a sample of them, each behind a switch, runs verification and tests on one after the other, and
prints which share of them was seen. docs/trust.md has the scores.

What has been judged stands in FOLDER/results.jsonl, a line a fault; a later call goes on from there. The copy is made
anew when a source file has changed, and results of another text are kept by their keys: delete the file to begin anew.
"""
import argparse
import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
sys.path.insert(0, HERE)

import again  # noqa: E402
import judge  # noqa: E402
import listing  # noqa: E402
import neutral  # noqa: E402
import runs  # noqa: E402
import scores  # noqa: E402
import tree  # noqa: E402
import units  # noqa: E402

KILLED = os.path.join(HERE, "killed.json")
PROGRAMS = ["scotty", "scotty_checked"]
TESTS = ["test_reference", "test_scenes", "test_emulation", "test_simt", "test_checked", "test_fuzz"] + [
    "test_verify_" + room for room in ("capture", "invariants", "oracles", "diff", "schedules", "images", "golden", "sweep", "backends",
                                       "queues", "analysis", "report", "render", "bench", "commands")]


def say(text):
    print("made: " + text, file=sys.stderr, flush=True)


def newest_source():
    newest = 0.0
    for folder in units.ROOMS:
        for at, _, files in os.walk(os.path.join(TOP, folder)):
            newest = max([newest] + [os.stat(os.path.join(at, f)).st_mtime for f in files if f.endswith((".h", ".cpp", ".cu"))])
    return newest


def places(options):
    """All faults, from the file that remembers them."""
    path = os.path.join(options.folder, "places.json")
    if not os.path.exists(path) or os.stat(path).st_mtime < newest_source():
        say("enumerating all places: minutes")
        found = listing.list_faults(TOP, options.build, options.jobs)
        if found["errors"]:
            say(f"libclang complains, so places may be missing: {found['errors'][0]}")
        listing.save(path, found)
    return listing.load(path)


def planted(options, targets):
    """The faults that are in the copy, which is built with these targets; those that do not compile are left out."""
    path = os.path.join(options.folder, "planted.json")
    copy = tree.Tree(TOP, options.folder)
    if os.path.exists(path) and os.stat(path).st_mtime >= newest_source():
        state = listing.load(path)
    else:
        everything = places(options)
        chosen = listing.sample(everything["faults"], options.planted, options.seed, options.files)
        if options.again:
            chosen = again.chosen(everything["faults"], again.load(KILLED), options.sample, options.seed)
        edits = neutral.neutral_edits(everything["faults"], listing.Reader(TOP))
        if not options.again:
            chosen += listing.sample(edits, 2 * options.neutral, options.seed, options.files)
        state = {"places": len(everything["faults"]), "in_macros": everything["in_macros"], "left_out": [],
                 "faults": [fault | {"number": i + 1} for i, fault in enumerate(chosen)]}
    while True:
        bad = copy.plant(state["faults"])
        if not bad:
            copy.copy_project()
            copy.configure()
            say(f"building {len(state['faults'])} of {state['places']} faults: {' '.join(targets)}")
            bad = copy.compile(targets, options.jobs)
            if bad is True:
                break
        say(f"{len(bad)} do not compile and are left out")
        state["left_out"] += [f["key"] for f in state["faults"] if f["number"] in bad]
        state["faults"] = [f for f in state["faults"] if f["number"] not in bad]
        listing.save(path, state)
    listing.save(path, state)
    return copy, state


def baseline(options, copy, name, steps):
    """Which faults each step executes; remembered until the programs change."""
    path = os.path.join(options.folder, name + ".json")
    newest = max(os.stat(step.command[0]).st_mtime for step in steps)
    if not os.path.exists(path) or os.stat(path).st_mtime < newest:
        say(f"recording what {len(steps)} runs execute ({name})")
        with ThreadPoolExecutor(options.jobs) as pool:
            measured = list(pool.map(lambda step: runs.measure(step, copy.source, options.folder, options.longest), steps))
        useless = [step.name for step, done in zip(steps, measured) if done is None]
        if useless:
            say(f"{len(useless)} fail or take too long without a fault, and judge none: {', '.join(useless[:8])}")
        runs.save_steps(path, [done for done in measured if done is not None])
    return runs.load_steps(path)


def options_of(words):
    parser = argparse.ArgumentParser(prog="scotty mutants --made", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", default="*", help="only faults of these files, such as 'gpu/*'")
    parser.add_argument("--sample", type=int, default=200, help="how many are run; 0: all that are in the copy")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--planted", type=int, default=2000, help="how many are built into the copy")
    parser.add_argument("--neutral", type=int, default=30, help="edits that change nothing, run besides: no alarm is right")
    parser.add_argument("--shard", default="1/1", help="I/N: every N-th of the sample, from the I-th")
    parser.add_argument("--json", help="write totals and results to this file; - is standard output")
    parser.add_argument("--badge", help="write a badge's JSON")
    parser.add_argument("--again", action="store_true",
                        help="former survivors and a sample of killed.json, each by the run that killed it; fails if one survives now")
    parser.add_argument("--record", action="store_true", help="write what killed the judged faults into killed.json")
    parser.add_argument("--steps", type=int, default=9, help="only so many verdicts of a fault, cheap ones first; go on later")
    parser.add_argument("--longest", type=int, default=1800, help="a run or test of more seconds of processor time judges none")
    parser.add_argument("--no-tests", action="store_true", help="verification only, no unit tests")
    parser.add_argument("--no-build", action="store_true", help="take the copy as it is, however the sources have changed")
    parser.add_argument("--only-score", action="store_true", help="run nothing: scores of what has been judged")
    parser.add_argument("--folder", default=os.path.join(TOP, "build/made"))
    parser.add_argument("--build", default=os.path.join(TOP, "build/release"), help="a configured build folder")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    return parser.parse_args(words)


def sampled(options, faults):
    """Faults and neutral edits that this shard runs."""
    chosen = []
    for is_neutral, count in ((False, options.sample), (True, options.neutral)):
        of_kind = [f for f in faults if (f["operator"] == "neutral") == is_neutral]
        chosen += listing.sample(of_kind, count or len(of_kind), options.seed, options.files)
    index, parts = (int(word) for word in options.shard.split("/"))
    return chosen[index - 1::parts]


def judge_all(options, copy, chosen, results_path):
    """Appends a line to the results for each of the chosen that has none yet."""
    scotty = os.path.join(copy.build, "bin/scotty")
    steps = {}
    only_simt = all(map(judge.is_of_simt, chosen))
    for tier, of in runs.verdict_steps(scotty).items():
        kept = [] if tier == "emulator" and only_simt else of[:options.steps]
        steps[tier] = [step for one in kept for step in baseline(options, copy, "step-" + one.name, [one])]
    tests = [] if options.no_tests else baseline(options, copy, "tests", list(runs.test_steps(copy.build)))
    done = {r["key"]: r for r in scores.load_results(results_path)}
    rest = [f for f in chosen if f["key"] not in done or not judge.is_done(done[f["key"]], steps, tests)]
    say(f"{len(rest)} of {len(chosen)} to be judged")
    with ThreadPoolExecutor(options.jobs) as pool:
        waiting = [pool.submit(judge.judge, f, steps, tests, copy.source, done.get(f["key"])) for f in rest]
        for count, future in enumerate(as_completed(waiting)):
            result = future.result()
            with open(results_path, "a", encoding="utf-8") as file:
                file.write(json.dumps(result) + "\n")
            say(f"{count + 1} of {len(rest)}: {judge.sentence(result)}")


def main():
    options = options_of(sys.argv[1:])
    os.makedirs(options.folder, exist_ok=True)
    results_path = os.path.join(options.folder, "results.jsonl")
    if options.only_score or options.no_build:
        copy = tree.Tree(TOP, options.folder)
        state = listing.load(os.path.join(options.folder, "planted.json"))
    else:
        copy, state = planted(options, PROGRAMS + ([] if options.no_tests else TESTS))
    if options.again:
        return again.judge_all(state["faults"], again.load(KILLED), copy, options.jobs, say)
    chosen = sampled(options, state["faults"])
    if not options.only_score:
        judge_all(options, copy, chosen, results_path)
    latest = {r["key"]: r for r in scores.load_results(results_path)}
    results = [latest[f["key"]] for f in chosen if f["key"] in latest]
    if options.record:
        again.record(KILLED, results)
    made = scores.scores(results, scores.load_equivalents(os.path.join(HERE, "equivalents.json")))
    made |= {"places": state["places"], "planted": len(state["faults"]), "do_not_compile": len(state["left_out"]),
             "in_macros": state["in_macros"]}
    text = json.dumps({"made": made, "results": results}, indent=1) + "\n"
    if options.json == "-":
        print(text, end="")
    else:
        print(scores.table(made))
    if options.json and options.json != "-":
        tree.write_if_new(os.path.abspath(options.json), text.encode())
    if options.badge:
        tree.write_if_new(os.path.abspath(options.badge), (json.dumps(scores.badge(made)) + "\n").encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
