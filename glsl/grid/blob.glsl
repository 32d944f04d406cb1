// How much a caster puts into which voxels, in the units of grid/media.glsl. Source: ours. Twin: reference::twin::media, to the
// bit: nothing here may be fused or put in another order, and no float is divided; integers are.
//
// A voxel's number is the mean extinction in it: what there is of extinction times volume, by the voxel's volume. With voxels for
// units that is σ · the share of the voxel that a sphere fills. A caster smaller than a voxel counts as what it absorbs of the light
// that meets it: its silhouette times 1 − exp(−optical depth). Such casters stand anywhere in a voxel, so a ray meets a Poisson
// number of them, of mean m, and E[exp(−τ)ⁿ] = exp(−m (1 − exp(−τ))).
//   A sphere: π r² and its mean chord 4/3 r; where it is thin, σ times its volume.
//   A strand: 2 r l |sin| of its angle to the ray, whose mean over all directions is π/4, and the optical depth of a crossing.
#ifndef GRID_BLOB_GLSL
#define GRID_BLOB_GLSL
#include "grid/media.glsl"
#include "world/caster.glsl"

const float PI = 3.14159265;

// A caster's optical depth over a way of one voxel is clamped to that of an opaque one.
uint media_units(float optical_depth) {
    precise float units = min(optical_depth, MAX_OPTICAL_DEPTH) * MEDIA_UNITS;
    return uint(units);
}

// 1 − exp(−optical depth): a series near 0, and doubled from there.
float light_taken(float optical_depth) {
    precise float x = min(optical_depth, 16.0) * (1.0 / 256.0);
    precise float taken = x * (1.0 - x * (0.5 - x * (0.16666667 - x * 0.041666668)));
    for (uint i = 0u; i < 8u; ++i) {
        precise float twice = taken * (2.0 - taken);
        taken = twice;
    }
    return taken;
}

// 1 / √, by Newton's iteration from the bits; 0 of 0.
float inverse_root(float square) {
    if (square < 1e-30) {
        return 0.0;
    }
    precise float inverse = uintBitsToFloat(0x5F3759DFu - (floatBitsToUint(square) >> 1));
    for (uint i = 0u; i < 4u; ++i) {
        precise float next = inverse * (1.5 - 0.5 * square * inverse * inverse);
        inverse = next;
    }
    return inverse;
}

float root(float square) {
    precise float result = square * inverse_root(square);
    return result;
}

// What is smaller than a voxel: parts at places, each shared by the eight voxels whose middles are about it.
struct Motes {
    vec3 first;   // voxels
    vec3 axis;    // from the first to where one more than the last would be, were they one apart by `step`
    float step;   // a power of two
    uint count;
    uint amount;  // of each
};

// A sphere of extinction σ a voxel, smaller than a voxel.
Motes sphere_motes(vec3 centre, float radius, float extinction) {
    precise float silhouette = PI * radius * radius;
    precise float chord = 1.3333334 * radius;
    precise float taken = light_taken(extinction * chord);
    precise float amount = silhouette * taken;
    return Motes(centre, vec3(0.0), 1.0, 1u, media_units(amount));
}

// A strand: parts at most half a voxel apart along each axis. It has no width but that.
Motes strand_motes(vec3 start, vec3 axis, float radius, float optical_depth) {
    vec3 far = abs(axis);
    float widest = max(far.x, max(far.y, far.z)), step = 1.0;
    uint count = 1u;
    for (; float(count) < 2.0 * widest && count < 4096u; count *= 2u) {
        step *= 0.5;
    }
    precise float square = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z;
    precise float silhouette = 0.5 * PI * radius * root(square);
    precise float amount = silhouette * light_taken(optical_depth) * step;
    precise vec3 first = start + axis * (0.5 * step);
    return Motes(first, axis, step, count, media_units(amount));
}

vec3 mote_place(Motes motes, uint i) {
    precise vec3 place = motes.first + motes.axis * (motes.step * float(i));
    return place;
}

// So many 256ths of an amount, rounded down; the rest goes to the other side, so that nothing is lost.
uint part_of(uint amount, uint share) { return (amount >> 8) * share + (((amount & 255u) * share) >> 8); }

// A sphere of a voxel's radius and more: two samples per voxel and axis, each of which is inside by a share that falls from 1 to 0
// over half a voxel, the samples' distance, about its border.
struct Ball {
    vec3 centre;    // voxels
    float core;     // square of the radius, less a 12th of the square of the border's width, since the slope adds to the volume
    float sharp;    // factor of a distance's square: 1 / radius
    uint amount;    // of a voxel that is all inside
    ivec3 first;
    ivec3 last;
};

Ball ball_of(vec3 centre, float radius, float extinction, uint size) {
    precise float core = radius * radius - 1.0 / 48.0;
    // 2¹⁸ / radius, a whole number.
    precise float sharp = float(16777216u / uint(radius * 64.0)) * (1.0 / 262144.0);
    precise vec3 low = centre - (radius + 0.25), high = centre + (radius + 0.25);
    ivec3 first = ivec3(clamp(floor(low), vec3(0.0), vec3(size - 1u)));
    ivec3 last = ivec3(clamp(floor(high), vec3(0.0), vec3(size - 1u)));
    return Ball(centre, core, sharp, media_units(extinction), first, last);
}

uint ball_sample(Ball ball, float x, float y, float z) {
    precise float square = x + y + z;
    precise float inside = (ball.core - square) * ball.sharp + 0.5;
    precise float share = clamp(inside, 0.0, 1.0) * 256.0 + 0.5;
    return uint(share);
}

// How much of the ball is in one voxel of its box.
uint ball_amount(Ball ball, ivec3 voxel) {
    precise vec3 near = vec3(voxel) + 0.25 - ball.centre, far = vec3(voxel) + 0.75 - ball.centre;
    precise vec3 a = near * near, b = far * far;
    uint inside = ball_sample(ball, a.x, a.y, a.z) + ball_sample(ball, b.x, a.y, a.z) + ball_sample(ball, a.x, b.y, a.z) +
                  ball_sample(ball, b.x, b.y, a.z) + ball_sample(ball, a.x, a.y, b.z) + ball_sample(ball, b.x, a.y, b.z) +
                  ball_sample(ball, a.x, b.y, b.z) + ball_sample(ball, b.x, b.y, b.z);
    return (ball.amount >> 11) * inside + (((ball.amount & 2047u) * inside) >> 11);
}
#endif
