// Distributes a volume's cell over voxels. A voxel's number is the mean of the field over a cube of the voxel's size around the voxel's
// centre, rotated with the volume. Adjacent cells therefore divide the voxels between them: nothing is lost or counted twice, whatever the
// volume's rotation. Source: ours. Twin: reference::twin::media::Slab; not bit for bit, since devices unpack a shape with different
// rounding.
#ifndef GRID_CELL_GLSL
#define GRID_CELL_GLSL
#include "grid/media.glsl"
#include "world/caster.glsl"

struct Slab {
    vec3 centre;  // voxels
    SplatShape shape;
    float extinction;  // per voxel of path
    ivec3 first;
    ivec3 last;
};

Slab slab_of(vec3 centre, float radius, vec3 packed, float extinction, uint size) {
    SplatShape shape = cell_shape(radius, packed);
    vec3 reach = vec3(0.0);
    for (uint i = 0u; i < 3u; ++i) {
        reach += abs(shape.axes[i]) * (shape.deviations[i] + 0.5);
    }
    ivec3 first = ivec3(clamp(floor(centre - reach - 0.5), vec3(0.0), vec3(size - 1u)));
    ivec3 last = ivec3(clamp(floor(centre + reach), vec3(0.0), vec3(size - 1u)));
    return Slab(centre, shape, extinction, first, last);
}

// Share of the interval from at − ½ to at + ½ that lies within `half_side` of 0.
float slab_share(float at, float half_side) {
    return clamp(at + half_side, -0.5, 0.5) - clamp(at - half_side, -0.5, 0.5);
}

// Amount of the cell in one voxel.
uint slab_amount(Slab slab, ivec3 voxel) {
    vec3 from = vec3(voxel) + 0.5 - slab.centre;
    float share = 1.0;
    for (uint i = 0u; i < 3u; ++i) {
        share *= slab_share(dot(slab.shape.axes[i], from), slab.shape.deviations[i]);
    }
    return uint(min(slab.extinction * share, MAX_OPTICAL_DEPTH) * MEDIA_UNITS);
}
#endif
