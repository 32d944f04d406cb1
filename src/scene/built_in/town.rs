//! The built-in scene `town`: a million triangles, nearly all of them small.

use crate::scene::built_in::emitters::direction;
use crate::scene::built_in::town_house::{House, Materials, house};
use crate::scene::built_in::town_shapes::{Place, beam, block, empty, leaf, tube};
use crate::scene::model::random::Random;
use crate::scene::model::time::wave;
use crate::scene::{Camera, Light, LightKind, Mesh, Scene};
use glam::{DVec2, DVec3};

/// Number of blocks of houses per side.
const BLOCKS: u32 = 8;

/// Distance between neighbouring blocks.
const BLOCK_WORLD: f64 = 25.0;

/// Width of a street between blocks.
const STREET_WORLD: f64 = 4.0;

/// Number of lots per block, along x and y.
const LOTS: [u32; 2] = [2, 3];

/// How far the ground extends beyond the outer streets.
const BORDER_WORLD: f64 = 2.0;

/// Number of ground squares per block, along x and y.
const SQUARES: u32 = 40;

/// One in this many blocks is a park.
const PARK: u32 = 11;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x7036, 11];

/// Builds the scene. The result is bit-identical on every call and machine.
pub(in crate::scene) fn town() -> Scene {
    of_blocks(BLOCKS)
}

/// The meshes of the town while they are built.
struct Town {
    random: Random,
    walls: [Mesh; 3],
    roofs: [Mesh; 2],
    frames: Mesh,
    glass: Mesh,
    fences: Mesh,
    wood: Mesh,
    leaves: [Mesh; 3],
    wires: Mesh,
}

/// Builds a town with `blocks` blocks per side.
fn of_blocks(blocks: u32) -> Scene {
    let mut town = Town {
        random: Random::new(SEED),
        walls: [("walls", [0.82, 0.78, 0.7]), ("plaster", [0.75, 0.58, 0.42]), ("brick", [0.55, 0.3, 0.24])]
            .map(|(name, albedo)| empty(name, albedo)),
        roofs: [("tiles", [0.5, 0.2, 0.14]), ("slate", [0.24, 0.25, 0.28])].map(|(name, albedo)| empty(name, albedo)),
        frames: empty("frames", [0.9, 0.9, 0.88]),
        glass: empty("glass", [0.1, 0.13, 0.16]),
        fences: empty("fences", [0.72, 0.66, 0.56]),
        wood: empty("wood", [0.33, 0.25, 0.18]),
        leaves: [[0.22, 0.4, 0.12], [0.32, 0.44, 0.14], [0.16, 0.32, 0.14]].map(|albedo| empty("leaves", albedo)),
        wires: empty("wires", [0.08; 3]),
    };
    for block in 0..blocks * blocks {
        let corner = BLOCK_WORLD * DVec2::new(f64::from(block % blocks), f64::from(block / blocks));
        town.block(corner + 0.5 * STREET_WORLD, block % PARK == PARK / 2);
    }
    for street in 0..=blocks {
        town.line(BLOCK_WORLD * f64::from(street), blocks);
    }
    let Town { walls, roofs, frames, glass, fences, wood, leaves, wires, .. } = town;
    let singles = [ground(blocks), frames, glass, fences, wood, wires];
    Scene {
        name: "town".into(),
        meshes: singles.into_iter().chain(walls).chain(roofs).chain(leaves).collect(),
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.4, 0.35, -0.8).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(128.0, -26.0, 22.0),
            target: DVec3::new(87.0, 48.0, 0.0),
            up: DVec3::Z,
            fov_y_degrees: 45.0,
        },
        ..Scene::default()
    }
}

/// Returns the height of the ground.
fn height(at: DVec2) -> f64 {
    let hill = |across: [f64; 2], phase: f64| wave(at.dot(DVec2::from(across)) + phase);
    2.4 * hill([0.0061, 0.0024], 0.1) + 1.3 * hill([-0.0042, 0.0093], 0.6) + 0.12 * hill([0.041, 0.033], 0.3)
}

