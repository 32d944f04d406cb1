#!/bin/bash
# Holds two editions of the program against each other: `results/before-after.sh BEFORE AFTER FOLDER [answers] [times]`.
#
# `answers`: both measure each path of every technique that the edition before the embeddable core has, in small maps and grids, on smoke,
# hair and houses. Rows whose errors, bytes, counts and picture have the same digits have the same answers: one that is rounded otherwise
# moves the mean of thousands. `times`: no truth, 30 frames, in turns (before, after, before, after …) until BUDGET seconds (130) would be
# over; medians of the rounds are compared. Only on a quiet machine. Without a word of these, both.
# Prints Markdown; rows of both programs are kept in FOLDER, and answers that are there are not measured again. FRAMES and PICTURE (640x360) are those of `times`, ALONE='SCENE SPEC' is all that it measures;
# PARTS are those of `answers`: smoke settings cornell virtual houses.
set -u
before=${1:-} after=${2:-} folder=${3:-}
[ -n "$folder" ] || { sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2 && exit 2; }
shift 3
[ $# -gt 0 ] || set -- answers times
mkdir -p "$folder"

# run PROGRAM OUT ARGUMENT…: a folder of rows. Rows that are refused make it end with failure, and are rows nevertheless.
run() {
    local program=$1 out=$2
    shift 2
    [ ! -e "$out/report.html" ] || return
    "$program" compare "$@" --resume --out "$out" >"$out.txt" 2>&1
    [ -e "$out/report.html" ] || { cat "$out.txt" >&2 && exit 1; }
}

small=(--quick --frames 2 --picture 96x54 --no-skip)
# Each path, then what else decides how curves are built.
smoke=(three-emitters plume_8k hair
    --technique 'avsm:size=32,path=two-pass|interlock|raster-order|binned' --technique 'avsm:size=32,path=two-pass,resolve=whole'
    --technique 'avsm:size=32,path=binned,resolve=streaming|whole|cells'
    --technique 'psm:size=32,slices=64,path=raster|fused'
    --technique 'beer-shadow-map:size=32,path=raster|binned' --technique 'translucency-map:size=32,path=raster|binned'
    --technique 'uncompressed:size=32' --technique 'voxel-grid:size=64,path=compute|raster,march=exact')
settings=(three-emitters
    --technique 'avsm:size=32,path=two-pass|interlock|raster-order,nodes=4|16,curve=linear'
    --technique 'avsm:size=32,path=interlock|raster-order,order=captured,nudge=off'
    --technique 'avsm:size=32,path=two-pass|interlock|raster-order|binned,storage=packed'
    --technique 'avsm:size=32,path=two-pass,filter=box|gaussian' --technique 'avsm:size=32,path=binned,storage=tight'
    --technique 'avsm:size=32,path=binned,resolve=streaming|cells,batch=shared|lanes'
    --technique 'avsm:size=32,path=binned,resolve=cells,fit=plain|refined,nodes=4|16'
    --technique 'avsm:size=32,path=binned,detail=adaptive' --technique 'avsm:size=32,path=binned,texel=area'
    --technique 'avsm:size=32,path=binned,opaque=raster|compute'
    --technique 'psm:size=32,slices=64,path=fused,storage=rgba16f|optical-depth,assign=nearest|split'
    --technique 'psm:size=32,slices=64,path=raster,route=vertex|geometry,coverage=off|viewport|tiles,storage=rgba16f'
    --technique 'translucency-map:size=32,path=raster|binned,storage=r16f'
    --technique 'voxel-grid:size=64,path=compute,march=steps|cone')
# The truth takes longer the coarser a map is: what is near to an edge is looked at more closely.
houses=(houses
    --technique 'shadow-map:size=1024,bits=16|32,opaque=raster' --technique 'shadow-map:size=1024,filter=3,opaque=raster|compute'
    --technique ray-query --technique 'voxel-grid:size=256,path=compute|raster,march=exact' --technique 'voxel-grid:size=256,march=steps|cone'
    --technique 'voxelized:size=1024,structure=svo|dag' --technique voxelized:size=1024,coverage=conservative
    --technique 'voxelized:size=1024,free=exit|entry|shared')
cornell=(cornell --technique 'shadow-map:size=256,opaque=raster|compute' --technique 'shadow-map:size=256,bits=16,opaque=raster' --technique ray-query
    --technique 'voxel-grid:size=64,path=compute|raster')
virtual=(cornell --vpls 64 --technique 'ism:size=32,points=1024,path=tiled|atomic|quads|triangles,adaptive=on|off')

answers() {
    local program=$1 out=$2
    for part in $parts; do
        local -n arguments=$part
        run "$program" "$out-$part" "${arguments[@]}" "${small[@]}"
    done
}

# What a device builds in well under a second, one spec a path.
frames=(--no-truth --frames "${FRAMES:-30}" --picture "${PICTURE:-640x360}" --no-skip)
times() {
    local program=$1 out=$2
    if [ -n "${ALONE:-}" ]; then
        run "$program" "$out-alone" "${ALONE%% *}" "${frames[@]}" --technique "${ALONE#* }"
        return
    fi
    run "$program" "$out-smoke" three-emitters "${frames[@]}" \
        --technique 'avsm:path=two-pass|interlock|raster-order|binned' --technique 'psm:path=raster|fused' \
        --technique 'beer-shadow-map:path=raster|binned' --technique 'translucency-map:path=raster|binned' --technique uncompressed \
        --technique 'voxel-grid:size=128,path=compute|raster'
    run "$program" "$out-meshes" houses "${frames[@]}" --technique shadow-map --technique ray-query \
        --technique 'voxel-grid:size=128,path=compute|raster' --technique voxelized:size=256
    run "$program" "$out-virtual" cornell --vpls 256 "${frames[@]}" --technique 'ism:path=tiled|atomic|quads|triangles,adaptive=off'
}

for what in "$@"; do
    case $what in
    answers)
        parts=${PARTS:-smoke settings cornell virtual houses}
        answers "$before" "$folder/answers-before"
        answers "$after" "$folder/answers-after"
        ;;
    times)
        rm -rf "$folder"/times-*
        parts=${ALONE:+alone} parts=${parts:-smoke meshes virtual} start=$SECONDS round=0
        while [ $round -lt 2 ] || [ $((SECONDS - start + (SECONDS - start) / round)) -lt "${BUDGET:-130}" ]; do
            round=$((round + 1))
            times "$before" "$folder/times-before-$round"
            times "$after" "$folder/times-after-$round"
        done
        ;;
    *)
        echo "$what: answers or times" >&2
        exit 2
        ;;
    esac
    python3 - "$what" "$folder" $parts <<'PYTHON' || exit 1
