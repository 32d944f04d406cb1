// A segment's contribution to a texel's layers. Twin: reference::twin::layers.
#ifndef TECHNIQUE_LAYERS_PARTS_GLSL
#define TECHNIQUE_LAYERS_PARTS_GLSL
#include "technique/layers/layers.glsl"

#define SUMS PLANES

// Each layer's sum is the optical depth of everything before the layer's end.
void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]) {
    // A zero-length segment is a step; a point exactly at the step counts as behind it.
    float steepness = place.y > place.x ? 1.0 / (place.y - place.x) : 0.0;
    for (uint k = 0u; k < SUMS; ++k) {
        float end = layer_end(k + 1u);
        parts[k] = end >= place.y ? optical_depth : optical_depth * clamp((end - place.x) * steepness, 0.0, 1.0);
    }
}
#endif
