//! Casters of several extinction ratios: each color of each light is answered as a grey scene is whose casters were made as thick by hand.

#![cfg(feature = "program")]

mod support;

use glam::{DVec2, DVec3};
use gobo::Error;
use gobo::consume::{Lighting, Renderer, Shading};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::{Casters, fog as true_fog, picture, space_points};
use gobo::scene::{
    Camera, Field, Fog, Gaussian, Ink, Light, LightKind, Particle, Picture, Placed, SKY, Scene, Strand, View, Volume,
};
use gobo::technique::{self, Name, Spec, Technique};
use gobo::world::World;
use std::collections::BTreeSet;
use std::sync::Arc;
use support::{all, ask, built, every_path, gpu_test, rows, scenes, some, spec, those_that_run};

/// Powers of two: a product with them is exact, so that extinctions made by hand have the same bits.
const RATIOS: [[f32; 3]; 3] = [[1.0, 0.5, 0.0], [0.25, 1.0, 0.5], [0.5, 0.0, 1.0]];

/// Those of volumes, which have no extinction of 0 by hand.
const VOLUME_RATIOS: [[f32; 3]; 2] = [[1.0, 0.5, 0.25], [0.25, 1.0, 0.5]];

const SIZE: [u32; 2] = [48, 27];
/// Twins: PARTICLE_ALBEDO, AMBIENT.
const ALBEDO: [f64; 3] = [0.92, 0.92, 0.95];
const AMBIENT: [f64; 3] = [0.10, 0.12, 0.15];

/// A scene of several inks, and for each color the grey scene that is as thick by hand, with the lights as they were.
struct Both {
    inks: Scene,
    grey: [Scene; 3],
    lights: usize,
}

