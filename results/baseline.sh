#!/bin/bash
# Whether `compare --baseline` can be trusted on the default device: `results/baseline.sh same|slower|same-small [TIMES [SPEC]]`.
# Measures plume_8k three times, which are the baseline, then the same TIMES times (20) against them. `same`: nothing has changed, and none should
# fail. `slower`: each build takes 10 % longer on purpose, since it also fills memory (GOBO_TEST_BURDEN, whose MiB are
# worked out first), and all should fail. `same-small` is `same` in a map of 64 x 64 and a picture of 80 x 45, for lavapipe.
# Says of each run whether it failed and what the build took, then how many did and in how long, and ends with failure where
# that is not how it should be.
# GOBO is the program, by default target/release/gobo.
set -u
what=${1:-} times=${2:-20} size='' picture=320x180
case $what in
same | slower) ;;
same-small) what=same size=,size=64 picture=80x45 ;;
*)
    sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
esac
spec=${3:-avsm:path=two-pass$size}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# measure MIB NAME [ARGUMENT…]: a run into $out/NAME.
measure() {
    local mib=$1 name=$2
    shift 2
    GOBO_TEST_BURDEN=$mib ${GOBO:-target/release/gobo} --test-hooks compare plume_8k --technique "$spec" --quick \
        --frames 10 --picture "$picture" --out "$out/$name" "$@" >"$out/$name.txt" 2>&1
}
# Nanoseconds of a build, the median.
build() {
    sed -n '/"build_ns"/,/}/s/.*"median": \([0-9.]*\).*/\1/p' "$out/$1/results.json"
}
# Where the program failed for another reason than what it found.
other() {
    cat "$out/$1.txt" >&2
    exit 2
}

baselines=()
for name in before second third; do
    measure 0 $name || other $name
    baselines+=(--baseline "$out/$name/results.json")
    echo "baseline: $spec on plume_8k, a build of $(build $name) ns"
done
mib=0
if [ "$what" = slower ]; then
    # How long so many MiB take, and from that how many take 10 % of a build; once more from there, where fewer fit a cache.
    mib=64
    for try in 1 2; do
        measure $mib try || other try
        mib=$(awk -v a="$(build before)" -v b="$(build try)" -v mib=$mib \
            'BEGIN { print (b > a ? int(mib * 0.1 * a / (b - a) + 0.999) : 2 * mib) }')
    done
    echo "each build also fills $mib MiB"
fi
failed=0
for ((i = 1; i <= times; i++)); do
    status=0
    measure $mib now "${baselines[@]}" --fail-slower --fail-worse || status=$?
    [ $status -le 1 ] && [ -e "$out/now/results.json" ] || other now
    failed=$((failed + status))
    [ $status = 0 ] && word=holds || word=fails
    awk -v i=$i -v word=$word -v a="$(build before)" -v b="$(build now)" \
        'BEGIN { printf "%d %s: a build of %d ns, %+.1f %%\n", i, word, b, 100 * (b / a - 1) }'
    [ $status = 0 ] || grep -E '^gobo: .*than the baseline|SLOWER|WORSE' "$out/now.txt"
    rm -r "$out/now"
done
echo "$failed of $times failed, in $SECONDS s"
[ "$what" = same ] && [ $failed = 0 ] || { [ "$what" = slower ] && [ $failed = "$times" ]; }
