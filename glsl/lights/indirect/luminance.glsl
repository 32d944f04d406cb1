// How a color weighs where one number stands for it.
#ifndef LIGHTS_INDIRECT_LUMINANCE_GLSL
#define LIGHTS_INDIRECT_LUMINANCE_GLSL

// Luminance by Rec. 709.
float luminance(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }
#endif
