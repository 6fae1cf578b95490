"""All faults of the project, each with a key; a sample of them by a seed."""
import fnmatch
import hashlib
import json
import multiprocessing
import os
from dataclasses import asdict

from places import Walk
from units import Unit, commands_of


class Reader:
    def __init__(self, top):
        self.top, self.files = top, {}

    def __call__(self, path):
        if path not in self.files:
            with open(os.path.join(self.top, path), "rb") as file:
                self.files[path] = file.read()
        return self.files[path]


def faults_of(work):
    """The faults of some units: those of a file come from the first unit that has it."""
    top, commands, say = work
    read, known, found, errors, macros = Reader(top), set(), [], [], 0
    for command in commands:
        unit = Unit(top, command)
        walk = Walk(unit, read)
        new = walk.run(known)
        known |= {fault.path for fault in new}
        found += new
        errors += unit.errors
        macros += walk.in_macros
        if say:
            print(f"{os.path.relpath(unit.source, top)}: {len(new)} faults, {len(unit.errors)} errors", flush=True)
    return found, errors, macros


def keyed(faults):
    """In the order of files and offsets, without duplicates; as dictionaries with keys."""
    places = {(f.path, f.begin, f.end, f.shape, f.operator, f.text): f for f in faults}
    counts, result = {}, []
    for place in sorted(places, key=lambda p: (p[0], p[1], -p[2], p[3:])):
        fault = places[place]
        ordinal = counts[fault.key(0)] = counts.get(fault.key(0), -1) + 1
        result.append({"key": fault.key(ordinal)} | asdict(fault))
    return result


def list_faults(top, build, processes, say=False):
    commands = commands_of(build)
    parts = [(top, commands[i::processes], say) for i in range(processes)]
    with multiprocessing.Pool(processes) as pool:
        answers = pool.map(faults_of, parts, chunksize=1)
    errors = [error for answer in answers for error in answer[1]]
    # A file that several processes saw is taken from the first.
    owner, faults = {}, []
    for number, (found, _, _) in enumerate(answers):
        for fault in found:
            if owner.setdefault(fault.path, number) == number:
                faults.append(fault)
    return {"faults": keyed(faults), "errors": errors, "in_macros": sum(answer[2] for answer in answers)}


def sample(faults, count, seed, files="*"):
    """Uniform, and stable: a fault's rank is a hash of its key, so that an edit elsewhere leaves the others in."""
    rank = {f["key"]: hashlib.sha256(f"{seed}:{f['key']}".encode()).digest() for f in faults}
    chosen = sorted((f for f in faults if fnmatch.fnmatch(f["path"], files)), key=lambda f: rank[f["key"]])
    return sorted(chosen[:count], key=lambda f: (f["path"], f["begin"], -f["end"], f["key"]))


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def save(path, listing):
    with open(path + ".unfinished", "w", encoding="utf-8") as file:
        json.dump(listing, file, indent=0)
    os.replace(path + ".unfinished", path)
