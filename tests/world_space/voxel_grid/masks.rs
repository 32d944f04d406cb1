//! `cell=mask`: words against their twin, marches against testing every cell, receivers with both kinds of cell, refusals.

use crate::support::{self, ask, gpu_test, scenes, scenes::Random, some, spec};
use crate::voxel_grid::{PLAIN, all, built, place, raster, shapes, triangles, twin, way};
use glam::DVec3;
use gobo::Error;
use gobo::gpu::Context;
use gobo::query::{PointBatch, Query};
use gobo::reference::twin::{grid::Place, masks::Masks};
use gobo::scene::{LightKind, Mesh, Scene};
use gobo::technique::{Technique, VoxelGrid, open, voxel_grid::Plan as Settings};
use gobo::world::World;

const MASKED: Settings = Settings { masks: true, ..PLAIN };

/// A scene with so many triangles that the masks do not fit at first.
fn dense() -> Scene {
    let mut random = Random::new(12);
    let mut scene = scenes::directional("dense", [0.4, 0.35, -0.8], Vec::new());
    let mut triangle = |_| {
        let at = random.point(-1.0, 1.0);
        [(); 3].map(|()| random.point(-0.2, 0.2)).map(|by| [0, 1, 2].map(|axis| at[axis] + by[axis]))
    };
    let positions: Vec<[f32; 3]> = (0..1500).flat_map(&mut triangle).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    scene.meshes =
        vec![Mesh { name: "dense".into(), positions, triangles, albedo: [0.5; 3], solid: false, alpha: None }];
    scene
}

fn masks_of(scene: &Scene, place: &Place) -> Masks {
    let among = triangles(scene).into_iter().map(|t| t.map(|corner| place.voxels(corner)));
    Masks::new(&twin(scene, place), among, place.size)
}

fn words(grid: &VoxelGrid) -> Vec<u32> {
    grid.grid().masks().expect("read")
}

/// Masks equal the twin's word for word, even after the buffer grew, and after the world moved away and back.
#[test]
fn masks_equal_their_twin() {
    if crate::support::is_costly("masks_equal_their_twin") {
        return;
    }
    gpu_test("masks_equal_their_twin", |context| {
        let mut grew = false;
        // Long triangles take the twin a long time.
        let more = some(all().into_iter().chain([raster::slivers()]), 2);
        for scene in [dense()].into_iter().chain(more) {
            let sizes: &[u32] = if scene.name == "dense" { &[64, 128] } else { &[64] };
            for size in some(sizes.iter().copied(), 1) {
                let (mut world, mut opened) = built(context, &scene, Settings { size, ..MASKED });
                let at = place(&opened.technique);
                let (masks, numbers) = (words(&opened.technique), (size / 4).pow(3) as usize);
                assert!(masks == masks_of(&scene, &at).words, "{}, size {size}", scene.name);
                assert_eq!(masks.len() == numbers, !scene.has_triangles(), "{}", scene.name);
                grew |= masks.len() - numbers > 2 * 4 * size.pow(2) as usize;
                let mut moved = scene.clone();
                moved.meshes.iter_mut().flat_map(|m| &mut m.positions).for_each(|p| p[0] *= 0.4);
                world.replace(&moved).expect("as many of all");
                opened.build(&world).expect("built");
                let there = place(&opened.technique);
                assert!(words(&opened.technique) == masks_of(&moved, &there).words, "{} moved", scene.name);
                world.replace(&scene).expect("as many of all");
                opened.build(&world).expect("built");
                assert!(words(&opened.technique) == masks, "{} moved back", scene.name);
            }
        }
        assert!(grew);
        let (_, opened) = built(context, &shapes::houses(), PLAIN);
        assert!(words(&opened.technique).is_empty(), "nobody asks for them");
    });
}

