// Amounts that casters add to voxels, in the units of grid/media.glsl. Source: ours. Twin: reference::twin::media, bit for bit: no
// operation here may be fused or reordered, and only integers may be divided, never floats.
//
// A voxel's number is its mean extinction: the integral of extinction over the voxel, divided by its volume. Lengths are in voxels; σ is a
// caster's extinction, τ its optical depth, r its radius. A sphere larger than a voxel adds σ times the share of the voxel that it fills. A
// caster smaller than a voxel adds the share of light that it absorbs, 1 − exp(−τ), times the area of its silhouette. This is less than τ
// times that area, because such casters may be anywhere in a voxel: their number on a ray, n, is Poisson distributed. If the mean of n is
// m, the mean transmittance is E[exp(−τ)ⁿ] = exp(−m (1 − exp(−τ))).
//   A sphere: its silhouette is π r²; τ is taken along its mean chord, 4/3 r. If τ is small, the product is σ times its volume.
//   A strand of length l at an angle a to the ray: its silhouette is 2 r l |sin a|, with |sin a| replaced by its mean over all
//   directions, π/4. τ is the optical depth of a ray that crosses the strand once.
#ifndef GRID_BLOB_GLSL
#define GRID_BLOB_GLSL
#include "grid/media.glsl"
#include "world/caster.glsl"

const float PI = 3.14159265;

// Converts the optical depth of a path of one voxel into units, clamped to the optical depth of an opaque voxel.
uint media_units(float optical_depth) {
    precise float units = min(optical_depth, MAX_OPTICAL_DEPTH) * MEDIA_UNITS;
    return uint(units);
}

// Returns 1 − exp(−optical depth): evaluates a series at 1/256 of the optical depth, then doubles the optical depth eight times.
float light_taken(float optical_depth) {
    precise float x = min(optical_depth, 16.0) * (1.0 / 256.0);
    precise float taken = x * (1.0 - x * (0.5 - x * (0.16666667 - x * 0.041666668)));
    for (uint i = 0u; i < 8u; ++i) {
        precise float twice = taken * (2.0 - taken);
        taken = twice;
    }
    return taken;
}

// 1 / √square, by Newton's iteration from a guess based on the float's bits; 0 for 0.
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

// A caster smaller than a voxel, as points. Each point's amount is shared among the eight voxels whose centres surround it.
struct Motes {
    vec3 first;   // voxels
    vec3 axis;    // point i is at first + axis · step · i
    float step;   // a power of two
    uint count;
    uint amount;  // per point
};

// A sphere smaller than a voxel; `extinction`: per voxel of path.
Motes sphere_motes(vec3 centre, float radius, float extinction) {
    precise float silhouette = PI * radius * radius;
    precise float chord = 1.3333334 * radius;
    precise float taken = light_taken(extinction * chord);
    precise float amount = silhouette * taken;
    return Motes(centre, vec3(0.0), 1.0, 1u, media_units(amount));
}

// A strand, as points at most half a voxel apart along each axis. Its radius changes their amounts, not their positions.
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

// Returns amount · share / 256, rounded down. The caller adds the remainder to the neighbouring voxel, so that nothing is lost.
uint part_of(uint amount, uint share) { return (amount >> 8) * share + (((amount & 255u) * share) >> 8); }

// A sphere with a radius of at least one voxel. Each voxel has two samples per axis. A sample's share falls from 1 inside to 0 outside,
// over half a voxel around the surface, which is the distance between samples.
struct Ball {
    vec3 centre;    // voxels
    float core;     // squared radius minus 1/12 of the border's squared width, which cancels the volume that the slope adds
    float sharp;    // factor of a squared distance: 1 / radius
    uint amount;    // of a voxel entirely inside
    ivec3 first;
    ivec3 last;
};

Ball ball_of(vec3 centre, float radius, float extinction, uint size) {
    precise float core = radius * radius - 1.0 / 48.0;
    // 1 / radius in units of 2⁻¹⁸, by integer division.
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

// Amount of the ball in one voxel of its box.
uint ball_amount(Ball ball, ivec3 voxel) {
    precise vec3 near = vec3(voxel) + 0.25 - ball.centre, far = vec3(voxel) + 0.75 - ball.centre;
    precise vec3 a = near * near, b = far * far;
    uint inside = ball_sample(ball, a.x, a.y, a.z) + ball_sample(ball, b.x, a.y, a.z) + ball_sample(ball, a.x, b.y, a.z) +
                  ball_sample(ball, b.x, b.y, a.z) + ball_sample(ball, a.x, a.y, b.z) + ball_sample(ball, b.x, a.y, b.z) +
                  ball_sample(ball, a.x, b.y, b.z) + ball_sample(ball, b.x, b.y, b.z);
    return (ball.amount >> 11) * inside + (((ball.amount & 2047u) * inside) >> 11);
}
#endif
