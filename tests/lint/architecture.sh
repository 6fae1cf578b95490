# architecture.sh: every file that docs/architecture.md names exists, so that its lists of what a change touches stay
# true.
source "$(dirname "$0")/common.sh"

page=docs/architecture.md
mapfile -t named < <(grep -oE '`(reference|emulation|gpu|verify|scenes|golden|tests|docs)/[A-Za-z0-9_./-]*`' "$page" | tr -d '\`' | sort -u)
((${#named[@]})) || { echo "$page names no file: this check would check nothing"; exit 1; }
missing=()
for path in "${named[@]}"; do [[ -e $path ]] || missing+=("$path"); done
if ((${#missing[@]})); then
    echo "$page names files that are not there; move the names with the files:"
    printf '%s\n' "${missing[@]}"
    exit 1
fi
echo "${#named[@]} files of $page are there"
