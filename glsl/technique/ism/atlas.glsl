// Shared by the passes that fill maps. Twin: technique::ism::AtlasPush.
#ifndef TECHNIQUE_ISM_ATLAS_GLSL
#define TECHNIQUE_ISM_ATLAS_GLSL
#include "technique/ism/adaptive.glsl"
#include "technique/ism/splat.glsl"

layout(push_constant, scalar) uniform AtlasPush {
    uint light_count;
    uint points;  // points per light
};

// A shader that only reads must first define ATLAS_ACCESS as `readonly`: devices need not support writes in vertex shaders.
#ifndef ATLAS_ACCESS
#define ATLAS_ACCESS
#endif

// set 0: ism_atlas ism_raster
layout(set = 0, binding = 0, scalar) readonly buffer AtlasLights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer AtlasHead { IsmPoints head; };
layout(set = 0, binding = 2, scalar) readonly buffer AtlasPool { IsmPoint pool[]; };
layout(set = 0, binding = 3, scalar) coherent ATLAS_ACCESS buffer AtlasMaps { uint maps[]; };  // map by map
layout(set = 0, binding = 4, scalar) ATLAS_ACCESS buffer AtlasSeen { uint seen[]; };            // number of points that each light sees

layout(set = 0, binding = 5, scalar) readonly buffer AtlasTaken { uint taken[]; };  // with ISM_ADAPTIVE: codes of each light's points

layout(set = 0, binding = 6, scalar) readonly buffer AtlasClusters { IsmCluster clusters[]; };  // with ISM_ADAPTIVE

// Fetches the `i`-th point that a light takes, the radius of the point's disc, and the box at which the disc is cut off. Returns false if
// the light takes fewer points.
bool take(uint light, uint i, out IsmPoint point, out float radius, out Bounds bounds) {
    bounds = Bounds(vec3(0.0), vec3(0.0));
    if (!ISM_ADAPTIVE) {
        point = pool[point_of(light, i, points)];
        radius = head.radius;
        return true;
    }
    uint code = taken[light * points + i];
    if (code == UNTAKEN) {
        point = IsmPoint(vec3(0.0), 0u);
        radius = 0.0;
        return false;
    }
    point = pool[taken_index(code)];
    radius = taken_radius(code, head.radius);
    bounds = taken_bounds(clusters[taken_index(code) / CLUSTER], radius, head.radius);
    return true;
}

// Whether holes are filled.
CONSTANT(bool, ISM_FILL, true)

// Index of the workgroup; a macro, since only compute shaders have workgroups.
#define GROUP_INDEX (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x)
#endif
