#version 460
// Splats all points into all maps at once, with atomic operations, one thread per point. Source: ours. Inputs: lights, points. Outputs:
// maps, filled with NOTHING beforehand; seen. Invariant: as in technique/ism/tiled.comp. Twin: reference::twin::ism::splat.
#include "technique/ism/atlas.glsl"

layout(local_size_x = 128) in;

shared uint kept;

void main() {
    // The workgroups of a light are consecutive.
    uint groups = points / 128u;
    uint light = GROUP_INDEX / groups, i = GROUP_INDEX % groups * 128u + gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    if (gl_LocalInvocationIndex == 0u) {
        kept = 0u;
    }
    barrier();
    IsmPoint point;
    float radius;
    Bounds bounds;
    Axes axes = axes_of(lights[light].direction);
    Splat splat;
    if (take(light, i, point, radius, bounds) && project(axes, lights[light].position, point, radius, bounds, splat)) {
        atomicAdd(kept, 1u);
        uint start = light * ISM_TEXELS;
        if (takes_own(splat)) {
            atomicMin(maps[start + texel_index(splat.level, splat.texel)], own_distance(splat));
        }
        for (int y = splat.low.y; y <= splat.high.y; ++y) {
            for (int x = splat.low.x; x <= splat.high.x; ++x) {
                uint distance = disc_at(axes, splat, ivec2(x, y));
                if (distance < NOTHING) {
                    atomicMin(maps[start + texel_index(splat.level, ivec2(x, y))], distance);
                }
            }
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && kept > 0u) {
        atomicAdd(seen[light], kept);
    }
}
