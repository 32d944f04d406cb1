// The faces of the cube around a light that shines in all directions. Twin: scene::Light::map_at.
#ifndef WORLD_FACE_GLSL
#define WORLD_FACE_GLSL

// The face +x, -x, +y, -y, +z or -z in the direction of the offset's largest component. On ties, at the cube's edges, the first of x, y, z
// wins.
uint cube_face(vec3 offset) {
    vec3 far = abs(offset);
    uint axis = far.x >= far.y && far.x >= far.z ? 0u : far.y >= far.z ? 1u : 2u;
    return 2u * axis + uint(offset[axis] < 0.0);
}
#endif