import glob, hashlib, json, os, statistics, sys

what, folder, *parts = sys.argv[1:]


def rows(run):
    """The rows of a run, by their place: keys of a spec may have been added."""
    found = []
    for part in parts:
        out = os.path.join(folder, f"{run}-{part}")
        with open(os.path.join(out, "results.json")) as file:
            results = json.load(file)
        for row in results["rows"]:
            row["folder"] = out
            row["device"] = results["device"]
            found.append(row)
    return found


def name(before, after):
    """What of a spec the editions have in common and is not a key that all rows have."""
    common = [(key, value) for key, value in before["variant"].items() if after["variant"].get(key) == value]
    return f"{before['scene']} {before['technique']}:" + ",".join(f"{key}={value}" for key, value in common)


def pairs(one, other):
    if [(row["scene"], row["technique"]) for row in one] != [(row["scene"], row["technique"]) for row in other]:
        sys.exit("the two editions have other rows")
    return list(zip(one, other))


def digits(row):
    """All that is no time: status, errors to the last digit, bytes, counts, the picture's bytes."""
    said = {key: row.get(key) for key in ("status", "bytes_resident", "bytes_transient", "bytes_on_disk", "limit_mean_abs")}
    said["counters"] = row.get("counters")
    errors = row.get("error") or {}
    for kind, error in errors.items():
        for key, value in (error or {}).items():
            said[f"{kind}.{key}"] = value
    picture = row.get("picture")
    if isinstance(picture, str):
        with open(os.path.join(row["folder"], picture), "rb") as file:
            said["picture"] = hashlib.sha256(file.read()).hexdigest()
    return said


