#!/usr/bin/env bash
# at_scale.sh SCOTTY: a sweep whole, and in parts that run at a time. The joined report says the same but for times;
# parts that are missing, doubled or of another sweep are refused. One thread each, since early-outs make the number of
# hits in leaves depend on which block comes first.
set -euo pipefail
scotty=$1
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
golden=$(dirname "$0")/../../../golden
sweep=(verify furnace veil --size 16x12 --spp 1 --bounces 1 --schedules 2 --threads 1)

"$scotty" "${sweep[@]}" --json "$out/whole.json" --golden "$golden" >/dev/null 2>&1
seq 3 | xargs -P 2 -I {} "$scotty" "${sweep[@]}" --golden "$golden" --shard {}/3 --json "$out/{}.json" >/dev/null 2>&1
"$scotty" report "$out"/{3,1,2}.json --json "$out/joined.json" --html "$out/joined.html" --junit "$out/joined.xml" \
    >/dev/null 2>&1

python3 - "$out" <<'TEXT'
import json, sys
def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in ("seconds", "oracle_seconds", "command")}
    return [without_times(v) for v in value] if isinstance(value, list) else value
whole, joined = (without_times(json.load(open(f"{sys.argv[1]}/{name}.json"))) for name in ("whole", "joined"))
assert whole["passed"] and len(whole["images"]) == 2 and len(whole["scenes"]) == 2, "the sweep is not what it should be"
for key in whole.keys() | joined.keys():
    assert whole.get(key) == joined.get(key), f"{key} is not the same"
sizes = [len(c["scenes"]) + len(c["images"]) for c in (json.load(open(f"{sys.argv[1]}/{i}.json")) for i in (1, 2, 3))]
assert all(sizes), f"a part has nothing to do: {sizes}"
TEXT
[[ -s $out/joined.html && -s $out/joined.xml ]]

refused() { # WORDS FILE...
    local words=$1 code=0
    shift
    "$scotty" report "$@" >"$out/said" 2>&1 || code=$?
    [[ $code == 2 ]] && grep -q "$words" "$out/said" && return
    echo "expected exit code 2 and '$words', found $code:"
    cat "$out/said"
    exit 1
}
refused "shard 2/3: is missing" "$out"/{1,3}.json
refused "is shard 1/3, and so is" "$out"/{1,1,2,3}.json
"$scotty" "${sweep[@]}" --seed 1 --no-golden --shard 2/3 --json "$out/other.json" >/dev/null 2>&1
refused "is of another sweep" "$out"/{1,other,3}.json
refused "expected what scotty verify --shard" "$out/whole.json"

# A golden file that is broken fails the sweep, in parts too, and excuses no run that nobody made.
cp -r "$golden" "$out/golden"
echo broken >"$out/golden/images/veil.exr"
for part in 1 2; do
    "$scotty" verify furnace veil --only-golden --golden "$out/golden" --shard $part/2 --json "$out/golden$part.json" \
        >/dev/null 2>&1 || true
done
code=0
"$scotty" report "$out"/golden{1,2}.json >"$out/said" 2>&1 || code=$?
[[ $code == 1 ]] && grep -q "veil.exr" "$out/said"
python3 - "$out" <<'TEXT'
import json, sys
for part in 1, 2:
    path = f"{sys.argv[1]}/golden{part}.json"
    report = json.load(open(path))
    report["images"] = []
    json.dump(report, open(path, "w"))
TEXT
refused "unit 0 of 2: was run by no shard" "$out"/golden{1,2}.json
for part in 1 2; do
    "$scotty" "${sweep[@]}" --stage 'nosuch*' --shard $part/2 --json "$out/stage$part.json" >/dev/null 2>&1
done
refused "no stage's name matches" "$out"/stage{1,2}.json

# The cases of the covering array come in parts, too.
cases=(verify --quick --brute-force 1000000 --threads 1)
"$scotty" "${cases[@]}" --json "$out/cases.json" >/dev/null 2>&1
seq 2 | xargs -P 2 -I {} "$scotty" "${cases[@]}" --shard {}/2 --json "$out/cases{}.json" >/dev/null 2>&1
"$scotty" report "$out"/cases{1,2}.json --json "$out/cases_joined.json" >/dev/null 2>&1
python3 - "$out" <<'TEXT'
import json, sys
whole, joined = (json.load(open(f"{sys.argv[1]}/{name}.json")) for name in ("cases", "cases_joined"))
cases = whole["coverage"]["cases"]
assert whole["coverage"] == joined["coverage"] and cases >= 40, "the cases are not what they should be"
for report in whole, joined:
    scene = report["scenes"][0]
    assert report["passed"] and scene["scene"] == "cases" and len(scene["configurations"]) == cases
assert whole["scenes"][0]["hits"] == joined["scenes"][0]["hits"], "oracles of the parts do not add up"
TEXT
echo "whole and joined say the same"
