//! Triangles that touch a column but miss its centre: lost with coverage=middle, kept with coverage=conservative. Here the columns that a
//! triangle touches are found by separating axes, in f64.

use super::{Coverage, Cube, PLAIN, Settings, baked, cube, shapes, twin_columns};
use crate::support::gpu_test;
use glam::{DVec2, DVec3};
use gobo::gpu::Context;
use gobo::scene::{Mesh, Scene};

/// Error bound for the rounding of corners, in voxels, plus a margin.
const ROUNDED: f64 = 1.0 / 128.0;

/// Returns the triangles of meshes, in voxels.
fn triangles(meshes: &[Mesh], cube: &Cube) -> Vec<[DVec3; 3]> {
    let [origin, x, y, z] =
        [cube.origin, cube.axes[0], cube.axes[1], cube.axes[2]].map(|v| DVec3::from(v.map(f64::from)));
    let voxel = |position: [f32; 3]| {
        let offset = DVec3::from(position.map(f64::from)) - origin;
        DVec3::new(offset.dot(x), offset.dot(y), offset.dot(z))
    };
    meshes.iter().flat_map(|m| m.triangles.iter().map(move |t| t.map(|i| voxel(m.positions[i as usize])))).collect()
}

/// Returns whether a triangle overlaps a column's square, enlarged by `larger` on each side.
fn overlaps(triangle: &[DVec3; 3], column: DVec2, larger: f64) -> bool {
    let corners = triangle.map(DVec3::truncate);
    let (low, high) = (column - larger, column + 1.0 + larger);
    let square = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    let sides = [0, 1, 2].map(|i| (corners[(i + 1) % 3] - corners[i]).perp());
    [DVec2::X, DVec2::Y].into_iter().chain(sides).all(|axis| {
        let range = |all: &[DVec2]| {
            let along = all.iter().map(|v| v.dot(axis));
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        };
        let ([a_low, a_high], [b_low, b_high]) = (range(&corners), range(&square));
        a_low < b_high && b_low < a_high
    })
}

/// Returns the cube, and its columns with their ranges.
fn columns(context: &Context, scene: &Scene, coverage: Coverage) -> (Cube, Vec<(DVec2, [u32; 2])>) {
    let opened = baked(context, scene, Settings { coverage, ..PLAIN });
    let place = |(i, range)| (DVec2::new((i % 64) as f64, (i / 64) as f64), range);
    let columns = opened.technique.columns().expect("read").into_iter().enumerate().map(place).collect();
    (cube(&opened.technique.trees().expect("read")[0]), columns)
}

/// Wires thinner than a voxel: with `conservative`, all columns that a wire touches are shadowed behind it, and none farther than a column
/// away; with `middle` many are lost.
#[test]
fn a_wire_is_kept() {
    gpu_test("a_wire_is_kept", |context| {
        for plane in [false, true] {
            let scene = shapes::wires(plane);
            for coverage in [Coverage::Middle, Coverage::Conservative] {
                let (cube, columns) = columns(context, &scene, coverage);
                let wires = triangles(&scene.meshes[..2], &cube);
                let (mut kept, mut lost) = (0, 0);
                for (column, range) in columns {
                    let touching = wires.iter().filter(|wire| overlaps(wire, column, -ROUNDED));
                    let deepest = touching.flatten().map(|corner| corner.z).reduce(f64::max);
                    if let Some(deepest) = deepest {
                        // A surface up to a voxel behind the wire may be recorded instead, and its depth is rounded.
                        *(if f64::from(range[1]) <= deepest + 2.0 { &mut kept } else { &mut lost }) += 1;
                    }
                    let is_near = wires.iter().any(|wire| overlaps(wire, column, 1.0));
                    assert!(plane || is_near || range == [64; 2], "{coverage:?}: {column} is far, and {range:?}");
                }
                println!("{coverage:?}, plane {plane}: of columns that wires touch {kept} are shadowed, {lost} lost");
                assert!(kept > 10 && if coverage == Coverage::Middle { lost > 30 } else { lost == 0 }, "{coverage:?}");
            }
        }
    });
}

/// Conservative shadows begin and end no later than those of coverage=middle, and differ in many columns.
#[test]
fn conservative_shadows_are_more() {
    gpu_test("conservative_shadows_are_more", |context| {
        let mut more = 0;
        for scene in shapes::all() {
            let tree = baked(context, &scene, PLAIN).technique.trees().expect("read")[0];
            let [middle, conservative] = [Coverage::Middle, Coverage::Conservative]
                .map(|coverage| twin_columns(&scene, &tree, Settings { coverage, ..PLAIN }));
            for (a, b) in middle.iter().zip(&conservative) {
                assert!(b[0] <= a[0] && b[1] <= a[1], "{}: {b:?} where the middle is {a:?}", scene.name);
                more += usize::from(a != b);
            }
        }
        assert!(more > 500, "{more} columns differ");
    });
}
