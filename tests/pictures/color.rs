//! Smoke that absorbs some colors of light more than others: look-ups and pictures against closed forms, the twin, and their colorless
//! counterparts.

use crate::support::{all, built, every_path, gpu_test, rows, scenes, some, those_that_run};
use glam::{DVec2, DVec3};
use gobo::Error;
use gobo::gpu::{Context, Requirement};
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Casters, picture, space_points};
use gobo::reference::twin::colors::color_left;
use gobo::scene::{Camera, Particle, Picture, SKY, Scene, Splat, Strand, View};
use gobo::shading::{Lighting, Renderer, Shading, parse};
use gobo::technique::Technique;
use gobo::world::World;

const SIZE: [u32; 2] = [48, 27];
const RATIO: [f32; 3] = [1.0, 0.5, 0.0];
/// Twins: PARTICLE_ALBEDO, AMBIENT.
const ALBEDO: [f64; 3] = [0.92, 0.92, 0.95];
const AMBIENT: [f64; 3] = [0.10, 0.12, 0.15];

/// A ball around the origin, lit from straight above.
fn ball(radius: f32, extinction: f32, ratio: [f32; 3]) -> Scene {
    let particle = Particle { position: [0.0; 3], radius, extinction };
    Scene { extinction_ratio: ratio, ..scenes::directional("ball", [0.0, 0.0, -1.0], vec![particle]) }
}

/// A ball of smoke of radius 1, with a plate above one corner.
fn ball_and_plate() -> Scene {
    let mut scene = ball(1.0, 1.5, RATIO);
    scene.meshes = vec![scenes::level(1.5, 0.6, [1.0, 1.0]), scenes::level(-1.5, 3.0, [0.0, 0.0])];
    scene
}

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

fn drawn(context: &Context, scene: &Scene, technique: &dyn Technique, lighting: Lighting) -> Picture {
    let world = World::new(context, scene).expect("room for the scene");
    let renderer = Renderer::new(context, &world, &camera(scene)).expect("a renderer");
    renderer.picture(&technique.answer(), Shading::Forward, lighting).expect("drawn")
}

/// Returns the centre of each pixel, in row-major order.
fn middles() -> impl Iterator<Item = DVec2> {
    (0..SIZE[0] * SIZE[1]).map(|i| DVec2::new(f64::from(i % SIZE[0]), f64::from(i / SIZE[0])) + 0.5)
}

/// Returns a picture's error bound for rounding: pixels are half floats if 32-bit floats cannot be blended.
fn rounding(context: &Context) -> f64 {
    if context.features().float32_blend { 2e-5 } else { 2e-3 }
}

/// Returns the look-ups at points for a color with this extinction.
fn asked(context: &Context, technique: &dyn Technique, extinction: f32, points: &[[f32; 3]]) -> Vec<f32> {
    let query =
        Query::of_lights(context, &[PointBatch { light: 0, points, normals: &[] }]).expect("room for the points");
    query.query(&query.color_kernel(&technique.answer(), extinction).expect("a kernel")).expect("asked");
    query.answers().expect("answered")
}

fn points(seed: u64, count: usize) -> Vec<[f32; 3]> {
    let mut random = scenes::Random::new(seed);
    (0..count).map(|_| random.point(-1.4, 1.4)).collect()
}

/// The transmittance of each color is exp(−kτ) inside and below the ball, 1 beside it, and 0 below the plate, even with extinction 0.
#[test]
fn the_truth_of_a_ball_is_a_closed_form() {
    let scene = ball_and_plate();
    let casters = Casters::new(&scene);
    let mut dark = 0;
    for point in points(1, 400) {
        let [x, y, z] = point.map(f64::from);
        let found = casters.colors(0, DVec3::new(x, y, z));
        let half = (1.0 - x * x - y * y).max(0.0).sqrt();
        let depth = 1.5 * (half - z.clamp(-half, half));
        let under_plate = z < 1.5 && (x - 1.0).abs() < 0.6 && (y - 1.0).abs() < 0.6;
        dark += usize::from(under_plate);
        for (found, k) in found.to_array().into_iter().zip(RATIO) {
            let expected = if under_plate { 0.0 } else { (-f64::from(k) * depth).exp() };
            assert!((found - expected).abs() < 1e-12, "{point:?}: {found}, not {expected}");
        }
        assert_eq!(found.x, casters.visibility(0, DVec3::new(x, y, z)), "of extinction 1 it is the truth of all light");
    }
    assert!(dark > 10, "{dark} points under the plate");
}

