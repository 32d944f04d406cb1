//! Points on meshes: half of them seen by the camera, half spread over all meshes by area.

use super::casters::Casters;
use super::meshes::Meshes;
use super::points::{first, r3};
use crate::scene::{Light, LightKind, Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A point on a mesh, in f64: rounded to f32, it would lie off the surface and shadow itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position in world units.
    pub position: DVec3,
    /// Unit normal: outwards on a closed surface, otherwise on either side.
    pub normal: DVec3,
    /// Whether the point is on a closed surface.
    pub closed: bool,
}

impl SurfacePoint {
    /// Returns the surface's normal, turned towards `towards`; on a closed mesh, always the outward normal.
    pub fn facing(&self, towards: DVec3) -> DVec3 {
        if self.closed || self.normal.dot(towards) >= 0.0 { self.normal } else { -self.normal }
    }

    /// Returns whether the point must lie in its own mesh's shadow: its surface is closed, and the outside faces away from a directional
    /// light. A light with a position proves nothing, since it may be inside the mesh. Twin: looks_away in glsl/query/receiver.glsl.
    pub fn looks_away(&self, light: &Light) -> bool {
        let LightKind::Directional { direction } = light.kind else { return false };
        self.closed && self.normal.dot(direction) > 0.0
    }

    /// Returns the normal passed to a technique: [`SurfacePoint::facing`], or 0 if [`SurfacePoint::looks_away`].
    pub fn asked(&self, light: &Light) -> [f32; 3] {
        let normal = if self.looks_away(light) { DVec3::ZERO } else { self.facing(light.towards(self.position)) };
        normal.as_vec3().into()
    }
}

/// Returns at most `count` low-discrepancy points on meshes on which light `light` shines. Half are seen through pixels of the picture that
/// show a mesh; the other half is spread over all meshes by area. For a light of limited reach, more pixels are tried so that as many
/// points are found. No point is inside a closed mesh ([`Casters::inside`]). Every run gives the same result, which is empty without
/// meshes.
pub fn surface_points(
    casters: &Casters,
    scene: &Scene,
    light: usize,
    camera: &View,
    count: usize,
) -> Vec<SurfacePoint> {
    if !scene.has_triangles() {
        return Vec::new();
    }
    let shining = &scene.lights[light];
    let wanted = |point: &SurfacePoint| shining.shines_on(point.position) && !casters.surface_inside(light, point);
    let seen = |i: usize| {
        let [x, y, _] = r3(i);
        let ray = camera.ray(DVec2::new(x * f64::from(camera.width), y * f64::from(camera.height)));
        let hit = casters.meshes.hit(ray.origin, ray.direction)?;
        Some(SurfacePoint { position: ray.at(hit.distance), normal: hit.normal, closed: hit.closed }).filter(wanted)
    };
    let pixels = count / 2;
    let mut points = if shining.radius.is_finite() {
        first(pixels, seen)
    } else {
        (0..pixels).into_par_iter().filter_map(seen).collect()
    };
    points.extend(by_area(&casters.meshes, count - pixels, wanted));
    points
}

