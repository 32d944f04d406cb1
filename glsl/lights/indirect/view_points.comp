#version 460
// Computes the points that the camera sees, from the indices of their triangles. Inputs: camera, triangles, their sides, numbers. Output:
// points. Twin: reference::twin::indirect::view_point.
#include "shading/camera_push.glsl"
#include "shading/surface.glsl"
#include "lights/indirect/luminance.glsl"
#include "lights/indirect/view.glsl"
#include "maps/scene.glsl"

layout(local_size_x = 64) in;

// set 1: indirect_view
layout(set = 1, binding = 0, scalar) readonly buffer ViewSides { int view_sides[]; };
// Index of each point's triangle, plus 1.
layout(set = 1, binding = 1) uniform utexture2D numbers;
layout(set = 1, binding = 2, scalar) writeonly buffer ViewPoints { ViewPoint view_points[]; };

const float PI = 3.14159265;

// Smaller cosines count as this one, which bounds the area of surfaces seen at grazing angles.
const float LEAST_COSINE = 0.1;

void main() {
    uint i = gl_GlobalInvocationID.x;
    View camera = pushed_camera();
    uvec2 at = uvec2(i % POINTS_ACROSS, i / POINTS_ACROSS);
    uint number = texelFetch(numbers, ivec2(at), 0).r;
    if (number == 0u) {
        view_points[i] = ViewPoint(vec3(0.0), 0.0, vec3(0.0, 0.0, 1.0), 0.0, 0u);
        return;
    }
    Triangle triangle = triangles[number - 1u];
    int side = view_sides[number - 1u];
    Surface surface = surface_of(camera, triangle, side);
    Ray ray = surface_ray(camera, vec2(at) + 0.5);
    float z = surface_z(ray, surface), slant = length(ray.direction);
    float cosine = max(abs(dot(ray.direction, surface.normal)) / slant, LEAST_COSINE);
    float crossed = 4.0 * z * z / (float(POINTS) * abs(camera.scale_x * camera.scale_y) * slant * PI);
    view_points[i] = ViewPoint(surface_position(ray, z), crossed / cosine, surface.normal, luminance(triangle.albedo),
                               side == 0 ? 1u : 0u);
}
