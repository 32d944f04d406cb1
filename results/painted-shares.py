#!/usr/bin/env python3
"""The aims of docs/notebook/painted.md and how far they are met, as a table: `results/painted-shares.py FOLDER`.

FOLDER has the CSVs of `results/measure.sh FOLDER gpu painters painters-meshes painters-720p painters-moving`, and, by a build of
the commit before pictures were painted in compute, those of `results/measure.sh FOLDER gpu before-painters before-painters-meshes
before-painters-720p`. A share is the time of today's passes over the time of that build's passes, each the median.
"""
import csv
import sys

# Passes of the picture before: casters, and meshes.
CASTERS, MESHES = ["consume.caster", "consume.volume"], ["consume.forward", "consume.visible"]
SORT = ["far_to_near", "order."]


def rows(name):
    with open(f"{sys.argv[1]}/{name}.csv", newline="") as file:
        return [row for row in csv.DictReader(file) if row["status"] == "ok"]


def passes(row, column="draw_pass_median_ns"):
    return {name: float(ns) for name, ns in (item.split("=") for item in row[column].split())}


def find(name, scene, technique, painter=None):
    found = [
        row
        for row in rows(name)
        if row["scene"] == scene and row["technique"] == technique and painter in (None, row.get("painter"))
    ]
    assert len(found) == 1, f"{name}: {len(found)} rows of {technique} in {scene}"
    return passes(found[0]), found[0]


def of(times, names):
    return sum(ns for name, ns in times.items() if any(part in name for part in names))


def is_mesh(name):
    return name.startswith("picture.") or name == "painter.shade"


def casters(scene, sorted_before=True):
    """Earlier the sort by distance was not in the frame; a row that is drawn today has that sort alone."""
    before, _ = find("before-painters", scene, "avsm")
    drawn, _ = find("painters", scene, "avsm", "raster")
    now, _ = find("painters", scene, "avsm", "compute")
    sort = of(drawn, SORT) if sorted_before else 0
    return of(before, CASTERS) / 1e6, (sum(ns for name, ns in now.items() if not is_mesh(name)) - sort) / 1e6


def meshes(scene, names=MESHES, name="painters-meshes", technique="voxel-grid", only=None):
    before, _ = find(f"before-{name}", scene, technique)
    now, _ = find(name, scene, technique, "compute")
    return of(before, names) / 1e6, sum(ns for part, ns in now.items() if is_mesh(part) and (only is None or part.startswith(only))) / 1e6


def line(what, aim, before, now):
    share = now / before
    print(f"| {what} | {before:.3g} | {now:.3g} | {aim:g} | {share:.3f}{'' if share <= aim else ' **misses**'} |")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print("| what | before, ms | now, ms | aim | share |\n|---|---|---|---|---|")
    for scene, aim in [("plume_8k", 0.1), ("three-emitters", 0.1), ("plume_64k", 0.1), ("hair", 0.15), ("plume-1m", 0.08)]:
        line(f"casters of {scene}, with lists, parts and their sort", aim, *casters(scene))
    # The sort of a million took 3.1 ms.
    before, now = casters("splats-1000000", sorted_before=False)
    line("a million splats, with their sort in both", 0.06, before + 3.1, now)
    line("casters of big-8k under 32 lights", 0.1, *casters("big-8k-32"))
    line("cells of cloud", 0.15, *casters("cloud"))
    for scene, aim in [("houses", 0.06), ("courtyard-32", 0.05), ("town", 0.03)]:
        line(f"meshes of {scene}", aim, *meshes(scene))
    for scene, aim in [("town", 0.15), ("cornell", 0.25)]:
        line(f"triangles that pixels of {scene} see, 720p", aim, *meshes(scene, ["consume.visible"], "painters-720p", "none", "picture."))
    _, row = find("painters", "plume-1m", "avsm", "raster")
    line("sorting a million casters by distance", 0.15, 3.1, of(passes(row), SORT) / 1e6)
    _, moving = find("painters-moving", "three-emitters", "avsm", "compute")
    print(f"| a frame of three-emitters in motion | – | {float(moving['frame_ns']) / 1e6:.3f} | 0.6 ms | |")


main()
