#version 460
// Projects each triangle's corners into the columns of a light: across in integer 256ths of a voxel, so that every device agrees whether a
// column hits a triangle. For a light with a position, triangles are first clipped to its pyramid; a polygon with more than three corners
// is split into triangles. Source: ours; clipping after Sutherland and Hodgman 1974. Inputs: triangles, sides, trees. Outputs: projected,
// the number of pieces, marks of the blocks that contain or contained triangles that have moved since the last bake. Twin:
// reference::twin::voxelized::project. Triangles that share an edge are clipped at the same points: an edge is always clipped from its
// inner end.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/projected.glsl"
#include "technique/voxelized/moves.glsl"
#include "world/view.glsl"

// Where a pyramid begins, as a share of its depth: there are no columns at its very tip.
const float NEAREST = 1e-6;
const uint PLANES = 5u;

// Maximum number of blocks that one moved triangle marks.
const uint MOST_MARKS = 4096u;

// After the triangles and pieces, `projected` holds SEEN_WORDS words per triangle: its corners and its side when a bake last saw it. Then
// follow BOX_WORDS words per tree and triangle: the box of the triangle's columns, in 256ths of a voxel.
const uint SEEN_WORDS = 10u;
const uint BOX_WORDS = 4u;

// Bounding box of all corners that `put` has written.
ivec2 box_low = ivec2(0x7fffffff), box_high = ivec2(-0x7fffffff);

// `owner`: the world's triangle.
void put(uint at, vec2 columns[3], vec3 depths, vec2 range, uint owner) {
    for (uint c = 0u; c < 3u; ++c) {
        ivec2 whole = ivec2(floor(columns[c] * SUB_VOXELS + 0.5));
        box_low = min(box_low, whole);
        box_high = max(box_high, whole);
        projected[PROJECTED_WORDS * at + 2u * c] = whole.x;
        projected[PROJECTED_WORDS * at + 2u * c + 1u] = whole.y;
        projected[PROJECTED_WORDS * at + PROJECTED_DEPTHS + c] = floatBitsToInt(depths[c]);
    }
    projected[PROJECTED_WORDS * at + PROJECTED_SIDE] = int(owner << 2 | (sides[owner] + 1u));
    projected[PROJECTED_WORDS * at + PROJECTED_RANGE] = floatBitsToInt(range.x);
    projected[PROJECTED_WORDS * at + PROJECTED_RANGE + 1u] = floatBitsToInt(range.y);
}

// Returns how far a point is inside a plane of the pyramid, which is twice as wide on each side as its columns.
float inside(uint plane, vec3 at, float size) {
    if (plane == 0u) {
        return at.z - NEAREST * size;
    }
    precise float wide = size * at.z;
    float across = plane < 3u ? at.x : at.y;
    precise float left = (plane & 1u) == 1u ? wide - across : wide + across;
    return left;
}

void put_pieces(uint i, vec3 corners[3], float size) {
    vec3 polygon[3 + PLANES] = vec3[](corners[0], corners[1], corners[2], vec3(0), vec3(0), vec3(0), vec3(0), vec3(0));
    uint count = 3u;
    for (uint plane = 0u; plane < PLANES; ++plane) {
        vec3 whole[3 + PLANES] = polygon;
        uint of_whole = count;
        count = 0u;
        for (uint c = 0u; c < of_whole; ++c) {
            vec3 here = whole[c], next = whole[c + 1u < of_whole ? c + 1u : 0u];
            float at_here = inside(plane, here, size), at_next = inside(plane, next, size);
            bool here_in = at_here >= 0.0, next_in = at_next >= 0.0;
            if (here_in && count < 3u + PLANES) {
                polygon[count++] = here;
            }
            if (here_in != next_in && count < 3u + PLANES) {
                vec3 from = here_in ? here : next, to = here_in ? next : here;
                float from_in = here_in ? at_here : at_next, to_in = here_in ? at_next : at_here;
                precise float share = from_in / (from_in - to_in);
                precise vec3 cut = from + (to - from) * share;
                polygon[count++] = cut;
            }
        }
    }
    vec2 columns[3] = vec2[](vec2(-1e4), vec2(-1e4), vec2(-1e4));
    if (count < 3u) {
        put(i, columns, vec3(0.0), vec2(0.0), i);
        return;
    }
    vec2 range = vec2(polygon[0].z);
    for (uint c = 1u; c < count; ++c) {
        range = vec2(min(range.x, polygon[c].z), max(range.y, polygon[c].z));
    }
    // Slopes of the triangle's plane: 1 over its depth is linear in the columns.
    precise vec3 b = corners[1] - corners[0], c = corners[2] - corners[0];
    precise float x = b.y * c.z - b.z * c.y, y = b.z * c.x - b.x * c.z, z = b.x * c.y - b.y * c.x;
    precise float away = x * corners[0].x + y * corners[0].y + z * corners[0].z;
    // A plane through the light is seen edge-on: all of its columns get the depth of the nearest corner.
    vec3 depths = abs(away) > 0.0 && abs(away) < FARTHEST ? vec3(z, x, y) / away : vec3(1.0 / range.x, 0.0, 0.0);
    uint first_piece = count > 3u ? atomicAdd(pieces, count - 3u) : 0u;
    for (uint p = 0u; p + 2u < count; ++p) {
        uint at = p == 0u ? i : triangle_count + first_piece + p - 1u;
        vec3 of_piece[3] = vec3[](polygon[0], polygon[p + 1u], polygon[p + 2u]);
        for (uint k = 0u; k < 3u; ++k) {
            precise vec2 column = of_piece[k].xy / of_piece[k].z + 0.5 * size;
            columns[k] = column;
        }
        if (at < triangle_count + piece_capacity) {
            put(at, columns, depths, range, i);
        }
    }
}

