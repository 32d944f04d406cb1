// The survey of a tile, by which its resolution is chosen. Twin: maps::Survey.
#ifndef MAPS_DETAIL_SURVEY_GLSL
#define MAPS_DETAIL_SURVEY_GLSL
#extension GL_EXT_scalar_block_layout : require

// Cells per side of a tile in which casters are looked for.
const uint SURVEY_CELLS = 4u;
// LENGTH_UNITS: how many units stand for a length of one texel. DEPTH_UNITS: how many units stand for an optical depth of 1 over all of a
// tile. Sums of whole units do not depend on their order.
const float LENGTH_UNITS = 16.0;
const float DEPTH_UNITS = 1024.0;

struct Survey {
    uint cells;          // bit 4 y + x: a caster meets cell (x, y)
    uint edges;          // lengths of edges times the share of light that they take
    uint optical_depth;  // mean over the tile
};
#endif
