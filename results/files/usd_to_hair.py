"""USD's BasisCurves to Cem Yuksel's .hair: `python usd_to_hair.py in.usd out.hair`, after `pip install usd-core==25.11 numpy==1.26.4`. World space, first time, control points."""
import sys, numpy as np
from pxr import Usd, UsdGeom
stage, now, points, widths, counts = Usd.Stage.Open(sys.argv[1]), Usd.TimeCode.EarliestTime(), [], [], []
for prim in filter(lambda prim: prim.IsA(UsdGeom.BasisCurves), stage.Traverse(Usd.TraverseInstanceProxies())):
    curves, world = UsdGeom.BasisCurves(prim), np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(now))
    each, wide = np.array(curves.GetCurveVertexCountsAttr().Get(now), int), np.array(curves.GetWidthsAttr().Get(now) or [0])
    wide = np.repeat(wide, each) if len(wide) == len(each) else np.resize(wide, each.sum()) if len(wide) in (1, each.sum()) else sys.exit(f"{prim.GetPath()}: {len(wide)} widths")
    counts.append(each), widths.append(wide * abs(np.linalg.det(world[:3, :3])) ** (1 / 3))
    points.append(np.array(curves.GetPointsAttr().Get(now), float) @ world[:3, :3] + world[3, :3])
counts, widths, points = map(np.concatenate, (counts, widths, points) if counts else sys.exit("no BasisCurves"))
with open(sys.argv[2], "wb") as file:  # Segments of each hair, points and widths; nothing else.
    file.write(b"HAIR" + np.array([len(counts), len(points), 7, 0], "<u4").tobytes() + np.zeros(5, "<f4").tobytes() + bytes(88))
    file.write((counts - 1).astype("<u2").tobytes() + points.astype("<f4").tobytes() + widths.astype("<f4").tobytes())
print(len(counts), "hairs,", len(points), "points, widths", widths.min(), "to", widths.max(), "up:", UsdGeom.GetStageUpAxis(stage))
