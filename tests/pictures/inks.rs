//! Casters with several extinction ratios: each color of each light gives the same look-ups as a grey scene whose casters were scaled by
//! hand.

mod pictures;

mod truth;

use crate::support::{all, ask, built, every_path, gpu_test, rows, scenes, some, spec, those_that_run};
use glam::DVec3;
use gobo::Error;
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, space_points};
use gobo::scene::{ExtinctionGroup, Field, Light, LightKind, Placed, Scene, Splat, Volume};
use gobo::shading::{Lighting, Shading};
use gobo::technique::{self, Name, Spec};
use gobo::world::World;
use pictures::renderer;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Powers of two: products with them are exact, so extinctions scaled by hand have the same bits.
const RATIOS: [[f32; 3]; 3] = [[1.0, 0.5, 0.0], [0.25, 1.0, 0.5], [0.5, 0.0, 1.0]];

/// Ratios of volumes, which cannot be scaled by hand to an extinction of 0.
const VOLUME_RATIOS: [[f32; 3]; 2] = [[1.0, 0.5, 0.25], [0.25, 1.0, 0.5]];

/// A scene of several inks, and for each color the equivalent grey scene scaled by hand, with the original lights.
struct Both {
    inks: Scene,
    grey: [Scene; 3],
    lights: usize,
}

impl Both {
    /// Creates the inked scene and its grey ones from `scene`. Its casters get the ratios in turn, in runs of `run` casters; each volume
    /// has one ratio.
    fn of(scene: Scene, run: usize) -> Self {
        let ratio = |i: usize| RATIOS[i / run % 3];
        let inks = |count: usize| (0..count).map(move |i| ExtinctionGroup { casters: 1, ratio: ratio(i) });
        let all = inks(scene.particles.len()).chain(inks(scene.strands.len())).chain(inks(scene.splats.len()));
        let volumes = scene.volumes.iter().enumerate();
        let cells =
            volumes.map(|(i, volume)| ExtinctionGroup { casters: volume.cells().len(), ratio: VOLUME_RATIOS[i % 2] });
        let all: Vec<ExtinctionGroup> = all.chain(cells).collect();
        let grey = [0, 1, 2].map(|color| {
            let mut grey = scene.clone();
            let k = |i: usize| f64::from(ratio(i)[color]);
            let thinner = |opacity: f32, k: f64| (1.0 - (1.0 - f64::from(opacity)).powf(k)) as f32;
            grey.particles.iter_mut().enumerate().for_each(|(i, p)| p.extinction *= k(i) as f32);
            grey.strands.iter_mut().enumerate().for_each(|(i, s)| s.opacity = thinner(s.opacity, k(i)));
            // A splat's extinction is proportional to −ln(1 − opacity) too.
            grey.splats.iter_mut().enumerate().for_each(|(i, g)| g.opacity = thinner(g.opacity, k(i)));
            for (i, volume) in grey.volumes.iter_mut().enumerate() {
                let placed = *volume.placed();
                let extinction = placed.extinction * f64::from(VOLUME_RATIOS[i % 2][color]);
                *volume =
                    Volume::new(Arc::new(volume.field().clone()), Placed { extinction, ..placed }).expect("a volume");
            }
            grey
        });
        let lights = scene.lights.len();
        Self { inks: scene.with_inks(&all).expect("inks"), grey, lights }
    }
}

/// Smoke over a plate, under a directional light and a spot light.
fn smoke() -> Scene {
    let mut scene = scenes::random();
    scene.particles.truncate(150);
    scene.meshes = vec![scenes::level(-1.3, 1.5, [0.2, 0.1]), scenes::level(1.5, 0.4, [0.8, 0.8])];
    let position = DVec3::new(0.5, -0.6, 4.0);
    let kind = LightKind::Spot { position, direction: DVec3::NEG_Z, cone_degrees: 50.0 };
    scene.lights.push(Light { kind, radiance: [0.5, 1.0, 2.0], radius: f64::INFINITY });
    scene
}

/// A ball-shaped field, placed at `at`.
fn ball(at: DVec3) -> Volume {
    let samples = (0..9 * 9 * 9).map(|i| {
        let place = [i % 9, i / 9 % 9, i / 81];
        let from = DVec3::from(place.map(f64::from)) / 4.0 - 1.0;
        (place, (1.0 - from.length_squared()).max(0.0) as f32)
    });
    let field = Field::new(samples).expect("a field");
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 0.1 * axis);
    let placed = Placed { origin: at, steps, extinction: 2.0, color: [0.9, 0.5, 0.2], side: 1 };
    Volume::new(Arc::new(field), placed).expect("a volume")
}

