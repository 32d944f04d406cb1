// What a workgroup builds, for passes with one workgroup a listed part: the bins as such a pass reads them.
#ifndef BINS_PART_GLSL
#define BINS_PART_GLSL
#include "bins/totals.glsl"
#include "bins/view_caster.glsl"
#include "maps/rounds.glsl"
#include "maps/scene.glsl"

layout(set = 1, binding = 1, scalar) readonly buffer Parts { TilePart parts[]; };
layout(set = 1, binding = 3, scalar) buffer Totals { BinTotals totals[]; };
#ifndef BINS_ENTRIES_WRITTEN
layout(set = 1, binding = 4, scalar) readonly buffer Entries { uvec2 entries[]; };
#else
layout(set = 1, binding = 4, scalar) coherent buffer Entries { uvec2 entries[]; };
#endif

// False where the list has ended; there is room behind it, so that both reads can be under way at once.
bool listed_part(out TilePart part) {
    uint place = gl_WorkGroupID.y * BIN_GROUPS_X + gl_WorkGroupID.x;
    part = parts[place];
    return place < totals[0].parts;
}

// After all loops over the part's casters: says if the driver cut them short.
void end_part(TilePart part) {
    if (rounds_ran_out(part.count)) {
        totals[0].cut_short = 1u;
    }
}

// The first texel of the part's tile.
uvec2 part_corner(View view, TilePart part) {
    uint across = (view.width + 7u) / 8u;
    return uvec2(part.tile % across, part.tile / across) * 8u;
}

// The caster of an entry, in the view's axes.
Caster tile_caster(View view, uint entry) { return view_caster(view, casters[entries[entry].y]); }
#endif
