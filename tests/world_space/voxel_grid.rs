//! The voxel grid: bits against their twin, marches against testing every voxel, visible surfaces against the truth.

mod cone;
mod holes;
mod listed;
mod masks;
mod media;
mod raster;

use crate::shapes;
use crate::support::{ask, assert_right_beyond_the_resolution, gpu_test, rows, scenes::Random, within::diagonal};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::grid::Voxelizer;
use gobo::reference::twin::grid::{Bits, Place};
use gobo::scene::{Light, LightKind, Scene};
use gobo::technique::{Opened, VoxelGrid, voxel_grid::Plan as Settings};
use gobo::world::World;

const PLAIN: Settings =
    Settings { size: 64, steps: None, offset: 0.5, cone: None, voxelizer: Voxelizer::Compute, masks: false, bias: 2.0 };

/// Scenes of meshes, one of them also under a lamp.
fn all() -> Vec<Scene> {
    let mut all = shapes::all();
    let mut lamp = shapes::houses();
    lamp.name = "lamp".into();
    let kind = LightKind::Point { position: DVec3::new(0.1, -0.7, 0.8) };
    lamp.lights = vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }];
    all.push(lamp);
    all
}

fn built(context: &Context, scene: &Scene, settings: Settings) -> (World, Opened<VoxelGrid>) {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = crate::support::opened(VoxelGrid::planned(context, &world, &settings), "voxel-grid");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    (world, opened)
}

fn place(grid: &VoxelGrid) -> Place {
    let data = grid.grid().data().expect("read");
    Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size }
}

fn triangles(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let of = |m: &gobo::scene::Mesh| m.triangles.iter().map(|t| t.map(|i| m.positions[i as usize])).collect::<Vec<_>>();
    scene.meshes.iter().flat_map(of).collect()
}

fn twin(scene: &Scene, place: &Place) -> Bits {
    let among = triangles(scene).into_iter().map(|t| t.map(|corner| place.voxels(corner)));
    Bits::voxelize(among, place.size)
}

#[test]
fn bits_equal_their_twin() {
    gpu_test("bits_equal_their_twin", |context| {
        for scene in all() {
            for size in crate::support::some([64, 256, 128], 2) {
                let (_, opened) = built(context, &scene, Settings { size, ..PLAIN });
                let at = place(&opened.technique);
                let corners = triangles(&scene).into_iter().flatten();
                let expected = Place::about(corners, size);
                // Equal up to rounding in the device's division.
                for (a, b) in [(at.voxel, expected.voxel), (at.per_unit, expected.per_unit)] {
                    assert!((a - b).abs() <= b.abs() * 1e-6, "{}: {at:?}, the twin {expected:?}", scene.name);
                }
                let bits = opened.technique.grid().bits().expect("read");
                assert!(bits == twin(&scene, &at).words, "{}, size {size}", scene.name);
                let is_empty = bits.iter().all(|word| *word == 0);
                assert_eq!(is_empty, !scene.has_triangles(), "{}", scene.name);
            }
        }
    });
}

/// Meshes that moved away leave nothing behind, and the same scene gives the same grid.
#[test]
fn a_grid_is_cleared() {
    gpu_test("a_grid_is_cleared", |context| {
        let scene = shapes::houses();
        let (mut world, mut opened) = built(context, &scene, PLAIN);
        let bits = opened.technique.grid().bits().expect("read");
        let mut moved = scene.clone();
        for (i, mesh) in moved.meshes.iter_mut().enumerate() {
            mesh.positions.iter_mut().for_each(|p| p[i % 3] *= 0.4);
        }
        world.replace(&moved).expect("as many of all");
        opened.build(&world).expect("built");
        let at = place(&opened.technique);
        let after = opened.technique.grid().bits().expect("read");
        assert!(after != bits && after == twin(&moved, &at).words);
        world.replace(&scene).expect("as many of all");
        opened.build(&world).expect("built");
        assert!(opened.technique.grid().bits().expect("read") == bits);
    });
}

