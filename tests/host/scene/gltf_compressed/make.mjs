// Makes the glTF test files: `npm install && node make.mjs OUT_DIRECTORY`. The tools' versions are in package.json.
// plain.glb has two meshes by the formulas of `sheet` and `column`; the other files are made from it by the tools.
import { execFileSync } from "node:child_process";
import { mkdirSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { MeshoptDecoder, MeshoptEncoder } from "meshoptimizer";

const out = process.argv[2] ?? "out";
mkdirSync(out, { recursive: true });

const FLOAT = 5126, BYTE = 5121, SHORT = 5123;

class Document {
    json = { asset: { version: "2.0", generator: "make.mjs" }, scene: 0, scenes: [{ nodes: [] }], nodes: [], meshes: [],
        accessors: [], bufferViews: [], buffers: [] };
    bytes = [];
    length = 0;

    view(data, more = {}) {
        const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
        this.json.bufferViews.push({ buffer: 0, byteOffset: this.length, byteLength: bytes.length, ...more });
        const padding = (4 - bytes.length % 4) % 4;
        this.bytes.push(bytes, Buffer.alloc(padding));
        this.length += bytes.length + padding;
        return this.json.bufferViews.length - 1;
    }

    accessor(data, type, componentType, more = {}) {
        const size = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 }[type];
        const count = data.length / size;
        const column = (i) => Array.from(data).filter((_, at) => at % size === i);
        const bounds = componentType === FLOAT && type === "VEC3"
            ? { min: [0, 1, 2].map((i) => Math.min(...column(i))), max: [0, 1, 2].map((i) => Math.max(...column(i))) }
            : {};
        this.json.accessors.push({ bufferView: this.view(data), type, componentType, count, ...bounds, ...more });
        return this.json.accessors.length - 1;
    }

    save(path) {
        const bin = Buffer.concat(this.bytes);
        this.json.buffers = [{ byteLength: bin.length }, ...this.json.buffers.slice(1)];
        let text = JSON.stringify(this.json);
        text += " ".repeat((4 - Buffer.byteLength(text) % 4) % 4);
        const head = (size, kind) => Buffer.from(Uint32Array.of(size, kind).buffer);
        const json = Buffer.from(text);
        writeFileSync(path, Buffer.concat([Buffer.from("glTF"), head(2, 12 + 8 + json.length + 8 + bin.length),
            head(json.length, 0x4e4f534a), json, head(bin.length, 0x004e4942), bin]));
    }
}

// Triangles of a grid of columns * rows vertices.
function grid(columns, rows) {
    const indices = [];
    for (let row = 0; row + 1 < rows; row++) {
        for (let column = 0; column + 1 < columns; column++) {
            const a = row * columns + column;
            indices.push(a, a + 1, a + columns, a + 1, a + columns + 1, a + columns);
        }
    }
    return Uint16Array.from(indices);
}

function each(columns, rows, of) {
    const all = [];
    for (let row = 0; row < rows; row++) {
        for (let column = 0; column < columns; column++) all.push(...of(column / (columns - 1), row / (rows - 1)));
    }
    return all;
}

// A wavy sheet: (3u, sin(6u) cos(4v) / 3, 2v), with texture coordinates (u, v) and the color (u, v, 1 - u, 1).
function sheet(document) {
    const [columns, rows] = [13, 9];
    const normal = (u, v) => {
        const [x, z] = [-2 / 3 * Math.cos(6 * u) * Math.cos(4 * v), 2 / 3 * Math.sin(6 * u) * Math.sin(4 * v)];
        const length = Math.hypot(x, 1, z);
        return [x / length, 1 / length, z / length];
    };
    const position = (u, v) => [3 * u, Math.sin(6 * u) * Math.cos(4 * v) / 3, 2 * v];
    const attributes = {
        POSITION: document.accessor(Float32Array.from(each(columns, rows, position)), "VEC3", FLOAT),
        NORMAL: document.accessor(Float32Array.from(each(columns, rows, normal)), "VEC3", FLOAT),
        TEXCOORD_0: document.accessor(Float32Array.from(each(columns, rows, (u, v) => [u, v])), "VEC2", FLOAT),
        COLOR_0: document.accessor(
            Uint8Array.from(each(columns, rows, (u, v) => [255 * u, 255 * v, 255 * (1 - u), 255])), "VEC4", BYTE, { normalized: true }),
    };
    const indices = document.accessor(grid(columns, rows), "SCALAR", SHORT);
    document.json.meshes.push({ primitives: [{ attributes, indices, material: 0 }] });
    document.json.materials = [{ pbrMetallicRoughness: { baseColorFactor: [1, 0.5, 0.25, 1] } }];
    const rotation = [0, Math.SQRT1_2, 0, Math.SQRT1_2];
    document.json.nodes.push({ mesh: 0, translation: [0, 1, 0], rotation, scale: [2, 2, 2] });
    document.json.scenes[0].nodes.push(document.json.nodes.length - 1);
}

