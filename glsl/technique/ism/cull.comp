#version 460
// Lists the points that lights see, projected, for a draw whose vertices read the list. Each subgroup counts its points with a ballot, the
// subgroups of a workgroup sum their counts in shared memory, and the workgroup reserves space in the list with one atomic operation.
// Source: Tokuyoshi 2014. Inputs: lights, points. Outputs: the list, the draw's arguments, seen. Invariant: every run lists the same
// points, in any order. Twin: reference::twin::ism::splat::is_seen.
// variants: BALLOTS 0 1
#if BALLOTS == 1
#extension GL_KHR_shader_subgroup_ballot : require
#endif
#include "technique/ism/atlas.glsl"
#include "technique/ism/drawn.glsl"

// Number of points that a thread tests before its workgroup reserves space, to save atomic operations.
const uint ROUNDS = 8u;
const uint CULL_THREADS = 128u;
const uint UNKEPT = 0xffffffffu;

layout(local_size_x = 128) in;

// set 0: ism_raster
layout(set = 0, binding = 7, scalar) writeonly buffer CullListed { vec4 listed[]; };
layout(set = 0, binding = 8, scalar) buffer CullDraw { uint draw[]; };  // a VkDrawIndirectCommand

shared uint kept;
shared uint first;

void main() {
    uint groups = points / (CULL_THREADS * ROUNDS), thread = gl_LocalInvocationIndex;
    uint light = GROUP_INDEX / groups, start = GROUP_INDEX % groups * CULL_THREADS * ROUNDS;
    if (light >= light_count) {
        return;
    }
    if (thread == 0u) {
        kept = 0u;
    }
    barrier();
    vec3 forward = lights[light].direction, origin = lights[light].position;
    Axes axes = axes_of(forward);
    uint places[ROUNDS];
    vec4 drawn[ROUNDS];
    for (uint round = 0u; round < ROUNDS; ++round) {
        IsmPoint point;
        float radius;
        Bounds bounds;
        bool keep = take(light, start + round * CULL_THREADS + thread, point, radius, bounds);
        precise vec3 offset = point.position - origin;
        keep = keep && dot(offset, offset) < FARTHEST && is_before(origin, forward, offset)
                 && is_seen(unpack_normal(point.normal), forward, offset, point_closed(point.normal));
        drawn[round] = drawn_point(light, axes, offset, radius, head.radius);
#if BALLOTS == 1
        uvec4 ballot = subgroupBallot(keep);
        uint of_subgroup = 0u;
        if (subgroupElect()) {
            of_subgroup = atomicAdd(kept, subgroupBallotBitCount(ballot));
        }
        uint place = subgroupBroadcastFirst(of_subgroup) + subgroupBallotExclusiveBitCount(ballot);
        places[round] = keep ? place : UNKEPT;
#else
        places[round] = keep ? atomicAdd(kept, 1u) : UNKEPT;
#endif
    }
    barrier();
    if (thread == 0u) {
        first = kept > 0u ? atomicAdd(draw[0], kept * DRAWN_VERTICES) / DRAWN_VERTICES : 0u;
        atomicAdd(seen[light], kept);
    }
    barrier();
    for (uint round = 0u; round < ROUNDS; ++round) {
        if (places[round] != UNKEPT) {
            listed[first + places[round]] = drawn[round];
        }
    }
}
