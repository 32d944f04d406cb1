// Bins casters into tiles of 8×8 texels of the light's map. Twin: reference::twin::bins.
#ifndef MAPS_BINS_TILES_GLSL
#define MAPS_BINS_TILES_GLSL
#include "maps/bins/texel.glsl"
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/sheet.glsl"

layout(push_constant, scalar) uniform BinPush {
    uint caster_count;
    uint capacity;  // capacity of the buffer, in entries
    uint room;      // not 0: capacity of each tile, in entries; entries are then not counted beforehand
    uint mark;      // value in met[] that marks casters in any tile; if entries are kept, a different one for each build
    uint map_count;
};

const uint TILE_TEXELS = 8u;
// Number of threads that share the tiles of a caster: 16, or 1 on devices whose threads do not run in parallel anyway.
CONSTANT(uint, TILE_LANES, 16u)

// True leaves casters in the dark behind the meshes out of a tile.
CONSTANT(bool, HIDE, false)

// Threads per workgroup of the passes that bin.
const uint BIN_THREADS = 64u;

// Index of this thread among all threads of its map, in a dispatch over two dimensions.
uint map_thread() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * BIN_THREADS + gl_LocalInvocationIndex;
}

uvec2 tile_counts(View view) {
    return (uvec2(view.width, view.height) + TILE_TEXELS - 1u) / TILE_TEXELS;
}

// The tiles, low to high, both included, of the texels whose centres (with AREA: whose squares) are within the caster's bounds. False if
// there are none.
bool caster_tiles(View view, Caster caster, out uvec2 low_tile, out uvec2 high_tile) {
    vec2 low, high;
    low_tile = high_tile = uvec2(0u);
    if (!texel_bounds(view, view_caster(view, caster), low, high)) {
        return false;
    }
    vec2 size = vec2(view.width, view.height);
    vec2 first = ceil(clamp(low, vec2(0.0), size));
    vec2 last = floor(clamp(high, vec2(-1.0), size - 1.0));
    if (any(greaterThan(first, last))) {
        return false;
    }
    low_tile = uvec2(first) / TILE_TEXELS;
    high_tile = uvec2(last) / TILE_TEXELS;
    return true;
}

// Finds the strand's point nearest to the ray through the tile's centre. Returns the point's position along the strand's axis, 0 to 1;
// `across`: its offset from that ray.
float tile_along(View view, Caster strand, uvec2 tile, out vec3 across) {
    vec3 start, axis;
    float along;
    bool aslant = strand_along(view_ray(view, vec2(tile * TILE_TEXELS) + 0.5 * float(TILE_TEXELS)), strand, start, axis, along);
    along = aslant ? clamp(along, 0.0, 1.0) : 0.0;
    across = start + along * axis;
    return along;
}

// In a parallel view: distance from a sphere's centre to a tile shrunk by `inset` texels on each side, along right and up, in units of the
// radius.
vec2 tile_apart(View view, Caster sphere, uvec2 tile, float inset) {
    vec2 scale = vec2(view.scale_x, view.scale_y), size = vec2(view.width, view.height);
    vec3 offset = sphere.position - view.origin;
    vec2 centre = vec2(dot(offset, view.right), dot(offset, view.up));
    vec2 low = ((vec2(tile * TILE_TEXELS) + inset) / size * 2.0 - 1.0) / scale;
    vec2 high = ((vec2(tile * TILE_TEXELS + TILE_TEXELS) - inset) / size * 2.0 - 1.0) / scale;
    return max(max(low - centre, centre - high), vec2(0.0)) / sphere.radius;
}

// Lower bound of the squared distance from the caster to the nearest ray of a tile, in units of the radius. The tile is shrunk by `inset`
// texels on each side (half a texel: to the rays of texel centres). For a sphere in a parallel view the bound is exact. For a strand in a
// parallel view it is the distance to the circle around the tile, which is too small by half a texel or more. In perspective the bound is
// 0, since tiles are not rectangles across the rays.
float tile_distance(View view, Caster caster, uvec2 tile, float inset) {
    if (view.projection == VIEW_PERSPECTIVE) {
        return 0.0;
    }
    if (caster_is_strand(caster)) {
        vec2 scale = vec2(view.scale_x, view.scale_y), size = vec2(view.width, view.height);
        vec3 across;
        tile_along(view, caster, tile, across);
        float apart = max(length(across) - length(float(TILE_TEXELS) / (size * scale)), 0.0) / caster.radius;
        return apart * apart;
    }
    vec2 apart = tile_apart(view, caster, tile, inset);
    return dot(apart, apart);
}

// The same bound, for the nearest ray that a texel of the tile represents.
float tile_distance(View view, Caster caster, uvec2 tile) {
    return tile_distance(view, caster, tile, 0.5 - TEXEL_REACH);
}

// A tile may be skipped if none of its rays meets the caster; the margin covers rounding errors.
bool tile_missed(float distance_square) {
    return distance_square > 1.0001;
}

// Whether no light reaches the caster in a tile, so that its shadow is never seen. The margin covers rounding errors.
bool tile_hidden(View view, Caster caster, float horizon) {
    if (!HIDE) {
        return false;
    }
    float start = dot(caster.position - view.origin, view.forward);
    float nearest = caster_is_strand(caster) ? min(start, start + dot(caster.axis, view.forward)) : start - caster.radius;
    return nearest > horizon + 1e-5 * (view.far - view.near);
}

// True: an entry holds its sort key. False, for casters that are summed in any order: an entry holds its caster's greatest optical depth on
// any ray.
CONSTANT(bool, KEYED, true)

// Depth of a sphere's front, nearest within the tile, of the strand's point nearest to the tile's centre, or of a sheet there, as float
// bits, which compare like the depths since none is negative.
uint tile_key(View view, Caster caster, uvec2 tile, float distance_square) {
    float centre = dot(caster.position - view.origin, view.forward);
    float nearest = centre - caster.radius * sqrt(max(1.0 - distance_square, 0.0));
    if (caster_is_strand(caster)) {
        vec3 across;
        nearest = centre + tile_along(view, caster, tile, across) * dot(caster.axis, view.forward);
    }
    if (caster_is_sheet(caster)) {
        View about = view;
        about.origin = vec3(0.0);
        Ray ray = view_ray(about, vec2(tile * TILE_TEXELS) + 0.5 * float(TILE_TEXELS));
        nearest = sheet_plane(view.origin, ray, caster);
    }
    return floatBitsToUint(max(view_depth(view, nearest), 0.0));
}

// The entry of caster `index` in a tile.
uvec2 tile_entry(View view, Caster caster, uint index, uvec2 tile, float distance_square) {
    return uvec2(KEYED ? tile_key(view, caster, tile, distance_square) : floatBitsToUint(caster_most(caster)), index);
}
#endif
