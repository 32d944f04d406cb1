#!/usr/bin/env python3
"""Sixteen frames of a puff of smoke that rises, grows and turns, as OpenVDB: `puff.py FOLDER` writes puff.0001.vdb to puff.0016.vdb and puff.toml, which has them over a ground."""
import math, os, sys
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from vdb import File

FRAMES, WIDE, HIGH = 16, 32, 48
SCENE = """# A puff of smoke over a ground, written by puff.py beside this file.
[[volumes]]
file = "puff.####.vdb"
extinction = 3.0

[[meshes]]
file = "floor.ply"
scale = 40.0
rotate = [1.0, 0.0, 0.0, 90.0]
translate = [4.0, 4.0, 0.0]

[light]
kind = "directional"
direction = [0.45, 0.2, -0.87]

[camera]
position = [-4.0, -5.5, 7.0]
target = [4.6, 4.0, 4.4]
up = [0.0, 0.0, 1.0]
fov_y_degrees = 50.0
"""


def density(x, y, z, number):
    """At a sample of a frame, counted from 0: a ball that wears off towards its side, and lumps that turn about its axis."""
    t = number / (FRAMES - 1)
    x, y, z = x - 0.5 * WIDE, y - 0.5 * WIDE, z - (12 + 18 * t)
    reach = 8 + 5 * t
    off = math.sqrt(x * x + y * y + z * z) / reach
    if off >= 1.0:
        return 0.0
    angle = 1.2 * t + 0.05 * z
    u, v = x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle)
    lumps = math.sin(0.9 * u) * math.sin(0.8 * v + 0.4 * z) + 0.6 * math.sin(0.7 * z - 0.5 * u + 2.0 * t)
    return max(0.0, (1.0 - off) * (0.7 + 0.6 * lumps))


def frame(number):
    places = ((x, y, z) for x in range(WIDE) for y in range(WIDE) for z in range(HIGH))
    values = {place: density(*place, number) for place in places}
    return {place: value for place, value in values.items() if value > 0.0}


if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) == 2 else sys.exit(__doc__)
    os.makedirs(folder, exist_ok=True)
    for number in range(FRAMES):
        with open(os.path.join(folder, "puff.%04d.vdb" % (number + 1)), "wb") as file:
            file.write(File(frame(number), move=(0.0, 0.0, 0.0)).bytes())
    with open(os.path.join(folder, "puff.toml"), "w") as file:
        file.write(SCENE)
