#version 460
// Finds where each column of voxels enters and leaves the first mesh, the least exit and the greatest entry of each block of 8 × 8 columns,
// and where each column's shadow begins. A column enters at its nearest surface. If that surface is the outside of a closed mesh, the
// column exits where it has left as many faces as it has entered, so that overlapping closed meshes count as one. Voxels between entry and
// exit may count as lit or as shadowed. With CONSERVATIVE, triangles in front of that entry that touch a column's square but miss its
// centre shadow the column like an open surface. One workgroup per block, one thread per column. Source: Sintorn et al. 2014 (closed
// objects), Scandolo et al. 2016 (counting faces), after Akenine-Möller and Aila 2005 (squares). Inputs: projected, entries. Outputs:
// boundaries, ranges, values (nodes of each block), columns. Twin: reference::twin::voxelized::columns. Invariant: entry <= boundary <=
// exit.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/projected.glsl"
#include "technique/voxelized/facet.glsl"
#include "technique/voxelized/moves.glsl"
#include "world/view.glsl"
#include "technique/voxelized/holes.glsl"

// Where the shadow begins between entry and exit: at the exit (0), at the entry (1), or where columns can share a
// boundary (2).
CONSTANT(uint, FREE, 2u)
const uint FREE_EXIT = 0u;
const uint FREE_SHARED = 2u;

// Whether closed meshes have an inside.
CONSTANT(bool, CLOSED, true)

// Whether entries and exits are written as well.
CONSTANT(bool, KEEP_COLUMNS, false)

// Number of a block's triangles in shared memory; if it has more, they are processed in batches of this size.
const uint FACETS = 128u;
shared Plane planes[FACETS];
// Which of these triangles each column hits, one bit each.
shared uint met[64][FACETS / 32u];
shared uint busy[2];
// Two of each: while one is read, the other is prepared for the next turn.
const uint NONE = 0xffffffffu;
shared uint first_exit[2];
shared uint last_entry[2];
shared uint least;
shared uint most;

// Stores triangle `i` at `place`, and marks which of `count` columns from `first` on hit it.
void take(uint place, uint i, uvec2 corner, bool squares, uint first, uint count) {
    Facet facet;
    if (!facet_at(i, corner, squares, facet)) {
        return;
    }
    uint owner = projected_owner(i);
    bool has_alpha = alpha_number(owner) != 0u;
    planes[place] = facet.plane;
    for (uint from = first; from < first + count; from += 32u) {
        for (uint bits = facet_columns(facet, from, min(count, 32u)); bits != 0u; bits &= bits - 1u) {
            uint c = from + uint(findLSB(bits));
            ivec2 column = ivec2(c & 7u, c >> 3);
            if (squares && (any(lessThan(column, facet.first)) || any(greaterThanEqual(column, facet.end)))) {
                continue;
            }
            if (has_alpha && !column_blocked(owner, facet.plane, corner, column, squares)) {
                continue;
            }
            atomicOr(met[c][place / 32u], 1u << (place & 31u));
        }
    }
}

// Loads the bin's triangles from `batch` on, at most FACETS of them.
void take_batch(uint batch, uint end, uvec2 corner, bool squares) {
    uint thread = gl_LocalInvocationIndex;
    barrier();
    met[thread] = uint[FACETS / 32u](0u, 0u, 0u, 0u);
    barrier();
    // If there are few triangles, several threads share one, each with `share` columns.
    uint here = min(FACETS, end - batch), share = 1u << min(findMSB(max(2u * here - 1u, 1u)), 6);
    for (uint i = thread % share; i < here; i += share) {
        take(i, bin_entries[large_capacity + batch + i], corner, squares, thread / share * share, share);
    }
    barrier();
}

// Returns the number in [low, high] with the most trailing zeros.
uint roundest(uint low, uint high) {
    if (low == 0u) {
        return 0u;
    }
    // Keeps the leading bits that low − 1 and high have in common, and the first bit of high that low − 1 lacks.
    uint differ = (low - 1u) ^ high;
    return high & ~((1u << findMSB(differ)) - 1u);
}

void put_block(uint block, uvec2 range) {
    ranges[bricks_at + block] = range;
    values[leaves_at + block] = range.y > range.x ? range.y - range.x : 0u;
    values[bricks_at + block] = node_range(range, 8u).y;
}

