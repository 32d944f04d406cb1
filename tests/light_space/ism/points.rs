//! Points on the meshes.

use crate::ism::{built, scenes};
use crate::support::gpu_test;
use crate::support::scenes::{cards, cuboid};
use glam::DVec3;
use gobo::reference::truth::Meshes;
use gobo::reference::twin::ism::points::{SUBSETS, area, point, sums, unpack_normal};
use gobo::scene::{Mesh, Scene, sides};
use gobo::technique::{PointData, PointsData};

pub fn triangles(scene: &Scene) -> Vec<[[f32; 3]; 3]> {
    let of = |mesh: &Mesh| mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect::<Vec<_>>();
    scene.meshes.iter().flat_map(of).collect()
}

fn signs(scene: &Scene) -> Vec<i32> {
    scene.meshes.iter().flat_map(|mesh| sides(mesh).into_iter().map(|side| side.sign())).collect()
}

/// All values of the points equal their twin's up to rounding, and so does each position, unless the rounding of an area moved the point to
/// the next triangle. The normal is the triangle's, outwards for closed meshes.
#[test]
fn points_equal_their_twin() {
    gpu_test("ism::points_equal_their_twin", |context| {
        for scene in [scenes::soup(), scenes::room()] {
            for points in [1024, 4096] {
                let ism = built(context, &scene, &format!("ism:points={points},size=32,adaptive=off"));
                let (head, pool) = ism.points().expect("the points");
                let (triangles, signs) = (triangles(&scene), signs(&scene));
                let areas: Vec<_> = triangles.iter().map(|t| area(*t)).collect();
                let all: f32 = areas.iter().sum();
                assert!((head.area / all - 1.0).abs() < 1e-5, "{head:?}, not {all}");
                let radius = 1.25 * (all / points as f32 / std::f32::consts::PI).sqrt();
                assert!((head.radius - radius).abs() < 1e-4 * radius, "{head:?}");
                let sums = sums(&areas, head.scale);
                assert!(head.total.abs_diff(*sums.last().expect("triangles")) < head.total >> 16, "{head:?}");
                let mut moved = 0;
                for (i, got) in (0..).zip(&pool) {
                    let (triangle, position) = point(&triangles, &sums, i, points).expect("there is area");
                    let off = DVec3::from(got.position.map(f64::from)).distance(position.map(f64::from).into());
                    if off > 1e-5 {
                        moved += 1;
                        continue;
                    }
                    let (normal, closed) = unpack_normal(got.normal);
                    assert_eq!(closed, signs[triangle] != 0, "point {i}");
                    let [a, b, c] = triangles[triangle].map(|p| DVec3::from(p.map(f64::from)));
                    let wanted =
                        (b - a).cross(c - a).normalize_or_zero() * if signs[triangle] < 0 { -1.0 } else { 1.0 };
                    let cosine = DVec3::from(normal.map(f64::from)).dot(wanted);
                    assert!(cosine > 1.0 - 1e-7, "point {i}: {normal:?}, not {wanted}");
                }
                assert!(moved * 500 < pool.len(), "{moved} of {} points stand elsewhere", pool.len());
            }
        }
    });
}

/// In each subset, a triangle's number of points is proportional to its area, up to the strata at either end of the triangle's range.
/// Points on a large triangle are spread over it: each quarter has a quarter of them.
#[test]
fn points_are_spread_by_area() {
    gpu_test("ism::points_are_spread_by_area", |context| {
        let wide = cuboid([-2.0, -2.0, 0.0], [2.0, 2.0, 0.01]);
        let small = cuboid([3.0, 3.0, 3.0], [3.5, 3.5, 3.5]);
        let scene = scenes::under("two", vec![wide, small], scenes::lights(1));
        let points = 4096;
        let (head, pool): (PointsData, Vec<PointData>) =
            built(context, &scene, &format!("ism:points={points},size=32,adaptive=off")).points().expect("the points");
        let share = 6.0 * 0.25 / f64::from(head.area);
        for subset in pool.chunks_exact(points) {
            let of_small = subset.iter().filter(|p| p.position[2] > 1.0).count() as f64;
            assert!((of_small - share * points as f64).abs() <= 2.0, "{of_small}, not {}", share * points as f64);
            let top: Vec<_> = subset.iter().filter(|p| p.position[2] > 0.009 && p.position[2] < 1.0).collect();
            for quarter in 0..4 {
                let side = |v: f32, i: u32| (v > 0.0) == (quarter >> i & 1 == 1);
                let here = top.iter().filter(|p| side(p.position[0], 0) && side(p.position[1], 1)).count() as f64;
                let expected = top.len() as f64 / 4.0;
                // The tolerance is below the standard deviation of independent points (22), because these points form a lattice.
                assert!((here - expected).abs() < 12.0, "{here} of {} in quarter {quarter}", top.len());
            }
        }
        assert_eq!(pool.len(), SUBSETS as usize * points);
    });
}

/// A point keeps its place on its triangle while the meshes move.
#[test]
fn points_move_with_their_triangles() {
    gpu_test("ism::points_move_with_their_triangles", |context| {
        let scene = scenes::soup();
        let mut moved = scene.clone();
        // Scales by two, which is exact in floats: areas keep exactly their shares.
        for position in moved.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
            *position = position.map(|v| 2.0 * v);
        }
        for text in ["ism:points=1024,size=32,adaptive=off", "ism:points=1024,size=32,adaptive=on"] {
            let both = [&scene, &moved].map(|scene| built(context, scene, text).points().expect("them").1);
            for (a, b) in both[0].iter().zip(&both[1]) {
                assert_eq!(a.position.map(|v| 2.0 * v), b.position);
            }
        }
    });
}

/// A point in a hole is NaN, and no other is: each agrees with the truth at the place of its twin.
#[test]
fn points_in_holes_are_left_out() {
    gpu_test("ism::points_in_holes_are_left_out", |context| {
        let meshes = cards(7).meshes;
        let scene = scenes::under("cards", meshes, scenes::lights(1));
        let alone: Vec<_> = scene.meshes.iter().map(|mesh| Meshes::new(std::slice::from_ref(mesh))).collect();
        let owners: Vec<usize> =
            scene.meshes.iter().enumerate().flat_map(|(i, mesh)| mesh.triangles.iter().map(move |_| i)).collect();
        let points = 4096;
        let ism = built(context, &scene, &format!("ism:points={points},size=32,adaptive=off"));
        let (head, pool) = ism.points().expect("the points");
        let triangles = triangles(&scene);
        let areas: Vec<_> = triangles.iter().map(|t| area(*t)).collect();
        let sums = sums(&areas, head.scale);
        let (mut holes, mut apart) = (0, 0);
        for (i, got) in (0..).zip(&pool) {
            let (triangle, position) = point(&triangles, &sums, i, points).expect("there is area");
            let [a, b, c] = triangles[triangle].map(|p| DVec3::from(p.map(f64::from)));
            let normal = (b - a).cross(c - a).normalize();
            let position = DVec3::from(position.map(f64::from));
            let is_hole = alone[owners[triangle]].free(position - 0.01 * normal, normal, 0.02);
            holes += usize::from(is_hole);
            apart += usize::from(is_hole != got.position[0].is_nan());
        }
        println!("{holes} of {} points are in holes, {apart} are apart", pool.len());
        assert!(holes > pool.len() / 10 && holes < pool.len() * 9 / 10, "{holes} of {}", pool.len());
        // Rounding puts a few points beyond a cut, or on the next triangle.
        assert!(apart * 300 < pool.len(), "{apart} of {}", pool.len());
    });
}
