#version 460
// Builds the curves of a tile of 8×8 texels, or of half of one, in any order of the casters: adds up their optical depth in
// CELLS even cells of each texel's own depth range, then compresses the curve through the cells' ends, which is exact
// there, and fits the nodes that are left to all of it.
// Inputs: maps, casters, parts, entries. Outputs: nodes of tiles that have casters.
// Invariants: cells are whole numbers, so the result depends only on the casters, not on the order they come in; where a
// segment lets nothing through, the first such keeps its own two depths, and what is behind it is left out.
// Source: ours. Twin: reference::twin::avsm::cells.

// LANES 0: a whole tile. LANES 1: half a tile, with what bins/batch.glsl has for software devices: a whole one would
// need more shared memory than they have. LANES 2: half a tile, else as 0, for devices of as little memory or of few
// threads.
// variants: LANES 0 1 2
#include "avsm/curve.glsl"
#include "bins/area.glsl"
#include "bins/sums.glsl"

#if LANES == 0
const uint TEXELS = 64u;
#else
const uint TEXELS = 32u;
#endif
// Casters that are looked at at the same time, each by one thread a texel; thresholds that are tried at the same time.
// 4; 8 for 16 nodes, which take so many registers that few workgroups have room; 16 where there are very many casters, for the
// fullest tiles; 1 where threads of a workgroup do not run at the same time anyway.
layout(local_size_x = TEXELS, local_size_y_id = ID_WORKGROUP) in;
// The same number: what is read of a specialized workgroup size is no constant to every tool.
CONSTANT(uint, GROUPS, 4u)
const uint THREADS = TEXELS * GROUPS;

layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };

// Casters at a time: as many as there is room for in what the nodes stand in while they are fitted, NODES * TEXELS / 4, and 32 a
// group at least.
CONSTANT(uint, BATCH, 128u)
#define BATCH BATCH
#include "avsm/store.glsl"
#include "bins/batch.glsl"

const int CELLS = 64;
// A cell end stays out of the curve where that changes the area under it by less than LEFT_OUT / NODES², at least a
// hundredth of what NODES nodes lose on smoke; where too many ends would stay, COARSER times as much, and again.
const float LEFT_OUT = 6.4e-4;
const float COARSER = 2.5;
const uint THRESHOLDS = 4u;

// Cell c of texel t at c · TEXELS + t, so that the threads of a subgroup never meet in a bank. Units of optical depth that
// segments take in a cell, in the end the bits of the optical depth up to the cell's end.
shared uint cells[CELLS * TEXELS];
#if LANES == 1
// By how much what segments take in every cell changes from a cell on: a segment is at most five numbers however many cells
// it spans. Software devices reach for shared memory one thread after the other.
shared uint slopes[CELLS * TEXELS];
#endif
// Bits of non-negative floats, which order as the floats do.
const uint NEVER = 0x7F800000u;
shared uint low_bits[TEXELS];
shared uint high_bits[TEXELS];
// Of the first segment that lets nothing through, where there is one: where it does so, and where it begins.
shared uint dark_bits[TEXELS];
shared uint dark_from_bits[TEXELS];
shared uint bound[2];
// Bit i: the end of cell i stays, at each threshold.
shared uvec2 ends[THRESHOLDS][TEXELS];

// Nodes stand where the casters stood, which are all added up by then.
#if LANES == 1
shared vec4 fitted[NODES / 2 * TEXELS];
#define FITTED fitted
#else
#define FITTED batch
#endif
#include "avsm/fit.glsl"

