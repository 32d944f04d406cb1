// Luminance of a color.
#ifndef LIGHTS_INDIRECT_LUMINANCE_GLSL
#define LIGHTS_INDIRECT_LUMINANCE_GLSL

// Returns the Rec. 709 luminance.
float luminance(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }
#endif
