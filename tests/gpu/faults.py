#!/usr/bin/env python3
"""Planted faults: does the diff catch a broken CUDA kernel, and name the right launch first?

  faults.py build NVCC BUILD OUT [NAME...]   one scotty-gpu a fault, from the kernels' text with one change
  faults.py run OUT SCOTTY                   on a machine with a GPU: captures, diffs, prints a table; 1 if one escapes

The faults are those of verify/mutants/registry.json that have a `gpu`: there `units` are the sources of gpu/ that have it,
`first` is the launch that the diff has to name first, as a regular expression.
"""
import json
import os
import re
import subprocess
import sys

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXACT = "--fmad=false --ftz=false --prec-div=true --prec-sqrt=true -diag-suppress=20012 -Xcompiler=-ffp-contract=off"

# What every run shares; a fault may add to it.
RUN = "spheres --size 45x37 --spp 2 --bounces 1 --light-samples 2 --width 8 --early-out level"


def capture_folder(fault):
    return re.sub(r"[^a-z0-9]+", "_", "emulator" + fault.get("run", ""))


def load():
    with open(os.path.join(TOP, "verify/mutants/registry.json"), encoding="utf-8") as file:
        return [{**fault["gpu"], "name": fault["name"], "file": fault["file"]}
                for fault in json.load(file)["faults"] if "gpu" in fault]


def plant(fault, folder):
    """The faulty file, in a tree that the compiler looks into first."""
    generate = os.path.join(TOP, "verify/mutants/generate.py")
    subprocess.run([sys.executable, generate, folder, "--alone", fault["name"]], check=True)


def build(nvcc, build_folder, out, names):
    for fault in load():
        if names and fault["name"] not in names:
            continue
        folder = os.path.join(out, fault["name"])
        plant(fault, folder)
        objects = []
        for unit in fault["units"]:
            target = os.path.join(folder, unit + ".o")
            subprocess.run(f"{nvcc} -O3 -arch=sm_90 -std=c++20 {EXACT} -I{folder} -I{TOP} -c {TOP}/gpu/host/{unit}.cu -o {target}",
                           shell=True, check=True)
            objects.append(target)
        libraries = " ".join(os.path.join(build_folder, path) for path in (
            "verify/libscotty_capture.a", "gpu/libscotty_gpu.a", "gpu/libscotty_gpu_fast.a",
            "reference/libscotty_contract.a", "reference/libscotty_base.a"))
        main = os.path.join(build_folder, "verify/CMakeFiles/scotty_gpu_program.dir/scotty_gpu/main.cpp.o")
        subprocess.run(f"{nvcc} -std=c++20 {main} {' '.join(objects)} {libraries} -lxxhash -o {folder}/scotty-gpu"
                       " -Xlinker -s -Xcompiler -static-libstdc++ -Xcompiler -static-libgcc",
                       shell=True, check=True)
        print(fault["name"], "built", flush=True)


def run(out, scotty):
    escaped = 0
    for fault in load():
        program = os.path.join(out, fault["name"], "scotty-gpu")
        if not os.path.exists(program):
            continue
        expected = os.path.join(out, capture_folder(fault))
        if not os.path.exists(expected):
            subprocess.run([scotty, "capture", *RUN.split(), *fault.get("run", "--rays-per-block 64").split(), "-o", expected], check=True)
        found = os.path.join(out, fault["name"], "capture")
        ran = subprocess.run([program, "run", os.path.join(expected, "input"), "-o", found],
                             capture_output=True, text=True, check=False)
        diff = subprocess.run([scotty, "diff", expected, found, "--json"], capture_output=True, text=True, check=False)
        if diff.stdout:
            divergence = json.loads(diff.stdout)["first_divergence"] or {"stage": "nothing differs", "what": ""}
            first = f"launch {divergence.get('launch')} {divergence['stage']}: {divergence['what']}"
            caught = diff.returncode == 1 and re.fullmatch(fault["first"], divergence["stage"]) is not None
        else:
            first, caught = ran.stderr.strip() + diff.stderr.strip(), False
        escaped += not caught
        print(f"{'caught' if caught else 'ESCAPED':<8} {fault['name']:<28} {fault['file']:<28} {first}", flush=True)
    sys.exit(1 if escaped else 0)


if __name__ == "__main__":
    if sys.argv[1:2] == ["build"] and len(sys.argv) >= 5:
        build(sys.argv[2], sys.argv[3], sys.argv[4], sys.argv[5:])
    elif sys.argv[1:2] == ["run"] and len(sys.argv) == 4:
        run(sys.argv[2], sys.argv[3])
    else:
        sys.exit(__doc__)
