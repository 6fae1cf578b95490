"""One fault: is it seen by a verdict, or else by a test?"""
import re

import runs


def step_of(fault, steps, folder):
    """(kind, name, words, seconds) of the first step that does not pass; kind is passed or not-executed otherwise."""
    ran, seconds = False, 0.0
    for step in steps:
        if step.executes and fault["number"] not in step.executes:
            continue
        ran = True
        outcome = runs.run(step.command, folder, step.limit(), fault=fault["number"])
        seconds += outcome.seconds
        if outcome.kind != "passed":
            return outcome.kind, step.name, outcome.output, seconds
    return ("passed" if ran else "not-executed"), "", "", seconds


def check_of(output):
    """The invariant that a verdict names first."""
    found = re.search(r"first failure: .*?\[([a-z0-9-]+)\]", output, re.S)
    return found[1] if found else ""


def wants_tests(result):
    return result["verdict"] in ("passed", "not-executed") and "suite" not in result


def judge(fault, steps, tests, folder, before):
    """`before`: what a former call found, without tests."""
    tier = steps["simt" if fault["path"].startswith("gpu/") else "emulator"]
    keep = ("key", "path", "line", "function", "operator", "original", "text")
    if before is None:
        kind, name, output, seconds = step_of(fault, tier, folder)
        result = {k: fault[k] for k in keep} | {"verdict": kind, "verdict_by": name, "check": check_of(output),
                                                "seconds": round(seconds, 2)}
    else:
        result = dict(before)
    if tests and wants_tests(result):
        covering = [t for t in tests if fault["number"] in t.executes]
        kind, name, output, seconds = step_of(fault, list(runs.joined(covering)), folder)
        result |= {"suite": kind, "suite_by": name, "test": runs.first_failed_case(output), "suite_seconds": round(seconds, 2)}
    return result


def sentence(result):
    where = f"{result['path']}:{result['line']} {result['operator']}"
    verdict = result["verdict"] + (f" ({result['verdict_by']} {result['check']})" if result["verdict_by"] else "")
    suite = f", tests: {result['suite']} {result.get('test', '')}" if "suite" in result else ""
    return f"{where}: {verdict}{suite}"
