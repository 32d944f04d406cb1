#version 460
// Writes an entry for each tile that each caster reaches, casters far to near. The threads of a workgroup share the entries of its casters
// evenly. Inputs: order, boxes, sums. Output: items. Twin: reference::twin::painter.
#include "shading/painter/list_set.glsl"

layout(local_size_x = LIST_THREADS) in;

LIST_ORDER
LIST_BOXES
LIST_SUMS
LIST_ITEMS

// Whether an entry holds the caster's place in the order, instead of the caster's index.
CONSTANT(bool, BY_PLACE, false)

shared uint ends[LIST_THREADS];
// The first tile of each caster, its number of tiles across, and the caster's index.
shared uvec2 group_tiles[LIST_THREADS];
shared uint group_across[LIST_THREADS];
shared uint group_casters[LIST_THREADS];

void main() {
    uint thread = gl_LocalInvocationIndex, i = list_group() * LIST_THREADS + thread;
    if (list_group() * LIST_THREADS >= count) {
        return;
    }
    uvec2 tile = uvec2(0u), reached = uvec2(0u);
    if (i < count) {
        uint caster = order[first + i];
        tiles_of(boxes[caster], tile, reached);
        group_casters[thread] = BY_PLACE ? first + i : caster;
    }
    group_tiles[thread] = tile;
    group_across[thread] = reached.x;
    ends[thread] = reached.x * reached.y;
    for (uint reach = 1u; reach < LIST_THREADS; reach *= 2u) {
        barrier();
        uint other = thread >= reach ? ends[thread - reach] : 0u;
        barrier();
        ends[thread] += other;
    }
    barrier();
    uint base = sums[list_group()], all = base < capacity ? min(ends[LIST_THREADS - 1u], capacity - base) : 0u;
    for (uint e = thread; e < all; e += LIST_THREADS) {
        // Finds the first caster whose entries end after entry e.
        uint k = 0u;
        for (uint reach = LIST_THREADS / 2u; reach > 0u; reach /= 2u) {
            k += ends[k + reach - 1u] <= e ? reach : 0u;
        }
        uint within = e - (k > 0u ? ends[k - 1u] : 0u), across = group_across[k];
        uvec2 at = group_tiles[k] + uvec2(within % across, within / across);
        items[base + e] = Item(at.y * tile_counts().x + at.x, group_casters[k]);
    }
}
