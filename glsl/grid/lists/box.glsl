// The part of a bounding box inside one voxel, packed into one word. Each axis of the voxel has 16 steps. The word has six lanes of four
// bits each, with a guard bit above each lane, which is set. From the lowest bit on, three lanes hold the box's last step along x, y and z;
// the next three hold the number of the voxel's steps after the box's first step. A second box, which is tested against the first, is a
// word without guard bits: its first step along x, y and z, then the number of steps after its last step. The two boxes overlap if no lane
// of the first word is less than the same lane of the second word. One subtraction compares all lanes. Sources: ours; lanes after Lamport
// 1975, Multiple byte processing with full-word instructions. Twin: reference::twin::lists, bit for bit.
#ifndef GRID_LISTS_BOX_GLSL
#define GRID_LISTS_BOX_GLSL

// Number of steps along each axis.
const uint BOX_PLACES = 16u;

const uint BOX_GUARDS = 0x21084210u;

uint box_lanes(uvec3 low, uvec3 high) {
    return low.x | low.y << 5 | low.z << 10 | high.x << 15 | high.y << 20 | high.z << 25;
}

// The step of a voxel that contains a point; `at`: the point's offset from the voxel's corner, in steps.
uvec3 box_place(vec3 at) { return uvec3(clamp(at, vec3(0.0), vec3(BOX_PLACES - 1u))); }

// The part of a box, from `low` to `high` in voxels, that is inside one voxel.
uint box_in(vec3 low, vec3 high, uvec3 voxel) {
    precise vec3 first = (low - vec3(voxel)) * float(BOX_PLACES), last = (high - vec3(voxel)) * float(BOX_PLACES);
    return box_lanes(box_place(last), BOX_PLACES - 1u - box_place(first)) | BOX_GUARDS;
}

// The smallest box that contains both boxes.
uint box_about(uint a, uint b) {
    uint more = (a - (b & ~BOX_GUARDS)) & BOX_GUARDS, mask = more - (more >> 4);
    return (a & mask) | (b & ~mask) | BOX_GUARDS;
}

// The box around two points, for box_is_met.
uint box_between(uvec3 a, uvec3 b) { return box_lanes(min(a, b), BOX_PLACES - 1u - max(a, b)); }

bool box_is_met(uint box, uint between) { return ((box - between) & BOX_GUARDS) == BOX_GUARDS; }
#endif
