// How much of a splat, an anisotropic Gaussian, goes into which voxels. What is thin is cut into parts, a third of a voxel apart at most, each
// of which goes into the voxel that it is in, so that nothing of it is lost however it is turned. What is thick in all directions fills voxels
// by its density at their middles, wider by a voxel's own variance, 1/12: the mean over a voxel but for fourth moments. Source: ours.
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

struct Bell {
    vec3 centre;  // voxels
    GaussianShape shape;
    bool thick;
    uvec3 count;   // parts along its axes, or voxels of its box
    ivec3 first;   // of the box
    float amount;  // extinction of a way of one voxel: over all voxels, or at the middle
};

// The light that a splat of that optical depth in its middle takes of all rays along an axis, by what it would take if it were
// thin: ∫₀¹ (1 − exp(−x u)) / u du, wrong by 3 % at most.
float bell_taken(float x) { return log(1.0 + x * (1.0 + 0.57 * x) / (1.0 + 0.32 * x)); }

Bell bell_of(vec3 centre, float radius, vec3 packed, float extinction, uint size) {
    GaussianShape shape = gaussian_shape(radius, packed);
    vec3 deviations = shape.deviations;
    bool thick = deviations.z >= BELL_THICK;
    vec3 wide = sqrt(deviations * deviations + 1.0 / 12.0);
    // Voxels spread it over more rays, so that it is less dark in its middle; a lone one has to take as much light as before.
    float depth = min(extinction * ROOT_TWO_PI * deviations.z, MAX_OPTICAL_DEPTH);
    float spread = deviations.x * deviations.y / (wide.x * wide.y);
    float share = depth > 0.0 ? bell_taken(depth) * spread / bell_taken(depth * spread) : 0.0;
    float area = ROOT_TWO_PI * ROOT_TWO_PI * deviations.x * deviations.y;
    float amount = share * depth * area;
    if (!thick) {
        uvec3 count = uvec3(max(ceil(18.0 * deviations), 4.0));
        count = uvec3(deviations.x < BELL_POINT ? 1u : count.x, deviations.y < BELL_POINT ? 1u : count.y,
                      deviations.z < BELL_POINT ? 1u : count.z);
        return Bell(centre, shape, false, count, ivec3(0), amount);
    }
    vec3 square = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        vec3 along = shape.axes[i] * wide[i];
        square += along * along;
    }
    vec3 reach = GAUSSIAN_REACH * sqrt(square);
    ivec3 first = ivec3(clamp(floor(centre - reach - 0.5), vec3(0.0), vec3(size - 1u)));
    ivec3 last = ivec3(clamp(floor(centre + reach), vec3(0.0), vec3(size - 1u)));
    shape.deviations = wide;
    amount *= BELL_WITHIN / (ROOT_TWO_PI * ROOT_TWO_PI * ROOT_TWO_PI * wide.x * wide.y * wide.z);
    return Bell(centre, shape, true, uvec3(last - first + 1), first, amount);
}

// How many parts or voxels it is, one at least: no axis is longer than a sixth of the grid, and so has no more than 768 parts.
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
    return square > GAUSSIAN_REACH * GAUSSIAN_REACH ? 0u : bell_units(bell.amount * exp(-0.5 * square));
}

// Where a part of a thin one is, and how much it has.
uint bell_part(Bell bell, uvec3 part, out vec3 place) {
    float amount = bell.amount;
    place = bell.centre;
    for (uint i = 0u; i < 3u; ++i) {
        if (bell.count[i] > 1u) {
            float step = 2.0 * GAUSSIAN_REACH / float(bell.count[i]), low = float(part[i]) * step - GAUSSIAN_REACH;
            amount *= BELL_AXIS * (gaussian_share(low + step) - gaussian_share(low));
            place += (low + 0.5 * step) * bell.shape.deviations[i] * bell.shape.axes[i];
        }
    }
    return bell_units(amount);
}
#endif
