# Sourced by every check; they all run in the root of the checkout.
set -euo pipefail

skip() {
    echo "skipped: $*"
    exit 77
}

# A downloaded archive has no list of tracked files. (A checkout that git refuses to read is a failure.)
need_checkout() { [[ -e .git ]] || skip "not a git checkout, so there is no list of tracked files"; }
