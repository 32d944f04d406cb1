// lighting=vertex: where the vertices of a caster's quad are, and where they look up their light. Source: Fife and Strugar 2013,
// Tessellation; Bavoil and Jansen 2013, Particle Lighting with DX11. Twin: reference::twin::vertex_lit.
#ifndef CONSUME_VERTEX_LIT_GLSL
#define CONSUME_VERTEX_LIT_GLSL
#include "world/caster.glsl"

// Level that every device with tessellation supports.
const float MAX_LEVEL = 64.0;

// Number of parts into which a side of a caster's quad is divided. `pixels`: the side's length. `spacing`: largest distance between
// neighbouring vertices, in pixels. A side of one part has vertices only at its ends, on the caster's silhouette or past it, where there is
// more light than inside. So a side longer than half of `spacing` is divided into at least two parts. A smaller caster is not divided: it
// has fewer pixels than 2 × 2 parts have vertices, which is nine.
float parts(float pixels, float spacing) {
    return clamp(ceil(pixels / spacing), pixels > 0.5 * spacing ? 2.0 : 1.0, MAX_LEVEL);
}

// The quad of a caster, low corner and high corner in NDC, as large as caster_corner draws it, and its number of parts along x and y. False
// if the quad is off the screen.
bool lit_quad(View camera, Caster caster, float spacing, out vec4 corners, out vec2 level) {
    vec2 low, high;
    bool seen = caster_bounds(camera, caster, low, high)
             && all(lessThan(low, vec2(1.0))) && all(greaterThan(high, vec2(-1.0)));
    low = clamp(low, -1.1, 1.1);
    high = clamp(high, -1.1, 1.1);
    vec2 pixels = 0.5 * (high - low) * vec2(camera.width, camera.height);
    corners = vec4(low, high);
    level = vec2(parts(pixels.x, spacing), parts(pixels.y, spacing));
    return seen;
}

// Pixel position of a vertex: `at` runs from 0 to 1 over the quad.
vec2 vertex_pixel(View camera, vec4 corners, vec2 at) {
    return (0.5 * mix(corners.xy, corners.zw, at) + 0.5) * vec2(camera.width, camera.height);
}

// Where a vertex looks up its light. On a sphere: as in caster.frag, at the midpoint of the segment of the vertex's ray inside the sphere.
// If the ray misses the sphere, at the sphere's point nearest to the ray, since farther out there may be more light than anywhere inside. A
// mesh that intersects the sphere also clips the segment. A mesh in front of the whole sphere is ignored: it hides this vertex, but perhaps
// not the pixels beside it. On a strand: at the point of the axis nearest to the ray, since most of a strand's quad is far from the strand.
vec3 caster_asked(View camera, Ray ray, Caster caster, float farthest) {
    if (caster_is_strand(caster)) {
        vec3 start, axis;
        float along;
        bool wide = strand_along(ray, caster, start, axis, along);
        return caster.position + (wide ? clamp(along, 0.0, 1.0) : 0.5) * caster.axis;
    }
    float square = dot(ray.direction, ray.direction);
    float middle = dot(caster.position - ray.origin, ray.direction) / square;
    vec3 across = ray.origin + middle * ray.direction - caster.position;
    float half_chord = sqrt(max(caster.radius * caster.radius - dot(across, across), 0.0) / square);
    bool in_front = farthest < middle - caster.radius * inversesqrt(square);
    vec2 z = max(min(middle + vec2(-half_chord, half_chord), in_front ? camera.far : farthest), camera.near);
    across *= caster.radius / max(length(across), caster.radius);
    return caster.position + across + (0.5 * (z.x + z.y) - middle) * ray.direction;
}

// Side of the square of pixels represented by a vertex: the pixels nearer to that vertex than to any other.
float vertex_side(View camera, vec4 corners, vec2 level) {
    vec2 apart = 0.5 * (corners.zw - corners.xy) * vec2(camera.width, camera.height) / level;
    return sqrt(apart.x * apart.y);
}
#endif
