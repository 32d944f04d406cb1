//! Volumes in lit pictures: the light in a slab in closed form, and `lighting=vertex` and wireframes in front of and behind a volume.

use crate::support::{built, gpu_test, gpu_test_needing, opened};
use crate::volumes::scene;
use glam::{DVec2, DVec3};
use gobo::gpu::{Context, Requirement};
use gobo::scene::{Camera, Field, LightKind, Particle, Picture, Placed, SKY, Scene, View, Volume};
use gobo::shading::{Lighting, Renderer, Shading, VERTEX_SPACING};
use gobo::world::World;
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 27];
const COLOR: [f32; 3] = [0.9, 0.5, 0.2];
const AMBIENT: [f64; 3] = [0.10, 0.12, 0.15];

/// Optical depth of a vertical ray through the slab: 12 samples of 1, 0.25 apart, with extinction 0.5.
const DEPTH: f64 = 0.5 * 12.0 * 0.25;

const VERTEX: Lighting = Lighting::Vertex { spacing: VERTEX_SPACING };

/// Samples of 1 in a slab that is 12 deep, under light straight through it, seen from 6 units away on the light's side, so that all rays
/// pass through both faces.
fn slab(particles: Vec<Particle>) -> Scene {
    let count = [46, 30, 12];
    let places = (0..46 * 30 * 12).map(|i| ([i % 46, i / 46 % 30, i / 1380], 1.0));
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 0.25 * axis);
    let origin = -0.25 * DVec3::from_array(count.map(|count| 0.5 * f64::from(count - 1)));
    let placed = Placed { origin, steps, extinction: 0.5, color: COLOR, side: 1 };
    let mut scene = scene(Volume::new(Arc::new(Field::new(places).expect("a field")), placed).expect("a volume"));
    scene.lights[0].kind = LightKind::Directional { direction: DVec3::NEG_Z };
    let position = DVec3::new(0.011, 0.017, 6.0);
    let target = DVec3::new(position.x, position.y, 0.0);
    scene.camera = Camera { position, target, up: DVec3::Y, fov_y_degrees: 40.0 };
    Scene { particles, ..scene }
}

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

