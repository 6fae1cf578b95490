# check.sh exact|contracted|approximate COMPILER [FLAG...]: the kernels' PTX holds no approximate instruction and no
# fma that the source does not ask for (written_fma.h marks those that it does). The compiler is nvcc, with the flags
# of the build, or clang, which needs no toolkit (without_toolkit/cuda_runtime.h).
# The other two words plant a fault by compiler flag, and the check has to find it: exit code 0 when it does.
set -euo pipefail
cd "$(dirname "$0")/../../.."
mode=$1 compiler=$2
shift 2
here=tests/gpu/ptx
ptx=$(mktemp)
trap 'rm -f "$ptx"' EXIT

if [[ $(basename "$compiler") == nvcc* ]]; then
    case $mode in
        contracted) planted=(--fmad=true) ;;
        approximate) planted=(--ftz=true --prec-div=false --prec-sqrt=false) ;; # the last of two flags counts
        *) planted=() ;;
    esac
    "$compiler" -ptx -arch=compute_75 -std=c++20 -diag-suppress=20012 -I. -include $here/written_fma.h "$@" \
        "${planted[@]}" -o "$ptx" $here/kernels.cu
else
    case $mode in
        contracted) planted=(-ffp-contract=fast) ;;
        approximate) planted=(-ffast-math -fcuda-approx-transcendentals -fcuda-flush-denormals-to-zero) ;;
        *) planted=() ;;
    esac
    "$compiler" -x cuda -std=c++20 --cuda-device-only --cuda-gpu-arch=sm_75 -Xclang -target-feature -Xclang +ptx70 \
        -nocudainc -nocudalib -D__CUDACC__ -DGLM_FORCE_CUDA -Wno-unknown-cuda-version \
        -D__cpp_impl_coroutine=201902L -O2 -ffp-contract=off -S -I $here/without_toolkit -I. \
        -include $here/written_fma.h "${planted[@]}" -o "$ptx" $here/kernels.cu
fi

kernels=$(grep -c '\.entry' "$ptx")
written=$(grep -c 'fma\.rn\.f32.*// written' "$ptx" || true)
divisions=$(grep -cE 'div\.rn\.f32|sqrt\.rn\.f32' "$ptx" || true)
found=$({
    grep -nE '\.approx|\.ftz|div\.full|[[:space:]](rsqrt|sin|cos|ex2|lg2|tanh)\.' "$ptx" | sed 's/^/approximate, line /' || true
    grep -nE '(fma|mad)\.[a-z.]*f(16|32|64)' "$ptx" | grep -v '// written' | sed 's/^/unwritten fma, line /' || true
})
count=$(grep -c . <<<"$found" || true)
echo "$kernels kernels: $written written fmas, $divisions correctly rounded divisions and square roots," \
    "$count forbidden instructions"
head -n 10 <<<"$found"
# Fewer would mean that something is not looked at.
((kernels >= 20 && written > 0)) || { echo "expected 20 kernels and more, and fmas that are written"; exit 1; }
case $mode in
    exact) ((count == 0 && divisions > 0)) ;;
    contracted) grep -q unwritten <<<"$found" ;;
    approximate) grep -q approximate <<<"$found" ;;
esac
