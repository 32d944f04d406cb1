//! The built-in scene `cornell`: a room lit mostly by light reflected from its walls. After the box of Goral et al. 1984, *Modeling the
//! interaction of light between diffuse surfaces*, with colors close to Cornell University's measurements.

use crate::scene::built_in::emitters::direction;
use crate::scene::built_in::town_shapes::{Place, block, empty};
use crate::scene::{Camera, Light, LightKind, Mesh, Scene};
use glam::{DVec2, DVec3};

/// Half the room's width and depth, and half its height.
const HALF: f64 = 1.0;

/// Thickness of the walls: more than a voxel of a 32³ grid, so that such a grid can resolve a wall.
const THICK: f64 = 0.1;

/// Overlap of touching objects, and offset between faces that would otherwise be coplanar. Thus no two faces are coplanar, and no light
/// leaks between two walls.
const LAP: f64 = 0.02;

/// Albedos, linear RGB, close to the measured reflectances.
const WHITE: [f32; 3] = [0.73, 0.71, 0.66];
const RED: [f32; 3] = [0.6, 0.06, 0.05];
const GREEN: [f32; 3] = [0.14, 0.45, 0.09];

/// Position of the lamp, just below the ceiling.
const LAMP: DVec3 = DVec3::new(0.0, 0.0, 2.0 * HALF - 0.02);

/// Builds a white room with a red left wall and a green right one, open towards the camera, containing two boxes. A spot light shines
/// straight down, so the ceiling, the upper walls and the shadows receive only indirect light. Units are roughly metres, z is up, and all
/// meshes are closed.
pub(in crate::scene) fn cornell() -> Scene {
    Scene {
        name: "cornell".into(),
        meshes: meshes(),
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
        ..Scene::default()
    }
}

fn meshes() -> Vec<Mesh> {
    let (near, top) = (-HALF, 2.0 * HALF);
    let out = HALF + THICK;
    // The lengths differ, so that no two ends are flush.
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

/// Builds a box centred on (x, y) that extends slightly into the floor, rotated by `turn` full turns.
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
