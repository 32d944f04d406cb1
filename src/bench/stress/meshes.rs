//! Cases of opaque triangles: their shapes, their positions in voxels and texels, and lights near them.

use super::StressCase;
use super::scene_builders::{SLANTED, along, random, scene};
use crate::scene::{Alpha, AlphaMode, AlphaTexture, LightKind, Mesh, Scene, Wrap};
use glam::DVec3;
use std::sync::Arc;

fn mesh(positions: impl IntoIterator<Item = DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let positions = positions.into_iter().map(|p| p.as_vec3().into()).collect();
    Mesh { name: "stress".into(), positions, triangles, albedo: [0.6; 3], solid: false, alpha: None }
}

/// Returns a horizontal square at height `z`, with half-extent `half`.
pub(super) fn plate(z: f64, half: f64) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    mesh(corners.map(|[x, y]| DVec3::new(x * half, y * half, z)), vec![[0, 1, 2], [0, 2, 3]])
}

/// Corner indices of each side of a box, counter-clockwise seen from outside; bit 0 of an index is x, bit 1 y, bit 2 z.
const SIDES: [[u32; 4]; 6] = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];

/// Returns a closed box with the corners `low` and `high`.
pub(super) fn block(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: u32| DVec3::select(glam::BVec3::new(i & 1 == 1, i & 2 == 2, i & 4 == 4), high, low);
    let triangles = SIDES.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    mesh((0..8).map(corner), triangles)
}

/// Returns the box that cases vary.
fn usual_block() -> Mesh {
    block(DVec3::new(-0.43, -0.37, 0.21), DVec3::new(0.41, 0.33, 0.83))
}

/// Returns meshes over a ground plane, under slanted light.
fn over_ground(meshes: Vec<Mesh>) -> Scene {
    scene(along(SLANTED), vec![], [vec![plate(0.0, 1.5)], meshes].concat())
}

/// Returns the usual box over a ground plane, under a light of this kind.
fn lit_by(kind: LightKind) -> Scene {
    scene(kind, vec![], vec![plate(0.0, 1.5), usual_block()])
}

