# Writes a curly ponytail of 4,933 strands of 16 points as a TressFX file: python3 results/files/ponytail.py results/files/ponytail.tfx
import struct, math, random, sys
random.seed(33); n, points = 4933, 16
out = bytearray(160)
struct.pack_into('<fIII', out, 0, 4.0, n, points, 160)
body = bytearray()
for s in range(n):
    a, r = random.uniform(0, 2*math.pi), math.sqrt(random.random())
    root = (0.12*r*math.cos(a), 0.12*r*math.sin(a), 2.0)
    tip = (0.55*r*math.cos(a)+random.gauss(0, .04), 0.9+0.45*r*math.sin(a)+random.gauss(0, .04), 0.15+random.uniform(0, .5))
    phase, turns, curl = random.uniform(0, 6.28), random.uniform(1.5, 3), random.uniform(.01, .035)
    mid = (0.1*r*math.cos(a), 0.75, 2.15+0.1*r*math.sin(a))
    for i in range(points):
        t = i/(points-1); w = ((1-t)**2, 2*t*(1-t), t*t)
        p = [w[0]*root[k]+w[1]*mid[k]+w[2]*tip[k] for k in range(3)]
        c = curl*t; p[0] += c*math.cos(6.28*turns*t+phase); p[1] += c*math.sin(6.28*turns*t+phase)
        body += struct.pack('<4f', *p, 1.0)
open(sys.argv[1], 'wb').write(out+body)
