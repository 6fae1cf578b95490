# tidy.sh CLANG_TIDY BUILD_FOLDER SOURCE: clang-tidy finds nothing in this file and the headers of ours that it
# includes. Takes seconds, so what passed is remembered in the build folder until one of those files changes.
source "$(dirname "$0")/common.sh"
clang_tidy=$1 build=$2 source=$3

# The key: the content of everything of ours that the compiler would read, the flags and the configuration.
flags=$(grep -F " -c $PWD/$source\"" "$build/compile_commands.json") ||
    { echo "$source is not part of the build: add it to its folder's CMakeLists.txt"; exit 1; }
compiler=$(sed -E 's/.*"command": "//; s/ -o .*//' <<<"$flags")
# shellcheck disable=SC2086 # the flags are words
headers=$(cd "$build" && $compiler -MM "$OLDPWD/$source" | tr -d '\\\n' | sed 's/^[^:]*://')
# shellcheck disable=SC2086
key=$({ echo "$compiler"; "$clang_tidy" --version; cat .clang-tidy $headers; } | sha256sum | cut -c -64)
passed=$build/lint/$key
[[ -e $passed ]] && { echo "unchanged since it passed"; exit 0; }

# clang-tidy also prints how many findings in system headers it does not show; nobody wants to know.
"$clang_tidy" -p "$build" --quiet "$source" 2>&1 | { grep -vE '^[0-9]+ warnings? (generated|treated)' || true; }
mkdir -p "$build/lint"
: >"$passed"