/// Look-ups of each color match the closed form straight below the middle of a wide ball, where its depth hardly changes from texel to
/// texel.
#[test]
fn look_ups_of_a_ball_are_closed_forms() {
    gpu_test("look_ups_of_a_ball_are_closed_forms", |context| {
        let test = "look_ups_of_a_ball_are_closed_forms";
        let scene = ball(1.0, 1.0, RATIO);
        let specs = [
            "avsm:nodes=16,size=256",
            "uncompressed:size=256",
            "ray-query",
            "layers:size=256",
            "beer-shadow-map:size=256",
        ];
        for text in those_that_run(test, context, specs) {
            let technique = built(context, &scene, text);
            for k in [0.0, 0.25, 0.5, 1.0, 3.0] {
                let below = [[0.01, 0.02, -1.2], [-0.2, 0.1, -3.0]];
                for (point, found) in below.iter().zip(asked(context, technique.as_ref(), k, &below)) {
                    let across = point[0] * point[0] + point[1] * point[1];
                    let expected = (-2.0 * k * (1.0 - across).sqrt()).exp();
                    assert!((found - expected).abs() < 2e-3, "{text}, {k}, {point:?}: {found}, not {expected}");
                }
            }
        }
    });
}

/// For every technique, in smoke and hair: the look-up for a color equals the twin's power of the look-up for all light, to the bit if the
/// extinction is 1, and never increases with extinction.
#[test]
fn look_ups_are_powers_of_grey_ones() {
    if crate::support::is_costly("look_ups_are_powers_of_grey_ones") {
        return;
    }
    gpu_test("look_ups_are_powers_of_grey_ones", |context| {
        let mut scene = scenes::random();
        scene.particles.truncate(150);
        scene.strands = scenes::strands().strands;
        scene.strands.truncate(40);
        let points = points(2, 600);
        let mut asked_of = 0;
        let mut specs = every_path("look_ups_are_powers_of_grey_ones", context);
        specs.retain(|spec| spec.entry.casts.particles && spec.entry.casts.strands);
        if !all() {
            // Keeps one spec per technique, first one for each way of finding casters: maps, a grid's sums, a grid's lists, rays, voxels,
            // slices.
            const FIRST: [&str; 6] = ["avsm", "density-grid", "grid-query", "ray-query", "voxel-grid", "psm"];
            specs.dedup_by_key(|spec| spec.entry.name);
            specs.sort_by_key(|spec| !FIRST.contains(&spec.entry.name));
        }
        for spec in some(specs, 6) {
            let text = spec.short();
            let technique = built(context, &scene, &text);
            let grey = crate::support::ask(context, technique.as_ref(), 0, &points);
            let mut before = vec![1.0f32; points.len()];
            for k in [0.0, 0.3, 1.0, 2.5] {
                let found = asked(context, technique.as_ref(), k, &points);
                for (i, (found, grey)) in found.iter().zip(&grey).enumerate() {
                    let twin = color_left(*grey, 1.0, k);
                    let same = if k == 1.0 { found.to_bits() == grey.to_bits() } else { (found - twin).abs() < 1e-5 };
                    assert!(same, "{text}, {k}, {:?}: {found}, not {twin}", points[i]);
                    // Look-ups for all light may exceed 1 by rounding.
                    assert!((0.0..=1.0 + 1e-5).contains(found), "{text}, {k}: {found}");
                    assert!(*found <= before[i] + 1e-5, "{text}, {k}: {found} after {}", before[i]);
                }
                before = found;
            }
            assert!(grey.iter().any(|v| *v < 0.3), "{text} sees no smoke");
            asked_of += 1;
        }
        assert!(asked_of > 3, "{asked_of} paths");
    });
}