/// Returns a mesh of `count` triangles; `corners` returns the corners of each.
pub(super) fn triangles(count: usize, corners: impl FnMut(usize) -> [DVec3; 3]) -> Mesh {
    let positions: Vec<DVec3> = (0..count).flat_map(corners).collect();
    mesh(positions, (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Returns a card cut out by a texture of `side` × `side` texels, every other of which is a hole.
fn card(at: DVec3, right: DVec3, up: DVec3, side: u32) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let chequer = |i: u32| if (i % side + i / side).is_multiple_of(2) { 255 } else { 0 };
    let texture = AlphaTexture {
        size: [side; 2],
        wrap: [Wrap::Repeat, Wrap::Mirror],
        texels: (0..side * side).map(chequer).collect(),
    };
    let alpha = Alpha {
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        texture: Some(Arc::new(texture)),
        ..Alpha::constant(AlphaMode::Cut(0.5), 1.0, 4)
    };
    let card = mesh(corners.map(|[x, y]| at + x * right + y * up), vec![[0, 1, 2], [0, 2, 3]]);
    Mesh { alpha: Some(alpha), ..card }
}

/// The cases of meshes.
pub(super) const CASES: &[StressCase] = &[
    StressCase {
        name: "slivers",
        about: "triangles long and thin, over a ground",
        swept: "length over width",
        values: &[1e1, 1e2, 1e4, 1e6, 1e9],
        scene: |aspect| {
            let mut random = random(40);
            let sliver = triangles(24, |_| {
                let (at, way) = (random.in_ball() * 0.5 + DVec3::Z, random.in_ball().normalize_or(DVec3::X));
                [at, at + way, at + way * 0.5 + way.any_orthonormal_vector() / aspect]
            });
            over_ground(vec![sliver])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "no-area",
        about: "a box, and triangles of no area about it: points and lines",
        swept: "how many",
        values: &[0.0, 1.0, 10.0, 1000.0],
        scene: |count| {
            let mut random = random(41);
            let flat = triangles(count as usize, |i| {
                let (at, way) = (random.in_ball() + DVec3::Z, random.in_ball());
                if i % 2 == 0 { [at; 3] } else { [at, at + way, at + way * 0.5] }
            });
            over_ground(vec![usual_block(), flat])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "coplanar",
        about: "two plates, one as good as in the other, over a ground",
        swept: "how far apart, units",
        values: &[1e-1, 1e-3, 1e-5, 1e-7, 0.0],
        scene: |apart| over_ground(vec![plate(0.6, 0.5), plate(0.6 + apart, 0.5)]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "duplicated",
        about: "the same plate many times",
        swept: "how many times",
        values: &[1.0, 2.0, 16.0, 128.0],
        scene: |count| over_ground(vec![plate(0.6, 0.5); count as usize]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "sides",
        about: "a box that is closed, inside out, open, and both of two turned in one",
        swept: "which: 0, 1, 2, 3",
        values: &[0.0, 1.0, 2.0, 3.0],
        scene: |which| {
            let (mut changed, plain) = (usual_block(), usual_block());
            if which == 1.0 || which == 3.0 {
                changed.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            } else if which == 2.0 {
                changed.triangles.truncate(9);
            }
            over_ground(if which == 3.0 { vec![changed, plain] } else { vec![changed] })
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "world-large",
        about: "a box on a ground as large as a world",
        swept: "half the ground's side, units",
        values: &[1.5, 15.0, 150.0, 1e4, 1e6],
        scene: |half| scene(along(SLANTED), vec![], vec![plate(0.0, half), usual_block()]),
        ..StressCase::USUAL
    },
    StressCase {
        name: "small-triangles",
        about: "a thousand triangles over a ground, at last smaller than any voxel and any texel",
        swept: "their size, units",
        values: &[1e-1, 1e-2, 1e-4, 1e-6, 1e-9],
        scene: |size| {
            let mut random = random(42);
            let dust = triangles(1000, |_| {
                let at = 0.5 * random.in_ball() + DVec3::Z * 0.8;
                [at, at + random.in_ball() * size, at + random.in_ball() * size]
            });
            over_ground(vec![dust])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "holes",
        about: "cards over a ground, cut out by a texture of chequers",
        swept: "texels per side",
        values: &[1.0, 2.0, 16.0, 300.0],
        scene: |side| {
            let mut random = random(43);
            let cards = (0..12).map(|_| {
                let (at, way) = (0.6 * random.in_ball() + DVec3::Z * 0.8, random.in_ball().normalize_or(DVec3::X));
                card(at, 0.5 * way, 0.4 * way.any_orthonormal_vector(), side as u32)
            });
            over_ground(cards.collect())
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "on-voxels",
        about: "boxes whose sides lie on the boundaries of voxels and texels, in a box that makes these so",
        swept: "how far off them, units",
        values: &[1e-2, 1e-4, 1e-6, 1e-8, 0.0],
        scene: |off| {
            let inner = block(DVec3::splat(-0.25 + off), DVec3::splat(0.25 + off));
            let edge = plate(-1.0, 1.0);
            let top = block(DVec3::splat(0.9375), DVec3::ONE);
            scene(along(DVec3::new(0.5, 0.25, -1.0)), vec![], vec![edge, inner, top])
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "grazing",
        about: "light that grazes the ground that a box stands on",
        swept: "degrees above it",
        values: &[45.0, 10.0, 1.0, 0.1, 1e-3, 0.0],
        scene: |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            lit_by(along(DVec3::new(cosine * 0.8, cosine * 0.6, -sine)))
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "light-at-surface",
        about: "a point light that comes down to a box, lies on it and is inside",
        swept: "how far above it, units",
        values: &[1.0, 1e-1, 1e-3, 1e-6, 0.0, -1e-6, -0.3],
        scene: |above| lit_by(LightKind::Point { position: DVec3::new(0.07, 0.03, 0.83 + above) }),
        ..StressCase::USUAL
    },
    StressCase {
        name: "vpl",
        about: "a virtual light on a ground, on the edge of a box and in its corner",
        swept: "how far from the corner, units",
        values: &[0.5, 1e-1, 1e-2, 1e-4, 1e-6, 0.0],
        scene: |away| {
            let position = DVec3::new(-0.43 - away, -0.37 - away * 0.5, 0.83);
            let normal = DVec3::new(-0.4, -0.3, -0.8).normalize();
            lit_by(LightKind::Virtual { position, normal, nearest: 0.05 })
        },
        ..StressCase::USUAL
    },
    StressCase {
        name: "one-node",
        about: "one triangle, and nothing that it shadows but itself",
        swept: "its size, units",
        values: &[1.0, 1e-3, 1e-6, 1e3],
        scene: |size| {
            scene(along(SLANTED), vec![], vec![triangles(1, |_| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p * size))])
        },
        ..StressCase::USUAL
    },
];
