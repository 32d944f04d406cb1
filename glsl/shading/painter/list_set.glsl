// The set and the push constants of the passes that list a picture's casters by tiles. Bound by shading::painter.
// set 0: painter_lists
#ifndef CONSUME_PAINTER_LIST_SET_GLSL
#define CONSUME_PAINTER_LIST_SET_GLSL
#include "shading/painter/lists.glsl"
#include "world/caster.glsl"

#define LIST_CASTERS layout(set = 0, binding = 0, scalar) readonly buffer Casters { Caster casters[]; };
// Casters, far to near.
#define LIST_ORDER layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
// By caster: see NO_PIXELS.
#define LIST_BOXES layout(set = 0, binding = 2, scalar) buffer Boxes { uvec2 boxes[]; };
// Entries of each workgroup's casters; then of those before.
#define LIST_SUMS layout(set = 0, binding = 3, scalar) buffer Sums { uint sums[]; };
#define LIST_ITEMS layout(set = 0, binding = 4, scalar) buffer Items { Item items[]; };
// Where the entries of each tile begin and end.
#define LIST_RANGES layout(set = 0, binding = 5, scalar) buffer Ranges { uvec2 ranges[]; };
#define LIST_PARTS layout(set = 0, binding = 6, scalar) writeonly buffer Parts { Part parts[]; };
// The first part of each tile of several.
#define LIST_SPLITS layout(set = 0, binding = 7, scalar) writeonly buffer Splits { Part splits[]; };
#define LIST_TOTALS layout(set = 0, binding = 8, scalar) buffer Totals { PaintTotals totals; };
#define LIST_CAMERA layout(set = 0, binding = 9, scalar) readonly buffer Cameras { View camera; };

layout(push_constant, scalar) uniform ListPush {
    uvec2 size;       // of the picture
    uint first;       // place in the order of the first caster that is painted
    uint count;       // casters that are painted
    uint capacity;    // entries
    uint sorted;      // where the sorted entries begin
    uint least_part;  // a part has at least so many entries, but where its tile has fewer
    uint most_parts;  // there are at most so many parts, and at most one more per tile
    uint is_first;    // 1 for the first lists of a frame
};

uint list_group() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uvec2 tile_counts() { return (size + PAINT_TILE - 1u) / PAINT_TILE; }
#endif
