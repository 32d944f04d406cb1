#!/bin/bash
# Holds what `gobo recommend` answers against all that it could have answered: `results/recommend.sh FOLDER [SCENE…]`.
#
# For each scene, by default five, `gobo recommend SCENE` and `gobo recommend SCENE --thorough`, which measures the same techniques in
# half, usual and twice the size, all of them properly; and `gobo compare SCENE`, which leaves sizes as they are. Prints a Markdown row per
# scene: the seconds of the first two, the share that the one is of the other, those of the third, the answer, and by how much the row of
# the thorough run that beats it most does so in both frame time and error over all points: 1.00 is on the front.
# With QUICK=1 all three are --quick. GOBO is the program, by default `cargo run --release --`. What is there of an earlier run is kept.
# Drivers' caches of compiled shaders are off, so that the second run does not find what the first has compiled.
set -u
export __GL_SHADER_DISK_CACHE=0 MESA_SHADER_CACHE_DISABLE=true
folder=${1:-}
[ -n "$folder" ] || { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2 && exit 2; }
shift
[ $# -gt 0 ] || set -- plume_8k hair houses courtyard fountain
read -ra gobo <<<"${GOBO:-cargo run --release --quiet --}"
echo '| scene | recommend, s | thorough, s | share | compare, s | answer | beaten by |'
echo '|---|---|---|---|---|---|---|'
failed=0
for scene in "$@"; do
    seconds=()
    for way in recommend thorough compare; do
        out=$folder/${scene//[^a-z0-9_]/-}/$way
        mkdir -p "$out"
        if [ ! -e "$out/seconds" ]; then
            command=recommend more=(${QUICK:+--quick})
            [ $way != thorough ] || more+=(--thorough)
            [ $way != compare ] || command=compare
            start=$(date +%s.%N)
            "${gobo[@]}" $command "$scene" --out "$out" "${more[@]}" >"$out/text" 2>"$out/errors" ||
                { echo "$scene $way: $(tail -n 1 "$out/errors")" >&2 && failed=1 && continue 2; }
            echo "$start $(date +%s.%N)" | awk '{ printf "%.1f\n", $2 - $1 }' >"$out/seconds"
        fi
        seconds+=("$(cat "$out/seconds")")
    done
    # The answer is worked out again: the least product of time and error, among rows that are closer than no shadow.
    awk -F, -v scene="$scene" -v recommend="${seconds[0]}" -v thorough="${seconds[1]}" -v compare="${seconds[2]}" '
        # What stands in quotes is one field.
        { count = split($0, part, "\""); $0 = ""; line = ""
          for (i = 1; i <= count; i++) { if (i % 2 == 0) gsub(",", ";", part[i]); line = line part[i] }
          $0 = line }
        FNR == 1 { file++; for (i = 1; i <= NF; i++) column[$i] = i; next }
        $column["status"] != "ok" || $column["frame_ns"] == "" { next }
        { surface = $column["surface_mean_abs"]; error = surface == "" ? $column["space_mean_abs"] : surface; time = $column["frame_ns"] / 1e6 }
        error == "" { next }
        $column["technique"] == "none" { if (file == 1) dark = error; next }
        file == 1 { first++; specs[first] = $column["variant"]; times[first] = time; errors[first] = error; next }
        { all++; spec[all] = $column["variant"]; t[all] = time; e[all] = error }
        END {
            for (i = 1; i <= first; i++) {
                worth = times[i] * (errors[i] > 0.001 ? errors[i] : 0.001)
                if ((dark == "" || errors[i] + 0 < dark + 0) && (best == "" || worth < least)) { best = specs[i]; least = worth }
            }
            for (i = 1; i <= all; i++) if (spec[i] == best) own = i
            by = 1
            for (i = 1; own && i <= all; i++) {
                faster = t[own] / t[i]
                closer = (e[own] > 0.001 ? e[own] : 0.001) / (e[i] > 0.001 ? e[i] : 0.001)
                both = faster < closer ? faster : closer
                if (both > by) by = both
            }
            gsub(";", ",", best)
            printf "| %s | %s | %s | %.2f | %s | `%s` | %s |\n", scene, recommend, thorough, recommend / thorough, compare, best, own ? sprintf("%.2f", by) : "not there"
            exit !own
        }' "$folder/${scene//[^a-z0-9_]/-}/recommend/results.csv" "$folder/${scene//[^a-z0-9_]/-}/thorough/results.csv" || failed=1
done
exit $failed
