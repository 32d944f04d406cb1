//! Lights with a position: pyramids of voxels against their twin, against rays in f64, and visible surfaces against the truth.

use super::{
    Coverage, Free, FreeKey, PLAIN, Settings, Structure, as_baked, assert_same_columns, bake, baked, cube, shapes,
    twin_columns, voxel,
};
use crate::support::{self, ask, assert_right_beyond_the_resolution, gpu_test, is_long, rows, scenes::Random};
use glam::{DVec2, DVec3};
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Meshes, bounds};
use gobo::scene::{Light, LightKind, Projection, Scene};
use gobo::technique::Technique;

fn lit_by(mut scene: Scene, kinds: &[LightKind]) -> Scene {
    let light = |kind: &LightKind| Light { kind: *kind, radiance: [1.0; 3], radius: f64::INFINITY };
    scene.lights = kinds.iter().map(light).collect();
    scene
}

fn spot(position: [f64; 3], direction: [f64; 3], cone_degrees: f64) -> LightKind {
    LightKind::Spot { position: position.into(), direction: DVec3::from(direction).normalize(), cone_degrees }
}

/// Spots that see the scene from outside, from above, and from so close that most of it is beside or behind the light.
fn spots() -> Vec<Scene> {
    let slanted = spot([-0.8, -1.1, 1.7], [0.45, 0.5, -0.8], 75.0);
    let above = spot([0.05, 0.1, 1.3], [0.0, 0.0, -1.0], 110.0);
    let near = spot([0.12, -0.31, 0.07], [0.8, 0.3, -0.2], 150.0);
    let scenes = [shapes::houses(), shapes::soup(), shapes::extremes(), shapes::wires(true)];
    let all = scenes.into_iter().flat_map(|scene| [slanted, above, near].map(|kind| lit_by(scene.clone(), &[kind])));
    all.chain([lit_by(Scene { meshes: Vec::new(), ..shapes::houses() }, &[above])]).collect()
}

#[test]
fn columns_and_nodes_of_pyramids_equal_their_twins() {
    gpu_test("columns_and_nodes_of_pyramids_equal_their_twins", |context| {
        for scene in support::some(spots(), 4) {
            for (closed, coverage, structure) in [
                (true, Coverage::Middle, Structure::Dag),
                (true, Coverage::Conservative, Structure::Svo),
                (false, Coverage::Middle, Structure::Svo),
            ] {
                let settings = Settings { closed, coverage, structure, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let tree = opened.technique.trees().expect("read")[0];
                let columns = opened.technique.columns().expect("read");
                let what = format!("{} from {:?}, closed {closed}, {coverage:?}", scene.name, scene.lights[0].kind);
                assert_same_columns(&columns, &twin_columns(&scene, &tree, settings), &what);
                let twin = bake(&columns, 64, Settings::TILE, Free::Shared, settings.merges());
                assert_eq!(as_baked(&opened.technique, 0, settings), twin, "{what}");
            }
        }
    });
}

/// The columns of a point light's last face, which is baked after all others, equal their twins. Baking in tiles changes no look-up.
#[test]
fn faces_equal_their_twins() {
    gpu_test("faces_equal_their_twins", |context| {
        for scene in [shapes::houses(), shapes::soup()] {
            let scene = lit_by(scene, &[LightKind::Point { position: DVec3::new(0.1, -0.05, 0.6) }]);
            let opened = baked(context, &scene, PLAIN);
            let trees = opened.technique.trees().expect("read");
            assert_eq!((trees.len(), trees[0].first, trees[0].faces, trees[5].faces), (6, 0, 6, 0));
            let columns = opened.technique.columns().expect("read");
            assert_same_columns(&columns, &twin_columns(&scene, &trees[5], PLAIN), &scene.name);
            // Baking in tiles gives the same look-ups as baking the whole.
            let points = shapes::about(&scene, 4000);
            let tiled = baked(context, &scene, Settings { tile: 32, ..PLAIN });
            let [whole, tiled] = [opened, tiled].map(|opened| ask(context, opened.technique.as_ref(), 0, &points));
            assert_eq!(whole, tiled, "{}", scene.name);
        }
    });
}

/// Rays through column centres in f64 determine where light stops. Columns with another surface's edge closer than the rounding of corners
/// are skipped.
#[test]
fn columns_end_where_rays_do() {
    gpu_test("columns_end_where_rays_do", |context| {
        let mut met = 0;
        for scene in support::some(spots(), 3) {
            let opened = baked(context, &scene, Settings { closed: false, free: FreeKey::Exit, ..PLAIN });
            let view = opened.technique.inspect().resolution()[0].view;
            assert!(view.projection() == Projection::Perspective && view.near == 0.0);
            let meshes = Meshes::new(&scene.meshes);
            let along = |at: DVec2| {
                let ray = view.ray(at);
                let hit = meshes.hit(ray.origin, ray.direction);
                (64.0 * hit.map_or(1.0, |hit| hit.distance / f64::from(view.far))).min(64.0)
            };
            let mut compared = 0;
            for (i, [entry, exit]) in opened.technique.columns().expect("read").into_iter().enumerate() {
                let middle = DVec2::new((i % 64) as f64, (i / 64) as f64) + 0.5;
                let about = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [0.0, 0.0]];
                let all = about.map(|by| along(middle + DVec2::from(by) / 64.0));
                let [low, high] = [all.iter().copied().fold(64.0, f64::min), all.iter().copied().fold(0.0, f64::max)];
                if high - low > 0.5 {
                    continue;
                }
                assert_eq!(entry, exit);
                let entry = f64::from(entry);
                assert!((low - 0.55..=high + 0.55).contains(&entry), "{}, {middle}: {entry}, {low}", scene.name);
                compared += 1;
                met += usize::from(entry < 64.0);
            }
            assert!(compared > 1500, "{}: {compared} columns compared", scene.name);
        }
        assert!(met > 1500, "{met} columns meet something");
    });
}

