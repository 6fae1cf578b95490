#!/usr/bin/env bash
# install.sh CMAKE BUILD_FOLDER: what `cmake --install` makes may be moved, and verifies from anywhere: programs start each
# other, golden files are found, the manual page and the completions are there. Without golden files it says how to name
# them before it does any work.
set -euo pipefail
cmake=$1 build=$2
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$cmake" --install "$build" --prefix "$out/first" >"$out/log" 2>&1 || { tail -n 20 "$out/log"; exit 1; }
mv "$out/first" "$out/moved"
cd /
scotty=$out/moved/bin/scotty

fail() { printf '%s\n' "$@"; exit 1; }
quick=(--size 16x12 --spp 1 --bounces 1 --light-samples 1 --width 8)
"$scotty" verify furnace "${quick[@]}" --no-golden >"$out/said" 2>&1 || fail "a moved copy fails:" "$(cat "$out/said")"
"$scotty" verify furnace --only-golden >"$out/said" 2>&1 || fail "its golden files are not found:" "$(cat "$out/said")"
if [[ -x $out/moved/bin/scotty-checked ]]; then
    "$scotty" verify furnace "${quick[@]}" --no-oracles --check >"$out/said" 2>&1 || fail "--check fails:" "$(cat "$out/said")"
fi
grep -q '^\.TH SCOTTY 1' "$out/moved/share/man/man1/scotty.1" || fail "no manual page"
bash -n "$out/moved/share/bash-completion/completions/scotty" || fail "the completions of bash are no script"
[[ -s $out/moved/share/zsh/site-functions/_scotty && -s $out/moved/share/fish/vendor_completions.d/scotty.fish ]] ||
    fail "completions of zsh or fish are missing"

rm -r "$out/moved/share/cuda-scotty"
code=0
"$scotty" verify furnace >"$out/said" 2>&1 || code=$?
[[ $code == 2 ]] && grep -q -- --golden "$out/said" || fail "without golden files: expected exit code 2, found $code:" "$(cat "$out/said")"
