"""Edits that change nothing: made from places that the operators found, switched on like faults, and never to be seen.

Comparisons turned round, integer sums and products in another form, independent assignments in another order. A rename
cannot stand behind a switch; it cannot change a program either, where it compiles.
"""
import re

NAME = r"[A-Za-z_][\w.]*(?:\[\w+\])?"
COMPARISON = re.compile(rf"({NAME}|\d+u?) (<|>|<=|>=|==|!=) ({NAME}|\d+u?)")
INTEGER = re.compile(rf"({NAME}) ([+*]) ({NAME}|\d+u?)")
ASSIGNMENT = re.compile(rf"({NAME}) = ({NAME}|[\d.]+f?);")
TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "==", "!=": "!="}


def root(name):
    return re.match(r"\w+", name)[0]


def turned(fault):
    """Another form of the same expression, or None."""
    if fault["operator"] == "relational":
        parts = COMPARISON.fullmatch(fault["original"])
        return parts and f"{parts[3]} {TURNED[parts[2]]} {parts[1]}"
    if fault["operator"] == "width":  # whose places are integers
        parts = INTEGER.fullmatch(fault["original"])
        return parts and f"{parts[3]} {parts[2]} {parts[1]}"
    return None


def reordered(first, second, between):
    """Two assignments that follow each other, none of which reads or writes what the other writes."""
    one, two = ASSIGNMENT.fullmatch(first["original"]), ASSIGNMENT.fullmatch(second["original"])
    if one is None or two is None or between.strip():
        return None
    apart = one[1] != two[1] and two[1] not in one[2] and one[1] not in two[2] and root(one[2]) != root(two[1])
    return f"{second['original']} {first['original']}" if apart and root(two[2]) != root(one[1]) else None


def neutral_edits(faults, read):
    """As faults of the operator "neutral"."""
    edits, statements = [], {}
    for fault in faults:
        text = turned(fault)
        if text:
            edits.append(fault | {"text": text})
        if fault["operator"] == "statement":
            previous = statements.get(fault["path"])
            if previous is not None and previous["function"] == fault["function"]:
                text = reordered(previous, fault, read(fault["path"])[previous["end"]:fault["begin"]].decode())
                if text:
                    original = previous["original"] + " " + fault["original"]
                    edits.append(previous | {"end": fault["end"], "shape": "instead", "text": text, "original": original})
            statements[fault["path"]] = fault
    unique = {(e["path"], e["begin"], e["text"]): e for e in edits}
    return [edit | {"operator": "neutral", "key": "n" + edit["key"][:11]} for edit in unique.values()]
