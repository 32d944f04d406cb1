#!/bin/bash
# Which of Blender's settings make the leaves of a glTF file cut out (MASK) and which make them see-through (BLEND).
#
# One would guess that a material whose blend method is CLIP, with a threshold of 0.3, is exported as MASK with a cutoff of 0.3, and
# that a texture of nothing but 0 and 1 is not blended at all. Neither counts: the exporter looks at the shader's nodes alone. A plain link
# from the texture's alpha is BLEND, whatever the material's settings and the texels are; a node Math > Round makes it MASK, and the file
# then has no cutoff (glTF's default, 0.5); Math > Greater Than makes it MASK with that number as the cutoff.
#
# So a program that shadows what Blender exports must not take BLEND for glass: leaves come that way too. Ours has `cutout = 0.5` in a
# scene file for them (docs/reference/scenes.md).
#
# Needs Python 3.11 (PYTHON, by default python3.11) and network; downloads about 350 MB into a temporary folder.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3.11}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check bpy==4.5.15
cat >"$folder/export.py" <<'PYTHON'
import json
import sys

import bpy

CASES = ["plain link", "plain link, CLIP at 0.3", "plain link, dithered", "Math > Round", "Math > Greater Than 0.3"]


def material(image, case):
    made = bpy.data.materials.new(case)
    made.use_nodes = True
    tree = made.node_tree
    shader = tree.nodes["Principled BSDF"]
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    alpha = texture.outputs["Alpha"]
    if case.startswith("Math"):
        node = tree.nodes.new("ShaderNodeMath")
        node.operation = "ROUND" if "Round" in case else "GREATER_THAN"
        tree.links.new(alpha, node.inputs[0])
        node.inputs[1].default_value = 0.3
        alpha = node.outputs[0]
    tree.links.new(alpha, shader.inputs["Alpha"])
    if "CLIP" in case:
        made.blend_method = "CLIP"
        made.alpha_threshold = 0.3
    if "dithered" in case:
        made.surface_render_method = "DITHERED"
    return made


bpy.ops.wm.read_factory_settings(use_empty=True)
image = bpy.data.images.new("leaf", 4, 4, alpha=True)
image.pixels = [value for i in range(16) for value in (0.2, 0.5, 0.1, float(i % 2))]
image.pack()
for case in CASES:
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.data.materials.append(material(image, case))
path = sys.argv[1]
bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE")
document = json.load(open(path))
print("Blender", bpy.app.version_string, "-", document["asset"]["generator"])
for made in document["materials"]:
    print(f"{made['name']}: {made.get('alphaMode', 'OPAQUE')} {made.get('alphaCutoff', 'without a cutoff')}")
PYTHON
"$folder/venv/bin/python" "$folder/export.py" "$folder/leaf.gltf" >"$folder/all"
grep -E "^Blender|: (OPAQUE|MASK|BLEND) " "$folder/all" | tee "$folder/said"
expected="plain link: BLEND without a cutoff
plain link, CLIP at 0.3: BLEND without a cutoff
plain link, dithered: BLEND without a cutoff
Math > Round: MASK without a cutoff
Math > Greater Than 0.3: MASK 0.30000001192092896"
if [ "$(grep -v ^Blender "$folder/said" | sort)" = "$(sort <<<"$expected")" ]; then
    echo "as found"
else
    echo "it has changed" >&2
    exit 1
fi
