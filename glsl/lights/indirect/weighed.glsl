// Buffers for weighting texels by how much of their light the camera sees. Bound by lights::indirect::Viewed.
#ifndef LIGHTS_INDIRECT_WEIGHED_GLSL
#define LIGHTS_INDIRECT_WEIGHED_GLSL
#extension GL_EXT_scalar_block_layout : require
#include "lights/indirect/view.glsl"

// set 3: indirect_weighed
layout(set = 3, binding = 0, scalar) readonly buffer ViewPoints { ViewPoint view_points[]; };
// Per texel: the light that it sends to all points in total, per unit of its flux.
layout(set = 3, binding = 1, scalar) buffer Importances { float importances[]; };
// Per row of texels: flux, and flux times importance.
layout(set = 3, binding = 2, scalar) buffer RowFluxes { vec2 row_fluxes[]; };
// The mean importance of all flux.
layout(set = 3, binding = 3, scalar) buffer MeanImportance { float mean_importance; };
#endif
