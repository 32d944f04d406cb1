#version 460
// Computes the bounds, centre and mean normal of each cluster of points, one workgroup per cluster. Source: ours. Inputs: the pool. Output:
// clusters. Invariant: bounds hold for every point of the cluster. Twin: reference::twin::ism::clusters.
#include "technique/ism/adaptive.glsl"

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform ClustersPush { uint cluster_count; };

// set 0: ism_clusters
layout(set = 0, binding = 0, scalar) readonly buffer ClustersPool { IsmPoint pool[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer ClustersOut { IsmCluster clusters[]; };

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
    lows[thread] = point.position;
    highs[thread] = point.position;
    sums[thread] = normal;
    if (thread == 0u) {
        all_closed = 1u;
    }
    barrier();
    if (!point_closed(point.normal)) {
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
    vec3 sum = sums[0];
    precise float square = sum.x * sum.x + sum.y * sum.y + sum.z * sum.z;
    // Normals that point in all directions have no mean.
    vec3 mean = square > 1.0 ? sum / sqrt(square) : vec3(0.0);
    barrier();
    precise vec3 off = point.position - middle, lean = normal - mean;
    precise float far = off.x * off.x + off.y * off.y + off.z * off.z;
    precise float slant = lean.x * lean.x + lean.y * lean.y + lean.z * lean.z;
    precise float rise = abs(mean.x * off.x + mean.y * off.y + mean.z * off.z);
    sums[thread] = vec3(sqrt(far), sqrt(slant), rise);
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
