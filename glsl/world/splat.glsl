// Splats: anisotropic Gaussians of extinction. Along a ray the extinction is again a Gaussian, with a centre and a deviation, so the
// optical depth up to a point is an error function. Source: docs/notebook/splats.md. Twins: scene::Splat, reference::twin::splat,
// reference::truth::splat.
#ifndef WORLD_SPLAT_GLSL
#define WORLD_SPLAT_GLSL
#include "world/view.glsl"

// A splat extends this many deviations from its centre. Twin: REACH.
const float SPLAT_REACH = 3.0;
// The segment of constant extinction that approximates a splat extends this many deviations to either side of the splat's centre. This
// length minimizes the mean error of the optical depth up to a point on the ray: integrated along the ray, the error is an 8th of a
// deviation times the whole optical depth. The error bound at any point is 6.7 % of the whole optical depth. Twin: CHORD.
const float SPLAT_CHORD = 1.5;
// Octaves covered by the 12 bits that encode the ratio of two axes. Twin: OCTAVES.
const float SPLAT_OCTAVES = 12.0;
// Bits of the axis that mark a caster as a splat. Twin: MARK.
const uint SPLAT_MARK = 0x71800000u;

const float ROOT_TWO_PI = 2.50662827;
// Within its reach a splat has all of its extinction except a fraction of exp(−4.5). This factor makes up for the missing fraction, so that
// on average many splats absorb as much light as splats of unlimited reach. Twin: WHOLE.
const float SPLAT_WHOLE = 1.01123452;

bool splat_marked(vec3 axis) { return (floatBitsToUint(axis.x) & 0x7F800000u) == SPLAT_MARK; }

// Unit axis vectors, from the longest axis to the shortest, and the deviations along them, in world units.
struct SplatShape {
    vec3 axes[3];
    vec3 deviations;
};

// Decodes a direction from the octahedron's upper half, rotated by 45°.
vec3 splat_axis(uvec2 packed) {
    vec2 at = vec2(packed) * (2.0 / 65535.0) - 1.0;
    vec2 place = 0.5 * vec2(at.x + at.y, at.x - at.y);
    return normalize(vec3(place, 1.0 - abs(place.x) - abs(place.y)));
}

// Two unit vectors perpendicular to one whose z is not negative. Source: Duff et al. 2017, Building an Orthonormal Basis, Revisited.
void splat_across(vec3 n, out vec3 first, out vec3 second) {
    float a = -1.0 / (1.0 + n.z), b = n.x * n.y * a;
    first = vec3(1.0 + n.x * n.x * a, b, -n.x);
    second = vec3(b, 1.0 + n.y * n.y * a, -n.y);
}

// Base-2 logarithms of the ratios of the longest axis to the middle one (x) and to the shortest (y), as 12-bit numbers.
uvec2 splat_octaves(uvec3 bits) {
    uvec3 high = (bits >> 16u & 127u) | (bits >> 24u & 128u);
    uint both = high.x | high.y << 8u | high.z << 16u;
    return uvec2(both & 4095u, both >> 12u);
}

SplatShape splat_shape(float radius, vec3 packed) {
    uvec3 bits = floatBitsToUint(packed);
    SplatShape shape;
    vec3 shortest = splat_axis(bits.xy & 0xFFFFu), first, second;
    splat_across(shortest, first, second);
    float along = float(bits.z & 0xFFFFu) * (2.0 / 65535.0) - 1.0;
    vec3 longest = normalize(along * first + (1.0 - abs(along)) * second);
    shape.axes = vec3[](longest, cross(shortest, longest), shortest);
    vec2 less = exp2(vec2(splat_octaves(bits)) * (-SPLAT_OCTAVES / 4095.0));
    shape.deviations = radius * (1.0 / SPLAT_REACH) * vec3(1.0, less);
    return shape;
}

// Packs the shortest and the longest axis as 16 bits in each of three words. The sign of either axis does not matter. Twin: axes_packed.
uvec3 splat_packed(vec3 shortest, vec3 longest) {
    vec3 first, second;
    shortest = shortest.z < 0.0 ? -shortest : shortest;
    vec2 place = shortest.xy / (abs(shortest.x) + abs(shortest.y) + shortest.z);
    vec2 both = vec2(place.x + place.y, place.x - place.y) * 0.5 + 0.5;
    uvec2 axis = uvec2(clamp(both, 0.0, 1.0) * 65535.0 + 0.5);
    splat_across(splat_axis(axis), first, second);
    vec2 turn = vec2(dot(first, longest), dot(second, longest));
    turn = turn.y < 0.0 ? -turn : turn;
    uint angle = uint(clamp(turn.x / (abs(turn.x) + turn.y) * 0.5 + 0.5, 0.0, 1.0) * 65535.0 + 0.5);
    return uvec3(axis, angle);
}

