#version 460
// Builds the rays of half a tile, 8×4 texels, in any order of the casters: adds up their optical depth in the slices and
// writes what is left of the light behind each slice once. No clear, no blending, no propagation.
// Inputs: maps, casters, parts, entries. Output: volume, every texel of it.
// Invariant: sums are of whole numbers, so the result depends only on the casters, not on the order they come in.
// Source: ours. Twin: reference::psm::fused.

// 0: there are no strands, and their arithmetic is left out.
layout(constant_id = 7) const uint STRANDS = 1u;
#define CASTER_STRANDS (STRANDS == 1u)
#include "bins/sums.glsl"
#include "bins/totals.glsl"
#include "bins/view_caster.glsl"
#include "common/light.glsl"
#include "psm/format.glsl"
#include "psm/place.glsl"

// 512, or 32 where the threads of a workgroup do not run at the same time anyway.
layout(local_size_x_id = 8) in;
// The same number: what is read of a specialized workgroup size is no constant to every tool.
layout(constant_id = 9) const uint THREADS = 512u;

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 1, scalar) readonly buffer Parts { TilePart parts[]; };
layout(set = 1, binding = 3, scalar) readonly buffer Totals { BinTotals totals[]; };
layout(set = 1, binding = 4, scalar) readonly buffer Entries { uvec2 entries[]; };
layout(set = 2, binding = 0, VOLUME_FORMAT) uniform writeonly image3D volume;

layout(push_constant, scalar) uniform Push { uint map; };

#include "bins/in_use.glsl"

const uint ROW = 8u, ROWS = 4u, TEXELS = ROW * ROWS;
// Texels of a row that a thread looks at for a caster; casters that are looked at at the same time. Few threads save more by
// fetching a caster for more texels.
const uint SPAN = THREADS > TEXELS ? 4u : 8u, SPANS = TEXELS / SPAN, CASTERS = THREADS / SPANS;
// Runs of slices that are summed at the same time, each by one thread a texel, and slices of a run: whole layers.
const uint RUNS = THREADS / TEXELS;
const uint RUN = (SLICES / 4u + RUNS - 1u) / RUNS * 4u;

// Slice k of texel t at k · TEXELS + t, so that the threads of a subgroup never meet in a bank: units of optical depth.
// With 256 slices it is all the shared memory that many devices have, so the first word is a bound before it is a sum.
shared uint slices[SLICES * TEXELS];

void write(ivec3 at, vec4 transmittance) {
    imageStore(volume, at, ADDITIVE == 1u ? 1.0 - transmittance : transmittance);
}

// Adds what a caster, in the view's axes, takes of the rays of a span of texels, the first of which stands at `first` of all
// and at `local` of the half tile.
void add_caster(View view, uvec2 first, uint local, uint rotation, Caster caster, float scale) {
    Place place = depth_place(view_depth(view, caster.position.z + 0.5 * caster.axis.z));
    Ray begin = view_texel_ray(view, first);
    float step = 2.0 / (float(view.width) * view.scale_x);
    for (uint i = 0u; i < SPAN; ++i) {
        // Casters begin at different texels, for the banks again.
        uint x = (i + rotation) % SPAN;
        Ray ray = begin;
        if (view.projection == VIEW_PARALLEL) {
            ray.origin.x += float(x) * step;
        } else {
            ray.direction.x += float(x) * step;
        }
        vec2 z;
        float optical_depth;
        if (view_segment(view, ray, length(ray.direction), caster, z, optical_depth)) {
            uint at = place.slice * TEXELS + local + x;
            optical_depth = min(optical_depth, MAX_OPTICAL_DEPTH);
            atomicAdd(slices[at], uint(min(optical_depth * (1.0 - place.share), DARK) * scale + 0.5));
            if (SPLIT == 1u && place.slice + 1u < SLICES) {
                atomicAdd(slices[at + TEXELS], uint(min(optical_depth * place.share, DARK) * scale + 0.5));
            }
        }
    }
}

void main() {
    TilePart part;
    if (!listed_part(map, part)) {
        return;
    }
    View view = maps[map].volume;
    uvec2 tiles = (uvec2(view.width, view.height) + ROW - 1u) / ROW;
    uvec2 corner = uvec2(part.tile % tiles.x, part.tile / tiles.x) * ROW;
    uint count = part.count, thread = gl_LocalInvocationIndex;
    uint t = thread % TEXELS, begin = thread / TEXELS * RUN, end = min(begin + RUN, SLICES);
    uvec2 texel = corner + uvec2(t % ROW, t / ROW);
    if (count == 0u) {
        // All of the tile.
        for (; texel.y < min(corner.y + ROW, view.height); texel.y += ROWS) {
            for (uint k = begin; k < end && texel.x < view.width; k += 4u) {
                write(ivec3(texel, map * LAYERS + k / 4u), vec4(1.0));
            }
        }
        return;
    }
    texel.y += part.part * ROWS;
    corner.y += part.part * ROWS;
    uint first = part.first, most = 0u, local = thread % SPANS * SPAN;
    for (uint i = thread; i < count; i += THREADS) {
        most += caster_bound(casters[entries[first + i].y], DARK * float(1u + SPLIT));
    }
    for (uint i = thread; i < SLICES * TEXELS; i += THREADS) {
        slices[i] = 0u;
    }
    barrier();
    atomicAdd(slices[0], most);
    barrier();
    float scale = sum_scale(slices[0]), unit = 1.0 / scale;
    barrier();
    if (thread == 0u) {
        slices[0] = 0u;
    }
    barrier();
    for (uint i = thread / SPANS; i < count; i += CASTERS) {
        Caster caster = casters[entries[first + i].y];
        uvec2 begin = corner + uvec2(local % ROW, local / ROW);
        add_caster(view, begin, local, thread / SPANS, view_caster(view, caster), scale);
    }
    barrier();
    // The sum of each run stands where its last slice was; then that of the runs before it.
    uint total = 0u, sum = 0u;
    if (RUNS > 1u) {
        for (uint k = begin; k < end; ++k) {
            total += slices[k * TEXELS + t];
        }
        if (begin < end) {
            slices[(end - 1u) * TEXELS + t] = total;
        }
        barrier();
        for (uint last = RUN - 1u; last < begin; last += RUN) {
            sum += slices[last * TEXELS + t];
        }
    }
    total += sum;
    if (any(greaterThanEqual(texel, uvec2(view.width, view.height)))) {
        return;
    }
    for (uint k = begin; k < end; k += 4u) {
        uvec4 behind;
        for (uint i = 0u; i < 4u; ++i) {
            sum += slices[(k + i) * TEXELS + t];
            behind[i] = sum;
        }
        behind.w = RUNS > 1u && k + 4u == end ? total : behind.w;
        write(ivec3(texel, map * LAYERS + k / 4u), exp(-vec4(behind) * unit));
    }
}
