// The two passes of glsl/technique/avsm/cells.comp over a tile's casters, for software devices. The lanes of subgroups hold the casters,
// each thread has its own texel, and threads access shared memory one at a time. Needs the declarations of glsl/technique/avsm/cells.comp.
// Twin: reference::twin::avsm::cells.
#ifndef TECHNIQUE_AVSM_CELLS_LANES_GLSL
#define TECHNIQUE_AVSM_CELLS_LANES_GLSL

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
    // Waits until all shared words are initialized.
    barrier();
    share_reach(its, reach);
    WIDE_ATOMIC_ADD(bound[0], bound[1], most);
}

void add_casters(TexelRay its, TilePart part, Range range) {
    for (uint begin = 0u; begin < part.count; begin += batch_size()) {
        uint filled = min(batch_size(), part.count - begin);
        fetch_batch(its.view, part.first + begin, filled);
        for (uint i = 0u; i < filled; ++i) {
            vec2 at;
            float optical_depth;
            if (caster_within(its, batch_caster(i), range, at, optical_depth)) {
                float whole = optical_depth * range.scale;
                add_segment(its.texel, at, whole, whole / max(at.y - at.x, 1e-6));
            }
        }
    }
}
#endif
