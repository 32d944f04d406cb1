// Sums the optical depths of a texel's segments in equal cells, stored as changes: a change is a cell's optical depth minus the optical
// depth of the previous cell. Must be declared before inclusion: LANES, CELLS, TEXELS, and cells[] with CELLS + 1 elements per texel. Twin:
// reference::twin::avsm::cells.
#ifndef TECHNIQUE_AVSM_CHANGES_GLSL
#define TECHNIQUE_AVSM_CHANGES_GLSL

void change_cell(uint cell, uint texel, uint units) {
#if LANES == 1
    // Each thread owns its texel.
    cells[cell * TEXELS + texel] += units;
#else
    atomicAdd(cells[cell * TEXELS + texel], units);
#endif
}

// Adds a segment. `at`: its entry and exit, in cells; `whole`: its optical depth in units; `rate`: units per cell. However many cells the
// segment spans, it changes the optical depth from cell to cell in only four places. Its total optical depth is rounded once. Intermediate
// sums may wrap around.
void add_segment(uint texel, vec2 at, float whole, float rate) {
    uint first = min(uint(at.x), uint(CELLS - 1)), last = min(uint(at.y), uint(CELLS - 1));
    float begin = at.x - float(first);
    uint units = uint(whole + 0.5), early = uint(min((1.0 - begin) * rate, whole) + 0.5);
    // Rounded up or down at random, since segments begin anywhere in a cell: many segments of the same rate are not all rounded the same
    // way.
    uint even = uint(min(rate, whole) + begin);
    uint late = early + even * (last - first) - units;
    change_cell(first, texel, early);
    change_cell(first + 1u, texel, even - early);
    change_cell(last, texel, -late);
    change_cell(last + 1u, texel, late - even);
}

// Turns one texel's changes into the optical depth from the first cell to the end of each cell. It never decreases from cell to cell, and
// at the last cell it is the optical depth of all segments.
void sum_cells(uint texel, float unit) {
    uint sum = 0u, change = 0u;
    for (uint place = texel; place < uint(CELLS) * TEXELS; place += TEXELS) {
        change += cells[place];
        sum += change;
        cells[place] = sum;
    }
    for (uint cell = uint(CELLS); cell > 0u; --cell) {
        uint place = (cell - 1u) * TEXELS + texel;
        sum = min(sum, cells[place]);
        cells[place] = floatBitsToUint(float(sum) * unit);
    }
}
#endif