impl Both {
    /// Both of `scene`. Its casters get the ratios in turns, `run` casters of a kind after each other; a volume has one ratio.
    fn of(scene: Scene, run: usize) -> Self {
        let ratio = |i: usize| RATIOS[i / run % 3];
        let inks = |count: usize| (0..count).map(move |i| Ink { casters: 1, ratio: ratio(i) });
        let all = inks(scene.particles.len()).chain(inks(scene.strands.len())).chain(inks(scene.gaussians.len()));
        let volumes = scene.volumes.iter().enumerate();
        let cells = volumes.map(|(i, volume)| Ink { casters: volume.cells().len(), ratio: VOLUME_RATIOS[i % 2] });
        let all: Vec<Ink> = all.chain(cells).collect();
        let grey = [0, 1, 2].map(|color| {
            let mut grey = scene.clone();
            let k = |i: usize| f64::from(ratio(i)[color]);
            let thinner = |opacity: f32, k: f64| (1.0 - (1.0 - f64::from(opacity)).powf(k)) as f32;
            grey.particles.iter_mut().enumerate().for_each(|(i, p)| p.extinction *= k(i) as f32);
            grey.strands.iter_mut().enumerate().for_each(|(i, s)| s.opacity = thinner(s.opacity, k(i)));
            // A splat's extinction is in proportion to −ln(1 − opacity) too.
            grey.gaussians.iter_mut().enumerate().for_each(|(i, g)| g.opacity = thinner(g.opacity, k(i)));
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

/// A ball of a field, at some place.
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
    scene.gaussians = (0..12)
        .map(|_| Gaussian {
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

/// Every path, and other ways of techniques that go through casters, with small maps.
fn specs(test: &str, context: &Context) -> Vec<Spec> {
    let mut specs = every_path(test, context);
    let more = [
        "avsm:path=binned,resolve=streaming",
        // So many bytes that each tile is as fine as it can be: the tiles of a color then do not take blocks from those of another.
        "avsm:path=binned,detail=adaptive,bytes=100000000",
        "avsm:path=binned,texel=area",
        "avsm:path=two-pass,resolve=whole",
        "psm:path=raster,route=geometry,slices=64",
        "psm:path=raster,route=vertex,slices=64",
        "psm:path=raster,coverage=tiles,assign=split,slices=64",
        "stochastic:path=binned,sampling=stratified",
        "stochastic:path=binned,sampling=hash",
    ];
    specs.extend(those_that_run(test, context, some(more, 5)).into_iter().map(spec));
    for spec in &mut specs {
        if !["psm", "voxelized", "density-grid", "optical-depth-grid", "voxel-grid"].contains(&spec.entry.name) {
            spec.set(Name::SIZE, "28");
        }
    }
    specs
}

/// What keeps one number for all lights.
const ONE_NUMBER: [&str; 6] =
    ["density-grid", "grid-query", "marched", "optical-depth-grid", "ray-query", "voxel-grid"];

#[test]
fn each_color_is_a_grey_scene_made_by_hand() {
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
                        // Lists are added up in the order of capture.
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

/// A point light has six maps, so that the maps of a color are more than its lights.
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
        for text in those_that_run(test, context, texts) {
            let technique = built(context, &both.inks, text);
            for (color, grey) in both.grey.iter().enumerate() {
                let by_hand = built(context, grey, text);
                for light in 0..both.lights {
                    let found = ask(context, technique.as_ref(), color * both.lights + light, &points);
                    let expected = ask(context, by_hand.as_ref(), light, &points);
                    assert_eq!(found, expected, "{text}, color {color}, light {light}");
                }
            }
        }
    });
}

/// Hair, splats and volumes too. Their extinctions by hand are rounded otherwise.
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
        for text in those_that_run(test, context, some(texts, 4)) {
            let technique = built(context, &both.inks, text);
            for (color, grey) in both.grey.iter().enumerate() {
                let by_hand = built(context, grey, text);
                let found = ask(context, technique.as_ref(), color, &points);
                let expected = ask(context, by_hand.as_ref(), 0, &points);
                let off = found.iter().zip(&expected).map(|(a, b)| f64::from(a - b).abs());
                let mean = off.sum::<f64>() / points.len() as f64;
                assert!(mean < 2e-4, "{text}, color {color}: {mean}");
                assert!(expected.iter().any(|v| *v < 0.5), "{text} sees casters");
            }
        }
    });
}

/// With `detail=adaptive` the tiles of all colors share the bytes, where a scene by hand has as many for one: answers differ, and err by as
/// much over all colors.
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

/// The truth of each color is that of the scene by hand: of points and of texels.
#[test]
fn the_truth_is_that_of_scenes_made_by_hand() {
    let mut scene = all_kinds();
    scene.lights.extend(smoke().lights.into_iter().skip(1));
    let both = Both::of(scene, 4);
    let casters = Casters::new(&both.inks);
    let points = points(3, 300);
    for (color, grey) in both.grey.iter().enumerate() {
        let by_hand = Casters::new(grey);
        let mut dark = 0;
        for light in 0..both.lights {
            for point in &points {
                let at = DVec3::from(point.map(f64::from));
                let (found, expected) =
                    (casters.visibility(color * both.lights + light, at), by_hand.visibility(light, at));
                // Extinctions and opacities by hand are floats.
                assert!(
                    (found - expected).abs() < 2e-6,
                    "color {color}, light {light}, {point:?}: {found}, {expected}"
                );
                dark += usize::from(expected < 0.5);
            }
        }
        assert!(dark > 50, "{dark} points");
        let views = View::volumes(grey, 16);
        let [found, expected] = [(&casters, &both.inks, color * views.len()), (&by_hand, grey, 0)].map(|all| {
            let (casters, _, first) = all;
            let of = |(map, view): (usize, &View)| {
                let ray = view.ray(DVec2::new(8.5, 8.5));
                let (curve, met) = casters.true_curve(first + map, view, &ray);
                (0..8).map(|i| curve.transmittance(f64::from(i) / 7.0)).chain([f64::from(met)]).collect::<Vec<_>>()
            };
            views.iter().enumerate().flat_map(of).collect::<Vec<_>>()
        });
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 2e-6),
            "color {color}: {found:?}, {expected:?}"
        );
    }
}

