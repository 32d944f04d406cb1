// A sparse grid of densities along a ray: blocks of 8³ cells that are not empty, found by a hash, and the cells in them, one behind the
// other. Between its samples density is trilinear. Source: Amanatides and Woo 1987. Twins: scene::Field, reference::truth::volume.
#ifndef WORLD_FIELD_GLSL
#define WORLD_FIELD_GLSL
#include "world/view.glsl"

// Where a field stands, and where its parts are among those of all fields.
struct FieldPlace {
    vec3 origin;        // of its lowest sample, world units
    float extinction;   // of density 1, 1 / world unit
    vec3 rows[3];       // samples per world unit, along each of its axes
    vec3 size;          // samples from its lowest to its highest
    uint first_slot;
    vec3 color;         // albedo
    uint last_slot;     // slots, a power of 2, less 1
    uint first_block;
};

// A slot of the hash, where a block may be.
struct FieldSlot {
    uvec3 block;  // its lowest sample, in blocks from the field's lowest
    uint number;  // among the blocks of its field, from 1; 0: none is here
};

const int FIELD_SIDE = 8;
// Samples of a block: corners of its cells.
const uint FIELD_CORNERS = 9u;
const uint FIELD_SAMPLES = 729u;

// The ray in samples, from the lowest one; z stays as it was.
Ray field_ray(FieldPlace place, Ray ray) {
    vec3 offset = ray.origin - place.origin;
    return Ray(vec3(dot(offset, place.rows[0]), dot(offset, place.rows[1]), dot(offset, place.rows[2])),
               vec3(dot(ray.direction, place.rows[0]), dot(ray.direction, place.rows[1]), dot(ray.direction, place.rows[2])));
}

// If a ray's direction has no more than this along an axis, the ray counts as parallel to the other two axes: within a field it never
// leaves a cube along that axis.
float field_still(vec3 direction) {
    vec3 each = abs(direction);
    return 1e-9 * max(each.x, max(each.y, each.z));
}

// Narrows `z` to the part of the ray that lies in the box from 0 to `size`. False where the ray misses the box.
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

// Where the first slot for a block is looked for. Twin: shading::volumes.
uint field_hash(uvec3 block) { return block.x * 73856093u ^ block.y * 19349663u ^ block.z * 83492791u; }

// Cubes of side 1 along a ray.
struct FieldWalk {
    ivec3 cube;
    float z;
    float end;
};

FieldWalk field_walk(Ray ray, vec2 z) { return FieldWalk(ivec3(floor(ray.origin + z.x * ray.direction)), z.x, z.y); }

// The next cube, and z where it begins and where it ends, which may be the same; false where there is none.
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

// The trilinear density between eight corners, x first.
float field_density(float corners[8], vec3 at) {
    vec4 along = mix(vec4(corners[0], corners[2], corners[4], corners[6]), vec4(corners[1], corners[3], corners[5], corners[7]), at.x);
    vec2 across = mix(along.xz, along.yw, at.y);
    return mix(across.x, across.y, at.z);
}
#endif
