//! The built-in scene `courtyard`: arcades around a court, under moving lamps.

use crate::Result;
use crate::scene::built_in::courtyard_lights::lights;
use crate::scene::built_in::courtyard_shapes::{Arches, knot};
use crate::scene::built_in::emitters::direction;
use crate::scene::built_in::grove_leaf::sprig;
use crate::scene::built_in::town_shapes::{Place, beam, block, empty, leaf, tube};
use crate::scene::model::random::Random;
use crate::scene::model::time::check_time;
use crate::scene::{Alpha, AlphaMode, Camera, Light, Mesh, Scene};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Distance from the court's centre to the columns' axes.
pub(in crate::scene) const YARD: f64 = 7.2;

/// Distance between neighbouring columns.
pub(in crate::scene) const BAY: f64 = 2.4;

/// Number of arches per side.
const BAYS: u32 = 6;

/// Position of the tree.
pub(in crate::scene) const TREE: [f64; 2] = [-3.2, 0.6];

/// Position of the statue.
pub(in crate::scene) const STATUE: [f64; 2] = [2.8, -0.4];

/// Distances from the court's centre to the inner and outer faces of the outer walls.
const WALL: [f64; 2] = [10.8, 11.4];

/// Half the side of the ground.
const GROUND: f64 = 13.0;

/// Height at which arches begin, and height of the top of the walls above them.
const ARCH: [f64; 2] = [3.12, 5.0];

/// The roofs' upper surface. `ROOF`: height at the eaves, and the eaves' distance from the court's centre. `SLOPE`: rise per unit of
/// distance outwards.
const ROOF: [f64; 2] = [5.1, 6.65];
const SLOPE: f64 = 0.36;

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0xc0_7a4d, 5];

/// Builds the scene with the given name and number of lamps at a given time. With `holes`, an alpha texture cuts a sprig out of each leaf.
/// The result is bit-identical on every call and machine.
///
/// # Errors
/// Same as [`check_time`].
pub(in crate::scene) fn courtyard(name: &str, lights: u32, holes: bool, time_s: f64) -> Result<Scene> {
    let mut meshes = meshes();
    if holes {
        meshes.iter_mut().filter(|mesh| mesh.name == "leaves").for_each(cut_holes);
    }
    Ok(Scene {
        name: name.into(),
        meshes,
        lights: lights_at(lights as usize, time_s)?,
        camera: Camera {
            position: DVec3::new(-6.1, -6.3, 2.6),
            target: DVec3::new(0.9, 2.2, 1.55),
            up: DVec3::Z,
            fov_y_degrees: 56.0,
        },
        ..Scene::default()
    })
}

/// Returns `count` lamps at a given time.
///
/// # Errors
/// Same as [`check_time`].
pub(crate) fn lights_at(count: usize, time_s: f64) -> Result<Vec<Light>> {
    check_time("courtyard", time_s)?;
    Ok(lights(count, time_s))
}

/// The meshes while they are built.
struct Courtyard {
    random: Random,
    walls: Mesh,
    columns: Mesh,
    trim: Mesh,
    roofs: Mesh,
    slabs: [Mesh; 2],
    steps: Mesh,
    statue: Mesh,
    iron: Mesh,
    wood: Mesh,
    leaves: Mesh,
}

fn meshes() -> Vec<Mesh> {
    let mut court = Courtyard {
        random: Random::new(SEED),
        walls: empty("walls", [0.78, 0.66, 0.52]),
        columns: empty("columns", [0.86, 0.83, 0.78]),
        trim: empty("trim", [0.7, 0.6, 0.52]),
        roofs: empty("roofs", [0.6, 0.28, 0.18]),
        slabs: [("slabs", [0.6, 0.56, 0.5]), ("slabs", [0.49, 0.44, 0.39])].map(|(name, albedo)| empty(name, albedo)),
        steps: empty("steps", [0.74, 0.7, 0.65]),
        statue: empty("statue", [0.5, 0.62, 0.56]),
        iron: empty("iron", [0.16, 0.16, 0.18]),
        wood: empty("wood", [0.4, 0.3, 0.22]),
        leaves: empty("leaves", [0.34, 0.52, 0.2]),
    };
    // Each side has its own axes: x points out of the court, y along the arcade.
    for along in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y] {
        court.side(&Place { origin: DVec3::ZERO, along });
    }
    court.floor();
    court.stairs();
    court.monument();
    court.tree();
    court.wires();
    let Courtyard { walls, columns, trim, roofs, slabs, steps, statue, iron, wood, leaves, .. } = court;
    let singles = [ground(), walls, columns, trim, roofs, steps, statue, iron, wood, leaves];
    singles.into_iter().chain(slabs).collect()
}

