//! The look-up, and how storages and assignments affect it.

use super::{built, kept, rays};
use crate::support::scenes::{self, Random};
use crate::support::{all, ask, gpu_test, gpu_test_needing, runs, some, spec, those_that_run};
use glam::{DVec2, DVec3, Vec2};
use gobo::bench::{PointError, point_error};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::{Casters, map_truths};
use gobo::reference::twin::filter::Filter;
use gobo::reference::twin::psm;
use gobo::scene::{Particle, Scene, View};
use gobo::technique::Technique;

/// Returns particles along the light's axis, which points down: for each depth (0 to 1 of the range) one with that optical depth along the
/// axis. Two without extinction, whose ends span the range, fix the view.
fn column(casters: &[(f64, f64)]) -> Scene {
    let held = [-2.0, 2.0].map(|z| Particle { position: [0.0, 0.0, z], radius: 1.0, extinction: 0.0 });
    let mut scene = scenes::directional("column", [0.0, 0.0, -1.0], held.to_vec());
    let view = View::volumes(&scene, 9)[0];
    for (depth, optical_depth) in casters {
        let at = view.ray(DVec2::splat(4.5)).at(view.z(*depth));
        let (radius, position) = (0.01, at.as_vec3().into());
        scene.particles.push(Particle { position, radius, extinction: *optical_depth as f32 / (2.0 * radius) });
    }
    scene
}

fn on_axis(scene: &Scene, depth: f64) -> [f32; 3] {
    let view = View::volumes(scene, 9)[0];
    view.ray(DVec2::splat(4.5)).at(view.z(depth)).as_vec3().into()
}

/// A caster at its slice's centre: full light in front of the slice, half of the shadow half a slice behind its near face, all of it
/// behind. At both ends of the volume, and on both sides of a packed texel's boundary.
#[test]
fn a_shadow_begins_and_ends_with_its_slice() {
    let name = "a_shadow_begins_and_ends_with_its_slice";
    gpu_test(name, |context| {
        let slices = 32u32;
        let paths = [
            "psm:path=raster",
            "psm:path=fused",
            "psm:path=fused,assign=split",
            "psm:path=raster,storage=optical-depth",
        ];
        let paths = those_that_run(name, context, paths);
        for slice in some([3, 4, 29, 2, 5, 15, 16, 28], 3) {
            let face = |k: f64| k / f64::from(slices);
            let depth = face(f64::from(slice) + 0.5);
            let scene = column(&[(depth, 0.7)]);
            let left = (-0.7f64).exp();
            let from = f64::from(slice);
            let places = [0.0, face(from - 1.0), face(from), depth, face(from + 1.0), face(from + 2.0), 1.0];
            let expected = [1.0, 1.0, 1.0, 0.5 + 0.5 * left, left, left, left];
            let points: Vec<_> = places.iter().map(|d| on_axis(&scene, *d)).collect();
            for keys in &paths {
                let psm = built(context, &scene, &format!("{keys},size=9,slices={slices}"));
                for (answer, expected) in ask(context, psm.as_ref(), 0, &points).into_iter().zip(expected) {
                    // Half a code of 8 bits, plus the rounding of blending.
                    let difference = (f64::from(answer) - expected).abs();
                    assert!(difference < 1.0 / 255.0, "{keys}, slice {slice}: {answer}, not {expected}");
                }
            }
        }
    });
}