/// Every cell that contains a point of a triangle is occupied, in the device's masks and in the twin's, which are equal.
#[test]
fn no_cell_is_missed() {
    gpu_test("no_cell_is_missed", |context| {
        let mut random = Random::new(19);
        for scene in some(all(), 3) {
            let (_, opened) = built(context, &scene, MASKED);
            let at = place(&opened.technique);
            let masks = masks_of(&scene, &at);
            assert!(masks.words == words(&opened.technique), "{}", scene.name);
            let origin = DVec3::from(at.origin.map(f64::from));
            for triangle in triangles(&scene) {
                let [a, b, c] = triangle.map(|corner| DVec3::from(corner.map(f64::from)));
                for _ in 0..40 {
                    let [mut u, mut v] = [(); 2].map(|()| f64::from(random.between(0.0, 1.0)));
                    if u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let p = (a + (b - a) * u + (c - a) * v - origin) * 4.0 * f64::from(at.per_unit);
                    assert!(masks.has(p.to_array().map(|c| c as u32)), "{}: {p}", scene.name);
                }
            }
        }
    });
}

/// Skipping changes no look-up; if a ray just touches a cell's edge either result is right, and the rays beside it differ.
#[test]
fn ways_through_masks_equal_their_twin() {
    gpu_test("ways_through_masks_equal_their_twin", |context| {
        for scene in some(all(), 4) {
            let (_, opened) = built(context, &scene, MASKED);
            let at = place(&opened.technique);
            let masks = masks_of(&scene, &at);
            let points = shapes::about(&scene, 3000);
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let (mut blocked, mut unsure) = (0, 0);
            for (point, answer) in points.iter().zip(answers) {
                let (from, way) = way(&at, &scene, *point);
                let met = masks.march_exact(from, way);
                blocked += u32::from(met);
                if met != (answer == 0.0) {
                    let by = |i: u32, axis: u32| if i >> axis & 1 == 1 { 1e-3 } else { -1e-3 };
                    let beside = (0..8).map(|i| masks.march_exact([0, 1, 2].map(|a| from[a] + by(i, a as u32)), way));
                    let met_beside = beside.filter(|met| *met).count();
                    assert!((1..8).contains(&met_beside), "{}: {answer} at {from:?} along {way:?}", scene.name);
                    unsure += 1;
                }
            }
            assert!(
                unsure < 60 && (blocked > 20 || scene.meshes.is_empty()),
                "{}: {unsure} unsure, {blocked} blocked",
                scene.name
            );
        }
    });
}

/// Returns the light of the scene's first light at surface points with these normals.
fn ask_surfaces(context: &Context, technique: &dyn Technique, points: &[[f32; 3]], normals: &[[f32; 3]]) -> Vec<f32> {
    let query = Query::of_lights(context, &[PointBatch { light: 0, points, normals }]).expect("room");
    query.ask(&technique.answer()).expect("answered")
}

/// Returns a randomly rotated square of side 2 around a place, points of it, and its normal.
fn turned(random: &mut Random, at: [f32; 3]) -> (Mesh, Vec<[f32; 3]>, DVec3) {
    let any = |random: &mut Random| DVec3::from(random.point(-1.0, 1.0).map(f64::from)).normalize();
    let across = any(random);
    let up = across.cross(any(random)).normalize();
    let point = |x: f64, y: f64| (DVec3::from(at.map(f64::from)) + x * across + y * up).as_vec3().to_array();
    let mesh = scenes::quad([point(-1.0, -1.0), point(1.0, -1.0), point(1.0, 1.0), point(-1.0, 1.0)], 0.5);
    let mut share = || f64::from(random.between(-0.95, 0.95));
    let points = (0..400).map(|_| point(share(), share())).collect();
    (mesh, points, across.cross(up))
}

