# format.sh CLANG_FORMAT: every tracked C++ and CUDA file is as clang-format writes it.
source "$(dirname "$0")/common.sh"
need_checkout

mapfile -t files < <(git ls-files -- '*.h' '*.hpp' '*.cpp' '*.cu' '*.cuh')
((${#files[@]})) || { echo "git lists no source file: this check would check nothing"; exit 1; }

wrong=()
for file in "${files[@]}"; do
    [[ -f $file ]] || continue # deleted, not yet committed
    "$1" --dry-run --Werror "$file" >/dev/null 2>&1 || wrong+=("$file")
done
if ((${#wrong[@]})); then
    echo "not clang-formatted; to mend: clang-format -i ${wrong[*]}"
    exit 1
fi
echo "${#files[@]} files are clang-formatted"