/// Builds hilly ground under `blocks` blocks per side. It is solid, so it is seen only from above.
fn ground(blocks: u32) -> Mesh {
    let squares = SQUARES * blocks;
    let place = |i: u32| {
        let share = f64::from(i) / f64::from(squares);
        share * (BLOCK_WORLD * f64::from(blocks) + 2.0 * BORDER_WORLD) - BORDER_WORLD
    };
    let mut ground = empty("ground", [0.38, 0.42, 0.28]);
    for i in 0..(squares + 1) * (squares + 1) {
        let at = DVec2::new(place(i % (squares + 1)), place(i / (squares + 1)));
        ground.positions.push(at.extend(height(at)).as_vec3().to_array());
    }
    for i in 0..squares * squares {
        let a = i / squares * (squares + 1) + i % squares;
        let [b, c, d] = [a + 1, a + squares + 2, a + squares + 1];
        ground.triangles.extend([[a, b, c], [a, c, d]]);
    }
    ground.solid = true;
    ground
}

impl Town {
    /// Adds a block of lots or a park, starting at its lowest corner.
    fn block(&mut self, corner: DVec2, is_park: bool) {
        let size = BLOCK_WORLD - STREET_WORLD;
        if is_park {
            for i in 0..36 {
                let jitter = DVec2::new(self.random.between(-1.0, 1.0), self.random.between(-1.0, 1.0));
                let middle = DVec2::new(f64::from(i % 6) + 0.5, f64::from(i / 6) + 0.5) * (size / 6.0);
                self.tree(corner + middle + jitter);
            }
            let around = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
            return self.fence(&around.map(|share| corner + size * DVec2::from(share)));
        }
        let lot = DVec2::new(size / f64::from(LOTS[0]), size / f64::from(LOTS[1]));
        for i in 0..LOTS[0] * LOTS[1] {
            let low = corner + lot * DVec2::new(f64::from(i % LOTS[0]), f64::from(i / LOTS[0]));
            self.lot(low, lot);
        }
    }

    /// Adds a house in its garden.
    fn lot(&mut self, low: DVec2, size: DVec2) {
        let jitter = DVec2::new(self.random.between(-0.6, 0.6), self.random.between(-0.3, 0.1));
        let middle = low + 0.5 * size + jitter;
        let turn = DVec2::new(1.0, self.random.between(-0.08, 0.08)).normalize();
        let along = if self.random.chance(0.5) { turn } else { -turn };
        let half_width = self.random.between(1.6, 2.0);
        let measures = House {
            half_length: self.random.between(2.4, 3.2),
            half_width,
            storeys: if self.random.chance(0.45) { 2 } else { 1 },
            rise: half_width * self.random.between(0.75, 1.15),
            wing: if self.random.chance(0.5) { Some(self.random.between(1.0, 1.3)) } else { None },
        };
        let [wall, roof] = [3, 2].map(|kinds| self.random.between(0.0, f64::from(kinds) - 0.001) as usize);
        let place = Place { origin: middle.extend(height(middle) + 0.15), along };
        let Self { walls, roofs, frames, glass, .. } = self;
        house(&mut Materials { walls: &mut walls[wall], roofs: &mut roofs[roof], frames, glass }, &place, &measures);
        for [x, y] in [[0.07, 0.14], [0.93, 0.86], [0.07, 0.86], [0.93, 0.14]] {
            if self.random.chance(0.4) {
                let jitter = DVec2::new(self.random.between(-0.4, 0.4), self.random.between(-0.4, 0.4));
                self.tree(low + size * DVec2::new(x, y) + jitter);
            }
        }
        if self.random.chance(0.6) {
            // The fence runs along all four sides, slightly inside the lot. On the side of lowest y it has a gap, from 35 % to 98 % of the
            // lot's width.
            let corners = [[0.98, 0.02], [0.98, 0.98], [0.02, 0.98], [0.02, 0.02], [0.35, 0.02]];
            self.fence(&corners.map(|share| low + size * DVec2::from(share)));
        }
    }

