//! Splats in voxels: the device's against the twin's, in any order, and techniques that march them against error functions.

use super::{PLAIN, Settings, built};
use crate::support::{self, ask, gpu_test, scenes, scenes::Random};
use glam::DVec3;
use gobo::reference::truth::Casters;
use gobo::reference::twin::media::{Media, UNITS};
use gobo::scene::{Scene, Splat};
use gobo::technique::Technique;

/// The splats of all techniques' tests, plus discs, needles and balls, from less than a voxel to a third of the grid.
fn all_sizes() -> Scene {
    let mut scene = scenes::splats();
    let mut random = Random::new(87);
    for i in 0..150 {
        let long = 10f32.powf(random.between(-3.0, -1.0));
        let deviations = [[1.0, 1.0, 0.01], [1.0, 0.05, 0.03], [1.0, 0.9, 0.8]][i % 3].map(|d| d * long);
        let turn = [0; 4].map(|_| random.between(0.1, 1.0));
        let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
        let rotation = turn.map(|x| x / length);
        let (position, opacity) = (random.point(-0.8, 0.8), [0.01, 0.5, 0.99, 1.0][i % 4]);
        scene.splats.push(Splat { position, deviations, rotation, opacity, color: [0.5; 3] });
    }
    scene
}

/// The voxels equal the twin's up to the device's rounding of shapes, with the same bytes in any order.
#[test]
fn splats_fill_voxels_as_their_twin() {
    gpu_test("splats_fill_voxels_as_their_twin", |context| {
        let scene = all_sizes();
        let mut turned = scene.clone();
        turned.splats.reverse();
        let [(voxels, place), (again, _)] = [&scene, &turned].map(|scene| {
            let (_, opened, place) = built(context, scene, PLAIN);
            (opened.technique.grid().media().expect("read").expect("there are splats"), place)
        });
        assert!(voxels == again, "the order of splats changes bytes");
        let twin = Media::deposit(&scene.casters(), &place);
        let of = |of: &u32| f64::from(*of) / f64::from(UNITS);
        let sum: f64 = twin.voxels.iter().map(of).sum();
        let apart = |(a, b): (&u32, &u32)| f64::from(a.abs_diff(*b)) / f64::from(UNITS);
        let off: Vec<f64> = voxels.0.iter().zip(&twin.voxels).map(apart).collect();
        // If the device rounds differently, what a splat adds at a voxel's face may go to the neighbouring voxel.
        let (sum_off, moved) = (off.iter().sum::<f64>(), off.iter().filter(|off| **off > 1e-3).count());
        println!("of {sum} {sum_off} are elsewhere, {moved} voxels differ");
        assert!(sum > 100.0 && sum_off < 1e-3 * sum && moved < 40, "{sum}, off by {sum_off}, in {moved} voxels");
    });
}

/// Look-ups are close to the truth, and finer grids come nearer to `grid-query`, which cuts the same splats off at three deviations. Opaque
/// splats are excluded, because their truth has no such cut-off.
#[test]
fn splats_are_near_the_error_functions() {
    gpu_test("splats_are_near_the_error_functions", |context| {
        let mut scene = scenes::splats();
        scene.splats.retain(|splat| splat.opacity < 1.0);
        let truth = Casters::new(&scene);
        let mut random = Random::new(88);
        let points: Vec<_> = (0..2000).map(|_| random.point(-1.0, 1.0)).collect();
        let exact: Vec<f64> = points.iter().map(|p| truth.visibility(0, DVec3::from(p.map(f64::from)))).collect();
        let found = |technique: &dyn Technique| -> Vec<f64> {
            ask(context, technique, 0, &points).into_iter().map(f64::from).collect()
        };
        let apart =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / points.len() as f64;
        let ended = found(support::built(context, &scene, "grid-query:size=64").as_ref());
        let answers = [64, 128].map(|size| {
            let (_, opened, _) = built(context, &scene, Settings { size, ..PLAIN });
            found(opened.technique.as_ref())
        });
        let errors = answers.each_ref().map(|answers| apart(answers, &exact));
        let from_ended = answers.each_ref().map(|answers| apart(answers, &ended));
        println!("at 64 and 128: {errors:?}, {from_ended:?} from grid-query, itself {}", apart(&ended, &exact));
        assert!(errors.iter().all(|error| *error < 0.02), "{errors:?}");
        assert!(from_ended[1] < from_ended[0], "{from_ended:?}");
    });
}