/// Cuts a sprig out of each leaf: its stem, sides and tip are in the middles of the texture's sides.
fn cut_holes(leaves: &mut Mesh) {
    const CORNERS: [[f32; 2]; 4] = [[0.5, 1.0], [1.0, 0.5], [0.5, 0.0], [0.0, 0.5]];
    let corners = leaves.positions.len();
    leaves.alpha = Some(Alpha {
        uvs: CORNERS.repeat(corners / CORNERS.len()),
        texture: Some(Arc::new(sprig())),
        ..Alpha::constant(AlphaMode::Cut(0.5), 1.0, corners)
    });
}

/// Builds a flat square, divided into squares. It is solid, so it is seen only from above.
fn ground() -> Mesh {
    const SQUARES: u32 = 26;
    let mut ground = empty("ground", [0.42, 0.38, 0.33]);
    let place = |i: u32| GROUND * (2.0 * f64::from(i) / f64::from(SQUARES) - 1.0);
    for i in 0..(SQUARES + 1) * (SQUARES + 1) {
        let at = DVec3::new(place(i % (SQUARES + 1)), place(i / (SQUARES + 1)), 0.0);
        ground.positions.push(at.as_vec3().to_array());
    }
    for i in 0..SQUARES * SQUARES {
        let a = i / SQUARES * (SQUARES + 1) + i % SQUARES;
        let [b, c, d] = [a + 1, a + SQUARES + 2, a + SQUARES + 1];
        ground.triangles.extend([[a, b, c], [a, c, d]]);
    }
    ground.solid = true;
    ground
}

impl Courtyard {
    /// Adds one side of the court: columns, arches above them, and a roof that rises from there to the outer wall.
    fn side(&mut self, place: &Place) {
        let arcade = place.turned([YARD, 0.0, 0.0], [1.0, 0.0]);
        for i in 1..BAYS {
            let y = BAY * (f64::from(i) - 0.5 * f64::from(BAYS));
            self.column(&place.turned([YARD, y, 0.0], [1.0, 0.0]));
            // A pilaster on the wall opposite the column, and an arch from the column to the wall.
            block(&mut self.trim, place, [WALL[0] - 0.25, y - 0.22, -0.1], [WALL[0] + 0.1, y + 0.22, ARCH[1]]);
            let width = WALL[0] - 0.2 - YARD - 0.25;
            let rib = Arches {
                count: 1,
                bay: width,
                radius: 0.5 * width - 0.15,
                heights: [ARCH[0], ARCH[1]],
                half_thickness: 0.13,
            };
            rib.wall(&mut self.walls, &place.turned([YARD + 0.25 + 0.5 * width, y, 0.0], [0.0, 1.0]));
        }
        let arches = Arches { count: BAYS, bay: BAY, radius: 0.8, heights: ARCH, half_thickness: 0.3 };
        arches.wall(&mut self.walls, &arcade);
        arches.frames(&mut self.trim, &arcade, 0.14, 0.05);
        let half = 0.5 * BAY * f64::from(BAYS);
        block(&mut self.trim, &arcade, [-0.38, -half, ARCH[1] - 0.22], [0.38, half, ARCH[1] + 0.06]);
        // The corner pier at one end of the arcade.
        block(&mut self.walls, place, [YARD - 0.42, YARD - 0.42, -0.1], [YARD + 0.42, YARD + 0.42, ARCH[1] - 0.1]);
        for [out, low, high] in [[0.5, -0.1, 0.28], [0.5, ARCH[0] - 0.14, ARCH[0] + 0.04]] {
            let [near, far] = [YARD - out, YARD + out];
            block(&mut self.trim, place, [near, near, low], [far, far, high]);
        }
        let height = roof_height(WALL[0]) + 0.5;
        block(&mut self.walls, place, [WALL[0], -WALL[0] - 0.05, -0.1], [WALL[1], WALL[1], height]);
        self.roof(place);
        for bay in (0..BAYS).filter(|bay| !matches!(bay, 2 | 3)) {
            let low = BAY * (f64::from(bay) - 0.5 * f64::from(BAYS));
            self.railing([low + 0.2, low + BAY - 0.2].map(|y| arcade.at([0.0, y, 0.0])), 16);
        }
    }

