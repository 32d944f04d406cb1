#version 460
// Moves the smoke, one particle per thread, and the sun. Puffs of 64 particles rise, widen and thin out; each position depends only on the
// particle's index and the time, so that nothing is kept from frame to frame.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) writeonly buffer Particles { Particle particles[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Suns { Sun sun; };

// Uniform in [0, 1), and always the same for the same number. PCG: Jarzynski and Olano 2020, Hash Functions for GPU Rendering.
float evenly(uint number) {
    uint state = number * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return float(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

void main() {
    uint i = gl_GlobalInvocationID.x, puff = i / 64u;
    if (i == 0u) {
        float by = frame.turn_per_s * frame.time_s, c = cos(by), s = sin(by);
        vec3 l = frame.to_light;
        sun = Sun(-normalize(vec3(c * l.x - s * l.y, s * l.x + c * l.y, l.z)), SUN);
    }
    float age = fract(frame.time_s * 0.125 + float(puff) * 0.015625);
    float turn = 6.2831853 * evenly(puff), reach = 0.05 + 0.3 * age;
    vec3 centre = vec3(reach * cos(turn) + 0.45 * age * age, reach * sin(turn), 0.25 + 1.9 * age);

    // Position inside the puff's ball: a direction, and a distance that fills the ball evenly.
    uint own = 0x10000u + 3u * i;
    float around = 6.2831853 * evenly(own), height = 2.0 * evenly(own + 1u) - 1.0, flat_part = sqrt(1.0 - height * height);
    float from_centre = (0.1 + 0.2 * age) * pow(evenly(own + 2u), 1.0 / 3.0);
    vec3 position = centre + from_centre * vec3(flat_part * cos(around), flat_part * sin(around), height);

    // The puff fades in and out, so that it never pops.
    float extinction = 9.0 * smoothstep(0.0, 0.08, age) * (1.0 - age) * (1.0 - 0.5 * age);
    particles[i] = Particle(position, 0.035 + 0.05 * age, extinction, age);
}
