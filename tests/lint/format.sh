# format.sh CLANG_FORMAT: every tracked C++ and CUDA file is as clang-format writes it.
source "$(dirname "$0")/common.sh"
need_checkout
need_version_14 "$1"

mapfile -t files < <(git ls-files -- '*.h' '*.hpp' '*.cpp' '*.cu' '*.cuh')
((${#files[@]})) || { echo "git lists no source file: this check would check nothing"; exit 1; }

existing=()
for file in "${files[@]}"; do
    [[ ! -f $file ]] || existing+=("$file") # else deleted, not yet committed
done
if ! said=$("$1" --dry-run --Werror "${existing[@]}" 2>&1); then
    mapfile -t wrong < <(sed -nE 's/^([^ :]+):[0-9]+:[0-9]+: error: code should be clang-formatted.*/\1/p' <<<"$said" | sort -u)
    ((${#wrong[@]})) || { head -n 20 <<<"$said"; exit 1; }
    echo "not clang-formatted; to mend: clang-format -i ${wrong[*]}"
    exit 1
fi
echo "${#existing[@]} files are clang-formatted"
