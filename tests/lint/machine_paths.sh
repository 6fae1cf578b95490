# machine_paths.sh: no tracked file names a folder that only exists on somebody's machine.
source "$(dirname "$0")/common.sh"
need_checkout

status=0
found=$(git grep -nIE '(^|[^A-Za-z0-9_.])/(work|farm|root|home)/[a-z.]' -- . ':!*.lock') || status=$?
case $status in
    0)
        echo "paths of one machine, which no other has:"
        echo "$found"
        exit 1
        ;;
    1) echo "none found" ;; # git grep's "no match"
    *) exit "$status" ;;    # git could not read the checkout, and has said why
esac