/// Look-ups in a cone equal those of a filter that tests each voxel; behind the light all is lit.
#[test]
fn look_ups_of_pyramids_equal_their_twins() {
    gpu_test("look_ups_of_pyramids_equal_their_twins", |context| {
        for scene in support::some(spots(), 3) {
            for (filter, structure) in [(1, Structure::Dag), (9, Structure::Dag), (3, Structure::Svo)] {
                let settings = Settings { structure, filter, ..PLAIN };
                let opened = baked(context, &scene, settings);
                let (tree, twin) =
                    (opened.technique.trees().expect("read")[0], as_baked(&opened.technique, 0, settings));
                let points = shapes::about(&scene, 12000);
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let mut compared = 0;
                for (point, answer) in points.iter().zip(answers) {
                    let at = voxel(&cube(&tree), *point);
                    if at[2] < 0.0 {
                        assert_eq!(answer, 1.0, "behind the light");
                    }
                    let inside = |v: f32| (5.0..59.0).contains(&v) && (v - v.round()).abs() > 2e-3;
                    if !(inside(at[0]) && inside(at[1]) && at[2] > 0.0 && (at[2] - at[2].round()).abs() > 2e-3) {
                        continue;
                    }
                    compared += 1;
                    let expected = twin.look_up(at, filter);
                    assert!((f64::from(answer) - expected).abs() < 1e-6, "{}: {answer}, {expected}", scene.name);
                }
                assert!(compared > 300, "{}: {compared} points compared", scene.name);
            }
        }
    });
}

/// A room around a lamp.
fn room() -> Scene {
    let scene = Scene::load("cornell", 0.0).expect("built in");
    lit_by(scene, &[LightKind::Point { position: DVec3::new(0.13, -0.22, 1.4) }])
}

