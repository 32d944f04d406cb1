#!/usr/bin/env python3
"""Writes splats of a closed form (the same as in tests/closed_form.rs) as PLY: make.py FILE COUNT [noise|far|harmonics]"""
import math, random, struct, sys

HARMONIC_0 = 0.28209479177387814


def splat(i, n):
    """Position, deviations, quaternion w x y z, opacity, color."""
    position = [((i * 37) % 101 - 50) * 0.37 + 0.001 * i, ((i * 53) % 89 - 44) * 0.11 - 0.003 * i, ((i * 71) % 97 - 48) * 1.7]
    deviations = [10.0 ** (-4 + 5 * ((i * k) % 64) / 63) for k in (5, 11, 23)]
    turn = [(i * 7) % 11 - 4.75, (i * 5) % 13 - 5.75, (i * 3) % 17 - 7.75, (i * 11) % 19 - 8.75]
    opacity = 0.01 + 0.989 * ((i * 29) % n) / (n - 1)
    color = [((i * k) % 41) / 40 for k in (3, 7, 17)]
    return position, deviations, turn, opacity, color


def noise(i, n):
    r = random.random
    g = random.gauss
    return [g(0, 5), g(0, 2), g(0, 5)], [math.exp(g(-4, 1.2)) for _ in range(3)], [g(0, 1) for _ in range(4)], 0.01 + 0.98 * r(), [r() for _ in range(3)]


def main(path, n, kind="closed"):
    random.seed(1)
    rest = 9 if kind == "harmonics" else 0
    names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", *[f"f_rest_{k}" for k in range(rest)], "opacity"]
    names += ["scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    with open(path, "wb") as out:
        out.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n".encode())
        out.write("".join(f"property float {name}\n" for name in names).encode() + b"end_header\n")
        far = [0.0, 2047.9, 2047.99988, 2048.0, 2048.5, 3000.0, -2048.0, -2048.5, -5000.0, 600000.0, -600000.0, 1e9]
        for i in range(n):
            position, deviations, turn, opacity, color = (noise if kind == "noise" else splat)(i, n)
            if kind == "far":
                position = [far[i], 0.0, 0.0]
            harmonics = [0.3 * math.sin(i + k) for k in range(rest)]
            out.write(struct.pack(f"<{len(names)}f", *position, *[(c - 0.5) / HARMONIC_0 for c in color], *harmonics,
                                  math.log(opacity / (1 - opacity)), *map(math.log, deviations), *turn))


main(sys.argv[1], int(sys.argv[2]), *sys.argv[3:])
