#!/usr/bin/env python3
"""Small OpenVDB files of known content: `openvdb12.py FOLDER`, with bpy 5.0.1 (PyPI), whose module openvdb is OpenVDB 12.0.0. The tests of
src/scene/files/vdb_file.rs say what is in each."""
import os, sys
import bpy

for path in list(sys.path):  # The module openvdb lies within bpy.
    sys.path.append(os.path.join(path, "bpy/5.0/python/lib/python3.11/site-packages"))
import openvdb as vdb

FOLDER = sys.argv[1]
FOG = vdb.GridClass.FOG_VOLUME


def bead():
    for x in range(3, 10):
        for y in range(2, 9):
            for z in range(6, 13):
                if (x - 6) ** 2 + (y - 5) ** 2 + (z - 9) ** 2 < 12:
                    yield (x, y, z), ((7 * x + 11 * y + 13 * z) % 29 + 1) / 32


def grid(name="density", kind=vdb.FloatGrid, background=0.0, values=None, more=0.0, half=False):
    made = kind(background)
    made.name, made.gridClass, made.saveFloatAsHalf = name, FOG, half
    made.transform = vdb.createLinearTransform(voxelSize=0.25)
    made.transform.postTranslate((1, 2, 3))
    to = made.getAccessor()
    for place, value in bead() if values is None else values:
        to.setValueOn(place, value + more)
    return made


def codes(kind=vdb.FloatGrid, half=False, background=0.25):
    """Leaves with the codes 0 to 6 in a row along x, and tiles."""
    made = kind(background)
    made.name, made.gridClass, made.saveFloatAsHalf = "density", FOG, half
    to = made.getAccessor()
    for code, others in enumerate([[background], [-background], [0.75], [-background, background], [0.75, background],
                                   [0.75, 1.5], [0.75, 1.5, 2.5]]):
        for i in range(512):
            x, y, z = i // 64, i // 8 % 8, i % 8
            place = (8 * code + x, y, z)
            if i % 5 == 0:
                to.setValueOn(place, (i + 1) / 1024)
            else:
                to.setValueOff(place, others[i % len(others)])
    made.fill((64, 0, 0), (71, 7, 7), 3.0, active=True)      # 8 samples wide, like the next
    made.fill((72, 0, 0), (79, 7, 7), 4.0, active=False)
    made.fill((128, 0, 0), (255, 127, 127), 5.0, active=False)  # 128 samples wide
    return made


def write(name, *grids):
    vdb.write(os.path.join(FOLDER, name + ".vdb"), grids=list(grids))


os.makedirs(FOLDER, exist_ok=True)
write("ok-double", grid(kind=vdb.DoubleGrid, more=2**-40, background=0.0))
write("ok-double-as-half", grid(kind=vdb.DoubleGrid, more=2**-40, half=True))
write("ok-background-fog", grid(background=0.25))
write("ok-codes", codes())
write("ok-codes-as-half", codes(half=True))
write("ok-codes-double", codes(kind=vdb.DoubleGrid))

sphere = vdb.createLevelSetSphere(radius=2.5, center=(5, 5.25, 5.5), voxelSize=0.5, halfWidth=3)
sphere.name = "density"
write("bad-level-set-sphere", sphere)

write("ok-same-names", grid(), grid(values=[((1, 2, 3), 0.5)]), grid("temperature", values=[((2, 3, 4), 0.75)]))

first = grid()
second = first.copy()
second.name, second.transform = "moved", vdb.createLinearTransform(voxelSize=2)
write("ok-instance", first, second)
third, fourth = first.copy(), first.copy()
third.transform = vdb.createLinearTransform([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 0.5, 0], [4, 5, 6, 1]])
fourth.saveFloatAsHalf = True  # Not the same way of saving: no instance, its tree is there again.
write("ok-instance-same-name", first, third, fourth)

sheared = grid()
sheared.transform = vdb.createLinearTransform([[0.5, 0, 0, 0], [0.25, 1, 0, 0], [0, 0.125, 2, 0], [7, 8, 9, 1]])
write("ok-sheared", sheared)

tiles = vdb.FloatGrid()
tiles.name, tiles.gridClass, tiles.transform = "density", FOG, vdb.createLinearTransform(voxelSize=1)
tiles.fill((0, 0, 0), (15, 7, 23), 0.5)
tiles.fill((128, 0, 0), (255, 127, 127), 0.75)
tiles.prune()
write("ok-large-tiles", tiles)
