#!/usr/bin/env bash
# loop.sh BUILD_FOLDER [FILE...]: how long somebody waits who edits a kernel.
#
# In a copy of the tree, with a build folder of its own, a function with a fresh name is appended to a header, so that no
# compiler cache has the answer; then the programs are built and `scotty verify` runs. By default the headers are, of the
# kernels of emulation/, those of gpu/ and the numerics of reference/, the ones that most other files include. For kernels the
# time to the first failure is measured as well: a fault of verify/mutants/registry.json is planted in the copy (always on), and
# `verify --fail-fast` runs until it has printed it. The last line has the worst of each. Beside each time stands, in brackets, the
# processor time by the number of cores: what the same takes on a machine with nothing else to do, if all cores are busy.
set -euo pipefail
build=$1
shift
top=$(cd "$(dirname "$0")/../.." && pwd)
copy=$top/build/loop

say() { printf '%s\n' "$*" >&2; }
# timed COMMAND...: sets `wall` and `busy`, the processor seconds by the number of cores; returns the command's exit code.
timed() {
    local TIMEFORMAT='%R %U %S' figures code=0
    figures=$( { time "$@" 1>&2; } 2>&1 1>/dev/null) || code=$?
    read -r wall busy < <(tail -n 1 <<<"$figures" | awk -v cores="$(nproc)" '{ printf "%.1f %.1f\n", $1, ($2 + $3) / cores }')
    return "$code"
}
calc() { awk "BEGIN { printf \"%.1f\", $1 }"; }
option_of() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; } # so that a compiler cache answers for the rest

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
verify() { "$copy/build/loop/bin/scotty" verify --quick "$@" --golden "$top/golden" >"$copy/verdict.txt" 2>&1; }
build_and_verify() { compile && verify "$@"; }
touched=()
trap 'for file in "${touched[@]}"; do restore "$file"; done' EXIT # refresh leaves files that are newer
append_function() { touched+=("$1") && echo "inline int loop_probe_$(date +%s%N)() { return 0; }" >>"$copy/$1"; }

files=("$@")
if ((${#files[@]} == 0)); then
    files=("$(most_included 'emulation/(kernels|device)')" "$(most_included 'gpu/kernels')"
        "$(most_included 'reference/numerics')")
fi

refresh
say "loop: building a copy of the tree in build/loop, once"
cmake -S "$copy" -B "$copy/build/loop" -G Ninja -D CMAKE_BUILD_TYPE="$(option_of CMAKE_BUILD_TYPE)" -D SCOTTY_UNITY=ON \
    -D SCOTTY_TESTS=OFF -D SCOTTY_WERROR="$(option_of SCOTTY_WERROR)" >"$copy/cmake.log" 2>&1 ||
    { tail -n 20 "$copy/cmake.log" >&2; exit 70; }
compile

printf '%-36s %14s %14s %8s %16s %8s\n' 'edit of' build verdict allowed 'first failure' allowed
worst_verdict=0 worst_failure=0
for file in "${files[@]}"; do
    options=() allowed=90 soon=- fault='' # the fault of a tier whose kernels this is
    case $file in
        emulation/*) allowed=30 soon=20 fault=block_one_short ;;
        gpu/*) options=(--backend simt) allowed=60 soon=25 fault=wrong_child ;;
    esac
    append_function "$file"
    timed compile
    built=$wall built_busy=$busy
    timed verify "${options[@]}" || { tail -n 20 "$copy/verdict.txt" >&2; say "loop: the unchanged renderer fails"; exit 1; }
    verdict=$(calc "$built + $wall") verdict_busy=$(calc "$built_busy + $busy")
    restore "$file"

    failure=-
    if [[ -n $fault ]]; then
        planted=$(python3 -c 'import json, sys
print(next(f["file"] for f in json.load(open(sys.argv[1]))["faults"] if f["name"] == sys.argv[2]))' \
            "$top/verify/mutants/registry.json" "$fault")
        python3 "$top/verify/mutants/generate.py" "$copy" --alone "$fault" --top "$top"
        append_function "$planted"
        code=0
        timed build_and_verify "${options[@]}" --fail-fast || code=$?
        ((code == 1)) || { tail -n 20 "$copy/verdict.txt" >&2; say "loop: $fault was not found"; exit 1; }
        failure="$wall ($busy)"
        worst_failure=$(calc "($busy > $worst_failure) ? $busy : $worst_failure")
        restore "$planted"
    fi
    printf '%-36s %14s %14s %8s %16s %8s\n' "$file" "$built ($built_busy)" "$verdict ($verdict_busy)" "$allowed" "$failure" "$soon"
    worst_verdict=$(calc "($verdict_busy > $worst_verdict) ? $verdict_busy : $worst_verdict")
done
echo "seconds on $(nproc) cores; the worst, by processor time: $worst_verdict to the verdict, $worst_failure to the first failure"
