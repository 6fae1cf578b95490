#!/usr/bin/env python3
"""Planted faults: writes copies of sources in which the faults of registry.json are present, each behind a switch.

  generate.py OUT FILE...        every fault, into copies of the files (paths from the project's root) below OUT, and
                                 OUT/registry.cpp: the registry for the program that is compiled from them
  generate.py OUT --alone NAME   one fault, always on, into a copy of its file below OUT: for other compilers

  --registry FILE, --top DIR     another registry, another project: for tests of this program

A fault is a text that matches once in its file, and what stands there instead. One whose text is not there any more, or is
there twice, is left out, and the registry says why ("unapplied"): `scotty mutants` fails on it, and no build does. Where it is an
expression, the two become `(PLANTED ? (replace) : (find))`; several faults may share one `find`. Otherwise `replace` says
PLANTED itself, and is the whole of the new text. Copies keep the lines of their originals and name them.
"""
import argparse
import json
import os
import re
import sys

# A fault's `run` changes this: one small configuration of `scotty verify`.
OPTIONS = {"--size": "24x18", "--spp": "1", "--bounces": "0", "--light-samples": "1", "--width": "8",
           "--rays-per-block": "64", "--queue-levels": "0", "--queues": "nodes", "--early-out": "off", "--hit-mode": "buffer", "--block-order": "linear",
           "--shadow-query": "closest", "--hit-capacity": "8", "--batch-rays": "262144", "--schedule": "free"}

HERE = os.path.dirname(os.path.abspath(__file__))
KEYS = {"name", "what", "file", "find", "replace", "run", "expect"}
MORE = {"gpu", "defect"}  # optional members


def load(path):
    with open(path, encoding="utf-8") as file:
        registry = json.load(file)
    faults = registry["faults"]
    seen = {condition["name"] for condition in registry["hostile"]}
    for fault in faults:
        name = fault.get("name", "?")
        keys = set(fault) - MORE
        if keys != KEYS:
            sys.exit(f"{path}: {name}: missing or unknown: {', '.join(sorted(keys ^ KEYS))}")
        if name in seen or not re.fullmatch(r"[a-z0-9_]+", name):
            sys.exit(f"{path}: {name}: a name is of a-z, 0-9 and _, and there once")
        seen.add(name)
    return registry


def why_not(fault, text):
    """Why a fault cannot be planted in the text of its file, which somebody may have edited; empty: it can."""
    if text is None:
        return f"{fault['file']} is not one of the files that are compiled with faults"
    count = text.count(fault["find"])
    return "" if count == 1 else f"found {count} times in {fault['file']}, not once: {fault['find']}"


def place_of(fault, text):
    """Begin and end of its `find` in the text of its file."""
    if "#" in fault["find"] or "#" in fault["replace"] or "//" in fault["replace"]:
        sys.exit(f"{fault['name']}: no preprocessor lines and no comments in what is replaced")
    begin = text.index(fault["find"])
    return begin, begin + len(fault["find"])


def planted_text(faults, switches):
    """What stands where all of these faults' `find` stood, on as many lines."""
    find = faults[0]["find"]
    planted = find
    for fault, switch in zip(faults, switches):
        if re.search(r"\bPLANTED\b", fault["replace"]):
            if len(faults) > 1:
                sys.exit(f"{fault['name']}: a statement's place cannot be shared, with {faults[0]['name']}")
            planted = re.sub(r"\bPLANTED\b", switch, fault["replace"])
        else:
            planted = f"({switch} ? ({fault['replace']}) : ({planted}))"
    # A statement may be shorter or longer than its replacement, which then goes to the first line as a whole.
    missing = find.count("\n") - planted.count("\n")
    return planted if missing == 0 else planted.replace("\n", " ") + "\n" * find.count("\n")


def plant(path, text, faults, switch_of):
    """The text with all faults of this file planted."""
    places = {}
    for fault in faults:
        places.setdefault(place_of(fault, text), []).append(fault)
    result, done, before = "", 0, None
    for (begin, end), sharing in sorted(places.items()):
        if begin < done:
            sys.exit(f"{sharing[0]['name']}: overlaps {before} in {path}")
        result += text[done:begin] + planted_text(sharing, [switch_of(fault) for fault in sharing])
        done, before = end, sharing[0]["name"]
    return result + text[done:]


def write_if_new(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            if file.read() == text:
                return
    with open(path + ".unfinished", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".unfinished", path)


def read(top, path):
    with open(os.path.join(top, path), encoding="utf-8") as file:
        return file.read()


def copy(top, out, path, faults, switch_of, header):
    text = plant(path, read(top, path), faults, switch_of)
    line = f'#line 1 "{os.path.join(top, path)}"\n'
    write_if_new(os.path.join(out, path), header + line + text)


def command_line(fault):
    """`run` is a scene and what differs from OPTIONS, or a whole command line."""
    words = fault["run"].split()
    if words[0] == "verify":
        return fault["run"]
    options = OPTIONS | dict(zip(words[1::2], words[2::2]))
    kernels = {"gpu": "--backend simt --check ", "reference": "--backend simt "}.get(fault["file"].split("/")[0], "")
    return f"verify {words[0]} {kernels}--no-golden " + " ".join(f"{key} {value}" for key, value in options.items())


def registry_source(registry):
    """The registry as text in the program, in pieces that every compiler takes, without what only this file needs."""
    kept = [{key: value for key, value in fault.items() if key not in ("find", "replace", "gpu")} | {"run": command_line(fault)}
            for fault in registry["faults"]]
    text = '{"faults": [\n' + ",\n".join(map(json.dumps, kept))
    text += '\n], "hostile": [\n' + ",\n".join(map(json.dumps, registry["hostile"])) + "\n]}"
    pieces = "\n".join(f'R"_({line}\n)_"' for line in text.split("\n"))
    return ('#include "verify/mutants/planted.h"\n\nnamespace scotty::planted {\n\n'
            f'int active = 0;\nconst char* const kRegistry =\n{pieces};\n\n}}  // namespace scotty::planted\n')


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("out")
    parser.add_argument("files", nargs="*")
    parser.add_argument("--alone")
    parser.add_argument("--registry", default=os.path.join(HERE, "registry.json"))
    parser.add_argument("--top", default=os.path.dirname(os.path.dirname(HERE)))
    options = parser.parse_args()
    registry = load(options.registry)
    faults = registry["faults"]
    if options.alone:
        chosen = [fault for fault in faults if fault["name"] == options.alone]
        if not chosen:
            sys.exit(f"{options.alone}: no such fault in {options.registry}")
        reason = why_not(chosen[0], read(options.top, chosen[0]["file"]))
        if reason:
            sys.exit(f"{options.alone}: {reason}")
        copy(options.top, options.out, chosen[0]["file"], chosen, lambda _: "true", "")
        return
    texts = {path: read(options.top, path) for path in options.files}
    for fault in faults:
        reason = why_not(fault, texts.get(fault["file"]))
        if reason:
            fault["unapplied"] = reason
            print(f"{fault['name']} does not apply any more: {reason}", file=sys.stderr)
    numbers = {fault["name"]: index + 1 for index, fault in enumerate(faults)}
    for path in options.files:
        here = [fault for fault in faults if fault["file"] == path and "unapplied" not in fault]
        header = '#include "verify/mutants/planted.h"\n' if here else ""
        copy(options.top, options.out, path, here, lambda fault: f"SCOTTY_PLANTED({numbers[fault['name']]})", header)
    write_if_new(os.path.join(options.out, "registry.cpp"), registry_source(registry))


if __name__ == "__main__":
    main()
