//! Voxelized shadows: columns and nodes against their twins, word for word, look-ups against testing each voxel, and visible surfaces
//! against the truth.

mod coverage;
mod directions;
mod file;
mod large;
mod moves;
mod pyramids;
mod receivers;
mod steps;

use crate::shapes;
use crate::support::{
    ask, assert_right_beyond_the_resolution, gpu_test, is_long, rows, scenes::Random, within::diagonal,
};
use gobo::gpu::{Context, PassTime};
use gobo::reference::twin::voxelized::{Baked, Cube, Free, bake, boundaries, columns, project, voxel};
use gobo::scene::{LightKind, Scene, sides};
use gobo::technique::{
    Coverage, Free as FreeKey, Opened, Structure, Technique, TreeData, Voxelized, voxelized::Plan as Settings,
};
use gobo::world::World;
use std::collections::BTreeSet;

/// Settings of most bakes.
const PLAIN: Settings = Settings {
    size: 64,
    structure: Structure::Dag,
    closed: true,
    free: FreeKey::Shared,
    coverage: Coverage::Middle,
    filter: 1,
    bias: 100,
    tile: Settings::TILE,
    keep_columns: true,
};

fn baked(context: &Context, scene: &Scene, settings: Settings) -> Opened<Voxelized> {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = crate::support::opened(Voxelized::planned(context, &world, &settings), "voxelized");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("baked");
    opened
}

fn cube(tree: &TreeData) -> Cube {
    Cube {
        origin: tree.origin,
        axes: [tree.right, tree.up, tree.forward],
        size: tree.size,
        perspective: tree.perspective == 1,
    }
}

/// Returns the columns that the twin finds in a tree's cube.
fn twin_columns(scene: &Scene, tree: &TreeData, settings: Settings) -> Vec<[u32; 2]> {
    let mut projected = Vec::new();
    for mesh in &scene.meshes {
        for (triangle, side) in mesh.triangles.iter().zip(sides(mesh)) {
            let corners = triangle.map(|i| mesh.positions[i as usize]);
            projected.extend(project(&cube(tree), corners, side.sign()));
        }
    }
    columns(&projected, tree.size, settings.closed, settings.is_conservative())
}

fn twin_free(free: FreeKey) -> Free {
    match free {
        FreeKey::Exit => Free::Exit,
        FreeKey::Entry => Free::Entry,
        FreeKey::Shared => Free::Shared,
    }
}

/// Returns the device's bake in the twin's format.
fn as_baked(voxelized: &Voxelized, light: usize, settings: Settings) -> Baked {
    let tree = voxelized.trees().expect("read")[light];
    let levels = tree.levels as usize;
    Baked {
        size: tree.size,
        root: tree.root,
        root_at: tree.root_at,
        at: tree.at[..levels].to_vec(),
        pointer_bits: tree.pointer_bits[..levels].to_vec(),
        header_bits: if settings.merges() { 16 } else { 32 },
        shortcuts: tree.shortcuts,
        words: voxelized.nodes().expect("read"),
    }
}

/// Asserts equal columns, except that a depth may be rounded to the other side of a voxel's edge, because devices do not divide exactly:
/// never by more, and seldom.
fn assert_same_columns(device: &[[u32; 2]], twin: &[[u32; 2]], what: &str) {
    let differ: Vec<_> = device.iter().zip(twin).filter(|(a, b)| a != b).collect();
    for (a, b) in &differ {
        let apart = a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1]));
        assert!(apart <= 1, "{what}: {a:?} and the twin's {b:?}");
    }
    assert!(differ.len() * 1000 <= device.len(), "{what}: {} of {} columns differ", differ.len(), device.len());
}

