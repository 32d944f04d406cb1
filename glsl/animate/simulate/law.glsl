// Constants of a fountain's motion, in world units and steps. Twins: scene::Law, scene::Jet.
#ifndef SIMULATE_LAW_GLSL
#define SIMULATE_LAW_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Law {
    vec3 low;          // the box that particles stay in, by their middles
    vec3 high;
    float gravity;     // speed lost along z
    float drag;        // the share of its speed that a particle keeps in a step
    float pull;        // speed gained per unit of the way to the attractor, close to it
    float reach;       // 1 over the square of the attractor's reach
    float bounce;      // the share of its speed that a particle keeps when it bounces off, across the surface
    float slide;       // the same, along the surface
    float rest;        // a lower speed along an axis becomes 0: no speed is so small that a device flushes it to 0
    float fastest;     // the greatest speed along an axis
    float radius;      // of the largest particle
    float extinction;  // in the middle of its life
    float appear;      // 1 over the steps in which a particle appears
    float vanish;      // 1 over the steps in which a particle vanishes
    uint life;         // steps from a particle's birth to its next birth
};

// Where particles are born: in a cube about `position`.
struct Jet {
    vec3 position;
    float width;
    vec3 speed;
    float spread;
};
#endif