// Adds a segment; `at` is where it enters and leaves, in cells, `whole` its optical depth in units. Roundings of a segment
// cancel: what it has taken by the end of a cell is rounded, not what it takes in the cell.
#if LANES == 1
// A thread has its texel for itself. Sums may wrap around on their way.
void add_segment(uint texel, vec2 at, float whole) {
    uint first = min(uint(at.x), uint(CELLS - 1)), last = min(uint(at.y), uint(CELLS - 1));
    uint units = uint(whole + 0.5);
    if (first == last) {
        cells[first * TEXELS + texel] += units;
        return;
    }
    // What it has taken by the end of its first cell and by the begin of its last.
    float rate = whole / max(at.y - at.x, 1e-6);
    uint early = uint(min((float(first + 1u) - at.x) * rate, whole) + 0.5);
    uint late = uint(min((float(last) - at.x) * rate, whole) + 0.5);
    cells[first * TEXELS + texel] += early;
    if (last > first + 1u) {
        // In even shares, whole numbers: the last `rest` cells in between take one more.
        uint count = last - first - 1u, share = (late - early) / count, rest = (late - early) % count;
        slopes[(first + 1u) * TEXELS + texel] += share;
        slopes[(last - rest) * TEXELS + texel] += 1u;
        slopes[last * TEXELS + texel] -= share + 1u;
    }
    cells[last * TEXELS + texel] += units - late;
}
#else
void add_segment(uint texel, vec2 at, float whole) {
    int cell = min(int(at.x), CELLS - 1), last = min(int(at.y), CELLS - 1);
    float rate = whole / max(at.y - at.x, 1e-6);
    uint before = 0u;
    for (; cell <= last; ++cell) {
        uint upto = uint((cell == last ? whole : min((float(cell + 1) - at.x) * rate, whole)) + 0.5);
        atomicAdd(cells[uint(cell) * TEXELS + texel], upto - before);
        before = upto;
    }
}
#endif

float optical_depth_at(uint texel, int cell) {
    return uintBitsToFloat(cells[uint(cell) * TEXELS + texel]);
}

// The ends that stay: the last, and those whose triangle with the end that stayed before and the next end, times the
// transmittance at the former, is at least `loss` (in cells times optical depth).
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

// 5/2 NODES; 3/2 where nodes are fitted anyway, which is as good and saves two removals of three.
bool few_enough(uvec2 mask) {
    return bitCount(mask.x) + bitCount(mask.y) <= (TURNS == 0 ? 5 : 3) * NODES / 2;
}

// Casters that a thread looks at before it goes on with those that it may hit, 32 at most: where they are small, the threads of
// a subgroup then go on together, as often as the busiest of them has hits, and not once for every caster that one of them
// hits. 1 where lanes hold the casters, which all threads take alike.
CONSTANT(uint, AHEAD, 1u)

// Bits of the casters i, i + GROUPS, … < filled of the batch, AHEAD at most: of those that the ray may hit and that may reach
// beyond `known`, from z to z, or let nothing through.
uint hits_ahead(View view, Ray ray, float ray_length, uint i, uint filled, vec2 known) {
    uint hits = 0u;
    for (uint bit = 0u; bit < AHEAD && i < filled; ++bit, i += GROUPS) {
        Caster caster = batch_caster(i);
        float reach = caster.radius + 1e-5 * (caster.radius + abs(caster.position.z));
        bool matters = caster.position.z - reach < known.x || caster.position.z + reach > known.y
                       || 2.001 * caster.radius * caster.density >= DARK || caster_is_strand(caster);
        hits |= uint(matters && (AREA || view_meets(view, ray, ray_length, caster))) << bit;
    }
    return hits;
}

// From where to where casters reach along the ray, and from where on it is dark, with one more caster.
void reach_caster(View view, Ray ray, float ray_length, Caster caster, inout float low, inout float high, inout float dark) {
    vec2 z;
    float optical_depth;
    if (texel_part(view, ray, ray_length, caster, DARK, z, optical_depth)) {
        low = min(low, z.x);
        high = max(high, z.y);
        dark = optical_depth >= DARK ? min(dark, z.y) : dark;
    }
}

