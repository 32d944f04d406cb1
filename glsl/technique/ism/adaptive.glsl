// Which points a light takes where their density is adapted to its view. The pool of points is in order along a curve over all triangles,
// so that CLUSTER consecutive points lie next to each other. The number of points that a light takes from a cluster follows the cluster's
// rank for it. Sources: Ritschel et al. 2011, Making imperfect shadow maps view-adaptive; the curve and the clusters are ours. Twin:
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
    float reach;   // distance from the middle to the farthest point
    vec3 normal;   // the points' mean normal; 0 where normals point to all sides
    float spread;  // the most by which a point's normal is off the mean
    vec3 sides;    // half the sides of a box around the middle, along the world's axes, that holds all points
    float thick;   // the most by which a point is off the plane through the middle
    uint closed;   // whether all points are on closed meshes
};

// The code of a point that a light takes. The lower TAKEN_BITS bits: the point's place in the pool. The bits above: how many times the area
// of the point's cluster is halved to give the area that the point stands for.
const uint TAKEN_BITS = 18u;
const uint UNTAKEN = 0xffffffffu;

// How far a point's disc may reach past the box of its cluster's points: the sum of two shares. MARGIN_POOL is a share of the radius that
// points have where all points stand for equal areas, which says how far apart the pool's points lie. MARGIN_OWN is a share of the point's
// own radius.
const float MARGIN_POOL = 0.05;
const float MARGIN_OWN = 0.1;

uint taken_index(uint code) { return code & ((1u << TAKEN_BITS) - 1u); }

// The radius of a point that a light takes. `radius`: the radius that points have where all points stand for equal areas and a light takes
// CLUSTER / SUBSETS points from each cluster.
float taken_radius(uint code, float radius) {
    uint halved = code >> TAKEN_BITS;
    precise float share = radius * ((halved & 1u) != 0u ? 1.41421356 : 2.0);
    return share / float(1u << (halved >> 1u));
}

// The box that holds a cluster's points and their discs of that radius. `usual`: the radius where all points stand for
// equal areas.
Bounds taken_bounds(IsmCluster cluster, float radius, float usual) {
    precise vec3 sides = cluster.sides + (MARGIN_POOL * usual + MARGIN_OWN * radius);
    return Bounds(cluster.middle, sides);
}
#endif
