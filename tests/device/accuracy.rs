//! Techniques against the f64 truth: the errors that the CPU prototype measured on real smoke, closed forms, the look-up, the opaque map
//! and the shaded picture.

mod far_to_near;
mod hair;
mod lights;
mod look_up;
mod meshes;
mod none;
mod packed;
mod picture;
mod prepare;
mod sixty;

use crate::support::{ask, built, gpu_test, runs, scenes, shared_data, some};
use glam::DVec3;
use gobo::bench::{PointError, point_error};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, MapTruth, map_truths};
use gobo::scene::{Scene, View};

fn map_error(context: &Context, scene: &Scene, text: &str, truth: &MapTruth) -> PointError {
    let answers = ask(context, built(context, scene, text).as_ref(), 0, &truth.points);
    point_error(&answers, &truth.visibility).expect("numbers").expect("points")
}

/// Errors measured by a CPU prototype (REFERENCES.md): linear and exponential, streaming, sorted, K = 4, 8, 16.
const PROTOTYPE: [(&str, [f64; 3]); 2] =
    [("linear", [0.0142, 0.0026, 0.00061]), ("exponential,nudge=off", [0.0084, 0.0021, 0.00047])];

/// Errors of another prototype, which fitted nodes to per-cell sums in eight refinement passes that try moving each node: K = 8, 4, 16.
const FITTED: [f64; 3] = [0.0010, 0.0037, 0.00028];

/// Errors of the CPU prototype for particle shadow maps of 64 and 256 slices, in float and in 8 bits.
const PROTOTYPE_SLICES: [(&str, [f64; 2]); 2] =
    [("path=fused,storage=rgba16f", [0.0026, 0.0031]), ("path=raster,storage=rgba8", [0.0031, 0.0036])];

#[test]
fn plume_8k_is_as_accurate_as_the_prototype() {
    if crate::support::is_costly("plume_8k_is_as_accurate_as_the_prototype") {
        return;
    }
    let name = "plume_8k_is_as_accurate_as_the_prototype";
    let Some(data) = shared_data(name) else { return };
    gpu_test(name, |context| {
        let file = data.join("plume_8k.toml");
        let scene = Scene::load(file.to_str().expect("UTF-8"), 0.0).expect("a scene");
        let casters = Casters::new(&scene);
        let truth = map_truths(&casters, &scene, &View::volumes(&scene, 128)).remove(0);
        // The prototype had 470,760 segments in 10,002 texels. Its map was rotated differently about the light's direction, which changes
        // both counts but not their ratio.
        let overlaps = truth.segments as f64 / truth.texels.len() as f64;
        println!("{} texels, {overlaps} segments each", truth.texels.len());
        assert!((overlaps / (470_760.0 / 10_002.0) - 1.0).abs() < 0.01, "{overlaps} segments a covered texel");
        for (curve, expected) in PROTOTYPE {
            for (nodes, expected) in some([8, 4, 16].into_iter().zip([expected[1], expected[0], expected[2]]), 1) {
                let text = format!("avsm:nodes={nodes},curve={curve},path=two-pass,size=128");
                let error = map_error(context, &scene, &text, &truth);
                println!("{text}: {error:?}, the prototype's {expected}");
                assert!((error.mean_abs / expected - 1.0).abs() < 0.1, "{text}: {error:?}, not {expected}");
            }
        }
        for (nodes, most) in some([8, 4, 16].into_iter().zip(FITTED), 1) {
            let error = |fit| {
                let text = format!("avsm:nodes={nodes},path=binned,fit={fit},size=128");
                map_error(context, &scene, &text, &truth)
            };
            let (plain, fitted) = (error("plain"), error("refined"));
            println!("{nodes} nodes, plain: {plain:?}, fitted: {fitted:?}, at most {most}");
            assert!(fitted.mean_abs <= most && fitted.mean_abs < plain.mean_abs, "{nodes} nodes: {fitted:?}");
        }
        for (keys, expected) in PROTOTYPE_SLICES {
            for (slices, expected) in some([64, 256].into_iter().zip(expected), 1) {
                let text = format!("psm:slices={slices},{keys},size=128");
                if !runs(name, context, &text) {
                    continue;
                }
                let error = map_error(context, &scene, &text, &truth);
                println!("{text}: {error:?}, the prototype's {expected}");
                assert!((error.mean_abs / expected - 1.0).abs() < 0.1, "{text}: {error:?}, not {expected}");
            }
        }
        let error = map_error(context, &scene, "uncompressed:size=128", &truth);
        println!("uncompressed: {error:?}");
        assert!(error.mean_abs < 1e-5, "uncompressed: {error:?}");
    });
}

