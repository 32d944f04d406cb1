//! Volumes that move: each frame gives the same look-ups and pictures as the static scene of its file, close to the exact field.

use crate::support::{self, ask, gpu_test, some, spec};
use crate::volumes::{left_by_cells, mean_apart};
use glam::DVec3;
use gobo::animate::AnimatedScene;
use gobo::bench::{Effort, Extent, Frames, Row, States, Status, with_case};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, picture, space_points};
use gobo::scene::{Field, Picture, Placed, Scene, View, Volume};
use gobo::shading::{Lighting, Renderer, Shading};
use gobo::technique::Opened;
use gobo::world::World;
use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};

/// Returns the path of a file written by results/files/vdb.py.
fn seed(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb").join(name)
}

fn load_animated(path: &Path) -> AnimatedScene {
    AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("a scene")
}

fn load(path: &Path) -> Scene {
    load_animated(path).scene
}

/// Returns a puff in three files, and the static scene of each, with the light and camera of the animation.
fn puff() -> (AnimatedScene, [Scene; 3]) {
    let animated = load_animated(&seed("ok-frame-#.vdb"));
    let all = &animated.scene;
    let alone = [1, 2, 3].map(|number| {
        let alone = load(&seed(&format!("ok-frame-{number}.vdb")));
        Scene { lights: all.lights.clone(), camera: all.camera, ..alone }
    });
    (animated, alone)
}

/// Times to move to, in 1/24 s, and the frame shown then: midpoints of the frames, then again in another order.
const TIMES: [(f64, usize); 5] = [(0.5, 0), (1.5, 1), (2.5, 2), (1.5, 1), (3.5, 0)];

fn opened(context: &Context, world: &World, text: &str) -> Opened {
    support::opened(gobo::technique::open(context, world, &spec(text)), text)
}

/// One technique follows a world through all frames.
#[test]
fn volumes_of_frames_are_those_of_their_files() {
    if crate::support::is_long("volumes_of_frames_are_those_of_their_files") {
        return;
    }
    gpu_test("volumes_of_frames_are_those_of_their_files", |context| {
        let (all, alone) = puff();
        let specs = [
            "avsm:path=binned,size=64",
            "grid-query:size=64",
            "density-grid:size=64",
            "layers:size=64",
            "uncompressed:size=64",
            "optical-depth-grid:size=64,cells=64",
            "marched:size=64",
            "psm:size=64,slices=64",
            "moments:size=64",
            "fourier:size=64",
            "wavelet:size=64",
            "deep-shadow-map:size=64",
            "beer-shadow-map:size=64",
            "translucency-map:size=64",
            "stochastic:size=64",
            "voxel-grid:size=64",
            "ray-query",
        ];
        let asked = alone.each_ref().map(|scene| {
            let (points, casters) = (space_points(scene, 0, 700), Casters::new(scene));
            let truth = points.iter().map(|p| casters.visibility(0, DVec3::from(p.map(f64::from)))).collect();
            (points, truth)
        });
        for text in some(specs, 5) {
            if !support::runs("volumes_of_frames_are_those_of_their_files", context, text) {
                continue;
            }
            let mut world = World::new(context, &all.scene).expect("room for the largest frame");
            let mut moving = opened(context, &world, text);
            for (time_s, frame) in TIMES {
                all.move_world(&mut world, time_s / 24.0).expect("its frame");
                moving.build(&world).expect("built");
                let (points, expected): &(Vec<[f32; 3]>, Vec<f64>) = &asked[frame];
                let found = ask(context, moving.technique.as_ref(), 0, points);
                let still = World::new(context, &alone[frame]).expect("room");
                let mut fresh = opened(context, &still, text);
                fresh.build(&still).expect("built");
                let of_file = ask(context, fresh.technique.as_ref(), 0, points);
                // Lists are summed in their order of capture, which may vary.
                let most = if text.starts_with("uncompressed") { 1e-6 } else { 0.0 };
                let off = found.iter().zip(&of_file).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off <= most, "{text}, frame {frame}: {off} from its file's");
                let found: Vec<f64> = found.into_iter().map(f64::from).collect();
                let error = mean_apart(&found, expected);
                let cells = mean_apart(&left_by_cells(&alone[frame], points), expected);
                let none = mean_apart(&vec![1.0; points.len()], expected);
                println!("{text}, frame {frame}: {error:.5}; cells {cells:.5}, without shadows {none:.4}");
                let bound = match text {
                    // Rounding of f32 sums over some hundred cells.
                    "grid-query:size=64" | "ray-query" => cells + 2e-4,
                    // A translucency map has no self-shadowing, and stochastic maps have few rays.
                    "translucency-map:size=64" | "stochastic:size=64" => none,
                    // A few numbers cannot represent a whole curve.
                    _ => cells + 0.25 * none,
                };
                assert!(error < bound, "{text}, frame {frame}: {error}, not below {bound}");
            }
        }
    });
}

