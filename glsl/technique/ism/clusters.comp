#version 460
// Computes the bounds, centre and mean normal of each cluster of points, one workgroup per cluster. Source: ours. Inputs: the pool. Output:
// clusters. Invariant: bounds hold for every point of the cluster that is not in a hole. Twin: reference::twin::ism::clusters.
#include "technique/ism/adaptive.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform ClustersPush { uint cluster_count; };

// set 0: ism_clusters
layout(set = 0, binding = 0, scalar) readonly buffer ClustersPool { IsmPoint pool[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer ClustersOut { IsmCluster clusters[]; };

// Beyond any coordinate.
const float MOST = 3e38;

shared vec3 lows[CLUSTER];
shared vec3 highs[CLUSTER];
shared vec3 sums[CLUSTER];
shared uint all_closed;

void main() {
    uint cluster = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    if (cluster >= cluster_count) {
        return;
    }
    IsmPoint point = pool[cluster * CLUSTER + thread];
    vec3 normal = unpack_normal(point.normal);
    // A point in a hole of a mesh is NaN.
    bool stands = (floatBitsToUint(point.position.x) & 0x7fffffffu) <= 0x7f800000u;
    lows[thread] = stands ? point.position : vec3(MOST);
    highs[thread] = stands ? point.position : vec3(-MOST);
    sums[thread] = stands ? normal : vec3(0.0);
    if (thread == 0u) {
        all_closed = 1u;
    }
    barrier();
    if (stands && !point_closed(point.normal)) {
        atomicAnd(all_closed, 0u);
    }
    for (uint step = CLUSTER / 2u; step > 0u; step /= 2u) {
        if (thread < step) {
            lows[thread] = min(lows[thread], lows[thread + step]);
            highs[thread] = max(highs[thread], highs[thread + step]);
            sums[thread] += sums[thread + step];
        }
        barrier();
    }
    precise vec3 middle = 0.5 * (lows[0] + highs[0]);
    precise vec3 sides = 0.5 * (highs[0] - lows[0]);
    // No light takes a cluster of holes alone.
    middle = lows[0].x == MOST ? vec3(uintBitsToFloat(0x7fc00000u)) : middle;
    vec3 sum = sums[0];
    precise float square = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
    // Normals that point in all directions have no mean.
    vec3 mean = square > 1.0 ? sum / sqrt(square) : vec3(0.0);
    barrier();
    precise vec3 off = point.position - middle, lean = normal - mean;
    precise float far = off.x * off.x + off.y * off.y + off.z * off.z;
    precise float slant = lean.x * lean.x + lean.y * lean.y + lean.z * lean.z;
    precise float rise = abs(mean.x * off.x + mean.y * off.y + mean.z * off.z);
    sums[thread] = stands ? vec3(sqrt(far), sqrt(slant), rise) : vec3(0.0);
    barrier();
    for (uint step = CLUSTER / 2u; step > 0u; step /= 2u) {
        if (thread < step) {
            sums[thread] = max(sums[thread], sums[thread + step]);
        }
        barrier();
    }
    if (thread == 0u) {
        clusters[cluster] = IsmCluster(middle, sums[0].x, mean, sums[0].y, sides, sums[0].z, all_closed);
    }
}
