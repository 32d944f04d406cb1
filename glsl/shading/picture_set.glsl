// The descriptor sets of a picture; a shader names the resources that it reads. Bound by shading::Renderer.
// set 0: picture_scene
// set 2: picture_surfaces
#ifndef CONSUME_PICTURE_SET_GLSL
#define CONSUME_PICTURE_SET_GLSL
#define PICTURE_LIGHTS layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
#define PICTURE_CAMERA layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
#define PICTURE_TRIANGLES layout(set = 0, binding = 2, scalar) readonly buffer Triangles { Triangle triangles[]; };
#define PICTURE_CASTERS layout(set = 0, binding = 3, scalar) readonly buffer Casters { Caster casters[]; };
// Casters, far to near.
#define PICTURE_ORDER layout(set = 0, binding = 4, scalar) readonly buffer Order { uint order[]; };
// The side of each triangle: see world::Generations::sides.
#define PICTURE_SIDES layout(set = 0, binding = 5, scalar) readonly buffer Sides { int sides[]; };
// The index of the first splat, sheet or cell among the casters, then the colors of all of these, three floats each.
#define PICTURE_SPLATS layout(set = 0, binding = 6, scalar) readonly buffer Splats { uint splats[]; };
// The G-buffer of the meshes: albedo (alpha 0: the sky), normal (w: closed), z.
#define SURFACE_ALBEDOS layout(set = 2, binding = 0) uniform texture2D albedos;
#define SURFACE_NORMALS layout(set = 2, binding = 1) uniform texture2D normals;
#define SURFACE_DISTANCES layout(set = 2, binding = 2) uniform texture2D distances;
#endif
