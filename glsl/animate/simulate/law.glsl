// Constants of a fountain's motion, in world units and steps. Twins: scene::Law, scene::Jet.
#ifndef SIMULATE_LAW_GLSL
#define SIMULATE_LAW_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Law {
    vec3 low;          // box that the particles' centres stay in
    vec3 high;
    float gravity;     // speed lost along z per step
    float drag;        // share of its speed that a particle keeps in a step
    float pull;        // speed gained per unit of distance to the attractor, close to it
    float reach;       // 1 over the square of the attractor's reach
    float bounce;      // share of its speed across the surface that a particle keeps when it bounces
    float slide;       // share of its speed along the surface that a particle keeps when it bounces
    float rest;        // lower speeds along an axis become 0, so that none is denormal: some devices flush denormals to 0
    float fastest;     // greatest speed along an axis
    float radius;      // radius of the largest particle
    float extinction;  // extinction of a particle in the middle of its life
    float appear;      // 1 over the number of steps in which a particle appears
    float vanish;      // 1 over the number of steps in which a particle vanishes
    uint life;         // steps from a particle's birth to its next birth
};

// Where particles are born: in a cube around `position`.
struct Jet {
    vec3 position;
    float width;
    vec3 speed;
    float spread;
};
#endif