// Rotates a packed shape into a view's axes and packs it again. An ellipsoid equals its mirror image about its own axes, so the view's axes
// may be left-handed.
vec3 splat_turned(View view, vec3 packed) {
    SplatShape shape = splat_shape(SPLAT_REACH, packed);
    mat3 across = transpose(mat3(view.right, view.up, view.forward));
    uvec3 turned = splat_packed(across * shape.axes[2], across * shape.axes[0]);
    return uintBitsToFloat((floatBitsToUint(packed) & 0xFFFF0000u) | turned);
}

// A Gaussian along a ray: z of its centre; its deviation, in lengths of the ray's direction; the squared distance from its centre to the
// nearest point of the ray, in deviations.
struct SplatRay {
    float middle;
    float deviation;
    float square;
};

// The point of the ray nearest to the centre is found first: a far origin then costs no precision in the division by small deviations.
SplatRay splat_ray(Ray ray, vec3 position, float radius, vec3 packed) {
    SplatShape shape = splat_shape(radius, packed);
    vec3 offset = position - ray.origin;
    float nearest = dot(offset, ray.direction) / dot(ray.direction, ray.direction);
    vec3 across = offset - nearest * ray.direction, per_deviation = 1.0 / shape.deviations;
    vec3 v = vec3(dot(shape.axes[0], ray.direction), dot(shape.axes[1], ray.direction), dot(shape.axes[2], ray.direction));
    vec3 q = vec3(dot(shape.axes[0], across), dot(shape.axes[1], across), dot(shape.axes[2], across));
    v *= per_deviation;
    q *= per_deviation;
    float square = dot(v, v);
    vec3 apart = cross(q, v);
    return SplatRay(nearest + dot(q, v) / square, inversesqrt(square), dot(apart, apart) / square);
}

// Length, in lengths of the ray's direction, over which the extinction at the splat's centre gives the ray's whole optical depth.
float splat_length(SplatRay along) { return SPLAT_WHOLE * ROOT_TWO_PI * along.deviation * exp(-0.5 * along.square); }

// Cumulative distribution function of a unit Gaussian, by Abramowitz and Stegun 26.2.17; the error bound is 7.5e-8.
float splat_share(float x) {
    float t = 1.0 / (1.0 + 0.2316419 * abs(x));
    float tail = exp(-0.5 * x * x) * t * (0.12741480 + t * (-0.14224837 + t * (0.71070687 + t * (-0.72657601 + t * 0.53070271))));
    return x < 0.0 ? tail : 1.0 - tail;
}

// Half the ray's chord within SPLAT_REACH.
float splat_half(SplatRay along) { return sqrt(max(SPLAT_REACH * SPLAT_REACH - along.square, 0.0)) * along.deviation; }

// Extent of a Gaussian's ellipsoid, given in the view's axes, in the form of sphere_extent: low to high along right (x, y) and along up (z,
// w). In perspective the bounds are the two planes through the eye that touch the ellipsoid.
vec4 splat_extent(View view, vec3 centre, float radius, vec3 packed) {
    SplatShape shape = splat_shape(radius, packed);
    mat3 rows = transpose(mat3(shape.axes[0], shape.axes[1], shape.axes[2]));
    vec3 x = rows[0] * shape.deviations * SPLAT_REACH, y = rows[1] * shape.deviations * SPLAT_REACH;
    vec3 z = rows[2] * shape.deviations * SPLAT_REACH;
    if (view.projection != VIEW_PERSPECTIVE) {
        vec2 reach = vec2(length(x), length(y));
        return vec4(centre.x - reach.x, centre.x + reach.x, centre.y - reach.y, centre.y + reach.y);
    }
    float deep = dot(z, z), square = centre.z * centre.z - deep;
    if (centre.z <= 0.0 || square <= 1e-3 * deep) {
        return vec4(-1e9, 1e9, -1e9, 1e9);
    }
    vec3 by_x = x * centre.z - z * centre.x, by_y = y * centre.z - z * centre.y, of_x = cross(x, z), of_y = cross(y, z);
    vec2 middle = centre.xy * centre.z - vec2(dot(x, z), dot(y, z));
    vec2 half_wide = sqrt(max(vec2(dot(by_x, by_x) - dot(of_x, of_x), dot(by_y, by_y) - dot(of_y, of_y)), 0.0));
    vec2 low = (middle - half_wide) / square, high = (middle + half_wide) / square;
    return vec4(low.x, high.x, low.y, high.y);
}
#endif