/// Returns how much longer each pixel's ray is than the vertical.
fn slant(camera: &View, pixel: usize) -> f64 {
    let at = DVec2::new((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
    let direction = camera.ray(at).direction;
    direction.length() / direction.z.abs()
}

/// Returns the length of each pixel's ray inside a ball.
fn chord(camera: &View, pixel: usize, ball: &Particle) -> f64 {
    let at = DVec2::new((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
    let ray = camera.ray(at);
    let direction = ray.direction.normalize();
    let to = DVec3::from(ball.position.map(f64::from)) - ray.origin;
    let beside = (to - to.dot(direction) * direction).length_squared();
    2.0 * (f64::from(ball.radius).powi(2) - beside).max(0.0).sqrt()
}

/// Returns a picture's error bound for rounding: pixels are half floats if 32-bit floats cannot be blended.
fn rounding(context: &Context) -> f64 {
    if context.features().float32_blend { 2e-5 } else { 1e-3 }
}

/// After a depth t of the slab exp(−t) of the light is left, whatever the densities above. A ray that is s times as long receives s exp(−s
/// t) dt of it, so it gathers s / (1 + s) · (1 − exp(−(1 + s) t)), plus 1 − exp(−s t) of ambient light.
#[test]
fn volumes_of_lit_slabs_are_closed_forms() {
    gpu_test("volumes_of_lit_slabs_are_closed_forms", |context| {
        let scene = slab(Vec::new());
        let world = World::new(context, &scene).expect("room for the scene");
        let view = camera(&scene);
        let renderer = Renderer::new(context, &world, &view).expect("a renderer");
        let technique = built(context, &scene, "grid-query:size=64");
        let has_vertices = context.features().lacks(Requirement::Tessellation).is_none();
        let lightings = [Lighting::Fragment].into_iter().chain(has_vertices.then_some(VERTEX));
        let drawn: Vec<Picture> = lightings
            .map(|lighting| opened(renderer.picture(&technique.answer(), Shading::Forward, lighting), "grid-query"))
            .collect();
        let (mut worst, mut unlit) = (0.0f64, 0.0f64);
        for (i, pixel) in drawn[0].pixels.iter().enumerate() {
            let s = slant(&view, i);
            let passes = (-s * DEPTH).exp();
            let lit = s / (1.0 + s) * (1.0 - (-(1.0 + s) * DEPTH).exp());
            for channel in 0..3 {
                let color = f64::from(COLOR[channel]);
                let behind = f64::from(SKY[channel]) * passes;
                let expected = color * (AMBIENT[channel] * (1.0 - passes) + lit) + behind;
                worst = worst.max((f64::from(pixel[channel]) - expected).abs());
                let without = color * (AMBIENT[channel] + 1.0) * (1.0 - passes) + behind;
                unlit = unlit.max((without - expected).abs());
            }
        }
        // Where densities fall to 0 over a cell, the cell's mean replaces a ramp: light is off by an eighth of a whole cell's optical depth
        // there, and half of that is seen; behind the whole slab, at most a tenth of it. The midpoint of a step replaces light that falls
        // exponentially over it: an error of its exponent's square over 24.
        let (cell, slant) = (0.5 * 0.25, 1.25);
        let ramps = 1.1 * (cell / 8.0) * (slant * cell / 2.0);
        let most = ramps + f64::powi((1.0 + slant) * cell / 2.0, 2) / 24.0 + rounding(context);
        println!("{worst:.1e} of {most:.1e}; without shadows {unlit:.2}");
        assert!(worst < most && unlit > 100.0 * most, "{worst}, not {most}; {unlit}");
        // The slab has no vertices, so `lighting=vertex` draws the same picture.
        assert!(drawn.iter().all(|other| other.pixels == drawn[0].pixels), "lighting=vertex lights it otherwise");
    });
}

/// Objects behind the slab, including wireframe lines, are attenuated by its closed form; objects in front hide it as they hide the sky.
#[test]
fn volumes_hide_lines_behind_them() {
    let needs = [Requirement::Tessellation, Requirement::Lines];
    gpu_test_needing("volumes_hide_lines_behind_them", &needs, |context| {
        let technique = |scene: &Scene| built(context, scene, "none");
        for (z, is_before) in [(-4.0, false), (3.5, true)] {
            let radius = if is_before { 0.5 } else { 1.5 };
            let ball = Particle { position: [0.1, -0.1, z], radius, extinction: 40.0 };
            let with = slab(vec![ball]);
            let view = camera(&with);
            let without = Scene { volumes: Vec::new(), ..with.clone() };
            let pictures = [&with, &without].map(|scene| {
                let world = World::new(context, scene).expect("room for the scene");
                // Both scenes are drawn with the same view.
                let renderer = Renderer::new(context, &world, &view).expect("a renderer");
                let technique = technique(scene);
                let answer = technique.answer();
                let plain = renderer.picture(&answer, Shading::Forward, VERTEX).expect("drawn");
                [plain, renderer.wireframe(&answer, Shading::Forward, 4.0).expect("drawn")]
            });
            let [[plain, lines], [alone, lines_alone]] = &pictures;
            for (what, found, behind) in [("vertex", plain, alone), ("lines", lines, lines_alone)] {
                let (mut worst, mut black, mut hidden) = (0.0f64, 0, 0);
                for (i, (found, behind)) in found.pixels.iter().zip(&behind.pixels).enumerate() {
                    black += usize::from(*behind == [0.0; 3]);
                    let passes = (-slant(&view, i) * DEPTH).exp();
                    let expected = [0, 1, 2].map(|channel| {
                        let (behind, sky) = (f64::from(behind[channel]), f64::from(SKY[channel]));
                        let slab = f64::from(COLOR[channel]) * (AMBIENT[channel] + 1.0) * (1.0 - passes);
                        if !is_before || behind == sky {
                            return slab + passes * behind;
                        }
                        // A sphere in front hides the slab; pixels are compared only if they are black or the sphere is thick there.
                        behind
                    });
                    let hides = 40.0 * chord(&view, i, &ball) > 15.0;
                    hidden += usize::from(is_before && hides);
                    let thick = hides || *behind == [0.0; 3] || behind.map(f32::to_bits) == SKY.map(f32::to_bits);
                    if !is_before || thick {
                        let off = [0, 1, 2].map(|c| (f64::from(found[c]) - expected[c]).abs());
                        worst = off.into_iter().fold(worst, f64::max);
                    }
                }
                println!("{what}, before: {is_before}: {worst:.1e}, {black} pixels of lines");
                assert!(worst < rounding(context), "{what}, before: {is_before}: {worst}");
                assert_eq!(hidden > 20, is_before, "{hidden} pixels of what hides");
                assert_eq!(black > 30, what == "lines", "{black} pixels of lines");
            }
        }
    });
}
