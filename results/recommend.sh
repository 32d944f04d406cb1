#!/bin/bash
# Holds what `gobo recommend` answers against all that it could have answered: `results/recommend.sh FOLDER [SCENE…]`.
#
# For each scene, by default five, `gobo recommend SCENE` and `gobo recommend SCENE --thorough`, which measures the same techniques in
# half, usual and twice the size, all of them properly. Prints a Markdown row per scene: the seconds of both, the share that the one is of
# the other, the answer, its FLIP and that of no shadow, and by how much the row of the thorough run that beats it most does so in both
# time and seen error: 1.00 is on the front. The time is the cost, or that of a build and a million look-ups where that decides.
# With QUICK=1 both are --quick; with THOROUGH=0 there is no thorough run. GOBO is the program, by default `cargo run --release --`. What
# is there of an earlier run is kept. Needs python3.
# Drivers' caches of compiled shaders are off, so that the second run does not find what the first has compiled.
set -u
export __GL_SHADER_DISK_CACHE=0 MESA_SHADER_CACHE_DISABLE=true
folder=${1:-}
[ -n "$folder" ] || { sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2 && exit 2; }
shift
[ $# -gt 0 ] || set -- plume_8k hair houses courtyard fountain
read -ra gobo <<<"${GOBO:-cargo run --release --quiet --}"
ways=(recommend thorough)
[ "${THOROUGH:-1}" != 0 ] || ways=(recommend)
echo '| scene | recommend, s | thorough, s | share | answer | ms | FLIP | none | beaten by |'
echo '|---|---|---|---|---|---|---|---|---|'
failed=0
for scene in "$@"; do
    for way in "${ways[@]}"; do
        out=$folder/${scene//[^a-z0-9_]/-}/$way
        mkdir -p "$out"
        [ ! -e "$out/seconds" ] || continue
        more=(${QUICK:+--quick})
        [ "$way" != thorough ] || more+=(--thorough)
        start=$(date +%s.%N)
        "${gobo[@]}" recommend "$scene" --json --out "$out" "${more[@]}" >"$out/answer.json" 2>"$out/errors" ||
            { echo "$scene $way: $(tail -n 1 "$out/errors")" >&2 && failed=1 && continue 2; }
        echo "$start $(date +%s.%N)" | awk '{ printf "%.1f\n", $2 - $1 }' >"$out/seconds"
    done
    python3 - "$scene" "$folder/${scene//[^a-z0-9_]/-}" <<'PYTHON' || failed=1
import json, os, sys

scene, folder = sys.argv[1:]


def read(way, name):
    path = f"{folder}/{way}/{name}"
    return open(path).read() if os.path.exists(path) else None


def seen(row):
    return ((row["error"] or {}).get("seen") or {}).get("mean")


def flip(row):
    return ((row["error"] or {}).get("image") or {}).get("flip_mean")


# The time is worked out again from what was measured: without a bake, and without what is drawn where that decides nothing.
def ms(row, by_compute, floor):
    if not by_compute:
        return row["cost_ns"] and max(row["cost_ns"] / 1e6, floor)
    baked = row["technique"] == "voxelized" and row["frame_ns"] == row["draw_ns"]["median"]
    passes = [] if baked else [p for p in row["passes"] if not p["name"].startswith(("world.move", "simulate."))]
    drawn, all_of_it = (sum(p["median_ns"] for p in passes if p["raster"] or every) for every in (False, True))
    if drawn > 0.25 * all_of_it or not row["lookup_ns_per_million"]:
        return None
    return ((0 if baked else row["build_ns"]["median"]) + row["lookup_ns_per_million"]["median"]) / 1e6


def figure(number):
    return "–" if number is None else f"{number:.3g}"


[answer] = json.loads(read("recommend", "answer.json"))
best, by_compute = answer["best"], answer["time"] != "cost"
[own] = [r for r in json.loads(read("recommend", "results.json"))["rows"] if [seen(r), flip(r)] == [best["error"], best["flip"]]][:1]
thorough, seconds = read("thorough", "results.json"), [read(way, "seconds") for way in ("recommend", "thorough")]
share = beaten = "–"
if thorough:
    rows = [r for r in json.loads(thorough)["rows"] if r["status"] == "ok" and seen(r) is not None]
    draws = [r["unshadowed"]["draw_ns"] for r in rows]
    floor = max(max((d["p95"] - d["p05"]) / 2, 0.005 * d["median"]) for d in draws) / 1e6
    points = [(ms(r, by_compute, floor), max(seen(r), 0.001)) for r in rows if r["technique"] != "none"]
    again = [r for r in rows if r["variant"] == own["variant"] and r["technique"] == own["technique"]]
    time, error = (ms(again[0], by_compute, floor), max(seen(again[0]), 0.001)) if again else (None, None)
    beaten = f"{max(min(time / t, error / e) for t, e in points if t):.2f}" if time else "not there"
    share = f"{float(seconds[0]) / float(seconds[1]):.2f}"
spec = f"{own['technique']}:" + ",".join(f"{key}={value}" for key, value in own["variant"].items())
cells = [scene, seconds[0].strip(), (seconds[1] or "–").strip(), share, f"`{spec}`", figure(best["time_ms"])]
print("| " + " | ".join(cells + [figure(best["flip"]), figure(own["unshadowed"]["flip_mean"]), beaten]) + " |")
sys.exit(beaten == "not there")
PYTHON
done
exit $failed
