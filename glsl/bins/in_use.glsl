// The tile of a workgroup, for passes with one workgroup a listed tile. Needs, declared before: totals, tiles_in_use.
#ifndef BINS_IN_USE_GLSL
#define BINS_IN_USE_GLSL

// False where the list has ended.
bool listed_tile(uint map, out uint tile) {
    uint place = gl_WorkGroupID.y * BIN_GROUPS_X + gl_WorkGroupID.x;
    bool listed = place < totals[map].tiles_listed;
    tile = listed ? tiles_in_use[place] : 0u;
    return listed;
}
#endif
