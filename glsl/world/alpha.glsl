// Alpha of triangles: holes that a texture cuts out, and glass. It is stored behind the triangles, in the same buffer: first a word per
// triangle, the number of its record plus 1, or 0 if the triangle is opaque; then records of the size of a triangle; then textures, a byte
// per texel. Define ALPHA_TRIANGLES as the array of triangles, and ALPHA_ROWS if its elements are TriangleRows. Twin: world::alpha,
// reference::twin::alpha.
#ifndef WORLD_ALPHA_GLSL
#define WORLD_ALPHA_GLSL

// Capacity of the buffer in triangles, behind which alpha is stored; 0 if no triangle has alpha.
CONSTANT(uint, ALPHA_FIRST, 0u)

// Words per triangle, and per record.
const uint ALPHA_WORDS = 12u;
// The cutoff of see-through triangles, which no alpha reaches.
const float ALPHA_SEE_THROUGH = 2.0;

struct Alpha {
    vec2 uvs[3];
    float factors[3];
    float cutoff;
    uint texels;  // word of the texture's first texel; 0 without a texture
    uint size;    // width - 1: 14 bits, height - 1: 14 bits, ALPHA_REPEAT and so on: 2 bits across, 2 bits down
};

const uint ALPHA_REPEAT = 0u;
const uint ALPHA_MIRROR = 1u;
const uint ALPHA_CLAMP = 2u;

uint alpha_word(uint at) {
    uint element = at / ALPHA_WORDS, word = at % ALPHA_WORDS;
#ifdef ALPHA_ROWS
    return floatBitsToUint(ALPHA_TRIANGLES[element].rows[word >> 2u][word & 3u]);
#else
    uint row = word / 3u, column = word - 3u * row;
    return floatBitsToUint(row < 3u ? ALPHA_TRIANGLES[element].corners[min(row, 2u)][column]
                                    : ALPHA_TRIANGLES[element].albedo[column]);
#endif
}

// Number of a triangle's record plus 1; 0 if the triangle is opaque.
uint alpha_number(uint triangle) { return ALPHA_FIRST == 0u ? 0u : alpha_word(ALPHA_WORDS * ALPHA_FIRST + triangle); }

// The record of this number, which is not 0.
Alpha alpha_record(uint number) {
    uint at = ALPHA_FIRST + (ALPHA_FIRST + ALPHA_WORDS - 1u) / ALPHA_WORDS + number - 1u;
    Alpha alpha;
#ifdef ALPHA_ROWS
    vec4 a = ALPHA_TRIANGLES[at].rows[0], b = ALPHA_TRIANGLES[at].rows[1], c = ALPHA_TRIANGLES[at].rows[2];
    alpha.uvs = vec2[3](a.xy, a.zw, b.xy);
    alpha.factors = float[3](b.z, b.w, c.x);
    alpha.cutoff = c.y;
    alpha.texels = floatBitsToUint(c.z);
    alpha.size = floatBitsToUint(c.w);
#else
    Triangle record = ALPHA_TRIANGLES[at];
    alpha.uvs = vec2[3](record.corners[0].xy, vec2(record.corners[0].z, record.corners[1].x), record.corners[1].yz);
    alpha.factors = float[3](record.corners[2].x, record.corners[2].y, record.corners[2].z);
    alpha.cutoff = record.albedo.x;
    alpha.texels = floatBitsToUint(record.albedo.y);
    alpha.size = floatBitsToUint(record.albedo.z);
#endif
    return alpha;
}

// Place in the texture along one axis, in texels from the centre of the first, and the two texels about it.
float alpha_place(float at, int size, uint wrap, out ivec2 texels) {
    precise float whole = floor(at), within = at - whole;
    if (wrap == ALPHA_MIRROR) {
        // An even repetition runs forwards, an odd one backwards.
        within = (int(whole) & 1) != 0 ? 1.0 - within : within;
    }
    within = wrap == ALPHA_CLAMP ? clamp(at, 0.0, 1.0) : within;
    precise float place = within * float(size) - 0.5;
    int first = int(floor(place));
    texels = ivec2(first, first + 1);
    if (wrap == ALPHA_REPEAT) {
        texels = ivec2(first < 0 ? size - 1 : first, first + 1 >= size ? 0 : first + 1);
    }
    texels = clamp(texels, ivec2(0), ivec2(size - 1));
    return place - floor(place);
}

