//! Volumes in pictures: marching against closed forms, and against the reference.

use crate::support::{built, gpu_test, opened, scenes};
use crate::volumes::{ball, scene};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, picture};
use gobo::scene::{Camera, Field, Particle, Picture, Placed, SKY, Scene, View, Volume};
use gobo::shading::{Lighting, Renderer, Shading};
use gobo::world::World;
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 27];

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

fn drawn(context: &Context, scene: &Scene, spec: &str) -> Picture {
    let world = World::new(context, scene).expect("room for the scene");
    let renderer = Renderer::new(context, &world, &camera(scene)).expect("a renderer");
    let technique = built(context, scene, spec);
    opened(renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment), spec)
}

/// Returns a picture's error bound for rounding: pixels are half floats if 32-bit floats cannot be blended.
fn rounding(context: &Context) -> f64 {
    if context.features().float32_blend { 2e-5 } else { 1e-3 }
}

/// Returns the largest and the mean difference.
fn apart(a: &Picture, b: &Picture) -> (f64, f64) {
    let all = a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| f64::from((a - b).abs()));
    (all.clone().fold(0.0, f64::max), all.sum::<f64>() / (3 * a.pixels.len()) as f64)
}

/// Samples in a slab, 90 wide and 12 deep, in steps of 0.25; seen along its depth from 6 units away, so that all rays pass through its
/// faces.
fn slab(density: impl Fn([i32; 3]) -> f32, [x, y]: [f64; 2]) -> Scene {
    let places = (0..90 * 90 * 12).map(|i| [i % 90, i / 90 % 90, i / 8100]);
    let field = Arc::new(Field::new(places.map(|place| (place, density(place)))).expect("a field"));
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 0.25 * axis);
    // The slab's centre is at 0.
    let origin = -0.25 * DVec3::new(44.5, 44.5, 5.5);
    let placed = Placed { origin, steps, extinction: 0.5, color: [0.9, 0.5, 0.2], side: 8 };
    let mut scene = scene(Volume::new(field, placed).expect("a volume"));
    let position = DVec3::new(x, y, 6.0);
    scene.camera = Camera { position, target: DVec3::new(x, y, 0.0), up: DVec3::Y, fov_y_degrees: 40.0 };
    scene
}

/// A slab's density per sample, and the mean along a ray as a function of where it passes the centre plane.
type Density<'a> = &'a dyn Fn([i32; 3]) -> f32;
type Mean<'a> = &'a dyn Fn(f64) -> f64;

/// The density is uniform, or rises along the slab's depth, or across it. Through both faces, where it falls to 0 over a step, a ray covers
/// as many steps as there are samples. Where the density rises evenly the ray sees its mean, which is the value at the centre.
#[test]
fn volumes_of_slabs_are_closed_forms() {
    gpu_test("volumes_of_slabs_are_closed_forms", |context| {
        let even = |_: [i32; 3]| 1.0;
        let deep = |[_, _, z]: [i32; 3]| 0.25 * z as f32;
        let across = |[x, _, _]: [i32; 3]| x as f32 / 32.0;
        let cases: [(&str, Density<'_>, Mean<'_>); 3] = [
            ("even", &even, &|_| 1.0),
            ("deep", &deep, &|_| 0.25 * 5.5),
            ("across", &across, &|x| (x / 0.25 + 44.5) / 32.0),
        ];
        // Either no cell side lies on a pixel's ray, or the rays of the middle row run within one throughout.
        let places = [[0.011, 0.017], [0.0, 0.125]];
        for ((name, density, mean), at) in cases.into_iter().flat_map(|case| places.map(|at| (case, at))) {
            let scene = slab(density, at);
            let found = drawn(context, &scene, "none");
            let camera = camera(&scene);
            let mut worst = 0.0f64;
            for (i, pixel) in found.pixels.iter().enumerate() {
                let at = glam::DVec2::new((i % 48) as f64 + 0.5, (i / 48) as f64 + 0.5);
                let ray = camera.ray(at);
                let middle = ray.origin - ray.origin.z / ray.direction.z * ray.direction;
                let slant = ray.direction.length() / ray.direction.z.abs();
                let passes = (-0.5 * 12.0 * 0.25 * slant * mean(middle.x)).exp();
                for (channel, ambient) in [0.10, 0.12, 0.15].into_iter().enumerate() {
                    let lit = [0.9, 0.5, 0.2][channel] * (ambient + 1.0);
                    let expected = lit * (1.0 - passes) + f64::from(SKY[channel]) * passes;
                    worst = worst.max((f64::from(pixel[channel]) - expected).abs());
                }
            }
            println!("{name}: {worst:.1e}");
            assert!(worst < rounding(context), "{name}: {worst}");
        }
    });
}

