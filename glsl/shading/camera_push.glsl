// The camera as push constants of a dispatch or a draw, so that millions of threads need not read it from a buffer.
// Twin: world::CameraPush.
#ifndef CONSUME_CAMERA_PUSH_GLSL
#define CONSUME_CAMERA_PUSH_GLSL
#include "world/view.glsl"

layout(push_constant, scalar) uniform CameraPush {
    vec3 origin;
    float scale_x;
    vec3 right;
    float scale_y;
    vec3 up;
    float near;
    vec3 forward;
    float far;
    uvec2 size;
};

// The camera as a view, which is in perspective for every camera.
View pushed_camera() {
    return View(origin, VIEW_PERSPECTIVE, right, scale_x, up, scale_y, forward, near, far, size.x, size.y);
}
#endif
