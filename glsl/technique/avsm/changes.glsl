// Optical depths of a texel's segments, added up in even cells as changes: a change is a cell's optical depth minus the optical depth of
// the cell before. Needs, declared before: LANES, CELLS and TEXELS, and cells[], one more than CELLS per texel. Twin:
// reference::twin::avsm::cells.
#ifndef TECHNIQUE_AVSM_CHANGES_GLSL
#define TECHNIQUE_AVSM_CHANGES_GLSL

void change_cell(uint cell, uint texel, uint units) {
#if LANES == 1
    // A thread has its texel for itself.
    cells[cell * TEXELS + texel] += units;
#else
    atomicAdd(cells[cell * TEXELS + texel], units);
#endif
}

// Adds a segment. `at`: where it enters and leaves, in cells; `whole`: its optical depth in units; `rate`: units per cell. However
// many cells the segment spans, it changes the optical depth from cell to cell in four places. Its whole optical depth is rounded
// once. Sums may wrap around on their way.
void add_segment(uint texel, vec2 at, float whole, float rate) {
    uint first = min(uint(at.x), uint(CELLS - 1)), last = min(uint(at.y), uint(CELLS - 1));
    float begin = at.x - float(first);
    uint units = uint(whole + 0.5), early = uint(min((1.0 - begin) * rate, whole) + 0.5);
    // Rounded up or down by chance, as segments begin anywhere in a cell: many of the same rate are not all rounded alike.
    uint even = uint(min(rate, whole) + begin);
    uint late = early + even * (last - first) - units;
    change_cell(first, texel, early);
    change_cell(first + 1u, texel, even - early);
    change_cell(last, texel, -late);
    change_cell(last + 1u, texel, late - even);
}

// Turns the changes of one texel into the optical depth from the first cell up to the end of each cell. It never falls from cell to cell,
// and at the last cell it is the optical depth of all segments.
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
