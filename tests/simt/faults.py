#!/usr/bin/env python3
"""Planted faults in the CUDA text, caught without a GPU, with kernel, line and threads named.

  faults.py BUILD OUT [NAME...]   plants each fault of tests/gpu/faults.json and tests/simt/faults.json, builds scotty-checked
                                  with it, runs it against a capture of the emulator, prints a table; 1 if one escapes

A fault is a replacement in one file of gpu/ that has to match once, so that it cannot rot unseen. `error` is what a kernel
has to be stopped with, `first` the launch that differs first where none is, `by` who has to be named for it (by default a
thread, a kernel and a line), all as regular expressions.
"""
import json
import os
import re
import shlex
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "gpu"))
sys.dont_write_bytecode = True
import faults as on_gpu  # tests/gpu/faults.py

TOP = on_gpu.TOP
RUN = on_gpu.RUN
NAMED = r"written by thread \d+ of block \d+ of kernel \S+ at \S*(gpu|reference|emulation)/\S+:\d+"


def load():
    """Faults of the GPU's list too; what tests/simt/ says of one of them holds here."""
    faults = {}
    for name in ("tests/gpu/faults.json", "tests/simt/faults.json"):
        with open(os.path.join(TOP, name), encoding="utf-8") as file:
            for fault in json.load(file):
                faults.setdefault(fault["name"], {}).update(fault)
    return faults.values()


def run_of(fault):
    return fault.get("run", "--rays-per-block 64")


def build_program(build, folder, units):
    """The build's own commands for the units and the link, with the faulty tree first and another output."""
    target, program, archive = "scotty_simt_checked", "scotty-checked", r" (\S*libscotty\S*\.a)"
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = {entry["file"]: entry["command"] for entry in json.load(file)
                    if f"/{target}.dir/" in entry["command"]}
    objects = []
    for unit in units:
        command = shlex.split(commands[os.path.join(TOP, f"verify/simt/{unit}.cpp")])
        faulty = os.path.join(folder, unit + ".o")
        command[command.index("-o") + 1] = faulty
        compiler = next(i for i, word in enumerate(command) if word.endswith("++"))
        subprocess.run([*command[compiler:compiler + 1], "-I", folder, *command[compiler + 1:], "-O1"], cwd=build, check=True)
        objects.append(faulty)
    link = subprocess.run(["ninja", "-C", build, "-t", "commands", "-s", "bin/" + program],
                          capture_output=True, text=True, check=True).stdout.splitlines()[-1]
    for unit in units:  # where the link names objects, the faulty one stands in
        link = re.sub(rf" \S*verify/simt/{unit}\.cpp\.o", "", link)
    # Before all else, so that the faulty versions of templates are the ones that count.
    built = os.path.join(folder, program)
    first = re.search(archive, link)
    link = link[:first.start()] + " " + " ".join(map(shlex.quote, objects)) + link[first.start():]
    subprocess.run(re.sub(r"-o \S*bin/" + program, "-o " + shlex.quote(built), link), shell=True, cwd=build, check=True)
    return built


def try_fault(fault, build, out):
    """What was said first, and whether that is what should have been."""
    folder = os.path.join(out, fault["name"])
    on_gpu.plant(fault, folder)
    faulty = build_program(build, folder, fault["units"])
    expected = os.path.join(out, re.sub(r"[^a-z0-9]+", "_", "emulator " + run_of(fault)))
    if not os.path.exists(expected):
        subprocess.run([os.path.join(build, "bin/scotty"), "capture", *RUN.split(), *run_of(fault).split(), "-o", expected],
                       check=True, capture_output=True)
    ran = subprocess.run([faulty, "diff", expected, "--backend", "simt", "--json"],
                         capture_output=True, text=True, check=False)
    shorten = r"[\w./-]*/(?=(gpu|reference|emulation)/\w+\.h:\d)"  # of paths, all before the project's folder
    if ran.returncode != 1:  # by its own fault at the most
        said = re.sub(shorten, "", (ran.stderr.strip() or "nothing").splitlines()[-1])
        return said, ran.returncode != 0 and re.search(fault.get("error", "^$"), said) is not None
    first = json.loads(ran.stdout)["first_divergence"]
    said = f"launch {first['launch']} {first['stage']}: {re.sub(shorten, '', first['what'])}"
    if "written_by" in first:
        said += "; written by " + re.sub(shorten, "", first["written_by"])
    if "error" in fault:
        return said, re.search(fault["error"], said) is not None
    return said, re.fullmatch(fault["first"], first["stage"]) is not None and re.search(fault.get("by", NAMED), said) is not None


def main(build, out, names):
    escaped = 0
    for fault in load():
        if names and fault["name"] not in names:
            continue
        said, caught = try_fault(fault, os.path.abspath(build), os.path.abspath(out))
        verdict = "caught" if caught else "ESCAPED"
        escaped += not caught
        print(f"{verdict:<8} {fault['name']:<30} {fault['file']:<26} {said}", flush=True)
    sys.exit(1 if escaped else 0)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
