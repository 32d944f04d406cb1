// The faces of the cube around a light that shines all about. Twin: scene::Light::map_at.
#ifndef WORLD_FACE_GLSL
#define WORLD_FACE_GLSL

// The face +x, -x, +y, -y, +z or -z towards which an offset from the light is farthest. Where it is equally far, at the cube's
// edges, the first of x, y, z.
uint cube_face(vec3 offset) {
    vec3 far = abs(offset);
    uint axis = far.x >= far.y && far.x >= far.z ? 0u : far.y >= far.z ? 1u : 2u;
    return 2u * axis + uint(offset[axis] < 0.0);
}
#endif
