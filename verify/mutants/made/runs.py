"""Runs of programs that have faults: which of them execute a fault, and what they say with it switched on."""
import itertools
import json
import os
import resource
import signal
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass

MOST = 1 << 17  # made.h


@dataclass
class Outcome:
    """`kind`: passed, failed (the program says so), crashed (a signal, or an exit code that is no verdict), timed-out."""
    kind: str
    seconds: float
    output: str


WORKERS = itertools.count()
WORKER = threading.local()


def two_cores():
    """This worker's share of the processors: a verdict's time is stated for two cores, and of many runs at once none is to
    start threads for all cores."""
    cores = sorted(os.sched_getaffinity(0))
    if not hasattr(WORKER, "number"):
        WORKER.number = next(WORKERS)
    first = 2 * WORKER.number % len(cores)
    return {cores[first], cores[(first + 1) % len(cores)]}


IDLE = 30.0  # seconds without any work, after which a run waits for something that never comes


def ticks_of(group):
    """Processor time that the processes of a group have used."""
    ticks = 0
    for process in os.listdir("/proc"):
        try:
            if process.isdigit() and os.getpgid(int(process)) == group:
                with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
                    ticks += sum(map(int, file.read().rpartition(")")[2].split()[11:13]))
        except (OSError, ValueError):
            continue  # it has ended
    return ticks


def wait_for(process):
    """The exit code; None where it does nothing any more."""
    ticks, since = -1, time.monotonic()
    while True:
        try:
            return process.wait(3)
        except subprocess.TimeoutExpired:
            now = ticks_of(process.pid)
        if now != ticks:
            ticks, since = now, time.monotonic()
        elif time.monotonic() - since > IDLE:
            return None


def run(command, folder, limit, fault=0, seen=None):
    """One process and its children, for so many seconds of processor time: a busy machine is no fault. Fault 0: none."""
    environment = dict(os.environ)
    for name, value in (("SCOTTY_MADE", str(fault) if fault else None), ("SCOTTY_MADE_SEEN", seen)):
        environment.pop(name, None)
        if value is not None:
            environment[name] = value
    cores = two_cores()

    def prepare():
        os.sched_setaffinity(0, cores)
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 9))

    start = time.monotonic()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=output,
                                   stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=prepare)
        code = wait_for(process)
        try:  # what it started too
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait()
        output.seek(0, os.SEEK_END)
        output.seek(max(0, output.tell() - 200000))
        text = output.read().decode(errors="replace")
    kind = {None: "timed-out", -signal.SIGXCPU: "timed-out", 0: "passed", 1: "failed"}.get(code, "crashed")
    return Outcome(kind, time.monotonic() - start, text)


@dataclass
class Step:
    """A run that may catch a fault, and what it is without any: the faults that it executes, and its time."""
    name: str
    command: list
    executes: frozenset = frozenset()
    seconds: float = 0.0

    def limit(self):
        """Seconds of processor time; the time of a run without faults was the clock's, on few cores."""
        return 20 + 8 * self.seconds


def measure(step, folder, scratch, longest):
    """Runs a step without faults. A step that fails, or takes more seconds of processor time, is no judge: None."""
    with tempfile.NamedTemporaryFile(dir=scratch) as seen:
        outcome = run(step.command, folder, longest, seen=seen.name)
        if outcome.kind != "passed":
            return None
        with open(seen.name, "rb") as file:
            executed = frozenset(number for number, byte in enumerate(file.read()) if byte)
    return Step(step.name, step.command, executed, outcome.seconds)


def save_steps(path, steps):
    with open(path, "w", encoding="utf-8") as file:
        json.dump([[s.name, s.command, sorted(s.executes), s.seconds] for s in steps], file)


def load_steps(path):
    with open(path, encoding="utf-8") as file:
        return [Step(name, command, frozenset(executes), seconds) for name, command, executes, seconds in json.load(file)]


def verdict_steps(scotty):
    """What judges a fault, cheap first; the text of gpu/ by runs of its own."""
    common = [scotty, "verify", "--fail-fast", "--patience", "30"]
    simt = common + ["--quick", "--backend", "simt"]
    return {"emulator": [Step("quick", common + ["--quick"]), Step("golden", common + ["--only-golden"]),
                         Step("default", common)],
            "simt": [Step("simt-two-scenes", simt + ["cornell", "veil"]), Step("simt-check", simt + ["--check", "cornell", "veil"]),
                     Step("simt-quick", simt)]}


def test_steps(build):
    """The tests of the build as CTest knows them, one step each, without those of the source text."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True, check=True)
    for test in json.loads(listed.stdout)["tests"]:
        command = test.get("command")
        if command and os.path.exists(command[0]) and os.path.basename(command[0]).startswith("test_"):
            yield Step(test["name"], command)


def joined(steps, most=200):
    """Catch2 programs run many cases at once: (command, names) of a program's cases, cheap ones first."""
    programs = {}
    for step in sorted(steps, key=lambda s: s.seconds):
        programs.setdefault(step.command[0], []).append(step)
    for program, cases in sorted(programs.items(), key=lambda p: sum(s.seconds for s in p[1])):
        for i in range(0, len(cases), most):
            part = cases[i:i + most]
            yield Step(os.path.basename(program), [program, ",".join(s.command[1] for s in part), "--abort"],
                       seconds=sum(s.seconds for s in part))


def first_failed_case(output):
    """Catch2's own words: the name stands between two rules."""
    lines = output.splitlines()
    for i, line in enumerate(lines[:-1]):
        if line.startswith("-----") and i + 1 < len(lines):
            return lines[i + 1].strip()
    return ""
