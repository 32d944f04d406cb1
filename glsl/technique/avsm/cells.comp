#version 460
// Builds the curves of a tile of 8×8 texels, or of half of one, in any order of the casters. The shader divides each texel's own depth
// range into CELLS even cells and adds up the casters' optical depth in each cell. The curve through the cells' ends is exact at these
// ends. The shader compresses that curve and fits the nodes that are left to all of the cells' ends.
// Inputs: maps, casters, parts, entries. Outputs: nodes of tiles that have casters.
// Invariants: cells are whole numbers, so the result depends only on the casters, not on the order they come in; the first segment that
// lets no light through keeps its own two depths, and segments behind it are left out. Source: ours.
// Twin: reference::twin::avsm::cells.

// LANES 0: a whole tile. LANES 1: half a tile, with casters in lanes (maps/bins/batch.glsl), for software devices. LANES 2: half a tile,
// otherwise as LANES 0, for devices of little shared memory or of few threads.
// variants: LANES 0 1 2
#include "maps/curve/curve.glsl"
#include "maps/bins/area.glsl"
#include "maps/bins/sums.glsl"

#if LANES == 0
const uint TEXELS = 64u;
#else
const uint TEXELS = 32u;
#endif
// Threads per texel: how many casters are looked at, and how many thresholds are tried, at the same time. Usually 4; 8 for curves of 16
// nodes, whose registers leave room for few workgroups; 16 for the fullest tiles where there are very many casters; 1 where threads of a
// workgroup do not run at the same time.
layout(local_size_x = TEXELS, local_size_y_id = ID_WORKGROUP) in;
// The same number: some tools do not take gl_WorkGroupSize for a constant where it is specialized.
CONSTANT(uint, GROUPS, 4u)
const uint THREADS = TEXELS * GROUPS;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// How many casters are fetched at a time: as many as fit into the memory that holds the nodes while they are fitted (NODES * TEXELS / 4
// casters), but at least 32 per group.
CONSTANT(uint, BATCH, 128u)
#define BATCH BATCH
#include "maps/curve/store.glsl"
#include "maps/bins/batch.glsl"

const int CELLS = 64;
// A cell's end stays out of the curve where that changes the area under the curve by less than LEFT_OUT / NODES². That is at least a
// hundredth of the area that curves of NODES nodes lose on smoke. If too many ends would stay, the next threshold is tried, which is
// COARSER times as high; there are THRESHOLDS thresholds.
const float LEFT_OUT = 6.4e-4;
const float COARSER = 2.5;
const uint THRESHOLDS = 4u;

// Cell c of texel t is at c · TEXELS + t, so that the threads of a subgroup never meet in a bank. While casters are added, a cell holds the
// optical depth that segments have in it minus the optical depth that they have in the cell before, in whole units. After sum_cells it
// holds the optical depth from the start of the first cell to its own end, as the bits of a float. Each texel has one extra cell at the
// end, which is never read.
shared uint cells[(CELLS + 1) * TEXELS];
// Bits of non-negative floats, which order as the floats do.
const uint NEVER = 0x7F800000u;
shared uint low_bits[TEXELS];
shared uint high_bits[TEXELS];
// The first segment that lets no light through, if a texel has one: the depth where it has become dark, and the depth
// where it begins.
shared uint dark_bits[TEXELS];
shared uint dark_from_bits[TEXELS];
shared uint bound[2];
// Bit i: the end of cell i stays, at each threshold.
shared uvec2 ends[THRESHOLDS][TEXELS];

// Nodes take the memory of the casters, which are all added up by then.
#if LANES == 1
shared vec4 fitted[NODES / 2 * TEXELS];
#define FITTED fitted
#else
#define FITTED batch
#endif
#include "technique/avsm/fit.glsl"

float optical_depth_at(uint texel, int cell) {
    return uintBitsToFloat(cells[uint(cell) * TEXELS + texel]);
}

