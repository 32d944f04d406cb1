// The set and the push constants of the passes that list a picture's casters by tile. Bound by shading::painter.
// set 0: painter_lists
#ifndef CONSUME_PAINTER_LIST_SET_GLSL
#define CONSUME_PAINTER_LIST_SET_GLSL
#include "shading/painter/lists.glsl"
#include "world/caster.glsl"

#define LIST_CASTERS layout(set = 0, binding = 0, scalar) readonly buffer Casters { Caster casters[]; };
// Casters, far to near.
#define LIST_ORDER layout(set = 0, binding = 1, scalar) readonly buffer Order { uint order[]; };
// Indexed by caster: see NO_PIXELS.
#define LIST_BOXES layout(set = 0, binding = 2, scalar) buffer Boxes { uvec2 boxes[]; };
// Number of entries of each workgroup's casters; later, number of entries before them.
#define LIST_SUMS layout(set = 0, binding = 3, scalar) buffer Sums { uint sums[]; };
#define LIST_ITEMS layout(set = 0, binding = 4, scalar) buffer Items { Item items[]; };
// Where the entries of each tile begin and end.
#define LIST_RANGES layout(set = 0, binding = 5, scalar) buffer Ranges { uvec2 ranges[]; };
#define LIST_PARTS layout(set = 0, binding = 6, scalar) writeonly buffer Parts { Part parts[]; };
// The first part of each tile with several parts.
#define LIST_SPLITS layout(set = 0, binding = 7, scalar) writeonly buffer Splits { Part splits[]; };
#define LIST_TOTALS layout(set = 0, binding = 8, scalar) buffer Totals { PaintTotals totals; };
#define LIST_CAMERA layout(set = 0, binding = 9, scalar) readonly buffer Cameras { View camera; };

layout(push_constant, scalar) uniform ListPush {
    uvec2 size;       // of the picture
    uint first;       // the first caster's place in the order
    uint count;       // number of casters to paint
    uint capacity;    // capacity of the lists, in entries
    uint sorted;      // index of the first sorted entry
    uint least_part;  // a part has at least this many entries, unless its tile has fewer
    uint most_parts;  // there are at most this many parts, plus at most one per tile
    uint is_first;    // 1 for the first lists of a frame
};

uint list_group() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uvec2 tile_counts() { return (size + PAINT_TILE - 1u) / PAINT_TILE; }
#endif
