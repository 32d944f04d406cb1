// The per-texel lists of all segments. Source: Fife and Strugar 2013, Capturing fragments. Twin: maps::SegmentData.
#ifndef MAPS_LIST_SEGMENTS_GLSL
#define MAPS_LIST_SEGMENTS_GLSL

const uint NO_SEGMENT = 0xFFFFFFFFu;

// Indices of a build's counters. CUT_SHORT: not 0 if the driver ended loops over a list too early (maps/rounds.glsl). From FRAGMENTS on:
// for each group of maps that are captured together, the number of its fragments.
const uint CUT_SHORT = 0u;
const uint FRAGMENTS = 1u;

struct Segment {
    float entry;
    float exit;
    float optical_depth;
    uint next;  // or NO_SEGMENT
};

// A segment as stored in memory, to be read and written at once; .w is the link.
uvec4 segment_words(Segment s) { return uvec4(floatBitsToUint(vec3(s.entry, s.exit, s.optical_depth)), s.next); }

Segment segment_of(uvec4 words) {
    vec3 values = uintBitsToFloat(words.xyz);
    return Segment(values.x, values.y, values.z, words.w);
}
#endif
