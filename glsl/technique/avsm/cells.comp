#version 460
// Builds the curves of a tile of 8×8 texels, or of half a tile, from casters in any order. Divides each texel's own depth range into CELLS
// equal cells and sums the casters' optical depth in each cell. The curve through the cells' ends is exact at those ends. It is then
// compressed, and the remaining nodes are fitted to the values at all cells' ends. Inputs: maps, casters, parts, entries. Outputs: nodes of
// tiles that have casters. Invariants: cells hold integers, so the result does not depend on the order of the casters; the first opaque
// segment keeps its own two depths, and segments behind it are ignored. Source: ours. Twin: reference::twin::avsm::cells.

// LANES 0: a whole tile. LANES 1: half a tile, with casters in lanes (maps/bins/batch.glsl), for software devices. LANES 2: half a tile,
// otherwise the same as LANES 0, for devices with little shared memory or few threads per workgroup.
// variants: LANES 0 1 2
#include "maps/curve/curve.glsl"
#include "maps/bins/area.glsl"
#include "maps/bins/sums.glsl"

#if LANES == 0
const uint TEXELS = 64u;
#else
const uint TEXELS = 32u;
#endif
// Threads per texel: number of casters, and of thresholds, that are tested at the same time. Usually 4; 8 for curves of 16 nodes, whose
// register use limits the number of resident workgroups; 16 for the fullest tiles if there are very many casters; 1 on devices that do not
// run a workgroup's threads in parallel.
layout(local_size_x = TEXELS, local_size_y_id = ID_WORKGROUP) in;
// The workgroup's size along y again: some tools do not accept a specialized gl_WorkGroupSize as a constant.
CONSTANT(uint, GROUPS, 4u)
const uint THREADS = TEXELS * GROUPS;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// Number of casters fetched at a time: as many as fit into the memory that later holds the nodes being fitted (NODES * TEXELS / 4 casters),
// but at least 32 per group.
CONSTANT(uint, BATCH, 128u)
#define BATCH BATCH
#include "maps/curve/store.glsl"
#include "maps/bins/batch.glsl"

const int CELLS = 64;
// A cell's end is left out of the curve if that changes the area under the curve by less than LEFT_OUT / NODES², which is at least a
// hundredth of the area that curves of NODES nodes lose on smoke. If too many ends remain, the next threshold is tried, which is COARSER
// times as high; there are THRESHOLDS thresholds.
const float LEFT_OUT = 6.4e-4;
const float COARSER = 2.5;
const uint THRESHOLDS = 4u;

// Cell c of texel t is at c · TEXELS + t, so that the threads of a subgroup have no bank conflicts. While casters are added, a cell holds
// the segments' optical depth in that cell minus their optical depth in the previous cell, in integer units. After sum_cells it holds the
// optical depth from the start of the first cell to its own end, as float bits. Each texel has one extra cell at the end, which is never
// read.
shared uint cells[(CELLS + 1) * TEXELS];
// Bits of non-negative floats, which compare like the floats.
const uint NEVER = 0x7F800000u;
shared uint low_bits[TEXELS];
shared uint high_bits[TEXELS];
// The first opaque segment, if a texel has one: the depth at which it ends, and the depth at which it begins.
shared uint dark_bits[TEXELS];
shared uint dark_from_bits[TEXELS];
shared uint bound[2];
// Bit i: the end of cell i stays, at each threshold.
shared uvec2 ends[THRESHOLDS][TEXELS];

// Nodes reuse the memory of the casters, which have all been added by then.
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

// Returns a mask of the cells' ends that stay in the curve. The last end always stays; any other stays if leaving it out would change the
// curve by at least `loss`. The change is twice the area of the triangle between three ends (the last one that stayed, this one, and the
// next), times the transmittance at the first of them. Its unit is cells times optical depth.
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

// Returns whether at most 5/2 NODES ends stay. If nodes are fitted afterwards, the limit is 3/2 NODES: the result is as good, and two
// thirds of the removals are saved.
bool few_enough(uvec2 mask) {
    return bitCount(mask.x) + bitCount(mask.y) <= (TURNS == 0 ? 5 : 3) * NODES / 2;
}

#include "technique/avsm/changes.glsl"

struct TexelRay {
    View view;
    Ray ray;
    float ray_length;
    uint texel;  // index within the workgroup
};

// The z at which casters begin and end along a ray, and the z beyond which the ray is dark.
struct Reach {
    float low;
    float high;
    float dark;
};

// A texel's cells. `low`, `high`: start and end of the cells in the light's range. `per_cell`, `per_z`: number of cells per whole range,
// and per world unit. `z_per_cell`: world units per cell. `ends_dark`: whether the cells end where the ray becomes dark. `scale`: units per
// optical depth of 1.
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

// Merges this thread's results for a texel with the other threads' results.
void share_reach(TexelRay its, Reach reach) {
    float per_depth = 1.0 / (its.view.far - its.view.near), high = (reach.high - its.view.near) * per_depth;
    if (high >= 0.0) {
        atomicMin(low_bits[its.texel], floatBitsToUint(max((reach.low - its.view.near) * per_depth, 0.0)));
        // One more than the bits, so that 0 means no hit.
        atomicMax(high_bits[its.texel], floatBitsToUint(high) + 1u);
    }
    if (reach.dark < FARTHEST) {
        atomicMin(dark_bits[its.texel], floatBitsToUint(max((reach.dark - its.view.near) * per_depth, 0.0)));
    }
}

// Computes the part of a caster within the cells of a texel: its start and end, in cells, and its optical depth. For the first opaque
// caster, only records where it begins, and returns false.
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

// Both files define two passes over all of a tile's casters: find_range sets low_bits, high_bits, dark_bits and a bound on the optical
// depth along any ray; add_casters sums the casters in the cells.
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
    // Nothing behind an opaque segment counts.
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
    // Uses the finest threshold that leaves few enough ends.
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
