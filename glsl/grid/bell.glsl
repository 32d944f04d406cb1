// How much of a splat, an anisotropic Gaussian, goes into which voxels. What is thin is cut into parts, half a voxel apart at most. Each
// is an even box, and goes into the voxels that it is in, so that nothing of it is lost however it is turned. What is thick in all directions
// fills voxels by its density at their middles, wider by a voxel's own variance, 1/12: the mean over a voxel but for fourth moments. Source: ours.
// Twin: reference::twin::bell; not to the bit, since devices unpack a shape with different rounding.
#ifndef GRID_BELL_GLSL
#define GRID_BELL_GLSL
#include "grid/media.glsl"
#include "world/caster.glsl"

// Deviations, in voxels, from which voxels' middles say all of a splat: sums over them are wrong by 2 exp(−2π² (0.6² + 1/12)), 0.03 %.
const float BELL_THICK = 0.6;
// Below so many it is one part along an axis.
const float BELL_POINT = 0.125;
// By the share of a Gaussian within three deviations of its middle: of all directions, and along one axis.
const float BELL_WITHIN = 1.0301747;
const float BELL_AXIS = 1.0027071;
// Half the side of a box that has the variance of a Gaussian, deviations: √3.
const float BELL_ALL = 1.7320508;

struct Bell {
    vec3 centre;  // voxels
    SplatShape shape;
    bool thick;
    uvec3 count;   // parts along its axes, or voxels of its box
    ivec3 first;   // of the box
    float amount;  // extinction of a way of one voxel: over all voxels, or at the middle
};

// The light that a splat of that optical depth in its middle takes of all rays along an axis, by what it would take if it were
// thin and of an optical depth of 1: ∫₀¹ (1 − exp(−x u)) / u du, wrong by 3 % at most.
float bell_taken(float x) {
    float q = x * (1.0 + 0.57 * x) / (1.0 + 0.32 * x);
    // Near 1 the sum would be rounded.
    return q < 0.01 ? q * (1.0 - q * (0.5 - q / 3.0)) : log(1.0 + q);
}

// The optical depth that takes so much: the inverse of bell_taken.
float bell_depth(float taken) {
    float q = taken < 0.01 ? taken * (1.0 + taken * (0.5 + taken / 6.0)) : exp(taken) - 1.0;
    float b = 1.0 - 0.32 * q, root = sqrt(b * b + 2.28 * q);
    return b > 0.0 ? 2.0 * q / (root + b) : (root - b) / 1.14;
}

Bell bell_of(vec3 centre, float radius, vec3 packed, float extinction, uint size) {
    SplatShape shape = splat_shape(radius, packed);
    vec3 deviations = shape.deviations;
    bool thick = deviations.z >= BELL_THICK;
    vec3 wide = sqrt(deviations * deviations + 1.0 / 12.0);
    // Voxels spread it over more rays, so that it is less dark in its middle; a lone one has to take as much light as before.
    float depth = min(extinction * ROOT_TWO_PI * deviations.z, MAX_OPTICAL_DEPTH);
    float spread = deviations.x * deviations.y / (wide.x * wide.y);
    float amount = bell_depth(spread * bell_taken(depth)) * ROOT_TWO_PI * ROOT_TWO_PI * wide.x * wide.y;
    if (!thick) {
        uvec3 count = uvec3(max(ceil(12.0 * deviations), 4.0));
        count = uvec3(deviations.x < BELL_POINT ? 1u : count.x, deviations.y < BELL_POINT ? 1u : count.y,
                      deviations.z < BELL_POINT ? 1u : count.z);
        return Bell(centre, shape, false, count, ivec3(0), amount);
    }
    vec3 square = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        vec3 along = shape.axes[i] * wide[i];
        square += along * along;
    }
    vec3 reach = SPLAT_REACH * sqrt(square);
    ivec3 first = ivec3(clamp(floor(centre - reach - 0.5), vec3(0.0), vec3(size - 1u)));
    ivec3 last = ivec3(clamp(floor(centre + reach), vec3(0.0), vec3(size - 1u)));
    shape.deviations = wide;
    amount *= BELL_WITHIN / (ROOT_TWO_PI * ROOT_TWO_PI * ROOT_TWO_PI * wide.x * wide.y * wide.z);
    return Bell(centre, shape, true, uvec3(last - first + 1), first, amount);
}

