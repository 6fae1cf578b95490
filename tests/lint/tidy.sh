# tidy.sh CLANG_TIDY BUILD_FOLDER SOURCE: clang-tidy finds nothing in this file and the headers of ours that it
# includes. That takes seconds, so what has passed is remembered: an empty file in the user's cache folder, named by
# a hash of everything that the verdict depends on. It holds in any checkout and needs no clearing.
source "$(dirname "$0")/common.sh"
need_version_14 "$1"
clang_tidy=$1 build=$2 source=$3 # relative to the top, or a piece of a unity build

[[ $source == /* ]] || source=$PWD/$source
entry=$(grep -F " -c $source\"" "$build/compile_commands.json") || {
    echo "$source is not part of the build: add it to its folder's CMakeLists.txt"
    exit 1
}
compiler=$(sed -E 's/.*"command": "//; s/ -o .*//' <<<"$entry")
# shellcheck disable=SC2086 # the compiler's flags, and the headers of ours that it reads, are words
{
    files=$(cd "$build" && $compiler -MM "$source" | tr -d '\\\n' | sed 's/^[^:]*://') ||
        files=$source # does not compile: clang-tidy will say why
    key=$({
        echo "${compiler//"$PWD"/.}"
        "$clang_tidy" --version
        cat .clang-tidy "$0" $files
    } | sha256sum | cut -c -64)
}
cache=${XDG_CACHE_HOME:-${HOME:-$build}/.cache}/cuda-scotty/lint
[[ -e $cache/$key ]] && {
    echo "unchanged since it passed"
    exit 0
}

# A piece of a unity build is nothing but included sources; what is off in their folder is off in it.
extra=()
if [[ $source == */Unity/* ]]; then
    folder=$(sed -n 's|^#include "\(.*\)/[^/]*"$|\1|p' "$source" | head -n 1)
    off=$([[ ! -e $folder/.clang-tidy ]] || sed -n "s/^Checks: '\(.*\)'$/,\1/p" "$folder/.clang-tidy")
    extra=("--checks=-bugprone-suspicious-include$off")
fi
# clang-tidy also counts the findings in system headers that it does not show; nobody wants to know.
"$clang_tidy" -p "$build" --quiet "$source" "${extra[@]}" 2>&1 | { grep -vE '^[0-9]+ warnings? (generated|treated)' || true; }
mkdir -p "$cache" && : >"$cache/$key" || true # an unwritable home only costs time