// A column around the y axis, 4 high, between two joints: the upper one is at height 2, turned by a quarter about z. A
// morph target of weight 1/2 widens it by twice its height.
function column(document) {
    const [columns, rows] = [9, 9];
    const round = (u, radius, height) => {
        const angle = 2 * Math.PI * u;
        return [radius * Math.cos(angle), height, radius * Math.sin(angle)];
    };
    const floats = (of, type) => document.accessor(Float32Array.from(each(columns, rows, of)), type, FLOAT);
    const attributes = {
        POSITION: floats((u, v) => round(u, 0.5, 4 * v), "VEC3"),
        JOINTS_0: document.accessor(Uint8Array.from(each(columns, rows, () => [0, 1, 0, 0])), "VEC4", BYTE),
        WEIGHTS_0: floats((u, v) => [1 - v, v, 0, 0], "VEC4"),
    };
    const target = floats((u, v) => round(u, 2 * v, 0), "VEC3");
    const indices = document.accessor(grid(columns, rows), "SCALAR", SHORT);
    const inverse = (height) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -height, 0, 1];
    const binds = document.accessor(Float32Array.from([...inverse(0), ...inverse(2)]), "MAT4", FLOAT);
    const primitives = [{ attributes, indices, targets: [{ POSITION: target }] }];
    document.json.meshes.push({ primitives, weights: [0.5] });
    const first = document.json.nodes.length;
    document.json.nodes.push({ mesh: 1, skin: 0 }, { children: [first + 2] },
        { translation: [0, 2, 0], rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] });
    document.json.skins = [{ joints: [first + 1, first + 2], inverseBindMatrices: binds }];
    document.json.scenes[0].nodes.push(first, first + 1);
}

const plain = join(out, "plain.glb");
const document = new Document();
sheet(document);
column(document);
document.save(plain);

// Draco files of gltf-pipeline keep only what it knows; a still mesh alone is enough.
const still = join(out, "still.glb");
const alone = new Document();
sheet(alone);
alone.save(still);

const tools = join(import.meta.dirname, "node_modules/.bin");
const tool = (name, ...args) => execFileSync(join(tools, name), args, { stdio: "pipe" });
const pack = (name, ...args) => tool("gltfpack", "-i", plain, "-o", join(out, name), "-kv", ...args);
pack("pack_c.glb", "-c");
pack("pack_cc.glb", "-cc");
pack("pack_cz.glb", "-cz");
pack("pack_cc_float.glb", "-cc", "-noq");
pack("pack_cc_exponential.glb", "-cc", "-ce", "khr", "-vpf", "-vtf", "-vnf");
pack("pack_c_fallback.gltf", "-c", "-cf");
pack("pack_quantized.glb");

const transform = (...args) => tool("gltf-transform", ...args);
transform("meshopt", plain, join(out, "transform_medium.glb"), "--level", "medium");
transform("meshopt", plain, join(out, "transform_high.glb"), "--level", "high");
transform("draco", plain, join(out, "draco_edgebreaker.glb"));
transform("draco", plain, join(out, "draco_valence.glb"), "--encode-speed", "0", "--decode-speed", "0");
transform("draco", plain, join(out, "draco_sequential.glb"), "--method", "sequential");
tool("gltf-pipeline", "-i", still, "-o", join(out, "draco_pipeline.glb"), "-d", "--draco.quantizePositionBits", "0");

