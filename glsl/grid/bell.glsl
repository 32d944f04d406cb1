// Distributes a splat, an anisotropic Gaussian, over voxels. A thin splat is split into uniform boxes, its parts, at most half a voxel
// apart. Each part is distributed over the voxels that it overlaps, so that no extinction is lost, whatever the splat's rotation. A splat
// that is thick in all directions adds its density at each voxel's centre, with its variance increased by a voxel's own variance, 1/12:
// this equals the mean over the voxel up to fourth moments. Source: ours. Twin: reference::twin::bell; not bit for bit, since devices
// unpack a shape with different rounding.
#ifndef GRID_BELL_GLSL
#define GRID_BELL_GLSL
#include "grid/media.glsl"
#include "world/caster.glsl"

// Smallest standard deviation, in voxels, at which a splat is sampled at voxel centres: the relative error of the samples' sum is then at
// most 2 exp(−2π² (0.6² + 1/12)), 0.03 %.
const float BELL_THICK = 0.6;
// A splat is not split along an axis whose standard deviation, in voxels, is smaller than this.
const float BELL_POINT = 0.125;
// Factors that compensate for cutting off a Gaussian at three standard deviations: in three dimensions, and along one axis.
const float BELL_WITHIN = 1.0301747;
const float BELL_AXIS = 1.0027071;
// Half-extent, in standard deviations, of a box with the same variance as the Gaussian: √3.
const float BELL_ALL = 1.7320508;

struct Bell {
    vec3 centre;  // voxels
    SplatShape shape;
    bool thick;
    uvec3 count;   // thin: number of parts per axis; thick: size of its box, in voxels
    ivec3 first;   // lowest voxel of the box
    float amount;  // extinction per voxel of path; thin: the sum over all voxels; thick: the value at the centre
};

// Light that a splat absorbs from all rays along an axis, normalized so that it tends to x, the optical depth at its centre, for small x:
// ∫₀¹ (1 − exp(−x u)) / u du. The relative error is at most 3 %.
float bell_taken(float x) {
    float q = x * (1.0 + 0.57 * x) / (1.0 + 0.32 * x);
    // For a small q, the sum 1 + q would round q away.
    return q < 0.01 ? q * (1.0 - q * (0.5 - q / 3.0)) : log(1.0 + q);
}

// The optical depth that absorbs this much light: the inverse of bell_taken.
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
    // Voxels spread the splat over more rays, which makes its centre less dark; a lone splat still has to absorb as much light as before.
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

// Number of parts or voxels, at least one: no axis is longer than a sixth of the grid, and so none has more than 512 parts.
uint bell_count(Bell bell) { return bell.count.x * bell.count.y * bell.count.z; }

uvec3 bell_place(Bell bell, uint i) {
    return uvec3(i % bell.count.x, i / bell.count.x % bell.count.y, i / (bell.count.x * bell.count.y));
}

uint bell_units(float extinction) { return uint(min(extinction, MAX_OPTICAL_DEPTH) * MEDIA_UNITS + 0.5); }

// Amount of a thick splat in a voxel.
uint bell_amount(Bell bell, ivec3 voxel) {
    vec3 from = vec3(voxel) + 0.5 - bell.centre;
    float square = 0.0;
    for (uint i = 0u; i < 3u; ++i) {
        float at = dot(bell.shape.axes[i], from) / bell.shape.deviations[i];
        square += at * at;
    }
    return square > SPLAT_REACH * SPLAT_REACH ? 0u : bell_units(bell.amount * exp(-0.5 * square));
}

// Density of a unit Gaussian.
float bell_density(float x) { return exp(-0.5 * x * x) / ROOT_TWO_PI; }

// Returns the amount in one part of a thin splat. `place`: the part's mean position. `half_sides`: half-extents of a box along the grid's
// axes with the part's variance.
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

// The voxels that a part overlaps: no side is longer than half a voxel, so there are at most two along each axis.
struct BellVoxels {
    uvec3 low;
    uvec3 high;
    vec3 in_low;  // per axis with two voxels: share of the part in the lower one
};

BellVoxels bell_voxels(vec3 place, vec3 half_sides, uint size) {
    uvec3 low = uvec3(clamp(place - half_sides, vec3(0.0), vec3(size - 1u)));
    uvec3 high = uvec3(clamp(place + half_sides, vec3(0.0), vec3(size - 1u)));
    vec3 in_low = (vec3(high) - (place - half_sides)) / max(2.0 * half_sides, vec3(1e-9));
    return BellVoxels(low, high, clamp(in_low, vec3(0.0), vec3(1.0)));
}

// Share of a part in one of these voxels: bit i of `corner` selects the higher one along axis i. If low and high are the same, the lower
// gets everything.
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
