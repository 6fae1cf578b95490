"""The project's translation units as libclang sees them, with the flags of a configured build folder."""
import json
import os
import re
import shlex

from clang import cindex

# Rooms whose code gets faults; what they are judged by (reference/truth), the checker's own machinery, pages and the
# programs around the judgement stay as they are.
ROOMS = ("emulation/device", "emulation/kernels", "emulation/host", "emulation/execution", "gpu/kernels", "gpu/host",
         "reference/contract", "reference/numerics", "reference/bvh", "scenes", "verify/base", "verify/capture",
         "verify/invariants", "verify/oracles", "verify/diff", "verify/schedules", "verify/images", "verify/golden",
         "verify/sweep")
TARGETS = re.compile(r"/scotty_(contract|bvh|truth|scenes|execution|emulator|simt|verify_base|capture|invariants|oracles|diff|"
                     r"schedules|images|golden|sweep)\.dir/")
GNU_ONLY = re.compile(r"-fno-trapping-math|-Werror.*|-W.*")


class Unit:
    """A parsed translation unit: its AST, and where macros were expanded in each file of the project."""

    def __init__(self, top, command):
        words = shlex.split(command["command"])
        words = words[next(i for i, word in enumerate(words) if word.startswith("-")):]
        source = command["file"]
        flags, skip = [], False
        for word in words:
            if skip or word in (source, "-c") or GNU_ONLY.fullmatch(word):
                skip = False
            elif word in ("-o", "-MF", "-MT"):
                skip = True
            else:
                flags.append(word)
        self.top = top + "/"
        self.source = source
        self.tree = cindex.Index.create().parse(
            source, args=flags + ["-w", "-ferror-limit=0", "-I" + command["directory"]],
            options=cindex.TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD)
        errors = [d for d in self.tree.diagnostics if d.severity >= cindex.Diagnostic.Error]
        self.errors = [f"{d.location.file}:{d.location.line}: {d.spelling}" for d in errors]
        self.macros = {}  # path -> [(begin, end)]
        for cursor in self.tree.cursor.get_children():
            if cursor.kind == cindex.CursorKind.MACRO_INSTANTIATION:
                path = self.path_of(cursor)
                if path:
                    self.macros.setdefault(path, []).append((cursor.extent.start.offset, cursor.extent.end.offset))

    def path_of(self, cursor):
        """Path from the project's root, or None: it is somebody else's, or no file."""
        file = cursor.location.file
        if file is None or not file.name.startswith(self.top):
            return None
        return os.path.normpath(file.name[len(self.top):])


def commands_of(build):
    """The compile commands of the rooms' units."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = json.load(file)
    return [c for c in commands if TARGETS.search(c["command"]) and "-fsanitize" not in c["command"]]


def has_faults(path):
    return path is not None and os.path.dirname(path) in ROOMS
