// Visibility per color, computed from the result of a look-up, for smoke and hair that absorb some colors more than others. The
// transmittance is raised to a power: the color's extinction as a multiple of the casters' own extinction. Meshes block all colors equally,
// so look-ups that see both also return the meshes' part separately. If all casters have the same ratio of extinctions this is exact (Beer
// and Lambert): one curve, three exponents. A technique that does not include this file sees meshes alone. Invariants: each color is
// between 0 and the meshes' visibility, and falls as its extinction rises; extinction 1 returns the result of the look-up, bit for bit.
#ifndef WORLD_COLORS_GLSL
#define WORLD_COLORS_GLSL
#define TECHNIQUE_COLORS

// Set by each look-up: the visibility with only meshes in the way.
float look_up_meshes = 1.0;

// Visibility in one color, from the look-up's result `visibility`. With extinction 0 only meshes block light, however dense the smoke is.
float color_left(float visibility, float extinction) {
    if (extinction == 1.0 || !(look_up_meshes > 0.0)) {
        return visibility;
    }
    // 0 to the power of 0 is undefined.
    return extinction > 0.0 ? look_up_meshes * pow(clamp(visibility / look_up_meshes, 0.0, 1.0), extinction) : look_up_meshes;
}

// Visibility in red, green and blue, from their extinctions and the last look-up's result `visibility`.
vec3 light_colors(float visibility, vec3 extinction) {
    return vec3(color_left(visibility, extinction.x), color_left(visibility, extinction.y), color_left(visibility, extinction.z));
}
#endif