/// For every technique that sees meshes: without smoke each color equals the look-up for all light, to the bit; below the plate even a
/// color that smoke transmits is dark, and beside it, below the smoke, that color is fully lit.
#[test]
fn meshes_have_no_color() {
    if crate::support::is_costly("meshes_have_no_color") {
        return;
    }
    gpu_test("meshes_have_no_color", |context| {
        let mut both = ball_and_plate();
        both.meshes.truncate(1);
        let mut meshes = both.clone();
        meshes.particles.clear();
        let all = points(3, 400);
        let (dark, lit): (Vec<_>, Vec<_>) = [(1.0, 1.0), (0.8, 0.9), (0.0, 0.0), (-0.3, 0.2)]
            .iter()
            .map(|(x, y)| [*x, *y, -1.3])
            .partition(|p| p[0] > 0.5);
        let mut asked_of = 0;
        for spec in every_path("meshes_have_no_color", context) {
            if !spec.entry.casts.meshes {
                continue;
            }
            let text = spec.short();
            let technique = built(context, &meshes, &text);
            let grey = crate::support::ask(context, technique.as_ref(), 0, &all);
            for k in some([0.3, 0.0, 2.5], 2) {
                assert_eq!(asked(context, technique.as_ref(), k, &all), grey, "{text}, {k}");
            }
            assert!(grey.contains(&0.0) && grey.contains(&1.0), "{text} sees a plate");
            if spec.entry.casts.particles {
                let technique = built(context, &both, &text);
                assert_eq!(asked(context, technique.as_ref(), 0.0, &dark), [0.0, 0.0], "{text}, under the plate");
                assert_eq!(asked(context, technique.as_ref(), 0.0, &lit), [1.0, 1.0], "{text}, under the smoke");
                assert!(asked(context, technique.as_ref(), 1.0, &lit).iter().all(|v| *v < 0.3), "{text} sees smoke");
                asked_of += 1;
            }
        }
        assert!(asked_of > 3, "{asked_of} paths");
    });
}

/// Under ambient light alone, a ball in front of the sky has a different opacity for each color.
#[test]
fn what_the_camera_sees_of_a_ball_is_a_closed_form() {
    gpu_test("what_the_camera_sees_of_a_ball_is_a_closed_form", |context| {
        let mut scene = ball(1.0, 0.8, [1.0, 0.4, 0.0]);
        scene.lights[0].radiance = [0.0; 3];
        let camera = camera(&scene);
        let technique = built(context, &scene, "none");
        let tessellates = context.features().lacks(Requirement::Tessellation).is_none();
        let vertex = tessellates.then_some(Lighting::Vertex { spacing: 8.0 });
        for lighting in [Some(Lighting::Fragment), vertex].into_iter().flatten() {
            let found = drawn(context, &scene, technique.as_ref(), lighting);
            let reference = picture(&Casters::new(&scene), &scene, &camera);
            let mut seen = 0;
            for ((at, found), reference) in middles().zip(&found.pixels).zip(&reference.pixels) {
                let ray = camera.ray(at);
                let direction = ray.direction.normalize();
                let nearest = ray.origin - ray.origin.dot(direction) * direction;
                let chord = 2.0 * (1.0 - nearest.length_squared()).max(0.0).sqrt();
                seen += usize::from(chord > 0.0);
                for (channel, k) in scene.extinction_ratio.into_iter().enumerate() {
                    let left = (-f64::from(k) * 0.8 * chord).exp();
                    let expected = ALBEDO[channel] * AMBIENT[channel] * (1.0 - left) + f64::from(SKY[channel]) * left;
                    let wrong = |of: &[f32; 3]| (f64::from(of[channel]) - expected).abs();
                    assert!(wrong(reference) < 1e-6, "the reference at {at}, {channel}: {reference:?}, not {expected}");
                    // A chord's ends are roots of a quadratic: rounding errors are largest for short chords.
                    let allowed = rounding(context) + if chord < 0.1 { 1e-3 } else { 0.0 };
                    assert!(wrong(found) < allowed, "{lighting:?} at {at}, {channel}: {found:?}, not {expected}");
                }
            }
            assert!(seen > 60, "{seen} pixels");
        }
    });
}