// How many parts or voxels it is, one at least: no axis is longer than a sixth of the grid, and so has no more than 512 parts.
uint bell_count(Bell bell) { return bell.count.x * bell.count.y * bell.count.z; }

uvec3 bell_place(Bell bell, uint i) {
    return uvec3(i % bell.count.x, i / bell.count.x % bell.count.y, i / (bell.count.x * bell.count.y));
}

uint bell_units(float extinction) { return uint(min(extinction, MAX_OPTICAL_DEPTH) * MEDIA_UNITS + 0.5); }

// How much of a thick one is in a voxel.
uint bell_amount(Bell bell, ivec3 voxel) {
    vec3 from = vec3(voxel) + 0.5 - bell.centre;
    float square = 0.0;
    for (uint i = 0u; i < 3u; ++i) {
        float at = dot(bell.shape.axes[i], from) / bell.shape.deviations[i];
        square += at * at;
    }
    return square > SPLAT_REACH * SPLAT_REACH ? 0u : bell_units(bell.amount * exp(-0.5 * square));
}

// The density of a Gaussian.
float bell_density(float x) { return exp(-0.5 * x * x) / ROOT_TWO_PI; }

// How much a part of a thin one has, where its mean is, and half the sides of its box along the grid's axes: those of the box's variance.
float bell_part(Bell bell, uvec3 part, out vec3 place, out vec3 half_sides) {
    float amount = bell.amount;
    place = bell.centre;
    vec3 square = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        float half_side = BELL_ALL * bell.shape.deviations[i];
        if (bell.count[i] > 1u) {
            float step = 2.0 * SPLAT_REACH / float(bell.count[i]), low = float(part[i]) * step - SPLAT_REACH;
            float share = splat_share(low + step) - splat_share(low);
            float mean = (bell_density(low) - bell_density(low + step)) / share;
            amount *= BELL_AXIS * share;
            place += mean * bell.shape.deviations[i] * bell.shape.axes[i];
            half_side = 0.5 * step * bell.shape.deviations[i];
        }
        vec3 along = half_side * bell.shape.axes[i];
        square += along * along;
    }
    half_sides = sqrt(square);
    return amount;
}

// The voxels that a part is in: no side is longer than half a voxel, so they are two at most along each axis.
struct BellVoxels {
    uvec3 low;
    uvec3 high;
    vec3 in_low;  // how much of the part is in the lower ones, where there are two
};

BellVoxels bell_voxels(vec3 place, vec3 half_sides, uint size) {
    uvec3 low = uvec3(clamp(place - half_sides, vec3(0.0), vec3(size - 1u)));
    uvec3 high = uvec3(clamp(place + half_sides, vec3(0.0), vec3(size - 1u)));
    vec3 in_low = (vec3(high) - (place - half_sides)) / max(2.0 * half_sides, vec3(1e-9));
    return BellVoxels(low, high, clamp(in_low, vec3(0.0), vec3(1.0)));
}

// How much of a part is in one of them: bit i of `corner` is set for the higher along axis i. Where low and high are the same the lower has all.
float bell_in(BellVoxels voxels, uint corner, out uvec3 voxel) {
    float share = 1.0;
    voxel = voxels.low;
    for (uint i = 0u; i < 3u; ++i) {
        bool high = (corner >> i & 1u) != 0u;
        float in_low = voxels.low[i] == voxels.high[i] ? 1.0 : voxels.in_low[i];
        share *= high ? 1.0 - in_low : in_low;
        voxel[i] = high ? voxels.high[i] : voxels.low[i];
    }
    return share;
}
#endif