/// All kinds of casters over a plate.
fn all_kinds() -> Scene {
    let mut scene = smoke();
    scene.particles.truncate(60);
    scene.lights.truncate(1);
    scene.strands = scenes::strands().strands;
    scene.strands.truncate(60);
    let mut random = scenes::Random::new(7);
    scene.splats = (0..12)
        .map(|_| Splat {
            position: random.point(-0.9, 0.9),
            deviations: [0.2, 0.1, 0.07],
            rotation: [0.0, 0.0, 0.0, 1.0],
            opacity: random.between(0.2, 0.8),
            color: [0.3, 0.7, 0.5],
        })
        .collect();
    scene.volumes = vec![ball(DVec3::new(-0.9, 0.1, 0.0)), ball(DVec3::new(0.2, -0.9, -0.3))];
    scene
}

fn points(seed: u64, count: usize) -> Vec<[f32; 3]> {
    let mut random = scenes::Random::new(seed);
    (0..count).map(|_| random.point(-1.3, 1.3)).collect()
}

/// Returns every path, and other variants of techniques that iterate over casters, with small maps.
fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    let more = [
        "avsm:path=binned,resolve=streaming",
        // Enough bytes for the finest detail in each tile, so that one color's tiles do not take blocks from another's.
        "avsm:path=binned,detail=adaptive,bytes=100000000",
        "avsm:path=binned,texel=area",
        "avsm:path=two-pass,resolve=whole",
        "psm:path=raster,route=geometry,slices=64",
        "psm:path=raster,route=vertex,slices=64",
        "psm:path=raster,coverage=tiles,assign=split,slices=64",
        "stochastic:path=binned,sampling=stratified",
        "stochastic:path=binned,sampling=hash",
    ];
    specs.extend(those_that_run(test, context, some(more, 2)).into_iter().map(spec));
    for spec in &mut specs {
        if !["psm", "voxelized", "density-grid", "optical-depth-grid", "voxel-grid"].contains(&spec.entry.name) {
            spec.set(Name::SIZE, "28");
        }
    }
    specs
}

/// Techniques that store one number for all lights.
const ONE_NUMBER: [&str; 6] =
    ["density-grid", "grid-query", "marched", "optical-depth-grid", "ray-query", "voxel-grid"];

#[test]
fn each_color_is_a_grey_scene_made_by_hand() {
    if crate::support::is_costly("each_color_is_a_grey_scene_made_by_hand") {
        return;
    }
    let test = "each_color_is_a_grey_scene_made_by_hand";
    gpu_test(test, |context| {
        let both = Both::of(smoke(), 5);
        let world = World::new(context, &both.inks).expect("room for the scene");
        let points = points(1, 500);
        let mut told_apart = BTreeSet::new();
        for spec in specs(test, context) {
            let text = spec.short();
            if ONE_NUMBER.contains(&spec.entry.name) {
                let refused = technique::open(context, &world, &spec).err().map(|e| e.to_string());
                let words = "refused: needs casters of one extinction ratio: ";
                assert!(
                    refused.as_ref().is_some_and(|r| r.starts_with(words) && !r.contains('\n')),
                    "{text}: {refused:?}"
                );
                continue;
            }
            let technique = built(context, &both.inks, &text);
            let mut of_colors = Vec::new();
            for (color, grey) in both.grey.iter().enumerate() {
                let by_hand = built(context, grey, &text);
                for light in 0..both.lights {
                    let found = ask(context, technique.as_ref(), color * both.lights + light, &points);
                    let expected = ask(context, by_hand.as_ref(), light, &points);
                    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                        // Lists are summed in their order of capture, which may vary.
                        let near = spec.entry.name == "uncompressed" && (found - expected).abs() < 1e-5;
                        assert!(
                            near || found.to_bits() == expected.to_bits(),
                            "{text}, color {color}, light {light}, {:?}: {found}, not {expected}",
                            points[i]
                        );
                    }
                    of_colors.push(expected);
                }
            }
            if spec.entry.casts.particles {
                let apart = of_colors[0].iter().zip(&of_colors[both.lights]).filter(|(a, b)| (**a - **b).abs() > 0.05);
                assert!(apart.count() > 50, "{text} has colors");
                told_apart.insert(spec.entry.name);
            }
        }
        assert!(told_apart.len() > 3 && told_apart.contains("avsm"), "{told_apart:?}");
    });
}

