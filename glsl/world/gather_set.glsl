// Buffers of the passes that turn the caller's buffer into casters.
#ifndef WORLD_GATHER_SET_GLSL
#define WORLD_GATHER_SET_GLSL
#include "world/gather.glsl"

// set 0: gather_casters
layout(set = 0, binding = 0, scalar) readonly buffer GatherTheirs { uint theirs[]; };
layout(set = 0, binding = 1, scalar) readonly buffer GatherCounts { uint counts[]; };
// Two vectors per caster, so that a caster is written with two stores.
layout(set = 0, binding = 2, scalar) writeonly buffer GatherCasters { uvec4 casters[]; };
layout(set = 0, binding = 3, scalar) buffer GatherCounted { GatherTotals counted; };

uvec3 three(uint at) { return uvec3(theirs[at], theirs[at + 1u], theirs[at + 2u]); }
#endif
