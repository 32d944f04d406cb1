// Sorts a tile's entries by key, then by what their casters are, not where they are listed, with one workgroup of
// TILE_THREADS threads: a bitonic network in shared memory, or in the entries' own memory where a tile has more than fit. No
// limit on their number.
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

// Every comparison moves the smaller entry to the lower place, so entries past `count`, thought of as infinite, never move
// and need not exist. Shifts, since division takes long.
void sort_places(bool in_shared, uint first, uint count) {
    uint levels = count > 1u ? uint(findMSB(count - 1u)) + 1u : 0u, pairs = (1u << levels) >> 1u;
    for (uint half_size = 1u; half_size <= pairs; half_size <<= 1u) {
        for (uint t = gl_LocalInvocationIndex; t < pairs; t += TILE_THREADS) {
            uint place = t & (half_size - 1u), block = 2u * (t - place), other = block + 2u * half_size - 1u - place;
            if (other < count) {
                sort_pair(in_shared, first, block + place, other);
            }
        }
        sort_barrier(in_shared);
        for (uint step = half_size >> 1u; step > 0u; step >>= 1u) {
            for (uint t = gl_LocalInvocationIndex; t < pairs; t += TILE_THREADS) {
                uint i = t + (t & ~(step - 1u));
                if (i + step < count) {
                    sort_pair(in_shared, first, i, i + step);
                }
            }
            sort_barrier(in_shared);
        }
    }
}

// Afterwards entry i is sort_entry(first, count, i). All threads of the workgroup call it alike.
void sort_tile(uint first, uint count) {
    // Twice the text, so that no entry is picked from two memories: lavapipe 22.3 would read both.
    if (count > SORT_SHARED) {
        sort_places(false, first, count);
        return;
    }
    for (uint i = gl_LocalInvocationIndex; i < count; i += TILE_THREADS) {
        sort_entries[i] = entries[first + i];
    }
    barrier();
    sort_places(true, first, count);
}

uvec2 sort_entry(uint first, uint count, uint i) {
    return count <= SORT_SHARED ? sort_entries[i] : entries[first + i];
}
#endif
