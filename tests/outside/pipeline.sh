#!/usr/bin/env bash
# pipeline.sh SCOTTY: another program's pipeline, in the style of the code of 2018, runs without a GPU and writes captures from device
# buffers. Its sound run passes; two faults of that code are named: where, and by the program's own ids.
set -euo pipefail
scotty=$1 source=$(dirname "$0")/pipeline_2018/pipeline.cu
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
fail() { printf '%s\n' "$@"; exit 1; }

"$scotty" check "$source" -- sound "$out/sound" >"$out/said" 2>&1 || fail "its kernels are not sound:" "$(cat "$out/said")"
"$scotty" check "$source" -- overflow "$out/overflow" box "$out/box" >"$out/said" 2>&1 || true # one of them is a race, too

judge() { # FAULT EXIT_CODE: leaves the diff's words in $out/said
    local code=0
    "$scotty" diff "$out/$1" >"$out/said" 2>&1 || code=$?
    [[ $code == "$2" ]] || fail "$1: expected exit code $2, found $code:" "$(cat "$out/said")"
}
says() { grep -qE "$1" "$out/said" || fail "expected '$1' in:" "$(cat "$out/said")"; }

judge sound 0
says 'passed: 4 stages compared'
says 'not judged, because the capture does not hold it: primary_rays'
judge overflow 1
says 'merge_intersections, ray [0-9]+ .*counter of hits is beyond its slots'
judge box 1
says 'level2/intersect, level 2, node [0-9]+ \([0-9]+ in the capture\), block [0-9]+, ray 5[0-9]+ .*missing from the node.s queue'
says 'enters the node.s box at [0-9.]+ and has its closest hit at'
echo "the sound run passes, both faults are named"