fn apart(a: &Picture, b: &Picture) -> f64 {
    let all = a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| f64::from((a - b).abs()));
    all.fold(0.0, f64::max)
}

/// A renderer that looks at the world again has the frame's field, possibly larger than the one it was created for, and another camera; it
/// draws the same picture as a new renderer, to the bit.
#[test]
fn volumes_are_looked_at_again() {
    if crate::support::is_costly("volumes_are_looked_at_again") {
        return;
    }
    gpu_test("volumes_are_looked_at_again", |context| {
        let (all, alone) = puff();
        let mut world = World::new(context, &all.scene).expect("room");
        let view = |scene: &Scene| View::camera(&scene.camera, scene, [64, 36]);
        let mut renderer = Renderer::new(context, &world, &view(&all.scene)).expect("a renderer");
        let mut technique = opened(context, &world, "grid-query:size=64");
        technique.build(&world).expect("built");
        let kernels = renderer.kernels(&technique.technique.answer(), Shading::Forward, Lighting::Fragment);
        let kernels = support::opened(kernels, "grid-query");
        let mut before: Option<Picture> = None;
        for (i, (time_s, frame)) in TIMES.into_iter().enumerate() {
            all.move_world(&mut world, time_s / 24.0).expect("its frame");
            technique.build(&world).expect("built");
            let mut scene = alone[frame].clone();
            scene.camera = scene.camera.turned(20.0 * i as f64);
            renderer.look(&world, &view(&scene)).expect("a larger field has room");
            renderer.draw(&kernels).expect("drawn");
            let found = renderer.read().expect("read");
            let still = World::new(context, &scene).expect("room");
            let fresh = Renderer::new(context, &still, &view(&scene)).expect("a renderer");
            let mut alone = opened(context, &still, "grid-query:size=64");
            alone.build(&still).expect("built");
            let of_file = fresh.picture(&alone.technique.answer(), Shading::Forward, Lighting::Fragment);
            let of_file = of_file.expect("drawn");
            assert!(found.pixels == of_file.pixels, "frame {frame}: {} from its file's", apart(&found, &of_file));
            let casters = Casters::new(&scene);
            let expected = picture(&casters, &scene, &view(&scene));
            // The picture is off by no more than the light, since colors and radiances are at most 1.
            let points = space_points(&scene, 0, 3000);
            let light = left_by_cells(&scene, &points).into_iter().zip(points);
            let most = light.map(|(cells, p)| (cells - casters.visibility(0, DVec3::from(p.map(f64::from)))).abs());
            let (most, off) = (most.fold(0.0, f64::max), apart(&found, &expected));
            println!("frame {frame}: {off:.4} of {most:.4}");
            assert!(off < most, "frame {frame}: {off}, not below {most}");
            assert!(before.is_none_or(|before| apart(&found, &before) > 0.1), "frame {frame}: as the one before");
            before = Some(found);
        }
        // Whatever a renderer was not created for is named in the error.
        let mut empty = Scene { volumes: Vec::new(), ..alone[0].clone() };
        let none = World::new(context, &empty).expect("room");
        let error = Renderer::new(context, &none, &view(&empty)).expect("a renderer").look(&world, &view(&all.scene));
        assert!(error.expect_err("no fields").to_string().contains("had none when this renderer was made"));
        empty.volumes = alone[1].volumes.clone();
        let mut small =
            Renderer::new(context, &World::new(context, &alone[0]).expect("room"), &view(&all.scene)).expect("one");
        let error = small.look(&World::new(context, &empty).expect("room"), &view(&all.scene)).expect_err("larger");
        assert!(error.to_string().contains("more blocks"), "{error}");
    });
}