/// Two balls of ink over each other: below both, each color keeps exp(−(a + b)).
fn two_balls() -> Scene {
    let ball = |z: f32, extinction| Particle { position: [0.0, 0.0, z], radius: 0.5, extinction };
    let scene = scenes::directional("balls", [0.0, 0.0, -1.0], vec![ball(0.6, 1.0), ball(-0.6, 2.0)]);
    let inks = [Ink { casters: 1, ratio: [1.0, 0.3, 0.0] }, Ink { casters: 1, ratio: [0.1, 0.5, 1.0] }];
    scene.with_inks(&inks).expect("inks")
}

#[test]
fn two_inks_over_each_other_are_a_closed_form() {
    let test = "two_inks_over_each_other_are_a_closed_form";
    gpu_test(test, |context| {
        let scene = two_balls();
        let casters = Casters::new(&scene);
        let places = [(0.01f32, 0.02f32), (-0.1, 0.05), (0.2, -0.1)];
        let expected = |color: usize, (x, y): (f32, f32), upper_alone: bool| {
            let chord = 2.0 * (0.25 - f64::from(x).powi(2) - f64::from(y).powi(2)).sqrt();
            let [a, b] = [[1.0, 0.3, 0.0], [0.2, 1.0, 2.0]].map(|k: [f64; 3]| k[color]);
            (-chord * if upper_alone { a } else { a + b }).exp()
        };
        let texts = ["uncompressed:size=256", "avsm:path=binned,nodes=16,size=256", "layers:size=256"];
        for text in those_that_run(test, context, texts) {
            let technique = built(context, &scene, text);
            for color in 0..3 {
                for (z, upper_alone) in [(0.0, true), (-1.5, false)] {
                    let below = places.map(|(x, y)| [x, y, z]);
                    for (place, found) in places.iter().zip(ask(context, technique.as_ref(), color, &below)) {
                        let expected = expected(color, *place, upper_alone);
                        let wrong = (f64::from(found) - expected).abs();
                        assert!(wrong < 3e-3, "{text}, color {color} at {place:?}, {z}: {found}, not {expected}");
                        let at = DVec3::new(place.0.into(), place.1.into(), z.into());
                        assert!((casters.visibility(color, at) - expected).abs() < 1e-6, "the truth");
                    }
                }
            }
        }
    });
}

fn renderer(context: &Context, scene: &Scene) -> Renderer {
    let world = World::new(context, scene).expect("room for the scene");
    Renderer::new(context, &world, &View::camera(&scene.camera, scene, SIZE)).expect("a renderer")
}

fn channel(picture: &Picture, color: usize) -> impl Iterator<Item = f32> {
    picture.pixels.iter().map(move |pixel| pixel[color])
}

