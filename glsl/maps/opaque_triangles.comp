#version 460
// Draws the small triangles of all maps and lists the large ones. One thread per triangle; the workgroup's z is the map. All threads of the
// workgroup together list the tiles of a large triangle. Tiles that do not fit into the list are drawn immediately: that is slower, but
// nothing is lost. Inputs: maps, triangles. Outputs: depths, items. Twin: reference::twin::opaque::draw.
// What is stored: see maps/opaque_store.glsl.
// variants: SEEN 0 1 2 3
layout(local_size_x = 64) in;
#include "maps/opaque_draw.glsl"

// Largest number of texels in a triangle's bounds for which one thread draws the triangle alone.
CONSTANT(uint, OPAQUE_SMALL, 64u)

// A triangle of the workgroup that is not small.
struct Large {
    uint triangle;
    uint shares;
    uint first;  // index of its first item; items from `capacity` on are not listed
};

shared uint large_count;
shared Large large[64];

// Reserves `shares` items of the list, and returns the index of the first; `capacity` if the list is full.
uint reserve(uint shares) {
    if (totals.items >= OPAQUE_MOST_ITEMS) {
        return capacity;
    }
    uint first = atomicAdd(totals.items, shares);
    uint end = min(first + shares, capacity);
    if (first < capacity) {
        atomicMax(totals.groups_y, (end + OPAQUE_ITEMS_X - 1u) / OPAQUE_ITEMS_X);
    }
    return min(first, capacity);
}

void main() {
    uint map = first_map + gl_WorkGroupID.z, thread = gl_LocalInvocationIndex;
    uint triangle = 64u * (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) + thread;
    View view = maps[map].opaque;
    ivec2 map_corner = opaque_map_corner(view, map);
    if (thread == 0u) {
        large_count = 0u;
    }
    barrier();
    if (triangle < triangle_count) {
        Seen seen = see(view, triangle);
        if (seen.count > 0u) {
            if (uint(seen.size.x) * uint(seen.size.y) <= OPAQUE_SMALL && max(seen.size.x, seen.size.y) <= OPAQUE_TILE) {
                draw_part(view, map_corner, seen, seen.first, ivec2(0), 1);
            } else {
                uint shares = shares_of(tiles_of(seen));
                large[atomicAdd(large_count, 1u)] = Large(triangle, shares, reserve(shares));
            }
        }
    }
    barrier();
    for (uint i = 0u; i < large_count; ++i) {
        Large one = large[i];
        uint listed = min(one.shares, capacity - one.first);
        for (uint share = thread; share < listed; share += 64u) {
            items[one.first + share] = OpaqueItem(one.triangle, map * OPAQUE_MOST_SHARES + share);
        }
        if (listed < one.shares) {
            Seen seen = see(view, one.triangle);
            for (uint share = listed; share < one.shares; ++share) {
                draw_share(view, map_corner, seen, share);
            }
        }
    }
}
