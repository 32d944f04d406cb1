// Walks through a sparse grid of densities along a ray: through the blocks of 8³ cells that are not empty, found by a hash, and through the
// cells in each. Between its samples density is trilinear. Source: Amanatides and Woo 1987. Twins: scene::Field, reference::truth::volume.
#ifndef WORLD_FIELD_GLSL
#define WORLD_FIELD_GLSL
#include "world/view.glsl"

// Placement of a field, and the positions of its parts in the buffers of all fields.
struct FieldPlace {
    vec3 origin;        // position of its minimum corner, world units
    float extinction;   // extinction of density 1, 1 / world unit
    vec3 rows[3];       // samples per world unit, along each of the field's axes
    vec3 size;          // distance from its minimum corner to its maximum corner, in samples
    uint first_slot;
    vec3 color;         // albedo
    uint last_slot;     // number of slots, a power of 2, minus 1
    uint first_block;
};

// A slot of the hash table, which may hold a block.
struct FieldSlot {
    uvec3 block;  // position of its minimum corner, in blocks from the field's minimum corner
    uint number;  // index among the field's blocks, counted from 1; 0: the slot is empty
};

const int FIELD_SIDE = 8;
// Samples per side of a block, the corners of its cells; and samples per block.
const uint FIELD_CORNERS = 9u;
const uint FIELD_SAMPLES = 729u;

// The ray in samples, relative to the field's minimum corner; z is unchanged.
Ray field_ray(FieldPlace place, Ray ray) {
    vec3 offset = ray.origin - place.origin;
    return Ray(vec3(dot(offset, place.rows[0]), dot(offset, place.rows[1]), dot(offset, place.rows[2])),
               vec3(dot(ray.direction, place.rows[0]), dot(ray.direction, place.rows[1]), dot(ray.direction, place.rows[2])));
}

// A ray whose direction has at most this component along an axis counts as perpendicular to that axis: within a field it never leaves a
// cube along the axis.
float field_still(vec3 direction) {
    vec3 each = abs(direction);
    return 1e-9 * max(each.x, max(each.y, each.z));
}

// Narrows `z` to the part of the ray inside the box from 0 to `size`. Returns false if the ray misses the box.
bool field_clipped(Ray ray, vec3 size, inout vec2 z) {
    float still = field_still(ray.direction);
    for (uint i = 0u; i < 3u; ++i) {
        if (abs(ray.direction[i]) <= still) {
            if (ray.origin[i] < 0.0 || ray.origin[i] > size[i]) {
                return false;
            }
        } else {
            float low = -ray.origin[i] / ray.direction[i], high = (size[i] - ray.origin[i]) / ray.direction[i];
            z = vec2(max(z.x, min(low, high)), min(z.y, max(low, high)));
        }
    }
    return z.y > z.x;
}

// Hash of a block: where the search for its slot begins. Twin: shading::volumes.
uint field_hash(uvec3 block) { return block.x * 73856093u ^ block.y * 19349663u ^ block.z * 83492791u; }

// A walk through the cubes of side 1 along a ray.
struct FieldWalk {
    ivec3 cube;
    float z;
    float end;
};

FieldWalk field_walk(Ray ray, vec2 z) { return FieldWalk(ivec3(floor(ray.origin + z.x * ray.direction)), z.x, z.y); }

// Returns the next cube, and the z at which it begins and ends, which may be equal; false at the end of the ray.
bool field_next(Ray ray, inout FieldWalk walk, out ivec3 cube, out vec2 z) {
    if (walk.z >= walk.end) {
        return false;
    }
    bvec3 rises = greaterThan(ray.direction, vec3(0.0));
    vec3 ends = (vec3(walk.cube + ivec3(rises)) - ray.origin) / ray.direction;
    ends = mix(ends, vec3(FARTHEST), lessThanEqual(abs(ray.direction), vec3(field_still(ray.direction))));
    uint axis = ends.x <= ends.y && ends.x <= ends.z ? 0u : ends.y <= ends.z ? 1u : 2u;
    cube = walk.cube;
    z = vec2(walk.z, clamp(ends[axis], walk.z, walk.end));
    walk.z = z.y;
    walk.cube[axis] += rises[axis] ? 1 : -1;
    return true;
}

// Density interpolated trilinearly between eight corners, x varying fastest.
float field_density(float corners[8], vec3 at) {
    vec4 along = mix(vec4(corners[0], corners[2], corners[4], corners[6]), vec4(corners[1], corners[3], corners[5], corners[7]), at.x);
    vec2 across = mix(along.xz, along.yw, at.y);
    return mix(across.x, across.y, at.z);
}
#endif