/// As for directional lights: beyond the resolution there are no leaks and no false shadows, and not everything is within it.
#[test]
fn nothing_leaks_from_lights_with_a_place() {
    if is_long("nothing_leaks_from_lights_with_a_place") {
        return;
    }
    gpu_test("nothing_leaks_from_lights_with_a_place", |context| {
        let [slanted, above] =
            [spot([-0.8, -1.1, 1.7], [0.45, 0.5, -0.8], 75.0), spot([0.05, 0.1, 1.3], [0.1, 0.0, -1.0], 100.0)];
        let lamp = LightKind::Point { position: DVec3::new(0.1, -0.05, 0.7) };
        let scenes = [
            room(),
            lit_by(shapes::houses(), &[slanted, above]),
            lit_by(shapes::soup(), &[lamp, above]),
            lit_by(shapes::houses(), &[lamp]),
        ];
        let specs = [
            "voxelized:size=256",
            "voxelized:size=512,filter=5",
            "voxelized:size=256,coverage=conservative",
            "voxelized:size=256,closed=off,structure=svo",
        ];
        for (i, scene) in support::some(scenes.into_iter().enumerate(), 3) {
            // Each scene starts with a different spec.
            let specs = support::some((0..specs.len()).map(|k| specs[(k + i) % specs.len()]), 1);
            for row in rows(context, &scene, &specs) {
                let number = |key: &str| row.variant[key].parse::<f64>().expect("a number");
                let across = number("filter") / 2.0 + if row.variant["coverage"] == "conservative" { 0.5 } else { 0.0 };
                // The widest voxel, at the farthest distance.
                let corners = bounds(&scene).expect("meshes");
                let far =
                    scene.lights.iter().filter_map(Light::position).map(|p| {
                        corners.map(|c| (c - p).abs()).into_iter().fold(DVec3::ZERO, DVec3::max).max_element()
                    });
                let column = 2.0 * 1.35 * far.fold(0.0, f64::max) / number("size");
                let across = 2f64.sqrt() * across;
                let reach = [(across + 1.8) * column, (2.0 * across + 2.8) * column];
                assert_right_beyond_the_resolution(&scene, row, 1500, reach);
            }
        }
    });
}

/// A floor below a lamp, crossed by the borders between the faces of a point light: no point of the floor shadows itself.
#[test]
fn a_floor_under_a_lamp_never_shadows_itself() {
    if is_long("a_floor_under_a_lamp_never_shadows_itself") {
        return;
    }
    gpu_test("a_floor_under_a_lamp_never_shadows_itself", |context| {
        let mut random = Random::new(6);
        let flat = |closed| shapes::flat([0.0, 0.0, -1.0], closed);
        let lamps = [
            LightKind::Point { position: DVec3::new(0.1, 0.03, 0.4) },
            LightKind::Point { position: DVec3::new(-0.3, 0.2, 0.06) },
            spot([0.4, -0.3, 0.5], [-0.3, 0.2, -0.6], 120.0),
            spot([0.9, 0.2, 0.15], [-0.9, 0.1, -0.3], 60.0),
        ];
        let bakes = [
            (256, 1, Coverage::Middle),
            (64, 3, Coverage::Conservative),
            (512, 5, Coverage::Conservative),
            (1024, 9, Coverage::Middle),
        ];
        // All combinations, with a different bake first for each lamp.
        let cases = (0..32).map(|i| (lamps[i % 4], (i / 16 + i) % 2 == 1, bakes[(i / 4 + i) % 4]));
        for (kind, closed, (size, filter, coverage)) in support::some(cases, 3) {
            let scene = lit_by(flat(closed), &[kind]);
            let opened = baked(context, &scene, Settings { size, filter, coverage, keep_columns: false, ..PLAIN });
            let mut points: Vec<[f32; 3]> =
                (0..8000).map(|_| [random.between(-0.95, 0.95), random.between(-0.95, 0.95), 0.0]).collect();
            points.retain(|p| scene.lights[0].shines_on(DVec3::from(p.map(f64::from))));
            let normals = vec![[0.0, 0.0, 1.0]; points.len()];
            let query = Query::of_lights(context, &[PointBatch { light: 0, points: &points, normals: &normals }]);
            let answers = query.expect("room").ask(&opened.technique.answer()).expect("asked");
            let shadowed: Vec<_> = points.iter().zip(&answers).filter(|(_, answer)| **answer < 1.0).collect();
            assert!(points.len() > 1000);
            assert!(
                shadowed.is_empty(),
                "{kind:?}, closed {closed}, size {size}, filter {filter}, {coverage:?}: {} of {}, {:?}",
                shadowed.len(),
                points.len(),
                shadowed[0]
            );
        }
    });
}
