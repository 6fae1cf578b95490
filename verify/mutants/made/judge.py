"""One fault: is it seen by a verdict, or else by a test?"""
import re

import runs
from scores import DETECTED


def is_of_simt(fault):
    """The text of gpu/ and what runs it on a CPU are executed by the back end simt alone."""
    return fault["path"].startswith(("gpu/", "emulation/simt/", "emulation/check/"))


def tier_of(fault, steps):
    """The runs that judge a fault."""
    if is_of_simt(fault):
        return "simt"
    if "number" not in fault or any(not s.executes or fault["number"] in s.executes for s in steps["emulator"]):
        return "emulator"
    return "simt" if any(fault["number"] in step.executes for step in steps["simt"]) else "emulator"


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
    return result["verdict"] not in DETECTED and "suite" not in result


def is_done(result, steps, tests):
    if result["verdict"] in DETECTED:
        return True
    tier = steps[result.get("tier") or tier_of(result, steps)]
    return all(step.name in result["tried"] for step in tier) and not (tests and wants_tests(result))


def judge(fault, steps, tests, folder, before):
    """`before`: what a former call found, with fewer steps or without tests."""
    name_of_tier = tier_of(fault, steps)
    tier = steps[name_of_tier]
    keep = ("key", "path", "line", "function", "operator", "original", "text")
    result = dict(before) if before else {k: fault[k] for k in keep} | {"verdict": "not-executed", "tried": [], "seconds": 0}
    result["tier"] = name_of_tier
    rest = [step for step in tier if step.name not in result["tried"]]
    if result["verdict"] not in DETECTED and rest:
        kind, name, output, seconds = step_of(fault, rest, folder)
        if kind != "not-executed":
            result |= {"verdict": kind, "verdict_by": name, "check": check_of(output)}
        result |= {"tried": result["tried"] + [s.name for s in rest], "seconds": round(result["seconds"] + seconds, 2)}
    if tests and wants_tests(result):
        covering = [t for t in tests if fault["number"] in t.executes]
        kind, name, output, seconds = step_of(fault, list(runs.joined(covering)), folder)
        result |= {"suite": kind, "suite_by": name, "test": runs.first_failed_case(output), "suite_seconds": round(seconds, 2)}
    return result


def sentence(result):
    where = f"{result['path']}:{result['line']} {result['operator']}"
    verdict = result["verdict"] + (f" ({result['verdict_by']} {result['check']})" if result.get("verdict_by") else "")
    suite = f", tests: {result['suite']} {result.get('test', '')}" if "suite" in result else ""
    return f"{where}: {verdict}{suite}"
