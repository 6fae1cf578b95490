#!/usr/bin/env bash
# fuzz.sh build            builds the fuzzers with the preset "fuzz" (clang and its libFuzzer)
# fuzz.sh short READER     a few thousand inputs, the same every time; what is found is left in build/fuzz/found/
# fuzz.sh long SECONDS     every reader in turn, that long together; new inputs go to build/fuzz/inputs/
# Exit codes: 0 nothing found, 77 no clang with libFuzzer here (fails with SCOTTY_REQUIRE_FUZZ=1).
set -euo pipefail
cd "$(dirname "$0")/../.."
corpus=tests/fuzz/corpus
build=build/fuzz
# An input may not take 10 s or a gigabyte at once.
# Leaks are not checked, because some libraries keep what they allocate once.
limits=(-detect_leaks=0 -timeout=10 -malloc_limit_mb=1000 -rss_limit_mb=3000)

# Debian names it with its version, the newest of which counts: 14 on Debian 12, 19 on Debian 13.
clang=$(compgen -c clang++ | sort -V | tail -n 1)

have_fuzzer() { echo 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }' |
    "${clang:-clang++}" -fsanitize=fuzzer -x c++ - -o /dev/null 2>/dev/null; }
if ! have_fuzzer; then
    echo "not run: needs clang++ with libFuzzer (Debian: clang-tidy libclang-rt-dev)"
    [[ -z ${SCOTTY_REQUIRE_FUZZ:-} ]] && exit 77 || exit 1
fi

program() {
    case $1 in
        command_line) echo "$build/bin/fuzz_command_line" ;;
        view_*) echo "$build/bin/fuzz_view" ;;
        *) echo "$build/bin/fuzz_files" ;;
    esac
}

fuzz() { # READER NEW_INPUTS OPTION...
    local reader=$1 inputs=$2
    shift 2
    mkdir -p "$build/found" "$inputs"
    SCOTTY_READER=$reader "$(program "$reader")" "${limits[@]}" -print_funcs=0 -artifact_prefix="$build/found/$reader-" "$@" \
        "$inputs" "$corpus/$reader" 2>&1 | grep -vE '^#|^INFO|^"|^Uncategorized|dictionary' | tail -n 40
}

case ${1:-} in
    build)
        cmake --preset fuzz -D CMAKE_CXX_COMPILER="$clang" >/dev/null
        ninja -C "$build" fuzz_files fuzz_command_line fuzz_view | tail -n 5
        ;;
    short)
        inputs=$(mktemp -d)
        trap 'rm -rf "$inputs"' EXIT
        runs=4000
        [[ $2 == command_line ]] && runs=300 # its library is slow to start
        fuzz "$2" "$inputs" -seed=1 -runs=$runs
        ;;
    long)
        readers=("$corpus"/*/)
        readers=("${readers[@]%/}")
        readers=("${readers[@]##*/}")
        for reader in "${readers[@]}"; do
            echo "$reader"
            fuzz "$reader" "$build/inputs/$reader" -max_total_time=$(($2 / ${#readers[@]}))
        done
        ;;
    *)
        sed -n '2,5s/^# //p' "$0"
        exit 2
        ;;
esac
