//! The built-in scene `grove`: twelve trees whose leaves are cards with holes, under the sun.

use crate::scene::built_in::emitters::ground;
use crate::scene::built_in::grove_leaf::sprig;
use crate::scene::built_in::town_shapes::{empty, tube};
use crate::scene::{Alpha, AlphaMode, AlphaTexture, Camera, Light, LightKind, Mesh, Random, Scene};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// The default and the largest number of cards.
pub(super) const USUAL: u32 = 200_000;
pub(super) const MOST: u32 = 4_000_000;

/// Area of all cards together, holes included.
const AREA_WORLD: f64 = 1_000.0;

/// Height of a card, relative to its width.
const HIGH: f64 = 1.2;

/// Half the side of the ground.
const GROUND_HALF_WORLD: f32 = 40.0;

/// Where the trees stand: around a clearing that is open towards the camera.
const TREES: [[f64; 2]; 12] = [
    [-4.4, -4.2],
    [4.6, -3.6],
    [-6.4, -0.2],
    [-2.4, 0.3],
    [1.7, 0.9],
    [6.6, 0.4],
    [-5.7, 3.9],
    [-1.6, 4.6],
    [2.6, 5.0],
    [6.3, 4.4],
    [-3.6, 7.6],
    [1.0, 8.6],
];

/// Number of boughs per tree. Each ends in a clump of leaves.
const BOUGHS: u32 = 22;

/// Reflectance of the leaves of every third tree.
const GREENS: [[f32; 3]; 3] = [[0.22, 0.4, 0.12], [0.32, 0.44, 0.14], [0.16, 0.32, 0.14]];

/// State and stream of the random numbers.
const SEED: [u64; 2] = [0x6707e, 12];

/// The four corners of a card in the texture, from the lower left counter-clockwise.
const CORNERS: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

/// The crown of a tree: an ellipsoid, and in it the ends of the boughs.
struct Crown {
    middle: DVec3,
    spread: DVec3,
    clumps: Vec<DVec3>,
}

/// Builds the trees with `cards` cards in all. The more cards, the smaller each is; the trees are the same. The result is bit-identical on
/// every machine. With `whole`, cards have no holes.
pub(in crate::scene) fn grove(title: &str, cards: u32, whole: bool) -> Scene {
    let mut random = Random::new(SEED);
    let mut wood = empty("wood", [0.33, 0.25, 0.18]);
    let crowns = TREES.map(|foot| tree(&mut random, &mut wood, foot.into()));
    let ground = Mesh { albedo: [0.38, 0.4, 0.27], solid: true, ..ground(GROUND_HALF_WORLD) };
    let leaves = leaves(&mut random, &crowns, cards).into_iter();
    let leaves = leaves.map(|mesh| Mesh { alpha: mesh.alpha.filter(|_| !whole), ..mesh });
    Scene {
        name: title.into(),
        meshes: [ground, wood].into_iter().chain(leaves).collect(),
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.62, -0.12, -0.77).normalize() },
            radiance: [1.0, 0.97, 0.9],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(2.4, -15.0, 4.4),
            target: DVec3::new(0.4, 0.0, 2.5),
            up: DVec3::Z,
            fov_y_degrees: 36.0,
        },
        ..Scene::default()
    }
}

/// Adds a trunk and its boughs, and returns the crown around them.
fn tree(random: &mut Random, wood: &mut Mesh, foot: DVec2) -> Crown {
    let tall = random.between(3.3, 4.3);
    let lean = 0.3 * random.in_ball().truncate();
    let at = |share: f64| (foot + share * share * lean).extend(share * tall);
    let trunk = [(-0.1, 0.21), (0.06, 0.14), (0.5, 0.1), (1.0, 0.04)];
    tube(wood, &trunk.map(|(share, radius)| (at(share), radius)), 8);
    let middle = at(0.95);
    let spread = random.between(1.75, 2.2) * DVec3::new(1.0, 1.0, 0.85);
    let grow = |_| {
        let start = at(random.between(0.45, 0.98));
        bough(random, wood, start, middle, spread)
    };
    let clumps = (0..BOUGHS).map(grow).collect();
    Crown { middle, spread, clumps }
}

/// Adds a bough that bends upwards, and returns its end.
fn bough(random: &mut Random, wood: &mut Mesh, start: DVec3, middle: DVec3, spread: DVec3) -> DVec3 {
    let end = middle + 0.8 * outwards(random) * spread;
    let bend = start.lerp(end, 0.5) - 0.12 * (end - start).length() * DVec3::Z;
    tube(wood, &[(start, 0.045), (bend, 0.03), (end, 0.01)], 5);
    end
}

/// Returns a point in the unit ball, more likely near its surface.
fn outwards(random: &mut Random) -> DVec3 {
    let point = random.in_ball();
    0.5 * (point + point.normalize_or(DVec3::Z))
}

/// Builds the leaves, one mesh per tree, skipping trees without any.
fn leaves(random: &mut Random, crowns: &[Crown], cards: u32) -> Vec<Mesh> {
    let texture = Arc::new(sprig());
    let first = |tree: usize| (u64::from(cards) * tree as u64 / crowns.len() as u64) as u32;
    let of_tree = |(tree, crown): (usize, &Crown)| {
        let numbers = first(tree)..first(tree + 1);
        let positions = numbers.flat_map(|number| card(random, crown, number, area(number, cards))).collect();
        with_holes(positions, GREENS[tree % GREENS.len()], &texture)
    };
    let all = crowns.iter().enumerate().map(of_tree);
    all.filter(|mesh| !mesh.positions.is_empty()).collect()
}