fn by_area(meshes: &Meshes, count: usize, wanted: impl Fn(&SurfacePoint) -> bool + Sync) -> Vec<SurfacePoint> {
    let triangles = &meshes.triangles;
    let mut total = 0.0;
    let ends: Vec<f64> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.corners;
            total += (b - a).cross(c - a).length();
            total
        })
        .collect();
    if total == 0.0 {
        return Vec::new();
    }
    let point = |i: usize| {
        let [u, v, w] = r3(i);
        let triangle = &triangles[ends.partition_point(|end| *end <= u * total).min(triangles.len() - 1)];
        let [a, b, c] = triangle.corners;
        // Uniform over a triangle: Osada et al. 2002, Shape distributions, section 3.1.
        let root = v.sqrt();
        let position = a * (1.0 - root) + b * (root * (1.0 - w)) + c * (root * w);
        let point = SurfacePoint { position, normal: triangle.normal(), closed: triangle.side != 0 };
        triangle.blocks_at(position).then_some(point)
    };
    first(count, |i| point(i).filter(&wanted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{cube, inside_out, mesh, on_the_axis};
    use crate::scene::{LightKind, Mesh};

    /// Two triangles, one three times as large as the other: three quarters of the points lie on the large one, evenly spread, and all
    /// points lie in the triangles' planes.
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
            alpha: None,
        });
        let points = by_area(&Meshes::new(&scene.meshes), 4000, |_| true);
        let (low, high): (Vec<SurfacePoint>, Vec<SurfacePoint>) = points.iter().partition(|p| p.position.z < 1.0);
        assert!(low.len().abs_diff(3000) < 40, "{}", low.len());
        assert!(
            low.iter().all(|p| p.position.z.abs() < 1e-12) && high.iter().all(|p| (p.position.z - 5.0).abs() < 1e-12)
        );
        assert!(points.iter().all(|p| p.normal.z.abs() == 1.0));
        // The mean of the points on the large triangle is its centroid.
        let mean = low.iter().map(|p| p.position).sum::<DVec3>() / low.len() as f64;
        assert!((mean - DVec3::new(1.0, 1.0 / 3.0, 0.0)).length() < 0.02, "{mean}");
    }

    /// On a large plate under a lamp of limited reach, all points lie within the lamp's light, and there are as many as under a lamp of
    /// unlimited reach.
    #[test]
    fn points_lie_where_the_light_is() {
        let mut scene = on_the_axis(&[]);
        let corners = vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
        scene.meshes = vec![mesh(corners, vec![[0, 1, 2], [0, 2, 3]])];
        let camera = View::camera(&scene.camera, &scene, [64, 64]);
        let position = DVec3::new(0.0, 0.0, 0.3);
        scene.lights[0].kind = LightKind::Point { position };
        let all = |scene: &Scene| surface_points(&Casters::new(scene), scene, 0, &camera, 600);
        assert!(all(&scene).iter().any(|p| p.position.length() > 5.0));
        scene.lights[0].radius = 2.0;
        let points = all(&scene);
        assert_eq!(points.len(), 600);
        assert!(points.iter().all(|p| (p.position - position).length() < 2.0));
    }

    /// Points that face away from a sun are blocked by their own mesh, as rays show. No point of an open mesh counts as facing away, and
    /// none counts as facing away from a lamp, even one inside the cube.
    #[test]
    fn what_looks_away_is_blocked() {
        let mut scene = on_the_axis(&[]);
        scene.meshes = vec![cube([0.0, 0.0, 0.0], 1.0), inside_out(cube([2.0, 0.5, -0.25], 1.0))];
        let camera = View::camera(&scene.camera, &scene, [64, 64]);
        let direction = DVec3::new(0.3, 0.2, -1.0).normalize();
        scene.lights[0].kind = LightKind::Directional { direction };
        let casters = Casters::new(&scene);
        let points = surface_points(&casters, &scene, 0, &camera, 2000);
        let (away, towards): (Vec<&SurfacePoint>, Vec<&SurfacePoint>) =
            points.iter().partition(|p| p.looks_away(&scene.lights[0]));
        assert!(away.len() > 400 && towards.iter().any(|p| casters.unblocked(0, p.position)));
        for p in away {
            assert!(!casters.unblocked(0, p.position) && p.asked(&scene.lights[0]) == [0.0; 3], "{p:?}");
        }
        assert!(points.iter().all(|p| !SurfacePoint { closed: false, ..*p }.looks_away(&scene.lights[0])));
        let lamp = Light { kind: LightKind::Point { position: DVec3::splat(0.5) }, ..scene.lights[0] };
        assert!(points.iter().all(|p| !p.looks_away(&lamp) && p.asked(&lamp) != [0.0; 3]));
    }

    /// Two cubes, one of them inside out, overlap each other and a solid ground. All sides get points, even those that face away from the
    /// light. No point lies inside another cube, under the ground, or on the ground inside a cube.
    #[test]
    fn none_are_inside_another() {
        let mut scene = on_the_axis(&[]);
        let corners = vec![[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [3.0, 3.0, 0.0], [-3.0, 3.0, 0.0]];
        let ground = Mesh { solid: true, ..mesh(corners, vec![[0, 1, 2], [0, 2, 3]]) };
        scene.meshes = vec![ground, cube([0.0, 0.0, -0.5], 1.0), inside_out(cube([0.5, 0.5, -0.25], 1.0))];
        let camera = View::camera(&scene.camera, &scene, [64, 64]);
        let direction = DVec3::new(0.3, 0.2, -1.0).normalize();
        scene.lights[0].kind = LightKind::Directional { direction };
        let points = surface_points(&Casters::new(&scene), &scene, 0, &camera, 8000);
        assert!(points.len() > 4000, "{}", points.len());
        let within = |p: DVec3, low: DVec3| {
            (p - low).cmpgt(DVec3::splat(1e-9)).all() && (p - low).cmplt(DVec3::splat(1.0 - 1e-9)).all()
        };
        let (first, second) = (DVec3::new(0.0, 0.0, -0.5), DVec3::new(0.5, 0.5, -0.25));
        for p in points.iter().map(|p| p.position) {
            assert!(p.z > -1e-9 && !within(p, first) && !within(p, second), "{p}");
        }
        // Points lie on the ground and on five sides of each cube, but not on the cubes' undersides.
        let on = |normal: DVec3, low: f64| {
            let of_side = |p: &&SurfacePoint| p.normal == normal && (p.position.dot(normal.abs()) - low).abs() < 1e-9;
            points.iter().filter(of_side).count()
        };
        for (normal, places) in [
            (DVec3::NEG_X, [0.0, 0.5]),
            (DVec3::X, [1.0, 1.5]),
            (DVec3::NEG_Y, [0.0, 0.5]),
            (DVec3::Y, [1.0, 1.5]),
            (DVec3::Z, [0.5, 0.75]),
        ] {
            assert!(places.iter().all(|place| on(normal, *place) > 20), "{normal}");
        }
        assert!(on(DVec3::Z, 0.0) > 1000 && on(DVec3::NEG_Z, -0.25) + on(DVec3::NEG_Z, -0.5) == 0);
    }
}
