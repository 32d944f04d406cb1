// Writes version 1 of SOG, as splat-transform 0.5 wrote it (no registry has that version; splat-transform 3.7.0 reads it), with the images
// by splat-transform's own WebP encoder: node make_sog_1.mjs IN.csv FOLDER (IN.csv: any splats that splat-transform wrote as .csv)
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
const root = path.resolve('../tools/node_modules/@playcanvas/splat-transform');
const { WebPCodec } = await import(pathToFileURL(path.join(root, 'dist/index.mjs')));
const [input, folder] = process.argv.slice(2);
const [names, ...rows] = fs.readFileSync(input, 'utf8').trim().split('\n').map(line => line.split(','));
const column = name => rows.map(row => Number(row[names.indexOf(name)]));
const count = rows.length, width = 4 * Math.ceil(Math.sqrt(count) / 4), height = 4 * Math.ceil(count / width / 4);
const codec = await WebPCodec.create();
fs.mkdirSync(folder, { recursive: true });
const write = (name, of) => {
    const rgba = new Uint8Array(4 * width * height);
    for (let i = 0; i < count; i++) rgba.set(of(i), 4 * i);
    fs.writeFileSync(path.join(folder, name), codec.encodeLosslessRGBA(rgba, width, height));
    return name;
};
const bounds = columns => ({ mins: columns.map(c => Math.min(...c)), maxs: columns.map(c => Math.max(...c)) });
const bytes = (columns, { mins, maxs }, most, i) => columns.map((c, k) => Math.round((c[i] - mins[k]) / (maxs[k] - mins[k]) * most));
const logs = ['x', 'y', 'z'].map(name => column(name).map(x => Math.sign(x) * Math.log1p(Math.abs(x))));
const scales = ['scale_0', 'scale_1', 'scale_2'].map(column);
const colors = ['f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity'].map(column);
const turns = ['rot_0', 'rot_1', 'rot_2', 'rot_3'].map(column);
const [of_logs, of_scales, of_colors] = [logs, scales, colors].map(bounds);
const quat = i => {
    const q = turns.map(c => c[i]), length = Math.hypot(...q);
    const greatest = q.reduce((best, x, k) => Math.abs(x) > Math.abs(q[best]) ? k : best, 0);
    const unit = q.map(x => x / length * Math.sign(q[greatest]));
    unit.splice(greatest, 1);
    return [...unit.map(x => Math.round(255 * (x * Math.SQRT1_2 + 0.5))), 252 + greatest];
};
const shape = [count, 3], dtype = 'float32';
fs.writeFileSync(path.join(folder, 'meta.json'), JSON.stringify({
    means: { shape, dtype, ...of_logs, files: [
        write('means_l.webp', i => [...bytes(logs, of_logs, 65535, i).map(x => x & 255), 255]),
        write('means_u.webp', i => [...bytes(logs, of_logs, 65535, i).map(x => x >> 8), 255])] },
    scales: { shape, dtype, ...of_scales, files: [write('scales.webp', i => [...bytes(scales, of_scales, 255, i), 255])] },
    quats: { shape: [count, 4], dtype: 'uint8', encoding: 'quaternion_packed', files: [write('quats.webp', quat)] },
    sh0: { shape: [count, 1, 4], dtype, ...of_colors, files: [write('sh0.webp', i => bytes(colors, of_colors, 255, i))] },
}));
