#version 460
// Finds each node's slot in the hash table, which all equal nodes share. If a slot is taken, the words are compared; if they differ, the
// next slot is tried. Two nodes are never merged by their hash alone. Source: ours; hash after Appleby 2008 (MurmurHash3). Inputs:
// candidates, kept nodes. Outputs: table, slots. Twin: reference::twin::voxelized::merge.
layout(local_size_x = 64) in;
#include "technique/voxelized/build.glsl"
#include "technique/voxelized/merge.glsl"

// Maximum number of slots tried per node, which hardly any node reaches in a half-full table; number of failed nodes after which no more
// are tried.
const uint MOST_TRIES = 512u;
const uint MOST_LOST = 256u;

uint hash(uint node) {
    uint words = node_words(), sum = 0x9e3779b9u;
    for (uint w = 0u; w < words; ++w) {
        uint k = candidates[words * node + w] * 0xcc9e2d51u;
        k = ((k << 15) | (k >> 17)) * 0x1b873593u;
        sum ^= k;
        sum = ((sum << 13) | (sum >> 19)) * 5u + 0xe6546b64u;
    }
    sum = (sum ^ (sum >> 16)) * 0x85ebca6bu;
    sum = (sum ^ (sum >> 13)) * 0xc2b2ae35u;
    return sum ^ (sum >> 16);
}

// Returns whether the node in a slot equals a candidate.
bool is_equal(uint node, uint standing) {
    uint number_of_words = node_words();
    bool kept = (standing & CANDIDATE) == 0u;
    if (kept && standing > unique_capacity) {
        return false;
    }
    uint place = kept ? unique_at + number_of_words * (standing - 1u) : number_of_words * (standing & ~CANDIDATE);
    for (uint w = 0u; w < number_of_words; ++w) {
        uint other = kept ? unique_nodes[place + w] : candidates[place + w];
        if (other != candidates[number_of_words * node + w]) {
            return false;
        }
    }
    return true;
}

void main() {
    uint node = 64u * build_group() + gl_LocalInvocationIndex;
    if (node >= levels[level].candidates || !MERGE) {
        return;
    }
    // Gives up early if the table is too full; a larger one is then created.
    uint slot = hash(node) & table_mask, most = levels[level].lost > MOST_LOST ? 0u : min(table_mask + 1u, MOST_TRIES);
    for (uint tries = 0u; tries < most; ++tries) {
        uint standing = atomicCompSwap(table[table_at + slot], EMPTY, CANDIDATE | node);
        if (standing == EMPTY || is_equal(node, standing)) {
            atomicMin(table[table_at + slot], CANDIDATE | node);
            slots[slots_at + node] = slot;
            return;
        }
        slot = (slot + 1u) & table_mask;
    }
    slots[slots_at + node] = 0u;
    atomicAdd(levels[level].lost, 1u);
}
