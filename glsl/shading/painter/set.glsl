// The set of the passes that paint listed casters. Bound by shading::painter.
// set 0: painter_scene
#ifndef CONSUME_PAINTER_SET_GLSL
#define CONSUME_PAINTER_SET_GLSL
#include "shading/painter/lists.glsl"
#include "world/triangle.glsl"

#define PAINTED_LIGHTS layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
#define PAINTED_CASTERS layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
#define PAINTED_SPLATS layout(set = 0, binding = 2, scalar) readonly buffer Splats { uint splats[]; };
#define PAINTED_ITEMS layout(set = 0, binding = 3, scalar) readonly buffer Items { Item items[]; };
#define PAINTED_RANGES layout(set = 0, binding = 4, scalar) readonly buffer Ranges { uvec2 ranges[]; };
#define PAINTED_PARTS layout(set = 0, binding = 5, scalar) readonly buffer Parts { Part parts[]; };
#define PAINTED_TOTALS layout(set = 0, binding = 6, scalar) readonly buffer Totals { PaintTotals totals; };
// Layers of the parts of tiles' lists. 64 pairs per slot, the pixels of a tile row by row: premultiplied color, and the transmitted light.
#define PAINTED_LAYERS layout(set = 0, binding = 7, scalar) buffer Layers { vec3 layers[]; };

// One box per caster.
#define PAINTED_BOXES layout(set = 0, binding = 8, scalar) readonly buffer Boxes { uvec2 boxes[]; };

#define PAINTED_TRIANGLES layout(set = 0, binding = 9, scalar) readonly buffer Triangles { Triangle triangles[]; };

const uint TILE_PIXELS = PAINT_TILE * PAINT_TILE;
#endif