/// Every voxel that contains a point of a triangle is occupied: nothing is missed, independently of the twin.
#[test]
fn no_surface_is_missed() {
    gpu_test("no_surface_is_missed", |context| {
        let mut random = Random::new(17);
        for scene in all() {
            let (_, opened) = built(context, &scene, Settings { size: 128, ..PLAIN });
            let at = place(&opened.technique);
            let bits = opened.technique.grid().bits().expect("read");
            let words = |voxel: [usize; 3]| (voxel[2] / 4 * 32 + voxel[1] / 4) * 32 + voxel[0] / 4;
            for triangle in triangles(&scene) {
                let [a, b, c] = triangle.map(|corner| DVec3::from(corner.map(f64::from)));
                for _ in 0..20 {
                    let [mut u, mut v] = [(); 2].map(|()| f64::from(random.bits() % 1000) / 999.0);
                    if u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let origin = DVec3::from(at.origin.map(f64::from));
                    let p = (a + (b - a) * u + (c - a) * v - origin) * f64::from(at.per_unit);
                    let voxel = p.to_array().map(|c| c.floor() as usize);
                    let bit = voxel[0] % 4 + 4 * (voxel[1] % 4) + 16 * (voxel[2] % 4);
                    assert!(bits[words(voxel)] >> bit & 1 == 1, "{}: {p}", scene.name);
                }
            }
        }
    });
}

/// Returns the start and the vector of a look-up's march, in voxels.
fn way(place: &Place, scene: &Scene, position: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let from = place.voxels(position);
    let light = &scene.lights[0];
    let way = match light.position() {
        None => {
            let middle = place.size as f32 / 2.0;
            let apart = from.map(|v| (v - middle).powi(2)).iter().sum::<f32>().sqrt();
            let towards = light.towards(glam::DVec3::ZERO);
            towards.to_array().map(|d| d as f32 * (2.0 * place.size as f32 + apart))
        }
        Some(light) => {
            let light = light.as_vec3().to_array();
            [0, 1, 2].map(|i| (light[i] - position[i]) * place.per_unit)
        }
    };
    (from, way)
}

/// Skipping empty space changes no look-up: the twin tests every voxel. If a ray just touches a voxel's edge either result is right, and
/// the two rays beside it differ.
#[test]
fn ways_equal_their_twin() {
    gpu_test("ways_equal_their_twin", |context| {
        for scene in all() {
            for steps in [None, Some(25), Some(75)] {
                let settings = Settings { steps, ..PLAIN };
                let (_, opened) = built(context, &scene, settings);
                let at = place(&opened.technique);
                let bits = twin(&scene, &at);
                let points = shapes::about(&scene, 3000);
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let (mut blocked, mut unsure) = (0, 0);
                for (point, answer) in points.iter().zip(answers) {
                    let (from, way) = way(&at, &scene, *point);
                    let march = |from: [f32; 3]| match steps {
                        None => bits.march_exact(from, way),
                        Some(steps) => bits.march_steps(from, way, steps, settings.offset),
                    };
                    let met = march(from);
                    blocked += u32::from(met);
                    if met == (answer == 0.0) {
                        continue;
                    }
                    let about =
                        (0..8).map(|i| march([0, 1, 2].map(|a| from[a] + if i >> a & 1 == 1 { 2e-3 } else { -2e-3 })));
                    let met_beside = about.filter(|met| *met).count();
                    assert!(
                        (1..8).contains(&met_beside),
                        "{}, {steps:?}: {answer} at {from:?} along {way:?}",
                        scene.name
                    );
                    unsure += 1;
                }
                let enough = blocked > 30 || !scene.has_triangles();
                assert!(unsure < 60 && enough, "{}, {steps:?}: {unsure} unsure, {blocked} blocked", scene.name);
            }
        }
    });
}

