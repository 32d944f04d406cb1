#version 460
// Builds each light's map in shared memory, one workgroup per light: splats the light's points, fills the holes between them, and writes
// each texel to memory once. Source: ours. Inputs: lights, points. Outputs: maps, seen. Invariant: a texel holds the nearest point,
// regardless of order, so every run writes the same bytes, and technique/ism/splat.comp writes them too. Twin:
// reference::twin::ism::splat, fill.
#include "technique/ism/atlas.glsl"

CONSTANT(uint, THREADS, 128u)

layout(local_size_x_id = ID_WORKGROUP) in;

shared uint levels[ISM_TEXELS];

uint texel_get(uint i) { return levels[i]; }
void texel_set(uint i, uint value) { levels[i] = value; }
void texel_barrier() { barrier(); }

#include "technique/ism/fill.glsl"

void main() {
    uint light = GROUP_INDEX, thread = gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    for (uint i = thread; i < ISM_TEXELS; i += THREADS) {
        levels[i] = NOTHING;
    }
    barrier();
    Axes axes = axes_of(lights[light].direction);
    vec3 origin = lights[light].position;
    uint kept = 0u;
    // Fetches the next point while the current one is splatted.
    IsmPoint next;
    float next_radius;
    Bounds next_bounds;
    bool takes = take(light, thread, next, next_radius, next_bounds);
    for (uint i = thread; i < points && takes; i += THREADS) {
        IsmPoint point = next;
        float radius = next_radius;
        Bounds bounds = next_bounds;
        takes = take(light, min(i + THREADS, points - 1u), next, next_radius, next_bounds);
        Splat splat;
        if (!project(axes, origin, point, radius, bounds, splat)) {
            continue;
        }
        ++kept;
        if (takes_own(splat)) {
            atomicMin(levels[texel_index(splat.level, splat.texel)], own_distance(splat));
        }
        for (int y = splat.low.y; y <= splat.high.y; ++y) {
            for (int x = splat.low.x; x <= splat.high.x; ++x) {
                uint distance = disc_at(axes, splat, ivec2(x, y));
                if (distance < NOTHING) {
                    atomicMin(levels[texel_index(splat.level, ivec2(x, y))], distance);
                }
            }
        }
    }
    barrier();
    wide_down(thread, THREADS);
    if (ISM_FILL) {
        pull(thread, THREADS, head.radius);
        push(thread, THREADS, head.radius);
    }
    uint texels = ISM_SIZE * ISM_SIZE;
    for (uint i = thread; i < texels; i += THREADS) {
        maps[light * texels + i] = levels[i];
    }
    if (kept > 0u) {
        atomicAdd(seen[light], kept);
    }
}
