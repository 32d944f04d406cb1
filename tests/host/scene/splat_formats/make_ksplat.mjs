// Writes a .ksplat file by its maker's own library (npm @mkkellogg/gaussian-splats-3d 0.4.7, three 0.187.0):
// node make_ksplat.mjs IN.ply OUT.ksplat LEVEL SECTION_SIZE BLOCK_SIZE BUCKET_SIZE HARMONICS_DEGREE
import fs from 'node:fs';
import { createRequire } from 'node:module';
const require = createRequire(process.cwd() + '/');
globalThis.window = globalThis;
globalThis.self = globalThis;
const at = require.resolve('@mkkellogg/gaussian-splats-3d').replace('umd.cjs', 'module.js');
const { PlyParser, SplatBufferGenerator } = await import(at);
const [input, output, ...numbers] = process.argv.slice(2);
const [level, sectionSize, blockSize, bucketSize, degree] = numbers.map(Number);
const bytes = fs.readFileSync(input);
const ply = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
const splats = PlyParser.parseToUncompressedSplatArray(ply, degree);
const generator = SplatBufferGenerator.getStandardGenerator(1, level, sectionSize, undefined, blockSize, bucketSize);
const result = generator.generateFromUncompressedSplatArray(splats);
fs.writeFileSync(output, Buffer.from(result.bufferData));
