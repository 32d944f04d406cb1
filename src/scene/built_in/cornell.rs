//! The built-in scene `cornell`: a room that is mostly lit by light reflected from its walls. After the box of Goral et al. 1984, *Modeling
//! the interaction of light between diffuse surfaces*, as Cornell University measured it.

use crate::scene::built_in::emitters::direction;
use crate::scene::built_in::town_shapes::{Place, block, empty};
use crate::scene::{Camera, Light, LightKind, Mesh, Motion, Scene};
use glam::{DVec2, DVec3};

/// Half the room's width and depth, and half its height.
const HALF: f64 = 1.0;

/// Thickness of the walls, so that a grid of voxels has room for all of a wall: more than a voxel of 32³.
const THICK: f64 = 0.1;

/// How far one thing stands in another that it touches, and ends before or behind another that would be flush with it: no
/// two faces lie in one plane, and no light comes through between two walls.
const LAP: f64 = 0.02;

/// Linear RGB, about the measured reflectances.
const WHITE: [f32; 3] = [0.73, 0.71, 0.66];
const RED: [f32; 3] = [0.6, 0.06, 0.05];
const GREEN: [f32; 3] = [0.14, 0.45, 0.09];

/// Just under the ceiling.
const LAMP: DVec3 = DVec3::new(0.0, 0.0, 2.0 * HALF - 0.02);

/// A white room, its walls to the left and right red and green, open towards the camera, with two boxes in it, under a spot
/// light that looks straight down: ceiling, the walls' upper parts and the shadows have indirect light alone. In units of about
/// a metre, z up. All of it is closed.
pub(in crate::scene) fn cornell() -> Scene {
    Scene {
        name: "cornell".into(),
        particles: Vec::new(),
        strands: Vec::new(),
        gaussians: Vec::new(),
        volumes: Vec::new(),
        meshes: meshes(),
        motion: Motion::Still,
        extinction_ratio: Scene::GREY,
        lights: vec![Light {
            kind: LightKind::Spot { position: LAMP, direction: DVec3::NEG_Z, cone_degrees: 110.0 },
            radiance: [1.4, 1.25, 1.0],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(0.0, -4.9, HALF),
            target: DVec3::new(0.0, 0.0, HALF),
            up: DVec3::Z,
            fov_y_degrees: 32.0,
        },
    }
}

fn meshes() -> Vec<Mesh> {
    let (near, top) = (-HALF, 2.0 * HALF);
    let out = HALF + THICK;
    // Each of another length than its neighbours.
    let [floor, walls, back] = [HALF + 2.0 * LAP, HALF + 3.0 * LAP, HALF + LAP];
    vec![
        slab("floor", WHITE, [-floor, near - LAP, -THICK], [floor, floor, 0.0]),
        slab("ceiling", WHITE, [-floor, near - LAP, top], [floor, floor, top + THICK]),
        slab("back", WHITE, [-back, HALF, -LAP], [back, out, top + LAP]),
        slab("left", RED, [-out, near, -3.0 * LAP], [-HALF, walls, top + 3.0 * LAP]),
        slab("right", GREEN, [HALF, near, -3.0 * LAP], [out, walls, top + 3.0 * LAP]),
        standing("tall box", [-0.35, 0.32], 0.05, 1.2),
        standing("short box", [0.36, -0.32], -0.045, 0.6),
    ]
}

fn slab(name: &str, albedo: [f32; 3], low: [f64; 3], high: [f64; 3]) -> Mesh {
    let mut mesh = empty(name, albedo);
    block(&mut mesh, &Place { origin: DVec3::ZERO, along: DVec2::X }, low, high);
    mesh
}

/// A box about (x, y) that stands a little in the floor, turned by a part `turn` of a full turn.
fn standing(name: &str, [x, y]: [f64; 2], turn: f64, height: f64) -> Mesh {
    const HALF_SIDE: f64 = 0.3;
    let mut mesh = empty(name, WHITE);
    let place = Place { origin: DVec3::new(x, y, 0.0), along: direction(turn) };
    block(&mut mesh, &place, [-HALF_SIDE, -HALF_SIDE, -LAP], [HALF_SIDE, HALF_SIDE, height]);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Side, sides};

    #[test]
    fn all_is_closed() {
        let meshes = meshes();
        assert_eq!(meshes.len(), 7);
        for mesh in &meshes {
            assert_eq!(sides(mesh), [Side::Outward; 12], "{}", mesh.name);
        }
    }
}
