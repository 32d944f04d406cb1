// Depth of a caster's centre in front of the camera, as an integer that decreases with distance. Twin:
// reference::twin::far_to_near.
#ifndef CONSUME_FAR_TO_NEAR_GLSL
#define CONSUME_FAR_TO_NEAR_GLSL
#include "maps/float_order.glsl"
#include "world/caster.glsl"

layout(push_constant, scalar) uniform FarToNearPush {
    vec3 origin;   // of the camera
    uint count;
    vec3 forward;
};

uint far_to_near(Caster caster) {
    // The origin is subtracted first: far from the world's origin the rest would be rounded away.
    precise vec3 middle = caster.position - origin + 0.5 * caster_axis(caster);
    precise float z = middle.x * forward.x + middle.y * forward.y + middle.z * forward.z;
    return ~float_order(z);
}
#endif
