"""sound_renders.py SCOTTY GOLDEN [--seeds N] [--jobs N] [--seconds S] [--json FILE]: sound
renders against golden images, as a user would hold them: how often does `scotty diff` fail one?

Renders every scene of the folder GOLDEN (SCENE.exr, or SCENE.npy with its variances where there is no image library) at 4, 16, 64 and
256 samples with seeds from 1000 on. Not a test: 11,200 renders take hours on two cores. With --seconds it ends after the
seed in which that time is up. Exit code 1 if more images failed than the rate of 1 in 10,000 allows with probability 0.999.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

RATE = 1e-4


def one(scotty, folder, golden, scene, samples, backend, seed):
    image = os.path.join(folder, f"{scene}-{samples}-{backend}-{seed}.npy")
    parts = [scotty, "render", scene, "--size", "64x64", "--spp", str(samples), "--seed", str(seed), "--backend", backend,
             "--threads", "1", "-q", "-o", image]
    rendered = subprocess.run(parts, capture_output=True, text=True)
    if rendered.returncode:
        return (scene, samples, backend, seed, "error", rendered.stderr[-300:])
    judged = subprocess.run([scotty, "diff", golden, image, "--json"], capture_output=True, text=True)
    verdict = {0: "passed", 1: "failed"}.get(judged.returncode, "error")
    said = "" if verdict == "passed" else judged.stdout[-2000:] + judged.stderr[-300:]
    for end in (".npy", ".variance.npy", ".json"):
        if os.path.exists(name := image[:-4] + end):
            os.remove(name)
    return (scene, samples, backend, seed, verdict, said)


def allowed(images):
    """The most failures that so many images may have: more of them have a probability below 0.001."""
    mean, term, total, most = images * RATE, math.exp(-images * RATE), 0.0, 0
    while total + term < 0.999:
        total += term
        most += 1
        term *= mean / most
    return most


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scotty")
    parser.add_argument("golden")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("--backends", default="emulator,embree")
    parser.add_argument("--scenes", help="of GOLDEN, with commas between them; all by default")
    parser.add_argument("--samples", default="4,16,64,256")
    parser.add_argument("--json")
    options = parser.parse_args()
    files = {}
    for name in sorted(os.listdir(options.golden), reverse=True):  # npy first, where there are both
        if name.endswith((".exr", ".npy")) and not name.endswith(".variance.npy"):
            files.setdefault(name[:-4], os.path.join(options.golden, name))
    scenes = options.scenes.split(",") if options.scenes else sorted(files)
    backends = options.backends.split(",")
    samples_of_all = [int(word) for word in options.samples.split(",")]
    start, results, seeds = time.monotonic(), [], 0
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        step = max(1, options.jobs // (len(scenes) * len(backends)))  # several seeds at once keep all cores busy
        while seeds < options.seeds and time.monotonic() - start < options.seconds:
            some = range(seeds, min(seeds + step, options.seeds))
            tasks = [pool.submit(one, options.scotty, folder, files[scene], scene, samples, backend, 1000 + seed)
                     for samples in reversed(samples_of_all) for seed in some for scene in scenes for backend in backends]
            results += [task.result() for task in tasks]
            seeds += len(some)
            print(f"{len(results)} images, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
    counts = Counter((scene, samples, backend, verdict) for scene, samples, backend, _, verdict, _ in results)
    failed = [result for result in results if result[4] != "passed"]
    print(f"{'scene':<10} {'samples':>8} " + " ".join(f"{backend + ' failed':>16}" for backend in backends) + f"   of {seeds}")
    for scene in scenes:
        for samples in samples_of_all:
            print(f"{scene:<10} {samples:>8} " + " ".join(
                f"{seeds - counts[scene, samples, backend, 'passed']:>16}" for backend in backends))
    for scene, samples, backend, seed, verdict, said in failed:
        print(f"{verdict}: {scene}, {samples} samples, {backend}, --seed {seed}")
    most = allowed(len(results))
    print(f"{len(failed)} of {len(results)} images failed; at most {most} are allowed at 1 in {1 / RATE:.0f}")
    if options.json:
        with open(options.json, "w") as out:
            json.dump({"images": len(results), "failed": [list(result) for result in failed], "seeds": seeds}, out, indent=1)
    return 1 if len(failed) > most else 0


if __name__ == "__main__":
    sys.exit(main())
