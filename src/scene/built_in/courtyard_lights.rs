//! The lamps of the courtyard. Each moves along a closed path through free air.

use crate::scene::model::random::Random;
use crate::scene::model::time::wave;
use crate::scene::{Light, LightKind};
use glam::DVec3;

/// The default number of lamps, to which [`RADIUS_WORLD`] and [`STRENGTH`] refer.
pub(in crate::scene) const USUAL: usize = 32;

/// The largest number of lamps.
pub(crate) const MOST: usize = 1024;

/// Radius of each lamp's light at the default number of lamps.
const RADIUS_WORLD: f64 = 5.6;

/// Strength of each lamp at the default number of lamps.
const STRENGTH: f64 = 0.85;

/// Colors of the lamps, linear RGB.
const COLORS: [[f64; 3]; 6] =
    [[1.0, 0.62, 0.28], [1.0, 0.8, 0.55], [0.42, 0.66, 1.0], [1.0, 0.45, 0.3], [0.55, 0.95, 0.75], [0.95, 0.55, 0.8]];

/// First half of each lamp's seed; the second half is the lamp's index.
const SEED: u64 = 0xc0_7a4d;

/// Number of columns that lamps circle, along the lines of the arcades.
const COLUMNS: usize = 20;

/// Distance of the arcades from the court's centre, and distance between columns.
const ARCADE: [f64; 2] = [crate::scene::built_in::courtyard::YARD, crate::scene::built_in::courtyard::BAY];

/// A region of free air in which a lamp moves.
struct Air {
    middle: DVec3,
    /// Smallest and largest amplitude of the motion along each axis.
    reach: [DVec3; 2],
    /// Whether the lamp circles the centre instead of passing through it.
    round: bool,
}

/// Returns the region around an object at (x, y), between two distances from it and two heights.
fn around(x: f64, y: f64, [near, far]: [f64; 2], [low, high]: [f64; 2]) -> Air {
    let half = 0.5 * (high - low);
    let reach = [DVec3::new(near, near, 0.2 * half), DVec3::new(far, far, half)];
    Air { middle: DVec3::new(x, y, low + half), reach, round: true }
}

/// Returns the region inside a box.
fn within(middle: [f64; 3], half: [f64; 3]) -> Air {
    let half = DVec3::from(half);
    Air { middle: DVec3::from(middle), reach: [0.5 * half, half], round: false }
}

/// Returns the position of column `i`, counted counter-clockwise over all arcades, excluding the corners.
fn column(i: usize) -> [f64; 2] {
    let [out, bay] = ARCADE;
    let along = bay * ((i % 5) as f64 - 2.0);
    [[along, -out], [out, along], [along, out], [-out, along]][i / 5 % 4]
}

/// Returns the region of lamp `i`. In every group of sixteen lamps, six circle columns, four move under the arcades, and six above the
/// court. The first lamps are spread over the whole scene, so that even a few lamps light all of it.
fn air(i: usize) -> Air {
    let [round, place] = [i / 16, i % 16];
    // Lamps around free-standing objects keep the distances in the tables below.
    let about = |nth: usize| {
        let [x, y] = column((6 * round + nth) * 7 % COLUMNS);
        around(x, y, [0.62, 0.92], [1.25, 2.3])
    };
    let aisle = |side: usize| {
        let [middle, along, across] = [9.1, 9.2, 0.85];
        let [x, y] = [[0.0, -middle], [middle, 0.0], [0.0, middle], [-middle, 0.0]][side];
        let half = if y == 0.0 { [across, along, 0.6] } else { [along, across, 0.6] };
        within([x, y, 1.7], half)
    };
    let [tree, statue] = [crate::scene::built_in::courtyard::TREE, crate::scene::built_in::courtyard::STATUE];
    match place {
        0 => within([2.5, 0.8, 3.75], [3.4, 2.8, 0.25]),
        1 => about(0),
        2 => aisle(2),
        3 => around(tree[0], tree[1], [1.35, 2.2], [0.9, 2.1]),
        4 => about(1),
        5 => aisle(0),
        6 => around(statue[0], statue[1], [1.3, 2.1], [0.7, 2.8]),
        7 => about(2),
        8 => aisle(3),
        9 => within([0.0, -4.9, 2.3], [5.6, 1.0, 0.9]),
        10 => about(3),
        11 => aisle(1),
        12 => about(4),
        13 => around(tree[0], tree[1], [1.35, 2.2], [0.9, 2.1]),
        14 => about(5),
        _ => within([0.0, -4.9, 2.3], [5.6, 1.0, 0.9]),
    }
}

/// Returns the position of lamp `i` at a given time.
fn position(i: usize, time_s: f64) -> DVec3 {
    let mut random = Random::new([SEED, i as u64]);
    let Air { middle, reach: [least, most], round } = air(i);
    let share = random.between(0.0, 1.0);
    let mut reach = least + (most - least) * share;
    let mut phase = [0; 3].map(|_| random.between(0.0, 1.0));
    // A whole number of turns per period closes the path. If the numbers for x and y differ, the path is a Lissajous figure.
    let mut turns = [[1.0, 2.0, 3.0], [2.0, 1.0, 3.0], [1.0, 3.0, 2.0], [3.0, 2.0, 1.0]][i % 4];
    let mut period_s = random.between(18.0, 30.0);
    if round {
        reach.z = random.between(least.z, most.z);
        phase[0] = phase[1] + 0.25;
        turns = [1.0, 1.0, turns[2]];
        period_s *= 0.4;
    }
    let way = if random.chance(0.5) { 1.0 } else { -1.0 };
    let swing = |axis: usize| wave(way * turns[axis] * time_s / period_s + phase[axis]);
    middle + reach * DVec3::new(swing(0), swing(1), swing(2))
}

/// Returns `count` lamps at a given time. With more lamps, each is weaker and has a smaller radius, so that the total brightness stays
/// about the same.
pub(in crate::scene) fn lights(count: usize, time_s: f64) -> Vec<Light> {
    // The total, count · radius² · strength, stays the same. A limit keeps a few lamps from overexposing the scene.
    let fourth = (USUAL as f64 / count.max(1) as f64).sqrt().sqrt();
    let (radius, strength) = (RADIUS_WORLD * fourth, STRENGTH * (fourth * fourth).min(2.0));
    let light = |i: usize| Light {
        kind: LightKind::Point { position: position(i, time_s) },
        radiance: COLORS[i * 5 % 7 % COLORS.len()].map(|c| (c * strength) as f32),
        radius,
    };
    (0..count).map(light).collect()
}