/// Returns a card's area: 0.6 to 1.4 times the mean.
fn area(number: u32, cards: u32) -> f64 {
    // Multiples of the golden ratio, without their whole parts, are spread evenly however many there are.
    let share = (0.618_033_988_749_895 * f64::from(number)).fract();
    (0.6 + 0.8 * share) * AREA_WORLD / f64::from(cards)
}

/// Returns the corners of a card in one of the crown's clumps. Most cards face outwards, and their tips hang down.
fn card(random: &mut Random, crown: &Crown, number: u32, area: f64) -> [[f32; 3]; 4] {
    let clump = crown.clumps[number as usize % crown.clumps.len()];
    let stem = clump + 0.25 * random.in_ball() * crown.spread;
    let out = (stem - crown.middle).normalize_or(DVec3::Z);
    let normal = (out + 0.4 * DVec3::Z + random.in_ball()).normalize_or(out);
    let hangs = random.in_ball() + 0.5 * out - 0.5 * DVec3::Z;
    let along = hangs.reject_from(normal).normalize_or(normal.any_orthonormal_vector());
    let width = (area / HIGH).sqrt();
    let (across, along) = (0.5 * width * along.cross(normal), HIGH * width * along);
    [stem - across, stem + across, stem + across + along, stem - across + along].map(|p| p.as_vec3().to_array())
}

/// Builds a mesh of cards, given four corners each.
fn with_holes(positions: Vec<[f32; 3]>, albedo: [f32; 3], texture: &Arc<AlphaTexture>) -> Mesh {
    let corners = positions.len();
    let halves = |first: u32| [[first, first + 1, first + 2], [first, first + 2, first + 3]];
    let alpha = Alpha {
        uvs: CORNERS.repeat(corners / CORNERS.len()),
        texture: Some(texture.clone()),
        ..Alpha::constant(AlphaMode::Cut(0.5), 1.0, corners)
    };
    let triangles = (0..corners as u32).step_by(CORNERS.len()).flat_map(halves).collect();
    Mesh { positions, triangles, alpha: Some(alpha), ..empty("leaves", albedo) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Side, sides};

    fn leaves_of(cards: u32) -> Vec<Mesh> {
        grove("grove", cards, false).meshes.into_iter().filter(|mesh| mesh.name == "leaves").collect()
    }

    /// Returns the area of a card, from its two triangles.
    fn area_of(mesh: &Mesh) -> f64 {
        let corner = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
        let of_triangle = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        mesh.triangles.iter().map(|triangle| of_triangle(triangle.map(corner))).sum()
    }

    #[test]
    fn every_card_is_there() {
        for cards in [1, 11, 12, 1_000, 1_001, USUAL] {
            let triangles: usize = leaves_of(cards).iter().map(|mesh| mesh.triangles.len()).sum();
            assert_eq!(triangles, 2 * cards as usize);
        }
    }

    #[test]
    fn the_area_does_not_depend_on_the_number() {
        for cards in [1_000, USUAL] {
            let area: f64 = leaves_of(cards).iter().map(area_of).sum();
            assert!((area / AREA_WORLD - 1.0).abs() < 0.01, "{cards} cards: {area}");
        }
    }

    /// The leaves share one texture, all places in it are in range, and each leaf has holes.
    #[test]
    fn leaves_have_one_texture() {
        let meshes = leaves_of(5_000);
        assert_eq!(meshes.len(), TREES.len());
        let alphas: Vec<_> = meshes.iter().filter_map(|mesh| mesh.alpha.as_ref()).collect();
        let textures: Vec<_> = alphas.iter().filter_map(|alpha| alpha.texture.as_ref()).collect();
        assert_eq!(textures.len(), meshes.len());
        assert!(textures.iter().all(|texture| Arc::ptr_eq(texture, textures[0])));
        for (mesh, alpha) in meshes.iter().zip(alphas) {
            assert_eq!(alpha.mode, AlphaMode::Cut(0.5));
            assert_eq!([alpha.factors.len(), alpha.uvs.len()], [mesh.positions.len(); 2]);
            assert!(alpha.factors.iter().all(|factor| *factor == 1.0));
            assert!(alpha.uvs.iter().flatten().all(|at| (0.0..=1.0).contains(at)));
        }
    }

    /// The wood is closed, rises from the ground, and does not depend on the number of cards.
    #[test]
    fn trees_stand_on_the_ground() {
        let scene = grove("grove", 1_000, false);
        let [ground, wood] = [&scene.meshes[0], &scene.meshes[1]];
        assert!(ground.solid && !wood.solid && ground.alpha.is_none() && wood.alpha.is_none());
        assert!(sides(wood).iter().all(|side| *side == Side::Outward));
        assert!((5_000..15_000).contains(&wood.triangles.len()), "{}", wood.triangles.len());
        assert_eq!(*wood, grove("grove", 20, false).meshes[1]);
        let usual = leaves_of(USUAL);
        let corners = usual.iter().flat_map(|mesh| &mesh.positions);
        for [x, y, z] in corners {
            assert!(x.abs() < 10.0 && y.abs() < 12.0 && (0.5..8.0).contains(z), "{x} {y} {z}");
        }
    }

    #[test]
    fn the_same_grove_each_time() {
        let prints = [1_000, 1_000, 1_001].map(|cards| grove("grove", cards, false).fingerprint());
        assert_eq!(prints[0], prints[1]);
        assert_ne!(prints[1], prints[2]);
    }
}
