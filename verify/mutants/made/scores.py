"""Scores of a sweep: per folder, raw and without the faults that no input can show."""
import json
import os
from collections import Counter

CAUGHT = {"failed"}
DETECTED = {"failed", "crashed", "timed-out"}
FIRST_STEPS = {"quick", "simt-two-scenes"}
LAST_STEPS = {"default", "simt-quick"}  # of runs.verdict_steps: with one of them a verdict is whole


def load_results(path):
    """What is known of each fault; several sweeps may have written at once, each what it found."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        lines = [json.loads(line) for line in file if line.endswith("\n")]
    known = {}
    for line in lines:
        known[line["key"]] = joined(known[line["key"]], line) if line["key"] in known else line
    return list(known.values())


def joined(one, other):
    """A verdict that saw the fault stays."""
    best = one if one["verdict"] in DETECTED or other["verdict"] == "not-executed" else other
    return one | other | best | {"tried": one["tried"] + [step for step in other["tried"] if step not in one["tried"]]}


def load_equivalents(path):
    """key -> why."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding="utf-8") as file:
        return {entry["key"]: entry["why"] for entry in json.load(file)["equivalents"]}


def share(part, whole):
    return round(part / whole, 4) if whole else None


def is_pending(result):
    """Only cheap verdicts were asked so far, and they passed."""
    return result["verdict"] not in DETECTED and not LAST_STEPS & set(result["tried"])


def score_of(results, equivalents):
    """`verdict_score`: verify says FAILED; `..._detected` counts crashes and time-outs too; both are lower bounds while
    `verdicts_pending` of those that passed have not been asked everything.
    `quick_...`: the first, cheapest run alone. `adjusted` is without the equivalents. Suite scores are of the faults that
    the tests were run for."""
    kept = [r for r in results if r["key"] not in equivalents]
    pending = sum(map(is_pending, results))
    totals = {"run": len(results), "equivalent": len(results) - len(kept), "verdicts_pending": pending,
              "suite_pending": sum(r["verdict"] not in DETECTED and "suite" not in r for r in results)}

    def both(name, of, hit):
        totals[name] = share(sum(hit(r) for r in results if of(r)), sum(1 for r in results if of(r)))
        totals[name + "_adjusted"] = share(sum(hit(r) for r in kept if of(r)), sum(1 for r in kept if of(r)))

    def quick(r):
        return r["verdict"] == "failed" and r.get("verdict_by") in FIRST_STEPS

    def everything(r):
        return True

    both("quick_verdict_score", everything, quick)
    both("quick_verdict_detected", everything, lambda r: r["verdict"] in DETECTED and r["verdict_by"] in FIRST_STEPS)
    both("verdict_score", everything, lambda r: r["verdict"] in CAUGHT)
    both("verdict_detected", everything, lambda r: r["verdict"] in DETECTED)

    def suite(r):
        return r["verdict"] in DETECTED or r.get("suite") in DETECTED

    both("suite_score", lambda r: r["verdict"] in DETECTED or "suite" in r, suite)
    totals["verdicts"] = dict(Counter(r["verdict"] for r in results))
    totals["suite"] = dict(Counter(r["suite"] for r in results if "suite" in r))
    return totals


def scores(results, equivalents):
    """The totals as the JSON has them."""
    real = [r for r in results if r["operator"] != "neutral"]
    neutral = [r for r in results if r["operator"] == "neutral"]
    made = score_of(real, equivalents)
    made["folders"] = {folder: score_of([r for r in real if r["path"].split("/")[0] == folder], equivalents)
                       for folder in sorted({r["path"].split("/")[0] for r in real})}
    under_test = [r for r in real if r["path"].split("/")[0] in ("emulation", "gpu", "reference")]
    made["emulation+gpu+reference"] = score_of(under_test, equivalents)
    ran = [r for r in neutral if (r["verdict"], r.get("suite", "not-executed")) != ("not-executed", "not-executed")]
    alarms = [r for r in ran if {r["verdict"], r.get("suite")} & DETECTED]
    made["neutral"] = {"run": len(ran), "not_executed": len(neutral) - len(ran), "false_alarms": len(alarms)}
    return made


def table(made):
    lines = [f"{'folder':<24} {'faults':>6} {'equiv.':>6} {'quick':>7} {'+crash':>7} {'verdict':>7} {'+crash':>7} {'suite':>7}"]

    def percent(value):
        return "-" if value is None else f"{100 * value:.1f} %"

    rows = list(made["folders"].items()) + [("emulation+gpu+reference", made["emulation+gpu+reference"]), ("all", made)]
    for name, row in rows:
        for raw in (True, False):
            end = "" if raw else "_adjusted"
            if not raw and not row["equivalent"]:
                continue
            cells = [percent(row[key + end]) for key in ("quick_verdict_score", "quick_verdict_detected", "verdict_score", "verdict_detected",
                                                           "suite_score")]
            count = row["run"] if raw else row["run"] - row["equivalent"]
            lines.append(f"{name if raw else '  adjusted':<24} {count:>6} {row['equivalent'] if raw else '':>6} "
                         + " ".join(f"{cell:>7}" for cell in cells))
    if made["verdicts_pending"]:
        lines.append(f"verdicts are at least that: {made['verdicts_pending']} faults that passed were not asked everything")
    lines.append(f"neutral edits: {made['neutral']['run']}, false alarms: {made['neutral']['false_alarms']}")
    return "\n".join(lines)


def badge(made):
    """For shields.io's endpoint."""
    under_test = made["emulation+gpu+reference"]
    score = under_test["verdict_detected_adjusted"]
    least = "at least " if under_test["verdicts_pending"] else ""
    message = "not measured" if score is None else f"{least}{100 * score:.0f} % of {under_test['run']} faults"
    return {"schemaVersion": 1, "label": "verdict", "message": message}