/// Smoke that appears: an empty first frame, then a box of uniform density, whose shadow has a closed form, then an empty frame again.
#[test]
fn volumes_may_begin_empty() {
    if crate::support::is_costly("volumes_may_begin_empty") {
        return;
    }
    gpu_test("volumes_may_begin_empty", |context| {
        let folder = tempfile::tempdir().expect("a folder");
        for (number, density) in [(1, 0.0f32), (2, 2.0)] {
            let raw: Vec<u8> = (0..17 * 17 * 9).flat_map(|_| density.to_le_bytes()).collect();
            let sidecar = format!(
                "file = \"{number}.raw\"\nsize = [17, 17, 9]\ntype = \"f32\"\nspacing = [0.125, 0.125, 0.125]\n\
                 origin = [-1, -1, 0]\n"
            );
            std::fs::write(folder.path().join(format!("{number}.raw")), raw).expect("written");
            std::fs::write(folder.path().join(format!("fog.{number}.volume")), sidecar).expect("written");
        }
        let mut all = load_animated(&folder.path().join("fog.#.volume"));
        all.scene.lights[0].kind = gobo::scene::LightKind::Directional { direction: DVec3::NEG_Z };
        // Points on rays through the centres of cells and along sides that cells share. Below the box, a ray has passed 9 samples of 2,
        // 0.125 apart, falling to 0 over the same distance at the ends.
        let below = (-2.0f64 * 9.0 * 0.125).exp() as f32;
        let points: Vec<[f32; 3]> =
            (0..64).map(|i| [(i % 8) as f32 * 0.19 - 0.71, (i / 8) as f32 * 0.1875 - 0.75, -0.13]).collect();
        let view = |world: &World| View::camera(&all.scene.camera, world.scene().expect("a scene's"), [48, 27]);
        for text in ["grid-query:size=64", "avsm:path=binned,size=64", "density-grid:size=64"] {
            if !support::runs("volumes_may_begin_empty", context, text) {
                continue;
            }
            let mut world = World::new(context, &all.scene).expect("room");
            assert!(world.kinds().volumes && world.caster_count() == 0);
            let mut technique = opened(context, &world, text);
            let mut renderer = Renderer::new(context, &world, &view(&world)).expect("a renderer");
            technique.build(&world).expect("built");
            let kernels = renderer.kernels(&technique.technique.answer(), Shading::Forward, Lighting::Fragment);
            let kernels = support::opened(kernels, text);
            for (frame, expected) in [(0, 1.0), (1, below), (2, 1.0)] {
                all.move_world(&mut world, (f64::from(frame) + 0.5) / 24.0).expect("its frame");
                technique.build(&world).expect("built");
                let found = ask(context, technique.technique.as_ref(), 0, &points);
                let off = found.iter().map(|answer| (answer - expected).abs()).fold(0.0, f32::max);
                renderer.look(&world, &view(&world)).expect("the next frame");
                renderer.draw(&kernels).expect("drawn");
                let sky = gobo::scene::SKY;
                let seen = renderer.read().expect("read").pixels.into_iter().filter(|pixel| *pixel != sky).count();
                println!("{text}, frame {frame}: {off:.1e} from {expected:.4}, {seen} pixels");
                // A grid's voxels are not aligned with the samples.
                assert!(off < if text.starts_with("density") { 0.03 } else { 2e-4 }, "{text}, frame {frame}: {off}");
                assert_eq!(seen > 200, frame == 1, "{text}, frame {frame}: {seen} pixels are not the sky");
            }
        }
    });
}