/// No point of a flat receiver is shadowed, however it is tilted, and for light from overhead to 1° above its plane: under the sun, a lamp
/// and a virtual light, at the origin and far from it, even with the smallest bias.
#[test]
fn a_flat_receiver_never_shadows_itself() {
    gpu_test("a_flat_receiver_never_shadows_itself", |context| {
        let mut random = Random::new(31);
        for i in 0..some(0..60, 18).len() {
            let at = [[0.0; 3], [300.0, -200.0, 50.0]][i % 2];
            let (mesh, points, normal) = turned(&mut random, at);
            let elevation = [90.0f64, 60.0, 30.0, 5.0, 1.0][i % 5].to_radians();
            let along = DVec3::from(mesh.positions[1].map(f64::from)) - DVec3::from(mesh.positions[0].map(f64::from));
            let towards = elevation.sin() * normal + elevation.cos() * along.normalize();
            let mut scene = scenes::directional("turned", (-towards).to_array(), Vec::new());
            let position = DVec3::from(at.map(f64::from)) + 20.0 * towards;
            match i % 3 {
                0 => {}
                1 => scene.lights[0].kind = LightKind::Point { position },
                _ => scene.lights[0].kind = LightKind::Virtual { position, normal: -towards, nearest: 0.1 },
            }
            scene.meshes = vec![mesh];
            let normals = vec![normal.as_vec3().to_array(); points.len()];
            for (masks, bias) in [(false, PLAIN.bias), (true, PLAIN.bias), (true, 0.0)] {
                let (_, opened) = built(context, &scene, Settings { masks, bias, ..PLAIN });
                let answers = ask_surfaces(context, opened.technique.as_ref(), &points, &normals);
                let dark = answers.iter().filter(|answer| **answer != 1.0).count();
                assert_eq!(dark, 0, "masks {masks}, bias {bias:?}, {:?}, normal {normal}", scene.lights[0].kind);
            }
        }
    });
}

/// The side of a closed mesh facing away from the light is dark, right up to its edges.
#[test]
fn what_looks_away_is_dark() {
    gpu_test("what_looks_away_is_dark", |context| {
        let scene = Scene {
            meshes: vec![scenes::cuboid([-0.3, -0.2, -0.25], [0.4, 0.3, 0.2])],
            ..scenes::directional("box", [0.4, 0.35, -0.8], Vec::new())
        };
        let mut random = Random::new(3);
        let mut points = Vec::new();
        let mut normals = Vec::new();
        for _ in 0..3000 {
            let (y, z) = (random.between(-0.2, 0.3), random.between(-0.25, 0.2));
            points.push([0.4, y, z]);
            normals.push([1.0, 0.0, 0.0]);
            points.push([random.between(-0.3, 0.4), y, -0.25]);
            normals.push([0.0, 0.0, -1.0]);
        }
        for settings in [PLAIN, MASKED] {
            let (_, opened) = built(context, &scene, settings);
            let answers = ask_surfaces(context, opened.technique.as_ref(), &points, &normals);
            assert!(answers.iter().all(|answer| *answer == 0.0), "masks: {}", settings.masks);
        }
    });
}

/// Rasterized masks have the same bytes as those of compute passes.
#[test]
fn drawn_masks_are_the_computed_ones() {
    let name = "drawn_masks_are_the_computed_ones";
    gpu_test(name, |context| {
        let ways = raster::rasterizers(name, context);
        for scene in [raster::slivers(), shapes::houses()] {
            let (_, computed) = built(context, &scene, MASKED);
            for voxelizer in &ways {
                let (_, drawn) = built(context, &scene, Settings { voxelizer: *voxelizer, ..MASKED });
                assert!(words(&drawn.technique) == words(&computed.technique), "{}, {voxelizer:?}", scene.name);
            }
        }
    });
}

#[test]
fn steps_and_cones_have_no_masks() {
    gpu_test("steps_and_cones_have_no_masks", |context| {
        let world = World::new(context, &shapes::houses()).expect("room for the scene");
        for march in ["steps", "cone"] {
            let error = open(context, &world, &spec(&format!("voxel-grid:cell=mask,march={march}"))).err();
            let error = error.expect("refused");
            assert!(
                matches!(&error, Error::Input { name, .. } if *name == format!("cell=mask,march={march}")),
                "{error}"
            );
            assert!(!error.to_string().contains('\n'), "{error}");
        }
        support::opened(open(context, &world, &spec("voxel-grid:cell=mask,size=64")), "masks");
    });
}
