#!/usr/bin/env python3
"""Makes a tree with leaf cards in Blender and exports it as glTF, to see what Blender's exporter writes for alpha.

    python3.11 -m venv /tmp/blender && /tmp/blender/bin/pip install bpy==4.5.15
    /tmp/blender/bin/python results/blender-tree.py tree.glb [mask|blend]

bpy 4.5 needs Python 3.11, and brings numpy. With `mask`, the default, leaves are cut out where their alpha is below the cutoff; with `blend`,
the same alpha mixes them with what is behind. After the export, the script prints the alpha mode, cutoff, images and triangles in the file.
"""

import json
import math
import random
import struct
import sys

import bpy
import numpy as np
from mathutils import Vector

SIDE = 64  # texels per side of the leaf's picture
CUTOFF = 0.4
BOUGHS = 40
CARDS = 6_000
CARD = 0.14  # width and height of a card


def leaf_picture():
    """Paints a pointed leaf: green, with an alpha that falls from 1 to 0 within a texel of its edge."""
    row, column = (np.mgrid[0:SIDE, 0:SIDE] + 0.5) / SIDE
    across = np.abs(column - 0.5)
    depth = 1.3 * row * (1.0 - row) - 0.03 - across
    pixels = np.empty((SIDE, SIDE, 4), np.float32)
    pixels[:] = (0.2, 0.42, 0.1, 1.0)
    pixels[across < 0.012] = (0.32, 0.5, 0.2, 1.0)
    pixels[..., 3] = np.clip(0.5 + SIDE * depth, 0.0, 1.0)
    image = bpy.data.images.new("leaf", SIDE, SIDE, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def material(name, color):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = color
    return made, made.node_tree, shader


def math_node(tree, operation, inputs):
    """Adds a node that calculates with numbers and sockets, and returns its result."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, inputs):
        if isinstance(value, float):
            socket.default_value = value
        else:
            tree.links.new(value, socket)
    return node.outputs["Value"]


def leaf_material(mode):
    """Connects the picture's color and alpha. The exporter takes `1 - (alpha < cutoff)` for a cutoff, and other alpha for blending."""
    made, tree, shader = material("leaf", (1.0, 1.0, 1.0, 1.0))
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = leaf_picture()
    texture.extension = "EXTEND"
    alpha = texture.outputs["Alpha"]
    if mode == "mask":
        alpha = math_node(tree, "SUBTRACT", [1.0, math_node(tree, "LESS_THAN", [alpha, CUTOFF])])
    tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(alpha, shader.inputs["Alpha"])
    return made


def in_ball(dice):
    while True:
        point = Vector(dice.uniform(-1.0, 1.0) for _ in range(3))
        if point.length <= 1.0:
            return point


def wood(dice):
    """Builds a trunk and boughs as curves with thickness, and returns the object and the boughs' ends."""
    curve = bpy.data.curves.new("wood", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution, curve.resolution_u = "3D", 0.15, 1, 3
    middle = Vector((0.0, 0.0, 3.4))
    ends = [middle + 1.4 * 0.5 * (point + point.normalized()) for point in (in_ball(dice) for _ in range(BOUGHS))]
    starts = [Vector((0.0, 0.0, dice.uniform(1.6, 3.2))) for _ in ends]
    branch(curve, [(Vector((0.0, 0.0, -0.2)), 1.3), (Vector((0.05, 0.0, 1.5)), 0.8), (Vector((0.0, 0.0, 3.4)), 0.2)])
    for start, end in zip(starts, ends):
        bend = start.lerp(end, 0.5) - Vector((0.0, 0.0, 0.15))
        branch(curve, [(start, 0.25), (bend, 0.16), (end, 0.05)])
    curve.materials.append(material("bark", (0.24, 0.16, 0.1, 1.0))[0])
    return bpy.data.objects.new("wood", curve), ends


def branch(curve, path):
    spline = curve.splines.new("POLY")
    spline.points.add(len(path) - 1)
    for point, (place, radius) in zip(spline.points, path):
        point.co, point.radius = (*place, 1.0), radius


def leaves(dice, ends, mode):
    """Builds a square card per leaf, in clumps around the boughs' ends."""
    corners = []
    for i in range(CARDS):
        stem = ends[i % len(ends)] + 0.45 * in_ball(dice)
        along = in_ball(dice).normalized()
        across = along.cross(in_ball(dice)).normalized()
        corners += [stem + CARD * (u * across + v * along) for u, v in [(-0.5, 0), (0.5, 0), (0.5, 1), (-0.5, 1)]]
    mesh = bpy.data.meshes.new("leaves")
    mesh.from_pydata(corners, [], [range(4 * i, 4 * i + 4) for i in range(CARDS)])
    mesh.uv_layers.new().data.foreach_set("uv", [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0] * CARDS)
    mesh.materials.append(leaf_material(mode))
    return bpy.data.objects.new("leaves", mesh)


def export(path):
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.rotation_euler = (math.radians(35), math.radians(20), 0.0)
    bpy.context.scene.collection.objects.link(sun)
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLB", export_lights=True)


def say(path):
    """Prints what the file says about alpha."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    print(document["asset"]["generator"], document.get("extensionsUsed"))
    for made in document["materials"]:
        texture = made["pbrMetallicRoughness"].get("baseColorTexture")
        print(made["name"], made.get("alphaMode", "OPAQUE"), made.get("alphaCutoff"), made.get("doubleSided"), texture)
    print(document["images"], document["textures"], document["samplers"])
    for mesh in document["meshes"]:
        counts = [document["accessors"][part["indices"]]["count"] // 3 for part in mesh["primitives"]]
        print(mesh["name"], sum(counts), "triangles", list(mesh["primitives"][0]["attributes"]))


def main():
    path, mode = sys.argv[1], (sys.argv[2:] or ["mask"])[0]
    if mode not in ("mask", "blend"):
        sys.exit(f"{mode}: give mask or blend")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    dice = random.Random(7)
    trunk, ends = wood(dice)
    for made in (trunk, leaves(dice, ends, mode)):
        bpy.context.scene.collection.objects.link(made)
    export(path)
    say(path)


main()
