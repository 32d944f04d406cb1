// A moving particle. It is as large as a cache sector, so that it is read and written in one piece. Twin: scene::Body.
#ifndef WORLD_BODY_GLSL
#define WORLD_BODY_GLSL

struct Body {
    vec4 place;  // xyz: its centre; w: its radius
    vec4 speed;  // xyz: displacement per step along each axis; w: extinction halfway through its life
};
#endif
