#!/usr/bin/env python3
"""Small OpenVDB files of one ball, and three frames of one that rises and grows: `vdb.py FOLDER`. A part is written here, byte by byte, so that it holds what OpenVDB does not write any more
or should not; the rest by OpenVDB's own Python module (Debian: python3-openvdb), where there is one. fuzz/seeds/vdb has all of them.
"""
import os, struct, sys, zlib

SIDES = [5, 4, 3]  # logarithms of a node's sides, from the root's children to the leaves
MANY = 20


def ball(x, y, z):
    inside = (x - 6) ** 2 + (y + 4) ** 2 + (z - 9) ** 2 < 30
    return ((7 * x + 11 * y + 13 * z) % 29 + 1) / 32 if inside else 0.0


def samples():
    places = [(x, y, z) for x in range(MANY) for y in range(-MANY, MANY) for z in range(MANY)]
    return {place: ball(*place) for place in places if ball(*place) != 0}


def frame(number):
    """From 1: a puff of that frame, it reaches 3, 5 and 4 samples from its middle, where it is densest."""
    (x, y, z), square = (2 * number, number, 5 * number - 4), (0, 12, 27, 18)[number]
    reach = range(-6, 7)
    away = [(i, j, k) for i in reach for j in reach for k in reach if i * i + j * j + k * k < square]
    return {(x + i, y + j, z + k): (square - i * i - j * j - k * k) / 8 for i, j, k in away}


def text(string):
    return struct.pack("<I", len(string)) + string.encode()


