#version 460
// Computes how far light reaches in each tile of each map: the farthest z at which a mesh blocks the light, over the texels of the tile and
// the surrounding texels from which a look-up may read the tile. FARTHEST if some light hits no mesh. One workgroup per tile. Inputs: maps,
// the opaque map. Outputs: horizon. Twin: reference::twin::bins::horizon. Invariant: a point in space behind the horizon of a tile that its
// look-up reads has an opaque visibility of 0. A lit point of a surface may be behind the horizon, by at most the depth that the surface
// recedes within the texels of a compare.
#include "maps/bins/set.glsl"
#include "maps/bins/tiles.glsl"
#include "maps/opaque.glsl"

layout(local_size_x = BIN_THREADS) in;

// Number of texels around a tile from which a look-up may read the tile: one for the bilinear weights, plus a filter's radius.
CONSTANT(uint, REACH, 1u)

BINS_HORIZON(writeonly buffer)

shared uint farthest;

// Maps a texel of the volume view to the opaque view: the same at every z, since both views have the same rays.
vec2 in_opaque(uint map, vec2 texel) {
    Ray ray = view_ray(maps[map].caster_view, texel);
    return view_project(maps[map].opaque, ray.origin + ray.direction).xy;
}

void main() {
    uint map = gl_WorkGroupID.z;
    View view = maps[map].caster_view, opaque = maps[map].opaque;
    if (gl_LocalInvocationIndex == 0u) {
        farthest = 0u;
    }
    barrier();
    vec2 a = in_opaque(map, vec2(gl_WorkGroupID.xy * TILE_TEXELS) - float(REACH));
    vec2 b = in_opaque(map, vec2(gl_WorkGroupID.xy * TILE_TEXELS + TILE_TEXELS) + float(REACH));
    // The four texels of a compare, and one more as a margin for rounding; past the map's edge nothing blocks the light.
    ivec2 size = ivec2(opaque.width, opaque.height);
    ivec2 low = ivec2(clamp(floor(min(a, b) - 0.5), vec2(-2.0), vec2(size))) - 1;
    ivec2 high = ivec2(clamp(floor(max(a, b) - 0.5), vec2(-2.0), vec2(size))) + 2;
    float far = any(lessThan(low, ivec2(0))) || any(greaterThanEqual(high, size)) ? 1.0 : 0.0;
    ivec2 extent = high - low + 1, corner = opaque_corner(opaque, map, opaque_map);
    for (int i = int(gl_LocalInvocationIndex); far < 1.0 && i < extent.x * extent.y; i += 64) {
        ivec2 texel = low + ivec2(i % extent.x, i / extent.x);
        far = max(far, texelFetch(opaque_map, corner + texel, 0).r);
    }
    atomicMax(farthest, floatBitsToUint(far));
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        float depth = uintBitsToFloat(farthest);
        float z = opaque.near + depth * (opaque.far - opaque.near) + dot(opaque.origin - view.origin, view.forward);
        uint place = (map * gl_NumWorkGroups.y + gl_WorkGroupID.y) * gl_NumWorkGroups.x + gl_WorkGroupID.x;
        horizon[place] = depth >= 1.0 ? FARTHEST : z;
    }
}
