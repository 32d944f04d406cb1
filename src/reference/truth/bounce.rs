//! One-bounce indirect light, path traced in f64: lit surfaces illuminate other surfaces. Virtual point lights approximate this, in the
//! same units: the cosine-weighted mean of the arriving radiance.
//!
//! Surfaces are two-sided, as in [`picture`](super::picture): like a virtual light, they reflect light to the side on which it arrives.
//! Only meshes take part; smoke and hair between them are ignored.

use super::casters::Casters;
use super::meshes::Hit;
use super::picture::light;
use crate::scene::{Picture, SKY, Scene, View};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A picture lit by indirect light alone, with an estimate of its noise.
pub struct Bounce {
    /// The picture from all directions.
    pub picture: Picture,
    /// Two pictures, one from each half of the directions. The halves are independent, so half of their difference is the standard error of
    /// the picture.
    pub halves: [Picture; 2],
}

/// Renders the meshes from `camera`, lit by one bounce of the scene's lights. For each pixel, `samples` directions (an even number) are
/// traced on each side of the surface. Every run gives the same result.
pub fn bounce(casters: &Casters, scene: &Scene, camera: &View, samples: u32) -> Bounce {
    let half = samples.div_ceil(2).max(1);
    let pixel = |i: u32| {
        let at = DVec2::new(f64::from(i % camera.width) + 0.5, f64::from(i / camera.width) + 0.5);
        let ray = camera.ray(at);
        let seen = casters.meshes.hit(ray.origin, ray.direction).filter(|hit| hit.distance < camera.far.into());
        let Some(hit) = seen else { return [SKY; 2] };
        let (position, albedo) = (ray.at(hit.distance), DVec3::from(hit.albedo.map(f64::from)));
        [0, 1].map(|batch| {
            let random = 2 * (2 * u64::from(i) + batch);
            let sides = [(hit.normal, random), (-hit.normal, random + 1)];
            let light: DVec3 =
                sides.map(|(normal, random)| from_side(casters, scene, position, normal, random, half)).iter().sum();
            (albedo * light).as_vec3().into()
        })
    };
    let both: Vec<[[f32; 3]; 2]> = (0..camera.width * camera.height).into_par_iter().map(pixel).collect();
    let picture = |of: &dyn Fn(&[[f32; 3]; 2]) -> [f32; 3]| Picture {
        width: camera.width,
        height: camera.height,
        pixels: both.iter().map(of).collect(),
    };
    let mean = |[a, b]: &[[f32; 3]; 2]| [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    Bounce { picture: picture(&mean), halves: [0, 1].map(|batch| picture(&|both| both[batch])) }
}

/// Returns the indirect light that arrives on the side of `normal`, in the units of [`light`]. `random` seeds the directions: a
/// low-discrepancy sequence (Roberts 2018, R2) with a random offset (Cranley and Patterson 1976), mapped to a cosine distribution by
/// Malley's method (Pharr, Jakob and Humphreys, *Physically based rendering*, section 13.6.3).
fn from_side(casters: &Casters, scene: &Scene, position: DVec3, normal: DVec3, random: u64, samples: u32) -> DVec3 {
    const ROOT: f64 = 1.324_717_957_244_746;
    let steps = [1.0 / ROOT, 1.0 / (ROOT * ROOT)];
    let begin = [0, 1].map(|axis| share(2 * random + axis));
    let (across, along) = normal.any_orthonormal_pair();
    let met = (0..samples).map(f64::from).map(|i| {
        let [u, v] = [0, 1].map(|axis| (begin[axis] + steps[axis] * i).fract());
        let (sin, cos) = (TAU * v).sin_cos();
        let direction = u.sqrt() * (cos * across + sin * along) + (1.0 - u).sqrt() * normal;
        let hit = casters.meshes.hit(position, direction);
        hit.map_or(DVec3::ZERO, |hit| leaving(casters, scene, position + hit.distance * direction, direction, &hit))
    });
    met.sum::<DVec3>() / f64::from(samples)
}

/// Returns the scene's light reflected by a surface to the side seen by a ray along `direction`.
fn leaving(casters: &Casters, scene: &Scene, position: DVec3, direction: DVec3, hit: &Hit) -> DVec3 {
    let normal = if hit.normal.dot(direction) > 0.0 { -hit.normal } else { hit.normal };
    let light = light(casters, scene, position, |_| 0.0, |towards| normal.dot(towards).max(0.0));
    DVec3::from(hit.albedo.map(f64::from)) * light
}

/// Returns a pseudo-random number from 0 to 1 (Steele, Lea and Flood 2014, SplitMix64).
fn share(number: u64) -> f64 {
    let mixed = (number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::truth::picture;
    use crate::scene::tests::{mesh, on_the_axis};
    use crate::scene::{Camera, Light, LightKind, Mesh};
    use std::f64::consts::PI;

    const ALBEDO: f64 = 0.5;
    const RADIANCE: DVec3 = DVec3::new(1.0, 0.5, 0.25);
    const HALF: f64 = 2.0;

    fn level(low: [f32; 2], high: [f32; 2], z: f32) -> Mesh {
        let [[x0, y0], [x1, y1]] = [low, high];
        mesh(vec![[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]], vec![[0, 1, 2], [0, 2, 3]])
    }

    /// Builds a square with half-extent [`HALF`] at z = 0, lit straight from above.
    fn square() -> Scene {
        let mut scene = on_the_axis(&[]);
        let half = HALF as f32;
        scene.meshes = vec![level([-half; 2], [half; 2], 0.0)];
        scene.lights[0].radiance = RADIANCE.as_vec3().into();
        scene
    }

    /// Returns the form factor from a surface element at `height` above the origin to a parallel rectangle at z = 0. Source: Howell, Siegel
    /// and Mengüç, *Thermal radiation heat transfer*, configuration B-3, for a rectangle with one corner below the point.
    fn rectangle(low: [f64; 2], high: [f64; 2], height: f64) -> f64 {
        let part = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
        let corner = |x: f64, y: f64| (part(x / height, y / height) + part(y / height, x / height)) / TAU;
        corner(high[0], high[1]) - corner(low[0], high[1]) - corner(high[0], low[1]) + corner(low[0], low[1])
    }

    #[track_caller]
    fn near(found: DVec3, expected: DVec3) {
        assert!((found - expected).abs().max_element() < 1e-3, "{found}, not {expected}");
    }

    /// The light arriving above a lit square is proportional to the square's form factor, and arrives only on the side that faces it. Where
    /// a plate shadows part of the square, only the lit part contributes. Below the square, on its dark side, no light arrives.
    #[test]
    fn a_lit_square_has_its_closed_form() {
        let mut scene = square();
        let position = DVec3::new(0.3, -0.2, 1.5);
        let at = |scene: &Scene, position, normal| from_side(&Casters::new(scene), scene, position, normal, 7, 1 << 16);
        let factor = rectangle([-2.3, -1.8], [1.7, 2.2], 1.5);
        assert!((0.5..0.7).contains(&factor), "{factor}");
        near(at(&scene, position, DVec3::NEG_Z), ALBEDO * RADIANCE * factor);
        assert_eq!(at(&scene, position, DVec3::Z), DVec3::ZERO);
        assert_eq!(at(&scene, DVec3::new(0.3, -0.2, -1.5), DVec3::Z), DVec3::ZERO);
        scene.meshes.push(level([-5.0; 2], [0.8, 5.0], 4.0));
        let lit = rectangle([0.5, -1.8], [1.7, 2.2], 1.5);
        near(at(&scene, position, DVec3::NEG_Z), ALBEDO * RADIANCE * lit);
    }

    /// Places one virtual light per cell of a parallelogram, as strong as the sunlight that the cell reflects.
    fn patches(casters: &Casters, scene: &Scene, origin: DVec3, sides: [DVec3; 2], cells: [u32; 2]) -> Vec<Light> {
        let normal = sides[0].cross(sides[1]).normalize();
        let area = sides[0].cross(sides[1]).length() / f64::from(cells[0] * cells[1]);
        let cell = |i: u32| {
            let at = [i % cells[0], i / cells[0]];
            let share = [0, 1].map(|axis| (f64::from(at[axis]) + 0.5) / f64::from(cells[axis]));
            let position = origin + share[0] * sides[0] + share[1] * sides[1];
            let lit = light(casters, scene, position, |_| 0.0, |towards| normal.dot(towards).max(0.0));
            let radiance = ALBEDO * lit * area / PI;
            let kind = LightKind::Virtual { position, normal, nearest: area.sqrt() };
            Light { kind, radiance: radiance.as_vec3().into(), radius: f64::INFINITY }
        };
        (0..cells[0] * cells[1]).map(cell).filter(|light| light.radiance[0] > 0.0).collect()
    }

    /// Virtual lights all over the lit square match its closed form too, and hence the path-traced light.
    #[test]
    fn virtual_lights_are_of_the_same_units() {
        let mut scene = square();
        let side = 2.0 * HALF;
        let origin = DVec3::new(-HALF, -HALF, 0.0);
        scene.lights = patches(&Casters::new(&scene), &scene, origin, [side * DVec3::X, side * DVec3::Y], [64, 64]);
        assert_eq!(scene.lights.len(), 64 * 64);
        let position = DVec3::new(0.3, -0.2, 1.5);
        let found = light(&Casters::new(&scene), &scene, position, |_| 0.0, |towards| towards.z.abs());
        near(found, ALBEDO * RADIANCE * rectangle([-2.3, -1.8], [1.7, 2.2], 1.5));
    }

    /// Builds a floor and a wall in the sun, with a plate over the floor.
    fn corner() -> Scene {
        let mut scene = square();
        let wall = vec![[-2.0, -2.0, 0.0], [-2.0, 2.0, 0.0], [-2.0, 2.0, 2.0], [-2.0, -2.0, 2.0]];
        scene.meshes.extend([mesh(wall, vec![[0, 1, 2], [0, 2, 3]]), level([0.0, -0.5], [0.8, 0.5], 1.0)]);
        scene.lights[0].kind = LightKind::Directional { direction: DVec3::new(-0.6, 0.0, -0.8) };
        let position = DVec3::new(3.5, -2.5, 3.0);
        scene.camera = Camera { position, target: DVec3::new(-0.8, 0.2, 0.6), up: DVec3::Z, fov_y_degrees: 40.0 };
        scene
    }

    fn rms(a: &Picture, b: &Picture) -> f64 {
        let squares = a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2));
        (squares.sum::<f64>() / a.pixels.len() as f64 / 3.0).sqrt()
    }

    /// Where surfaces light and shadow each other, thousands of virtual lights nearly reproduce the path-traced picture. With fewer
    /// directions, the error of the traced picture matches the noise estimated from its two halves.
    #[test]
    fn virtual_lights_converge_to_the_bounce() {
        let scene = corner();
        let casters = Casters::new(&scene);
        let camera = View::camera(&scene.camera, &scene, [24, 16]);
        let mut lit = scene.clone();
        let surfaces = [
            (DVec3::new(-2.0, -2.0, 0.0), [4.0 * DVec3::X, 4.0 * DVec3::Y], [40, 40]),
            (DVec3::new(-2.0, -2.0, 0.0), [4.0 * DVec3::Y, 2.0 * DVec3::Z], [40, 20]),
            (DVec3::new(0.0, -0.5, 1.0), [0.8 * DVec3::X, DVec3::Y], [8, 10]),
        ];
        lit.lights =
            surfaces.iter().flat_map(|(at, sides, cells)| patches(&casters, &scene, *at, *sides, *cells)).collect();
        let patches = picture(&Casters::new(&lit), &lit, &camera);
        let traced = bounce(&casters, &scene, &camera, 4096);
        let is_sky = |p: &[f32; 3]| *p == SKY;
        let both = || traced.picture.pixels.iter().zip(&patches.pixels).filter(|(p, _)| !is_sky(p));
        assert!(both().all(|(_, p)| !is_sky(p)) && (150..380).contains(&both().count()), "{}", both().count());
        let sum = |of: fn((&[f32; 3], &[f32; 3])) -> f32| both().map(of).map(f64::from).sum::<f64>();
        let (by_bounce, by_patches) = (sum(|(a, _)| a[1]), sum(|(_, b)| b[1]));
        let apart = sum(|(a, b)| (a[1] - b[1]).abs());
        println!("sums {by_bounce:.4}, {by_patches:.4}, apart {apart:.4}");
        assert!((by_bounce / by_patches - 1.0).abs() < 0.02 && apart < 0.04 * by_bounce);
        // Indirect light reaches the plate's shadow too.
        assert!(both().all(|(p, _)| p[1] > 1e-3));

        let noise = |b: &Bounce| 0.5 * rms(&b.halves[0], &b.halves[1]);
        let few = bounce(&casters, &scene, &camera, 32);
        let (found, stated) = (rms(&few.picture, &traced.picture), noise(&few));
        println!("wrong by {found:.2e}, stated {stated:.2e}, of many {:.2e}", noise(&traced));
        assert!((0.7..1.4).contains(&(found / stated)) && noise(&traced) < 0.1 * stated);
    }
}
