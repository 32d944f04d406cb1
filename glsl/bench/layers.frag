#version 460
// Outputs a layer's color for blending. Inputs: the layer, push constants. Output: color.
#include "bench/layers.glsl"

layout(location = 0) flat in uint layer;
layout(location = 0) out vec4 color;

void main() { color = layer_color(layer); }