// codec.glb: compressed views of each mode, filter and version, each with the plain bytes after it as meshoptimizer
// decodes them. Views without a filter have no plain bytes: byte k of their element i is (i * i * (k % 5) + 7 * k) >>
// (k % 4), their indices are those of a grid of 9 columns.
await MeshoptEncoder.ready;
await MeshoptDecoder.ready;
const codec = new Document();
function store(bytes, count, stride, mode, version, filter) {
    const stream = MeshoptEncoder.encodeGltfBuffer(bytes, count, stride, mode, version);
    const view = codec.view(stream);
    const { byteOffset, byteLength } = codec.json.bufferViews[view];
    const extension = { buffer: 0, byteOffset, byteLength, byteStride: stride, count, mode, filter };
    Object.assign(codec.json.bufferViews[view], { buffer: 1, byteOffset: 0, byteLength: count * stride,
        extensions: { KHR_meshopt_compression: extension } });
    if (filter) {
        const decoded = new Uint8Array(count * stride);
        MeshoptDecoder.decodeGltfBuffer(decoded, count, stride, stream, mode, filter);
        codec.view(decoded);
    }
}
const byte = (i, k) => (i * i * (k % 5) + 7 * k) >> (k % 4) & 255;
for (const [count, stride] of [[1, 4], [300, 4], [270, 12], [33, 256]]) {
    for (const version of [0, 1]) {
        const of = (_, at) => byte(Math.floor(at / stride), at % stride);
        store(Uint8Array.from({ length: count * stride }, of), count, stride, "ATTRIBUTES", version);
    }
}
for (const stride of [2, 4]) {
    const indices = grid(9, 9);
    const bytes = new Uint8Array((stride === 2 ? indices : Uint32Array.from(indices)).buffer);
    store(bytes, indices.length, stride, "TRIANGLES", 1);
    store(bytes, indices.length, stride, "INDICES", 1);
}
const turn = (i, n) => [...Array(n).keys()].map((k) => Math.sin(i + 2 * k));
const unit = (i, n) => turn(i, n).map((x) => x / Math.hypot(...turn(i, n)));
const vectors = (n, of) => Float32Array.from({ length: 40 * n }, (_, at) => of(Math.floor(at / n), n)[at % n]);
const normals = vectors(4, (i) => [...unit(i, 3), 0.5]);
store(MeshoptEncoder.encodeFilterOct(normals, 40, 4, 7), 40, 4, "ATTRIBUTES", 1, "OCTAHEDRAL");
store(MeshoptEncoder.encodeFilterOct(normals, 40, 8, 12), 40, 8, "ATTRIBUTES", 1, "OCTAHEDRAL");
store(MeshoptEncoder.encodeFilterQuat(vectors(4, unit), 40, 8, 11), 40, 8, "ATTRIBUTES", 0, "QUATERNION");
const sizes = vectors(3, (i) => turn(i, 3).map((x) => x * 10 ** (i - 20)));
store(MeshoptEncoder.encodeFilterExp(sizes, 40, 12, 15, "Separate"), 40, 12, "ATTRIBUTES", 1, "EXPONENTIAL");
const colors = vectors(4, (i) => turn(i, 4).map((x) => x * x));
store(MeshoptEncoder.encodeFilterColor(colors, 40, 4, 8), 40, 4, "ATTRIBUTES", 1, "COLOR");
store(MeshoptEncoder.encodeFilterColor(colors, 40, 8, 12), 40, 8, "ATTRIBUTES", 1, "COLOR");
codec.json.buffers = [{}, { byteLength: 33 * 256, extensions: { KHR_meshopt_compression: { fallback: true } } }];
codec.json.extensionsUsed = codec.json.extensionsRequired = ["KHR_meshopt_compression"];
codec.save(join(out, "codec.glb"));

// splats.glb: splat-transform's, of 3 splats by the formulas of the rows.
const names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split(" ");
const ply = join(out, "splats.ply");
const row = (i) => [i, 10 + i, 100 + i, 0.1 * i, 0.2 * i, 0.3 * i, i - 1, -1 - i, -2 - i, -3 - i, 0.5, 0.5, 0.5, i - 0.5];
const rows = [0, 1, 2].map(row);
const properties = names.map((name) => `property float ${name}\n`).join("");
const head = `ply\nformat binary_little_endian 1.0\nelement vertex ${rows.length}\n${properties}end_header\n`;
writeFileSync(ply, Buffer.concat([Buffer.from(head), Buffer.from(Float32Array.from(rows.flat()).buffer)]));
tool("splat-transform", "-w", ply, join(out, "splats.glb"));
rmSync(ply);

for (const name of readdirSync(out)) console.log(String(statSync(join(out, name)).size).padStart(6), name);