// Two texels of a row, mostly of one word.
vec2 alpha_texels(Alpha alpha, int width, ivec2 columns, int row) {
    uvec2 at = uint(row) * uint(width) + uvec2(columns), words = at >> 2u;
    uint left = alpha_word(alpha.texels + words.x);
    uint right = words.y == words.x ? left : alpha_word(alpha.texels + words.y);
    return vec2(uvec2(left, right) >> (8u * (at & 3u)) & 255u);
}

// The texture's alpha at a place, 0 to 1, bilinearly between the centres of four texels.
float alpha_texture(Alpha alpha, vec2 uv) {
    int width = int(alpha.size & 0x3fffu) + 1, height = int(alpha.size >> 14u & 0x3fffu) + 1;
    ivec2 columns, rows;
    precise float x = alpha_place(uv.x, width, alpha.size >> 28u & 3u, columns);
    precise float y = alpha_place(uv.y, height, alpha.size >> 30u, rows);
    vec2 upper = alpha_texels(alpha, width, columns, rows.x), lower = alpha_texels(alpha, width, columns, rows.y);
    precise float above = upper.x + x * (upper.y - upper.x), below = lower.x + x * (lower.y - lower.x);
    precise float mean = (above + y * (below - above)) * (1.0 / 255.0);
    return mean;
}

// Alpha at a point of the triangle. `at`: the weights of its second and third corners.
float alpha_value(Alpha alpha, vec2 at) {
    precise float factor = alpha.factors[0] + at.x * (alpha.factors[1] - alpha.factors[0]) +
                           at.y * (alpha.factors[2] - alpha.factors[0]);
    if (alpha.texels != 0u) {
        precise vec2 uv = alpha.uvs[0] + at.x * (alpha.uvs[1] - alpha.uvs[0]) + at.y * (alpha.uvs[2] - alpha.uvs[0]);
        factor *= alpha_texture(alpha, uv);
    }
    return factor;
}

// Whether the point blocks all light: not in a hole, and not see-through. `at`: see alpha_value.
bool alpha_blocks(uint triangle, vec2 at) {
    uint number = alpha_number(triangle);
    if (number == 0u) {
        return true;
    }
    Alpha alpha = alpha_record(number);
    return alpha_value(alpha, at) >= alpha.cutoff;
}

// Whether light passes through the whole triangle: it is see-through.
bool alpha_sees_through(uint triangle) {
    uint number = alpha_number(triangle);
    return number != 0u && alpha_record(number).cutoff == ALPHA_SEE_THROUGH;
}

#ifdef EXACT
#include "maps/exact.glsl"
float alpha_reciprocal(float a) { return reciprocal(a); }
#else
float alpha_reciprocal(float a) { return 1.0 / a; }
#endif

// A triangle's plane: at an offset from the first corner, the weights of the second and third corners are its products with these vectors.
struct AlphaPlane {
    vec3 first, second, third;
};

// Undefined for a triangle without an area.
AlphaPlane alpha_plane(vec3 corners[3]) {
    precise vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    precise vec3 normal = vec3(ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x);
    precise vec3 b = vec3(ac.y * normal.z - ac.z * normal.y, ac.z * normal.x - ac.x * normal.z, ac.x * normal.y - ac.y * normal.x);
    precise vec3 c = vec3(normal.y * ab.z - normal.z * ab.y, normal.z * ab.x - normal.x * ab.z, normal.x * ab.y - normal.y * ab.x);
    precise float square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    float inverse = alpha_reciprocal(square);
    precise vec3 second = b * inverse, third = c * inverse;
    return AlphaPlane(corners[0], second, third);
}

// Weights of a triangle's second and third corners at a point of its plane.
vec2 alpha_weights(AlphaPlane plane, vec3 point) {
    precise vec3 offset = point - plane.first;
    precise float of_b = offset.x * plane.second.x + offset.y * plane.second.y + offset.z * plane.second.z;
    precise float of_c = offset.x * plane.third.x + offset.y * plane.third.y + offset.z * plane.third.z;
    return vec2(of_b, of_c);
}

vec2 alpha_weights(vec3 corners[3], vec3 point) { return alpha_weights(alpha_plane(corners), point); }
#endif
