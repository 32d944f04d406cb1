// The two passes over a tile's casters, of glsl/avsm/cells.comp, for software devices: lanes hold the casters, each thread has a
// texel for itself, and reaches for shared memory after the one before it.
// Needs, declared before: what glsl/avsm/cells.comp says. Twin: reference::twin::avsm::cells::Cells::new.
#ifndef AVSM_CELLS_LANES_GLSL
#define AVSM_CELLS_LANES_GLSL

// By how much what segments take in every cell changes from a cell on: a segment is at most five numbers however many cells
// it spans.
shared uint slopes[CELLS * TEXELS];

void clear_cells() {
    for (uint i = gl_LocalInvocationIndex; i < uint(CELLS) * TEXELS; i += THREADS) {
        cells[i] = slopes[i] = 0u;
    }
}

void find_range(TexelRay its, TilePart part) {
    uvec2 most = uvec2(0u);
    Reach reach = Reach(FARTHEST, -FARTHEST, FARTHEST);
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(its.view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            reach_caster(its, batch_caster(i), reach);
        }
    }
    for (uint i = gl_LocalInvocationIndex; i < part.count; i += THREADS) {
        wide_add(most, entry_bound(entries[part.first + i], DARK));
    }
    share_reach(its, reach);
    WIDE_ATOMIC_ADD(bound[0], bound[1], most);
}

// Adds a segment; `at` is where it enters and leaves, in cells, `whole` its optical depth in units. Roundings of a segment
// cancel: what it has taken by the end of a cell is rounded, not what it takes in the cell. Sums may wrap around on their way.
void add_segment(uint texel, vec2 at, float whole) {
    uint first = min(uint(at.x), uint(CELLS - 1)), last = min(uint(at.y), uint(CELLS - 1));
    uint units = uint(whole + 0.5);
    if (first == last) {
        cells[first * TEXELS + texel] += units;
        return;
    }
    // What it has taken by the end of its first cell and by the begin of its last.
    float rate = whole / max(at.y - at.x, 1e-6);
    uint early = uint(min((float(first + 1u) - at.x) * rate, whole) + 0.5);
    uint late = uint(min((float(last) - at.x) * rate, whole) + 0.5);
    cells[first * TEXELS + texel] += early;
    if (last > first + 1u) {
        // In even shares, whole numbers: the last `rest` cells in between take one more.
        uint count = last - first - 1u, share = (late - early) / count, rest = (late - early) % count;
        slopes[(first + 1u) * TEXELS + texel] += share;
        slopes[(last - rest) * TEXELS + texel] += 1u;
        slopes[last * TEXELS + texel] -= share + 1u;
    }
    cells[last * TEXELS + texel] += units - late;
}

void add_casters(TexelRay its, TilePart part, Range range) {
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(its.view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 at;
            float optical_depth;
            if (caster_within(its, batch_caster(i), range, at, optical_depth)) {
                add_segment(its.texel, at, optical_depth * range.scale);
            }
        }
    }
}

// Of one texel: from what segments take to the optical depth up to the end of each cell.
void sum_cells(uint texel, float unit) {
    uint sum = 0u, slope = 0u;
    for (uint place = texel; place < uint(CELLS) * TEXELS; place += TEXELS) {
        slope += slopes[place];
        sum += cells[place] + slope;
        cells[place] = floatBitsToUint(float(sum) * unit);
    }
}
#endif
