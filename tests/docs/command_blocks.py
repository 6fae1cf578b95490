"""command_blocks.py TOP SCOTTY [PAGE...]: the command blocks of README.md and docs/*.md do what they say.

Every line of every fenced `sh` block runs, page by page, in a folder of its own that has the project's golden files and programs;
the lines of a page find what earlier ones have left. A word in brackets where a line's comment begins, or alone on the first line
of a block, says what that line or block needs which is not here, and it is not run: # [device], # [minutes]. Both are counted.
`./run` is a stand-in that starts scotty, and gives `verify` the smaller of its two budgets. Exit code 1, a verdict, is a
success of commands that show a fault or a difference; any other code but 0 fails.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

NEEDS = {"device", "minutes", "your files", "endless", "viewer", "compilers", "approval", "build"}
RUN = """#!/bin/sh
case " $* " in
    " verify "*" --quick "* | " verify "*" --plant "*) exec scotty "$@" ;;
    " verify "*) exec scotty "$@" --quick ;;
esac
exec scotty "$@"
"""


def blocks(text):
    for match in re.finditer(r"^```sh\n(.*?)^```", text, re.M | re.S):
        yield text[: match.start()].count("\n") + 2, match.group(1).splitlines()


def commands(first, lines):
    """(line number, command, need or None); a line that ends in a backslash goes on in the next."""
    need_of_all = None
    if lines and (match := re.fullmatch(r"# \[(.+?)\].*", lines[0])):
        need_of_all, first, lines = match.group(1), first + 1, lines[1:]
    begin, whole = first, ""
    for number, line in enumerate(lines, first):
        whole += line + "\n"
        if line.endswith("\\"):
            continue
        match = re.search(r"# \[(.+?)\]", whole)
        yield begin, whole.rstrip("\n"), need_of_all or (match.group(1) if match else None)
        begin, whole = number + 1, ""


def may_differ(command):
    return "--plant" in command or re.search(r"\b(diff|queues|check)\b", command) is not None


def run_page(top, scotty, page):
    """Problems, and how many commands were run or not, by need."""
    problems, counts = [], {}
    with open(os.path.join(top, page), encoding="utf-8") as file:
        text = file.read()
        found = [command for block in blocks(text) for command in commands(*block)]
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(os.path.join(top, "golden"), os.path.join(folder, "golden"))
        with open(os.path.join(folder, "run"), "w", encoding="utf-8") as file:
            file.write(RUN)
        os.chmod(os.path.join(folder, "run"), 0o755)
        for name, content in re.findall(r"^```\w+ ([\w.]+)\n(.*?)^```", text, re.M | re.S):  # files that a page shows
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(content)
        environment = dict(os.environ, PATH=f"{os.path.dirname(scotty)}:{os.environ['PATH']}")
        for number, command, need in found:
            if need is not None:
                counts[need] = counts.get(need, 0) + 1
                if need not in NEEDS:
                    problems.append(f"{page}:{number}: [{need}] is none of {', '.join(sorted(NEEDS))}")
                continue
            counts["run"] = counts.get("run", 0) + 1
            ran = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=folder, env=environment, capture_output=True,
                                 text=True, stdin=subprocess.DEVNULL, check=False)
            if ran.returncode != 0 and not (ran.returncode == 1 and may_differ(command)):
                problems.append(f"{page}:{number}: {command}\n  exit code {ran.returncode}: {ran.stderr[-600:]}")
    return problems, counts


def main():
    top, scotty, *pages = sys.argv[1:]
    if not pages:
        pages = ["README.md"] + sorted("docs/" + name for name in os.listdir(os.path.join(top, "docs")) if name.endswith(".md"))
    problems, counts = [], {}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for of_page, counted in pool.map(lambda page: run_page(top, os.path.abspath(scotty), page), pages):
            problems += of_page
            for need, count in counted.items():
                counts[need] = counts.get(need, 0) + count
    run = counts.pop("run", 0)
    print(f"{run} commands run; not run: " + (", ".join(f"{counts[need]} [{need}]" for need in sorted(counts)) or "none"))
    if run == 0:
        problems.append("no command was run: this checks nothing")
    if problems:
        sys.exit("\n".join(problems))


main()
