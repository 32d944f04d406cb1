//! Triangles with holes: voxels and cells equal their twins, and none is missing where a triangle blocks light.

use super::{PLAIN, Settings, built, place};
use crate::support::{gpu_test, scenes, scenes::Random};
use glam::{DVec3, Vec3};
use gobo::reference::truth::Meshes;
use gobo::reference::twin::alpha::{TriangleAlpha, triangles};
use gobo::reference::twin::grid::{Bits, Place};
use gobo::reference::twin::masks::Masks;
use gobo::scene::Scene;

type Corners = [[f32; 3]; 3];

fn all(scene: &Scene) -> Vec<(Corners, Option<TriangleAlpha>)> {
    scene.meshes.iter().flat_map(triangles).collect()
}

/// Returns whether each triangle may block light in each voxel, or in each cell of which a voxel has `cells` a side.
fn blocks<'a>(
    triangles: &'a [(Corners, Option<TriangleAlpha>)],
    place: &'a Place,
    cells: f32,
) -> impl Fn(usize, [u32; 3]) -> bool + 'a {
    move |number, voxel| {
        let (corners, alpha) = &triangles[number];
        let corners = corners.map(|corner| cells * Vec3::from(place.voxels(corner)));
        let low = Vec3::from(voxel.map(|v| v as f32));
        alpha.as_ref().is_none_or(|alpha| alpha.covers(corners, low, 1.0))
    }
}

fn twins(scene: &Scene, place: &Place) -> (Bits, Masks) {
    let triangles = all(scene);
    let among = || triangles.iter().map(|(corners, _)| corners.map(|corner| place.voxels(corner)));
    let bits = Bits::voxelize_where(among(), place.size, blocks(&triangles, place, 1.0));
    let masks = Masks::new_where(&bits, among(), place.size, blocks(&triangles, place, 4.0));
    (bits, masks)
}

#[test]
fn voxels_with_holes_equal_their_twin() {
    gpu_test("voxels_with_holes_equal_their_twin", |context| {
        for seed in 1..3 {
            let scene = scenes::cards(seed);
            for size in [64, 128] {
                let (_, opened) = built(context, &scene, Settings { size, masks: true, ..PLAIN });
                let (bits, masks) = twins(&scene, &place(&opened.technique));
                let grid = opened.technique.grid();
                assert!(grid.bits().expect("read") == bits.words, "voxels, seed {seed}, size {size}");
                assert!(grid.masks().expect("read") == masks.words, "cells, seed {seed}, size {size}");
                // Holes are left out: whole cards have more voxels.
                let mut whole = scene.clone();
                whole.meshes.iter_mut().for_each(|mesh| mesh.alpha = None);
                let count = |bits: &[u64]| bits.iter().map(|word| word.count_ones()).sum::<u32>();
                let (_, full) = built(context, &whole, Settings { size, ..PLAIN });
                let (held, full) = (count(&bits.words), count(&full.technique.grid().bits().expect("read")));
                println!("size {size}: {held} of {full} voxels");
                assert!(held < full - full / 8, "size {size}: {held} of {full} voxels");
            }
        }
    });
}

/// Every voxel and every cell in which the truth finds a point that blocks light is occupied.
#[test]
fn nothing_that_blocks_is_missed() {
    gpu_test("nothing_that_blocks_is_missed", |context| {
        let scene = scenes::cards(5);
        let (_, opened) = built(context, &scene, Settings { size: 128, masks: true, ..PLAIN });
        let at = place(&opened.technique);
        let (bits, masks) = twins(&scene, &at);
        let mut random = Random::new(3);
        let (mut blocking, mut free) = (0, 0);
        for mesh in &scene.meshes {
            let alone = Meshes::new(std::slice::from_ref(mesh));
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
                let normal = (b - a).cross(c - a).normalize();
                for _ in 0..400 {
                    let [mut u, mut v] = [(); 2].map(|()| f64::from(random.bits() % 1000) / 999.0);
                    if u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let point = a + u * (b - a) + v * (c - a);
                    if alone.free(point - 0.01 * normal, normal, 0.02) {
                        free += 1;
                        continue;
                    }
                    blocking += 1;
                    let voxels = at.voxels(point.as_vec3().to_array());
                    let voxel = voxels.map(|v| v as u32);
                    assert!(bits.has(0, voxel), "{}: {point} in {voxel:?}", mesh.name);
                    let cell = voxels.map(|v| (4.0 * v) as u32);
                    assert!(masks.has(cell), "{}: {point} in cell {cell:?}", mesh.name);
                }
            }
        }
        assert!(blocking > 5000 && free > 5000, "{blocking} {free}");
    });
}