/// The ground under a ball, seen from a camera between ball and ground, shows the ball's transmittance of each color, in every shading that
/// stores more than one bit per light.
#[test]
fn the_shadow_of_a_ball_is_a_closed_form() {
    if crate::support::is_costly("the_shadow_of_a_ball_is_a_closed_form") {
        return;
    }
    gpu_test("the_shadow_of_a_ball_is_a_closed_form", |context| {
        let mut scene = ball(1.0, 0.7, [1.0, 0.4, 0.0]);
        scene.meshes = vec![scenes::level(-3.0, 4.0, [0.0, 0.0])];
        scene.camera = Camera {
            position: DVec3::new(0.3, -0.2, -1.4),
            target: DVec3::new(0.0, 0.1, -3.0),
            up: DVec3::Y,
            fov_y_degrees: 50.0,
        };
        let camera = camera(&scene);
        let world = World::new(context, &scene).expect("room for the scene");
        let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
        let test = "the_shadow_of_a_ball_is_a_closed_form";
        for text in those_that_run(test, context, ["uncompressed:size=512", "ray-query", "avsm:nodes=16,size=512"]) {
            let technique = built(context, &scene, text);
            for shading in [Shading::Forward, Shading::Deferred, Shading::Interleaved, Shading::Reservoir] {
                let found = renderer.picture(&technique.answer(), shading, Lighting::Fragment).expect("drawn");
                // Interleaved and reservoir shading average over 4 × 4 pixels, and all shadings have errors from the maps' texels and from
                // 32-bit normals.
                let averages = matches!(shading, Shading::Interleaved | Shading::Reservoir);
                let (reach, allowed) = if averages { (0.6, 0.02) } else { (0.9, 4e-3) };
                let mut counted = 0;
                for (at, found) in middles().zip(&found.pixels) {
                    let ray = camera.ray(at);
                    let on = ray.at((-3.0 - ray.origin.z) / ray.direction.z).truncate();
                    if on.length() > reach {
                        continue; // silhouette texels
                    }
                    counted += 1;
                    let chord = 2.0 * (1.0 - on.length_squared()).sqrt();
                    for (channel, k) in scene.extinction_ratio.into_iter().enumerate() {
                        let light = AMBIENT[channel] + (-f64::from(k) * 0.7 * chord).exp();
                        let wrong = (f64::from(found[channel]) - 0.6 * light).abs();
                        assert!(
                            wrong < allowed,
                            "{text}, {shading:?} at {at}, {channel}: {found:?}, not {}",
                            0.6 * light
                        );
                    }
                }
                assert!(counted > 100, "{counted} pixels");
            }
            // A shading that stores one bit per light is refused by name.
            let tiled = Shading::of(
                &parse(&format!("{text},shading=tiled").replace("query,", "query:")).expect("a spec")[0].settings(),
            );
            let refused = renderer.picture(&technique.answer(), tiled, Lighting::Fragment);
            assert!(
                matches!(&refused, Err(Error::Refused(needs)) if needs.to_string().contains("tiled")),
                "{:?}",
                refused.err()
            );
        }
        let mut smoke = scene.clone();
        smoke.meshes.clear();
        let world = World::new(context, &smoke).expect("room for the scene");
        let renderer = Renderer::new(context, &world, &View::camera(&smoke.camera, &smoke, SIZE)).expect("a renderer");
        let painter = built(context, &smoke, "half-angle");
        let refused = renderer.picture_of(painter.as_ref(), Shading::Forward, Lighting::Fragment);
        assert!(
            matches!(&refused, Err(Error::Refused(needs)) if needs.to_string().contains("[color]")),
            "{:?}",
            refused.err()
        );
    });
}

