#!/usr/bin/env python3
"""Puts results/pictures/rank-*.png together: `results/rank-pictures.py FOLDER`, where FOLDER/plume, cloud, psm and fountain are what the
four commands of docs/notebook/truth.md, "Where the two disagree", wrote. Above: the reference and two techniques, a part of each, enlarged
without smoothing; below: their differences from the reference as `compare` wrote them."""
import os
import struct
import sys
import zlib

PICTURES = [
    ("rank-plume_8k", "plume", "plume_8k", "01-stochastic", "02-avsm", (285, 120, 395, 230), 3),
    ("rank-cloud", "cloud", "cloud", "01-marched", "02-stochastic", (270, 165, 436, 265), 2),
    ("rank-cloud-psm", "psm", "cloud", "01-layers", "02-psm", (88, 20, 198, 130), 3),
    ("rank-fountain", "fountain", "fountain", "01-deep-shadow-map", "02-fourier", (70, 15, 220, 125), 2),
]
WHITE, GREY = b"\xff" * 3, b"\x80" * 3


def predicted(kind, left, up, corner):
    """What a PNG's filter takes a byte for, from its neighbours."""
    if kind == 4:
        at = left + up - corner
        return min((abs(at - left), 0, left), (abs(at - up), 1, up), (abs(at - corner), 2, corner))[2]
    return (0, left, up, (left + up) // 2)[kind]


def read(name):
    """Rows of pixels, three bytes each, of an 8-bit PNG."""
    data, at, packed = open(name, "rb").read(), 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", body[:10])
            assert bits == 8 and color in (2, 6), f"{name}: not 8 bits of red, green and blue"
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    n, raw = 3 if color == 2 else 4, zlib.decompress(packed)
    rows, last = [], bytearray(width * n)
    for y in range(height):
        start = y * (width * n + 1)
        row = bytearray(raw[start + 1 : start + 1 + width * n])
        for i in range(len(row)):
            left, corner = (row[i - n], last[i - n]) if i >= n else (0, 0)
            row[i] = row[i] + predicted(raw[start], left, last[i], corner) & 255
        rows.append([bytes(row[i : i + 3]) for i in range(0, len(row), n)])
        last = row
    return rows


def write(name, rows):
    """Each row with the filter that leaves the smallest bytes."""
    out, last = b"", bytes(3 * len(rows[0]))
    for pixels in rows:
        row = b"".join(pixels)

        def filtered(kind):
            beside = lambda line, i: line[i - 3] if i > 2 else 0
            of = lambda i: row[i] - predicted(kind, beside(row, i), last[i], beside(last, i)) & 255
            return bytes([kind]) + bytes(of(i) for i in range(len(row)))

        out += min((filtered(kind) for kind in range(5)), key=lambda line: sum(min(x, 256 - x) for x in line))
        last = row
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    with open(name, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(out, 9)) + chunk(b"IEND", b""))


def part(rows, box, times):
    """A part of a picture, enlarged."""
    left, top, right, bottom = box
    cut = [row[left:right] for row in rows[top:bottom]]
    return [[pixel for pixel in row for _ in range(times)] for row in cut for _ in range(times)]


def beside(parts, gap=4):
    """Pictures in a row, with white between them."""
    line = lambda y: sum(([WHITE] * gap * (i > 0) + rows[y] for i, rows in enumerate(parts)), [])
    return [line(y) for y in range(len(parts[0]))]


def main():
    folder, out = sys.argv[1], os.path.join(os.path.dirname(os.path.abspath(__file__)), "pictures")
    for name, sub, scene, one, other, box, times in PICTURES:
        of = lambda what: part(read(f"{folder}/{sub}/{scene}-{what}.png"), box, times)
        reference, a, b = of("reference"), of(one), of(other)
        none = [[GREY] * len(reference[0])] * len(reference)
        above = beside([reference, a, b])
        below = beside([none, of(f"{one}-difference"), of(f"{other}-difference")])
        write(f"{out}/{name}.png", above + [[WHITE] * len(above[0])] * 4 + below)


main()
