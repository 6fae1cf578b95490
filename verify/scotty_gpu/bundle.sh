#!/usr/bin/env bash
# Verification on a machine that has a driver and nothing else, in three steps:
#
#   ./run gpu-bundle make FOLDER     here: scotty-gpu, inputs of every built-in scene for every width, and this script
#   FOLDER/bundle.sh run             there: parity, then every configuration; captures keep their hashes only
#   ./run gpu-bundle check FOLDER    here again, with what came back: every capture against a fresh emulator run
#
# Inputs are 24 x 17 pixels with 2 samples; the configurations are widths 2, 4, 8, 16, rays per block 64 with queues on
# all levels and 256 with queues on two, early-out off and level, both hit modes: 256 captures of the 8 built-in scenes.
set -euo pipefail

picture=(--size 24x17 --spp 2)

make_bundle() {
    local scotty=$1 gpu=$2 script=$3 folder=$4 scene width
    [[ ! -e $folder ]] || { echo "$folder is there already" >&2; exit 2; }
    mkdir -p "$folder/inputs"
    for scene in $("$scotty" list --json | python3 -c 'import json, sys; [print(s["name"]) for s in json.load(sys.stdin)]'); do
        for width in 2 4 8 16; do
            "$scotty" capture "$scene" "${picture[@]}" --width "$width" --input-only -o "$folder/inputs/$scene.$width"
        done
    done
    cp "$gpu" "$folder/scotty-gpu"
    cp "$script" "$folder/bundle.sh"
    echo "copy $folder to the machine with the GPU, run bundle.sh run there, and bring it back"
}

run_bundle() {
    cd "$(dirname "${BASH_SOURCE[0]}")"
    ./scotty-gpu device
    ./scotty-gpu parity
    local input block levels early mode name count=0
    mkdir -p captures
    for input in inputs/*; do
        for block in 64 256; do
            levels=0
            [[ $block == 64 ]] || levels=2
            for early in off level; do
                for mode in buffer packed; do
                    name=${input#inputs/}.$block.$early.$mode
                    ./scotty-gpu run "$input" -o "captures/$name" --hashes-only --rays-per-block "$block" --queue-levels $levels \
                        --early-out "$early" --hit-mode "$mode" >/dev/null
                    count=$((count + 1))
                done
            done
        done
    done
    echo "$count captures; bring the folder back and check it"
}

check_bundle() {
    local scotty=$1 folder=$2 capture scene width block levels early mode good=0 bad=0
    mine=$(mktemp -d) # not local: the trap outlives the function
    trap 'rm -rf "$mine"' EXIT
    [[ -d $folder/captures ]] || { echo "$folder has no captures: run bundle.sh run on the machine with the GPU" >&2; exit 2; }
    for capture in "$folder"/captures/*; do
        IFS=. read -r scene width block early mode <<<"$(basename "$capture")"
        levels=0
        [[ $block == 64 ]] || levels=2
        "$scotty" capture "$scene" "${picture[@]}" --width "$width" --rays-per-block "$block" --queue-levels $levels --early-out "$early" \
            --hit-mode "$mode" -o "$mine/capture" 2>/dev/null
        if "$scotty" diff "$mine/capture" "$capture" >"$mine/diff.txt"; then
            good=$((good + 1))
        else
            bad=$((bad + 1))
            echo "$capture"
            head -n 12 "$mine/diff.txt"
        fi
    done
    echo "$good captures agree with the emulator in every stage, $bad do not"
    ((bad == 0 && good > 0))
}

case ${1:-} in
    make) make_bundle "${@:2}" ;;
    run) run_bundle ;;
    check) check_bundle "${@:2}" ;;
    *)
        sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
        exit 2
        ;;
esac