/// A block of density that shrinks from frame to frame, with a weak reference that tells whether it is still in memory.
fn block(frame: usize) -> (Scene, Weak<Field>) {
    let side = 6 - frame as i32;
    let samples =
        (0..side.pow(3)).map(|i| ([i % side, i / side % side, i / side.pow(2)], 0.5 + 0.1 * (i % side) as f32));
    let field = Arc::new(Field::new(samples).expect("a field"));
    let held = Arc::downgrade(&field);
    let steps = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| 0.25 * axis);
    let placed = Placed { origin: DVec3::splat(-0.6), steps, extinction: 2.0, color: [0.7; 3], side: 1 };
    let mut scene = support::scenes::directional("block", [0.3, 0.2, -1.0], Vec::new());
    scene.volumes.push(Volume::new(field, placed).expect("a volume"));
    (scene, held)
}

/// Frames read on demand give the same rows as frames that are all in memory, to the bit. Besides the first, at most three are in memory,
/// whatever is measured: the one shown, the one being read, and the previous one while errors over areas are measured.
#[test]
fn frames_that_are_read_are_compared_as_those_in_memory() {
    if crate::support::is_costly("frames_that_are_read_are_compared_as_those_in_memory") {
        return;
    }
    gpu_test("frames_that_are_read_are_compared_as_those_in_memory", |context| {
        const COUNT: usize = 5;
        let effort = Effort {
            frames: COUNT,
            warm_up: 1,
            space_points: 300,
            seen_points: 300,
            lookups: 0,
            picture: [32, 18],
            turning: false,
            footprints: true,
            counts: false,
            truth: Extent::Sample,
        };
        let specs = ["avsm:path=binned,size=32", "none", "density-grid:size=64"];
        let measured = |frames: Frames| -> Vec<Row> {
            let rows = with_case(context, frames, effort, |case| {
                Ok(specs.iter().map(|text| case.measure(&spec(text)).0).collect())
            });
            rows.expect("measured")
        };
        let all: Vec<Scene> = (0..COUNT).map(|frame| block(frame).0).collect();
        let held = measured(Frames::from(&all[..]));
        let (given, most) = (RefCell::new(Vec::<Weak<Field>>::new()), Cell::new(0));
        let read = |frame: usize| {
            let (scene, field) = block(frame);
            given.borrow_mut().push(field);
            most.set(most.get().max(given.borrow().iter().filter(|field| field.strong_count() > 0).count()));
            Ok(scene)
        };
        let states = States::Read { first: &all[0], count: COUNT, read: &read };
        let rows = measured(Frames { states, ..Frames::from(&all[..1]) });
        println!("{} frames were read, {} in memory at most", given.borrow().len(), most.get());
        assert!(given.borrow().len() > 2 * COUNT && most.get() <= 3, "{} in memory", most.get());
        for (row, held) in rows.iter().zip(&held) {
            let what = format!("{} {}", row.technique, row.reason);
            assert_eq!((row.status, &row.reason), (held.status, &held.reason));
            if row.status == Status::Refused && support::is_lowered() {
                continue;
            }
            assert_eq!(row.status, Status::Ok, "{what}");
            assert!(row.flicker_rms.is_some() && row.error.is_some() && !row.footprints.is_empty(), "{what}");
            assert_eq!(row.flicker_rms, held.flicker_rms, "{what}");
            assert_eq!(
                format!("{:?}", (&row.error, &row.footprints)),
                format!("{:?}", (&held.error, &held.footprints))
            );
        }
        // Blocks of different sizes flicker by different amounts, which proves that the requested frames were used.
        assert_ne!(rows[0].flicker_rms, rows[1].flicker_rms);
    });
}
