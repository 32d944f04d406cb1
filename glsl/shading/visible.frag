#version 460
// Writes the number of the triangle that each pixel sees, counted from 1; 0 is the sky. gbuffer.comp derives albedo, normal and z from it,
// once per pixel. Source: Burns and Hunt 2013, The visibility buffer. Input: the triangle's number. Output: the same number.
layout(location = 0) flat in uint number;
layout(location = 0) out uint seen;

void main() { seen = number; }