/// Even steps find only voxels on the ray and, if they are a fraction of a voxel long, all of these except clipped corners. Points are
/// close enough to a lamp that each of the 75 steps is at most a quarter of a voxel.
#[test]
fn fine_steps_agree_with_exact_ways() {
    gpu_test("fine_steps_agree_with_exact_ways", |context| {
        let mut scene = shapes::houses();
        let lamps: Vec<_> = shapes::about(&scene, 24).iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        let light = |lamp: &DVec3| Light {
            kind: LightKind::Point { position: *lamp },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        };
        scene.lights = lamps.iter().map(light).collect();
        let (_world, exact) = built(context, &scene, PLAIN);
        let (_world, steps) = built(context, &scene, Settings { steps: Some(75), ..PLAIN });
        let reach = 75.0 / 4.0 * f64::from(place(&exact.technique).voxel);
        let (mut both, mut missed, mut beside, mut asked) = (0, 0, 0, 0);
        for (light, lamp) in lamps.iter().enumerate() {
            let near = |p: &[f32; 3]| DVec3::from(p.map(f64::from)).distance(*lamp) < reach;
            let points: Vec<_> = shapes::about(&scene, 5000).into_iter().filter(near).collect();
            let [exact, steps] = [&exact, &steps].map(|o| ask(context, o.technique.as_ref(), light, &points));
            let count = |wanted: [f32; 2]| exact.iter().zip(&steps).filter(|(a, b)| [**a, **b] == wanted).count();
            both += count([0.0, 0.0]);
            missed += count([0.0, 1.0]);
            beside += count([1.0, 0.0]);
            asked += points.len();
        }
        println!("{asked} points, {both} blocked in both, {missed} by a corner, {beside} beside the way");
        // By rounding, some steps find the voxel beside the ray.
        assert!(both > 100 && beside * 1000 < asked, "{both}, {beside}");
        assert!(missed * 20 < both, "{missed} of {both}");
    });
}

/// All lights share one grid, and each gives the same look-ups as alone.
#[test]
fn lights_share_a_grid() {
    gpu_test("lights_share_a_grid", |context| {
        let mut both = shapes::houses();
        let kind = LightKind::Point { position: DVec3::new(0.1, -0.7, 0.8) };
        both.lights.push(Light { kind, radiance: [1.0; 3], radius: f64::INFINITY });
        let (_, together) = built(context, &both, PLAIN);
        let points = shapes::about(&both, 2000);
        for light in 0..2 {
            let mut alone = both.clone();
            alone.lights = vec![both.lights[light]];
            let (_, alone) = built(context, &alone, PLAIN);
            let answers = ask(context, together.technique.as_ref(), light, &points);
            assert_eq!(answers, ask(context, alone.technique.as_ref(), 0, &points), "light {light}");
            let blocked = answers.iter().filter(|answer| **answer == 0.0).count();
            assert!(blocked > 30 && blocked < 1970, "light {light}: {blocked} blocked");
        }
    });
}

/// Points without a voxel are lit: NaN, infinite, outside.
#[test]
fn what_has_no_voxel_is_lit() {
    gpu_test("what_has_no_voxel_is_lit", |context| {
        let scene = shapes::houses();
        let (_, opened) = built(context, &scene, PLAIN);
        let points = [[f32::NAN; 3], [f32::INFINITY; 3], [1e30, 0.0, 0.0], [0.0, 0.0, 50.0], [60.0, 0.0, 0.0]];
        assert_eq!(ask(context, opened.technique.as_ref(), 0, &points), [1.0; 5]);
    });
}

/// Outside a boundary of one voxel, or one cell, there are no leaks and no false shadows, in space and on surfaces.
#[test]
fn exact_ways_neither_leak_nor_shadow_falsely() {
    if crate::support::is_costly("exact_ways_neither_leak_nor_shadow_falsely") {
        return;
    }
    gpu_test("exact_ways_neither_leak_nor_shadow_falsely", |context| {
        let mut lamp = shapes::houses();
        let kind = LightKind::Point { position: DVec3::new(0.1, -0.7, 0.8) };
        lamp.lights = vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }];
        for scene in shapes::seen().into_iter().chain([lamp]) {
            let solid = crate::support::some([256, 64], 1).into_iter().map(|size| ("solid", size));
            let masks = crate::support::some([64, 256], 1).into_iter().map(|size| ("mask", size));
            let cells: Vec<(&str, u32)> = solid.chain(masks).collect();
            let specs: Vec<_> =
                cells.iter().map(|(cell, size)| format!("voxel-grid:cell={cell},size={size}")).collect();
            let specs: Vec<_> = specs.iter().map(String::as_str).collect();
            for (row, (cell, size)) in rows(context, &scene, &specs).into_iter().zip(cells) {
                // Reach of the boundary: a voxel along each axis, the same distance off a surface, and the bias along the ray.
                let side = diagonal(&scene) / f64::from(size - 2) * if cell == "mask" { 0.25 } else { 1.0 };
                let reach = 3f64.sqrt() * side;
                let along = f64::from(PLAIN.bias) * side;
                assert_right_beyond_the_resolution(&scene, row, 1000, [reach, 2.0 * reach + along]);
            }
        }
    });
}
