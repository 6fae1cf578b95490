"""A copy of the project with faults in it, and its build: what does not compile is left out, and counted."""
import os
import re
import shutil
import subprocess

from emit import Emitter, at_error, can_be_written
from listing import Reader

HERE = os.path.dirname(os.path.abspath(__file__))
ERROR = re.compile(r"^(?P<path>[^\s:][^:\n]*):(?P<line>\d+):(?P<column>\d+):\s+(?P<what>error:|fatal error:|required |in )",
                   re.M)


def write_if_new(path, data):
    if os.path.exists(path):
        with open(path, "rb") as file:
            if file.read() == data:
                return
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + ".unfinished", "wb") as file:
        file.write(data)
    os.replace(path + ".unfinished", path)


class Tree:
    def __init__(self, top, folder):
        self.top, self.source, self.build = top, os.path.join(folder, "source"), os.path.join(folder, "build")
        self.texts = {}  # path -> (text, ranges)

    def copy_project(self):
        """All files that git knows, so that tests find what they read."""
        listed = subprocess.run(["git", "-C", self.top, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                                check=True, capture_output=True).stdout.decode()
        for path in listed.split("\0"):
            original, copied = os.path.join(self.top, path), os.path.join(self.source, path)
            if not path or not os.path.isfile(original) or path in self.texts:
                continue
            if not os.path.exists(copied) or os.stat(copied).st_mtime < os.stat(original).st_mtime:
                os.makedirs(os.path.dirname(copied), exist_ok=True)
                shutil.copyfile(original, copied)
                shutil.copymode(original, copied)

    def plant(self, faults):
        """Writes the files that have faults. Returns the numbers of those that cannot be written."""
        read, files = Reader(self.top), {}
        bad = [f["number"] for f in faults if not can_be_written(f)]
        for fault in faults:
            if fault["number"] not in bad:
                files.setdefault(fault["path"], []).append(fault)
        for path, here in files.items():
            emitter = Emitter(read(path), here)
            text = emitter.run()
            bad += emitter.left_out
            self.texts[path] = (text, emitter.ranges)
            write_if_new(os.path.join(self.source, path), text)
        with open(os.path.join(HERE, "made.h"), "rb") as file:
            write_if_new(os.path.join(self.source, "made.h"), file.read())
        return bad

    def configure(self):
        """No optimisation that takes long, no CUDA, no warnings: they are the original's."""
        subprocess.run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Made",
                        "-DCMAKE_CXX_FLAGS_MADE=-O1 -DNDEBUG -w -include " + self.source + "/made.h",
                        "-DCMAKE_CUDA_COMPILER=NOTFOUND", "-DSCOTTY_UNITY=ON", "-DSCOTTY_LINT=OFF"],
                       check=True, stdout=subprocess.DEVNULL)

    def compile(self, targets, jobs):
        """True, or the numbers of the faults that do not compile. A failure that is not a fault's raises."""
        ran = subprocess.run(["ninja", "-C", self.build, "-k", "0", "-j", str(jobs), *targets], capture_output=True, text=True,
                             check=False)
        if ran.returncode == 0:
            return True
        bad = self.guilty(ran.stdout)
        if not bad:
            raise SystemExit("the copy does not build:\n" + ran.stdout[-6000:])
        return bad

    def guilty(self, log):
        bad, context = set(), []
        for match in ERROR.finditer(log):
            path = os.path.normpath(os.path.join(self.build, match["path"]))
            path = os.path.relpath(path, self.source)
            place = (path, int(match["line"]), int(match["column"]))
            if "error" not in match["what"]:
                context.append(place)  # of the error that follows, where that is in a header of somebody else
                continue
            # The nearest place that is ours.
            for place in [place] + context[::-1]:
                found = at_error(*self.texts[place[0]], *place[1:]) if place[0] in self.texts else []
                if found:
                    bad.update(found)
                    break
            context = []
        return bad
