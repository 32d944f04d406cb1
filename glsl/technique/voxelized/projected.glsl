// A triangle projected into columns. Twin: reference::twin::voxelized::Projected.
#ifndef TECHNIQUE_VOXELIZED_PROJECTED_GLSL
#define TECHNIQUE_VOXELIZED_PROJECTED_GLSL

// Number of words per triangle: two for each corner, three for depths, one for the triangle it is a piece of (times 4) and its
// side plus 1, two for its least and greatest depth. The depths
// are the corners' depths, in voxels. If the light has a position, they are instead 1 over the depth at the centre of all columns, and its
// change per column to the right and per column up.
const uint PROJECTED_WORDS = 12u;
const uint PROJECTED_DEPTHS = 6u;
const uint PROJECTED_SIDE = 9u;
const uint PROJECTED_RANGE = 10u;
const float SUB_VOXELS = 256.0;

// Whether the light has a position.
CONSTANT(bool, PERSPECTIVE, false)

// Columns per side of a bin of triangles.
const uint BIN_COLUMNS = 8u;
// Maximum number of bins of a triangle that a single thread processes.
const uint MANY_BINS = 16u;

// The world's triangle that this is a piece of.
uint projected_owner(uint i) { return uint(projected[PROJECTED_WORDS * i + PROJECTED_SIDE]) >> 2; }

int projected_side(uint i) { return (projected[PROJECTED_WORDS * i + PROJECTED_SIDE] & 3) - 1; }

ivec2 projected_corner(uint i, uint c) {
    return ivec2(projected[PROJECTED_WORDS * i + 2u * c], projected[PROJECTED_WORDS * i + 2u * c + 1u]);
}

// Finds the bins of the tile that the triangle may overlap: the first, and one past the last.
void projected_bins(uint i, out ivec2 first, out ivec2 end) {
    ivec2 a = projected_corner(i, 0u), b = projected_corner(i, 1u), c = projected_corner(i, 2u);
    ivec2 low = min(a, min(b, c)), high = max(a, max(b, c));
    // Columns whose centre is inside the triangle's bounding box; with CONSERVATIVE, columns whose square overlaps or touches the box.
    ivec2 corner = ivec2(tile_x, tile_y);
    first = max(((low + (CONSERVATIVE ? -1 : 127)) >> 8) - corner, ivec2(0));
    end = min(((high + (CONSERVATIVE ? 256 : 128)) >> 8) - corner, ivec2(8u * width));
    bool none = any(lessThanEqual(end, first));
    first = none ? ivec2(0) : first / int(BIN_COLUMNS);
    end = none ? ivec2(0) : (end + int(BIN_COLUMNS) - 1) / int(BIN_COLUMNS);
}

uint bins_across() { return (8u * width + BIN_COLUMNS - 1u) / BIN_COLUMNS; }
#endif
