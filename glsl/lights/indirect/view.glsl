// The points that the camera sees, and how much of a patch's light reaches them. Sources: Ritschel et al. 2011 (weighting the texels of a
// reflective shadow map by what is seen); Wallace, Elmquist and Haines 1989 (light between a point and a disc). Twin:
// reference::twin::indirect::importance.
#ifndef LIGHTS_INDIRECT_VIEW_GLSL
#define LIGHTS_INDIRECT_VIEW_GLSL
#extension GL_EXT_scalar_block_layout : require

// Points across and down the picture, evenly spaced. Twin: lights::indirect::POINTS_ACROSS.
const uint POINTS_ACROSS = 16u;
const uint POINTS = POINTS_ACROSS * POINTS_ACROSS;

// Twin: lights::indirect::ViewPointData.
struct ViewPoint {
    vec3 position;
    float area;     // area of the surface that the point represents, over pi
    vec3 normal;    // of unit length; on the outside of closed meshes
    float weight;   // luminance of the albedo; 0 if the camera sees no mesh
    uint is_open;   // 1: lit from either side
};

// Returns the light that a patch of flux 1 sends to a point, without occlusion. `area`: the patch's area, over pi. Patch and point are
// treated as discs, which bounds the result.
float light_to(ViewPoint point, vec3 position, vec3 normal, float area) {
    vec3 offset = point.position - position;
    float squared = dot(offset, offset);
    if (point.weight <= 0.0 || squared <= 0.0) {
        return 0.0;
    }
    float sent = max(dot(offset, normal), 0.0), met = -dot(offset, point.normal);
    met = point.is_open != 0u ? abs(met) : max(met, 0.0);
    return point.weight * (sent / squared) * (met / (squared + point.area + area));
}
#endif
