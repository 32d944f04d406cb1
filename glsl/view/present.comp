#version 460
// Writes the window's picture as bytes. It shows one of two pictures, both pictures with a wipe between them, the difference of the two,
// values from the host or a slice, or panels that compare both with the truth. Inputs: two pictures in linear light; for each of the 256
// sRGB bytes, the least number that maps to it; the values. Output: one byte per channel, four per pixel, rows from the top.
// Twin: view::present::bytes. Invariant: the bytes equal those of scene::Picture::to_srgb8, since both find the last level that a number
// reaches.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = 8, local_size_y = 8) in;

// set 0: view_present
layout(set = 0, binding = 0) uniform texture2D first_picture;
layout(set = 0, binding = 1) uniform texture2D second_picture;
layout(set = 0, binding = 2, scalar) readonly buffer Levels { float levels[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Values { float values[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Shown { uint shown[]; };

// Twins: view::state::Show.
const uint FIRST = 0u, SECOND = 1u, WIPE = 2u, DIFFERENCE = 3u, SLICE = 4u, PAINTED = 5u, BESIDE = 7u;

// The third picture, besides A and B.
const uint TRUTH = 2u;
// Twins: view::present::PANELS.
const uint COLUMNS = 3u, ROWS = 2u;

// Color in place of an empty picture.
const uvec3 NOBODY = uvec3(40u);

layout(push_constant, scalar) uniform PresentPush {
    uint width;
    uint height;
    uint show;
    uint wipe;    // first column of the second picture
    uint gain;    // factor that differences are multiplied by
    uint sources;        // two bits each for the first picture, the second and the truth: 1 if it comes from the values, 2 if empty
    uint blue_first;     // 1: bytes in the order blue, green, red
};

uint level(float value) {
    uint at = 0u;
    for (uint half_of = 128u; half_of > 0u; half_of >>= 1u) {
        at += value >= levels[at + half_of] ? half_of : 0u;
    }
    return at;
}

uvec3 bytes(vec3 color) {
    return uvec3(level(color.r), level(color.g), level(color.b));
}

// Returns the size of a picture, in pixels.
uvec2 size() {
    return show == BESIDE ? max(uvec2(width / COLUMNS, height / ROWS), 1u) : uvec2(width, height);
}

// Returns the two bits of `sources` for a picture.
uint source_of(uint which) {
    return sources >> 2u * which & 3u;
}

// Returns a pixel of A, B or the truth.
uvec3 picture(uint which, uvec2 pixel) {
    uint source = source_of(which);
    if ((source & 2u) != 0u) {
        return NOBODY;
    }
    if ((source & 1u) != 0u) {
        uint at = 3u * (pixel.y * size().x + pixel.x);
        return bytes(vec3(values[at], values[at + 1u], values[at + 2u]));
    }
    return bytes(which == 1u ? texelFetch(second_picture, ivec2(pixel), 0).rgb
                             : texelFetch(first_picture, ivec2(pixel), 0).rgb);
}

uvec3 difference(uint which, uint other, uvec2 pixel) {
    if (((source_of(which) | source_of(other)) & 2u) != 0u) {
        return NOBODY;
    }
    ivec3 apart = abs(ivec3(picture(which, pixel)) - ivec3(picture(other, pixel)));
    return min(uvec3(apart) * gain, uvec3(255u));
}

// Shows A, the truth and B in a row. Below A and B are their differences from the truth, and between those the difference of A and B.
uvec3 beside(uvec2 pixel) {
    uvec2 panel = pixel / size(), inside = pixel % size();
    if (panel.x >= COLUMNS || panel.y >= ROWS) {
        return NOBODY;
    }
    if (panel.y == 0u) {
        return picture(panel.x == 0u ? 0u : panel.x == 1u ? TRUTH : 1u, inside);
    }
    return difference(panel.x == 2u ? 1u : 0u, panel.x == 1u ? 1u : TRUTH, inside);
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= width || pixel.y >= height) {
        return;
    }
    uint at = pixel.y * width + pixel.x;
    uvec3 is;
    if (show == SLICE) {
        // The slice is a square, in the upper left.
        uint side = min(width, height);
        bool inside = pixel.x < side && pixel.y < side;
        is = inside ? bytes(vec3(values[pixel.y * side + pixel.x])) : uvec3(0u);
    } else if (show == PAINTED) {
        uint painted = floatBitsToUint(values[at]);
        is = uvec3(painted, painted >> 8, painted >> 16) & 255u;
    } else if (show == DIFFERENCE) {
        is = difference(0u, 1u, pixel);
    } else if (show == BESIDE) {
        is = beside(pixel);
    } else {
        is = picture(show == SECOND || show == WIPE && pixel.x >= wipe ? 1u : 0u, pixel);
    }
    is = blue_first == 1u ? is.bgr : is.rgb;
    shown[at] = is.r | is.g << 8 | is.b << 16 | 255u << 24;
}
