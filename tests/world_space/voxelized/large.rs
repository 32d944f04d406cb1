//! Trees, graphs and columns of large cubes, compared at many voxels.

use super::{PLAIN, Structure, baked, shapes};
use crate::support::{self, ask, gpu_test, scenes::Random};
use glam::DVec3;
use gobo::technique::{TreeData, voxelized::Plan as Settings};

/// Returns the world position of a voxel's centre.
fn middle(tree: &TreeData, voxel: [u32; 3]) -> [f32; 3] {
    let axes = [tree.right, tree.up, tree.forward].map(|axis| DVec3::from(axis.map(f64::from)));
    let along = |i: usize| axes[i] / axes[i].length_squared() * (f64::from(voxel[i]) + 0.5);
    (DVec3::from(tree.origin.map(f64::from)) + along(0) + along(1) + along(2)).as_vec3().into()
}

/// A tree and a graph give the same look-ups at random voxels and at columns' entries and exits, in agreement with the columns: lit before
/// the entry, shadowed from the exit on. A full run tests 10^7 voxels.
#[test]
fn trees_graphs_and_columns_agree() {
    gpu_test("trees_graphs_and_columns_agree", |context| {
        let (size, count) = if support::all() { (4096, 10_000_000) } else { (512, 200_000) };
        for scene in support::some([shapes::houses(), shapes::soup()], 1) {
            for closed in support::some([true, false], 1) {
                let settings = Settings { size, closed, ..PLAIN };
                let dag = baked(context, &scene, settings);
                let svo = baked(context, &scene, Settings { structure: Structure::Svo, ..settings });
                let columns = dag.technique.columns().expect("read");
                assert_eq!(columns, svo.technique.columns().expect("read"), "{}: columns", scene.name);
                let tree = dag.technique.trees().expect("read")[0];
                let (mut random, mut left, mut at_edges) = (Random::new(5), count, 0);
                while left > 0 {
                    let voxels: Vec<[u32; 3]> = (0..left.min(1_000_000))
                        .map(|i| {
                            let [x, y, z] = [(); 3].map(|()| random.bits() % size);
                            let range = columns[(y * size + x) as usize];
                            // Half of the voxels are within one voxel of an entry or exit.
                            let edge = (range[i as usize / 2 % 2] + z % 3).saturating_sub(1).min(size - 1);
                            [x, y, if i % 2 == 0 { z } else { edge }]
                        })
                        .collect();
                    left -= voxels.len() as u32;
                    let points: Vec<_> = voxels.iter().map(|voxel| middle(&tree, *voxel)).collect();
                    let answers = ask(context, dag.technique.as_ref(), 0, &points);
                    assert!(answers == ask(context, svo.technique.as_ref(), 0, &points), "{}: dag and svo", scene.name);
                    for ([x, y, z], answer) in voxels.into_iter().zip(answers) {
                        let [entry, exit] = columns[(y * size + x) as usize];
                        let allowed = if z < entry { 1.0..=1.0 } else { 0.0..=if z < exit { 1.0 } else { 0.0 } };
                        assert!(allowed.contains(&answer), "{}: {x} {y} {z}, {entry} to {exit}: {answer}", scene.name);
                        at_edges += u32::from(entry < size && z.abs_diff(entry) < 2);
                    }
                }
                assert!(at_edges > count / 20, "{}: {at_edges} voxels at an entry", scene.name);
            }
        }
    });
}
