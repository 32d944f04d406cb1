// A simulated particle: two quarters of a cache line's sector each, so that it is read and written whole. Twin: scene::Body.
#ifndef SIMULATE_BODY_GLSL
#define SIMULATE_BODY_GLSL

struct Body {
    vec4 place;  // its middle, and its radius
    vec4 speed;  // along each axis, a step; and its extinction in the middle of its life
};
#endif
