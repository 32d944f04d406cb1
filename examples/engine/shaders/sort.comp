#version 460
// Sorts the particles into drawing order, far to near: a bitonic sort (Batcher 1968) by one workgroup in shared memory. A key is 20 bits of
// nearness above the particle's index.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"

layout(local_size_x = 128) in;
layout(set = 0, binding = 0, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Order { uint order[]; };

shared uint keys[PARTICLES];

void main() {
    const float farthest = 16.0;
    for (uint i = gl_LocalInvocationIndex; i < PARTICLES; i += 128u) {
        float nearness = 1.0 - clamp(distance(frame.eye, particles[i].position) / farthest, 0.0, 1.0);
        keys[i] = uint(nearness * 1048575.0) << 12u | i;
    }
    for (uint run = 2u; run <= PARTICLES; run *= 2u) {
        for (uint step = run / 2u; step > 0u; step /= 2u) {
            barrier();
            for (uint pair = gl_LocalInvocationIndex; pair < PARTICLES / 2u; pair += 128u) {
                uint low = pair / step * step * 2u + pair % step, high = low + step;
                bool rises = (low & run) == 0u;
                uint a = keys[low], b = keys[high];
                if (a > b == rises) {
                    keys[low] = b;
                    keys[high] = a;
                }
            }
        }
    }
    barrier();
    for (uint i = gl_LocalInvocationIndex; i < PARTICLES; i += 128u) {
        order[i] = keys[i] & 4095u;
    }
}