if what == "answers":
    table, others = {}, []
    for before, after in pairs(rows("answers-before"), rows("answers-after")):
        one, other = digits(before), digits(after)
        # A figure that only one edition knows is no other answer.
        differ = [key for key in one if key in other and one[key] != other[key] and None not in (one[key], other[key])]
        counts = table.setdefault((before["technique"], before["path"]), [0, 0, 0])
        if before["status"] == after["status"] == "refused":
            counts[2] += 1
            continue
        counts[0] += 1
        counts[1] += not differ
        if differ:
            says = ", ".join(f"{key} {one[key]} → {other[key]}" for key in differ)
            others.append(f"- {name(before, after)}: {says}")
    print("| technique | path | rows | same digits | other digits | refused by both |\n|---|---|---|---|---|---|")
    for (technique, path), (count, same, refused) in table.items():
        print(f"| {technique} | {path} | {count} | {same} | {count - same} | {refused} |")
    sums = [sum(counts[i] for counts in table.values()) for i in range(3)]
    print(f"| all | | {sums[0]} | {sums[1]} | {sums[0] - sums[1]} | {sums[2]} |")
    if others:
        print("\n" + "\n".join(others))
else:
    count = len(glob.glob(os.path.join(folder, f"times-after-*-{parts[0]}")))
    runs = {edition: [rows(f"times-{edition}-{i}") for i in range(1, count + 1)] for edition in ("before", "after")}
    device = runs["before"][0][0]["device"]
    print(f"{device.get('name')}, {device.get('driver')}: {count} rounds, in turns\n")
    print("| scene | technique | path | build before, ms | after | change | spread | frame before, ms | after | change |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    slower, changes = [], []

    def medians(edition, place, key):
        """Of each round."""
        found = []
        for run in runs[edition]:
            value = run[place].get(key)
            found.append(value["median"] if isinstance(value, dict) else value)
        return found

    for place, (before, after) in enumerate(pairs(runs["before"][0], runs["after"][0])):
        cells = []
        for key in ("build_ns", "frame_ns"):
            one, other = medians("before", place, key), medians("after", place, key)
            if None in one + other:
                break
            a, b = statistics.median(one), statistics.median(other)
            # By how much medians of the same program differ from round to round.
            spread = max(max(one) / min(one), max(other) / min(other)) - 1
            cells.append((a, b, b / a - 1, spread))
        if len(cells) < 2:
            print(f"| {before['scene']} | {before['technique']} | {before['path']} | {before['status']} | {after['status']} | | | | | |")
            continue
        (a, b, change, spread), (c, d, frame, _) = cells
        path = before["path"] or after["path"]
        print(
            f"| {before['scene']} | {before['technique']} | {path} | {a / 1e6:.4f} | {b / 1e6:.4f} | {100 * change:+.1f} % "
            f"| {100 * spread:.1f} % | {c / 1e6:.4f} | {d / 1e6:.4f} | {100 * frame:+.1f} % |"
        )
        changes.append((change, frame))
        if change > 0.03 + spread:
            slower.append(f"- {before['scene']} {before['technique']} {path}: {100 * change:+.1f} %, spread {100 * spread:.1f} %")
    print(
        f"\nBuild: median change {100 * statistics.median(c for c, _ in changes):+.1f} %, greatest {100 * max(c for c, _ in changes):+.1f} %; "
        f"frame: {100 * statistics.median(f for _, f in changes):+.1f} %, {100 * max(f for _, f in changes):+.1f} %. "
        f"Builds slower by more than 3 % beyond the spread: {len(slower)} of {len(changes)}."
    )
    print("\n".join(slower))
PYTHON
done
