//! What cells of a field are worth: as many spheres of as many bytes and as much in each, one per cell that is not empty, against the
//! field's own truth. docs/notebook/volumes.md has the figures, of `cargo test --release --test volumes spheres -- --nocapture`.

use glam::{DVec3, Vec3};
use gobo::reference::truth::{Casters, space_points};
use gobo::reference::twin::cell;
use gobo::scene::{Caster, Particle, Scene};
use rayon::prelude::*;

/// Mean and greatest error of light at points in space.
fn error(expected: &[f64], found: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let apart = |(a, b): (&f64, f64)| (a - b).abs();
    let all: Vec<f64> = expected.iter().zip(found).map(apart).collect();
    [all.iter().sum::<f64>() / all.len() as f64, all.into_iter().fold(0.0, f64::max)]
}

/// A sphere that takes as much as the cell does, `wide` times as wide as the cell's sides.
fn sphere(cell: &Caster, wide: f64) -> Particle {
    // The cells of `cloud` are cubes, of which the radius is half the diagonal.
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
        // As large as the cell; and about it, so that spheres leave nothing free.
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