def mask(bits, places):
    found = bytearray((1 << 3 * bits) // 8)
    for place in places:
        found[place // 8] |= 1 << place % 8
    return bytes(found)


class File:
    """One grid, `density`, whose inactive values are 0, or `others`, the first where z is odd. Of floats, or of halves as OpenVDB 13 has."""

    def __init__(self, active, zipped=True, background=0.0, others=None, version=224, move=(1.0, 2.0, 3.0), half=False):
        self.active, self.zipped, self.background, self.others, self.version = active, zipped, background, others, version
        self.move, self.number_of, self.kind = list(move), "e" if half else "f", "half" if half else "float"

    def packed(self, floats):
        raw = struct.pack("<%d%s" % (len(floats), self.number_of), *floats)
        if not self.zipped:
            return raw
        short = zlib.compress(raw)
        return struct.pack("<q", len(short)) + short if len(short) < len(raw) else struct.pack("<q", -len(raw)) + raw

    def number(self, place, level):
        """Where a sample is in its node of that level."""
        below = sum(SIDES[level + 1:])
        x, y, z = (at >> below & (1 << SIDES[level]) - 1 for at in place)
        return (x << 2 * SIDES[level]) + (y << SIDES[level]) + z

    def groups(self, places, level):
        found = {}
        for place in places:
            found.setdefault(self.number(place, level), []).append(place)
        return sorted(found.items())

    def node(self, places, level, leaves):
        if level == 2:
            leaves.append(places)
            return mask(3, (self.number(place, 2) for place in places))
        groups = self.groups(places, level)
        children = mask(SIDES[level], (number for number, _ in groups))
        # No tile has a value: how inactive ones are kept, and no active one behind it.
        head = children + mask(SIDES[level], ()) + b"\0" + self.packed([])
        return head + b"".join(self.node(of, level + 1, leaves) for _, of in groups)

    def leaf(self, places):
        active = sorted((self.number(place, 2), place) for place in places)
        on = mask(3, (number for number, _ in active))
        floats = self.packed([self.active[place] for _, place in active])
        if self.others is None:
            return on + b"\0" + floats
        # Two values, and which of them each inactive sample has: a bit is the second.
        second = mask(3, (number for number in range(512) if number % 8 % 2 == 0))
        return on + b"\5" + struct.pack("<2" + self.number_of, *self.others) + second + floats

    def bytes(self):
        out = bytes([0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0]) + struct.pack("<3IB", self.version, 10, 0, 1)
        out += b"00000000-0000-0000-0000-000000000000" + struct.pack("<II", 0, 1)
        out += text("density") + text("Tree_%s_5_4_3" % self.kind) + text("")
        begin = len(out) + 24
        grid = struct.pack("<II", 3 if self.zipped else 2, 1) + text("class") + text("string") + text("fog volume")
        scale = [0.25] * 3
        numbers = self.move + scale + scale + [1 / s for s in scale] + [1 / s ** 2 for s in scale] + [0.5 / s for s in scale]
        grid += text("UniformScaleTranslateMap") + struct.pack("<18d", *numbers)
        roots = {}
        for place in self.active:
            roots.setdefault(tuple(at >> 12 << 12 for at in place), []).append(place)
        grid += struct.pack("<I%sII" % self.number_of, 1, self.background, 0, len(roots))
        leaves = []
        for corner, places in sorted(roots.items()):
            grid += struct.pack("<3i", *corner) + self.node(places, 0, leaves)
        blocks = b"".join(self.leaf(places) for places in leaves)
        places = (begin, begin + len(grid), begin + len(grid) + len(blocks))
        return out + struct.pack("<3q", *places) + grid + blocks


def ours():
    zipped = File(samples()).bytes()
    yield "ok-zipped", zipped
    yield "ok-plain", File({(1, 1, 1): 0.5, (2, 1, 1): 0.25}, zipped=False).bytes()
    yield "ok-two-others", File(samples(), others=(0.25, 0.5)).bytes()
    yield "ok-half-tree", File(samples(), version=225, half=True).bytes()
    yield "ok-half-tree-others", File(samples(), version=225, half=True, others=(0.25, 0.5)).bytes()
    for number in (1, 2, 3):
        yield "ok-frame-%d" % number, File(frame(number), move=(-0.5, 0.0, 0.25 * number)).bytes()
    yield "bad-cut-off", zipped[:-9]
    yield "bad-cut-in-the-tree", zipped[:700]
    yield "ok-background", File(samples(), background=1.0).bytes()
    # Described as so many grids, each of which ends where the file begins.
    where = zipped.index(text("density")) + len(text("density") + text("Tree_float_5_4_3") + text("")) + 16
    begins = zipped.index(text("density")) - 4
    again = zipped[:begins] + b"\xff" * 4 + zipped[begins + 4:where] + struct.pack("<q", begins + 4) + zipped[where + 8:]
    yield "bad-ends-before", again
    yield "bad-old", File(samples(), version=213).bytes()
    yield "bad-not-a-number", File({**samples(), (1, 1, 1): float("nan")}).bytes()
    yield "bad-negative", File({**samples(), (1, 1, 1): -0.5}).bytes()
    yield "bad-million-wide", File({(0, 0, 0): 0.5, (1_000_000, 0, 0): 0.5}).bytes()


def theirs(folder):
    try:
        import pyopenvdb as vdb
    except ImportError:
        import openvdb as vdb

    def grid(name="density", turned=False, values=None):
        made = vdb.FloatGrid()
        made.name, made.gridClass = name, vdb.GridClass.FOG_VOLUME
        cosine = 3 ** 0.5 / 2
        if turned:
            rows = [[0.5 * cosine, 0.25, 0, 0], [-0.5, cosine, 0, 0], [0, 0, 2, 0], [7, 8, 9, 1]]
            made.transform = vdb.createLinearTransform(rows)
        else:
            made.transform = vdb.createLinearTransform(voxelSize=0.25)
            made.transform.translate((1, 2, 3))
        accessor = made.getAccessor()
        for place, value in (samples() if values is None else values).items():
            accessor.setValueOn(place, value)
        return made

    def write(name, grids):
        vdb.write(os.path.join(folder, name + ".vdb"), grids=grids)

    velocity = vdb.Vec3SGrid()
    velocity.name = "velocity"
    velocity.getAccessor().setValueOn((1, 2, 3), (1, 2, 3))
    write("ok-blosc", [velocity, grid("temperature", values={(2, 3, 4): 0.75}), grid()])
    half = grid()
    half.saveFloatAsHalf = True
    write("ok-half", [half])
    write("ok-turned", [grid(turned=True)])
    tiles = vdb.FloatGrid()
    tiles.name, tiles.transform = "density", vdb.createLinearTransform(voxelSize=1)
    tiles.fill((-8, 0, 8), (15, 7, 23), 0.5)
    tiles.prune()
    write("ok-tiles", [tiles])
    shell = vdb.createLevelSetSphere(radius=3, center=(9, 9, 9), voxelSize=1, halfWidth=2)
    shell.name = "density"
    write("bad-level-set", [shell])


if __name__ == "__main__":
    folder = sys.argv[1] if len(sys.argv) == 2 else sys.exit(__doc__)
    os.makedirs(folder, exist_ok=True)
    for name, data in ours():
        with open(os.path.join(folder, name + ".vdb"), "wb") as file:
            file.write(data)
    try:
        theirs(folder)
    except ImportError:
        sys.exit("no Python module of OpenVDB: ok-blosc, ok-half, ok-turned, ok-tiles and bad-level-set are not written")
