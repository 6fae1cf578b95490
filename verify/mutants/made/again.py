"""Faults that were killed once, each by the run that did it: is it still? Cheaper than a sweep, as nothing is searched."""
import json
import os
from concurrent.futures import ThreadPoolExecutor

import listing
import runs
from scores import DETECTED

LIMIT = 120  # seconds of processor time


def load(path):
    """key -> {"by": a step of runs.verdict_steps() or a test program, "test": its case, "former": it had survived a sweep};
    or, of a fault that survived the latest one, {"survived": true}."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return json.load(file)["killed"]


def record(path, results):
    """Adds what killed these; what was known of others stays."""
    killed = load(path)
    for result in results:
        if result["operator"] == "neutral":
            continue
        before = killed.pop(result["key"], {})
        if result["verdict"] in DETECTED:
            now = {"by": result["verdict_by"]}
        elif result.get("suite") in DETECTED and result.get("test"):
            now = {"by": result["suite_by"], "test": result["test"]}
        else:
            now = {"survived": True}
        if "by" in now and (before.get("survived") or before.get("former")):
            now["former"] = True
        killed[result["key"]] = {"file": result["path"]} | now
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"killed": dict(sorted(killed.items()))}, file, indent=1)
        file.write("\n")


def faults_of(faults, killed):
    """Those that are in the text still: an edit of its place ends a fault."""
    return [fault for fault in faults if "by" in killed.get(fault["key"], {})]


def chosen(faults, killed, count, seed):
    """All former survivors, and so many of the others."""
    known = faults_of(faults, killed)
    former = [fault for fault in known if killed[fault["key"]].get("former")]
    return former + listing.sample([fault for fault in known if fault not in former], count, seed)


def command_of(killer, build):
    for steps in runs.verdict_steps(os.path.join(build, "bin/scotty")).values():
        for step in steps:
            if step.name == killer["by"]:
                return step.command
    return [os.path.join(build, "bin", killer["by"]), killer.get("test", "") or "*", "--abort"]


def judge_all(faults, killed, copy, jobs, say):
    """An exit code: 1 where a fault has survived what killed it."""
    def judge(fault):
        return runs.run(command_of(killed[fault["key"]], copy.build), copy.source, LIMIT, fault=fault["number"])

    known = faults_of(faults, killed)
    with ThreadPoolExecutor(jobs) as pool:
        outcomes = list(pool.map(judge, known))
    survived = [fault for fault, outcome in zip(known, outcomes) if outcome.kind not in DETECTED]
    for fault in survived:
        say(f"survived what killed it: {fault['path']}:{fault['line']} {fault['original']} -> {fault['text']}")
    seconds = sum(outcome.seconds for outcome in outcomes)
    say(f"{len(known) - len(survived)} of {len(known)} killed again, {seconds:.0f} s of runs")
    return 1 if survived else 0
