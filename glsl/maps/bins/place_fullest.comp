#version 460
// Does the same as place.comp, but with one workgroup, and lists the tiles with the most casters first. Workgroups start in the order of
// the list; if a full tile started last, the whole device would wait for it. Inputs: counts, slots. Outputs: cursors, parts, totals
// (cleared beforehand).
// Invariant: a tile comes before all tiles with less than four fifths of its casters.
// LISTED 0: all tiles. LISTED 1: the blocks listed by maps/detail/choose.comp.
// variants: LISTED 0 1
#include "maps/bins/place.glsl"
#include "maps/detail/set.glsl"

// Size of the workgroup: at least 128.
layout(local_size_x_id = ID_WORKGROUP) in;
// The workgroup's size again: some tools do not accept a specialized gl_WorkGroupSize as a constant.
CONSTANT(uint, THREADS, 128u)

// Number of classes of tiles: four for each doubling of the casters.
const uint CLASSES = 128u;

// First the number of parts in each class; then where the next part of each class is listed.
shared uint classes[CLASSES];
shared uint entries_low, entries_high, used, fullest;

uint class_of(uint count) {
    uint top = count < 4u ? 0u : uint(findMSB(count)) - 2u;
    return 4u * top + (count >> top);
}

#if LISTED == 1
DETAIL_LISTED(readonly buffer)

uint bin_count() { return listed[0]; }
uint bin_at(uint i) { return listed[i + 1u]; }
uint wanted_of(uint bin, uint count) { return PARTS; }
#else
uint bin_count() { return bins_per_map() * map_count; }
uint bin_at(uint i) { return i; }
uint wanted_of(uint bin, uint count) { return parts_wanted(bin, count); }
#endif

void main() {
    uint thread = gl_LocalInvocationIndex, bins = bin_count();
    if (thread < CLASSES) {
        classes[thread] = 0u;
    }
    if (thread == 0u) {
        entries_low = entries_high = used = fullest = 0u;
    }
    barrier();
    uint most = 0u, with_casters = 0u;
    for (uint i = thread; i < bins; i += THREADS) {
        uint bin = bin_at(i), count = counts[bin];
        most = max(most, count);
        with_casters += uint(count > 0u);
        atomicAdd(classes[class_of(count)], wanted_of(bin, count));
    }
    atomicMax(fullest, most);
    atomicAdd(used, with_casters);
    barrier();
    uint before = 0u, parts_of_class = 0u;
    if (thread < CLASSES) {
        parts_of_class = classes[thread];
        for (uint fuller = thread + 1u; fuller < CLASSES; ++fuller) {
            before += classes[fuller];
        }
    }
    barrier();
    if (thread < CLASSES) {
        classes[thread] = before;
    }
    barrier();
    for (uint i = thread; i < bins; i += THREADS) {
        uint bin = bin_at(i), count = counts[bin], first = 0u;
        if (count > 0u) {
            first = atomicAdd(entries_low, count);
            if (first + count < first) {
                atomicAdd(entries_high, 1u);
            }
        }
        uint wanted = wanted_of(bin, count);
        uint place = wanted > 0u ? atomicAdd(classes[class_of(count)], wanted) : 0u;
        list_parts(place, wanted, bin, count, first_entry(bin, i, count, first));
    }
    barrier();
    if (thread == 0u) {
        uint listed = before + parts_of_class;
        totals[0].entries = entries_low;
        totals[0].entries_high = entries_high;
        totals[0].tiles_used = used;
        totals[0].parts = listed;
        totals[0].groups_x = BIN_GROUPS_X;
        totals[0].groups_y = (listed + BIN_GROUPS_X - 1u) / BIN_GROUPS_X;
        totals[0].groups_z = 1u;
        // The maximum with the old value, since scatter may have recorded a tile that exceeded its capacity.
        atomicMax(totals[0].fullest, fullest);
    }
}
