// Where the ray of a pixel hits the triangle that covers the pixel. A rasterizer snaps corners to its grid, so its interpolated z belongs
// to a ray beside the pixel's. A point with that z on the pixel's own ray would be off the triangle, in its own shadow or in front of it.
// Forward and deferred shading both look up light at the point found here, identical bit for bit.
#ifndef CONSUME_SURFACE_GLSL
#define CONSUME_SURFACE_GLSL
#include "world/triangle.glsl"
#include "world/view.glsl"

// A triangle's plane, as a corner and the normal, and the least and the greatest z of the triangle's corners.
struct Surface {
    vec3 corner;
    vec3 normal;
    vec2 z;
};

float camera_z(View camera, vec3 position) {
    precise vec3 offset = position - camera.origin;
    precise float z = offset.x * camera.forward.x + offset.y * camera.forward.y + offset.z * camera.forward.z;
    return z;
}

// `side` as in world::Generations::sides: on a closed mesh the normal points outwards.
Surface surface_of(View camera, Triangle triangle, int side) {
    vec3 z = vec3(camera_z(camera, triangle.corners[0]), camera_z(camera, triangle.corners[1]),
                  camera_z(camera, triangle.corners[2]));
    vec3 normal = side < 0 ? -triangle_normal(triangle) : triangle_normal(triangle);
    return Surface(triangle.corners[0], normal, vec2(min(min(z.x, z.y), z.z), max(max(z.x, z.y), z.z)));
}

// Position of a corner in clip space.
vec4 surface_place(View camera, vec3 corner) {
    vec3 offset = corner - camera.origin;
    float z = camera_z(camera, corner);
    return vec4(dot(offset, camera.right) * camera.scale_x, dot(offset, camera.up) * camera.scale_y,
                (z - camera.near) * camera.far / (camera.far - camera.near), view_w(camera, z));
}

// The ray through a pixel of a perspective camera. All arithmetic here is `precise`, so that any two shaders round alike.
Ray surface_ray(View camera, vec2 pixel) {
    precise vec2 ndc = pixel / vec2(camera.width, camera.height) * 2.0 - 1.0;
    precise vec3 direction =
        camera.forward + camera.right * (ndc.x / camera.scale_x) + camera.up * (ndc.y / camera.scale_y);
    return Ray(camera.origin, direction);
}

// z at which the ray hits the triangle's plane, clamped to the range of z of the triangle's corners. If the plane is parallel to the ray,
// returns the smallest z of the corners.
float surface_z(Ray ray, Surface surface) {
    precise float z = dot(surface.corner - ray.origin, surface.normal) / dot(ray.direction, surface.normal);
    return z >= surface.z.x ? min(z, surface.z.y) : surface.z.x;
}

vec3 surface_position(Ray ray, float z) {
    precise vec3 position = ray.origin + z * ray.direction;
    return position;
}
#endif