/// A point light has six maps, so that a color has more maps than lights.
#[test]
fn each_color_of_a_point_light_is_a_grey_scene_made_by_hand() {
    let test = "each_color_of_a_point_light_is_a_grey_scene_made_by_hand";
    gpu_test(test, |context| {
        let mut scene = smoke();
        scene.particles.truncate(60);
        let kind = LightKind::Point { position: DVec3::new(0.1, -0.2, 0.3) };
        scene.lights[0] = Light { kind, ..scene.lights[0] };
        let both = Both::of(scene, 4);
        assert_ne!(both.inks.map_count(), both.inks.lights.len());
        let points = points(6, 300);
        let texts = ["avsm:path=binned,size=28", "avsm:path=two-pass,size=28", "layers:size=28", "psm:slices=64"];
        for text in those_that_run(test, context, some(texts, 1)) {
            let technique = built(context, &both.inks, text);
            for (color, grey) in both.grey.iter().enumerate() {
                let by_hand = built(context, grey, text);
                for light in 0..both.lights {
                    let found = ask(context, technique.as_ref(), color * both.lights + light, &points);
                    let expected = ask(context, by_hand.as_ref(), light, &points);
                    // The layers of all maps share one image, so a fetch's coordinate is divided by the number of layers, and rounded.
                    let most = if text.starts_with("psm") { 1e-5 } else { 0.0 };
                    let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(apart <= most, "{text}, color {color}, light {light}: {apart}");
                }
            }
        }
    });
}

/// Compares each color of hair, splats and volumes too; their extinctions scaled by hand are rounded differently.
#[test]
fn each_color_of_all_kinds_is_a_grey_scene_made_by_hand() {
    let test = "each_color_of_all_kinds_is_a_grey_scene_made_by_hand";
    gpu_test(test, |context| {
        let both = Both::of(all_kinds(), 4);
        let points = points(2, 500);
        let texts = [
            "uncompressed:size=64",
            "avsm:path=binned,size=64",
            "avsm:path=two-pass,size=64",
            "avsm:path=binned,detail=adaptive,bytes=100000000,size=32",
            "layers:size=64",
            "moments:size=64",
            "psm:slices=64",
            "psm:path=raster,slices=64",
        ];
        for text in those_that_run(test, context, some(texts, 2)) {
            let technique = built(context, &both.inks, text);
            for (color, grey) in both.grey.iter().enumerate() {
                let by_hand = built(context, grey, text);
                let found = ask(context, technique.as_ref(), color, &points);
                let expected = ask(context, by_hand.as_ref(), 0, &points);
                let off = found.iter().zip(&expected).map(|(a, b)| f64::from(a - b).abs());
                let mean = off.sum::<f64>() / points.len() as f64;
                // The same segments, with extinctions rounded once more: the last bits of floats. If these bits decide a byte of `psm`, or
                // which node `avsm` drops, a point differs by about 1/255; one in twenty may.
                assert!(mean < 2e-4, "{text}, color {color}: {mean}");
                assert!(expected.iter().any(|v| *v < 0.5), "{text} sees casters");
            }
        }
    });
}

/// With `detail=adaptive` the tiles of all colors share the bytes, while a grey scene scaled by hand has all of them for one color:
/// look-ups differ, with the same error over all colors.
#[test]
fn adaptive_tiles_of_colors_share_their_bytes() {
    gpu_test("adaptive_tiles_of_colors_share_their_bytes", |context| {
        let mut scene = all_kinds();
        scene.meshes.clear();
        let both = Both::of(scene, 4);
        let (casters, points) = (Casters::new(&both.inks), points(5, 2000));
        let text = "avsm:path=binned,detail=adaptive,size=64";
        let technique = built(context, &both.inks, text);
        let mean = |off: &mut dyn Iterator<Item = f64>| off.sum::<f64>() / points.len() as f64;
        let mut sums = [0.0; 3];
        for (color, grey) in both.grey.iter().enumerate() {
            let found = ask(context, technique.as_ref(), color, &points);
            let by_hand = ask(context, built(context, grey, text).as_ref(), 0, &points);
            let truth: Vec<_> =
                points.iter().map(|p| casters.visibility(color, DVec3::from(p.map(f64::from))) as f32).collect();
            let pairs = [(&found, &by_hand), (&found, &truth), (&by_hand, &truth)];
            let off = pairs.map(|(a, b)| mean(&mut a.iter().zip(b).map(|(a, b)| f64::from(a - b).abs())));
            println!("color {color}: apart by {:.6}, off by {:.6}, by hand {:.6}", off[0], off[1], off[2]);
            (0..3).for_each(|i| sums[i] += off[i]);
        }
        let [apart, shared, alone] = sums;
        assert!(apart > 0.0 && apart < 0.5 * alone, "apart by {apart}, off by {alone}");
        assert!(shared < 1.1 * alone, "{shared}, and {alone} where each color has bytes of its own");
    });
}

