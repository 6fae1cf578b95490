#!/usr/bin/env bash
# loop.sh BUILD_FOLDER [FILE...]: how long somebody waits who edits a kernel.
#
# In a copy of the tree, with a build folder of its own, a function with a fresh name is appended to a header, so that no
# compiler cache has the answer; then the programs are built and `scotty verify` runs. By default the headers are, of the
# kernels of emulation/, those of gpu/ and the numerics of reference/, the ones that most other files include. For kernels the
# time to the first failure is measured as well: a fault of verify/mutants/registry.json is planted in the copy (always on), and
# `verify --fail-fast` runs until it has printed it. The last line has the worst of each.
set -euo pipefail
build=$1
shift
top=$(cd "$(dirname "$0")/../.." && pwd)
copy=$top/build/loop

say() { printf '%s\n' "$*" >&2; }
now() { date +%s.%N; }
since() { echo "$1 $(now)" | awk '{ printf "%.1f", $2 - $1 }'; }

# The header of these folders that most sources and headers include.
most_included() {
    (cd "$top" && grep -rhoE "^#include \"($1)/[^\"]+\.h\"" emulation gpu reference scenes verify) |
        sort | uniq -c | sort -rn | sed -n '1s/.*"\(.*\)"/\1/p'
}

# What is built from, newer files only, so that the copy's build folder stays of use.
refresh() {
    mkdir -p "$copy"
    (cd "$top" && tar -cf - --exclude=./build --exclude=./.git .) | tar -xf - -C "$copy" --keep-newer-files 2>/dev/null || true
}
restore() { cp -p "$top/$1" "$copy/$1" && touch "$copy/$1"; }
compile() { ninja -C "$copy/build/loop" scotty >"$copy/ninja.log" 2>&1 || { tail -n 30 "$copy/ninja.log" >&2; exit 70; }; }

quick=()
if "$build/bin/scotty" verify --help | grep -q -- '--quick'; then quick=(--quick); fi
files=("$@")
if ((${#files[@]} == 0)); then
    files=("$(most_included 'emulation/(kernels|device)')" "$(most_included 'gpu/kernels')"
        "$(most_included 'reference/numerics')")
fi

refresh
say "loop: building a copy of the tree in build/loop, once"
cmake -S "$copy" -B "$copy/build/loop" -G Ninja -D CMAKE_BUILD_TYPE=Release -D SCOTTY_UNITY=ON -D SCOTTY_TESTS=OFF \
    >"$copy/cmake.log" 2>&1 || { tail -n 20 "$copy/cmake.log" >&2; exit 70; }
compile

printf '%-34s %8s %8s %8s %8s %14s\n' 'edit of' build verify verdict allowed 'first failure'
worst_verdict=0 worst_failure=0
for file in "${files[@]}"; do
    options=() allowed=90 fault='' # the fault of a tier whose kernels this is
    case $file in
        emulation/*) allowed=30 fault=block_one_short ;;
        gpu/*) options=(--backend simt) allowed=60 fault=wrong_child ;;
    esac
    begin=$(now)
    echo "inline int loop_probe_$(date +%s%N)() { return 0; }" >>"$copy/$file"
    compile
    built=$(since "$begin")
    code=0
    "$copy/build/loop/bin/scotty" verify "${quick[@]}" "${options[@]}" --golden "$top/golden" >"$copy/verdict.txt" 2>&1 || code=$?
    verdict=$(since "$begin")
    ((code == 0)) || { tail -n 20 "$copy/verdict.txt" >&2; say "loop: the unchanged renderer fails"; exit 1; }
    restore "$file"

    failure=-
    if [[ -n $fault ]]; then
        planted=$(python3 -c 'import json, sys
print(next(f["file"] for f in json.load(open(sys.argv[1]))["faults"] if f["name"] == sys.argv[2]))' \
            "$top/verify/mutants/registry.json" "$fault")
        begin=$(now)
        python3 "$top/verify/mutants/generate.py" "$copy" --alone "$fault" --top "$top"
        echo "inline int loop_probe_$(date +%s%N)() { return 0; }" >>"$copy/$planted"
        compile
        code=0
        "$copy/build/loop/bin/scotty" verify "${quick[@]}" "${options[@]}" --golden "$top/golden" --fail-fast \
            >"$copy/verdict.txt" 2>&1 || code=$?
        failure=$(since "$begin")
        ((code == 1)) || { tail -n 20 "$copy/verdict.txt" >&2; say "loop: $fault was not found"; exit 1; }
        restore "$planted"
    fi
    printf '%-34s %8s %8s %8s %8s %14s\n' "$file" "$built" "$(awk "BEGIN { printf \"%.1f\", $verdict - $built }")" "$verdict" \
        "$allowed" "$failure"
    worst_verdict=$(awk "BEGIN { print ($verdict > $worst_verdict) ? $verdict : $worst_verdict }")
    [[ $failure == - ]] || worst_failure=$(awk "BEGIN { print ($failure > $worst_failure) ? $failure : $worst_failure }")
done
echo "seconds on $(nproc) cores; the worst: $worst_verdict to the verdict, $worst_failure to the first failure"
