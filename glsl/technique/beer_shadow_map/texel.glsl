// Content of a texel, in half floats: 1 - front in red, back in green, the maximum optical depth in alpha. The mean extinction is the
// maximum optical depth over back - front. Red and green can be blended by maximum, and all channels are 0 without casters. With a weighted
// front, front and back are moved deeper by the same distance, which keeps the extinction. Twin: reference::twin::beer_shadow_map.
#ifndef TECHNIQUE_BEER_SHADOW_MAP_TEXEL_GLSL
#define TECHNIQUE_BEER_SHADOW_MAP_TEXEL_GLSL

vec4 beer_texel(vec2 depth, float optical_depth) { return vec4(1.0 - depth.x, depth.y, 0.0, optical_depth); }

// Returns the maximum optical depth. Many opaque casters exceed the range of a half float: alpha is then infinity, or on some drivers NaN.
float beer_most(vec4 texel) { return texel.a < 65504.0 ? texel.a : 65504.0; }

// Returns the optical depth from the light to `depth`.
float beer_optical_depth(vec4 texel, float depth) {
    float front = 1.0 - texel.r, extent = texel.g - front;
    // Compares first, so that a texel without extent is a step and not 0/0; a caster does not shadow its own depth.
    float share = depth >= texel.g ? 1.0 : depth <= front ? 0.0 : min((depth - front) / extent, 1.0);
    // Infinity times 0 would be NaN: beer_most bounds the factor.
    return beer_most(texel) * share;
}
#endif