// Adds a caster to the cells of a texel, which are between two depths.
void add_caster(View view, Ray ray, float ray_length, Caster caster, uint t, vec2 range, float per_cell, float scale) {
    vec2 z;
    float optical_depth;
    if (!texel_part(view, ray, ray_length, caster, DARK, z, optical_depth)) {
        return;
    }
    bool ends_dark = dark_bits[t] != NEVER;
    vec2 depth = (z - view.near) * (1.0 / (view.far - view.near));
    if (optical_depth >= DARK && floatBitsToUint(max(depth.y, 0.0)) == dark_bits[t]) {
        atomicMin(dark_from_bits[t], floatBitsToUint(max(depth.x, 0.0)));
    } else if (!ends_dark || depth.x < range.y) {
        float share = ends_dark && depth.y > range.y ? (range.y - depth.x) / (depth.y - depth.x) : 1.0;
        vec2 at = clamp((depth - range.x) * per_cell, 0.0, float(CELLS));
        add_segment(t, at, optical_depth * scale * share);
    }
}

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    View view = part_view(part);
    uint first = part.first, count = part.count;
    uint t = gl_LocalInvocationID.x, group = gl_LocalInvocationID.y;
    uvec2 texel = part_corner(view, part) + uvec2(t % 8u, part_of_tile(part) * 4u + t / 8u);
    for (uint i = gl_LocalInvocationIndex; i < uint(CELLS) * TEXELS; i += THREADS) {
        cells[i] = 0u;
#if LANES == 1
        slopes[i] = 0u;
#endif
    }
    if (group == 0u) {
        low_bits[t] = dark_bits[t] = dark_from_bits[t] = NEVER;
        high_bits[t] = 0u;
    }
    if (gl_LocalInvocationIndex == 0u) {
        bound[0] = bound[1] = 0u;
    }
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction);
    float per_depth = 1.0 / (view.far - view.near);

    // The depths that each texel's segments span, where they are dark, and a bound of the optical depth in any texel.
    float low = FARTHEST, high = -FARTHEST, dark = FARTHEST;
    uvec2 most = uvec2(0u);
    for (uint begin = 0u; begin < count; begin += batch_size()) {
        uint filled = min(batch_size(), count - begin);
        fetch_batch(view, first + begin, filled);
#if LANES != 1
        for (uint i = gl_LocalInvocationIndex; i < filled; i += THREADS) {
            wide_add(most, caster_bound(batch_caster(i), DARK));
        }
#endif
        for (uint i = group; i < filled; i += AHEAD * GROUPS) {
            if (AHEAD == 1u) {
                reach_caster(view, ray, ray_length, batch_caster(i), low, high, dark);
                continue;
            }
            uint hits = hits_ahead(view, ray, ray_length, i, filled, vec2(low, high));
            for (; hits != 0u; hits &= hits - 1u) {
                Caster caster = batch_caster(i + uint(findLSB(hits)) * GROUPS);
                reach_caster(view, ray, ray_length, caster, low, high, dark);
            }
        }
    }
#if LANES == 1
    for (uint i = gl_LocalInvocationIndex; i < count; i += THREADS) {
        wide_add(most, caster_bound(casters[entries[first + i].y], DARK));
    }
#endif
    low = max((low - view.near) * per_depth, 0.0);
    high = (high - view.near) * per_depth;
    if (high >= 0.0) {
        atomicMin(low_bits[t], floatBitsToUint(low));
        // One more than the bits, so that 0 says that nothing was hit.
        atomicMax(high_bits[t], floatBitsToUint(high) + 1u);
    }
    if (dark < FARTHEST) {
        atomicMin(dark_bits[t], floatBitsToUint(max((dark - view.near) * per_depth, 0.0)));
    }
    WIDE_ATOMIC_ADD(bound[0], bound[1], most);
    barrier();
    bool covered = high_bits[t] > 0u;
    low = covered ? uintBitsToFloat(low_bits[t]) : 0.0;
    // Nothing counts behind what lets nothing through.
    bool ends_dark = dark_bits[t] != NEVER;
    high = covered ? uintBitsToFloat(ends_dark ? dark_bits[t] : high_bits[t] - 1u) : low;
    float extent = max(high - low, 1e-6);
    float per_cell = float(CELLS) / extent;
    float scale = sum_scale(uvec2(bound[0], bound[1]));
    float unit = 1.0 / scale;

    for (uint begin = 0u; begin < count; begin += batch_size()) {
        uint filled = min(batch_size(), count - begin);
        fetch_batch(view, first + begin, filled);
        for (uint i = group; i < filled; i += AHEAD * GROUPS) {
            if (AHEAD == 1u) {
                add_caster(view, ray, ray_length, batch_caster(i), t, vec2(low, high), per_cell, scale);
                continue;
            }
            uint hits = hits_ahead(view, ray, ray_length, i, filled, vec2(FARTHEST, -FARTHEST));
            for (; hits != 0u; hits &= hits - 1u) {
                Caster caster = batch_caster(i + uint(findLSB(hits)) * GROUPS);
                add_caster(view, ray, ray_length, caster, t, vec2(low, high), per_cell, scale);
            }
        }
    }
    barrier();
    if (group == 0u) {
        uint sum = 0u, slope = 0u;
        for (uint place = t; place < uint(CELLS) * TEXELS; place += TEXELS) {
#if LANES == 1
            slope += slopes[place];
#endif
            sum += cells[place] + slope;
            cells[place] = floatBitsToUint(float(sum) * unit);
        }
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
