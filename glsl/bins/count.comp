#version 460
// Counts the particles of each tile. Inputs: light, particles. Outputs: counts (cleared before), culled particles.
#include "bins/tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 1, binding = 0, scalar) buffer Counts { uint counts[]; };
layout(set = 1, binding = 3, scalar) buffer Totals {
    uint entry_total;
    uint culled;
    uint tiles_used;
};

layout(push_constant, scalar) uniform Push {
    uint particle_count;
    uint capacity;
};

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= particle_count) {
        return;
    }
    View view = lights[0].volume;
    Particle particle = particles[index];
    uvec2 low, high;
    if (!particle_tiles(view, particle, low, high)) {
        atomicAdd(culled, 1u);
        return;
    }
    uint columns = tile_counts(view).x;
    for (uint y = low.y; y <= high.y; ++y) {
        for (uint x = low.x; x <= high.x; ++x) {
            if (!tile_missed(tile_distance(view, particle, uvec2(x, y)))) {
                atomicAdd(counts[y * columns + x], 1u);
            }
        }
    }
}