#[test]
fn columns_equal_their_twin() {
    gpu_test("columns_equal_their_twin", |context| {
        for scene in shapes::all() {
            for (closed, coverage) in [
                (true, Coverage::Middle),
                (true, Coverage::Conservative),
                (false, Coverage::Middle),
                (false, Coverage::Conservative),
            ] {
                let settings = Settings { closed, coverage, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let tree = opened.technique.trees().expect("read")[0];
                let twin = twin_columns(&scene, &tree, settings);
                let device = opened.technique.columns().expect("read");
                assert_same_columns(&device, &twin, &format!("{}, closed {closed}, {coverage:?}", scene.name));
            }
        }
    });
}

/// Given the device's own columns, the twin builds the same nodes, word for word.
#[test]
fn nodes_equal_their_twin() {
    gpu_test("nodes_equal_their_twin", |context| {
        for scene in shapes::all() {
            for structure in [Structure::Dag, Structure::Svo] {
                for free in crate::support::some([FreeKey::Shared, FreeKey::Exit, FreeKey::Entry], 1) {
                    let settings = Settings { structure, free, ..PLAIN };
                    let opened = baked(context, &scene, settings);
                    let columns = opened.technique.columns().expect("read");
                    let twin = bake(&columns, 64, Settings::TILE, twin_free(free), settings.merges());
                    assert_eq!(as_baked(&opened.technique, 0, settings), twin, "{}, {settings:?}", scene.name);
                }
            }
        }
    });
}

/// Tiles change the positions of nodes, not their contents: the same words as a twin that proceeds tile by tile, and the same voxels as
/// without tiles.
#[test]
fn tiles_say_the_same() {
    gpu_test("tiles_say_the_same", |context| {
        for scene in crate::support::some(shapes::all(), 3) {
            for structure in [Structure::Dag, Structure::Svo] {
                let whole = baked(context, &scene, Settings { size: 128, structure, ..PLAIN });
                let columns = whole.technique.columns().expect("read");
                for tile in [64, 32] {
                    let settings = Settings { size: 128, structure, tile, ..PLAIN };
                    let opened = baked(context, &scene, settings);
                    let twin = bake(&columns, 128, tile, Free::Shared, settings.merges());
                    assert_eq!(as_baked(&opened.technique, 0, settings), twin, "{}, {settings:?}", scene.name);
                }
            }
        }
    });
}

/// In every structure, a voxel in front of its column's entry is lit, and one at or behind the exit is shadowed.
#[test]
fn every_voxel_is_what_the_depth_map_says() {
    gpu_test("every_voxel_is_what_the_depth_map_says", |context| {
        for scene in crate::support::some(shapes::all(), 4) {
            for (structure, closed) in [(Structure::Dag, true), (Structure::Dag, false), (Structure::Svo, true)] {
                let settings = Settings { structure, closed, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let tree = as_baked(&opened.technique, 0, settings);
                for (column, [entry, exit]) in opened.technique.columns().expect("read").into_iter().enumerate() {
                    let (x, y) = (column as u32 % 64, column as u32 / 64);
                    for z in 0..64 {
                        let (shadowed, _) = tree.shadowed([x, y, z]);
                        assert!(z >= entry || !shadowed, "{}: {x} {y} {z} is lit, entry {entry}", scene.name);
                        assert!(z < exit || shadowed, "{}: {x} {y} {z} is shadowed, exit {exit}", scene.name);
                    }
                }
            }
        }
    });
}

/// Look-ups on the device against a filter that tests each voxel, in and around the cube.
#[test]
fn look_up_equals_its_twin() {
    gpu_test("look_up_equals_its_twin", |context| {
        for scene in crate::support::some(shapes::all(), 3) {
            for (filter, structure) in [
                (1, Structure::Dag),
                (9, Structure::Dag),
                (3, Structure::Svo),
                (7, Structure::Dag),
                (5, Structure::Svo),
            ] {
                let settings = Settings { structure, filter, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let tree = opened.technique.trees().expect("read")[0];
                let twin = as_baked(&opened.technique, 0, settings);
                let points = shapes::about(&scene, 4000);
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let mut compared = 0;
                for (point, answer) in points.iter().zip(answers) {
                    let at = voxel(&cube(&tree), *point);
                    // The device may fuse a multiplication and an addition: within that error of a voxel's edge either side is right.
                    if at.iter().any(|v| (v - v.round()).abs() < 1e-3) {
                        continue;
                    }
                    compared += 1;
                    let expected = twin.look_up(at, filter);
                    assert!(
                        (f64::from(answer) - expected).abs() < 1e-6,
                        "{}, filter {filter}: {answer} at {at:?}, the twin {expected}",
                        scene.name
                    );
                }
                assert!(compared > 3000, "{compared} points compared");
            }
        }
    });
}

/// Points without a voxel are lit: NaN, infinite, outside.
#[test]
fn what_has_no_voxel_is_lit() {
    gpu_test("what_has_no_voxel_is_lit", |context| {
        let scene = shapes::houses();
        let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("directional") };
        let opened = baked(context, &scene, Settings { filter: 9, ..PLAIN });
        let before = (direction * -1e3).as_vec3().into();
        let points =
            [[f32::NAN; 3], [f32::INFINITY; 3], [-f32::INFINITY; 3], [1e30, 0.0, 0.0], [0.0, -3e9, 4e9], before];
        assert_eq!(ask(context, opened.technique.as_ref(), 0, &points), [1.0; 6]);
        // Behind the cube is the shadow of the meshes in it.
        let behind = (direction * 1e3).as_vec3().into();
        assert_eq!(ask(context, opened.technique.as_ref(), 0, &[behind]), [0.0]);
    });
}

/// Two bakes give the same bytes, and so does a technique that has baked before.
#[test]
fn bakes_are_repeatable() {
    gpu_test("bakes_are_repeatable", |context| {
        let scene = shapes::soup();
        let world = World::new(context, &scene).expect("room");
        let settings = Settings { size: 256, ..PLAIN };
        let mut first = baked(context, &scene, settings);
        let second = baked(context, &scene, settings);
        let words = first.technique.nodes().expect("read");
        assert_eq!(words, second.technique.nodes().expect("read"));
        let passes = first.rebuild(&world).expect("baked").passes;
        assert_eq!(words, first.technique.nodes().expect("read"));
        assert!(passes.iter().all(|pass| pass.name.starts_with("voxelized.")));
    });
}

/// A free boundary lies between the column's entry and exit, for every setting of `free`.
#[test]
fn free_boundaries_stay_inside() {
    let mut random = Random::new(3);
    let columns: Vec<_> = (0..64 * 64)
        .map(|_| {
            let entry = random.bits() % 64;
            [entry, entry + random.bits() % (65 - entry)]
        })
        .collect();
    for free in [Free::Exit, Free::Entry, Free::Shared] {
        for (boundary, [entry, exit]) in boundaries(&columns, 64, free).into_iter().zip(&columns) {
            assert!(boundary >= *entry && boundary <= *exit, "{free:?}: {boundary} of {entry} to {exit}");
        }
    }
}

/// On visible surfaces and in space, there are no leaks and no false shadows outside the boundary, and the boundary does not cover
/// everything.
#[test]
fn nothing_leaks_outside_the_boundary() {
    if is_long("nothing_leaks_outside_the_boundary") {
        return;
    }
    gpu_test("nothing_leaks_outside_the_boundary", |context| {
        let specs = [
            "voxelized:size=256",
            "voxelized:size=256,coverage=conservative",
            "voxelized:size=512,filter=3",
            "voxelized:size=512,filter=3,coverage=conservative",
            "voxelized:size=256,closed=off",
            "voxelized:size=256,free=exit,structure=svo",
            "voxelized:size=256,free=entry",
            "voxelized:size=1024,filter=9",
        ];
        for scene in shapes::seen() {
            for row in rows(context, &scene, &crate::support::some(specs, 4)) {
                assert_eq!(row.frame_ns, row.draw_ns.map(|draw| draw.median), "a bake is no part of a frame");
                // In voxels, as in docs/notebook/voxelized.md: half the filter across, half a voxel more if conservative, and a voxel along
                // the light; a surface point is moved as far across, plus half a voxel and a bit.
                let number = |key: &str| row.variant[key].parse::<f64>().expect("a number");
                let conservative = row.variant["coverage"] == "conservative";
                let across = number("filter") / 2.0 + if conservative { 0.5 } else { 0.0 };
                let (across, voxel) = (2f64.sqrt() * across, diagonal(&scene) / number("size"));
                let reach = [(across + 1.0) * voxel, (2.0 * across + 1.6) * voxel];
                assert_right_beyond_the_resolution(&scene, row, 2000, reach);
            }
        }
    });
}

/// The first bake grows buffers that are too small, yet its counts and times are complete: a second bake gives the same.
#[test]
fn a_first_bake_counts_all_of_it() {
    gpu_test("a_first_bake_counts_all_of_it", |context| {
        let scene = shapes::soup();
        let world = World::new(context, &scene).expect("room");
        for tile in [Settings::TILE, 64] {
            let settings = Settings { size: 512, tile, keep_columns: false, ..PLAIN };
            let technique = crate::support::opened(Voxelized::planned(context, &world, &settings), "voxelized");
            let mut opened = Opened::new(context, Box::new(technique), false);
            let names = |passes: &[PassTime]| passes.iter().map(|p| p.name.clone()).collect::<BTreeSet<_>>();
            let first = opened.build(&world).expect("baked").passes;
            let facts = opened.technique.inspect().facts().expect("facts");
            let second = opened.build(&world).expect("baked").passes;
            assert_eq!(names(&first), names(&second));
            if context.features().timestamp_valid_bits > 0 {
                assert!(names(&first).contains("voxelized.columns") && names(&first).contains("voxelized.root"));
            }
            assert_eq!(facts, opened.technique.inspect().facts().expect("facts"));
            assert!(facts.counters.values().all(|count| *count > 0), "{facts:?}");
        }
    });
}