// Which cells' ends stay in the curve, one bit each. The last end stays. Any other end stays if leaving it out would change the curve by at
// least `loss`. That change is twice the area of the triangle between three ends (the last end that stayed, this end, the next end), times
// the transmittance at the first of them. Its unit is cells times optical depth.
uvec2 ends_that_stay(uint texel, float loss) {
    uvec2 mask = uvec2(0u, 0x80000000u);
    float before = 0.0, light = 1.0, extent = 1.0, here = optical_depth_at(texel, 0);
    for (int i = 0; i < CELLS - 1; ++i) {
        float next = optical_depth_at(texel, i + 1);
        float triangle = (here - before) * (extent + 1.0) - (next - before) * extent;
        bool stays = abs(triangle) * light >= loss;
        mask.x |= stays && i < 32 ? 1u << i : 0u;
        mask.y |= stays && i >= 32 ? 1u << (i - 32) : 0u;
        before = stays ? here : before;
        light = stays ? exp(-here) : light;
        extent = stays ? 1.0 : extent + 1.0;
        here = next;
    }
    return mask;
}

// Whether at most 5/2 NODES ends stay. Where nodes are fitted afterwards the limit is 3/2 NODES: the result is as good, and two thirds of
// the removals are saved.
bool few_enough(uvec2 mask) {
    return bitCount(mask.x) + bitCount(mask.y) <= (TURNS == 0 ? 5 : 3) * NODES / 2;
}

#include "technique/avsm/changes.glsl"

struct TexelRay {
    View view;
    Ray ray;
    float ray_length;
    uint texel;  // of the workgroup
};

// z at which casters begin and end along a ray, and z from which on the ray is dark.
struct Reach {
    float low;
    float high;
    float dark;
};

// A texel's cells. `low`, `high`: where they begin and end in the light's range. `per_cell`, `per_z`: how many cells fit into the whole
// range, and into one world unit. `z_per_cell`: world units per cell. `ends_dark`: whether the cells end where it is dark. `scale`: units
// per optical depth of 1.
struct Range {
    float low;
    float high;
    float per_cell;
    float per_z;
    float z_per_cell;
    bool ends_dark;
    float scale;
};

void reach_caster(TexelRay its, Caster caster, inout Reach reach) {
    vec2 z;
    float optical_depth;
    if (texel_part(its.view, its.ray, its.ray_length, caster, DARK, z, optical_depth)) {
        reach.low = min(reach.low, z.x);
        reach.high = max(reach.high, z.y);
        reach.dark = optical_depth >= DARK ? min(reach.dark, z.y) : reach.dark;
    }
}

// Merges one thread's results for a texel into those of all threads.
void share_reach(TexelRay its, Reach reach) {
    float per_depth = 1.0 / (its.view.far - its.view.near), high = (reach.high - its.view.near) * per_depth;
    if (high >= 0.0) {
        atomicMin(low_bits[its.texel], floatBitsToUint(max((reach.low - its.view.near) * per_depth, 0.0)));
        // One more than the bits, so that 0 says that nothing was hit.
        atomicMax(high_bits[its.texel], floatBitsToUint(high) + 1u);
    }
    if (reach.dark < FARTHEST) {
        atomicMin(dark_bits[its.texel], floatBitsToUint(max((reach.dark - its.view.near) * per_depth, 0.0)));
    }
}

// The part of a caster that lies within the cells of a texel: its place, in cells, and its optical depth. For the first opaque caster the
// function only notes where the caster begins, and returns no part.
bool caster_within(TexelRay its, Caster caster, Range range, out vec2 at, out float optical_depth) {
    vec2 z;
    at = vec2(0.0);
    if (!texel_part(its.view, its.ray, its.ray_length, caster, DARK, z, optical_depth)) {
        return false;
    }
    vec2 depth = (z - its.view.near) * (1.0 / (its.view.far - its.view.near));
    if (optical_depth >= DARK && floatBitsToUint(max(depth.y, 0.0)) == dark_bits[its.texel]) {
        atomicMin(dark_from_bits[its.texel], floatBitsToUint(max(depth.x, 0.0)));
        return false;
    }
    optical_depth *= range.ends_dark && depth.y > range.high ? (range.high - depth.x) / (depth.y - depth.x) : 1.0;
    at = clamp((depth - range.low) * range.per_cell, 0.0, float(CELLS));
    return !range.ends_dark || depth.x < range.high;
}

