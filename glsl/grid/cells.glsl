// Cells of a grid: 2, 4, 8 … voxels per side, one level per size. For cells of up to 4 voxels per side, the number of occupied voxels
// follows from the grid's bits. For larger ones it is stored, level by level, from 8 voxels per side to the whole grid. Source: after
// Crassin et al. 2011, section 4. Twin: reference::twin::cone::Cells.
#ifndef GRID_CELLS_GLSL
#define GRID_CELLS_GLSL

const uint CELLS_FIRST = 3u;

uint cells_at(uint size, uint level) {
    uint at = 0u;
    for (uint l = CELLS_FIRST; l < level; ++l) {
        uint side = size >> l;
        at += side * side * side;
    }
    return at;
}

uint cell_at(uint size, uint level, uvec3 cell) {
    uint side = size >> level;
    return cells_at(size, level) + (cell.z * side + cell.y) * side + cell.x;
}
#endif
