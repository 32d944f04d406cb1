// Which points a light takes where their density is adapted to its view. The pool stands in order along a curve over all triangles, so that
// CLUSTER consecutive points lie next to each other. The number of points that a light takes from a cluster follows the cluster's rank for
// it. Sources: Ritschel et al. 2011, Making imperfect shadow maps view-adaptive; the curve and the clusters are ours. Twin:
// reference::twin::ism::adapt.
#ifndef TECHNIQUE_ISM_ADAPTIVE_GLSL
#define TECHNIQUE_ISM_ADAPTIVE_GLSL
#include "technique/ism/points.glsl"
#include "technique/ism/splat.glsl"

// Points of a cluster; a light takes points, so that it has points · SUBSETS / CLUSTER clusters to take them from.
const uint CLUSTER = 64u;
const uint CLUSTER_BITS = 6u;

// Twin: technique::ClusterData.
struct IsmCluster {
    vec3 middle;
    float reach;   // of the farthest point from there
    vec3 normal;   // the mean; none where they have none
    float spread;  // of a normal from the mean, at most
    vec3 sides;    // half the sides of the box about the middle, along the world's axes, that all of them are in
    float thick;   // of a point from the plane through the middle, at most
    uint closed;   // whether all are of closed things
};

// A point that is taken: where it stands in the pool, and how often the area of its cluster was halved to get that which it stands for.
const uint TAKEN_BITS = 18u;
const uint UNTAKEN = 0xffffffffu;

// How far beside its cluster's points a disc may reach: parts of the radius of a point where all stand for equal areas, as which the
// pool's points lie apart, and of its own.
const float MARGIN_POOL = 0.05;
const float MARGIN_OWN = 0.1;

uint taken_index(uint code) { return code & ((1u << TAKEN_BITS) - 1u); }

// `radius`: of a point where all stand for equal areas, SUBSETS to a cluster's CLUSTER.
float taken_radius(uint code, float radius) {
    uint halved = code >> TAKEN_BITS;
    precise float share = radius * ((halved & 1u) != 0u ? 1.41421356 : 2.0);
    return share / float(1u << (halved >> 1u));
}

// What a disc of that radius ends at: `usual` is the radius where all points stand for equal areas.
Bounds taken_bounds(IsmCluster cluster, float radius, float usual) {
    precise vec3 sides = cluster.sides + (MARGIN_POOL * usual + MARGIN_OWN * radius);
    return Bounds(cluster.middle, sides);
}
#endif
