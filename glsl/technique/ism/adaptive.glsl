// The points that a light takes if their density adapts to its view. The pool is ordered along a curve over all triangles, so that CLUSTER
// consecutive points are close to each other. The cluster's rank for a light determines how many of its points the light takes. Sources:
// Ritschel et al. 2011, Making imperfect shadow maps view-adaptive; the curve and the clusters are ours. Twin:
// reference::twin::ism::adapt.
#ifndef TECHNIQUE_ISM_ADAPTIVE_GLSL
#define TECHNIQUE_ISM_ADAPTIVE_GLSL
#include "technique/ism/points.glsl"
#include "technique/ism/splat.glsl"

// Points per cluster. A light that takes `points` points chooses them from points · SUBSETS / CLUSTER clusters.
const uint CLUSTER = 64u;
const uint CLUSTER_BITS = 6u;

// Twin: technique::ClusterData.
struct IsmCluster {
    vec3 middle;
    float reach;   // distance from the middle to the farthest point
    vec3 normal;   // mean normal of the points; 0 if the normals point in all directions
    float spread;  // greatest deviation of a point's normal from the mean
    vec3 sides;    // half-extents of an axis-aligned box around the middle that contains all points
    float thick;   // greatest distance of a point from the plane through the middle
    uint closed;   // whether all points are on closed meshes
};

// Code of a point that a light takes. Lower TAKEN_BITS bits: the point's index in the pool. Upper bits: how many times the area of the
// point's cluster is halved to give the area that the point represents.
const uint TAKEN_BITS = 18u;
const uint UNTAKEN = 0xffffffffu;

// Maximum distance that a point's disc may extend beyond the box of its cluster's points: MARGIN_POOL times the radius that points have if
// all represent equal areas, a measure of the pool's spacing, plus MARGIN_OWN times the point's own radius.
const float MARGIN_POOL = 0.05;
const float MARGIN_OWN = 0.1;

uint taken_index(uint code) { return code & ((1u << TAKEN_BITS) - 1u); }

// Returns the radius of a point that a light takes. `radius`: the radius that points have if all represent equal areas and a light takes
// CLUSTER / SUBSETS points from each cluster.
float taken_radius(uint code, float radius) {
    uint halved = code >> TAKEN_BITS;
    precise float share = radius * ((halved & 1u) != 0u ? 1.41421356 : 2.0);
    return share / float(1u << (halved >> 1u));
}

// Returns the box at which the discs of a cluster's points are cut off. `radius`: the discs' radius. `usual`: the radius if all points
// represent equal areas.
Bounds taken_bounds(IsmCluster cluster, float radius, float usual) {
    precise vec3 sides = cluster.sides + (MARGIN_POOL * usual + MARGIN_OWN * radius);
    return Bounds(cluster.middle, sides);
}
#endif
