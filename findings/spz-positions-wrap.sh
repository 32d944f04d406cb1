#!/bin/bash
# What becomes of splats farther than 2,048 from the origin in an SPZ file.
#
# One would guess that positions beyond the format's range are clamped to its end, or that the writer says that they do not fit, or chooses
# fewer bits for the fraction, which the header has a byte for. None of these: they wrap around, in versions 3 and 4, without a word. A
# splat at 3,000 comes back at -1,096, inside the scene, and one at 600,000 beside the origin. The same splats in .sog come back where
# they were.
#
# So a capture in metres of a large site, or in centimetres, loses its far splats into its middle, and no reader can tell. Ours notes the
# few that come to lie on the very end.
#
# Needs Node 20, Python 3 and network; downloads about 60 MB into a temporary folder.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --ignore-scripts @playcanvas/splat-transform@3.7.0 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat >make.py <<'PYTHON'
import struct

names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
places = [0.0, 100.0, 2047.5, 2048.0, 3000.0, -3000.0, 600000.0]
with open("far.ply", "wb") as out:
    head = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(places)
    out.write((head + "".join("property float %s\n" % name for name in names) + "end_header\n").encode())
    for x in places:
        out.write(struct.pack("<14f", x, 1, 2, 0, 0, 0, 1, -3, -3, -3, 1, 0, 0, 0))
PYTHON
python3 make.py
transform() { node node_modules/@playcanvas/splat-transform/bin/cli.mjs -w -q "$@"; }
transform far.ply 4.spz
transform far.ply --spz-version 3 3.spz
transform -g cpu far.ply far.sog
echo "splat-transform $(node -p 'require("./node_modules/@playcanvas/splat-transform/package.json").version')"
found=
for file in far.ply 3.spz 4.spz far.sog; do
    transform "$file" back.csv
    line="$file: $(python3 - <<'PYTHON'
import csv

rows = list(csv.DictReader(open("back.csv")))
print(" ".join("%.0f" % x for x in sorted(float(row["x"]) for row in rows)))
PYTHON
)"
    echo "$line"
    found="$found$line
"
done
expected='far.ply: -3000 0 100 2048 2048 3000 600000
3.spz: -2048 -1096 -0 0 100 1096 2048
4.spz: -2048 -1096 -0 0 100 1096 2048'
[ "$(echo "$found" | head -n3)" = "$expected" ] || { echo "this has changed"; exit 1; }