/// The errors of each color equal those of the grey scenes scaled by hand, and their mean is the error over all light.
#[test]
fn rows_have_an_error_of_each_color() {
    if crate::support::is_costly("rows_have_an_error_of_each_color") {
        return;
    }
    gpu_test("rows_have_an_error_of_each_color", |context| {
        let mut scene = smoke();
        scene.lights.truncate(1);
        let both = Both::of(scene, 5);
        let specs = ["none", "avsm:path=binned,size=64", "layers:size=64", "density-grid:size=64"];
        let found = rows(context, &both.inks, &specs);
        assert!(found[3].reason.contains("casters of one extinction ratio"), "{}", found[3].reason);
        let by_hand = both.grey.each_ref().map(|grey| rows(context, grey, &specs[..3]));
        for (i, row) in found[..3].iter().enumerate() {
            let names: Vec<_> = row.colors.iter().map(|error| error.color.as_str()).collect();
            assert_eq!(names, ["red", "green", "blue"], "{}", row.reason);
            let mut sum = 0.0;
            for (color, error) in row.colors.iter().enumerate() {
                let of = by_hand[color][i].error.as_ref().expect("a truth");
                for (found, expected) in [(error.space, of.space), (error.surface, of.surface)] {
                    let (found, expected) = (found.expect("points").mean_abs, expected.expect("points").mean_abs);
                    assert!((found - expected).abs() < 1e-7, "{}, color {color}: {found}, {expected}", row.technique);
                }
                sum += error.space.expect("points").mean_abs;
            }
            let all = row.error.as_ref().and_then(|error| error.space).expect("points").mean_abs;
            assert!((sum / 3.0 - all).abs() < 1e-9, "{}: {sum} / 3 and {all}", row.technique);
        }
        let errors = found[0].colors.iter().map(|error| error.space.expect("points").mean_abs).collect::<Vec<_>>();
        assert!((errors[0] - errors[1]).abs() > 1e-3, "colors differ: {errors:?}");
    });
}

/// Moved casters make a new world; different inks are refused.
#[test]
fn casters_of_inks_move() {
    gpu_test("casters_of_inks_move", |context| {
        let both = Both::of(smoke(), 5);
        let points = points(4, 200);
        let mut world = World::new(context, &both.inks).expect("room for the scene");
        let mut opened = technique::open(context, &world, &spec("avsm:path=binned,size=28")).expect("opened");
        opened.build(&world).expect("built");
        let mut moved = both.inks.clone();
        moved.particles.iter_mut().skip(20).for_each(|particle| particle.position[0] += 0.2);
        world.replace(&moved).expect("another state");
        opened.build(&world).expect("built");
        let anew = built(context, &moved, "avsm:path=binned,size=28");
        for light in 0..moved.lights.len() {
            let found = ask(context, opened.technique.as_ref(), light, &points);
            assert_eq!(found, ask(context, anew.as_ref(), light, &points), "light {light}");
        }
        let mut other = moved.clone();
        other.inks[0].ratio = [0.5, 0.5, 0.25];
        let refused = world.replace(&other).expect_err("another world").to_string();
        assert!(refused.contains("of another color"), "{refused}");
        // With fewer casters, the rest would get other casters' ratios.
        let mut fewer = moved.clone();
        fewer.particles.remove(20);
        let refused = world.replace(&fewer).expect_err("another world").to_string();
        assert!(refused.contains("inks of 150 casters, and it has 149"), "{refused}");
        let mut two = moved.clone();
        two.lights.truncate(4);
        assert!(World::new(context, &two).is_err_and(|e| e.to_string().contains("once per color")));
        let refused = world.casters_move().expect_err("passes know one extinction").to_string();
        assert!(refused.contains("one extinction ratio"), "{refused}");
    });
}

