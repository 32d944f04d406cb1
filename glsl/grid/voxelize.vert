#version 460
// Draws each triangle along the axis that it faces most, with one texel per column of voxels. The triangle is enlarged until it covers the
// centre of every column that it overlaps; with CONSERVATIVE, until it touches every such column. Sources: Schwarz and Seidel 2010, section
// 3 (the axis); Hasselgren, Akenine-Möller and Ohlsson 2005 (the enlarged triangle); the box of slivers is ours. Inputs: triangles, grid.
// Outputs: position, the triangle. Invariant: the draw only decides which columns glsl/grid/voxelize.frag tests.
// variants: MASK 0 1
#define GRID_ACCESS readonly
#if MASK == 1
#define FACET_CELLS 4
#endif
#include "grid/facing.glsl"

CONSTANT(bool, CONSERVATIVE, false)

layout(location = 0) flat out uint triangle;

// In texels. HALF_COLUMN: from a column's centre to its border. MOVED: how far rasterizers may move corners: a 16th by snapping, a 16th by
// clipping, and a little by rounding.
const float HALF_COLUMN = 0.5;
const float MOVED = 0.14;

// Smallest `area` of a triangle, as a share of its longest side's square, for which the sides are moved outwards. With a smaller area,
// rounding would rotate the sides and throw the corners far away.
const float SLIVER = 1.0 / 64.0;

float turned(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

void main() {
    triangle = uint(gl_VertexIndex) / 3u;
    Facet facet = facet_at(triangle);
    uint axis = facet_axis(facet), across = (axis + 1u) % 3u, up = (axis + 2u) % 3u;
    vec2 corners[3];
    vec2 sides[3];
    float longest = 0.0;
    uint widest = 0u;
    for (uint i = 0u; i < 3u; ++i) {
        corners[i] = vec2(facet.corners[i][across], facet.corners[i][up]);
        sides[i] = vec2(facet.edges[i][across], facet.edges[i][up]);
        float square = dot(sides[i], sides[i]);
        widest = square > longest ? i : widest;
        longest = max(longest, square);
    }
    float reach = MOVED + (CONSERVATIVE ? 0.0 : HALF_COLUMN), area = turned(sides[0], sides[1]);
    uint corner = uint(gl_VertexIndex) % 3u;
    vec2 at;
    if (abs(area) > SLIVER * longest) {
        // Each side moves outwards, far enough to enclose squares with half-extent `reach` around all points of the triangle. The corners
        // are where the moved sides intersect.
        vec2 one = area < 0.0 ? -sides[(corner + 2u) % 3u] : sides[(corner + 2u) % 3u];
        vec2 other = area < 0.0 ? -sides[corner] : sides[corner];
        float by_one = reach * (abs(one.x) + abs(one.y)), by_other = reach * (abs(other.x) + abs(other.y));
        at = corners[corner] + (by_other * one - by_one * other) / turned(one, other);
    } else {
        // For a sliver: a box along its longest side, enclosed by a triangle twice as wide and twice as high as the box.
        vec2 along = longest > 0.0 ? sides[widest] * inversesqrt(longest) : vec2(1.0, 0.0);
        vec2 over = vec2(-along.y, along.x), low = vec2(0.0), high = vec2(0.0);
        for (uint i = 0u; i < 3u; ++i) {
            vec2 offset = corners[i] - corners[widest], place = vec2(dot(offset, along), dot(offset, over));
            low = min(low, place);
            high = max(high, place);
        }
        // A square's corner is less than 1.415 half-extents away from its centre.
        low -= 1.415 * reach;
        high += 1.415 * reach;
        vec2 place = low + 2.0 * (high - low) * vec2(corner == 1u, corner == 2u);
        at = corners[widest] + place.x * along + place.y * over;
    }
    gl_Position = facet_is_point(facet) ? vec4(2.0, 2.0, 0.5, 1.0) : vec4(2.0 * at / float(FACET_CELLS * grid.size) - 1.0, 0.5, 1.0);
}