/// A picture of all kinds of casters over a ground equals the reference's.
#[test]
fn pictures_are_those_of_the_reference() {
    gpu_test("pictures_are_those_of_the_reference", |context| {
        let mut scene = ball_and_plate();
        scene.strands = vec![Strand { start: [-1.2, -0.9, 0.6], radius: 0.15, end: [0.2, -1.3, 0.4], opacity: 0.7 }];
        scene.splats = vec![Splat {
            position: [-1.3, 0.4, 0.2],
            deviations: [0.3, 0.2, 0.15],
            rotation: [0.0, 0.0, 0.0, 1.0],
            opacity: 0.8,
            color: [0.3, 0.7, 0.5],
        }];
        let reference = picture(&Casters::new(&scene), &scene, &camera(&scene));
        for text in
            those_that_run("pictures_are_those_of_the_reference", context, ["ray-query", "uncompressed:size=512"])
        {
            let technique = built(context, &scene, text);
            let found = drawn(context, &scene, technique.as_ref(), Lighting::Fragment);
            for channel in 0..3 {
                let apart =
                    found.pixels.iter().zip(&reference.pixels).map(|(a, b)| f64::from(a[channel] - b[channel]).abs());
                let mean = apart.sum::<f64>() / found.pixels.len() as f64;
                assert!(mean < 2e-3, "{text}: channel {channel} is off by {mean}");
            }
            // Without color the picture differs.
            let grey = Scene { extinction_ratio: Scene::GREY, ..scene.clone() };
            let grey = drawn(context, &grey, technique.as_ref(), Lighting::Fragment);
            let apart = |channel: usize| {
                let of = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(a[channel] - b[channel]).abs();
                grey.pixels.iter().zip(&found.pixels).map(of).sum::<f64>() / found.pixels.len() as f64
            };
            assert!(apart(0) == 0.0 && apart(1) > 0.01 && apart(2) > 0.02, "{:?}", [0, 1, 2].map(apart));
        }
    });
}

/// Rows report an error for each color: with extinction 1 it equals the error for all light, and with extinction 0.5 the error in smoke
/// with half the extinction. Rows of a colorless scene have none.
#[test]
fn rows_have_an_error_of_each_color() {
    gpu_test("rows_have_an_error_of_each_color", |context| {
        let scene = ball_and_plate();
        let specs = ["none", "beer-shadow-map:size=64"];
        let colored = rows(context, &scene, &specs);
        let mut thin = scene.clone();
        thin.particles[0].extinction *= 0.5;
        thin.extinction_ratio = Scene::GREY;
        let thin = rows(context, &thin, &specs);
        assert!(thin.iter().all(|row| row.colors.is_empty() && row.error.is_some()));
        for row in &colored {
            let [red, green, blue] = &row.colors[..] else { panic!("{}: {:?}", row.technique, row.colors) };
            assert_eq!(
                [red, green, blue].map(|e| (e.color.as_str(), e.extinction as f32)),
                [("red", 1.0), ("green", 0.5), ("blue", 0.0)]
            );
            let error = row.error.as_ref().expect("a truth");
            for (of_all, of_red) in [(error.space, red.space), (error.surface, red.surface)] {
                let (of_all, of_red) = (of_all.expect("points"), of_red.expect("points"));
                assert_eq!((of_all.mean_abs, of_all.bias, of_all.max), (of_red.mean_abs, of_red.bias, of_red.max));
            }
        }
        // A technique that always returns 1 is off by exactly the light that the smoke absorbs.
        let of = |row: &gobo::bench::Row| row.error.as_ref().and_then(|e| e.space).expect("points").mean_abs;
        let green = colored[0].colors[1].space.expect("points").mean_abs;
        assert!((green - of(&thin[0])).abs() < 1e-9, "{green}, and {} of half the extinction", of(&thin[0]));
        let all = [0, 1, 2].map(|i| colored[1].colors[i].space.expect("points").mean_abs);
        assert!(all[0] > all[1] && all[1] > all[2], "a power below 1 of what is little off is less off: {all:?}");
    });
}