/// Each channel of a picture is that of the scene by hand, drawn alone; with fog over it too.
#[test]
fn each_channel_of_a_picture_is_that_of_a_scene_made_by_hand() {
    let test = "each_channel_of_a_picture_is_that_of_a_scene_made_by_hand";
    gpu_test(test, |context| {
        let both = Both::of(all_kinds(), 4);
        let air = Fog { extinction: 0.1, steps: 8 };
        let tessellates = context.features().lacks(Requirement::Tessellation).is_none();
        let vertex = tessellates.then_some((Shading::Forward, Lighting::Vertex { spacing: 8.0 }));
        let ways = [(Shading::Forward, Lighting::Fragment), (Shading::Deferred, Lighting::Fragment)];
        for text in those_that_run(test, context, ["avsm:path=binned,size=64", "uncompressed:size=64"]) {
            let technique = built(context, &both.inks, text);
            let by_hand = both.grey.each_ref().map(|grey| built(context, grey, text));
            for (shading, lighting) in ways.into_iter().chain(vertex) {
                let drawn = |scene: &Scene, technique: &dyn Technique| {
                    let renderer = renderer(context, scene);
                    let clear = renderer.picture(&technique.answer(), shading, lighting).expect("drawn");
                    renderer.fog(&technique.answer(), &air).expect("fog");
                    (clear, renderer.read().expect("read"))
                };
                let found = drawn(&both.inks, technique.as_ref());
                let expected: Vec<_> =
                    both.grey.iter().zip(&by_hand).map(|(grey, by_hand)| drawn(grey, by_hand.as_ref())).collect();
                for (color, expected) in expected.iter().enumerate() {
                    for (found, expected) in [(&found.0, &expected.0), (&found.1, &expected.1)] {
                        let off =
                            channel(found, color).zip(channel(expected, color)).map(|(a, b)| f64::from(a - b).abs());
                        let mean = off.sum::<f64>() / found.pixels.len() as f64;
                        assert!(mean < 2e-4, "{text}, {shading:?}, {lighting:?}, color {color}: {mean}");
                    }
                }
                let apart =
                    channel(&expected[0].0, 0).zip(channel(&expected[1].0, 0)).map(|(a, b)| f64::from(a - b).abs());
                assert!(apart.sum::<f64>() / found.0.pixels.len() as f64 > 0.01, "the scenes look different");
            }
        }
    });
}

/// The reference's picture and fog too, and what the camera sees of two balls before the sky is a closed form.
#[test]
fn pictures_are_those_of_the_reference() {
    let test = "pictures_are_those_of_the_reference";
    gpu_test(test, |context| {
        let scene = Both::of(all_kinds(), 4).inks;
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let casters = Casters::new(&scene);
        let reference = picture(&casters, &scene, &camera);
        let air = Fog { extinction: 0.1, steps: 8 };
        let foggy = true_fog(&casters, &camera, &reference, &air, |light, at| casters.arriving_colors(light, at));
        for text in those_that_run(test, context, ["uncompressed:size=256"]) {
            let technique = built(context, &scene, text);
            let renderer = renderer(context, &scene);
            let clear = renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
            renderer.fog(&technique.answer(), &air).expect("fog");
            for (found, reference) in [(clear, &reference), (renderer.read().expect("read"), &foggy)] {
                for color in 0..3 {
                    let off =
                        channel(&found, color).zip(channel(reference, color)).map(|(a, b)| f64::from(a - b).abs());
                    let mean = off.sum::<f64>() / found.pixels.len() as f64;
                    assert!(mean < 4e-3, "{text}, color {color}: {mean}");
                }
            }
        }

        // Two balls one behind the other.
        let mut scene = two_balls();
        scene.lights.iter_mut().for_each(|light| light.radiance = [0.0; 3]);
        scene.camera =
            Camera { position: DVec3::new(0.0, 0.0, 9.0), target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 12.0 };
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let reference = picture(&Casters::new(&scene), &scene, &camera);
        let technique = built(context, &scene, "none");
        let renderer = renderer(context, &scene);
        let found = renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
        let mut seen = 0;
        for i in 0..found.pixels.len() {
            let at = DVec2::new((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
            let ray = camera.ray(at);
            let direction = ray.direction.normalize();
            let chord = |z: f64| {
                let offset = DVec3::new(0.0, 0.0, z) - ray.origin;
                2.0 * (0.25 - (offset - offset.dot(direction) * direction).length_squared()).max(0.0).sqrt()
            };
            let chords = [chord(0.6), chord(-0.6)];
            if chords.iter().any(|chord| *chord < 0.2) {
                continue; // a chord's end is a root
            }
            seen += 1;
            for color in 0..3 {
                let [a, b] = [[1.0, 0.3, 0.0], [0.2, 1.0, 2.0]].map(|k: [f64; 3]| k[color]);
                let left = (-a * chords[0] - b * chords[1]).exp();
                let expected = ALBEDO[color] * AMBIENT[color] * (1.0 - left) + f64::from(SKY[color]) * left;
                let allowed = if context.features().float32_blend { 5e-5 } else { 3e-3 };
                for (found, allowed) in [(&found, allowed), (&reference, 1e-6)] {
                    let wrong = (f64::from(found.pixels[i][color]) - expected).abs();
                    assert!(wrong < allowed, "pixel {i}, color {color}: {:?}, not {expected}", found.pixels[i]);
                }
            }
        }
        assert!(seen > 30, "{seen} pixels");
    });
}

/// Errors of each color are those of the scenes by hand, and all of them together the error of all lights.
#[test]
fn rows_have_an_error_of_each_color() {
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

/// Casters that moved are a new world; other inks are another world.
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
        // Fewer casters would have the ratios of others.
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

/// What paints with one opacity, or keeps one bit of a light, says so.
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
            assert!(matches!(&refused, Some(Error::Refused { needs }) if needs.contains(words)), "{text}: {refused:?}");
        }
        let technique = built(context, &scene, "layers:size=28");
        let renderer = renderer(context, &scene);
        let tiled = Shading::of(&gobo::consume::parse("layers:shading=tiled").expect("a spec")[0].settings());
        let refused = renderer.picture(&technique.answer(), tiled, Lighting::Fragment).err();
        assert!(matches!(&refused, Some(Error::Refused { needs }) if needs.contains("tiled")), "{refused:?}");
    });
}

