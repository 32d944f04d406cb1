#version 460
// Places samples at even quantiles of the transmittance along a texel's ray, shifted by one random number per texel. The share of samples
// that have ended by a depth is then the share of light lost up to there, to within one sample. Each sample's depth is found by bisection
// over the depth range of the texel's casters. Source: ours, after systematic sampling, which predates computer graphics; Enderton et al.
// 2010 stratify each caster separately. Inputs: maps, casters, parts, entries. Output: samples. Twin:
// reference::twin::stochastic::quantiles. Invariant: sums are integers, so the bytes are the same in any order, and never decrease with
// depth.
layout(local_size_x = 8, local_size_y = 8) in;
const uint THREADS = 64u;
#include "maps/bins/batch.glsl"
#include "maps/bins/scale.glsl"
#include "technique/stochastic/draw.glsl"

// AT_ONCE: samples that are searched at a time, in vectors of four. HALVINGS: steps of the bisection.
const uint AT_ONCE = 16u;
const uint HALVINGS = 16u;

void keep_sample(uint place, uint bits) { samples[place] = bits; }

// Returns the share of a caster that lies before each depth. A step counts as passed at its own depth.
vec4 shares_before(vec4 at, vec2 z) {
    vec4 within = clamp((at - z.x) / max(z.y - z.x, 1e-30), 0.0, 1.0);
    return mix(within, vec4(1.0), greaterThanEqual(at, vec4(z.y)));
}

void main() {
    TilePart part;
    if (!listed_part(part)) {
        return;
    }
    uint map = part_map(part), all_units = 0u;
    View view = maps[map].caster_view;
    uvec2 texel = part_corner(view, part) + gl_LocalInvocationID.xy;
    bool inside = all(lessThan(texel, uvec2(view.width, view.height)));
    Ray ray = view_texel_ray(view, texel);
    float ray_length = length(ray.direction), scale = tile_scale(part);
    vec2 range = vec2(FARTHEST, -FARTHEST);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 z;
            float optical_depth;
            if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth)) {
                range = vec2(min(range.x, z.x), max(range.y, z.y));
                all_units += uint(optical_depth * scale + 0.5);
            }
        }
    }
    uint first = first_sample(view, map, texel);
    float offset = stochastic_share(texel_key(texel));
    for (uint of = 0u; of < SAMPLES; of += AT_ONCE) {
        uvec4 wanted[AT_ONCE / 4u];
        vec4 at[AT_ONCE / 4u];
        [[unroll]] for (uint k = 0u; k < AT_ONCE / 4u; ++k) {
            vec4 lost = min((float(of + 4u * k) + vec4(0.0, 1.0, 2.0, 3.0) + offset) / float(SAMPLES), 0.9999999);
            wanted[k] = uvec4(-log(1.0 - lost) * scale);
            at[k] = vec4(range.x);
        }
        float wide = range.y - range.x;
        for (uint halved = 0u; halved < HALVINGS && part.count > 0u; ++halved) {
            wide *= 0.5;
            uvec4 sums[AT_ONCE / 4u];
            [[unroll]] for (uint k = 0u; k < AT_ONCE / 4u; ++k) {
                sums[k] = uvec4(0u);
            }
            for (uint begin = 0u; begin < part.count; begin += batch_size()) {
                uint filled = min(batch_size(), part.count - begin);
                fetch_batch(view, part.first + begin, filled);
                for (uint i = 0u; i < filled; ++i) {
                    vec2 z;
                    float optical_depth;
                    if (view_segment(view, ray, ray_length, batch_caster(i), DARK, z, optical_depth)) {
                        [[unroll]] for (uint k = 0u; k < AT_ONCE / 4u; ++k) {
                            sums[k] += uvec4(shares_before(at[k] + wide, z) * (optical_depth * scale) + 0.5);
                        }
                    }
                }
            }
            [[unroll]] for (uint k = 0u; k < AT_ONCE / 4u; ++k) {
                at[k] = mix(at[k], at[k] + wide, lessThanEqual(sums[k], wanted[k]));
            }
        }
        [[unroll]] for (uint i = 0u; i < AT_ONCE; ++i) {
            if (inside && of + i < SAMPLES) {
                bool ends = wanted[i / 4u][i % 4u] < all_units;
                keep_sample(first + of + i, ends ? depth_bits(view_depth(view, at[i / 4u][i % 4u])) : NO_END);
            }
        }
    }
    end_part(part);
}
