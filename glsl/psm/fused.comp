#version 460
// Builds the rays of half a tile, 8×4 texels, in any order of the casters: adds up their optical depth in the slices and
// writes what is left of the light behind each slice once. No clear, no blending, no propagation. Of a tile without casters,
// one workgroup writes all.
// Inputs: maps, casters, totals, parts, entries. Output: volume, every texel of it.
// Invariant: sums are of whole numbers, so the result depends only on the casters, not on the order they come in.
// Source: ours. Twin: reference::twin::psm::fused.

// variants: BITS 8 16
#include "bins/part.glsl"
#include "bins/sums.glsl"
#include "psm/format.glsl"
#include "psm/place.glsl"

// A multiple of TEXELS: as many as the device has, up to 512; TEXELS where threads do not run at the same time anyway.
layout(local_size_x_id = ID_WORKGROUP) in;
// The same number: what is read of a specialized workgroup size is no constant to every tool.
CONSTANT(uint, THREADS, 512u)

layout(set = 2, binding = 0, VOLUME_FORMAT) uniform writeonly image3D volume;

const uint ROW = 8u, ROWS = 4u, TEXELS = ROW * ROWS;
// Texels of a row that a thread looks at for a caster, and casters that are looked at at the same time. Few threads gain more
// from fetching a caster less often.
const uint SPAN = THREADS == TEXELS ? 8u : 4u, SPANS = TEXELS / SPAN, CASTERS = THREADS / SPANS;
// Runs of slices that are summed at the same time, each by one thread a texel, and slices of a run: whole layers.
const uint RUNS = THREADS / TEXELS, RUN = (SLICES / 4u + RUNS - 1u) / RUNS * 4u;

// Slice k of texel t at k · TEXELS + t, so that the threads of a subgroup never meet in a bank: units of optical depth. With
// 256 slices it is all the shared memory that many devices have, so the first two words are the bound before they are
// sums.
shared uint slices[SLICES * TEXELS];

void write(uint map, uvec2 texel, uint slice, vec4 transmittance) {
    ivec3 at = ivec3(texel, map * LAYERS + slice / 4u);
    imageStore(volume, at, ADDITIVE ? 1.0 - transmittance : transmittance);
}

// Adds what a caster, in the view's axes, takes of the rays of a span, the first of which is `ray`, `place_in_part` among the
// texels.
void add_caster(View view, Ray ray, uint place_in_part, uint rotation, Caster caster, float scale) {
    Place place = depth_place(view_depth(view, caster.position.z + 0.5 * caster.axis.z));
    float texel_width = 2.0 / (float(view.width) * view.scale_x);
    for (uint i = 0u; i < SPAN; ++i) {
        // Casters begin at different texels of a span, for the banks again.
        uint x = (i + rotation) % SPAN;
        Ray beside = view_ray_beside(view, ray, float(x) * texel_width);
        vec2 z;
        float optical_depth;
        if (view_segment(view, beside, length(beside.direction), caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
            uint at = place.slice * TEXELS + place_in_part + x;
            atomicAdd(slices[at], uint(min(optical_depth * (1.0 - place.share), DARK) * scale + 0.5));
            if (SPLIT && place.slice + 1u < SLICES) {
                atomicAdd(slices[at + TEXELS], uint(min(optical_depth * place.share, DARK) * scale + 0.5));
            }
        }
    }
}

void main() {
    TilePart part;
    if (!listed_part(part)) {
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

    uvec2 most = uvec2(0u);
    for (uint i = thread; i < part.count; i += THREADS) {
        wide_add(most, caster_bound(casters[entries[part.first + i].y], DARK * (SPLIT ? 2.0 : 1.0)));
    }
    for (uint i = thread; i < SLICES * TEXELS; i += THREADS) {
        slices[i] = 0u;
    }
    barrier();
    WIDE_ATOMIC_ADD(slices[0], slices[1], most);
    barrier();
    float scale = sum_scale(uvec2(slices[0], slices[1])), unit = 1.0 / scale;
    barrier();
    if (thread == 0u) {
        slices[0] = slices[1] = 0u;
    }
    barrier();

    uint span = thread % SPANS * SPAN;
    Ray ray = view_texel_ray(view, corner + uvec2(span % ROW, span / ROW));
    for (uint i = thread / SPANS; i < part.count; i += CASTERS) {
        Caster caster = tile_caster(view, part.first + i);
        add_caster(view, ray, span, thread / SPANS, caster, scale);
    }
    barrier();

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
    for (uint k = begin; k < end; k += 4u) {
        uvec4 sums;
        for (uint i = 0u; i < 4u; ++i) {
            before += slices[(k + i) * TEXELS + t];
            sums[i] = before;
        }
        sums.w = RUNS != 1u && k + 4u == end ? upto : sums.w;
        write(map, texel, k, exp(-vec4(sums) * unit));
    }
}
