//! Particle shadow maps' twins: three ways to fill a ray's slices, and look-ups in them.

use super::segments::ROUNDING;
use glam::DVec3;
use gobo::reference::twin::psm::{Slices, fused, look_up, place, propagate, propagate_depths, scale, voxelize};
use gobo::reference::twin::segment::texel_segment;
use gobo::reference::twin::sums::DARK;
use gobo::scene::{Camera, Caster, Light, LightKind, Particle, Scene, View};

/// Largest number of casters on the ray.
const MOST: usize = 64;

/// Returns the only ray of a map of one texel, down from z = 2 to −2.
fn ray() -> View {
    let held = |z| Particle { position: [0.0, 0.0, z], radius: 1.0, extinction: 0.0 };
    let down = LightKind::Directional { direction: DVec3::NEG_Z };
    let scene = Scene {
        name: "ray".into(),
        particles: vec![held(-1.0), held(1.0)],
        lights: vec![Light { kind: down, radiance: [1.0; 3], radius: f64::INFINITY }],
        camera: Camera { position: DVec3::ONE, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
        ..Scene::default()
    };
    View::volumes(&scene, 1)[0]
}

/// Reads spheres on the ray, some beyond its ends, with radii from 2⁻¹⁶ to 1 and extinctions of 0 and from 10⁻³⁸ to 10³⁸.
fn casters(bytes: &[u8]) -> Vec<Caster> {
    let sphere = |b: &[u8]| {
        let z = (f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0 - 0.5) * 6.0;
        let extinction = if b[3] == 0 { 0.0 } else { 10f32.powf((f32::from(b[3]) - 128.0) * 0.3) };
        Caster { position: [0.0, 0.0, z], radius: (-f32::from(b[2] % 17)).exp2(), axis: [0.0; 3], density: extinction }
    };
    bytes.chunks_exact(4).take(MOST).map(sphere).collect()
}

/// Reads slices from the first byte, and spheres from the rest.
pub fn psm(bytes: &[u8]) -> bool {
    let Some((code, rest)) = bytes.split_first() else { return false };
    let slices = Slices { count: [4, 8, 64, 256][usize::from(code % 4)], split: code / 4 % 2 == 1 };
    let (view, casters) = (ray(), casters(rest));
    // Optical depth in each slice, in f64, from the twin's own segments and positions.
    let mut taken = vec![0.0; slices.count as usize + 1];
    for caster in &casters {
        let Some(segment) = texel_segment(&view, [0, 0], caster) else { continue };
        let (place, depth) = (place(&view, caster, slices), f64::from(segment.optical_depth));
        taken[place.slice] += depth * (1.0 - f64::from(place.share));
        taken[place.slice + 1] += depth * f64::from(place.share);
    }
    let local = voxelize(&view, [0, 0], &casters, slices);
    let scale = scale(&casters, slices.split);
    let sums = propagate_depths(&local);
    let products = propagate(&local.iter().map(|depth| (-depth).exp()).collect::<Vec<_>>());
    let whole = fused(&view, [0, 0], &casters, slices, scale);
    // Error bound: a rounded share and a rounded sum per caster, and a rounded sum (or product) per slice.
    let rounded = (2 * casters.len() + slices.count as usize + 8) as f64 * ROUNDING;
    // Error bound in fixed point: half a unit for each of a caster's two slices. No share is darker than DARK.
    let units = casters.len() as f64 / f64::from(scale) + (-f64::from(DARK)).exp();
    let mut sum = 0.0;
    for slice in 0..slices.count as usize {
        sum += taken[slice];
        let exact = (-sum).exp();
        for (light, off) in [(sums[slice], rounded), (products[slice], rounded), (whole[slice], rounded + units)] {
            assert!((f64::from(light) - exact).abs() <= off, "slice {slice}: {light}, not {exact} to {off}");
        }
    }
    [sums, products, whole].iter().for_each(|behind| looks_up(behind));
    true
}

/// Asserts that transmittance is in [0, 1], never rises, and matches f64 interpolation between the slices.
fn looks_up(behind: &[f32]) {
    let count = behind.len();
    let mut last = 1.0;
    for step in 0..=4 * count + 4 {
        let depth = step as f32 / (4 * count) as f32;
        let light = look_up(behind, depth);
        let at = f64::from(depth.min(1.0)) * count as f64;
        let slice = (at as usize).min(count - 1);
        let near = if slice == 0 { 1.0 } else { f64::from(behind[slice - 1]) };
        let exact = near + (f64::from(behind[slice]) - near) * (at - slice as f64);
        assert!((f64::from(light) - exact).abs() <= 4.0 * ROUNDING, "{light}, not {exact}, at {depth}");
        assert!((0.0..=1.0).contains(&light), "{light} at {depth}");
        assert!(f64::from(light - last) <= 4.0 * ROUNDING, "rises from {last} to {light} at {depth}");
        last = light;
    }
}