// Marks the blocks of a box, and the neighbouring blocks that it touches.
void mark(ivec2 low, ivec2 high) {
    int across = int(trees[light].size / 8u), tiles = across / int(width);
    ivec2 first = clamp((low - 1) >> 11, ivec2(0), ivec2(across)), end = clamp((high + 2304) >> 11, ivec2(0), ivec2(across));
    if (any(lessThanEqual(end, first))) {
        return;
    }
    if (uint((end.x - first.x) * (end.y - first.y)) > MOST_MARKS) {
        moves_wide = 1u;
        return;
    }
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            ivec2 tile_at = ivec2(x, y) / int(width), in_tile = ivec2(x, y) % int(width);
            uint before = uint(tile_at.y * tiles + tile_at.x) * TILE_WORDS * width * width;
            boundaries[before + mark_at(uint(in_tile.y) * width + uint(in_tile.x))] = 1u;
        }
    }
}

// Marks where triangle `i` was and is, if it moved, and records where it is.
void remember(uint i) {
    uint seen = PROJECTED_WORDS * (triangle_count + piece_capacity), boxes = seen + SEEN_WORDS * triangle_count;
    uint at = seen + SEEN_WORDS * i, box = boxes + BOX_WORDS * (light * triangle_count + i);
    bool moved = projected[at + 9u] != int(sides[i]);
    for (uint c = 0u; c < 9u; ++c) {
        moved = moved || projected[at + c] != floatBitsToInt(triangles[i].corners[c / 3u][c % 3u]);
    }
    if (moved && (mode & WHOLE) == 0u) {
        mark(ivec2(projected[box], projected[box + 1u]), ivec2(projected[box + 2u], projected[box + 3u]));
        mark(box_low, box_high);
    }
    projected[box] = box_low.x;
    projected[box + 1u] = box_low.y;
    projected[box + 2u] = box_high.x;
    projected[box + 3u] = box_high.y;
    for (uint c = 0u; c < 9u && (mode & LAST) != 0u; ++c) {
        projected[at + c] = floatBitsToInt(triangles[i].corners[c / 3u][c % 3u]);
    }
    if ((mode & LAST) != 0u) {
        projected[at + 9u] = int(sides[i]);
    }
}

void main() {
    uint i = 64u * build_group() + gl_LocalInvocationIndex;
    if (i >= triangle_count) {
        return;
    }
    Tree tree = trees[light];
    vec3 at[3];
    for (uint c = 0u; c < 3u; ++c) {
        vec3 offset = triangles[i].corners[c] - tree.origin;
        // `precise`: no product may be fused with a sum, since the twin does not fuse them either.
        precise float x = offset.x * tree.right.x + offset.y * tree.right.y + offset.z * tree.right.z;
        precise float y = offset.x * tree.up.x + offset.y * tree.up.y + offset.z * tree.up.z;
        precise float z = offset.x * tree.forward.x + offset.y * tree.forward.y + offset.z * tree.forward.z;
        at[c] = vec3(x, y, z);
    }
    if (PERSPECTIVE) {
        put_pieces(i, at, float(tree.size));
    } else {
        put(i, vec2[](at[0].xy, at[1].xy, at[2].xy), vec3(at[0].z, at[1].z, at[2].z), vec2(0.0), i);
    }
    if ((mode & SEEN) != 0u) {
        remember(i);
    }
}