    /// Adds posts with two rails between them, along a line over the ground.
    fn fence(&mut self, corners: &[DVec2]) {
        let on_ground = |at: DVec2, above: f64| at.extend(height(at) + above);
        for pair in corners.windows(2) {
            let spans = ((pair[1] - pair[0]).length() / 1.6).ceil();
            let place = |i: f64| pair[0] + (pair[1] - pair[0]) * (i / spans);
            for i in 0..spans as u32 {
                let ends = [place(f64::from(i)), place(f64::from(i) + 1.0)];
                self.post(ends[0]);
                for above in [0.35, 0.85] {
                    beam(&mut self.fences, ends.map(|end| on_ground(end, above)), 0.025, 0.06);
                }
            }
        }
        if let Some(last) = corners.last().filter(|last| **last != corners[0]) {
            self.post(*last);
        }
    }

    /// Adds a fence post.
    fn post(&mut self, at: DVec2) {
        let place = Place { origin: at.extend(height(at)), along: DVec2::X };
        block(&mut self.fences, &place, [-0.05, -0.05, -0.4], [0.05, 0.05, 1.05]);
    }

    /// Adds a trunk with branches, and leaves around them.
    fn tree(&mut self, at: DVec2) {
        let tall = self.random.between(3.2, 5.6);
        let lean = direction(self.random.between(0.0, 1.0)) * self.random.between(0.0, 0.3);
        let foot = at.extend(height(at));
        let crown = foot + lean.extend(tall);
        let radius = self.random.between(0.14, 0.22);
        let bend = foot + 0.5 * lean.extend(tall) - 0.2 * lean.extend(0.0);
        let trunk = [
            (foot - 0.5 * DVec3::Z, 1.3 * radius),
            (foot + 0.4 * DVec3::Z, radius),
            (bend, 0.8 * radius),
            (crown, 0.3 * radius),
        ];
        tube(&mut self.wood, &trunk, 8);
        let spread = tall * self.random.between(0.3, 0.38);
        for _ in 0..6 {
            let start = bend + (crown - bend) * self.random.between(0.1, 0.9);
            let end = crown + self.random.in_ball() * spread * DVec3::new(0.85, 0.85, 0.6);
            tube(&mut self.wood, &[(start, 0.35 * radius), (end, 0.1 * radius)], 5);
        }
        let kind = self.random.between(0.0, 2.999) as usize;
        for _ in 0..(60.0 * tall) as u32 {
            // Most leaves are near the outside of the crown, where the light is.
            let place = self.random.in_ball();
            let place = place * (0.5 / place.length().max(0.05) + 0.5).min(2.0);
            let stem = crown + place * spread * DVec3::new(1.0, 1.0, 0.8);
            let along = (self.random.in_ball() + 0.3 * place).normalize_or(DVec3::X);
            let across = along.cross(self.random.in_ball()).normalize_or(along.any_orthonormal_vector());
            let size = self.random.between(0.19, 0.33);
            leaf(&mut self.leaves[kind], stem, size * along, 0.55 * size * across);
        }
    }

