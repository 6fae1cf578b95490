#!/usr/bin/env bash
# kernels.sh CMAKE BUILD_FOLDER SOURCE_FOLDER installed|source: the project in kernels/ builds and passes against what cmake --install
# makes, moved elsewhere; or inside a project that adds this one, with nothing but a C++ compiler.
set -euo pipefail
export CMAKE_GENERATOR=Ninja # make is not everywhere
cmake=$1 build=$2 source=$3 how=$4
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
fail() { printf '%s\n' "$@"; exit 1; }
project=$(dirname "$0")/kernels

if [[ $how == installed ]]; then
    "$cmake" --install "$build" --component kernels --prefix "$out/first" >"$out/log" 2>&1 || fail "cmake --install:" "$(cat "$out/log")"
    mv "$out/first" "$out/moved"
    [[ -s $out/moved/include/scotty/capture_writer.h ]] || fail "capture_writer.h is not installed"
    grep -q 'verify/capture' "$out/moved/include/scotty/capture_writer.h" && fail "the installed header needs another one"
    from=(-DCMAKE_PREFIX_PATH="$out/moved")
else
    from=(-DSCOTTY_SOURCE="$source" -DSCOTTY_NATIVE=OFF)
fi
"$cmake" -S "$project" -B "$out/build" -DCMAKE_BUILD_TYPE=Release "${from[@]}" >"$out/log" 2>&1 || fail "it is not configured:" "$(cat "$out/log")"
if [[ $how == source ]]; then  # none of the renderer's packages was looked for
    grep -qiE 'embree|openimageio|tbb|fmt_DIR' "$out/build/CMakeCache.txt" && fail "the renderer's packages were looked for"
fi
"$cmake" --build "$out/build" -j 2 >"$out/log" 2>&1 || fail "it does not build:" "$(tail -n 40 "$out/log")"
(cd "$out/build" && "$(dirname "$cmake")/ctest" --output-on-failure >"$out/log" 2>&1) || fail "its tests fail:" "$(cat "$out/log")"
grep -E 'tests passed' "$out/log"
"$cmake" --build "$out/build" >"$out/log" 2>&1
grep -q 'Building CUDA text' "$out/log" && fail "a second build compiles again:" "$(cat "$out/log")"

# The project that docs/your-own-code.md shows, by the command that it shows.
[[ $how == installed ]] || exit 0
page=$source/docs/your-own-code.md
mkdir "$out/page"
for file in scale.cu test_scale.cu CMakeLists.txt; do
    awk -v file="$file" '/^```/ { inside = $2 == file; next } inside' "$page" >"$out/page/$file"
    [[ -s $out/page/$file ]] || fail "the page shows no $file"
done
command=$(grep -E '^cmake -S \. -B build' "$page") || fail "the page does not say how to build"
(cd "$out/page" && HOME=$out && ln -s moved "$out/scotty" && eval "$command") >"$out/log" 2>&1 || fail "$command:" "$(tail -n 40 "$out/log")"
grep -E 'tests passed' "$out/log"
