//! Twin of glsl/technique/ism/clusters.comp.

use super::map::{V3, dot, minus};
use super::splat::Point;

/// Number of points in a cluster. Twin: CLUSTER.
pub const CLUSTER: usize = 64;

/// Twin: IsmCluster.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// Centre of the points' bounding box, in world units.
    pub middle: V3,
    /// Distance of the farthest point from the centre.
    pub reach: f32,
    /// The mean normal, or 0 if the normals cancel out.
    pub normal: V3,
    /// Greatest distance between a point's normal and the mean normal.
    pub spread: f32,
    /// Half-extents of the points' bounding box, along the world axes.
    pub sides: V3,
    /// Greatest distance of a point from the plane through the centre.
    pub thick: f32,
    /// Whether all points lie on closed surfaces.
    pub closed: bool,
}

/// Computes the bounds and means of [`CLUSTER`] points.
pub fn cluster(points: &[Point]) -> Cluster {
    let bound = |of: fn(f32, f32) -> f32| {
        points.iter().map(|p| p.position).reduce(|a, b| [0, 1, 2].map(|i| of(a[i], b[i]))).unwrap_or_default()
    };
    let (low, high) = (bound(f32::min), bound(f32::max));
    let middle = [0, 1, 2].map(|i| 0.5 * (low[i] + high[i]));
    let mut sums: Vec<V3> = points.iter().map(|p| p.normal).collect();
    while sums.len() > 1 {
        let (first, second) = sums.split_at(sums.len() / 2);
        sums = first.iter().zip(second).map(|(a, b)| [0, 1, 2].map(|i| a[i] + b[i])).collect();
    }
    let sum = sums.first().copied().unwrap_or_default();
    let square = dot(sum, sum);
    let normal = if square > 1.0 { sum.map(|s| s / square.sqrt()) } else { [0.0; 3] };
    let most = |of: &dyn Fn(&Point) -> f32| points.iter().map(of).fold(0.0, f32::max);
    let length = |v: V3| dot(v, v).sqrt();
    Cluster {
        middle,
        reach: most(&|p| length(minus(p.position, middle))),
        normal,
        spread: most(&|p| length(minus(p.normal, normal))),
        sides: [0, 1, 2].map(|i| 0.5 * (high[i] - low[i])),
        thick: most(&|p| dot(normal, minus(p.position, middle)).abs()),
        closed: points.iter().all(|p| p.closed),
    }
}
