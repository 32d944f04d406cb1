// What a workgroup builds, for passes with one workgroup a listed part. Needs, declared before: totals, parts.
#ifndef BINS_PART_GLSL
#define BINS_PART_GLSL

// False where the list has ended; there is room behind it, so that both reads can be under way at once.
bool listed_part(uint map, out TilePart part) {
    uint place = gl_WorkGroupID.y * BIN_GROUPS_X + gl_WorkGroupID.x;
    part = parts[place];
    return place < totals[map].parts;
}
#endif
