// Assigns a caster's whole optical depth to a slice. Slice k spans the depths k / SLICES to (k + 1) / SLICES of the light's range. With
// SPLIT, the two slices whose midpoints enclose the caster's centre share the optical depth. Their mean depth is then the caster's depth,
// and nothing jumps as the caster moves. If the caster's transmittance is T, the two slices get T^(1 - share) and T^share.
// Twin: reference::twin::psm::place.
#ifndef TECHNIQUE_PSM_PLACE_GLSL
#define TECHNIQUE_PSM_PLACE_GLSL
#include "world/caster.glsl"
#include "technique/psm/constants.glsl"

struct Place {
    uint slice;
    float share;  // share of the optical depth that the next slice takes
};

Place depth_place(float depth) {
    float at = clamp(depth * float(SLICES) - (SPLIT ? 0.5 : 0.0), 0.0, float(SLICES - 1u));
    uint slice = uint(at);
    return Place(slice, SPLIT ? at - float(slice) : 0.0);
}

// Returns a caster's place from its centre, or from a strand's midpoint.
Place caster_place(View view, Caster caster) {
    float z = dot(caster.position + 0.5 * caster_axis(caster) - view.origin, view.forward);
    return depth_place(view_depth(view, z));
}
#endif
