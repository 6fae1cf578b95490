# planted.sh CLANG_FORMAT CLANG_TIDY: a check that was never seen to fail proves nothing. In a checkout of its own,
# every check passes on a clean file, then fails on one planted violation and names the file.
source "$(dirname "$0")/common.sh"
need_version_14 "$1"
need_version_14 "$2"
clang_format=$1 clang_tidy=$2
lint=$PWD/tests/lint

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp .clang-format .clang-tidy "$folder"
export XDG_CACHE_HOME=$folder/cache
cd "$folder"
git init -q
mkdir -p reference/base build

clean() {
    cat >reference/base/length.h <<'TEXT'
#pragma once
inline float length_squared(float x, float y) { return x * x + y * y; }
TEXT
    cat >reference/base/length.cpp <<'TEXT'
#include "reference/base/length.h"

float twice(float x) { return length_squared(x, x); }
TEXT
    git add -f .clang-format reference
    cat >build/compile_commands.json <<TEXT
[ { "directory": "$folder/build",
    "command": "c++ -I$folder -std=c++20 -o length.o -c $folder/reference/base/length.cpp",
    "file": "$folder/reference/base/length.cpp" } ]
TEXT
}

passes() {
    local output
    output=$(bash "$lint/$1" "${@:2}" 2>&1) || {
        printf '%s\n' "$* fails on a clean checkout:" "$output"
        exit 1
    }
}

# fails_naming TEXT SCRIPT ARGUMENT...
fails_naming() {
    local output status=0
    git add -f reference
    output=$(bash "$lint/$2" "${@:3}" 2>&1) || status=$?
    if ((status == 0 || status == 77)) || [[ $output != *"$1"* ]]; then
        printf '%s\n' "$2 was to fail and name $1; exit code $status:" "$output"
        exit 1
    fi
    git rm -q -f --cached -r reference
    rm -rf reference/* && mkdir reference/base && clean
    echo "seen to fail: $2 ($1)"
}

clean
passes format.sh "$clang_format"
passes machine_paths.sh
passes sizes.sh
passes floors.sh
mkdir docs
echo "\`reference/base/length.h\`" >docs/architecture.md
passes architecture.sh
passes tidy.sh "$clang_tidy" build reference/base/length.cpp

echo 'float   thrice( float x );' >>reference/base/length.h
fails_naming reference/base/length.h format.sh "$clang_format"

printf '// see /%s/somebody/notes\n' home >>reference/base/length.h
fails_naming reference/base/length.h:3 machine_paths.sh

head -c 524289 /dev/zero >reference/base/picture.exr
fails_naming reference/base/picture.exr sizes.sh

seq -f '// line %g' 701 >reference/base/long.h
fails_naming reference/base/long.h sizes.sh

echo '#include "reference/truth/tracers.h"' >>reference/base/length.h
fails_naming 'reference/base/length.h:3: includes reference/truth/tracers.h' floors.sh
echo '#include "gpu/kernels/dialect.h"' >>reference/base/length.h
fails_naming 'reference/base/length.h:3: includes gpu/kernels/dialect.h' floors.sh
mkdir -p verify/base
echo '#include "reference/stages/filters.h"' >verify/base/judge.h
git add -f verify
fails_naming 'verify/base/judge.h:1: includes reference/stages/filters.h, but verify/ never includes reference/stages/' floors.sh
git rm -q -f --cached -r verify && rm -rf verify
echo "\`reference/base/gone.h\`" >docs/architecture.md
fails_naming reference/base/gone.h architecture.sh
echo "#pragma once" >reference/stray.h
fails_naming 'reference/stray.h: is in no room' floors.sh

# One per family of checks, in the source and in a header.
echo 'int* none() { return 0; }' >>reference/base/length.cpp
fails_naming modernize-use-nullptr tidy.sh "$clang_tidy" build reference/base/length.cpp
echo 'inline float Length(float x) { return x; }' >>reference/base/length.h
fails_naming 'length.h:3' tidy.sh "$clang_tidy" build reference/base/length.cpp
echo 'float half(int x) { return x / 2; }' >>reference/base/length.cpp
fails_naming bugprone-integer-division tidy.sh "$clang_tidy" build reference/base/length.cpp
echo 'int unfinished( {' >>reference/base/length.cpp
fails_naming clang-diagnostic-error tidy.sh "$clang_tidy" build reference/base/length.cpp
fails_naming 'not part of the build' tidy.sh "$clang_tidy" build reference/base/other.cpp
