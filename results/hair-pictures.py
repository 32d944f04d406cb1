#!/usr/bin/env python3
# Draws results/pictures/hair-footprints.png anew: `GOBO=target/release/gobo results/hair-pictures.py FOLDER`. Pictures that FOLDER has are not
# drawn twice.
# Rows: hair and mohawk. Columns: maps of the same bytes, then the f64 reference with 64 samples per pixel, which is drawn eight times as
# large and averaged in linear light. Of each map it prints how far the picture is from that: the root of the mean square of the
# difference in linear light, over the pixels that are shown, and over a part of the floor where no hair is before the shadow. Nothing is
# needed but Python.
import os, struct, subprocess, sys, zlib

GOBO, FOLDER = os.environ.get('GOBO', 'target/release/gobo'), sys.argv[1]
OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'pictures/hair-footprints.png')
WIDTH, HEIGHT, SIDE, GAP = 240, 180, 8, 4
# Left, top, right and bottom of what is shown, how many times as large, and of floor in it.
SCENES = {'hair': ((60, 90, 220, 170), 3, (66, 142, 140, 156)), 'mohawk': ((75, 10, 155, 65), 6, None)}
MAPS = ['avsm:path=binned', 'avsm:path=binned,size=220,texel=area,levels=7',
        'avsm:path=binned,nodes=8,storage=tight,size=443,texel=area,levels=8']

def read(name):
    """Width, height and rows of a PNG of 8 bits, three or four channels."""
    data, at, packed = open(name, 'rb').read(), 8, b''
    while at < len(data):
        size, kind = struct.unpack('>I4s', data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b'IHDR':
            width, height, bits, color, _, _, interlaced = struct.unpack('>IIBBBBB', body)
            assert bits == 8 and color in (2, 6) and not interlaced, name
        packed += body if kind == b'IDAT' else b''
        at += 12 + size
    n, raw = 3 if color == 2 else 4, zlib.decompress(packed)
    rows, last = [], bytearray(width * n)
    for y in range(height):
        kind, row = raw[y * (width * n + 1)], bytearray(raw[y * (width * n + 1) + 1:(y + 1) * (width * n + 1)])
        for i in range(len(row)):
            a, b, c = row[i - n] if i >= n else 0, last[i], last[i - n] if i >= n else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = row[i] + [0, a, b, (a + b) // 2, nearest][kind] & 255
        last = row
        rows.append([row[i:i + 3] for i in range(0, len(row), n)])
    return rows

def write(name, rows):
    raw = b''.join(b'\0' + b''.join(bytes(p) for p in row) for row in rows)
    chunk = lambda kind, body: struct.pack('>I', len(body)) + kind + body + struct.pack('>I', zlib.crc32(kind + body))
    head = struct.pack('>IIBBBBB', len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    open(name, 'wb').write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunk(b'IDAT', zlib.compress(raw, 9)) + chunk(b'IEND', b''))

def drawn(scene, spec, number, times):
    name = f'{FOLDER}/{scene}-{number}.png'
    if not os.path.exists(name):
        size = ['--picture', f'{WIDTH * times}x{HEIGHT * times}']
        subprocess.run([GOBO, 'render', scene, '--plain', '--technique', spec, '-o', name] + size, check=True, stdout=subprocess.DEVNULL)
    return read(name)

# sRGB, both ways.
LINEAR = [c / 255 / 12.92 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in range(256)]
def code(light):
    return round(255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055))

def mean(rows, x, y):
    pixels = [rows[y * SIDE + j][x * SIDE + i] for j in range(SIDE) for i in range(SIDE)]
    return [sum(LINEAR[p[k]] for p in pixels) / len(pixels) for k in range(3)]

def rms(picture, truth, places):
    pairs = [(LINEAR[picture[y][x][k]], truth[x, y][k]) for x, y in places for k in range(3)]
    return (sum((a - b) ** 2 for a, b in pairs) / len(pairs)) ** 0.5

def inside(box):
    return [(x, y) for y in range(box[1], box[3]) for x in range(box[0], box[2])]

whole, white = [], [[255] * 3]
for scene, (shown, zoom, floor) in SCENES.items():
    large = drawn(scene, 'reference', 'reference', SIDE)
    truth = {at: mean(large, *at) for at in inside(shown)}
    pictures = [drawn(scene, spec, number, 1) for number, spec in enumerate(MAPS)]
    for spec, picture in zip(MAPS, pictures):
        beside = f', floor {rms(picture, truth, inside(floor)):.4f}' if floor else ''
        print(f'{scene}, {spec}: {rms(picture, truth, inside(shown)):.4f}{beside}')
    left, top, right, bottom = shown
    for y in range(top, bottom):
        rows = [picture[y][left:right] for picture in pictures]
        rows.append([[code(light) for light in truth[x, y]] for x in range(left, right)])
        line = []
        for row in rows:
            line += (white * GAP if line else []) + [pixel for pixel in row for _ in range(zoom)]
        whole += [line] * zoom
    whole += [white * len(line)] * GAP
write(OUT, whole[:-GAP])
