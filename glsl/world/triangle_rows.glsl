// A triangle (world/triangle.glsl), laid out so that look-ups read it in three loads instead of nine. Twin: world::TriangleData.
#ifndef WORLD_TRIANGLE_ROWS_GLSL
#define WORLD_TRIANGLE_ROWS_GLSL
#extension GL_EXT_scalar_block_layout : require

struct TriangleRows {
    vec4 rows[3];
};

vec3[3] triangle_corners(TriangleRows t) {
    return vec3[3](t.rows[0].xyz, vec3(t.rows[0].w, t.rows[1].xy), vec3(t.rows[1].zw, t.rows[2].x));
}
#endif
