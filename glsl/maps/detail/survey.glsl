// Survey of a tile, from which its resolution is chosen. Twin: maps::Survey.
#ifndef MAPS_DETAIL_SURVEY_GLSL
#define MAPS_DETAIL_SURVEY_GLSL
#extension GL_EXT_scalar_block_layout : require

// Number of cells per side of a tile; each cell is tested for casters.
const uint SURVEY_CELLS = 4u;
// LENGTH_UNITS: units per texel of length. DEPTH_UNITS: units per optical depth of 1 over a whole tile. Integer sums do not depend on the
// order of their terms.
const float LENGTH_UNITS = 16.0;
const float DEPTH_UNITS = 1024.0;

struct Survey {
    uint cells;          // bit 4 y + x: a caster touches cell (x, y)
    uint edges;          // sum of the lengths of edges, each times the fraction of light that its caster absorbs
    uint optical_depth;  // mean over the tile
};
#endif