/// Lists are exact at texel centres under any light; the truth is computed independently (f64, a grid, intervals).
#[test]
fn uncompressed_is_exact_at_texel_centres() {
    gpu_test("uncompressed_is_exact_at_texel_centres", |context| {
        let lights = [
            scenes::random(),
            scenes::spot([2.0, 1.0, 3.0], 60.0, scenes::random()),
            // Inside the smoke: particles around and behind the light, clipped at the near plane.
            scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random()),
            scenes::spot([0.0, 0.0, 4.0], 50.0, scenes::nested()),
            scenes::strands(),
            scenes::locks(),
            scenes::spot([2.0, 1.0, 3.0], 60.0, scenes::strands()),
            // Strands that cross the light's own plane.
            scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::locks()),
            scenes::four_lights(),
        ];
        for scene in &lights {
            let technique = built(context, scene, "uncompressed:size=32");
            let mut covered = 0;
            for truth in map_truths(&Casters::new(scene), scene, &View::volumes(scene, 32)) {
                let what = format!("{}, map {} of light {}", scene.name, truth.map, truth.light);
                let answers = ask(context, technique.as_ref(), truth.light, &truth.points);
                // If a point light is beside the smoke, some of its cube faces see no smoke.
                let Some(error) = point_error(&answers, &truth.visibility).expect("numbers") else {
                    assert!(truth.texels.is_empty(), "{what}");
                    continue;
                };
                println!("{what}: {} texels, {error:?}", truth.texels.len());
                assert!(error.mean_abs < 1e-5 && error.p99.is_some_and(|p99| p99 < 1e-4), "{what}: {error:?}");
                covered += truth.texels.len();
            }
            assert!(covered > 100 * scene.lights.len(), "{}: {covered} texels are covered", scene.name);
        }
    });
}

/// On the ray through the centre of a sphere of radius r and extinction σ, exp(−2 r σ) of the light is left behind the sphere, exp(−r σ)
/// at its centre, and all of it in front.
#[test]
fn one_sphere_has_a_closed_form() {
    gpu_test("one_sphere_has_a_closed_form", |context| {
        let (radius, extinction, centre) = (0.75f32, 1.2f32, [0.5f32, -0.25, 1.5]);
        let particle = gobo::scene::Particle { position: centre, radius, extinction };
        let direction = DVec3::new(0.5, 0.3, -0.81).normalize();
        let directional = scenes::directional("sphere", direction.to_array(), vec![particle]);
        let at = DVec3::from(centre.map(f64::from));
        // Aimed at the origin: the sphere's centre is 2 units behind it along the axis, also in the middle of the map.
        let spot = scenes::spot((at * -1.5).to_array(), 40.0, directional.clone());
        for scene in [&directional, &spot] {
            let casters = Casters::new(scene);
            let along = match scene.lights[0].kind {
                gobo::scene::LightKind::Directional { direction } => direction,
                gobo::scene::LightKind::Spot { direction, .. } => direction,
                _ => unreachable!("not among these scenes"),
            };
            let (r, sigma) = (f64::from(radius), f64::from(extinction));
            let places = [(-2.0, 0.0), (-1.01, 0.0), (-0.5, 0.5), (0.0, 1.0), (0.5, 1.5), (1.01, 2.0), (4.0, 2.0)];
            let points = places.map(|(radii, _)| at + along * (radii * r));
            let expected = places.map(|(_, chords)| (-chords * r * sigma).exp());
            for (point, expected) in points.iter().zip(expected) {
                assert!((casters.visibility(0, *point) - expected).abs() < 1e-6, "the reference at {point}");
            }
            // An odd size has a texel centred in the map, at the sphere's centre.
            let points = points.map(|p| p.as_vec3().to_array());
            for text in [
                "uncompressed:size=9",
                "avsm:size=9,nodes=4,path=two-pass,curve=exponential",
                "avsm:size=1,nodes=16,path=two-pass,curve=exponential",
                "avsm:size=17,nodes=4,path=two-pass,resolve=whole",
                "avsm:size=9,nodes=8,path=binned",
            ] {
                let answers = ask(context, built(context, scene, text).as_ref(), 0, &points);
                for ((answer, expected), (radii, _)) in answers.iter().zip(expected).zip(places) {
                    let difference = (f64::from(*answer) - expected).abs();
                    assert!(difference < 1e-4, "{text} at {radii} radii: {answer}, not {expected}");
                }
            }
        }
    });
}
