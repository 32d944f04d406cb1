#!/bin/bash
# What bounds a file has after gltf-pipeline's Draco compression without quantized positions.
#
# One would guess that --draco.quantizePositionBits 0, which keeps positions exact, leaves the accessor's min and max as they were, or makes
# them anew: glTF requires both for POSITION. They are written as null instead, once per number, while 11 bits keep them. The file still
# decodes to the exact positions, but a reader that checks its JSON against the schema, or places the camera by the bounds, refuses it or
# divides by nothing.
#
# So bounds of positions are not to be trusted, nor to be required. Ours computes what it needs from the positions.
#
# Needs Node 20 and network; downloads about 60 MB into a temporary folder.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund gltf-pipeline@4.3.1 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat >make.mjs <<'JS'
// A grid of 5 by 5 vertices as a glTF file.
import { writeFileSync } from "node:fs";
const places = [], indices = [];
for (let row = 0; row < 5; row++) for (let column = 0; column < 5; column++) places.push(column, (row * column) % 3, row);
for (let row = 0; row < 4; row++)
    for (let column = 0; column < 4; column++) {
        const a = row * 5 + column;
        indices.push(a, a + 5, a + 1, a + 1, a + 5, a + 6);
    }
const floats = Buffer.from(Float32Array.from(places).buffer), shorts = Buffer.from(Uint16Array.from(indices).buffer);
const data = Buffer.concat([floats, shorts]);
writeFileSync("grid.gltf", JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
        { bufferView: 0, componentType: 5126, count: 25, type: "VEC3", min: [0, 0, 0], max: [4, 2, 4] },
        { bufferView: 1, componentType: 5123, count: indices.length, type: "SCALAR" },
    ],
    bufferViews: [{ buffer: 0, byteLength: floats.length, target: 34962 }, { buffer: 0, byteOffset: floats.length, byteLength: shorts.length, target: 34963 }],
    buffers: [{ byteLength: data.length, uri: "data:application/octet-stream;base64," + data.toString("base64") }],
}));
JS
node make.mjs
echo "gltf-pipeline $(node -p 'require("./node_modules/gltf-pipeline/package.json").version')"
found=
for bits in 11 0; do
    node_modules/.bin/gltf-pipeline -i grid.gltf -o "$bits.gltf" -d --draco.quantizePositionBits "$bits" >/dev/null
    line="$bits bits: $(node -e '
        const json = JSON.parse(require("fs").readFileSync(process.argv[1]));
        const { min, max } = json.accessors[json.meshes[0].primitives[0].attributes.POSITION];
        const text = (bound) => JSON.stringify(bound?.map((number) => (number === null ? null : Math.round(number))));
        console.log("min " + text(min) + ", max " + text(max));
    ' "$bits.gltf")"
    echo "$line"
    found="$found$line
"
done
expected='11 bits: min [0,0,0], max [4,2,4]
0 bits: min [null,null,null], max [null,null,null]'
[ "$(echo "$found" | head -n2)" = "$expected" ] || { echo "this has changed"; exit 1; }
