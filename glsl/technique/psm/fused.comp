#version 460
// Builds the rays of half a tile, ROWS rows of 8 texels at a time, from casters in any order: sums their optical depth in the slices and
// writes the transmittance behind each slice once. No clear, no blending, no propagation. For a tile without casters, one workgroup writes
// the whole tile. Inputs: maps, casters, totals, parts or counts, entries. Output: volume, every texel of it. Invariant: sums are integers,
// so the result does not depend on the order of the casters. Source: ours. Twin: reference::twin::psm::fused.

// variants: BITS 8 16
#include "maps/bins/part.glsl"
#include "maps/bins/sums.glsl"
#include "maps/bins/texel.glsl"
#include "technique/psm/format.glsl"
#include "technique/psm/place.glsl"

// A multiple of TEXELS: up to 256, so that a multiprocessor runs several workgroups at a time; TEXELS on devices that do not run threads in
// parallel anyway.
layout(local_size_x_id = ID_WORKGROUP) in;
// The workgroup's size again: some tools do not accept a specialized gl_WorkGroupSize as a constant.
CONSTANT(uint, THREADS, 256u)
// Number of casters in shared memory at a time, less than THREADS. They are in the view's axes, without casters that miss the rows. 0: each
// thread fetches the casters that it tests.
CONSTANT(uint, BATCH, 0u)
// BATCH if there are strands, splats or cells, else 0.
CONSTANT(uint, BATCH_AXES, 0u)

// Whether the casters of the next batch are fetched while the current batch is added, for tiles with many batches.
CONSTANT(bool, FETCH_AHEAD, false)

layout(push_constant, scalar) uniform PartPush {
    uint room;        // if not 0: capacity of each tile, in entries; parts are then not listed
    uint tile_count;  // tiles per map
};

BINS_COUNTS(readonly buffer)
// set 2: psm_volume
layout(set = 2, binding = 0, VOLUME_FORMAT) uniform writeonly image3D volume;

// ROWS: rows of texels that are built at a time. ROW: texels per row. HALF: rows of half a tile. TEXELS: texels that are built at a time.
CONSTANT(uint, ROWS, 2u)
const uint ROW = 8u, HALF = 4u, TEXELS = ROW * ROWS;
// SPAN: number of texels of a row for which a thread uses each caster that it has read; larger if reading a caster costs more. SPANS:
// number of such spans in a workgroup's texels. CASTERS: casters that are read at a time.
const uint SPAN = THREADS == TEXELS ? 8u : BATCH == 0u ? 4u : 1u, SPANS = TEXELS / SPAN, CASTERS = THREADS / SPANS;
// RUNS: runs of slices that are summed at a time, each by one thread per texel. RUN: slices per run, in whole layers.
const uint RUNS = THREADS / TEXELS, RUN = (SLICES / 4u + RUNS - 1u) / RUNS * 4u;
// Fewer than MANY casters are summed in a unit that depends only on their number and suits any casters. Each addition rounds by at most
// half a unit, so the error bound of the sum is 2⁻¹³, a quarter of a step of a half float.
const uint MANY = SPLIT ? 128u : 256u;

// Optical depth of each slice of each texel, in units, at the index that sum_place returns. Before casters are added, two of the words are
// used to find a bound on the sums.
shared uint slices[SLICES * TEXELS];
// The batch of casters. batch_balls: centres and radii. batch_takes: densities and places among the slices. batch_axes: axes of strands,
// splats and cells. A plain sphere has its radius squared, and units of optical depth per half of a chord's length instead of its density.
// Other casters have their radius negated. `filled`: number of casters in this batch and in the next.
shared vec4 batch_balls[BATCH + 1u];
shared vec2 batch_takes[BATCH + 1u];
shared vec3 batch_axes[BATCH_AXES + 1u];
shared uint filled[2];

// Returns the index of the sum of slice k of a texel. The threads of a subgroup access the same slice of one run, or of two runs, at a
// time. This order avoids bank conflicts.
uint sum_place(uint k, uint texel) {
    return (k ^ (TEXELS == 16u ? k / RUN & 1u : 0u)) * TEXELS + texel;
}

void write(uint map, uvec2 texel, uint slice, vec4 transmittance) {
    ivec3 at = ivec3(texel, map * LAYERS + slice / 4u);
    imageStore(volume, at, ADDITIVE ? 1.0 - transmittance : transmittance);
}

// Returns the slices of a caster that is given in the view's axes.
Place place_of(View view, Caster caster) {
    return depth_place(view_depth(view, caster.position.z + 0.5 * caster_axis(caster).z));
}

