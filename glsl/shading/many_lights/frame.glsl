// Shared by the passes that shade many lights in tiles: the lights, the cameras of this frame and the previous one, which lights reach a
// tile, and which are shadowed at a pixel. Twins: shading::many_lights::FrameData, ManyLightsPush.
#ifndef CONSUME_MANY_LIGHTS_FRAME_GLSL
#define CONSUME_MANY_LIGHTS_FRAME_GLSL
#include "world/light.glsl"

// How a frame sees the world.
struct Frame {
    View camera;
    // The direction of a pixel's ray, scaled so that its z is 1: corner + (x + ½) · across + (y + ½) · down. Computed once, on the host, so
    // that devices that divide differently find the same edges.
    vec3 corner;
    vec3 across;
    vec3 down;
    float edge;  // how far a point may be off a surface and still belong to it, world units per unit of z
};

layout(push_constant, scalar) uniform ManyLightsPush {
    uvec2 size;       // of the picture, pixels
    uint words;       // words per pixel, with one bit per light
    uint phase;       // the dither's offset within a step, in quarters: 2, or 1 and 3 alternately if two frames are averaged
    uint has_before;  // 1 if there is a previous frame
    float sky_red;
    float sky_green;
    float sky_blue;
    uint light_bits;  // number of bits of a job that hold the light
    uint capacity;    // capacity of the list, in jobs
};

// set 0: many_lights_frame
layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Frames { Frame frames[]; };  // this frame, the previous one
layout(set = 0, binding = 2, scalar) buffer Masks { uint masks[]; };              // tile by tile in rows, all words of a tile together
layout(set = 0, binding = 3, scalar) buffer Shadows { uint shadows[]; };          // word by word, the words of all pixels together

// Pixels per side of a tile.
const uint TILE = 16u;

// Index of a tile's first word.
uint tile_words(uvec2 tile) { return (tile.y * ((size.x + TILE - 1u) / TILE) + tile.x) * words; }

uint pixel_index(uvec2 pixel) { return pixel.y * size.x + pixel.x; }

// Index of a pixel's word in shadows[]. A set bit means that the light is shadowed at the pixel. Lights that are not queried count as not
// shadowed.
uint shadow_word(uint pixel, uint word) { return word * size.x * size.y + pixel; }

vec3 frame_direction(Frame frame, uvec2 pixel) {
    precise vec3 direction = frame.corner + (float(pixel.x) + 0.5) * frame.across + (float(pixel.y) + 0.5) * frame.down;
    return direction;
}
#endif
