# floors.sh: every include points to the file's own room or to one above it in floors.txt, and every source file of
# reference/, emulation/, gpu/ and verify/ is in a room.
source "$(dirname "$0")/common.sh"
need_checkout

list=$(dirname "$0")/floors.txt
found=$(git ls-files -z -- '*.h' '*.cpp' '*.cu' ':!tests' | xargs -0 awk -v list="$list" '
    BEGIN {
        while ((getline line < list) > 0) {
            if (line ~ /^never /) { split(line, word, " "); never[word[2], word[3]] = 1 }
            else if (line != "" && line !~ /^#/) floor[line] = ++floors
        }
        if (!floors) { print list ": no rooms"; exit }
    }
    function folder_of(path) { sub(/\/.*/, "", path); return path }
    function room_of(path,    parts, room) {
        room = folder_of(path)
        if (room in floor) return room
        split(path, parts, "/")
        return parts[1] "/" parts[2]
    }
    FNR == 1 {
        room = room_of(FILENAME)
        if (!(room in floor)) print FILENAME ": is in no room of tests/lint/floors.txt"
    }
    /^ *# *include "/ {
        split($0, quoted, "\"")
        other = room_of(quoted[2])
        if (!(other in floor)) next # generated, or beside the file
        folder = folder_of(FILENAME)
        if ((folder, folder_of(quoted[2])) in never) banned = folder_of(quoted[2])
        else if ((folder, other) in never) banned = other
        else banned = ""
        if (banned != "")
            print FILENAME ":" FNR ": includes " quoted[2] ", but " folder "/ never includes " banned "/"
        else if (floor[other] > floor[room])
            print FILENAME ":" FNR ": includes " quoted[2] ", which is on a higher floor than " room "/"
    }')
if [[ $found ]]; then
    echo "includes point the wrong way (the order of the rooms is in tests/lint/floors.txt):"
    echo "$found"
    exit 1
fi
echo "includes point to lower floors only"