/// The second map's layers follow the first map's, and its coverage layer if that is drawn.
#[test]
fn look_up_equals_its_twin() {
    let name = "look_up_equals_its_twin";
    gpu_test(name, |context| {
        let mut random = Random::new(11);
        let two = || {
            let mut scene = scenes::random();
            scene.lights.extend(scenes::directional("", [0.5, -0.4, -0.7], vec![]).lights);
            scene
        };
        for (scene, light, keys, filter) in [
            (scenes::random(), 0, "storage=rgba8", Filter::Bilinear),
            (scenes::locks(), 0, "storage=optical-depth", Filter::Bilinear),
            (two(), 1, "path=fused", Filter::Bilinear),
            (two(), 1, "path=raster,coverage=viewport", Filter::Bilinear),
            (two(), 1, "path=raster,coverage=viewport,filter=box,radius=2", Filter::Box(2)),
            (two(), 1, "path=fused,storage=optical-depth,filter=gaussian,radius=1", Filter::Gaussian(1)),
        ] {
            let text = format!("psm:size=24,slices=24,{keys}");
            if !runs(name, context, &text) {
                continue;
            }
            let psm = built(context, &scene, &text);
            let spec = spec(&text);
            let rays = rays(&psm, &spec, scene.map_count());
            let view = psm.inspect().maps()[light].caster_view;
            let mut points = Vec::new();
            let mut expected = Vec::new();
            for _ in 0..4000 {
                // Some points lie past the map's edges, where all of the light remains.
                let at = DVec2::new(random.between(-1.0, 25.0).into(), random.between(-1.0, 25.0).into());
                let depth = random.between(0.001, 1.1);
                points.push(view.ray(at).at(view.z(depth.into())).as_vec3().into());
                let sum = filter.weights(Vec2::splat(24.0), at.as_vec2()).into_iter().map(|(texel, weight)| {
                    let inside = texel.min_element() >= 0 && texel.max_element() < 24;
                    let ray = || kept(&spec, rays.at(light, texel.y as u32 * 24 + texel.x as u32));
                    f64::from(weight) * if inside { f64::from(psm::look_up(&ray(), depth)) } else { 1.0 }
                });
                expected.push(sum.sum::<f64>());
            }
            let darkest = expected.iter().copied().fold(1.0, f64::min);
            assert!(darkest < 0.5, "{text}: nothing but light, {darkest}");
            for (answer, expected) in ask(context, psm.as_ref(), light, &points).into_iter().zip(expected) {
                // Samplers may quantize weights to 256ths, in each direction.
                assert!((f64::from(answer) - expected).abs() < 2.0 / 256.0, "{text}: {answer}, not {expected}");
            }
        }
    });
}

/// Casters in the dark behind a mesh are left out of the bins, and no look-up changes.
#[test]
fn skipping_changes_no_answer() {
    gpu_test("skipping_changes_no_answer", |context| {
        let mut scene = scenes::random();
        scene.lights = scenes::directional("", [0.0, 0.0, -1.0], vec![]).lights;
        scene.meshes.push(scenes::level(0.0, 3.0, [0.0, 0.0]));
        let mut random = Random::new(13);
        let points: Vec<_> = (0..4000).map(|_| random.point(-1.3, 1.3)).collect();
        let [on, off] = ["on", "off"].map(|skip| {
            let psm = built(context, &scene, &format!("psm:path=fused,size=40,slices=64,skip={skip}"));
            (ask(context, psm.as_ref(), 0, &points), psm.inspect().facts().expect("counted").counters["culled_casters"])
        });
        assert!(on.1 > off.1, "nothing is culled");
        for (on, off) in on.0.iter().zip(&off.0) {
            // Fewer casters are summed in finer units: an 8-bit code may differ.
            assert!((on - off).abs() <= 1.01 / 255.0, "{on} with skip=on, {off} without");
        }
        assert!(on.0.contains(&0.0) && on.0.iter().any(|v| *v > 0.5), "no dark and light");
    });
}

/// Returns particles of one opacity, about a thousand of them on every ray.
fn thin(opacity: f64) -> Scene {
    let mut random = Random::new(12);
    let radius = 1.0f32;
    let extinction = -(1.0 - opacity).ln() as f32 / (2.0 * radius);
    let particles = (0..1000)
        .map(|_| Particle {
            position: [random.between(-0.1, 0.1), random.between(-0.1, 0.1), random.between(-20.0, 20.0)],
            radius,
            extinction,
        })
        .collect();
    scenes::directional("thin", [0.0, 0.0, -1.0], particles)
}

