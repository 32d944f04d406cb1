#version 460
// Marches each texel's ray through the density grid of smoke and hair, and stores the transmittance as a curve of samples. A sample is kept
// where the transmittance differs by more than both thresholds from the prediction by the extinction at the last kept sample. If there are
// more than WORK samples, those that change the curve least are removed; in the end NODES samples remain. One workgroup per tile of 8×8
// texels, with the map in z. Sources: Unreal Engine 5, Heterogeneous Volumes (which samples are kept); Salvi et al. 2010 (which are
// removed); Amanatides and Woo 1987 (the march); stepping from one voxel's side to the next instead of evenly is ours. Inputs: maps, the
// grid, its media. Outputs: nodes; counts, the number of rays of each tile that hit smoke or hair. Twin: reference::twin::marched.
// Invariants: samples have the grid's exact optical depth; the last sample has the optical depth of the whole ray, up to DARK; if TILED is
// true, a tile whose rays all miss smoke and hair has no nodes.
#include "maps/scene.glsl"
#include "grid/media.glsl"
#include "maps/curve/tiled.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// set 1: marched
layout(set = 1, binding = 0, scalar) readonly buffer MarchedGrid { Grid grid; };
layout(set = 1, binding = 1, scalar) readonly buffer MarchedMedia { uint visibility_media[]; };
layout(set = 1, binding = 2, scalar) readonly buffer MarchedBits { uint visibility_media_bits[]; };
// set 2: curves
layout(set = 2, binding = 0, scalar) writeonly buffer Nodes { uvec2 nodes[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer Counts { uint counts[]; };

#include "maps/curve/curve.glsl"
#include "maps/curve/store.glsl"

// Voxels per side.
CONSTANT(uint, GRID_SIZE, 128u)
// Tolerances for the difference between the transmittance and the prediction, beyond which a sample is kept: as a fraction of all light,
// and as a fraction of the remaining light.
CONSTANT(float, ABSOLUTE_ERROR, 0.0)
CONSTANT(float, RELATIVE_ERROR, 0.05)

// At position p along the ray, the depth in the light's range is depth_of.x + depth_of.y · p.
vec2 depth_of;
// Position where the range begins.
float near_place;

// kept_place, kept_value and kept_rate: the position of the last kept sample, the optical depth up to there, and the extinction behind it.
// last_place and last_value: the end of the last stretch, and the optical depth up to there.
float kept_place, kept_value, kept_rate;
float last_place, last_value;

void keep(float rate) {
    curve_append(clamp(depth_of.x + depth_of.y * last_place, 0.0, 1.0), last_value);
    kept_place = last_place;
    kept_value = last_value;
    kept_rate = rate;
}

// Adds a stretch of constant extinction, from the end of the last stretch to `end`.
void stretch(float rate, float end) {
    float value = last_value + rate * (end - last_place), through = exp(-value);
    float error = abs(through - exp(-(kept_value + kept_rate * (end - kept_place))));
    if (last_place > kept_place && error > ABSOLUTE_ERROR && error > RELATIVE_ERROR * through) {
        keep(rate);
    }
    last_place = end;
    last_value = value;
}

#define MEDIA_VISIT
void media_visit(float rate, float begin, float end) {
    if (!(rate > 0.0) || last_value >= DARK) {
        return;
    }
    // Media in front of the range count at its near end.
    if (begin < near_place) {
        last_place = min(end, near_place);
        last_value += rate * (last_place - begin);
        if (end <= near_place) {
            return;
        }
        begin = near_place;
    }
    if (node_count == 0) {
        last_place = last_value > 0.0 ? near_place : begin;
        keep(last_place < begin ? 0.0 : rate);
    }
    if (begin > last_place) {
        stretch(0.0, begin);
    }
    stretch(rate, end);
}

// Voxels absorb the same in every direction.
float media_towards(float sum, uvec3 voxel) { return sum; }

#include "grid/march_media.glsl"

// Marches the whole part of the ray that is in the grid. Voxels extend beyond the casters in them, so the march may find smoke in front of
// the light's range of depths or behind it. Smoke in front of the range counts at its near end, smoke behind it at its far end.
void march_ray(View view, uvec2 texel) {
    View about = view;
    about.origin -= grid.origin;
    Ray ray = view_ray(about, vec2(texel) + 0.5);
    // The grid's diagonal.
    float reach = 1.7320509 * float(GRID_SIZE) * grid.voxel;
    float first = view.near - reach, last = view.far + reach;
    if (view.projection == VIEW_PERSPECTIVE) {
        first = max(first, 0.0);
    }
    depth_of = vec2(first - view.near, last - first) / (view.far - view.near);
    near_place = (view.near - first) / (last - first);
    media_exact((ray.origin + first * ray.direction) * grid.per_unit, ray.direction * ((last - first) * grid.per_unit));
    if (node_count > 0 || last_value > 0.0) {
        keep(0.0);
    }
}

shared uint rays;

void main() {
    uvec2 size = map_size(), texel = gl_GlobalInvocationID.xy;
    uint map = gl_WorkGroupID.z;
    bool within = all(lessThan(texel, size));
    if (gl_LocalInvocationIndex == 0u) {
        rays = 0u;
    }
    barrier();
    curve_clear();
    last_value = 0.0;
    if (within) {
        march_ray(maps[map].caster_view, texel);
    }
    if (node_count > 0) {
        atomicAdd(rays, 1u);
    }
    curve_reduce();
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        counts[(map * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x] = rays;
    }
    if (within && !tile_skipped(rays)) {
        store_curve((map * size.y + texel.y) * size.x + texel.x);
    }
}