/// Bytes, resident and transient, and the least milliseconds of a build.
fn cost(context: &Context, scene: &Scene, text: &str) -> (u64, u64, f64) {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = technique::open(context, &world, &spec(text)).expect(text);
    let builds = (0..5).map(|_| opened.rebuild(&world).expect(text).host_ns / 1e6);
    let least = builds.fold(f64::INFINITY, f64::min);
    let facts = opened.technique.facts().expect("facts");
    (facts.bytes_resident, facts.bytes_transient, least)
}

/// What docs/notebook/colour.md says of three curves: `cargo test --release --test inks three_curves -- --nocapture`.
#[test]
fn three_curves_err_as_one_does() {
    let test = "three_curves_err_as_one_does";
    gpu_test(test, |context| {
        let one_color = Scene::load("ink", 0.0).expect("built in");
        let mut ink = one_color.clone();
        ink.extinction_ratio = Scene::GREY;
        let drop = ink.particles.len() / 4;
        let inks = [0, 1, 2, 3].map(|i| Ink { casters: drop, ratio: [[1.0, 0.55, 0.2], [0.2, 0.6, 1.0]][i % 2] });
        let scene = ink.with_inks(&inks).expect("inks");
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
            // Colors that one ratio lets pass, half of the drops take here.
            let [three, one] = [errors, errors_of_one].map(|errors| errors.iter().sum::<f64>());
            assert!(text == "none" || three < 1.25 * one, "{text}: {three}, of one ratio {one}");
        }
    });
}

/// A strand's optical depth is a factor's as any.
#[test]
fn a_strand_has_an_extinction_for_each_color() {
    let strand = Strand { start: [0.0; 3], radius: 0.1, end: [1.0, 0.0, 0.0], opacity: 0.75 };
    let mut scene = scenes::directional("strands", [0.0, 0.0, -1.0], Vec::new());
    scene.strands = vec![strand, strand];
    let inks = [Ink { casters: 1, ratio: [1.0, 0.5, 0.0] }, Ink { casters: 1, ratio: [0.5, 0.5, 1.0] }];
    let scene = scene.with_inks(&inks).expect("inks");
    let casters = Casters::new(&scene);
    let left = [0, 1, 2].map(|color| casters.visibility(color, DVec3::new(0.5, 0.0, -1.0)));
    // 0.25^(1 + 0.5), 0.25^(0.5 + 0.5) and 0.25^(0 + 1).
    for (found, expected) in left.into_iter().zip([0.125, 0.25, 0.25]) {
        assert!((found - expected).abs() < 1e-6, "{left:?}");
    }
}
