// The per-texel lists of all segments. Source: Fife and Strugar 2013, Capturing fragments. Twin: maps::SegmentData.
#ifndef LIST_SEGMENTS_GLSL
#define LIST_SEGMENTS_GLSL

const uint NO_SEGMENT = 0xFFFFFFFFu;

struct Segment {
    float entry;
    float exit;
    float optical_depth;
    uint caster;
    uint next;  // or NO_SEGMENT
};
#endif
