// AVSM look-up: how much of light `light` reaches `position`, 0 to 1. Source: Fife and Strugar 2013, Sampling from the AVSM data structure.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  curves, map by map in rows of texels, each as in maps/curve/node.glsl; then the curves of coarser levels, as in
//              maps/level_place.glsl
//   binding 4  number of casters in each tile of 8×8 texels, map by map in rows of tiles (any buffer if TILED is false); if DETAIL is true,
//              the words of each tile's blocks instead (maps/detail/blocks.glsl), and the curves are stored block by block
// Set the specialization constants NODES, EXPONENTIAL, TILED, PACKED, TIGHT, DETAIL and LEVELS to the values that the curves were built
// with.
// flat: bindings 0, constants 0: NODES EXPONENTIAL PACKED TIGHT TILED DETAIL FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#define MAP_TRANSMITTANCE avsm_transmittance
#include "maps/curve/look_up.glsl"
#include "maps/detail/blocks.glsl"

// Returns the weighted mean of the four texels around the point, at the resolution of the point's tile. If one of the four lies in another
// tile, which may have a different resolution, the texel of that tile that contains its centre is used instead.
float detailed_transmittance(LookUp l) {
    uvec2 tiles = (uvec2(l.view.width, l.view.height) + 7u) / 8u;
    uint first = l.map * tiles.x * tiles.y;
    uvec2 tile = uvec2(clamp(l.at, vec2(0.0), vec2(l.view.width, l.view.height) - 1.0)) / 8u;
    uint here = first + tile.y * tiles.x + tile.x, side = slot_side(visibility_tiles[here * SLOTS]);
    View fine = finer(l.view, side);
    Footprint f = view_footprint(fine, l.at * float(side));
    float transmittance = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = f.corner + ivec2(i % 2, i / 2);
        float through = 1.0;
        if (view_has(fine, texel)) {
            uvec2 of = uvec2(texel) / (8u * side), its = uvec2(texel);
            uint place = (first + of.y * tiles.x + of.x) * SLOTS, its_side = slot_side(visibility_tiles[place]);
            its = (2u * its + 1u) * its_side / (2u * side);
            uvec2 block = its / 8u - of * its_side;
            uint curve = slot_place(visibility_tiles[place + block.y * its_side + block.x]);
            uint within = its.y % 8u * 8u + its.x % 8u;
            through = curve > 0u ? curve_transmittance_at((curve - 1u) * 64u + within, l.depth) : 1.0;
        }
        transmittance += f.weights[i] * through;
    }
    return transmittance;
}

float avsm_transmittance(LookUp l) { return DETAIL ? detailed_transmittance(l) : leveled_transmittance(l); }
