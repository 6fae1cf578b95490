"""corpus.py SCOTTY FOLDER [--table PAGE | --write PAGE] [NAME...]: every labelled kernel of the corpus gets its label.

Each file of FOLDER is a class of faults. A comment `// [kind] what is wrong` begins a section, and labels what follows up to the
next such comment: `[data race]` and other kinds of findings are expected in it, `[clean]` wants none, `[main]` is not judged. Each
program runs under four orders. With --table the page must hold the table that comes out, between the lines that mark it; --write
puts it there.
"""
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

SCHEDULES = 4
BEGIN, END = "<!-- corpus begins -->", "<!-- corpus ends -->"


class Section:
    def __init__(self, kind, what, first):
        self.kind, self.what, self.first, self.last, self.found = kind, what, first, 10**9, set()


def sections(path):
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        match = re.fullmatch(r"// \[(.+?)\] ?(.*)", line)
        if match:
            if found:
                found[-1].last = number - 1
            found.append(Section(match.group(1), match.group(2), number))
    return lines[0].removeprefix("// "), found


def lines_of(finding, name):
    for side in ("one", "other"):
        place = finding.get(side, {})
        for line in [place.get("line", "")] + place.get("called_from", []):
            match = re.search(re.escape(name) + r":(\d+)", line)
            if match:
                yield int(match.group(1))


def check(scotty, path):
    title, found = sections(path)
    ran = subprocess.run([scotty, "check", os.path.basename(path), "--json", "--schedules", str(SCHEDULES)],
                         cwd=os.path.dirname(path), capture_output=True, text=True, check=False)
    problems = []
    if ran.returncode not in (0, 1):
        return title, found, [f"exit code {ran.returncode}: {ran.stderr[-1500:]}"], 0
    report = json.loads(ran.stdout)
    name = os.path.basename(path)
    for finding in report["findings"]:
        here = [s for line in lines_of(finding, name) for s in found if s.first <= line <= s.last]
        if not here or here[0].kind == "main":
            problems.append(f"a finding in no section: {finding}")
        else:
            here[0].found.add(finding["kind"])
    for section in found:
        where = f"{name}:{section.first}: {section.what}"
        if section.kind == "main":
            continue
        if section.kind == "clean":
            if section.found:
                problems.append(f"{where}: clean, but found {sorted(section.found)}")
        elif section.kind not in section.found:
            problems.append(f"{where}: expected {section.kind}, found {sorted(section.found) or 'nothing'}")
    return title, found, problems, report["seconds"]


def main():
    scotty, folder, *rest = sys.argv[1:]
    scotty = os.path.abspath(scotty)
    mode, page = (rest[0], rest[1]) if rest and rest[0].startswith("--") else (None, None)
    wanted = rest[2:] if mode else rest
    paths = sorted(os.path.join(os.path.abspath(folder), n) for n in os.listdir(folder) if n.endswith(".cu"))
    if wanted:
        paths = [p for p in paths if os.path.basename(p) in wanted or os.path.basename(p)[:-3] in wanted]
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda path: check(scotty, path), paths))
    rows, all_problems = [], []
    totals = [0, 0, 0, 0]
    for path, (title, found, problems, _) in zip(paths, results):
        all_problems += problems
        faulty = [s for s in found if s.kind not in ("clean", "main")]
        clean = [s for s in found if s.kind == "clean"]
        caught = sum(s.kind in s.found for s in faulty)
        alarms = sum(bool(s.found) for s in clean)
        for i, value in enumerate((len(faulty), caught, len(clean), alarms)):
            totals[i] += value
        rows.append(f"| [{os.path.basename(path)[:-3]}](../tests/verify/kernel_check/corpus/{os.path.basename(path)}) | {title} | "
                    f"{caught} of {len(faulty)} | {alarms} of {len(clean)} |")
    table = "\n".join(["| class | what goes wrong | found | false alarms |", "|---|---|---|---|"] + rows +
                      [f"| **{len(rows)} classes** | **{totals[0] + totals[2]} kernels and programs** | "
                       f"**{totals[1]} of {totals[0]}** | **{totals[3]} of {totals[2]}** |"])
    for problem in all_problems:
        print(problem)
    print(table)
    if mode:
        with open(page, encoding="utf-8") as file:
            text = file.read()
        before, rest_of_page = text.split(BEGIN)
        held, after = rest_of_page.split(END)
        if mode == "--write":
            with open(page, "w", encoding="utf-8") as file:
                file.write(f"{before}{BEGIN}\n{table}\n{END}{after}")
        elif held.strip() != table:
            all_problems.append("x")
            print(f"{page} holds another table: corpus.py ... --write writes this one")
    return 1 if all_problems else 0


if __name__ == "__main__":
    sys.exit(main())
