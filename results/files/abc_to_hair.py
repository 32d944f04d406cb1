"""Alembic's curves to Cem Yuksel's .hair: `python abc_to_hair.py in.abc out.hair`, with Python 3.11 after `pip install bpy==5.0.1`. World space, z up, first frame, control points."""
import bpy, sys, numpy as np
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.alembic_import(filepath=sys.argv[1], as_background_job=False)
points, widths, counts, graph = [], [], [], bpy.context.evaluated_depsgraph_get()
for found in (each.evaluated_get(graph) for each in bpy.data.objects if each.type == "CURVES"):
    get = lambda name, kind, wide: np.array([getattr(item, kind) for item in found.data.attributes[name].data], float).reshape(-1, wide)
    world = np.array(found.matrix_world)
    counts.append([curve.points_length for curve in found.data.curves])
    points.append(get("position", "vector", 3) @ world[:3, :3].T + world[:3, 3])
    radius = get("radius", "value", 1)[:, 0] if "radius" in found.data.attributes else np.zeros(sum(counts[-1]))
    widths.append(2 * radius * abs(np.linalg.det(world[:3, :3])) ** (1 / 3))
counts, widths, points = map(np.concatenate, (counts, widths, points) if counts else sys.exit("no curves"))
with open(sys.argv[2], "wb") as file:  # Segments of each hair, points and widths; nothing else.
    file.write(b"HAIR" + np.array([len(counts), len(points), 7, 0], "<u4").tobytes() + np.zeros(5, "<f4").tobytes() + bytes(88))
    file.write((counts - 1).astype("<u2").tobytes() + points.astype("<f4").tobytes() + widths.astype("<f4").tobytes())
print(len(counts), "hairs,", len(points), "points, widths", widths.min(), "to", widths.max())
