# sizes.sh: no tracked file exceeds 512 KiB, no source file 700 lines (is it still one idea?).
source "$(dirname "$0")/common.sh"
need_checkout

wrong=$(git ls-files -z | { xargs -0 stat --printf '%s %n\n' 2>/dev/null || true; } | # a deleted file is not there
    awk '$1 > 512 * 1024 { size = $1; sub(/^[0-9]+ /, ""); printf "%s: %d KiB, at most 512 are allowed in the repository\n", $0, size / 1024 }'
    git ls-files -z -- '*.h' '*.hpp' '*.cpp' '*.cu' '*.cuh' '*.py' '*.sh' '*.cmake' '*CMakeLists.txt' '*.html' '*.css' '*.js' |
        { xargs -0 wc -l 2>/dev/null || true; } | awk '$1 > 700 && !/ total$/ { sub(/^ +/, ""); lines = $1; sub(/^[0-9]+ /, "")
            printf "%s: %s lines, at most 700 are allowed; split it\n", $0, lines }')
if [[ -n $wrong ]]; then
    echo "$wrong"
    exit 1
fi
echo "sizes are fine"
