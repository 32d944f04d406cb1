// Constants of a fountain's motion, in world units and steps. Twins: scene::Law, scene::Jet.
#ifndef SIMULATE_LAW_GLSL
#define SIMULATE_LAW_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Law {
    vec3 low;          // the box that particles stay in, by their middles
    vec3 high;
    float gravity;     // speed lost along z
    float drag;        // the share of its speed that a particle keeps in a step
    float pull;        // speed won for each unit of the way to the attractor, right at it
    float reach;       // 1 over the square of how far it reaches
    float bounce;      // the share of its speed that a particle keeps when it bounces off, across the surface
    float slide;       // and along it
    float rest;        // less speed than this along an axis is none: no speed is so small that a device flushes it
    float fastest;     // more there never is
    float radius;      // of the largest particle
    float extinction;  // in the middle of its life
    float appear;      // 1 over the steps in which a particle appears
    float vanish;      // and in which it goes
    uint life;         // steps from a particle's birth to its next
};

// Where particles are born: in a cube about `position`.
struct Jet {
    vec3 position;
    float width;
    vec3 speed;
    float spread;
};
#endif
