// How a light or a camera sees the world, in parallel or perspective projection; conversions between texels, rays and depths.
// Twin: scene::View. `z` below is the distance along `forward` in world units, also in perspective views.
#ifndef WORLD_VIEW_GLSL
#define WORLD_VIEW_GLSL
#extension GL_EXT_scalar_block_layout : require

// Farther than any real depth or z: marks an unused node, or light that continues without end. Twin: scene::FARTHEST.
const float FARTHEST = 3e38;

const uint VIEW_PARALLEL = 0u;
const uint VIEW_PERSPECTIVE = 1u;

struct View {
    vec3 origin;
    uint projection;  // VIEW_PARALLEL or VIEW_PERSPECTIVE
    vec3 right;
    float scale_x;    // NDC per world unit (parallel) or per unit of tangent (perspective)
    vec3 up;
    float scale_y;
    vec3 forward;
    float near;       // z of depth 0
    float far;        // z of depth 1
    uint width;       // texels
    uint height;
};

// A ray whose parameter is z: point = origin + z · direction.
struct Ray {
    vec3 origin;
    vec3 direction;
};

// A point's x and y in texels (texel centres at .5), and its z as defined above.
vec3 view_project(View view, vec3 position) {
    vec3 offset = position - view.origin;
    float z = dot(offset, view.forward);
    float w = view.projection == VIEW_PARALLEL ? 1.0 : z;
    vec2 ndc = vec2(dot(offset, view.right) * view.scale_x, dot(offset, view.up) * view.scale_y) / w;
    return vec3((ndc * 0.5 + 0.5) * vec2(view.width, view.height), z);
}

// The w of a corner in a perspective view: its z, but never 0, since SwiftShader loses a triangle with such a corner. The value that
// replaces 0 is so far in front of the near plane that no texel shows the difference.
float view_w(View view, float z) { return z == 0.0 ? 1e-6 * view.near : z; }

// The ray through a point given in texels.
Ray view_ray(View view, vec2 texel) {
    vec2 ndc = texel / vec2(view.width, view.height) * 2.0 - 1.0;
    vec3 across = view.right * (ndc.x / view.scale_x) + view.up * (ndc.y / view.scale_y);
    return view.projection == VIEW_PARALLEL ? Ray(view.origin + across, view.forward)
                                            : Ray(view.origin, view.forward + across);
}

// The four texels around a point given in texels, x varying fastest, and their bilinear weights.
struct Footprint {
    ivec2 corner;
    float weights[4];
};

Footprint view_footprint(View view, vec2 at) {
    // Clamped so that the conversion to integers is defined: that far outside, all four texels are outside anyway.
    at = clamp(at, vec2(-2.0), vec2(view.width, view.height) + 2.0) - 0.5;
    vec2 corner = floor(at);
    vec2 high = at - corner, low = 1.0 - high;
    return Footprint(ivec2(corner), float[](low.x * low.y, high.x * low.y, low.x * high.y, high.x * high.y));
}

bool view_has(View view, ivec2 texel) {
    return all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(view.width, view.height)));
}

// Maps z to depth in the light's range: 0 at `near`, 1 at `far`.
float view_depth(View view, float z) {
    return (z - view.near) / (view.far - view.near);
}
#endif
