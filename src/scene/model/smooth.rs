//! Smooth normals for meshes, which store none. Used in presentation pictures.

use crate::scene::Mesh;
use crate::scene::model::view::vec;
use glam::DVec3;
use std::collections::HashMap;

/// An edge stays sharp if the angle between its triangles exceeds 30°; this is the cosine.
const EDGE: f64 = 0.866;

/// Returns the unit normals at each triangle's corners. Each is the area-weighted mean normal of all triangles that share the corner and
/// differ in orientation by less than a sharp edge's angle. 0 if the triangle has no area.
pub fn smooth_normals(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions.get(i as usize).copied().unwrap_or_default());
    // Adding 0 turns −0 into 0.
    let place = |p: [f32; 3]| p.map(|value| (value + 0.0).to_bits());
    let areas: Vec<DVec3> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = corners(t).map(vec);
            (b - a).cross(c - a)
        })
        .collect();
    let mut meeting: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        corners(triangle).into_iter().for_each(|corner| meeting.entry(place(corner)).or_default().push(i));
    }
    let smooth = |(i, triangle): (usize, &[u32; 3])| {
        let own = areas[i].normalize_or_zero();
        // Triangles may be wound either way, even within one surface.
        let with_own = |j: &usize| {
            let cosine = areas[*j].normalize_or_zero().dot(own);
            (cosine.abs() >= EDGE).then(|| areas[*j] * cosine.signum())
        };
        corners(triangle).map(|corner| {
            let sum: DVec3 = meeting[&place(corner)].iter().filter_map(with_own).sum();
            sum.normalize_or_zero().as_vec3().to_array()
        })
    };
    mesh.triangles.iter().enumerate().map(smooth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{cube, mesh};
    use glam::Vec3;

    /// A box keeps its sharp edges: every normal is along an axis.
    #[test]
    fn edges_stay() {
        for corner in smooth_normals(&cube([0.0; 3], 2.0)).into_iter().flatten() {
            let normal = Vec3::from(corner);
            assert_eq!(normal.abs().max_element(), normal.length(), "{normal}");
        }
    }

    /// On a fine ball, corner normals point away from the centre much more exactly than the triangles' own normals.
    #[test]
    fn a_ball_is_round() {
        let at = |i: u32, j: u32| {
            let (theta, phi) =
                (f64::from(i) * std::f64::consts::PI / 24.0, f64::from(j % 48) * std::f64::consts::PI / 24.0);
            [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()].map(|c| c as f32)
        };
        let mut ball = mesh(vec![], vec![]);
        for (i, j) in (1..23).flat_map(|i| (0..48).map(move |j| (i, j))) {
            let first = ball.positions.len() as u32;
            ball.positions.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            // Every other triangle is wound the opposite way.
            ball.triangles.extend([[first, first + 1, first + 2], [first, first + 3, first + 2]]);
        }
        let normals = smooth_normals(&ball);
        for (triangle, normals) in ball.triangles.iter().zip(&normals) {
            let corners = triangle.map(|i| Vec3::from(ball.positions[i as usize]));
            let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            for (corner, normal) in corners.into_iter().zip(normals) {
                let at_the_rim = !(0.2..0.98).contains(&(1.0 - corner.z.abs()));
                assert!(at_the_rim || Vec3::from(*normal).dot(corner).abs() > 0.9995, "{corner} {normal:?}");
                assert!(at_the_rim || flat.dot(corner).abs() < 0.9985, "{corner} {flat}");
            }
        }
    }
}