    /// Adds a round column between two square blocks.
    fn column(&mut self, place: &Place) {
        block(&mut self.trim, place, [-0.36, -0.36, -0.1], [0.36, 0.36, 0.18]);
        // The column's profile: radius, height.
        let profile = [
            [0.31, 0.1],
            [0.33, 0.19],
            [0.35, 0.24],
            [0.35, 0.28],
            [0.33, 0.33],
            [0.28, 0.35],
            [0.27, 0.39],
            [0.25, 0.44],
            [0.248, 0.9],
            [0.243, 1.4],
            [0.235, 1.9],
            [0.222, 2.4],
            [0.215, 2.58],
            [0.25, 2.6],
            [0.25, 2.66],
            [0.22, 2.68],
            [0.225, 2.76],
            [0.25, 2.84],
            [0.3, 2.92],
            [0.36, 2.98],
            [0.38, 3.03],
        ];
        let ring = |[radius, height]: [f64; 2]| (place.at([0.0, 0.0, height]), radius);
        tube(&mut self.columns, &profile.map(ring), 32);
        block(&mut self.trim, place, [-0.4, -0.4, 3.0], [0.4, 0.4, ARCH[0] + 0.02]);
    }

    /// Adds a roof slab with rows of round tiles. It meets the slabs of the neighbouring sides along the hips.
    fn roof(&mut self, place: &Place) {
        let (inner, outer) = (ROOF[1], WALL[0] + 0.1);
        let corners = [[inner, -0.14], [outer, -0.14], [outer, 0.0], [inner, 0.0]];
        // The slab's outline as points (x, z), once at each hip.
        let first = self.roofs.positions.len() as u32;
        for side in [-1.0, 1.0] {
            for [x, above] in corners {
                let point = place.at([x, side * x, roof_height(x) + above]);
                self.roofs.positions.push(point.as_vec3().to_array());
            }
        }
        let quads = [[0, 1, 2, 3], [7, 6, 5, 4], [1, 0, 4, 5], [2, 1, 5, 6], [3, 2, 6, 7], [0, 3, 7, 4]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        self.roofs.triangles.extend(triangles.map(|t| t.map(|i: u32| first + i)));
        let rows = 72;
        for row in 0..rows {
            let y = 2.0 * (outer - 0.2) * ((f64::from(row) + 0.5) / f64::from(rows) - 0.5);
            let start = inner.max(y.abs()) - 0.06;
            let courses = ((outer - start) / 0.42).ceil() as u32;
            let path: Vec<_> = (0..2 * courses)
                .map(|i| {
                    // Each tile overlaps the next, so it is wider at its lower end.
                    let x = start + 0.42 * f64::from(i / 2) + if i % 2 == 0 { 0.0 } else { 0.41 };
                    let radius = if i % 2 == 0 { 0.085 } else { 0.07 };
                    (place.at([x, y, roof_height(x)]), radius)
                })
                .collect();
            tube(&mut self.roofs, &path, 6);
        }
    }

    /// Adds bars between two rails, from one position to another.
    fn railing(&mut self, [from, to]: [DVec3; 2], bars: u32) {
        for height in [0.12, 0.88] {
            beam(&mut self.iron, [from, to].map(|end| end + height * DVec3::Z), 0.018, 0.012);
        }
        for bar in 0..bars {
            let foot = from + (to - from) * ((f64::from(bar) + 0.5) / f64::from(bars));
            tube(&mut self.iron, &[(foot + 0.11 * DVec3::Z, 0.009), (foot + 0.88 * DVec3::Z, 0.009)], 6);
        }
    }

    /// Adds slabs with joints between them, in two colors.
    fn floor(&mut self) {
        const SLABS: u32 = 12;
        let side = 2.0 * (YARD - 0.6) / f64::from(SLABS);
        for i in 0..SLABS * SLABS {
            let (x, y) = (i % SLABS, i / SLABS);
            let low = [x, y].map(|n| side * (f64::from(n) - 0.5 * f64::from(SLABS)) + 0.02);
            let place = Place { origin: DVec3::ZERO, along: DVec2::X };
            let high = low.map(|c| c + side - 0.04);
            let top = 0.03 + self.random.between(0.0, 0.015);
            block(&mut self.slabs[((x + y) % 2) as usize], &place, [low[0], low[1], -0.1], [high[0], high[1], top]);
        }
    }

    /// Adds stairs up to a platform, both with a railing towards the court.
    fn stairs(&mut self) {
        const STEPS: u32 = 11;
        let place = Place { origin: DVec3::new(0.4, 4.3, 0.0), along: DVec2::X };
        let (tread, rise, end, width) = (0.32, 0.17, 5.7, 1.75);
        let foot = |x: f64, y: f64, top: f64| place.at([x, y, top]);
        let mut feet = Vec::new();
        for step in 0..STEPS {
            let top = rise * f64::from(step + 1);
            let x = tread * f64::from(step);
            let next = if step + 1 == STEPS { end } else { x + tread + 0.02 };
            block(&mut self.steps, &place, [x, 0.0, -0.1], [next, width, top - 0.05]);
            // The tread overhangs the riser.
            block(&mut self.steps, &place, [x - 0.03, -0.03, top - 0.06], [next, width + 0.03, top]);
            feet.push(foot(x + 0.5 * tread, 0.06, top));
        }
        let top = rise * f64::from(STEPS);
        let corners = [feet[0], feet[feet.len() - 1], foot(end - 0.08, 0.06, top), foot(end - 0.08, width - 0.06, top)];
        for (pair, posts) in corners.windows(2).zip([0, 14, 11]) {
            beam(&mut self.iron, [pair[0], pair[1]].map(|foot| foot + 0.95 * DVec3::Z), 0.03, 0.02);
            feet.extend((1..=posts).map(|i| pair[0] + (pair[1] - pair[0]) * (f64::from(i) / f64::from(posts))));
        }
        for foot in feet {
            tube(&mut self.iron, &[(foot - 0.04 * DVec3::Z, 0.012), (foot + 0.95 * DVec3::Z, 0.012)], 6);
        }
    }

    /// Adds a knot on a pedestal.
    fn monument(&mut self) {
        let place = Place { origin: DVec2::from(STATUE).extend(0.0), along: DVec2::new(0.8, 0.6) };
        for [half, low, high] in [[0.62, -0.1, 0.16], [0.45, 0.1, 0.92], [0.54, 0.86, 1.02]] {
            block(&mut self.steps, &place, [-half, -half, low], [half, half, high]);
        }
        tube(&mut self.statue, &[(place.at([0.0, 0.0, 0.98]), 0.3), (place.at([0.0, 0.0, 1.16]), 0.16)], 24);
        knot(&mut self.statue, place.at([0.0, 0.0, 2.06]), 1.0, 0.13);
    }

    /// Adds a tree in a round bed.
    fn tree(&mut self) {
        let foot = DVec2::from(TREE).extend(0.0);
        let ring = |radius: f64, height: f64| (foot + height * DVec3::Z, radius);
        tube(&mut self.steps, &[ring(1.0, -0.1), ring(1.0, 0.4), ring(1.06, 0.42), ring(1.06, 0.5)], 40);
        let crown = foot + DVec3::new(0.15, 0.1, 4.6);
        let fork = foot + DVec3::new(-0.1, 0.05, 2.75);
        tube(&mut self.wood, &[ring(0.3, 0.4), ring(0.2, 0.8), (fork, 0.15), (crown, 0.05)], 14);
        for i in 0..26 {
            let start = fork + (crown - fork) * self.random.between(0.0, 0.9);
            let out = direction(0.618_034 * f64::from(i)) * self.random.between(1.1, 1.9);
            let end = start + out.extend(self.random.between(0.5, 1.3));
            let bend = start + 0.5 * (end - start) + 0.12 * self.random.in_ball();
            tube(&mut self.wood, &[(start, 0.055), (bend, 0.035), (end, 0.012)], 7);
            for _ in 0..230 {
                let along = self.random.between(0.45, 1.08);
                let stem = start + (end - start) * along + 0.52 * self.random.in_ball();
                self.leaf(stem);
            }
        }
    }

    fn leaf(&mut self, stem: DVec3) {
        let along = (self.random.in_ball() - 0.3 * DVec3::Z).normalize_or(DVec3::X);
        let across = along.cross(self.random.in_ball()).normalize_or(along.any_orthonormal_vector());
        let size = self.random.between(0.055, 0.1);
        leaf(&mut self.leaves, stem, size * along, 0.5 * size * across);
    }

    /// Adds wires over the court, with small objects hanging from them.
    fn wires(&mut self) {
        for [from, to] in [[[-2.4, -1.0], [4.8, 1.0]], [[-4.8, -1.0], [0.0, 1.0]], [[2.4, -1.0], [-2.4, 1.0]]] {
            let [a, b] = [from, to].map(|[x, side]| DVec3::new(x, side * (YARD - 0.3), ARCH[1] - 0.3));
            let at = |share: f64| a + (b - a) * share - 0.35 * 4.0 * share * (1.0 - share) * DVec3::Z;
            let path: Vec<_> = (0..=32).map(|i| (at(f64::from(i) / 32.0), 0.008)).collect();
            tube(&mut self.iron, &path, 5);
            for i in 1..10 {
                let top = at(f64::from(i) / 10.0);
                let body = [[0.0, 0.01], [0.03, 0.045], [0.14, 0.06], [0.2, 0.03], [0.21, 0.01]];
                let ring = |[below, radius]: [f64; 2]| (top - (below - 0.004) * DVec3::Z, radius);
                let mut path = body.map(ring);
                path.reverse();
                tube(&mut self.iron, &path, 10);
            }
        }
    }
}

/// Returns the height of the roof's upper surface at a given distance from the court's centre.
fn roof_height(out: f64) -> f64 {
    ROOF[0] + SLOPE * (out - ROOF[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Side, sides};

    fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)))
    }

    /// All triangles are above the ground or slightly below it, and none is degenerate.
    #[test]
    fn is_a_hundred_and_forty_thousand_triangles() {
        let meshes = meshes();
        let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        assert!((130_000..150_000).contains(&triangles), "{triangles}");
        for mesh in &meshes {
            for triangle in &mesh.triangles {
                let [a, b, c] = corners(mesh, *triangle);
                // NaN fails too, since comparisons with it are never true.
                assert!((b - a).cross(c - a).length() > 2e-5, "{}: {a} {b} {c}", mesh.name);
                for corner in [a, b, c] {
                    assert!(corner.abs().max_element() <= GROUND && corner.z >= -0.1001, "{}: {corner}", mesh.name);
                }
            }
        }
    }

    /// Everything except leaves is closed and wound outwards.
    #[test]
    fn all_but_leaves_are_closed() {
        for mesh in meshes() {
            let expected = if mesh.name == "leaves" { Side::Open } else { Side::Outward };
            assert!(mesh.triangles.len() > 100, "{}", mesh.name);
            let wrong = sides(&mesh).iter().filter(|side| **side != expected).count();
            assert_eq!(wrong, 0, "{} of {}", mesh.triangles.len(), mesh.name);
            assert_eq!(mesh.solid, mesh.name == "ground");
        }
    }

    /// Leaves alone have holes, and they stand where leaves without stand.
    #[test]
    fn leaves_have_holes() {
        let scene = courtyard("courtyard", 1, true, 0.0).expect("the time is in range");
        let with_alpha: Vec<_> = scene.meshes.iter().filter(|mesh| mesh.alpha.is_some()).collect();
        let [leaves] = with_alpha[..] else { panic!("{} meshes have alpha", with_alpha.len()) };
        let alpha = leaves.alpha.as_ref().expect("an alpha");
        assert_eq!((alpha.uvs.len(), leaves.triangles.len()), (leaves.positions.len(), 11_960));
        assert_eq!(courtyard("courtyard", 1, false, 0.0).expect("in range").meshes[9].positions, leaves.positions);
    }

    /// Wires and bars are thinner than a voxel of a 256³ grid over the court.
    #[test]
    fn some_of_it_is_thinner_than_a_voxel() {
        let voxel = 2.0 * GROUND / 256.0;
        let iron = meshes().into_iter().find(|mesh| mesh.name == "iron").expect("bars and wires");
        // On a long thin shape, a triangle's shortest edge equals the shape's thickness.
        let across = |t: &[u32; 3]| {
            let [a, b, c] = corners(&iron, *t);
            [(b - a).length(), (c - b).length(), (a - c).length()].into_iter().fold(f64::MAX, f64::min)
        };
        let thin = iron.triangles.iter().filter(|t| across(t) < 0.2 * voxel).count();
        assert!(thin > iron.triangles.len() / 2, "{thin} of {}", iron.triangles.len());
    }
}
