#version 460
// Builds the rays of one tile of 8×8 texels in any order of the casters: adds up their optical depth in the slices, CHUNK
// slices at a time, and writes what is left of the light behind each slice once. No clear, no blending, no propagation.
// Inputs: maps, casters, counts, offsets, entries. Output: volume, every texel of it.
// Invariant: sums are of whole numbers, so the result depends only on the casters, not on the order they come in.
// Source: ours. Twin: reference::psm::fused.
#extension GL_EXT_control_flow_attributes : require

// 0: there are no strands, and their arithmetic is left out.
layout(constant_id = 7) const uint STRANDS = 1u;
#define CASTER_STRANDS (STRANDS == 1u)
#include "bins/sums.glsl"
#include "bins/view_caster.glsl"
#include "common/light.glsl"
#include "psm/format.glsl"
#include "psm/place.glsl"

const uint TEXELS = 64u;
// Casters that are looked at at the same time, each by one thread a texel; runs of slices that are summed at the same time.
const uint GROUPS = 4u;
layout(local_size_x = TEXELS, local_size_y = GROUPS) in;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Offsets { uint offsets[]; };
layout(set = 1, binding = 4, scalar) readonly buffer Entries { uvec2 entries[]; };
layout(set = 2, binding = 0, VOLUME_FORMAT) uniform writeonly image3D volume;

layout(push_constant, scalar) uniform Push { uint map; };

const uint CHUNK = 64u;
// Slices that a group sums.
const uint RUN = CHUNK / GROUPS;
const uint THREADS = TEXELS * GROUPS;
// Slice c of texel t at c · TEXELS + t, so that the threads of a subgroup never meet in a bank.
shared uint slices[CHUNK * TEXELS];
shared uint run_sums[GROUPS * TEXELS];
shared uint bound;
// Casters in the view's axes: all of a tile's, chunk after chunk, where there is room; or some of those that reach into the
// chunk at hand.
shared Caster batch[THREADS];
shared Place places[THREADS];
shared uint filled;
const uint MAX_CHUNKS = 4u;
shared uint chunk_counts[MAX_CHUNKS];

void write(ivec3 at, vec4 transmittance) {
    imageStore(volume, at, ADDITIVE == 1u ? 1.0 - transmittance : transmittance);
}

// Adds what a caster of the batch takes of a texel's ray to the chunk that begins at slice `base`.
void add_caster(View view, Ray ray, float ray_length, uint i, uint base, float scale) {
    vec2 z;
    float optical_depth;
    if (!view_segment(view, ray, ray_length, batch[i], z, optical_depth)) {
        return;
    }
    uint t = gl_LocalInvocationID.x;
    optical_depth = min(optical_depth, MAX_OPTICAL_DEPTH);
    float share = SPLIT == 1u ? places[i].share : 0.0;
    uint here = uint(min(optical_depth * (1.0 - share), DARK) * scale + 0.5);
    uint slice = places[i].slice - base;  // wraps for the slice before the chunk
    if (slice < CHUNK) {
        atomicAdd(slices[slice * TEXELS + t], here);
    }
    if (SPLIT == 1u && slice + 1u < CHUNK) {
        atomicAdd(slices[(slice + 1u) * TEXELS + t], uint(min(optical_depth * share, DARK) * scale + 0.5));
    }
}

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint first = offsets[tile], count = counts[map * gl_NumWorkGroups.x * gl_NumWorkGroups.y + tile];
    View view = maps[map].volume;
    uint t = gl_LocalInvocationID.x, group = gl_LocalInvocationID.y;
    uvec2 texel = gl_WorkGroupID.xy * 8u + uvec2(t % 8u, t / 8u);
    bool inside = all(lessThan(texel, uvec2(view.width, view.height)));
    if (count == 0u) {
        for (uint layer = group; inside && layer < SLICES / 4u; layer += GROUPS) {
            write(ivec3(texel, map * LAYERS + layer), vec4(1.0));
        }
        return;
    }
    uint thread = gl_LocalInvocationIndex;
    if (thread == 0u) {
        bound = 0u;
    }
    if (thread < MAX_CHUNKS) {
        chunk_counts[thread] = 0u;
    }
    barrier();
    // Split, a caster may reach into two chunks.
    bool once = SPLIT == 0u && count <= THREADS;
    Caster mine;
    Place place;
    uint most = 0u, slot = 0u;
    for (uint i = thread; i < count; i += THREADS) {
        mine = casters[entries[first + i].y];
        most += caster_bound(mine, DARK * float(1u + SPLIT));
    }
    atomicAdd(bound, most);
    if (once && thread < count) {
        mine = view_caster(view, mine);
        place = depth_place(view_depth(view, mine.position.z + 0.5 * mine.axis.z));
        slot = atomicAdd(chunk_counts[place.slice / CHUNK], 1u);
    }
    barrier();
    if (once && thread < count) {
        for (uint c = 0u; c < place.slice / CHUNK; ++c) {
            slot += chunk_counts[c];
        }
        batch[slot] = mine;
        places[slot] = place;
    }
    float scale = sum_scale(bound), unit = 1.0 / scale;
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction);

    for (uint i = gl_LocalInvocationIndex; i < CHUNK * TEXELS; i += THREADS) {
        slices[i] = 0u;
    }
    uint before = 0u;  // units of all slices of this texel before the chunk
    uint chunk_first = 0u;
    for (uint base = 0u; base < SLICES; base += CHUNK) {
        barrier();
        if (once) {
            uint end = chunk_first + chunk_counts[base / CHUNK];
            for (uint i = chunk_first + group; i < end; i += GROUPS) {
                add_caster(view, ray, ray_length, i, base, scale);
            }
            chunk_first = end;
        }
        for (uint begin = 0u; !once && begin < count; begin += THREADS) {
            if (thread == 0u) {
                filled = 0u;
            }
            barrier();
            if (begin + thread < count) {
                mine = view_caster(view, casters[entries[first + begin + thread].y]);
                place = depth_place(view_depth(view, mine.position.z + 0.5 * mine.axis.z));
                if (place.slice + 1u >= base && place.slice < base + CHUNK) {
                    slot = atomicAdd(filled, 1u);
                    batch[slot] = mine;
                    places[slot] = place;
                }
            }
            barrier();
            for (uint i = group; i < filled; i += GROUPS) {
                add_caster(view, ray, ray_length, i, base, scale);
            }
            barrier();
        }
        barrier();
        uint run[RUN], sum = 0u;
        [[unroll]] for (uint i = 0u; i < RUN; ++i) {
            uint slice = (group * RUN + i) * TEXELS + t;
            sum += slices[slice];
            run[i] = sum;
            slices[slice] = 0u;
        }
        run_sums[group * TEXELS + t] = sum;
        barrier();
        sum = before;
        [[unroll]] for (uint i = 0u; i < GROUPS; ++i) {
            sum += i < group ? run_sums[i * TEXELS + t] : 0u;
            before += run_sums[i * TEXELS + t];
        }
        [[unroll]] for (uint i = 0u; i < RUN; i += 4u) {
            uint slice = base + group * RUN + i;
            if (inside && slice < SLICES) {
                vec4 depths = vec4(uvec4(run[i], run[i + 1u], run[i + 2u], run[i + 3u]) + sum) * unit;
                write(ivec3(texel, map * LAYERS + slice / 4u), exp(-depths));
            }
        }
    }
}
