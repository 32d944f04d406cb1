#version 460
// Chooses the points that each light takes, one workgroup per light. A light takes at least one point from each cluster that it may see. It
// takes more points from clusters that cover more texels of its map or are nearer to the viewer. Source: Ritschel et al. 2011 (importance
// to the view and to the light); the clusters are ours. Inputs: lights, head, clusters. Output: taken. Invariants: from the ranks on, all
// numbers are integers, so that every run chooses the same points; a light takes the points of a cluster in a fixed order, so that small
// motions change little. Twin: reference::twin::ism::adapt.
#include "technique/ism/map.glsl"
#include "technique/ism/splat.glsl"
#include "technique/ism/adaptive.glsl"

const uint ADAPT_THREADS = 128u;

layout(local_size_x = 128) in;

layout(push_constant, scalar) uniform AdaptPush {
    uint light_count;
    uint points;  // most points that a light takes
    vec3 eye;
    float near;   // clusters nearer to the eye than this count as equally near
};

// set 0: ism_adapt
layout(set = 0, binding = 0, scalar) readonly buffer AdaptLights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer AdaptHead { IsmPoints head; };
layout(set = 0, binding = 2, scalar) readonly buffer AdaptClusters { IsmCluster clusters[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer AdaptTaken { uint taken[]; };

// The clusters of a light, at most 4,096, two per word: first each cluster's rank, then the number of points of the clusters before it.
shared uint pairs[2048];
// Number of clusters per rank; then prefix sums of the points of each thread's clusters.
shared uint histogram[ADAPT_THREADS];
shared uint scan[2][ADAPT_THREADS];
// Cluster of the first point in each run of RUN points.
shared uint run_firsts[16384u / RUN];
shared uint best;
shared uint first_more;

// Ranks measure the texels that a cluster covers in eighths of an octave, from 2^-8 on; 0: not seen.
const uint RANKS = 128u;
const uint RANK_SHIFT = 20u;
const uint LOWEST_RANK = 951u;
// Rates measure points per texel in the same way, from 2^-10 to 4.
const uint LOWEST_RATE = 936u;
const uint RATES = 97u;

// Minimum weight of a slanted cluster, as a share of its weight if it faced the light.
const float LEAST_FACING = 0.25;
// Weight of the cluster farthest from the eye, as a share of the nearest cluster's weight.
const float LEAST_NEAR = 0.25;

// Returns a cluster's rank for a light.
uint rank_of(vec3 origin, vec3 forward, IsmCluster cluster) {
    precise vec3 offset = cluster.middle - origin;
    precise float square = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z;
    precise float before = forward.x * offset.x + forward.y * offset.y + forward.z * offset.z;
    precise float lean = forward.x * cluster.normal.x + forward.y * cluster.normal.y + forward.z * cluster.normal.z;
    precise float support = abs(lean) * cluster.thick + cluster.reach * sqrt(max(1.0 - lean * lean, 0.0));
    precise float sum = abs(offset.x) + abs(offset.y) + abs(offset.z), sum_origin = abs(origin.x) + abs(origin.y) + abs(origin.z);
    // The tests is_before and is_seen for the whole cluster: passed if any of its points may pass, with a margin for rounding.
    precise float far = SLANT * max(sum - 1.75 * cluster.reach, 0.0);
    if (!(square < FARTHEST) || !(before + 1.001 * support > 0.99 * far)) {
        return 0u;
    }
    precise float distance = sqrt(square);
    vec3 along = ISM_SLIDE ? forward : offset;
    precise float away = cluster.normal.x * along.x + cluster.normal.y * along.y + cluster.normal.z * along.z;
    away = ISM_CULLING == CULL_FAR ? -away : away;
    precise float wide = ISM_SLIDE ? 1.0 : distance + cluster.reach;
    precise float most = away + (ISM_SLIDE ? 0.0 : cluster.thick) + 1.001 * cluster.spread * wide + 1e-5 * wide + 1e-6 * sum_origin;
    if (ISM_CULLING != CULL_NONE && cluster.closed != 0u && !(most > 0.0)) {
        return 0u;
    }
    precise float straight = cluster.normal.x * offset.x + cluster.normal.y * offset.y + cluster.normal.z * offset.z;
    precise float facing = min(max(abs(straight) / max(distance, 1e-30), LEAST_FACING) + cluster.spread, 1.0);
    precise float ahead = max(distance + max(before, 0.0), max(cluster.reach, 1e-18));
    precise float texel = ahead * (2.0 / float(ISM_SIZE));
    precise float texels = head.area * (float(CLUSTER) / (float(SUBSETS) * float(points))) / texel / texel * facing;
    precise vec3 from_eye = cluster.middle - eye;
    precise float behind = (from_eye.x * from_eye.x + from_eye.y * from_eye.y + from_eye.z * from_eye.z) / (near * near);
    precise float worth = texels * max(1.0 / max(behind, 1.0), LEAST_NEAR);
    return clamp(floatBitsToUint(worth) >> RANK_SHIFT, LOWEST_RANK + 1u, LOWEST_RANK + RANKS - 1u) - LOWEST_RANK;
}

// Returns how many points a light takes from a cluster of this rank, at this rate. The factors have only a few bits each, so products are
// exact on all devices.
uint count_of(uint rank, uint rate) {
    float worth = uintBitsToFloat((rank + LOWEST_RANK) << RANK_SHIFT), times = uintBitsToFloat((rate + LOWEST_RATE) << RANK_SHIFT);
    return rank == 0u ? 0u : clamp(uint(min(worth * times, 64.0)), 1u, CLUSTER);
}

// Returns the number of points of all clusters; clusters of rank `more` and higher use the next rate.
uint total_of(uint rate, uint more) {
    uint total = 0u;
    for (uint rank = 1u; rank < RANKS; ++rank) {
        total += histogram[rank] * count_of(rank, rate + uint(rank >= more));
    }
    return total;
}

uint half_of(uint i) { return pairs[i >> 1u] >> 16u * (i & 1u) & 0xffffu; }

void main() {
    uint light = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, thread = gl_LocalInvocationIndex;
    if (light >= light_count) {
        return;
    }
    uint count = head.total == 0u ? 0u : points * SUBSETS / CLUSTER;
    histogram[thread] = 0u;
    if (thread == 0u) {
        best = 0u;
        first_more = RANKS;
    }
    barrier();
    vec3 origin = lights[light].position, forward = lights[light].direction;
    for (uint i = thread; i < count / 2u; i += ADAPT_THREADS) {
        uint low = rank_of(origin, forward, clusters[2u * i]), high = rank_of(origin, forward, clusters[2u * i + 1u]);
        pairs[i] = low | high << 16u;
        atomicAdd(histogram[low], 1u);
        atomicAdd(histogram[high], 1u);
    }
    barrier();
    if (thread < RATES && total_of(thread, RANKS) <= points) {
        atomicMax(best, thread);
    }
    barrier();
    uint rate = best;
    // The remaining points go to the highest ranks.
    if (rate + 1u < RATES && thread > 0u && total_of(rate, thread) <= points) {
        atomicMin(first_more, thread);
    }
    barrier();
    uint more = first_more, own = count / 2u / ADAPT_THREADS, sum = 0u;
    for (uint i = thread * own; i < (thread + 1u) * own; ++i) {
        for (uint part = 0u; part < 2u; ++part) {
            uint rank = half_of(2u * i + part);
            sum += count_of(rank, rate + uint(rank >= more));
        }
    }
    uint from = 0u;
    scan[from][thread] = sum;
    barrier();
    for (uint step = 1u; step < ADAPT_THREADS; step *= 2u) {
        scan[1u - from][thread] = scan[from][thread] + (thread >= step ? scan[from][thread - step] : 0u);
        from = 1u - from;
        barrier();
    }
    uint start = scan[from][thread] - sum, total = scan[from][ADAPT_THREADS - 1u];
    for (uint i = thread * own; i < (thread + 1u) * own; ++i) {
        uint starts[2];
        for (uint part = 0u; part < 2u; ++part) {
            uint rank = half_of(2u * i + part), end = start + count_of(rank, rate + uint(rank >= more));
            for (uint run = (start + RUN - 1u) / RUN; run * RUN < end; ++run) {
                run_firsts[run] = 2u * i + part;
            }
            starts[part] = start;
            start = end;
        }
        pairs[i] = starts[0] | starts[1] << 16u;
    }
    barrier();
    uint scrambled = ism_hash(light);
    for (uint i = thread; i < points; i += ADAPT_THREADS) {
        uint code = UNTAKEN;
        if (i < total) {
            uint low = run_firsts[i / RUN], high = (i / RUN + 1u) * RUN < total ? run_firsts[i / RUN + 1u] : count - 1u;
            while (low < high) {
                uint middle = (low + high + 1u) / 2u;
                if (half_of(middle) <= i) {
                    low = middle;
                } else {
                    high = middle - 1u;
                }
            }
            uint before = half_of(low), own_count = (low + 1u < count ? half_of(low + 1u) : total) - before, j = i - before;
            // The first 2^k points lie one in each part of the cluster; further points halve these parts, one at a time.
            uint k = uint(findMSB(own_count)), halved = k + uint(j >= 1u << k || j < own_count - (1u << k));
            uint place = bitfieldReverse(j) >> (32u - CLUSTER_BITS) ^ ism_hash(scrambled + low) % CLUSTER;
            code = low * CLUSTER + place | halved << TAKEN_BITS;
        }
        taken[light * points + i] = code;
    }
}
