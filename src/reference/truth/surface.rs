//! Points on meshes: half of them where the camera looks, half all over, by area.

use super::casters::Casters;
use crate::scene::{Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A point on a mesh, in f64: rounded to f32 it would lie beside the surface, and shadow itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World units.
    pub position: DVec3,
    /// Unit length, either side.
    pub normal: DVec3,
}

/// `count` low-discrepancy points or fewer: half of them through the picture's pixels, as far as they show a mesh; the others on
/// all meshes, by area. The same for the same scene. None without meshes.
pub fn surface_points(casters: &Casters, scene: &Scene, camera: &View, count: usize) -> Vec<SurfacePoint> {
    if !scene.has_triangles() {
        return Vec::new();
    }
    let seen = (0..count / 2).into_par_iter().filter_map(|i| {
        let [x, y, _] = r3(i);
        let ray = camera.ray(DVec2::new(x * f64::from(camera.width), y * f64::from(camera.height)));
        let hit = casters.meshes.hit(ray.origin, ray.direction)?;
        Some(SurfacePoint { position: ray.at(hit.distance), normal: hit.normal })
    });
    let mut points: Vec<_> = seen.collect();
    points.extend(by_area(scene, count - count / 2));
    points
}

/// Roberts' R3: multiples of the powers of the inverse of the real root of x⁴ = x + 1.
fn r3(i: usize) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5;
    [1.0 / ROOT, 1.0 / (ROOT * ROOT), 1.0 / (ROOT * ROOT * ROOT)].map(|step| (0.5 + step * (i as f64)).fract())
}

fn by_area(scene: &Scene, count: usize) -> Vec<SurfacePoint> {
    let corner = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let triangles: Vec<[DVec3; 3]> = scene
        .meshes
        .iter()
        .flat_map(|m| {
            m.triangles.iter().map(|t| t.map(|i| m.positions.get(i as usize).map_or(DVec3::ZERO, |p| corner(*p))))
        })
        .collect();
    let mut total = 0.0;
    let ends: Vec<f64> = triangles
        .iter()
        .map(|[a, b, c]| {
            total += (*b - *a).cross(*c - *a).length();
            total
        })
        .collect();
    if total == 0.0 {
        return Vec::new();
    }
    let point = |i: usize| {
        let [u, v, w] = r3(i);
        let [a, b, c] = triangles[ends.partition_point(|end| *end <= u * total).min(triangles.len() - 1)];
        // Evenly over a triangle: Osada et al. 2002, Shape distributions, section 3.1.
        let root = v.sqrt();
        let position = a * (1.0 - root) + b * (root * (1.0 - w)) + c * (root * w);
        SurfacePoint { position, normal: (b - a).cross(c - a).normalize_or_zero() }
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;
    use crate::scene::tests::on_the_axis;

    /// Two triangles, one three times as large: three quarters of the points lie on it, evenly, and all lie on their planes.
    #[test]
    fn points_go_by_area() {
        let mut scene = on_the_axis(&[(0.0, 0.5, 1.0)]);
        scene.meshes.push(Mesh {
            name: "two".into(),
            positions: vec![
                [0.0; 3],
                [3.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 5.0],
                [1.0, 0.0, 5.0],
                [0.0, 1.0, 5.0],
            ],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            albedo: [0.5; 3],
            solid: false,
        });
        let points = by_area(&scene, 4000);
        let (low, high): (Vec<SurfacePoint>, Vec<SurfacePoint>) = points.iter().partition(|p| p.position.z < 1.0);
        assert!(low.len().abs_diff(3000) < 40, "{}", low.len());
        assert!(
            low.iter().all(|p| p.position.z.abs() < 1e-12) && high.iter().all(|p| (p.position.z - 5.0).abs() < 1e-12)
        );
        assert!(points.iter().all(|p| p.normal.z.abs() == 1.0));
        // The centroid of the large one.
        let mean = low.iter().map(|p| p.position).sum::<DVec3>() / low.len() as f64;
        assert!((mean - DVec3::new(1.0, 1.0 / 3.0, 0.0)).length() < 0.02, "{mean}");
    }
}
