// Visibility of each color from a look-up's answer, where smoke and hair absorb some colors more than others. The transmittance is raised
// to a power: the color's extinction as a multiple of the casters' own extinction. Meshes leave the same share of each color, so look-ups
// of both also return the meshes' part by itself. Where all casters have the same ratio of extinctions this is exact (Beer and Lambert):
// one curve, three exponents. A technique that does not include this file sees meshes alone. Invariants: each color is between 0 and the
// meshes' visibility, and falls with its extinction; extinction 1 gives the answer itself, to the bit.
#ifndef WORLD_COLORS_GLSL
#define WORLD_COLORS_GLSL
#define TECHNIQUE_COLORS

// Set by each look-up: the visibility past meshes alone.
float look_up_meshes = 1.0;

// Visibility in one color, from the answer `visibility`. With extinction 0 only meshes take light, however dark the smoke is.
float color_left(float visibility, float extinction) {
    if (extinction == 1.0 || !(look_up_meshes > 0.0)) {
        return visibility;
    }
    // 0 to the power of 0 is undefined.
    return extinction > 0.0 ? look_up_meshes * pow(clamp(visibility / look_up_meshes, 0.0, 1.0), extinction) : look_up_meshes;
}

// Visibility in red, green and blue, by their extinctions, from the last answer `visibility`.
vec3 light_colors(float visibility, vec3 extinction) {
    return vec3(color_left(visibility, extinction.x), color_left(visibility, extinction.y), color_left(visibility, extinction.z));
}
#endif
