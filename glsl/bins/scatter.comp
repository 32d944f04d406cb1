#version 460
// Writes (key, particle) of each particle into each of its tiles, in any order: whoever reads a tile sorts it, and no
// two entries of a tile are equal. Inputs: light, particles, cursors. Outputs: entries.
#include "bins/tiles.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Particles { Particle particles[]; };
layout(set = 1, binding = 2, scalar) buffer Cursors { uint cursors[]; };
layout(set = 1, binding = 4, scalar) writeonly buffer Entries { uvec2 entries[]; };

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
        return;
    }
    uint columns = tile_counts(view).x;
    for (uint y = low.y; y <= high.y; ++y) {
        for (uint x = low.x; x <= high.x; ++x) {
            float distance_square = tile_distance(view, particle, uvec2(x, y));
            if (!tile_missed(distance_square)) {
                uint slot = atomicAdd(cursors[y * columns + x], 1u);
                if (slot < capacity) {
                    entries[slot] = uvec2(tile_key(view, particle, distance_square), index);
                }
            }
        }
    }
}
