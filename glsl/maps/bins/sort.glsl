// Sorts a tile's entries by key, and entries of equal key by the casters' values, so that the order of the list does not matter. One
// workgroup of TILE_THREADS threads runs a bitonic network, in shared memory or, if a tile has more entries than fit, in the entries' own
// memory: their number has no limit. The network compares only keys. Entries of equal key are then adjacent and are sorted by their
// casters, which are slow to read: a few by one thread, many by the network once more. Must be declared before inclusion: a coherent buffer
// `uvec2 entries[]`, and `casters`.
#ifndef MAPS_BINS_SORT_GLSL
#define MAPS_BINS_SORT_GLSL

const uint TILE_THREADS = 64u;
const uint SORT_SHARED = 1024u;

// Largest number of entries of equal key that one thread sorts.
const uint SORT_ALONE = 16u;

shared uvec2 sort_entries[SORT_SHARED];
// Whether more than SORT_ALONE entries have the same key.
shared bool sort_many;

bool entry_after(uvec2 a, uvec2 b) {
    return a.x > b.x || (a.x == b.x && caster_after(casters[a.y], casters[b.y]));
}

uvec2 sort_read(bool in_shared, uint first, uint i) {
    return in_shared ? sort_entries[i] : entries[first + i];
}

void sort_write(bool in_shared, uint first, uint i, uvec2 entry) {
    if (in_shared) {
        sort_entries[i] = entry;
    } else {
        entries[first + i] = entry;
    }
}

void sort_pair(bool in_shared, bool by_casters, uint first, uint i, uint j) {
    uvec2 a = sort_read(in_shared, first, i), b = sort_read(in_shared, first, j);
    if (by_casters ? entry_after(a, b) : a.x > b.x) {
        sort_write(in_shared, first, i, b);
        sort_write(in_shared, first, j, a);
    }
}

void sort_barrier(bool in_shared) {
    if (!in_shared) {
        memoryBarrierBuffer();
    }
    barrier();
}

// Every comparison moves the smaller entry to the lower index, so entries past `count`, thought of as infinite, never move and need not
// exist. Indices are computed by shifts, since division is slow.
void sort_places(bool in_shared, bool by_casters, uint first, uint count) {
    uint levels = count > 1u ? uint(findMSB(count - 1u)) + 1u : 0u, pairs = (1u << levels) >> 1u;
    for (uint half_size = 1u; half_size <= pairs; half_size <<= 1u) {
        for (uint t = gl_LocalInvocationIndex; t < pairs; t += TILE_THREADS) {
            uint place = t & (half_size - 1u), block = 2u * (t - place), other = block + 2u * half_size - 1u - place;
            if (other < count) {
                sort_pair(in_shared, by_casters, first, block + place, other);
            }
        }
        sort_barrier(in_shared);
        for (uint step = half_size >> 1u; step > 0u; step >>= 1u) {
            for (uint t = gl_LocalInvocationIndex; t < pairs; t += TILE_THREADS) {
                uint i = t + (t & ~(step - 1u));
                if (i + step < count) {
                    sort_pair(in_shared, by_casters, first, i, i + step);
                }
            }
            sort_barrier(in_shared);
        }
    }
}

// Sorts entries of equal key, which are adjacent since entries are sorted by key.
void sort_equals(bool in_shared, uint first, uint count) {
    for (uint i = gl_LocalInvocationIndex; i < count; i += TILE_THREADS) {
        uint key = sort_read(in_shared, first, i).x, end = i + 1u;
        // Other threads may be moving entries, but only among entries of equal key: the keys stay in place.
        bool begins = i == 0u || sort_read(in_shared, first, i - 1u).x != key;
        while (begins && end < count && end - i <= SORT_ALONE && sort_read(in_shared, first, end).x == key) {
            ++end;
        }
        if (end - i > SORT_ALONE) {
            sort_many = true;
            end = i;
        }
        for (uint j = i + 1u; j < end; ++j) {
            uvec2 entry = sort_read(in_shared, first, j), before;
            uint place = j;
            while (place > i && entry_after(before = sort_read(in_shared, first, place - 1u), entry)) {
                sort_write(in_shared, first, place, before);
                --place;
            }
            sort_write(in_shared, first, place, entry);
        }
    }
    sort_barrier(in_shared);
}

void sort_all(bool in_shared, uint first, uint count) {
    sort_places(in_shared, false, first, count);
    sort_equals(in_shared, first, count);
    if (sort_many) {
        sort_places(in_shared, true, first, count);
    }
}

// Afterwards entry i is sort_entry(first, count, i). All threads of the workgroup must call it with the same arguments.
void sort_tile(uint first, uint count) {
    if (gl_LocalInvocationIndex == 0u) {
        sort_many = false;
    }
    // One call per memory: if a single call chose the memory per entry, lavapipe 22.3 would read both.
    if (count > SORT_SHARED) {
        barrier();
        sort_all(false, first, count);
        return;
    }
    for (uint i = gl_LocalInvocationIndex; i < count; i += TILE_THREADS) {
        sort_entries[i] = entries[first + i];
    }
    barrier();
    sort_all(true, first, count);
}

uvec2 sort_entry(uint first, uint count, uint i) {
    return count <= SORT_SHARED ? sort_entries[i] : entries[first + i];
}
#endif
