//! Fog laid over a picture, marched in f64. Twin: glsl/shading/fog.glsl.

use super::casters::Casters;
use crate::scene::{Fog, Picture, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Mul;

/// Twin: PHASE.
const PHASE: f64 = 0.25;

/// Adds fog to `picture`, as seen by `camera`. `arriving` returns how much of a light arrives at a point, from 0 to 1, as one number or per
/// color; [`Casters::arriving_colors`] is the truth.
pub fn fog<L>(
    casters: &Casters,
    camera: &View,
    picture: &Picture,
    fog: &Fog,
    arriving: impl Fn(usize, DVec3) -> L + Sync,
) -> Picture
where
    DVec3: Mul<L, Output = DVec3>,
{
    let radiances: Vec<_> = casters.scene.lights.iter().map(|l| DVec3::from(l.radiance.map(f64::from))).collect();
    let light = |position| radiances.iter().enumerate().map(|(i, l)| *l * arriving(i, position)).sum::<DVec3>();
    let pixel = |(i, behind): (usize, &[f32; 3])| {
        let pixel = [i as u32 % camera.width, i as u32 / camera.width];
        let ray = camera.ray(DVec2::from(pixel.map(f64::from)) + 0.5);
        let far = f64::from(camera.far);
        let end = casters.meshes.hit(ray.origin, ray.direction).map_or(far, |hit| hit.distance.min(far));
        let length = end * ray.direction.length();
        let at = |share: f64| light(ray.at(share * end));
        let [scattered, transmittance] = march(fog, length, place_in_step(pixel), at);
        over(scattered, transmittance, *behind)
    };
    Picture { pixels: picture.pixels.par_iter().enumerate().map(pixel).collect(), ..*picture }
}

/// Blends the scattered light over the color behind the fog.
fn over(scattered: DVec3, transmittance: DVec3, behind: [f32; 3]) -> [f32; 3] {
    (PHASE * scattered + transmittance * DVec3::from(behind.map(f64::from))).as_vec3().into()
}

/// Marches a ray of the given length through the fog. Returns the light scattered back to the start of the ray, and the transmittance.
/// `light` returns the light that arrives at a point of the ray, given as a fraction of its length. Each step queries it at `place`, which
/// runs from 0 at the step's start to 1 at its end.
fn march(fog: &Fog, length: f64, place: f64, light: impl Fn(f64) -> DVec3) -> [DVec3; 2] {
    let steps = f64::from(fog.steps);
    let (mut scattered, mut transmittance) = (DVec3::ZERO, 1.0);
    for i in (0..fog.steps).map(f64::from) {
        let behind = (-f64::from(fog.extinction) * length * (i + 1.0) / steps).exp();
        scattered += (transmittance - behind) * light((i + place) / steps);
        transmittance = behind;
    }
    [scattered, DVec3::splat(transmittance)]
}

/// Twin: place_in_step.
fn place_in_step([x, y]: [u32; 2]) -> f64 {
    let sum = x.wrapping_mul(3_242_174_889).wrapping_add(y.wrapping_mul(2_447_445_414));
    f64::from(sum >> 8) / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{cube, on_the_axis};
    use crate::scene::{Camera, Scene};

    /// Builds a box under a light shining straight down, seen from the side, so that a column of shadow hangs below the box.
    fn column() -> Scene {
        let mut scene = on_the_axis(&[]);
        scene.meshes = vec![cube([-0.5, -0.5, 1.0], 1.0), cube([-0.2, 4.0, -3.0], 0.4)];
        scene.lights[0].radiance = [0.8, 1.0, 1.4];
        let position = DVec3::new(0.3, -4.0, 0.4);
        scene.camera = Camera { position, target: DVec3::new(0.0, 0.0, 0.5), up: DVec3::Z, fov_y_degrees: 50.0 };
        scene
    }

    /// Returns the range of z in which a ray is inside an upright square column around the axis, below height `top`.
    fn in_column(origin: DVec3, direction: DVec3, half: f64, top: f64) -> [f64; 2] {
        let (low, high) = (DVec3::new(-half, -half, -1e3), DVec3::new(half, half, top));
        let (a, b) = ((low - origin) / direction, (high - origin) / direction);
        [a.min(b).max_element(), a.max(b).min_element()]
    }

    /// Along a ray that is in shadow from a to b and ends at d, fog scatters 1 − e^(−σa) + e^(−σb) − e^(−σd) of the light, a quarter of it
    /// towards the camera. Only the two steps in which the shadow starts and ends add to the error of a march; the error bound is the light
    /// scattered in these steps.
    #[test]
    fn a_shaft_has_its_closed_form() {
        let scene = column();
        let casters = Casters::new(&scene);
        let camera = View::camera(&scene.camera, &scene, [32, 24]);
        let picture = Picture { width: 32, height: 24, pixels: vec![[0.5, 0.25, 0.125]; 32 * 24] };
        let extinction = 0.3f32;
        for steps in [1, 4, 16, 64, 1024] {
            let marched = fog(&casters, &camera, &picture, &Fog { extinction, steps }, |l, p| casters.arriving(l, p));
            let mut shafts = 0;
            for (i, pixel) in marched.pixels.iter().enumerate() {
                let ray = camera.ray(DVec2::new((i % 32) as f64 + 0.5, (i / 32) as f64 + 0.5));
                let hit = casters.meshes.hit(ray.origin, ray.direction);
                let end = hit.map_or(f64::from(camera.far), |h| h.distance.min(camera.far.into()));
                let left = |z: f64| (-f64::from(extinction) * z.clamp(0.0, end) * ray.direction.length()).exp();
                let [from, to] = in_column(ray.origin, ray.direction, 0.5, 2.0);
                // Skips rays through the shadow of the small box behind.
                let behind = in_column(ray.origin - DVec3::Y * 4.2, ray.direction, 0.2, -2.6);
                if behind[0] < behind[1].min(end) {
                    continue;
                }
                let in_shadow = if from < to { left(from) - left(to) } else { 0.0 };
                shafts += usize::from(in_shadow > 0.05);
                let scattered = 0.25 * (1.0 - left(end) - in_shadow);
                let step = 1.0 - left(end).powf(1.0 / f64::from(steps));
                for ((c, radiance), clear) in pixel.iter().zip([0.8, 1.0, 1.4]).zip([0.5, 0.25, 0.125]) {
                    let expected = radiance * scattered + clear * left(end);
                    let wrong = (f64::from(*c) - expected).abs();
                    let bound = 2.0 * 0.25 * radiance * step + 1e-6;
                    assert!(wrong <= bound, "{steps} steps, pixel {i}: {c}, not {expected}, {wrong} > {bound}");
                }
            }
            assert!(shafts > 50, "{shafts} pixels see the shadow");
        }
    }

    /// Neighbouring pixels sample their steps at positions far apart. Over all pixels, the positions are evenly distributed.
    #[test]
    fn places_are_spread() {
        let places: Vec<_> = (0..64 * 64).map(|i| place_in_step([i % 64, i / 64])).collect();
        let mut counts = [0; 16];
        places.iter().for_each(|p| counts[(p * 16.0) as usize] += 1);
        assert!(counts.iter().all(|c: &i32| c.abs_diff(256) < 16), "{counts:?}");
        let apart = |a: f64, b: f64| (a - b).abs().min(1.0 - (a - b).abs());
        for (i, place) in places.iter().enumerate().filter(|(i, _)| i % 64 != 63 && *i < 63 * 64) {
            assert!(apart(*place, places[i + 1]) > 0.2 && apart(*place, places[i + 64]) > 0.2, "pixel {i}");
        }
    }
}
