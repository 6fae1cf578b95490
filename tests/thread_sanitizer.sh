#!/usr/bin/env bash
# thread_sanitizer.sh [CTEST OPTION...]: the tests with the thread sanitizer (preset tsan), on a TBB that has it too.
#
# The sanitizer sees no order between threads that a library without it has made, so that Debian's TBB would be all false
# alarms. TBB is built from Debian's own source (which the package index must list: deb-src); Embree and OpenImageIO have
# threads and locks of their own, and reports through them are suppressed, as is flatten(), which reads the tree that Embree's
# threads have built. One test is left out: its kernel reaches memory that is not there, and the sanitizer, which looks for that
# memory's shadow first, dies of it. So are the fuzzers' short runs: they have the address sanitizer.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$PWD/build/tsan
tbb=$build/tbb
if [[ ! -d $tbb/build ]]; then
    mkdir -p "$tbb"
    (cd "$tbb" && apt-get source --download-only onetbb && tar xf onetbb_*.orig.tar.xz) || {
        echo "needs TBB's source: a line 'Types: deb-src' (or 'deb-src ...') in /etc/apt, then apt-get update" >&2
        exit 3
    }
    cmake -S "$tbb"/oneTBB-* -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread \
        -DTBB_TEST=OFF -DTBB_STRICT=OFF >/dev/null
fi
ninja -C "$tbb/build" tbb
cmake --preset tsan >/dev/null
ninja -C "$build"
printf 'race:%s\n' libembree3.so libOpenImageIO flatten >"$tbb/suppressions"
library=$(find "$tbb/build" -name libtbb.so.12 -printf '%h\n' -quit)
cd "$build"
LD_LIBRARY_PATH=$library TSAN_OPTIONS="suppressions=$tbb/suppressions allocator_may_return_null=1" \
    ctest -LE lint -E '^fuzz/|a thread that reaches memory which is not there' --timeout 900 --output-on-failure "$@"