fn map_error(context: &Context, scene: &Scene, text: &str) -> PointError {
    let psm = built(context, scene, text);
    let views: Vec<_> = psm.inspect().maps().iter().map(|m| m.caster_view).collect();
    let truth = map_truths(&Casters::new(scene), scene, &views).remove(0);
    let answers = ask(context, psm.as_ref(), 0, &truth.points);
    point_error(&answers, &truth.visibility).expect("numbers").expect("points")
}

/// Multiplying in 8 bits stalls on thin media; adding optical depths does not.
#[test]
fn thin_media_need_optical_depths() {
    gpu_test_needing("thin_media_need_optical_depths", &[Requirement::Layers], |context| {
        for opacity in some([0.002, 0.02], 1) {
            let scene = thin(opacity);
            let error = |keys: &str| {
                let error = map_error(context, &scene, &format!("psm:size=32,{keys}"));
                println!("opacity {opacity}, {keys}: {error:?}");
                error.mean_abs
            };
            let added = error("path=raster,storage=optical-depth");
            let multiplied = error("path=raster,storage=rgba8");
            error("path=raster,storage=rgba16f");
            let fused = error("path=fused,storage=rgba8");
            assert!(added <= 0.003 && error("path=fused,storage=optical-depth") <= 0.003, "{added}");
            // A stored 8-bit transmittance is off by half a code at most.
            assert!(fused <= 0.003 + 0.5 / 255.0, "{fused}");
            if opacity == 0.002 {
                assert!(multiplied > 10.0 * added, "{multiplied}, {added}");
            }
        }
    });
}

/// Behind the slices that a particle moves through, its shadow jumps in one step with assign=nearest. With assign=split, its optical depth
/// τ shifts gradually from slice to slice: over a frame of `moved` slices no value can change by more than τ · moved, the slope of T^(1 −
/// w) in w, plus a step of the storage.
#[test]
fn nothing_pops_when_it_is_split() {
    let name = "nothing_pops_when_it_is_split";
    gpu_test(name, |context| {
        let (slices, optical_depth, moved) = (16.0, 1.0f64, 1.0 / 8.0);
        let largest = |assign: &str, path: &str| {
            let mut last: Option<Vec<f32>> = None;
            let mut largest = 0.0f64;
            for frame in 0..if all() { 33 } else { 12 } {
                let at = (6.0 + moved * f64::from(frame)) / slices;
                let scene = column(&[(at, optical_depth)]);
                let text = format!("psm:size=9,slices=16,storage=rgba16f,assign={assign},path={path}");
                let points: Vec<_> = (0..=32).map(|i| on_axis(&scene, f64::from(i) / 32.0)).collect();
                let now = ask(context, built(context, &scene, &text).as_ref(), 0, &points);
                for (now, before) in now.iter().zip(last.iter().flatten()) {
                    largest = largest.max(f64::from((now - before).abs()));
                }
                last = Some(now);
            }
            largest
        };
        for path in ["raster", "fused"] {
            if !runs(name, context, &format!("psm:slices=16,path={path}")) {
                continue;
            }
            let (nearest, split) = (largest("nearest", path), largest("split", path));
            println!("{path}: largest step of a frame: nearest {nearest}, split {split}");
            assert!(nearest > 0.95 * (1.0 - (-optical_depth).exp()), "{path}: {nearest}");
            assert!(split <= optical_depth * moved + 4.0 / 2048.0, "{path}: {split}");
        }
    });
}

#[test]
fn the_view_holds() {
    let views = [0.3, 0.6].map(|depth| View::volumes(&column(&[(depth, 1.0)]), 9)[0]);
    assert_eq!(bytes_of(&views[0]), bytes_of(&views[1]), "casters inside do not move the view");
    let point = DVec3::from(on_axis(&column(&[]), 0.5).map(f64::from));
    assert!(point.length() < 1e-6, "{point}");
}

fn bytes_of(view: &View) -> Vec<u8> {
    bytemuck::bytes_of(view).to_vec()
}
