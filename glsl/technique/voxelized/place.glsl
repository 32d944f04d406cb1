// Position in a light's voxels, and distance by which a receiver is moved. Include after technique/voxelized/walk.glsl.
// Twins: reference::twin::voxelized::voxel, scene::Resolution::looked_up.
#ifndef TECHNIQUE_VOXELIZED_PLACE_GLSL
#define TECHNIQUE_VOXELIZED_PLACE_GLSL
#include "world/face.glsl"

// Returns the light's tree that a position is looked up in.
uint tree_of(uint light, vec3 position) {
    uint first = visibility_trees[light].first;
    bool faces = visibility_trees[light].faces > 1u;
    return first + (faces ? cube_face(position - visibility_trees[first].origin) : 0u);
}

// Returns a position in voxels. At or behind the tip of a pyramid, the result is meaningless.
vec3 tree_voxel(uint tree, vec3 position) {
    vec3 offset = position - visibility_trees[tree].origin;
    vec3 voxel = vec3(dot(offset, visibility_trees[tree].right), dot(offset, visibility_trees[tree].up),
                      dot(offset, visibility_trees[tree].forward));
    if (visibility_trees[tree].perspective != 0u) {
        voxel.xy = voxel.xy / voxel.z + 0.5 * float(visibility_trees[tree].size);
    }
    return voxel;
}

// Returns how far a surface point must be moved along its normal, in world units, to lie `across` columns plus `always` beside the
// surface's plane, and `along` voxels in front of it.
float receiver_way(uint tree, vec3 position, vec3 normal, float across, float along, float always) {
    vec3 right = visibility_trees[tree].right, forward = visibility_trees[tree].forward;
    float columns = length(right), looks = dot(normal, forward);
    float beside = across * (abs(dot(normal, right)) + abs(dot(normal, visibility_trees[tree].up))) / columns + always;
    if (visibility_trees[tree].perspective == 0u) {
        return (beside + along * abs(looks) / columns) / columns;
    }
    vec3 offset = position - visibility_trees[tree].origin;
    float z = dot(offset, forward);
    if (!(z > 0.0)) {
        return 0.0;
    }
    // Columns are wider behind the point, and rays are steeper in front of it: `more` allows for that at the moved point.
    float before = (along + always) * abs(dot(normal, offset)) / z;
    float more = looks > 0.0 ? beside / columns * looks : -2.0 * before * looks / z;
    return (beside * z / columns + before) / (1.0 - min(more, 0.5));
}
#endif
