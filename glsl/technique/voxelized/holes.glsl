// Whether a triangle with alpha blocks light in a column: at the column's centre, or with `squares` anywhere in the column's square. Source:
// ours. No twin: the truth in tests/light_space/holes.rs.
#ifndef TECHNIQUE_VOXELIZED_HOLES_GLSL
#define TECHNIQUE_VOXELIZED_HOLES_GLSL
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/projected.glsl"
#include "technique/voxelized/facet.glsl"
#include "world/alpha_cover.glsl"

// The depth of a triangle's plane; `column` is relative to the block's first column, and need not be whole.
float hole_depth(Plane plane, vec2 column) {
    float z = plane.z + plane.slope.x * column.x + plane.slope.y * column.y;
    if (PERSPECTIVE) {
        z = z > 0.0 ? 1.0 / z : plane.range.y;
    }
    return z;
}

// The point of the world at a depth of a column, which need not be whole.
vec3 hole_point(Tree tree, vec2 column, float z) {
    vec2 across = PERSPECTIVE ? (column - 0.5 * float(tree.size)) * z : column;
    return tree.origin + tree.right * (across.x / dot(tree.right, tree.right)) + tree.up * (across.y / dot(tree.up, tree.up)) +
           tree.forward * (z / dot(tree.forward, tree.forward));
}

// The weights of the triangle's second and third corners where a column, relative to `corner`, meets its plane.
vec2 hole_weights(Tree tree, uint triangle, Plane plane, uvec2 corner, vec2 column) {
    vec3 point = hole_point(tree, vec2(corner) + column + 0.5, hole_depth(plane, column));
    return alpha_weights(triangles[triangle].corners, point);
}

bool column_blocked(uint triangle, Plane plane, uvec2 corner, ivec2 column, bool squares) {
    Tree tree = trees[light];
    Alpha alpha = alpha_record(alpha_number(triangle));
    if (!squares) {
        return alpha_value(alpha, hole_weights(tree, triangle, plane, corner, vec2(column))) >= alpha.cutoff;
    }
    // With squares the plane is moved to their farthest corners (facet_at).
    float farther = 0.5 * (abs(plane.slope.x) + abs(plane.slope.y));
    plane.z += PERSPECTIVE ? farther : -farther;
    vec2 low = vec2(FARTHEST), high = vec2(-FARTHEST);
    for (uint c = 0u; c < 4u; ++c) {
        vec2 at = hole_weights(tree, triangle, plane, corner, vec2(column) + vec2(c & 1u, c >> 1) - 0.5);
        vec2 uv = alpha.uvs[0] + at.x * (alpha.uvs[1] - alpha.uvs[0]) + at.y * (alpha.uvs[2] - alpha.uvs[0]);
        low = min(low, uv);
        high = max(high, uv);
    }
    float factor = max(alpha.factors[0], max(alpha.factors[1], alpha.factors[2]));
    if (alpha.texels == 0u) {
        return factor >= alpha.cutoff;
    }
    vec2 least = min(alpha.uvs[0], min(alpha.uvs[1], alpha.uvs[2])), most = max(alpha.uvs[0], max(alpha.uvs[1], alpha.uvs[2]));
    return factor * most_texel(alpha, clamp(low, least, most), clamp(high, least, most)) >= alpha.cutoff;
}
#endif