// Adds a caster to the batch, with the slice that receives its optical depth, if the caster may cover the `rows` rows from the corner on.
void put_caster(View view, uvec2 corner, uint rows, Caster caster, float scale, uint turn) {
    vec2 low, high;
    vec2 first = vec2(corner), last = first + vec2(float(ROW - 1u), float(rows - 1u));
    if (!texel_bounds(view, caster, low, high) || any(greaterThan(low, last)) || any(lessThan(high, first))) {
        return;
    }
    Place place = place_of(view, caster);
    bool plain = plain_sphere(view, caster);
    uint at = atomicAdd(filled[turn & 1u], 1u);
    batch_balls[at] = vec4(caster.position, plain ? caster.radius * caster.radius : -caster.radius);
    batch_takes[at] = vec2(plain ? 2.0 * caster.density * scale : caster.density, float(place.slice) + place.share);
    if (STRANDS || SPLATS_OR_CELLS || SHEETS) {
        batch_axes[at] = caster.axis;
    }
}

// Adds a ray's units of optical depth to the slices of their place.
void add_units(uint texel, Place place, float units, float scale) {
    atomicAdd(slices[sum_place(place.slice, texel)], uint(min(units * (1.0 - place.share), DARK * scale) + 0.5));
    if (SPLIT && place.slice + 1u < SLICES) {
        atomicAdd(slices[sum_place(place.slice + 1u, texel)], uint(min(units * place.share, DARK * scale) + 0.5));
    }
}