/// The figures in docs/notebook/color.md for casters of two inks: `cargo test --release --test pictures two_inks -- --nocapture`. A single
/// curve with the mean of the inks' ratios has a large error, however exact the curve; one curve per ink, with three exponents each, is as
/// accurate as the curves themselves.
#[test]
fn two_inks_take_two_curves() {
    gpu_test("two_inks_take_two_curves", |context| {
        let ink = Scene::load("ink", 0.0).expect("built in");
        let drop = ink.particles.len() / 4;
        let of = |first: usize| {
            let some = ink.particles.iter().enumerate().filter(|(i, _)| i / drop % 2 == first);
            Scene { particles: some.map(|(_, particle)| *particle).collect(), ..ink.clone() }
        };
        let (inks, ratios) = ([of(0), of(1)], [[1.0f32, 0.55, 0.2], [0.2, 0.6, 1.0]]);
        // Light absorbed by each ink from all directions: volume times extinction.
        let takes =
            inks.each_ref().map(|scene| scene.particles.iter().map(|p| p.radius.powi(3) * p.extinction).sum::<f32>());
        let mean = [0, 1, 2].map(|c| (takes[0] * ratios[0][c] + takes[1] * ratios[1][c]) / (takes[0] + takes[1]));
        let points = space_points(&ink, 0, 20_000);
        let casters = inks.each_ref().map(Casters::new);
        let depths: Vec<_> = points
            .iter()
            .map(|p| {
                let at = DVec3::from(p.map(f64::from));
                let lit = casters[0].unblocked(0, at);
                (f64::from(u8::from(lit)), casters.each_ref().map(|casters| casters.optical_depth(0, at)))
            })
            .collect();
        let left = |k: [f32; 2]| {
            let of = move |(lit, [a, b]): &(f64, [f64; 2])| lit * (-f64::from(k[0]) * a - f64::from(k[1]) * b).exp();
            depths.iter().map(of).collect::<Vec<f64>>()
        };
        let off = |found: &[f64], truth: &[f64]| {
            found.iter().zip(truth).map(|(a, b)| (a - b).abs()).sum::<f64>() / truth.len() as f64
        };
        let wide = |found: Vec<f32>| found.into_iter().map(f64::from).collect::<Vec<_>>();
        let avsm = "avsm:path=binned";
        let [one, first] = [&ink, &inks[0]].map(|scene| built(context, scene, avsm));
        // Meshes must count only once.
        let second = built(context, &Scene { meshes: Vec::new(), ..inks[1].clone() }, avsm);
        for (c, color) in ["red", "green", "blue"].into_iter().enumerate() {
            let [a, b] = [ratios[0][c], ratios[1][c]];
            let truth = left([a, b]);
            let exact = off(&left([mean[c]; 2]), &truth);
            let one = off(&wide(asked(context, one.as_ref(), mean[c], &points)), &truth);
            let halves = wide(asked(context, first.as_ref(), a, &points)).into_iter().zip(wide(asked(
                context,
                second.as_ref(),
                b,
                &points,
            )));
            let two = off(&halves.map(|(a, b)| a * b).collect::<Vec<_>>(), &truth);
            println!(
                "{color}: mean ratio {:.3}; off by {exact:.5} with the true curve, {one:.5} with one of avsm, {two:.5} with two",
                mean[c]
            );
            assert!(two < 4e-3, "{color}: two curves are off by {two}");
            // Both inks absorb about the same amount of green.
            assert!(color == "green" || exact > 5.0 * two, "{color}: {exact} with a mean ratio, {two} with two curves");
        }
    });
}