/// Painters with a single opacity, and shadings that store one bit per light, are refused by name.
#[test]
fn what_keeps_one_number_refuses() {
    gpu_test("what_keeps_one_number_refuses", |context| {
        let mut scene = smoke();
        scene.meshes.clear();
        scene.lights.truncate(1);
        let scene = Both::of(scene, 5).inks;
        let world = World::new(context, &scene).expect("room for the scene");
        for text in
            ["half-angle", "density-grid:size=64", "grid-query:size=64", "optical-depth-grid:size=64", "marched"]
        {
            let refused = technique::open(context, &world, &spec(text)).err();
            let words = "casters of one extinction ratio";
            assert!(
                matches!(&refused, Some(Error::Refused(needs)) if needs.to_string().contains(words)),
                "{text}: {refused:?}"
            );
        }
        let technique = built(context, &scene, "layers:size=28");
        let renderer = renderer(context, &scene);
        let tiled = Shading::of(&gobo::shading::parse("layers:shading=tiled").expect("a spec")[0].settings());
        let refused = renderer.picture(&technique.answer(), tiled, Lighting::Fragment).err();
        assert!(matches!(&refused, Some(Error::Refused(needs)) if needs.to_string().contains("tiled")), "{refused:?}");
    });
}

/// Returns the resident and transient bytes, and the shortest build time in milliseconds.
fn cost(context: &Context, scene: &Scene, text: &str) -> (u64, u64, f64) {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = technique::open(context, &world, &spec(text)).expect(text);
    let builds = (0..5).map(|_| opened.rebuild(&world).expect(text).host_ns / 1e6);
    let least = builds.fold(f64::INFINITY, f64::min);
    let facts = opened.technique.inspect().facts().expect("facts");
    (facts.bytes_resident, facts.bytes_transient, least)
}

/// The figures in docs/notebook/color.md for three curves: `GOBO_TEST_ALL=1 cargo test --release --test pictures three_curves --
/// --nocapture`.
#[test]
fn three_curves_err_as_one_does() {
    if crate::support::is_long("three_curves_err_as_one_does") {
        return;
    }
    let test = "three_curves_err_as_one_does";
    gpu_test(test, |context| {
        let one_color = Scene::load("ink", 0.0).expect("built in");
        let scene = Scene::load("ink:inks=2", 0.0).expect("built in");
        let points = space_points(&scene, 0, if all() { 20_000 } else { 4000 });
        let casters = Casters::new(&scene);
        let texts = ["uncompressed", "avsm:path=binned", "layers", "beer-shadow-map", "none"];
        for text in those_that_run(test, context, some(texts, 2)) {
            let technique = built(context, &scene, text);
            let errors = [0, 1, 2].map(|color| {
                let truth = points.iter().map(|p| casters.visibility(color, DVec3::from(p.map(f64::from))));
                let found = ask(context, technique.as_ref(), color, &points);
                found.iter().zip(truth).map(|(a, b)| (f64::from(*a) - b).abs()).sum::<f64>() / points.len() as f64
            });
            let by_one = built(context, &one_color, text);
            let (answers, grey) = (ask(context, by_one.as_ref(), 0, &points), Casters::new(&one_color));
            let errors_of_one = one_color.extinction_ratio.map(f64::from).map(|power| {
                let truth = points.iter().map(|p| grey.visibility(0, DVec3::from(p.map(f64::from))).powf(power));
                let off = answers.iter().zip(truth).map(|(a, b)| (f64::from(*a).powf(power) - b).abs());
                off.sum::<f64>() / points.len() as f64
            });
            let [three, one] = [&scene, &one_color].map(|scene| cost(context, scene, text));
            println!(
                "{text}: {errors:.5?}, of one ratio {errors_of_one:.5?}; bytes and milliseconds {three:?}, {one:?}"
            );
            // Here half of the drops absorb colors that a single ratio would transmit.
            let [three, one] = [errors, errors_of_one].map(|errors| errors.iter().sum::<f64>());
            assert!(text == "none" || three < 1.25 * one, "{text}: {three}, of one ratio {one}");
        }
    });
}