void main() {
    uint block = build_group(), thread = gl_LocalInvocationIndex;
    // If not all triangles fit, the columns would be wrong.
    if (block >= width * width || failed != 0u) {
        return;
    }
    if (!block_moves(block)) {
        if (thread == 0u) {
            put_block(block, uvec2(boundaries[range_at(block)], boundaries[range_at(block) + 1u]));
        }
        return;
    }
    uvec2 block_at = uvec2(block % width, block / width);
    uvec2 corner = uvec2(tile_x, tile_y) + 8u * block_at;
    ivec2 column = ivec2(thread & 7u, thread >> 3);
    uint bin = (8u * block_at.y / BIN_COLUMNS) * bins_across() + 8u * block_at.x / BIN_COLUMNS;
    uint first = min(before(bins_at + bin), entry_capacity), end = min(before(bins_at + bin + 1u), entry_capacity);

    if (thread == 0u) {
        busy = uint[2](0u, 0u);
        first_exit[0] = least = NONE;
        last_entry[0] = most = 0u;
    }
    barrier();
    float nearest = FARTHEST, leaves = FARTHEST;
    int enters = 0, inside = 0;
    bool open = true, searching = true;
    for (uint round = 0u;; ++round) {
        // The first round finds the nearest surface, and the nearest back face of any mesh. Each further round tests whether the column has
        // left as many faces as it has entered at the back face that the previous round found. It also finds the next back face behind it.
        float next = FARTHEST;
        inside = 0;
        for (uint batch = first; batch < end; batch += FACETS) {
            // If all triangles fit into one batch, they stay in shared memory.
            if (round == 0u || end - first > FACETS) {
                take_batch(batch, end, corner, false);
            }
            for (uint w = 0u; 32u * w < min(FACETS, end - batch) && searching; ++w) {
                for (uint bits = met[thread][w]; bits != 0u; bits &= bits - 1u) {
                    Plane plane = planes[32u * w + uint(findLSB(bits))];
                    float z = plane_depth(plane, column);
                    int faces = CLOSED ? plane.faces : 0;
                    if (round == 0u) {
                        enters = z < nearest ? faces : z == nearest ? max(enters, faces) : enters;
                        nearest = min(nearest, z);
                        next = faces < 0 ? min(next, z) : next;
                    } else {
                        inside += z <= leaves ? faces : 0;
                        next = faces < 0 && z > leaves ? min(next, z) : next;
                    }
                }
            }
        }
        // Round 0 guesses that the column exits at the nearest back face. If the column is still inside a mesh there, later rounds try the
        // next back face. A ground plane has no back face.
        open = round == 0u ? enters <= 0 : open;
        if (searching) {
            bool left = round == 0u ? open : inside <= 0;
            leaves = left ? leaves : next;
            searching = !left && leaves < FARTHEST;
        }
        if (searching) {
            busy[round & 1u] = 1u;
        }
        barrier();
        if (busy[round & 1u] == 0u) {
            break;
        }
        if (thread == 0u) {
            busy[1u - (round & 1u)] = 0u;
        }
        barrier();
    }
    if (CONSERVATIVE) {
        // A triangle whose corners all lie more than a voxel in front of the nearest surface is not part of that surface: it touches the
        // column's square and misses the column's centre. Only such triangles count here, so that a smooth surface, whose triangles touch
        // each other's columns, keeps its depth.
        float touched = FARTHEST;
        for (uint batch = first; batch < end; batch += FACETS) {
            take_batch(batch, end, corner, true);
            for (uint w = 0u; 32u * w < min(FACETS, end - batch); ++w) {
                for (uint bits = met[thread][w]; bits != 0u; bits &= bits - 1u) {
                    Plane plane = planes[32u * w + uint(findLSB(bits))];
                    touched = plane.range.y + 1.0 < nearest ? min(touched, plane_depth(plane, column)) : touched;
                }
            }
        }
        open = open || touched < FARTHEST;
        nearest = min(nearest, touched);
    }
    // An entry's voxel counts as lit, and an exit's voxel as inside. If the mesh is open or too thin for both, entry and exit are both the
    // nearest surface, rounded to the nearest voxel.
    float size = float(trees[light].size);
    float middle = clamp(floor(nearest + 0.5), 0.0, size);
    float entry = clamp(ceil(nearest), 0.0, size), exit = clamp(floor(leaves), 0.0, size);
    bool thin = open || exit < entry;
    uvec2 range = nearest == FARTHEST ? uvec2(size) : thin ? uvec2(middle) : uvec2(entry, exit);

    atomicMin(least, range.y);
    atomicMax(most, range.x);
    barrier();
    if (thread == 0u) {
        uvec2 of_block = uvec2(least, most);
        put_block(block, of_block);
        boundaries[range_at(block)] = least;
        boundaries[range_at(block) + 1u] = most;
        boundaries[mark_at(block)] = 0u;
        atomicAdd(found, 1u);
    }
    uint boundary = FREE == FREE_EXIT ? range.y : range.x;
    if (FREE == FREE_SHARED) {
        // Chooses as few distinct boundaries as the block's columns allow. The first boundary lies at or before the least exit of all
        // columns, and serves all columns that have entered by that exit. The next one serves the remaining columns in the same way, and so
        // on. Each boundary is the possible z with the most trailing zero bits, so that different blocks tend to share boundaries.
        bool placed = false;
        for (uint turn = 0u; turn < 64u; ++turn) {
            // The values of the previous turn are no longer read.
            uint now = turn & 1u;
            if (!placed) {
                atomicMin(first_exit[now], range.y);
            }
            barrier();
            uint stop = first_exit[now];
            if (stop == NONE) {
                break;
            }
            bool here = !placed && range.x <= stop;
            if (here) {
                atomicMax(last_entry[now], range.x);
            }
            if (thread == 0u) {
                first_exit[1u - now] = NONE;
                last_entry[1u - now] = 0u;
            }
            barrier();
            boundary = here ? roundest(last_entry[now], stop) : boundary;
            placed = placed || here;
        }
    }
    uint row = 8u * width;
    uint place = (8u * block_at.y + uint(column.y)) * row + 8u * block_at.x + uint(column.x);
    boundaries[columns_at + place] = boundary;
    if (KEEP_COLUMNS) {
        columns[place] = range;
    }
}
