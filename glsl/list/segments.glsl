// The per-texel lists of all segments. Source: seed 000 (capturing fragments). Twin: technique::list::Segment.
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