// Adds the optical depth of a caster, given in the view's axes, along a texel's ray.
void add_caster(View view, Ray ray, float ray_length, uint texel, Caster caster, Place place, float scale) {
    vec2 z;
    float optical_depth;
    if (view_segment(view, ray, ray_length, caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
        if (caster_is_sheet(caster)) {
            place = depth_place(view_depth(view, z.x));
        }
        add_units(texel, place, optical_depth * scale, scale);
    }
}

// Adds the optical depth of a caster of the batch along a texel's ray.
void add_batched(View view, Ray ray, float ray_length, uint texel, uint i, float scale) {
    vec4 ball = batch_balls[i];
    vec2 take = batch_takes[i];
    uint slice = uint(take.y);
    Place place = Place(slice, SPLIT ? take.y - float(slice) : 0.0);
    if (ball.w < 0.0) {
        Caster caster = Caster(ball.xyz, -ball.w, STRANDS || SPLATS_OR_CELLS || SHEETS ? batch_axes[i] : vec3(0.0), take.x);
        add_caster(view, ray, ray_length, texel, caster, place, scale);
        return;
    }
    vec2 across = ball.xy - ray.origin.xy;
    float half_square = ball.w - dot(across, across);
    if (half_square > 0.0) {
        add_units(texel, place, min(sqrt(half_square) * take.x, MAX_OPTICAL_DEPTH * scale), scale);
    }
}

// Adds the casters of the part to the slices of ROWS rows from `corner` on. The slices must be 0. All threads must call this function.
// `again`: the batch already holds all of these casters.
void add_casters(View view, TilePart part, uvec2 corner, bool again, float scale) {
    uint thread = gl_LocalInvocationIndex, span = thread % SPANS * SPAN, rotation = thread / SPANS;
    Ray ray = view_texel_ray(view, corner + uvec2(span % ROW, span / ROW));
    if (BATCH == 0u) {
        float texel_width = 2.0 / (float(view.width) * view.scale_x);
        barrier();
        for (uint i = rotation; i < part.count; i += CASTERS) {
            Caster caster = tile_caster(view, part.first + i);
            Place place = place_of(view, caster);
            for (uint j = 0u; j < SPAN; ++j) {
                // Threads start at different texels of a span, which reduces bank conflicts.
                uint x = (j + rotation) % SPAN;
                Ray beside = view_ray_beside(view, ray, float(x) * texel_width);
                add_caster(view, beside, length(beside.direction), span + x, caster, place, scale);
            }
        }
    } else {
        float ray_length = length(ray.direction);
        uint rows = part.count <= BATCH ? HALF : ROWS;
        // The thread's caster in the next batch, and the index of its caster in the batch after that.
        uint mine = thread < BATCH ? thread : part.count, later = 0u;
        Caster next;
        if (FETCH_AHEAD && !again && mine < part.count) {
            next = casters[entries[part.first + mine].y];
        }
        if (FETCH_AHEAD && !again && BATCH + mine < part.count) {
            later = entries[part.first + BATCH + mine].y;
        }
        if (thread < 2u && !again) {
            filled[thread] = 0u;
        }
        for (uint first = 0u, turn = 0u; first < part.count; first += BATCH, ++turn) {
            barrier();
            if (!again) {
                if (first + mine < part.count) {
                    if (!FETCH_AHEAD) {
                        next = casters[entries[part.first + first + mine].y];
                    }
                    put_caster(view, corner, rows, view_caster(view, next), scale, turn);
                } else if (thread == THREADS - 1u) {
                    // Resets the count of the previous batch, which is finished. The last thread does so, since it has no caster of its
                    // own.
                    filled[turn + 1u & 1u] = 0u;
                }
                barrier();
                if (FETCH_AHEAD && first + BATCH + mine < part.count) {
                    next = casters[later];
                }
                if (FETCH_AHEAD && first + 2u * BATCH + mine < part.count) {
                    later = entries[part.first + first + 2u * BATCH + mine].y;
                }
            }
            uint count = filled[turn & 1u];
            for (uint i = rotation; i < count; i += CASTERS) {
                add_batched(view, ray, ray_length, span, i, scale);
            }
        }
    }
    barrier();
}

// Returns the units per optical depth of 1: as fine as possible without overflowing a sum of 32 bits. Fewer than MANY casters are assumed
// to have an optical depth of DARK = 2⁴ each, or twice that with SPLIT. For MANY casters or more, bounds on their optical depths are
// summed. Overwrites slices; all threads must call this function.
float part_scale(TilePart part) {
    if (part.count < MANY) {
        return exp2(float(min(22, (SPLIT ? 26 : 27) - findMSB(part.count))));
    }
    uint thread = gl_LocalInvocationIndex;
    uvec2 most = uvec2(0u);
    for (uint i = thread; i < part.count; i += THREADS) {
        wide_add(most, entry_bound(entries[part.first + i], DARK * (SPLIT ? 2.0 : 1.0)));
    }
    if (thread < 2u) {
        slices[thread] = 0u;
    }
    barrier();
    WIDE_ATOMIC_ADD(slices[0], slices[1], most);
    barrier();
    float scale = sum_scale(uvec2(slices[0], slices[1]));
    barrier();
    return scale;
}

// Writes the transmittance behind each slice of the thread's run of a texel. All threads must call this function.
void write_run(View view, uint map, uvec2 texel, uint t, uint run, float unit) {
    uint begin = min(run * RUN, SLICES), end = min(begin + RUN, SLICES);
    // First, the sum of each run replaces its last slice; then each run adds the sums of the runs before it.
    uint before = 0u, whole = 0u;
    if (RUNS != 1u) {
        for (uint k = begin; k < end; ++k) {
            whole += slices[sum_place(k, t)];
        }
        if (begin < end) {
            slices[sum_place(end - 1u, t)] = whole;
        }
        barrier();
        // Reads the sums of all runs, so that no read waits for another.
        [[unroll]] for (uint i = 1u; i < RUNS; ++i) {
            uint last = i * RUN - 1u;
            before += last < begin ? slices[sum_place(min(last, SLICES - 1u), t)] : 0u;
        }
    }
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    vec4 behind = vec4(exp(-float(before) * unit));
    uint upto = before + whole;
    for (uint k = begin; k < end; k += 4u) {
        uvec4 sums = uvec4(before);
        // A ray hits nothing in most runs, and in most layers of the remaining runs.
        if (RUNS == 1u || whole != 0u) {
            uint here = before;
            for (uint i = 0u; i < 4u; ++i) {
                here += slices[sum_place(k + i, t)];
                sums[i] = here;
            }
            sums.w = RUNS != 1u && k + 4u == end ? upto : sums.w;
        }
        if (sums.w != before) {
            behind = exp(-vec4(sums) * unit);
            before = sums.w;
        } else {
            behind = behind.wwww;
        }
        write(map, texel, k, behind);
    }
}

// Returns the workgroup's part if parts are not listed: two workgroups per tile, the second idle if there are no casters.
bool unlisted_part(out TilePart part) {
    uint place = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, tile = place / 2u, map = gl_WorkGroupID.z;
    uint bin = map * tile_count + min(tile, tile_count - 1u), count = counts[bin];
    part = TilePart(tile, map << 8 | place & 1u, bin * room, min(count, room));
    return tile < tile_count && (count > 0u || (place & 1u) == 0u);
}

void main() {
    TilePart part;
    bool listed = room == 0u, built = listed ? listed_part(part) : unlisted_part(part);
    // Read before it is known whether there is anything to build, to hide the latency.
    uint map = !listed ? gl_WorkGroupID.z : built ? part_map(part) : 0u;
    View view = maps[map].caster_view;
    if (!built) {
        return;
    }
    uint thread = gl_LocalInvocationIndex, t = thread % TEXELS, run = thread / TEXELS;
    uvec2 corner = part_corner(view, part), texel = corner + uvec2(t % ROW, t / ROW);
    if (part.count == 0u) {
        for (; texel.y < min(corner.y + ROW, view.height); texel.y += ROWS) {
            for (uint k = run * RUN; k < min(run * RUN + RUN, SLICES) && texel.x < view.width; k += 4u) {
                write(map, texel, k, vec4(1.0));
            }
        }
        return;
    }
    uvec2 down = uvec2(0u, part_of_tile(part) * HALF);
    float scale = part_scale(part), unit = 1.0 / scale;
    for (uint row = 0u; row < HALF; row += ROWS, down.y += ROWS) {
        for (uint i = thread; i < SLICES * TEXELS; i += THREADS) {
            slices[i] = 0u;
        }
        add_casters(view, part, corner + down, row > 0u && part.count <= BATCH, scale);
        write_run(view, map, texel + down, t, run, unit);
        // Waits for threads that are still reading sums.
        barrier();
    }
    end_part(part);
}
