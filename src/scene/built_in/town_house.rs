//! A house of the town: walls under a pitched roof, windows, a door, a chimney, and perhaps a wing that joins the main body.

use crate::scene::Mesh;
use crate::scene::built_in::town_shapes::{Place, block, extrude, fan};

/// The meshes of a house, one per material.
pub(in crate::scene) struct Materials<'a> {
    pub walls: &'a mut Mesh,
    pub roofs: &'a mut Mesh,
    pub frames: &'a mut Mesh,
    pub glass: &'a mut Mesh,
}

/// The dimensions of a house, in world units. Its ridge runs along its place's x axis.
pub(in crate::scene) struct House {
    pub half_length: f64,
    pub half_width: f64,
    pub storeys: u32,
    /// Rise of the roof from the eaves to the ridge.
    pub rise: f64,
    /// Half the length of the wing, if there is one.
    pub wing: Option<f64>,
}

/// How far walls extend below the ground floor: more than the ground falls away under any house.
const FOUNDATION: f64 = 2.5;

/// Height of a storey.
const HEIGHT: f64 = 2.2;

/// How far a roof overhangs its walls.
const OVERHANG: f64 = 0.45;

/// How far a roof extends below and above the walls' upper ends.
const ROOF: [f64; 2] = [0.06, 0.22];

/// How far frames protrude from walls, and extend into them.
const FRAME: [f64; 2] = [0.07, 0.05];

/// Width of a frame's bars.
const BAR: f64 = 0.07;

/// Builds a house whose ground floor is at the place's height.
pub(in crate::scene) fn house(materials: &mut Materials, place: &Place, house: &House) {
    let eaves = HEIGHT * f64::from(house.storeys) + 0.3;
    body(materials, place, house, eaves);
    let spacing = 1.7;
    let along = ((2.0 * house.half_length - 0.8) / spacing) as u32;
    let across = ((2.0 * house.half_width - 0.8) / spacing) as u32;
    let sides = [
        ([1.0, 0.0], house.half_width, along),
        ([0.0, 1.0], house.half_length, across),
        ([-1.0, 0.0], house.half_width, along),
        ([0.0, -1.0], house.half_length, across),
    ];
    for (number, (direction, distance, count)) in sides.into_iter().enumerate() {
        for storey in 0..house.storeys {
            for window in 0..count {
                let at = (f64::from(window) - 0.5 * f64::from(count - 1)) * spacing;
                let floor = HEIGHT * f64::from(storey) + 0.1;
                // Looking along a wall's x axis, its outside is on the right.
                let [x, y] = direction;
                let wall = place.turned([at * x + distance * y, at * y - distance * x, floor], direction);
                match (number, storey, window) {
                    (0, 0, 0) => opening(materials, &wall, 0.45, [0.0, 1.9]),
                    _ => opening(materials, &wall, 0.42, [0.8, 1.95]),
                }
            }
        }
    }
    let chimney = [0.5 * house.half_length, 0.3 * house.half_width];
    let top = eaves + house.rise + 0.5;
    let [x, y] = chimney;
    block(materials.walls, place, [x - 0.25, y - 0.25, eaves], [x + 0.25, y + 0.25, top]);
    block(materials.roofs, place, [x - 0.32, y - 0.32, top - 0.05], [x + 0.32, y + 0.32, top + 0.08]);
    if let Some(half_length) = house.wing {
        // The wing's ridge runs across the house's, and the wing begins inside the house.
        let half_width = 0.55 * house.half_length;
        let origin = [-0.3 * house.half_length, house.half_width + half_length - 0.6, 0.0];
        let wing = place.turned(origin, [0.0, 1.0]);
        let rise = house.rise * half_width / house.half_width;
        let measures = House { half_length, half_width, storeys: 1, rise, wing: None };
        body(materials, &wing, &measures, HEIGHT + 0.1);
        for side in [-1.0, 1.0] {
            let wall = wing.turned([0.2 * half_length, -side * half_width, 0.1], [side, 0.0]);
            opening(materials, &wall, 0.42, [0.8, 1.8]);
        }
    }
}

/// Builds walls and roof.
fn body(materials: &mut Materials, place: &Place, house: &House, eaves: f64) {
    let House { half_length, half_width, rise, .. } = *house;
    let ridge = eaves + rise;
    let walls = [
        [-half_width, -FOUNDATION],
        [half_width, -FOUNDATION],
        [half_width, eaves],
        [0.0, ridge],
        [-half_width, eaves],
    ];
    extrude(materials.walls, place, [-half_length, half_length], &walls, &fan(5));
    let reach = half_width + OVERHANG;
    let edge = eaves - rise * OVERHANG / half_width;
    let [below, above] = ROOF;
    let roof = [
        [reach, edge - below],
        [reach, edge + above],
        [0.0, ridge + above],
        [-reach, edge + above],
        [-reach, edge - below],
        [0.0, ridge - below],
    ];
    let slopes = [[0, 1, 2], [0, 2, 5], [2, 3, 4], [2, 4, 5]];
    let ends = half_length + OVERHANG;
    extrude(materials.roofs, place, [-ends, ends], &roof, &slopes);
}

/// Builds a window or a door in a wall whose outside faces −y: a pane in a frame with a bar in the middle.
fn opening(materials: &mut Materials, wall: &Place, half: f64, [low, high]: [f64; 2]) {
    let [out, into] = FRAME;
    let mut bar = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], out: f64| {
        block(materials.frames, wall, [x0, -out, z0], [x1, into, z1]);
    };
    bar([-half, -half + BAR], [low, high], out);
    bar([half - BAR, half], [low, high], out);
    bar([-half + 0.5 * BAR, half - 0.5 * BAR], [high - BAR, high], 0.9 * out);
    bar([-half + 0.5 * BAR, half - 0.5 * BAR], [low, low + BAR], 0.9 * out);
    bar([-0.4 * BAR, 0.4 * BAR], [low + 0.5 * BAR, high - 0.5 * BAR], 0.7 * out);
    bar([-half - 0.1, half + 0.1], [low - 0.06, low + 0.02], 2.0 * out);
    block(materials.glass, wall, [-half + 0.5 * BAR, -0.2 * out, low], [half - 0.5 * BAR, 0.8 * into, high]);
}
