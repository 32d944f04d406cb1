//! Bakes on disk: a file opens as it was baked, and the checks detect all damage.

use super::{PLAIN, baked, shapes};
use crate::support::{self, all, ask, gpu_test, scenes::Random, spec};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::scene::{Light, LightKind, Scene};
use gobo::technique::{self, Coverage, Opened, Structure, Technique, voxelized::Plan as Settings};
use gobo::world::World;
use std::path::Path;

/// Offset of the trees and size of each, as documented in docs/notebook/voxelized.md.
const TREES: usize = 88;
const TREE: usize = 200;

/// Size of the checksum in bytes.
const LAST: usize = 4;

fn two_lights() -> Scene {
    let mut scene = shapes::houses();
    let direction = DVec3::new(-0.3, 0.2, -0.9).normalize();
    scene.lights.push(Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY });
    scene
}

fn world(context: &Context, scene: &Scene) -> World {
    World::new(context, scene).expect("room for the scene")
}

fn open(context: &Context, world: &World, file: &Path, filter: u32) -> gobo::Result<Opened> {
    technique::open(context, world, &spec(&format!("voxelized:file={},filter={filter}", file.display())))
}

/// Returns the file of a small bake.
fn bytes(context: &Context, scene: &Scene) -> Vec<u8> {
    let opened = baked(context, scene, PLAIN);
    opened.technique.inspect().file(&world(context, scene)).expect("read back").expect("baked")
}

/// Returns the bytes with the right checksum.
fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
    let content = bytes.len() - LAST;
    let sum = crc32fast::hash(&bytes[..content]);
    bytes[content..].copy_from_slice(&sum.to_le_bytes());
    bytes
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

/// Asserts that the error is one line that names the file.
#[track_caller]
fn told(result: gobo::Result<Opened>, file: &Path, what: &str) -> String {
    let error = result.err().unwrap_or_else(|| panic!("{what} must be refused")).to_string();
    assert!(error.contains(&*file.to_string_lossy()) && !error.contains('\n'), "{what}: {error}");
    error
}

#[test]
fn a_file_answers_as_its_bake() {
    gpu_test("a_file_answers_as_its_bake", |context| {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("bake.gobo");
        for scene in std::iter::once(two_lights()).chain(support::some(shapes::all(), 2)) {
            for (structure, tile, coverage) in [
                (Structure::Dag, Settings::TILE, Coverage::Middle),
                (Structure::Svo, 64, Coverage::Conservative),
                (Structure::Dag, 64, Coverage::Middle),
            ] {
                let settings = Settings { size: 128, structure, tile, coverage, filter: 3, ..PLAIN };
                let what = format!("{}, {settings:?}", scene.name);
                let (world, bake) = (world(context, &scene), baked(context, &scene, settings));
                let bytes = bake.technique.inspect().file(&world).expect("read back").expect("baked");
                let words: Vec<u32> =
                    bytemuck::pod_collect_to_vec(&bytes[TREES + TREE * scene.lights.len()..bytes.len() - LAST]);
                assert_eq!(words, bake.technique.nodes().expect("read"), "{what}");

                std::fs::write(&file, &bytes).expect("written");
                let mut opened = open(context, &world, &file, 3).unwrap_or_else(|error| panic!("{what}: {error}"));
                assert!(opened.build(&world).expect("nothing to do").passes.is_empty(), "{what}");
                let [was, is] = [bake.technique.inspect().facts(), opened.technique.inspect().facts()]
                    .map(|facts| facts.expect("known"));
                assert_eq!((was.bytes_on_disk, is.bytes_on_disk), (Some(bytes.len() as u64), Some(bytes.len() as u64)));
                assert_eq!((is.path, is.bytes_resident, is.bytes_transient), ("file", was.bytes_resident, 0), "{what}");
                assert_eq!(is.counters, was.counters, "{what}");
                let points = shapes::about(&scene, 2000);
                for light in 0..scene.lights.len() {
                    let [was, is] = [bake.technique.as_ref(), opened.technique.as_ref() as &dyn Technique]
                        .map(|technique| ask(context, technique, light, &points));
                    assert_eq!(was, is, "{what}, light {light}");
                }
                let views = |technique: &dyn Technique| -> Vec<_> {
                    technique.inspect().resolution().iter().map(|r| (r.view, r.reach_texels, r.depth)).collect()
                };
                assert_eq!(views(bake.technique.as_ref()), views(opened.technique.as_ref()), "{what}");
            }
        }
    });
}

/// Flips a bit in each byte, and truncates to each length.
#[test]
fn every_damage_is_refused() {
    gpu_test("every_damage_is_refused", |context| {
        let scene = two_lights();
        let (world, good) = (world(context, &scene), bytes(context, &scene));
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("bake.gobo");
        assert!(good.len() > TREES + 2 * TREE + 500, "header, trees and nodes: {} bytes", good.len());
        // A checksum detects all damage alike, so it suffices to change some of the bytes, covering all bit positions.
        for at in (0..good.len()).step_by(if all() { 1 } else { 5 }) {
            let mut changed = good.clone();
            changed[at] ^= 1 << (at % 8);
            std::fs::write(&file, &changed).expect("written");
            told(open(context, &world, &file, 1), &file, &format!("byte {at} changed"));
            std::fs::write(&file, &good[..at]).expect("written");
            let error = told(open(context, &world, &file, 1), &file, &format!("cut at {at}"));
            assert!(error.contains("cut off"), "cut at {at}: {error}");
        }
        std::fs::write(&file, &good).expect("written");
        assert!(open(context, &world, &file, 1).is_ok(), "undamaged");
    });
}

