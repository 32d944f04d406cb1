//! The place that a camera sees through a pixel.

use super::casters::Casters;
use super::volume;
use crate::scene::{Ray, View};
use glam::{DVec2, DVec3};

/// Minimum fraction of the light behind smoke that the smoke must absorb to be seen.
const LEAST: f64 = 1e-3;

/// Number of bisection steps, enough for f64 precision.
const HALVINGS: u32 = 60;

impl Casters<'_> {
    /// Returns the place that `camera` sees at a point given in pixels, on a mesh or in smoke, hair and splats. If more than half of the
    /// light arriving at the camera comes from the mesh, the place is on the mesh. Otherwise it is where casters along the ray have
    /// absorbed half of the light. Without a mesh on the ray, it is where casters have absorbed half of the light that they absorb in
    /// total. `None` if nothing is seen. Light is the mean of red, green and blue, which casters may absorb by different amounts.
    pub fn seen(&self, camera: &View, pixel: DVec2) -> Option<DVec3> {
        let (ray, near) = (camera.ray(pixel), f64::from(camera.near));
        let surface = self.meshes.hit(ray.origin, ray.direction).map(|hit| hit.distance);
        let far = surface.unwrap_or(f64::INFINITY).min(camera.far.into());
        let met = self.met(&ray);
        let through = |z: f64| (-self.optical_depths_to(&ray, &met, near, z)).exp().element_sum() / 3.0;
        let behind = through(far);
        let taken = if surface.is_some() { 1.0 } else { 1.0 - behind };
        if taken < LEAST {
            return None;
        }
        let wanted = 1.0 - 0.5 * taken;
        if behind > wanted {
            return Some(ray.at(far));
        }
        let (mut before, mut reached) = (near, far);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + reached);
            *(if through(middle) > wanted { &mut before } else { &mut reached }) = middle;
        }
        Some(ray.at(reached))
    }

    /// Returns the casters that a ray meets, with the z at which it enters and leaves each.
    fn met(&self, ray: &Ray) -> Vec<(usize, f64, f64)> {
        let asked = self.all.len() - self.scene.cell_count();
        let meets = |i| self.overlap(ray, i as u32).map(|(entry, exit)| (i, entry, exit));
        (0..asked).filter_map(meets).collect()
    }

    /// Returns the optical depths for red, green and blue light between the camera and `z`.
    fn optical_depths_to(&self, ray: &Ray, met: &[(usize, f64, f64)], near: f64, z: f64) -> DVec3 {
        let of = |(i, entry, exit): &(usize, f64, f64)| {
            let (entry, exit) = (entry.max(near), exit.min(z));
            let own = if exit < entry { 0.0 } else { self.depth_within(ray, *i as u32, entry, exit) };
            own * self.ratio_of(*i as u32)
        };
        let volume = |(i, field)| self.ratio_of_volume(i) * volume::optical_depth(field, ray, near, z);
        let volumes = (0..).zip(&self.scene.volumes).map(volume).sum::<DVec3>();
        volumes + met.iter().map(of).sum::<DVec3>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{mesh, on_the_axis};
    use crate::scene::{Camera, Scene};

    /// Looks down the axis from z = 10 at a sphere of optical depth `depth` from z = 1 to −1, over a plate at −3. Returns the z that is
    /// seen.
    fn seen(depth: f32, plate: bool, ratio: [f32; 3]) -> Option<f64> {
        let mut scene = on_the_axis(&[(0.0, 1.0, depth / 2.0)]);
        scene.extinction_ratio = ratio;
        if plate {
            let corners = vec![[-9.0, -9.0, -3.0], [9.0, -9.0, -3.0], [9.0, 9.0, -3.0], [-9.0, 9.0, -3.0]];
            scene.meshes = vec![mesh(corners, vec![[0, 1, 2], [0, 2, 3]])];
        }
        let above = DVec3::new(0.0, 0.0, 10.0);
        let camera = Camera { position: above, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 };
        let camera = View::camera(&camera, &scene, [64, 64]);
        Casters::new(&scene).seen(&camera, DVec2::splat(32.0)).map(|place| place.z)
    }

    /// Expected places, derived by hand: optical depth rises by depth / 2 per unit, and half of the light is left at an optical depth of ln
    /// 2.
    #[test]
    fn it_is_where_half_has_come_from() {
        let half = |depth: f64| 1.0 - 2.0 * std::f64::consts::LN_2 / depth;
        let near = |found: Option<f64>, expected: f64| {
            assert!(found.is_some_and(|z| (z - expected).abs() < 1e-5), "{found:?}, not {expected}");
        };
        near(seen(4.0, true, Scene::GREY), half(4.0));
        // The smoke is too thin, so the plate behind it is seen.
        near(seen(0.5, true, Scene::GREY), -3.0);
        // Without a mesh, half of the light that the smoke absorbs: 1 − (1 − exp(−τ)) / 2.
        let wanted = -(1.0 - 0.5 * (1.0 - (-0.5f64).exp())).ln();
        near(seen(0.5, false, Scene::GREY), 1.0 - 2.0 * wanted / 0.5);
        assert_eq!(seen(1e-5, false, Scene::GREY), None);
        // Smoke that absorbs only red light: two thirds of the light come from the plate.
        near(seen(4.0, true, [1.0, 0.0, 0.0]), -3.0);
        // Smoke that absorbs all but blue light: half of the light is absorbed where red and green have lost three quarters.
        near(seen(4.0, true, [1.0, 1.0, 0.0]), 1.0 - 2.0 * 4.0f64.ln() / 4.0);
    }
}
