//! Compares a field's cells with the same number of spheres, one per non-empty cell, of the same size in bytes and the same mass, against
//! the exact field. docs/notebook/volumes.md has the figures, from `cargo test --release --test world_space spheres -- --nocapture`.

use crate::support::{ask, gpu_test, spec};
use glam::{DVec3, Vec3};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, space_points};
use gobo::reference::twin::cell;
use gobo::scene::{Caster, Particle, Placed, Scene, Volume};
use gobo::technique;
use gobo::world::World;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Returns the mean and the largest error of light at points in space.
fn error(expected: &[f64], found: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let apart = |(a, b): (&f64, f64)| (a - b).abs();
    let all: Vec<f64> = expected.iter().zip(found).map(apart).collect();
    [all.iter().sum::<f64>() / all.len() as f64, all.into_iter().fold(0.0, f64::max)]
}

/// Returns a sphere with the cell's mass, `wide` times as wide as the cell's sides.
fn sphere(cell: &Caster, wide: f64) -> Particle {
    // The cells of `cloud` are cubes, and the radius is half the diagonal.
    let side = f64::from(cell.radius) * 2.0 / 3f64.sqrt();
    let radius = 0.5 * wide * side;
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let extinction = (f64::from(cell.density) * side.powi(3) / volume) as f32;
    Particle { position: cell.position, radius: radius as f32, extinction }
}

#[test]
fn volumes_by_cells_are_nearer_than_by_spheres() {
    for samples in [20, 40] {
        let mut scene = Scene::load(&format!("cloud:samples={samples}"), 0.0).expect("built in");
        scene.meshes.clear();
        let points = space_points(&scene, 0, 1500);
        let light = |scene: &Scene| -> Vec<f64> {
            let casters = Casters::new(scene);
            points.iter().map(|p| casters.visibility(0, DVec3::from(p.map(f64::from)))).collect()
        };
        let expected = light(&scene);
        let cells = scene.casters();
        let towards = scene.lights[0].towards(DVec3::ZERO).as_vec3();
        let by_cells = |at: &[f32; 3]| {
            let depth = |cell: &Caster| {
                let z = cell::overlap((Vec3::from(*at), towards), cell);
                z.map_or(0.0, |z| f64::from(((z[1] - z[0].max(0.0)).max(0.0)) * cell.density))
            };
            (-cells.iter().map(depth).sum::<f64>()).exp()
        };
        let found: Vec<f64> = points.par_iter().map(by_cells).collect();
        let [mean, most] = error(&expected, found);
        println!("cloud:samples={samples}, {} casters of 32 bytes: cells {mean:.5}, at most {most:.4}", cells.len());
        // Spheres with the cell's volume, circumscribed spheres, which leave no gaps, and wider ones.
        for (name, wide) in [("of a cell's volume", 1.2407), ("about a cell", 3f64.sqrt()), ("twice as wide", 2.0)] {
            let particles: Vec<_> = cells.iter().map(|cell| sphere(cell, wide)).collect();
            let mass = |of: &dyn Fn(usize) -> f64| (0..cells.len()).map(of).sum::<f64>();
            let side = |i: usize| f64::from(cells[i].radius) * 2.0 / 3f64.sqrt();
            let boxes = mass(&|i| f64::from(cells[i].density) * side(i).powi(3));
            let balls = mass(&|i| {
                let Particle { radius, extinction, .. } = particles[i];
                f64::from(extinction) * 4.0 / 3.0 * std::f64::consts::PI * f64::from(radius).powi(3)
            });
            assert!((balls / boxes - 1.0).abs() < 1e-5, "{name}: {balls}, not {boxes}");
            let spheres = Scene { particles, volumes: Vec::new(), ..scene.clone() };
            let [of_spheres, most_of_spheres] = error(&expected, light(&spheres));
            println!("  spheres {name}: {of_spheres:.5}, at most {most_of_spheres:.4}");
            assert!(of_spheres > mean, "{name}: {of_spheres}, and cells {mean}");
        }
    }
}

/// Returns the shortest device time of a build of `text`, in milliseconds, and its mean error of light at `points`. Builds repeat for at
/// least half a second, because a GPU's clock takes a while to rise.
fn built_in(context: &Context, scene: &Scene, text: &str, points: &[[f32; 3]], expected: &[f64]) -> [f64; 2] {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = technique::open(context, &world, &spec(text)).expect("opened");
    let began = Instant::now();
    let goes_on = |count: &u32| *count < 10 || began.elapsed().as_secs_f64() < 0.5;
    let builds =
        (0..).take_while(goes_on).map(|_| opened.rebuild(&world).expect("built").device_ns.expect("timestamps"));
    let least = 1e-6 * builds.fold(f64::INFINITY, f64::min);
    [least, error(expected, ask(context, opened.technique.as_ref(), 0, points).into_iter().map(f64::from))[0]]
}

/// Compares cells and spheres of one field, finer and coarser, in a technique: which has less error in the same time.
#[test]
#[ignore = "measures"]
fn how_near_spheres_are_at_equal_time() {
    gpu_test("how_near_spheres_are_at_equal_time", |context| {
        let mut field = Scene::load("cloud:samples=64", 0.0).expect("built in");
        field.meshes.clear();
        let points = space_points(&field, 0, 8192);
        let casters = Casters::new(&field);
        let expected: Vec<f64> =
            points.par_iter().map(|p| casters.visibility(0, DVec3::from(p.map(f64::from)))).collect();
        for text in ["avsm:path=binned,size=256", "layers:layers=16,size=256", "density-grid:size=64"] {
            println!("{text}: casters, milliseconds and mean error by cells, and by spheres about a cell");
            let mut ways: [Vec<[f64; 2]>; 2] = Default::default();
            for side in [1, 2, 4, 8] {
                let volumes = field.volumes.iter().map(|volume| {
                    let placed = Placed { side, ..*volume.placed() };
                    Volume::new(Arc::new(volume.field().clone()), placed).expect("a volume")
                });
                let cells = Scene { volumes: volumes.collect(), ..field.clone() };
                let particles: Vec<_> = cells.casters().iter().map(|cell| sphere(cell, 3f64.sqrt())).collect();
                let spheres = Scene { particles, volumes: Vec::new(), ..field.clone() };
                let found = [&cells, &spheres].map(|scene| built_in(context, scene, text, &points, &expected));
                println!(
                    "  {:6} {:8.3} {:.5} {:8.3} {:.5}",
                    cells.cell_count(),
                    found[0][0],
                    found[0][1],
                    found[1][0],
                    found[1][1]
                );
                ways.iter_mut().zip(found).for_each(|(way, found)| way.push(found));
            }
            let [cells, spheres] = ways;
            for [time, error] in cells {
                // Interpolates between two of the spheres' builds, linearly in both logarithms.
                let pair = spheres.windows(2).find(|pair| (pair[1][0]..=pair[0][0]).contains(&time));
                let Some([fine, coarse]) = pair.map(|pair| [pair[0], pair[1]]) else { continue };
                let share = (time / coarse[0]).ln() / (fine[0] / coarse[0]).ln();
                let other = (coarse[1].ln() + share * (fine[1] / coarse[1]).ln()).exp();
                println!("  in {time:.3} ms: cells {error:.5}, spheres {other:.5}");
            }
        }
    });
}
