// A sphere of constant extinction, its overlap with a ray, and the quad that covers it. Twin: scene::Particle,
// reference::sphere.
#ifndef COMMON_PARTICLE_GLSL
#define COMMON_PARTICLE_GLSL
#include "common/view.glsl"

struct Particle {
    vec3 position;
    float radius;
    float extinction;  // 1 / world unit
};

// Optical depth from which a caster counts as opaque: exp(-80) is still a normal float, and sums of many stay finite.
const float MAX_OPTICAL_DEPTH = 80.0;

// Where the ray is inside the sphere, z from .x to .y. The offset from the ray is squared after the subtraction, so
// that a far origin costs no digits.
bool particle_overlap(Ray ray, Particle particle, out vec2 z) {
    vec3 offset = particle.position - ray.origin;
    float scale = 1.0 / dot(ray.direction, ray.direction);
    float middle = dot(offset, ray.direction) * scale;
    vec3 across = offset - middle * ray.direction;
    float half_square = (particle.radius * particle.radius - dot(across, across)) * scale;
    if (!(half_square > 0.0)) {
        z = vec2(0.0);
        return false;
    }
    float half_chord = sqrt(half_square);
    z = vec2(middle - half_chord, middle + half_chord);
    return true;
}

float particle_optical_depth(Ray ray, Particle particle, vec2 z) {
    return min(particle.extinction * (z.y - z.x) * length(ray.direction), MAX_OPTICAL_DEPTH);
}

// Range of tan(angle) that a circle of radius r at (across, z) covers, seen from the origin; all of it when the circle
// reaches behind the eye.
vec2 particle_tangents(float across, float z, float radius) {
    if (z <= radius) {
        return vec2(-1e9, 1e9);
    }
    float side = sqrt(max(across * across + z * z - radius * radius, 0.0));
    return vec2((across * side - radius * z) / (z * side + radius * across),
                (across * side + radius * z) / (z * side - radius * across));
}

// Bounds of the sphere in NDC, low corner and high corner; false where it is behind the view. They are a 16th of a
// texel too large, against rounding: whoever draws or bins with them decides exactly afterwards.
bool particle_bounds(View view, Particle particle, out vec2 low, out vec2 high) {
    vec3 offset = particle.position - view.origin;
    vec3 centre = vec3(dot(offset, view.right), dot(offset, view.up), dot(offset, view.forward));
    vec2 x = centre.x + vec2(-particle.radius, particle.radius);
    vec2 y = centre.y + vec2(-particle.radius, particle.radius);
    low = high = vec2(2.0);
    if (view.projection == VIEW_PERSPECTIVE) {
        if (centre.z + particle.radius <= view.near) {
            return false;
        }
        x = particle_tangents(centre.x, centre.z, particle.radius);
        y = particle_tangents(centre.y, centre.z, particle.radius);
    }
    x *= view.scale_x;
    y *= view.scale_y;
    vec2 margin = 0.125 / vec2(view.width, view.height);
    low = vec2(min(x.x, x.y), min(y.x, y.y)) - margin;
    high = vec2(max(x.x, x.y), max(y.x, y.y)) + margin;
    return true;
}

// Corner 0..5 of two triangles over the sphere's bounds.
vec4 particle_corner(View view, Particle particle, uint corner) {
    vec2 low, high;
    if (!particle_bounds(view, particle, low, high)) {
        return vec4(2.0, 2.0, 0.0, 1.0);
    }
    vec2 select = vec2(corner == 1u || corner == 2u || corner == 4u, corner == 2u || corner == 4u || corner == 5u);
    return vec4(clamp(mix(low, high, select), -1.1, 1.1), 0.5, 1.0);
}
#endif