// Both files define two passes over all of a tile's casters. find_range sets low_bits, high_bits, dark_bits and a bound of the optical
// depth on any ray; add_casters adds the casters up in the cells.
#if LANES == 1
#include "technique/avsm/cells_lanes.glsl"
#else
#include "technique/avsm/cells_shared.glsl"
#endif

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    View view = part_view(part);
    uint t = gl_LocalInvocationID.x, group = gl_LocalInvocationID.y;
    uvec2 texel = part_corner(view, part) + uvec2(t % 8u, part_of_tile(part) * 4u + t / 8u);
    for (uint i = gl_LocalInvocationIndex; i < uint(CELLS + 1) * TEXELS; i += THREADS) {
        cells[i] = 0u;
    }
    if (group == 0u) {
        low_bits[t] = dark_bits[t] = dark_from_bits[t] = NEVER;
        high_bits[t] = 0u;
    }
    if (gl_LocalInvocationIndex == 0u) {
        bound[0] = bound[1] = 0u;
    }
    Ray ray = view_texel_ray(view, texel);
    TexelRay its = TexelRay(view, ray, length(ray.direction), t);
    find_range(its, part);
    barrier();
    bool covered = high_bits[t] > 0u;
    float low = covered ? uintBitsToFloat(low_bits[t]) : 0.0;
    // Nothing counts behind an opaque segment.
    bool ends_dark = dark_bits[t] != NEVER;
    float high = covered ? uintBitsToFloat(ends_dark ? dark_bits[t] : high_bits[t] - 1u) : low;
    float extent = max(high - low, 1e-6), per_cell = float(CELLS) / extent;
    float depth = view.far - view.near, scale = sum_scale(uvec2(bound[0], bound[1]));
    add_casters(its, part, Range(low, high, per_cell, per_cell / depth, extent / float(CELLS) * depth, ends_dark, scale));
    barrier();
    if (group == 0u) {
        sum_cells(t, 1.0 / scale);
    }
    barrier();
    // The finest threshold that leaves few enough ends is taken.
    for (uint i = group; i < THRESHOLDS; i += GROUPS) {
        float loss = 2.0 * LEFT_OUT / float(NODES * NODES) * per_cell * pow(COARSER, float(i));
        ends[i][t] = ends_that_stay(t, loss);
        if (GROUPS == 1u && few_enough(ends[i][t])) {
            break;
        }
    }
    barrier();
    float dark_from = uintBitsToFloat(dark_from_bits[t]);
    curve_clear();
    if (group == 0u && covered) {
        uvec2 mask = ends[0][t];
        for (uint i = 1u; i < THRESHOLDS && !few_enough(mask); ++i) {
            mask = ends[i][t];
        }
        curve_append(low, 0.0);
        while (mask != uvec2(0u)) {
            int i = mask.x != 0u ? findLSB(mask.x) : 32 + findLSB(mask.y);
            mask = mask.x != 0u ? uvec2(mask.x & (mask.x - 1u), mask.y) : uvec2(0u, mask.y & (mask.y - 1u));
            float end = low + float(i + 1) / per_cell;
            if (end < dark_from) {
                curve_append(end, optical_depth_at(t, i));
            }
        }
        if (dark_from_bits[t] != NEVER) {
            float at = clamp((dark_from - low) * per_cell, 0.0, float(CELLS));
            int cell = min(int(at), CELLS - 1);
            float before = cell > 0 ? optical_depth_at(t, cell - 1) : 0.0;
            curve_append(dark_from, mix(before, optical_depth_at(t, cell), at - float(cell)));
            curve_append(high, optical_depth_at(t, CELLS - 1) + DARK);
        }
        curve_reduce();
    }
    if (TURNS != 0) {
        curve_fit(t, group, GROUPS, low, per_cell, dark_from);
    }
    end_part(part);
    if (group == 0u && all(lessThan(texel, uvec2(view.width, view.height)))) {
        store_curve(part_texel(view, part, texel));
    }
}
