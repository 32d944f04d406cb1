// Triangle edge functions in integer arithmetic. Source: Pineda 1988, with the top-left rule of rasterizers.
#ifndef MAPS_EDGE_GLSL
#define MAPS_EDGE_GLSL

// A 64-bit integer in two words: products of edge vectors have up to 52 bits.
struct Wide {
    int high;
    uint low;
};

Wide wide_cross(ivec2 a, ivec2 b) {
    int high, other_high, low, other_low;
    imulExtended(a.x, b.y, high, low);
    imulExtended(a.y, b.x, other_high, other_low);
    uint borrow;
    uint difference = usubBorrow(uint(low), uint(other_low), borrow);
    return Wide(high - other_high - int(borrow), difference);
}

// Whether a point exactly on the edge is inside: it belongs to exactly one of the two triangles that share the edge.
bool owns_edge(ivec2 edge) { return edge.y < 0 || (edge.y == 0 && edge.x > 0); }
#endif