/// Damage that a checksum does not detect: files that were written wrong. They are refused, or look-ups stay inside their buffers.
#[test]
fn no_file_leads_astray() {
    if crate::support::is_costly("no_file_leads_astray") {
        return;
    }
    gpu_test("no_file_leads_astray", |context| {
        let scene = two_lights();
        let (world, good) = (world(context, &scene), bytes(context, &scene));
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("bake.gobo");
        let points = shapes::about(&scene, 150);
        let heads = TREES + 2 * TREE;
        let try_with = |changes: &[(usize, u32)]| {
            let mut changed = good.clone();
            changes.iter().for_each(|(at, value)| changed[*at..at + 4].copy_from_slice(&value.to_le_bytes()));
            std::fs::write(&file, signed(changed)).expect("written");
            let what = format!("{changes:x?}");
            match open(context, &world, &file, 9) {
                Ok(opened) => {
                    for light in 0..2 {
                        let answers = ask(context, opened.technique.as_ref(), light, &points);
                        assert!(answers.iter().all(|answer| (0.0..=1.0).contains(answer)), "{what}");
                    }
                    None
                }
                error => Some(told(error, &file, &what)),
            }
        };
        assert_eq!(try_with(&[]), None, "as it was");
        for at in (8..heads).step_by(4) {
            let was = word(&good, at);
            // A cube's axes may have any value: one try is enough.
            let of_tree = (at - TREES.min(at)) % TREE;
            let is_float = at >= TREES && of_tree < 64 && !matches!(of_tree, 12 | 28 | 44 | 60);
            let values = [u32::MAX, 0, 0x7fff_ffff, was.wrapping_add(1), was ^ 64];
            for value in &values[..if is_float { 1 } else { values.len() }] {
                try_with(&[(at, *value)]);
            }
        }
        // Gives all eight children nodes at pointers past the end: for the root, and for the first node of each level.
        for level in 1..=4 {
            let at = word(&good, TREES + 68 + 4 * level) as usize;
            let node = heads + 4 * at;
            let error = try_with(&[(node, u32::MAX), (node + 4, u32::MAX), (node + 8, u32::MAX)]);
            assert!(error.is_some_and(|error| error.contains("damaged")), "level {level}");
        }
        // A cell of an unknown kind, and one whose node is past the end.
        let cell = heads + 4 * word(&good, TREES + 64) as usize;
        for value in [0, u32::MAX] {
            assert!(try_with(&[(cell, value)]).is_some_and(|error| error.contains("damaged")), "cell {value:x}");
        }
        let mut random = Random::new(11);
        for _ in 0..if support::all() { 1000 } else { 30 } {
            let at = heads + 4 * (random.bits() as usize % ((good.len() - LAST - heads) / 4));
            try_with(&[(at, random.bits())]);
        }
    });
}

/// Parts that a bake does not depend on may change; if shapes change, the file belongs to another scene.
#[test]
fn a_file_is_of_its_scene() {
    gpu_test("a_file_is_of_its_scene", |context| {
        let scene = two_lights();
        let mut world = world(context, &scene);
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("bake.gobo");
        std::fs::write(&file, bytes(context, &scene)).expect("written");

        let mut painted = scene.clone();
        (painted.name, painted.meshes[1].albedo, painted.lights[0].radiance) = ("painted".into(), [0.1; 3], [0.2; 3]);
        let mut opened = open(context, &world, &file, 1).expect("the same scene");
        world.replace(&painted).expect("as many of all");
        assert!(opened.build(&world).expect("the same shapes").passes.is_empty());

        let mut moved = scene.clone();
        moved.meshes[1].positions[3][2] += 1e-3;
        let mut turned = scene.clone();
        turned.lights[1].kind = LightKind::Directional { direction: DVec3::NEG_Z };
        let mut hollow = scene.clone();
        hollow.meshes[0].solid = !hollow.meshes[0].solid;
        let mut wound = scene.clone();
        wound.meshes[2].triangles[0].swap(0, 1);
        for other in [moved, turned, hollow, wound] {
            world.replace(&scene).expect("back");
            let mut opened = open(context, &world, &file, 1).expect("the same scene again");
            world.replace(&other).expect("as many of all");
            for result in [opened.build(&world).map(|_| ()), open(context, &world, &file, 1).map(|_| ())] {
                let error = result.expect_err("another scene").to_string();
                assert!(error.contains("meshes or lights differ") && error.contains("bake.gobo"), "{error}");
            }
        }
    });
}

/// There is nothing to write before a build, or after meshes or lights have moved; other casters may move.
#[test]
fn only_what_is_baked_is_written() {
    gpu_test("only_what_is_baked_is_written", |context| {
        let scene = two_lights();
        let mut world = world(context, &scene);
        let mut opened = technique::open(context, &world, &spec("voxelized:size=64")).expect("opened");
        let has_file = |opened: &Opened, world: &World| opened.technique.inspect().file(world).expect("read").is_some();
        assert!(!has_file(&opened, &world));
        opened.build(&world).expect("baked");
        assert!(has_file(&opened, &world));
        let mut seen = scene.clone();
        seen.camera.position.x += 1.0;
        world.replace(&seen).expect("the same meshes and lights");
        assert!(has_file(&opened, &world));
        seen.meshes[0].positions[0][0] += 0.1;
        world.replace(&seen).expect("as many");
        assert!(!has_file(&opened, &world));
    });
}
