# sizes.sh: no tracked file exceeds 512 KiB, no source file 700 lines (is it still one idea?).
source "$(dirname "$0")/common.sh"
need_checkout

wrong=0
while IFS= read -r -d '' file; do
    [[ -f $file ]] || continue # deleted, not yet committed
    bytes=$(stat -c %s "$file")
    if ((bytes > 512 * 1024)); then
        echo "$file: $((bytes / 1024)) KiB, at most 512 are allowed in the repository"
        wrong=1
    fi
    case $file in
        *.h | *.hpp | *.cpp | *.cu | *.cuh | *.py | *.sh | *.cmake | *CMakeLists.txt | *.html | *.css | *.js)
            lines=$(wc -l <"$file")
            if ((lines > 700)); then
                echo "$file: $lines lines, at most 700 are allowed; split it"
                wrong=1
            fi
            ;;
    esac
done < <(git ls-files -z)
((wrong)) && exit 1
echo "sizes are fine"
