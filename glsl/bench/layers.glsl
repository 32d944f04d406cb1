// A layer to composite over a pixel: a color that depends on the layer's index, premultiplied by its opacity. Twin: bench::raster_worth.
#ifndef MEASURE_LAYERS_GLSL
#define MEASURE_LAYERS_GLSL
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform LayersPush {
    uint layers;
    float opacity;
};

vec4 layer_color(uint layer) { return vec4(float(layer & 1u), float(layer >> 1u & 1u), float(layer >> 2u & 1u), 1.0) * opacity; }

vec4 over(vec4 behind, vec4 color) { return color + (1.0 - color.a) * behind; }
#endif
