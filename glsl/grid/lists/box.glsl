// A box in a voxel, of 32 places along each axis: the first and the last that it reaches, five bits each in a word. Source: ours. Twin:
// reference::twin::lists, to the bit.
#ifndef GRID_LISTS_BOX_GLSL
#define GRID_LISTS_BOX_GLSL

// Places along each axis.
const uint BOX_PLACES = 32u;

// Where the first and the last places stand in the word.
const uvec3 BOX_FIRST = uvec3(0u, 5u, 10u);
const uvec3 BOX_LAST = uvec3(15u, 20u, 25u);

uvec3 box_places(uint box, uvec3 at) { return (uvec3(box) >> at) & (BOX_PLACES - 1u); }

uint box_word(uvec3 first, uvec3 last) {
    uvec3 low = first << BOX_FIRST, high = last << BOX_LAST;
    return low.x | low.y | low.z | high.x | high.y | high.z;
}

// What of a box from `low` to `high` is in a voxel.
uint box_in(vec3 low, vec3 high, uvec3 voxel) {
    precise vec3 first = (low - vec3(voxel)) * float(BOX_PLACES), last = (high - vec3(voxel)) * float(BOX_PLACES);
    vec3 end = vec3(BOX_PLACES - 1u);
    return box_word(uvec3(clamp(floor(first), vec3(0.0), end)), uvec3(clamp(floor(last), vec3(0.0), end)));
}

// About both.
uint box_about(uint a, uint b) {
    return box_word(min(box_places(a, BOX_FIRST), box_places(b, BOX_FIRST)),
                    max(box_places(a, BOX_LAST), box_places(b, BOX_LAST)));
}
#endif