/// With only ambient light, a picture shows how much of everything is visible, independently of techniques: rotated volumes, a plate inside
/// one of them, smoke in front, inside and behind, and a camera inside.
#[test]
fn volumes_are_seen_as_in_the_reference() {
    gpu_test("volumes_are_seen_as_in_the_reference", |context| {
        let mut all = scene(ball(24, 1));
        all.lights[0].radiance = [0.0; 3];
        let placed = *all.volumes[0].placed();
        let beside = Placed { origin: placed.origin + DVec3::new(0.9, 0.7, 0.3), color: [0.2, 0.9, 0.4], ..placed };
        let field = Arc::new(all.volumes[0].field().clone());
        all.volumes.push(Volume::new(field, beside).expect("a volume"));
        all.meshes = vec![scenes::level(-0.2, 0.5, [0.3, 0.1])];
        let smoke = |position, radius| Particle { position, radius, extinction: 1.5 };
        all.particles = vec![smoke([0.9, -1.1, 0.7], 0.4), smoke([0.1, 0.0, 0.1], 0.3), smoke([-0.7, 1.0, -0.4], 0.5)];
        let outside = all.camera.position;
        for position in [outside, DVec3::new(0.21, -0.33, 0.13)] {
            all.camera.position = position;
            let expected = picture(&Casters::new(&all), &all, &camera(&all));
            let (most, mean) = apart(&drawn(context, &all, "none"), &expected);
            println!("{position}: {most:.1e}, {mean:.1e} in the mean");
            // At a few pixels, rounding decides whether the edge of a plate or a sphere is hit.
            assert!(mean < rounding(context) && most < 0.3, "{position}: {most}, {mean}");
        }
    });
}

/// A row of dense balls with two volumes in it, seen from all around by one renderer: each picture equals a new renderer's to the bit, and
/// the reference's up to rounding. From either end, many balls come before each volume, too many to be in order by chance.
#[test]
fn volumes_stay_among_casters_that_are_sorted() {
    gpu_test("volumes_stay_among_casters_that_are_sorted", |context| {
        let mut all = scene(ball(8, 1));
        all.lights[0].radiance = [0.0; 3];
        let placed = *all.volumes[0].placed();
        let field = Arc::new(all.volumes[0].field().clone());
        let steps = placed.steps.map(|step| 0.4 * step);
        let at = |x: f64| Placed { origin: DVec3::X * x + 0.4 * placed.origin, steps, extinction: 8.0, ..placed };
        all.volumes = [-0.8, 1.1].map(|x| Volume::new(field.clone(), at(x)).expect("a volume")).into();
        all.particles = (0..12u8)
            .map(|i| Particle {
                position: [0.31 * f32::from(i * 7 % 12) - 1.7, 0.0, 0.01],
                radius: 0.2,
                extinction: 3.0,
            })
            .collect();
        let world = World::new(context, &all).expect("room for the scene");
        let technique = built(context, &all, "none");
        let mut renderer = Renderer::new(context, &world, &camera(&all)).expect("a renderer");
        let answer = technique.answer();
        let kernels = renderer.kernels(&answer, Shading::Forward, Lighting::Fragment).expect("kernels");
        let mut pictures = Vec::new();
        for turn in 0..6 {
            let angle = std::f64::consts::TAU * f64::from(turn) / 6.0 + 0.1;
            all.camera.target = DVec3::ZERO;
            all.camera.position = DVec3::new(5.0 * angle.cos(), 5.0 * angle.sin(), 0.7);
            renderer.look(&world, &camera(&all)).expect("the next frame");
            let passes = renderer.draw(&kernels).expect("drawn");
            assert!(passes.is_empty() || passes.iter().any(|pass| pass.name == "shading.far_to_near"), "{passes:?}");
            let found = renderer.read().expect("read");
            assert!(found == drawn(context, &all, "none"), "turn {turn}: another picture than that of a new renderer");
            let (most, mean) = apart(&found, &picture(&Casters::new(&all), &all, &camera(&all)));
            println!("turn {turn}: {most:.1e}, {mean:.1e} in the mean");
            assert!(mean < rounding(context) && most < 0.3, "turn {turn}: {most}, {mean}");
            pictures.push(found);
        }
        // Without volumes, the last picture differs.
        let none = Scene { volumes: Vec::new(), ..all.clone() };
        let unlike = apart(&drawn(context, &none, "none"), &pictures[5]).0;
        assert!(unlike > 0.02, "volumes are hardly seen: {unlike}");
    });
}

/// A lit picture differs from the reference only by the technique's error. Here that is the cells' error in space, which bounds the error
/// of a pixel, because a pixel averages it with colors and radiances of at most 1.
#[test]
fn volumes_are_lit_as_in_the_reference() {
    gpu_test("volumes_are_lit_as_in_the_reference", |context| {
        let lit = scene(ball(24, 1));
        let casters = Casters::new(&lit);
        let technique = built(context, &lit, "grid-query:size=64");
        let points = gobo::reference::truth::space_points(&lit, 0, 4000);
        let answers = crate::support::ask(context, technique.as_ref(), 0, &points);
        let error =
            |(p, a): (&[f32; 3], &f32)| (f64::from(*a) - casters.visibility(0, DVec3::from(p.map(f64::from)))).abs();
        let most = points.iter().zip(&answers).map(error).fold(0.0, f64::max);
        let expected = picture(&casters, &lit, &camera(&lit));
        let (found, mean) = apart(&drawn(context, &lit, "grid-query:size=64"), &expected);
        let unlit = apart(&drawn(context, &lit, "none"), &expected).0;
        println!("{found:.4} of {most:.4}, {mean:.5} in the mean; without shadows {unlit:.3}");
        assert!(found < most && unlit > 10.0 * most, "{found}, not {most}; {unlit}");
    });
}
