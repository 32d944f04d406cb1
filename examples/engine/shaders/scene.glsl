// Shared by the renderer's own shaders: the per-frame constants and the particles.
#extension GL_EXT_scalar_block_layout : require

const uint PARTICLES = 4096u;

// Twin: Push in renderer/mod.rs.
layout(push_constant, scalar) uniform Push {
    mat4 clip;
    vec3 eye;
    float time_s;
    vec3 to_light;
    float turn_per_s;  // rotation of the sun about z, in radians per second
} frame;

// Twin: Particle in tests/embed/engine.rs. Gobo reads the first four members.
struct Particle {
    vec3 position;
    float radius;
    float extinction;
    float age;
};

// Twin: Sun in tests/embed/engine.rs. Gobo reads it if the device turns the sun.
struct Sun {
    vec3 direction;  // direction in which its light travels
    vec3 radiance;
};

const vec3 SUN = vec3(1.0, 0.93, 0.82) * 2.4;
const vec3 SKY = vec3(0.36, 0.46, 0.62);
