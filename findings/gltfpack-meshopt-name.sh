#!/bin/bash
# Which extension gltfpack's compression settings write, and which of them gltf-transform can undo.
#
# One would guess that gltfpack's -c, -cc and -cz differ in how hard they compress and name one extension, and that `gltf-transform cp`,
# which most answers recommend to decompress a file, undoes each. -cz writes another extension: KHR_meshopt_compression, not
# EXT_meshopt_compression, and `gltf-transform cp` refuses such a file. What undoes it is gltfpack itself, with -noq.
#
# So a program that refuses compressed files must not send people to gltf-transform for all of them; and one that knows the EXT name alone
# cannot read what -cz makes. Ours decodes both.
#
# Needs Node 20 and network; downloads about 150 MB into a temporary folder.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund gltfpack@1.3.0 @gltf-transform/cli@4.5.1 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat >make.mjs <<'JS'
// A grid of 9 by 9 vertices as a glTF file.
import { writeFileSync } from "node:fs";
const places = [], indices = [];
for (let row = 0; row < 9; row++) for (let column = 0; column < 9; column++) places.push(column, Math.sin(row + column), row);
for (let row = 0; row < 8; row++)
    for (let column = 0; column < 8; column++) {
        const a = row * 9 + column;
        indices.push(a, a + 9, a + 1, a + 1, a + 9, a + 10);
    }
const floats = Buffer.from(Float32Array.from(places).buffer), shorts = Buffer.from(Uint16Array.from(indices).buffer);
const data = Buffer.concat([floats, shorts]);
const axis = (i) => places.filter((_, at) => at % 3 === i);
writeFileSync("grid.gltf", JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
        { bufferView: 0, componentType: 5126, count: 81, type: "VEC3", min: [0, 1, 2].map((i) => Math.min(...axis(i))), max: [0, 1, 2].map((i) => Math.max(...axis(i))) },
        { bufferView: 1, componentType: 5123, count: indices.length, type: "SCALAR" },
    ],
    bufferViews: [{ buffer: 0, byteLength: floats.length }, { buffer: 0, byteOffset: floats.length, byteLength: shorts.length }],
    buffers: [{ byteLength: data.length, uri: "data:application/octet-stream;base64," + data.toString("base64") }],
}));
JS
node make.mjs
required() {
    node -e '
        const bytes = require("fs").readFileSync(process.argv[1]);
        const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
        console.log((json.extensionsRequired ?? []).filter((name) => name.includes("meshopt")).join(" ") || "none");
    ' "$1"
}
echo "gltfpack $(node_modules/.bin/gltfpack -h 2>&1 | grep -om1 '[0-9.]*[0-9]') (npm 1.3.0), gltf-transform $(node_modules/.bin/gltf-transform --version 2>&1 | tail -n1)"
found=
for setting in c cc cz; do
    node_modules/.bin/gltfpack -i grid.gltf -o "$setting.glb" "-$setting" >/dev/null
    if node_modules/.bin/gltf-transform cp "$setting.glb" "plain-$setting.glb" >cp.log 2>&1; then
        undone="$(required "plain-$setting.glb")"
    else
        undone="refused: $(grep -ohim1 'missing required extension[^.]*' cp.log)"
    fi
    line="-$setting: $(required "$setting.glb"); after gltf-transform cp: $undone"
    echo "$line"
    found="$found$line
"
done
node_modules/.bin/gltfpack -i cz.glb -o plain.glb -noq >/dev/null
line="-cz after gltfpack -noq: $(required plain.glb)"
echo "$line"
found="$found$line"
expected='-c: EXT_meshopt_compression; after gltf-transform cp: none
-cc: EXT_meshopt_compression; after gltf-transform cp: none
-cz: KHR_meshopt_compression; after gltf-transform cp: refused: Missing required extension
-cz after gltfpack -noq: none'
[ "$(echo "$found" | sed 's/\(extension\).*"KHR.*/\1/')" = "$expected" ] || { echo "this has changed"; exit 1; }
