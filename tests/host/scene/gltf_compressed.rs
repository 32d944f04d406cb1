//! Compressed glTF files have the triangles of the file that they were made from, by the tools that people use (gltf_compressed/make.mjs):
//! gltfpack 1.3.0, gltf-transform 4.5.1 and gltf-pipeline 4.3.1.

use crate::scene::*;
use glam::DVec3;

/// The number of triangles of the sheet; those of the column come after.
const SHEET: usize = 2 * 12 * 8;

type Triangle = [DVec3; 3];

fn triangles(name: &str) -> Vec<Triangle> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/host/scene/gltf_compressed").join(name);
    let scene = load(&path).unwrap_or_else(|error| panic!("{error}"));
    let of = |mesh: &Mesh| {
        let corner = |index: u32| DVec3::from(mesh.positions[index as usize].map(f64::from));
        mesh.triangles.iter().map(|triangle| triangle.map(corner)).collect::<Vec<_>>()
    };
    scene.meshes.iter().flat_map(of).collect()
}

/// The closed form: a wavy sheet under a node, and a column between two joints that a morph target widens.
#[test]
fn the_plain_file_has_its_formulas() {
    let all = triangles("plain.glb");
    assert_eq!(all.len(), SHEET + 2 * 8 * 8);
    // A quarter turn about y takes (x, y, z) to (z, y, −x); twice as large and 1 higher.
    let sheet = |column: f64, row: f64| {
        let (u, v) = (column / 12.0, row / 8.0);
        DVec3::new(4.0 * v, 1.0 + 2.0 / 3.0 * (6.0 * u).sin() * (4.0 * v).cos(), -6.0 * u)
    };
    // A vertex moves by v with the upper joint, about (0, 2, 0) by a quarter turn about z.
    let column = |column: f64, row: f64| {
        let (u, v) = (column / 8.0 * std::f64::consts::TAU, row / 8.0);
        let at = DVec3::new((0.5 + v) * u.cos(), 4.0 * v, (0.5 + v) * u.sin());
        at.lerp(DVec3::new(-(at.y - 2.0), 2.0 + at.x, at.z), v)
    };
    let near = |found: &Triangle, expected: Triangle| {
        let off = found.iter().zip(expected).map(|(a, b)| (*a - b).length()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{found:?} for {expected:?}");
    };
    near(&all[0], [sheet(0.0, 0.0), sheet(1.0, 0.0), sheet(0.0, 1.0)]);
    near(&all[all.len() - 2], [column(7.0, 7.0), column(8.0, 7.0), column(7.0, 8.0)]);
}

/// Asserts that each triangle is in both files, with the same front. `step`: the largest difference of a coordinate; `weight`: that of a
/// weight of the column's joints, which moves by up to 6.
#[track_caller]
fn is_same(name: &str, expected: &[Triangle], step: f64, weight: f64) {
    let mut left = triangles(name);
    assert_eq!(left.len(), expected.len(), "{name}");
    for (number, triangle) in expected.iter().enumerate() {
        let apart = |other: &Triangle| {
            let turned = |by: usize| {
                let corners = (0..3).map(|i| (triangle[i] - other[(i + by) % 3]).abs().max_element());
                corners.fold(0.0, f64::max)
            };
            (0..3).map(turned).fold(f64::INFINITY, f64::min)
        };
        let nearest = left.iter().map(apart).enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b));
        let (place, nearest) = nearest.expect("a triangle");
        let most = if number < SHEET { step } else { step + 6.0 * weight };
        assert!(nearest <= most, "{name}: triangle {number} is {nearest:e} apart, of {most:e}");
        left.swap_remove(place);
    }
}

/// Two steps of 14 bits over the largest extent, 6, and half a step of the 8 bits of weights.
#[test]
fn meshopt_has_the_triangles() {
    let expected = triangles("plain.glb");
    let (step, weight) = (6.0 / 16383.0, 0.5 / 255.0);
    for name in [
        "pack_quantized.glb",
        "pack_c.glb",
        "pack_cc.glb",
        "pack_cz.glb",
        "pack_cc_exponential.glb",
        "pack_c_fallback.gltf",
        "transform_medium.glb",
        "transform_high.glb",
    ] {
        is_same(name, &expected, step, weight);
    }
    is_same("pack_cc_float.glb", &expected, 4e-6, weight);
}

/// Half a step of 14 bits over the largest extent, 6, and of the 12 bits of weights; or none at all.
#[test]
fn draco_has_the_triangles() {
    let expected = triangles("plain.glb");
    for name in ["draco_edgebreaker.glb", "draco_valence.glb"] {
        is_same(name, &expected, 3.0 / 16383.0 + 1e-6, 0.5 / 4095.0);
    }
    is_same("draco_pipeline.glb", &expected[..SHEET], 1e-6, 0.0);
}
