// Shared by the passes that shade many lights in tiles: the lights, the cameras of this frame and the one before, which lights reach a
// tile, and which are shadowed at a pixel. Twins: shading::many_lights::FrameData, ManyLightsPush.
#ifndef CONSUME_MANY_LIGHTS_FRAME_GLSL
#define CONSUME_MANY_LIGHTS_FRAME_GLSL
#include "world/light.glsl"

// How a frame sees the world.
struct Frame {
    View camera;
    // The direction of a pixel's ray, scaled so that z along it is 1: corner + (x + ½) · across + (y + ½) · down. Computed
    // once, on the host, so that devices that divide differently find the same edges.
    vec3 corner;
    vec3 across;
    vec3 down;
    float edge;  // how far a point may lie off a surface and still belong to it, world units per unit of z
};

layout(push_constant, scalar) uniform ManyLightsPush {
    uvec2 size;       // pixels
    uint words;       // per pixel: a bit per light
    uint phase;       // offset within a step of the dither, in quarters: 2; where two frames are averaged, 1 and 3 alternately
    uint has_before;  // 1 where there is a frame before
    float sky_red;
    float sky_green;
    float sky_blue;
    uint light_bits;  // bits of a job that hold the light
    uint capacity;    // jobs
};

// set 0: many_lights_frame
layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Frames { Frame frames[]; };  // this one, the one before
layout(set = 0, binding = 2, scalar) buffer Masks { uint masks[]; };              // row by row of tiles, all words of a tile together
layout(set = 0, binding = 3, scalar) buffer Shadows { uint shadows[]; };          // word by word, all pixels of a word together

// Pixels per side.
const uint TILE = 16u;

// The first of a tile's words.
uint tile_words(uvec2 tile) { return (tile.y * ((size.x + TILE - 1u) / TILE) + tile.x) * words; }

uint pixel_index(uvec2 pixel) { return pixel.y * size.x + pixel.x; }

// The index of a pixel's word in shadows[]. A set bit says that the light is shadowed at the pixel. Lights that are not
// asked for count as not shadowed.
uint shadow_word(uint pixel, uint word) { return word * size.x * size.y + pixel; }

vec3 frame_direction(Frame frame, uvec2 pixel) {
    precise vec3 direction = frame.corner + (float(pixel.x) + 0.5) * frame.across + (float(pixel.y) + 0.5) * frame.down;
    return direction;
}
#endif
