// Cells of equal length over a range, for levels of detail (maps/sums/levels.glsl).
#ifndef MAPS_SUMS_EVEN_CELLS_GLSL
#define MAPS_SUMS_EVEN_CELLS_GLSL

// Twins: texel_sums::EVEN_CELLS and maps::EVEN_CELLS.
#define LEVEL_CELLS 32u

float cell_end(uint k) { return float(k) / float(LEVEL_CELLS); }

uint cell_at(float place) { return min(uint(place * float(LEVEL_CELLS)), LEVEL_CELLS - 1u); }
#endif
