# Sourced by every check; they all run in the root of the checkout.
set -euo pipefail

skip() {
    echo "skipped: $*"
    exit 77
}

# Another version formats otherwise and has other checks, so the text follows one: that of Debian 12.
need_version_14() {
    local found
    found=$("$1" --version | sed -nE 's/.*version ([0-9]+).*/\1/p' | head -n 1)
    [[ $found == 14 ]] || skip "the text follows version 14 of ${1##*/}; this is version ${found:-unknown}"
}

# A downloaded archive has no list of tracked files. (A checkout that git refuses to read is a failure.)
need_checkout() { [[ -e .git ]] || skip "not a git checkout, so there is no list of tracked files"; }
