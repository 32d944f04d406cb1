#version 460
// Marches each texel's ray through the density grid of smoke and hair, and keeps the transmittance as a curve of samples. It keeps a sample
// where the transmittance differs by more than both thresholds from the transmittance that the extinction at the last kept sample predicts.
// If there are more than WORK samples, it removes those that change the curve least; in the end NODES samples stay. One workgroup per tile
// of 8×8 texels, the map in z. Sources: Unreal Engine 5, Heterogeneous Volumes (which samples are kept); Salvi et al. 2010 (which are
// removed); Amanatides and Woo 1987 (the march); that steps end at voxels' sides, and are not even, is ours. Inputs: maps, the grid, its
// media. Outputs: nodes; counts: for each tile, how many rays meet smoke or hair. Twin: reference::twin::marched. Invariants: samples have
// the grid's exact optical depth; the last has that of the whole ray, up to DARK; where TILED is true, a tile whose rays all miss smoke and
// hair has no nodes.
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
// How far the transmittance may differ from the prediction before a sample is kept: as a share of all light, and as a
// share of the light that is left.
CONSTANT(float, ABSOLUTE_ERROR, 0.0)
CONSTANT(float, RELATIVE_ERROR, 0.05)

// At place p on the way, the depth in the light's range is depth_of.x + depth_of.y · p.
vec2 depth_of;
// The place where the range begins.
float near_place;

// kept_place, kept_value and kept_rate: the place of the last sample that was kept, the optical depth up to there, and the extinction
// behind it. last_place and last_value: the end of the last stretch, and the optical depth up to there.
float kept_place, kept_value, kept_rate;
float last_place, last_value;

void keep(float rate) {
    curve_append(clamp(depth_of.x + depth_of.y * last_place, 0.0, 1.0), last_value);
    kept_place = last_place;
    kept_value = last_value;
    kept_rate = rate;
}

// Adds a stretch of even extinction, from where the last stretch ended to `end`.
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
    // What is in front of the range counts at its near end.
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

// Voxels take the same in each direction.
float media_towards(float sum, uvec3 voxel) { return sum; }

#include "grid/march_media.glsl"

// Marches all of the ray that is in the grid. A voxel reaches farther than the casters in it, so the march may meet smoke in front of the
// light's range of depths or behind it. Such parts count at the ends of the range.
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
