#version 460
// Builds the rays of half a tile, 8×4 texels, in any order of the casters: adds up their optical depth in the slices and
// writes what is left of the light behind each slice once. No clear, no blending, no propagation. Of a tile without casters,
// one workgroup writes all.
// Inputs: maps, casters, totals, parts or counts, entries. Output: volume, every texel of it.
// Invariant: sums are of whole numbers, so the result depends only on the casters, not on the order they come in.
// Source: ours. Twin: reference::twin::psm::fused.

// variants: BITS 8 16
#include "bins/part.glsl"
#include "bins/sums.glsl"
#include "bins/texel.glsl"
#include "psm/format.glsl"
#include "psm/place.glsl"

// A multiple of TEXELS: as many as the device has, up to 512; TEXELS where threads do not run at the same time anyway.
layout(local_size_x_id = ID_WORKGROUP) in;
// The same number: what is read of a specialized workgroup size is no constant to every tool.
CONSTANT(uint, THREADS, 512u)
// Casters that stand in shared memory at the same time, in the view's axes, fewer than THREADS, without those that miss the half
// tile. 0: each is fetched by who looks at it.
CONSTANT(uint, BATCH, 0u)

layout(push_constant, scalar) uniform PartPush {
    uint room;  // not 0: entries of each tile, tile after tile; parts are not listed then
};

layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 2, binding = 0, VOLUME_FORMAT) uniform writeonly image3D volume;

const uint ROW = 8u, ROWS = 4u, TEXELS = ROW * ROWS;
// Texels of a row that a thread looks at for a caster: the dearer it is to fetch one, the more. Casters that are looked at
// at the same time.
const uint SPAN = THREADS == TEXELS ? 8u : BATCH == 0u ? 4u : 1u, SPANS = TEXELS / SPAN, CASTERS = THREADS / SPANS;
// Runs of slices that are summed at the same time, each by one thread a texel, and slices of a run: whole layers.
const uint RUNS = THREADS / TEXELS, RUN = (SLICES / 4u + RUNS - 1u) / RUNS * 4u;
// Fewer casters than these are summed in units that suit any casters. Their sum is wrong by 2⁻¹³ at most, half a unit
// for each addition: a quarter of a step of a half float.
const uint MANY = SPLIT ? 128u : 256u;

// Slice k of texel t at k · TEXELS + t, so that the threads of a subgroup never meet in a bank: units of optical depth. With
// 256 slices it is all the shared memory that many devices have, so the first two words are the bound before they are
// sums. Behind the slices the batch, and how many casters it has, this time and the next.
const uint BATCH_PLACE = SLICES * TEXELS, CASTER_WORDS = 10u, COUNTS_PLACE = BATCH_PLACE + BATCH * CASTER_WORDS;
shared uint slices[COUNTS_PLACE + (BATCH + THREADS - 1u) / THREADS * 2u];

void write(uint map, uvec2 texel, uint slice, vec4 transmittance) {
    ivec3 at = ivec3(texel, map * LAYERS + slice / 4u);
    imageStore(volume, at, ADDITIVE ? 1.0 - transmittance : transmittance);
}

// Of a caster in the view's axes.
Place place_of(View view, Caster caster) {
    return depth_place(view_depth(view, caster.position.z + 0.5 * caster.axis.z));
}

// Puts a caster that may meet the half tile into the batch, with the slice that takes it.
void put_caster(View view, uvec2 corner, Caster caster, uint turn) {
    vec2 low, high;
    vec2 first = vec2(corner), last = first + vec2(float(ROW - 1u), float(ROWS - 1u));
    if (!texel_bounds(view, caster, low, high) || any(greaterThan(low, last)) || any(lessThan(high, first))) {
        return;
    }
    Place place = place_of(view, caster);
    uint at = BATCH_PLACE + atomicAdd(slices[COUNTS_PLACE + (turn & 1u)], 1u) * CASTER_WORDS;
    for (uint x = 0u; x < 3u; ++x) {
        slices[at + x] = floatBitsToUint(caster.position[x]);
        slices[at + 4u + x] = floatBitsToUint(caster.axis[x]);
    }
    slices[at + 3u] = floatBitsToUint(caster.radius);
    slices[at + 7u] = floatBitsToUint(caster.density);
    slices[at + 8u] = place.slice;
    slices[at + 9u] = floatBitsToUint(place.share);
}

Caster batch_caster(uint i, out Place place) {
    uint at = BATCH_PLACE + i * CASTER_WORDS;
    vec4 ball = uintBitsToFloat(uvec4(slices[at], slices[at + 1u], slices[at + 2u], slices[at + 3u]));
    vec4 rest = uintBitsToFloat(uvec4(slices[at + 4u], slices[at + 5u], slices[at + 6u], slices[at + 7u]));
    place = Place(slices[at + 8u], uintBitsToFloat(slices[at + 9u]));
    return Caster(ball.xyz, ball.w, rest.xyz, rest.w);
}