    /// Adds poles along a street, with wires from one to the next.
    fn line(&mut self, y: f64, blocks: u32) {
        let tops: Vec<DVec3> = (0..=blocks)
            .map(|i| {
                let at = DVec2::new(BLOCK_WORLD * f64::from(i) + 0.8, y + 1.2);
                let foot = at.extend(height(at));
                let top = foot + 7.5 * DVec3::Z;
                tube(&mut self.wood, &[(foot - 0.8 * DVec3::Z, 0.14), (top + 0.2 * DVec3::Z, 0.09)], 8);
                beam(&mut self.wood, [top - 0.8 * DVec3::Y, top + 0.8 * DVec3::Y], 0.05, 0.06);
                top
            })
            .collect();
        for pair in tops.windows(2) {
            for side in [-0.7, 0.0, 0.7] {
                let along = |share: f64| {
                    let sag = 3.2 * share * (1.0 - share);
                    (pair[0] + (pair[1] - pair[0]) * share + DVec3::new(0.0, side, 0.07 - sag), 0.015)
                };
                let path: Vec<_> = (0..=16).map(|i| along(f64::from(i) / 16.0)).collect();
                tube(&mut self.wires, &path, 4);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Side, sides};

    fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)))
    }

    /// The full scene has a million triangles. None is degenerate, and all are above the ground or slightly below it.
    #[test]
    fn is_a_million_triangles() {
        let scene = town();
        let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        assert!((1_000_000..1_300_000).contains(&triangles), "{triangles}");
        let ground = -BORDER_WORLD..=BLOCK_WORLD * f64::from(BLOCKS) + BORDER_WORLD;
        for mesh in &scene.meshes {
            for triangle in &mesh.triangles {
                let [a, b, c] = corners(mesh, *triangle);
                // The smallest is half the end of a wire. NaN fails too, since comparisons with it are never true.
                assert!((b - a).cross(c - a).length() > 2e-4, "{}: {a} {b} {c}", mesh.name);
                let middle = (a + b + c) / 3.0;
                assert!(ground.contains(&middle.x) && ground.contains(&middle.y), "{}: {middle}", mesh.name);
                let above = middle.z - height(middle.truncate());
                assert!((-3.5..10.0).contains(&above), "{}: {middle}, {above} above the ground", mesh.name);
            }
        }
    }

    /// Houses, frames, posts, wires and trunks are closed and wound outwards; leaves are open, even if they touch closed shapes.
    #[test]
    fn all_but_leaves_are_closed() {
        for mesh in &of_blocks(2).meshes {
            let expected = if mesh.name == "leaves" { Side::Open } else { Side::Outward };
            assert!(mesh.triangles.len() > 100, "{}", mesh.name);
            assert!(sides(mesh).iter().all(|side| *side == expected), "{}", mesh.name);
            assert_eq!(mesh.solid, mesh.name == "ground");
            let is_up = |t: &[u32; 3]| {
                let [a, b, c] = corners(mesh, *t);
                (b - a).cross(c - a).z > 0.0
            };
            assert!(!mesh.solid || mesh.triangles.iter().all(is_up));
        }
    }

    /// Returns the bounding boxes of the closed shapes in a mesh, in the order in which they were built.
    fn boxes(mesh: &Mesh) -> Vec<[DVec3; 2]> {
        let mut boxes: Vec<[DVec3; 2]> = vec![];
        let mut next = 0;
        for triangle in &mesh.triangles {
            let [a, b, c] = corners(mesh, *triangle);
            if triangle.iter().all(|i| *i >= next) {
                boxes.push([a, a]);
            }
            next = triangle.iter().fold(next, |next, i| next.max(i + 1));
            if let Some([low, high]) = boxes.last_mut() {
                (*low, *high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
            }
        }
        boxes
    }

    /// Each shape extends into the ground, or is connected to it through other shapes that it touches.
    #[test]
    fn nothing_floats() {
        let scene = of_blocks(1);
        let built = scene.meshes.iter().filter(|mesh| !mesh.solid && mesh.name != "leaves");
        let mut floating: Vec<_> = built.flat_map(|mesh| boxes(mesh).into_iter().map(|at| (&mesh.name, at))).collect();
        assert!(floating.len() > 500, "{} things", floating.len());
        let is_grounded = |[low, high]: &[DVec3; 2]| low.z < height((0.5 * (*low + *high)).truncate());
        let mut standing: Vec<_> = floating.extract_if(.., |(_, at)| is_grounded(at)).map(|(_, at)| at).collect();
        while let Some([low, high]) = standing.pop() {
            let touches = |[a, b]: &[DVec3; 2]| a.cmple(high).all() && b.cmpge(low).all();
            standing.extend(floating.extract_if(.., |(_, at)| touches(at)).map(|(_, at)| at));
        }
        assert!(floating.is_empty(), "{floating:?}");
    }
}
