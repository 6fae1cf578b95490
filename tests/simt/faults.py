#!/usr/bin/env python3
"""Planted faults in the CUDA text, caught without a GPU, and the right launch, or kernel and threads, named.

  faults.py BUILD OUT [NAME...]   plants each fault of tests/gpu/faults.json and tests/simt/faults.json, builds scotty with
                                  it, captures with --backend simt, diffs; prints a table; 1 if one escapes

A fault is a replacement in one file of gpu/ that has to match once, so that it cannot rot unseen. `first` is the
launch that the diff has to name first, `error` what the executor has to say, `race` what the thread sanitizer has to
say of simt_races, as regular expressions.
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


def build_program(build, folder, units, target, program, archive):
    """The build's own commands for the units and the link, with the faulty tree first and another output."""
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


def try_race(fault, build, folder):
    """Under the thread sanitizer: it need not happen to be seen."""
    program = build_program(build, folder, fault["units"], "simt_races", "simt_races", r" \S*/simt_races\.dir/\S*\.o")
    ran = subprocess.run([program], capture_output=True, text=True, check=False)
    said = next((line for line in ran.stderr.splitlines() if line.startswith("SUMMARY")), "no race")
    said = said.replace(folder + "/", "").replace(TOP + "/", "")
    return said, ran.returncode != 0 and re.search(fault["race"], said) is not None


def try_fault(fault, build, out):
    """What was said first, and whether that is what should have been."""
    folder = os.path.join(out, fault["name"])
    on_gpu.plant(fault, folder)
    if "race" in fault:
        return try_race(fault, build, folder)
    faulty = build_program(build, folder, fault["units"], "scotty_simt", "scotty", r" (\S*libscotty\S*\.a)")
    scotty = os.path.join(build, "bin/scotty")
    expected = os.path.join(out, re.sub(r"[^a-z0-9]+", "_", "emulator " + run_of(fault)))
    what = [*RUN.split(), *run_of(fault).split()]
    if not os.path.exists(expected):
        subprocess.run([scotty, "capture", *what, "-o", expected], check=True, capture_output=True)
    found = os.path.join(folder, "capture")
    subprocess.run(["rm", "-rf", found], check=True)
    ran = subprocess.run([faulty, "capture", *what, "--backend", "simt", "-o", found],
                         capture_output=True, text=True, check=False)
    if "error" in fault or not os.path.exists(found):
        said = (ran.stderr.strip() or "nothing").splitlines()[-1].replace(folder + "/", "").replace(TOP + "/", "")
        return said, ran.returncode != 0 and re.search(fault.get("error", "^$"), said) is not None
    diff = subprocess.run([scotty, "diff", expected, found, "--json"], capture_output=True, text=True, check=False)
    divergence = json.loads(diff.stdout)["first_divergence"] or {"stage": "nothing differs", "what": ""}
    said = f"launch {divergence.get('launch')} {divergence['stage']}: {divergence['what']}"
    return said, re.fullmatch(fault["first"], divergence["stage"]) is not None


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
