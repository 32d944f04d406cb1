// Distributes the amount of one point of a caster over the eight voxels whose centres surround it. Needs `deposit`. Twin:
// reference::twin::media::mote.
#ifndef GRID_MOTE_GLSL
#define GRID_MOTE_GLSL

void deposit_mote(vec3 place, uint amount) {
    vec3 at = clamp(place - 0.5, vec3(0.0), vec3(grid.size - 1u)), corner = floor(at);
    uvec3 voxel = uvec3(corner), share = uvec3((at - corner) * 256.0);
    uint z[2] = uint[2](0u, part_of(amount, share.z));
    z[0] = amount - z[1];
    for (uint i = 0u; i < 2u; ++i) {
        uint high = part_of(z[i], share.y), low = z[i] - high;
        uint low_x = part_of(low, share.x), high_x = part_of(high, share.x);
        deposit(voxel + uvec3(0u, 0u, i), low - low_x);
        deposit(voxel + uvec3(1u, 0u, i), low_x);
        deposit(voxel + uvec3(0u, 1u, i), high - high_x);
        deposit(voxel + uvec3(1u, 1u, i), high_x);
    }
}
#endif
