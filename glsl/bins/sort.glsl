// Sorts a tile's entries by key, then by what their casters are, not where they are listed, with one workgroup of TILE_THREADS threads: a bitonic network in shared
// memory, or in the entries' own memory where a tile has more than fit. No limit on their number.
// Needs, declared before: a coherent buffer `uvec2 entries[]`, and `casters`.
#ifndef BINS_SORT_GLSL
#define BINS_SORT_GLSL

const uint TILE_THREADS = 64u;
const uint SORT_SHARED = 1024u;

shared uvec2 sort_entries[SORT_SHARED];

bool entry_after(uvec2 a, uvec2 b) {
    return a.x > b.x || (a.x == b.x && caster_after(casters[a.y], casters[b.y]));
}

void sort_pair(bool in_shared, uint first, uint i, uint j) {
    uvec2 a = in_shared ? sort_entries[i] : entries[first + i];
    uvec2 b = in_shared ? sort_entries[j] : entries[first + j];
    if (entry_after(a, b)) {
        if (in_shared) {
            sort_entries[i] = b;
            sort_entries[j] = a;
        } else {
            entries[first + i] = b;
            entries[first + j] = a;
        }
    }
}

void sort_barrier(bool in_shared) {
    if (!in_shared) {
        memoryBarrierBuffer();
    }
    barrier();
}

// Afterwards entry i is sort_entry(first, count, i). All threads of the workgroup call it alike.
void sort_tile(uint first, uint count) {
    uint thread = gl_LocalInvocationIndex;
    bool in_shared = count <= SORT_SHARED;
    if (in_shared) {
        for (uint i = thread; i < count; i += TILE_THREADS) {
            sort_entries[i] = entries[first + i];
        }
        barrier();
    }
    uint padded = 1u;
    while (padded < count) {
        padded <<= 1u;
    }
    // Every comparison moves the smaller entry to the lower place, so entries past `count`, thought of as infinite,
    // never move and need not exist.
    for (uint size = 2u; size <= padded; size <<= 1u) {
        uint half_size = size >> 1u;
        for (uint t = thread; t < padded / 2u; t += TILE_THREADS) {
            uint block = t / half_size * size, place = t % half_size;
            if (block + size - 1u - place < count) {
                sort_pair(in_shared, first, block + place, block + size - 1u - place);
            }
        }
        sort_barrier(in_shared);
        for (uint step = size >> 2u; step > 0u; step >>= 1u) {
            for (uint t = thread; t < padded / 2u; t += TILE_THREADS) {
                uint i = t / step * (2u * step) + t % step;
                if (i + step < count) {
                    sort_pair(in_shared, first, i, i + step);
                }
            }
            sort_barrier(in_shared);
        }
    }
}

uvec2 sort_entry(uint first, uint count, uint i) {
    return count <= SORT_SHARED ? sort_entries[i] : entries[first + i];
}
#endif