// Adds what a caster, in the view's axes, takes of the ray of a texel.
void add_caster(View view, Ray ray, float ray_length, uint texel, Caster caster, Place place, float scale) {
    vec2 z;
    float optical_depth;
    if (view_segment(view, ray, ray_length, caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
        uint at = place.slice * TEXELS + texel;
        atomicAdd(slices[at], uint(min(optical_depth * (1.0 - place.share), DARK) * scale + 0.5));
        if (SPLIT && place.slice + 1u < SLICES) {
            atomicAdd(slices[at + TEXELS], uint(min(optical_depth * place.share, DARK) * scale + 0.5));
        }
    }
}

// Adds all casters of the part. The slices are 0, and all threads call it alike.
void add_casters(View view, TilePart part, uvec2 corner, float scale) {
    uint thread = gl_LocalInvocationIndex, span = thread % SPANS * SPAN, rotation = thread / SPANS;
    Ray ray = view_texel_ray(view, corner + uvec2(span % ROW, span / ROW));
    if (BATCH == 0u) {
        float texel_width = 2.0 / (float(view.width) * view.scale_x);
        barrier();
        for (uint i = thread / SPANS; i < part.count; i += CASTERS) {
            Caster caster = tile_caster(view, part.first + i);
            Place place = place_of(view, caster);
            for (uint j = 0u; j < SPAN; ++j) {
                // Casters begin at different texels of a span, for the banks again.
                uint x = (j + rotation) % SPAN;
                Ray beside = view_ray_beside(view, ray, float(x) * texel_width);
                add_caster(view, beside, length(beside.direction), span + x, caster, place, scale);
            }
        }
    } else {
        float ray_length = length(ray.direction);
        if (thread < 2u) {
            slices[COUNTS_PLACE + thread] = 0u;
        }
        for (uint first = 0u, turn = 0u; first < part.count; first += BATCH, ++turn) {
            barrier();
            if (thread < min(part.count - first, BATCH)) {
                put_caster(view, corner, tile_caster(view, part.first + first + thread), turn);
            } else if (thread == THREADS - 1u) {
                // Of the batch before, which is done with; the last thread has no caster of its own.
                slices[COUNTS_PLACE + (turn + 1u & 1u)] = 0u;
            }
            barrier();
            uint filled = slices[COUNTS_PLACE + (turn & 1u)];
            for (uint i = rotation; i < filled; i += CASTERS) {
                Place place;
                Caster caster = batch_caster(i, place);
                add_caster(view, ray, ray_length, span, caster, place, scale);
            }
        }
    }
    barrier();
}

// Units an optical depth of 1: as fine as it gets without a sum passing 32 bits. Few casters may each take 2⁴, DARK, and
// with SPLIT twice; what many may take is added up. Writes to the slices; all threads call it alike.
float part_scale(TilePart part) {
    if (part.count < MANY) {
        return exp2(float(min(22, (SPLIT ? 26 : 27) - findMSB(part.count))));
    }
    uint thread = gl_LocalInvocationIndex;
    uvec2 most = uvec2(0u);
    for (uint i = thread; i < part.count; i += THREADS) {
        wide_add(most, caster_bound(casters[entries[part.first + i].y], DARK * (SPLIT ? 2.0 : 1.0)));
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

// Where parts are not listed: two workgroups a tile, the second without work where there are no casters.
bool unlisted_part(out TilePart part) {
    uvec2 tiles = (map_size() + 7u) / 8u;
    uint place = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, tile = place / 2u, map = gl_WorkGroupID.z;
    uint bin = map * tiles.x * tiles.y + tile;
    if (tile >= tiles.x * tiles.y) {
        return false;
    }
    uint count = counts[bin];
    part = TilePart(tile, map << 8 | place & 1u, bin * room, min(count, room));
    return count > 0u || (place & 1u) == 0u;
}

void main() {
    TilePart part;
    if (room == 0u ? !listed_part(part) : !unlisted_part(part)) {
        return;
    }
    uint map = part_map(part);
    View view = maps[map].volume;
    uint thread = gl_LocalInvocationIndex;
    uvec2 corner = part_corner(view, part);
    uint t = thread % TEXELS, begin = thread / TEXELS * RUN, end = min(begin + RUN, SLICES);
    uvec2 texel = corner + uvec2(t % ROW, t / ROW);
    if (part.count == 0u) {
        for (; texel.y < min(corner.y + ROW, view.height); texel.y += ROWS) {
            for (uint k = begin; k < end && texel.x < view.width; k += 4u) {
                write(map, texel, k, vec4(1.0));
            }
        }
        return;
    }
    corner.y += part_of_tile(part) * ROWS;
    texel.y += part_of_tile(part) * ROWS;

    float scale = part_scale(part), unit = 1.0 / scale;
    for (uint i = thread; i < SLICES * TEXELS; i += THREADS) {
        slices[i] = 0u;
    }
    add_casters(view, part, corner, scale);

    // The sum of each run stands where its last slice was; then that of the runs before it.
    uint before = 0u, upto = 0u;
    if (RUNS != 1u) {
        for (uint k = begin; k < end; ++k) {
            upto += slices[k * TEXELS + t];
        }
        if (begin < end) {
            slices[(end - 1u) * TEXELS + t] = upto;
        }
        barrier();
        for (uint last = RUN - 1u; last < min(begin, SLICES); last += RUN) {
            before += slices[last * TEXELS + t];
        }
    }
    upto += before;
    end_part(part);
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    vec4 behind = vec4(exp(-float(before) * unit));
    for (uint k = begin; k < end; k += 4u) {
        uvec4 sums;
        uint here = before;
        for (uint i = 0u; i < 4u; ++i) {
            here += slices[(k + i) * TEXELS + t];
            sums[i] = here;
        }
        sums.w = RUNS != 1u && k + 4u == end ? upto : sums.w;
        // In most layers a ray meets nothing.
        if (sums.w != before) {
            behind = exp(-vec4(sums) * unit);
            before = sums.w;
        } else {
            behind = behind.wwww;
        }
        write(map, texel, k, behind);
    }
}
