// A particle in motion: its size fits the cache's sectors, so that it is read and written whole. Twin: scene::Body.
#ifndef WORLD_BODY_GLSL
#define WORLD_BODY_GLSL

struct Body {
    vec4 place;  // its middle, and its radius
    vec4 speed;  // per step, along each axis; and its extinction in the middle of its life
};
#endif
