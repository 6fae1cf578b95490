"""readme_example.py README SCOTTY: the command of "A first failure, explained" prints what stands below it.

Blanks do not count, as the README breaks lines; "..." stands for anything.
"""
import re
import subprocess
import sys

readme, scotty = sys.argv[1:]
with open(readme, encoding="utf-8") as file:
    section = file.read().split("## A first failure, explained")[1].split("\n## ")[0]
command = re.search(r"```sh\n\./run (.*)\n```", section).group(1)
shown = re.search(r"```text\n(.*?)```", section, re.S).group(1)
ran = subprocess.run([scotty, *command.split()], capture_output=True, text=True, check=False)
if ran.returncode != 1:
    sys.exit(f"scotty {command}: expected exit code 1, found {ran.returncode}: {ran.stderr}")
said = "".join(ran.stdout.split())
at = 0
for piece in shown.split("..."):
    words = "".join(piece.split())
    found = said.find(words, at)
    if found < 0:
        sys.exit(f"the README says\n{piece}\nwhich is not, in this order, in what scotty {command} prints:\n{ran.stdout}")
    at = found + len(words)
