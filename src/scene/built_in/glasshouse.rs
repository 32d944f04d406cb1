//! The built-in scene `glasshouse`: smoke in a small greenhouse, whose panes let different shares of the sunlight through.

use crate::Result;
use crate::scene::built_in::emitters::{Emitter, ground, smoke};
use crate::scene::built_in::town_shapes::{empty, tube};
use crate::scene::{Alpha, AlphaMode, Camera, Light, LightKind, Mesh, Scene};
use glam::DVec3;

/// Alpha of the panes. Each is used equally often.
const ALPHAS: [f32; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// The extinctions of colored panes, in the order of [`ALPHAS`]: amber, green, red, blue and clear.
const COLORS: [[f32; 3]; 5] = [[0.2, 0.5, 1.0], [1.0, 0.25, 0.9], [0.15, 1.0, 1.0], [1.0, 0.6, 0.15], Scene::GREY];

/// Half the length and width of the house, and the height of its eaves and its ridge.
const HALF_WORLD: [f64; 2] = [2.4, 1.6];
const EAVE_WORLD: f64 = 1.9;
const RIDGE_WORLD: f64 = 2.8;

/// Number of panes along the house.
const BAYS: u32 = 4;

/// Half the thickness of a bar.
const BAR_WORLD: f64 = 0.04;

/// Half the side of the ground.
const GROUND_HALF_WORLD: f32 = 9.0;

/// The scene's time: a particle's lifetime, so that all particles exist.
const TIME_S: f64 = 9.0;

/// The smoke rises between the panes and stays there: 1,600 particles.
const SMOKE: [Emitter; 2] = [heap([0x91a5_0001, 51], [-1.2, 0.1]), heap([0x91a5_0002, 52], [1.0, -0.3])];

const fn heap(seed: [u64; 2], [x, y]: [f64; 2]) -> Emitter {
    Emitter {
        seed,
        capacity: 800,
        lifetime_s: TIME_S,
        position: DVec3::new(x, y, 0.1),
        nozzle_radius_world: 0.2,
        velocity: DVec3::new(0.0, 0.0, 0.2),
        velocity_spread: 0.1,
        rise: [0.26, 0.12],
        drag: 1.5,
        swirl: 0.05,
        drift: 0.05,
        radius_world: [0.07, 0.26],
        optical_depth: 0.12,
    }
}

/// Builds the house under the sun, with grey or colored panes. The result is bit-identical on every call and machine.
///
/// # Errors
/// None: the time is in range.
pub(in crate::scene) fn glasshouse(name: &str, is_colored: bool) -> Result<Scene> {
    let panes = panes();
    let ground = Mesh { solid: true, ..ground(GROUND_HALF_WORLD) };
    let groups = (0..ALPHAS.len()).map(|group| glass(group, is_colored, &panes));
    let scene = Scene {
        name: name.into(),
        particles: smoke(name, &SMOKE, TIME_S)?,
        meshes: [ground, frame(&panes)].into_iter().chain(groups).collect(),
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.45, 0.55, -0.7).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(5.6, -6.6, 4.4),
            target: DVec3::new(0.8, 0.4, 0.9),
            up: DVec3::Z,
            fov_y_degrees: 34.0,
        },
        ..Scene::default()
    };
    scene.with_tints()
}

/// Returns the corners of all panes: walls and roof bay by bay, then the gables.
fn panes() -> Vec<[DVec3; 4]> {
    let [half_length, half_width] = HALF_WORLD;
    let column = |bay: u32| half_length * (2.0 * f64::from(bay) / f64::from(BAYS) - 1.0);
    let foot = |x: f64, side: f64| DVec3::new(x, side * half_width, 0.0);
    let eave = |x: f64, side: f64| DVec3::new(x, side * half_width, EAVE_WORLD);
    let top = |x: f64| DVec3::new(x, 0.0, RIDGE_WORLD);
    let bay = |(bay, side): (u32, f64)| {
        let [a, b] = [column(bay), column(bay + 1)];
        [[foot(a, side), foot(b, side), eave(b, side), eave(a, side)], [eave(a, side), eave(b, side), top(b), top(a)]]
    };
    let gable = |(x, side): (f64, f64)| [foot(x, side), foot(x, 0.0), top(x), eave(x, side)];
    let bays = (0..BAYS).flat_map(|i| [(i, -1.0), (i, 1.0)]).flat_map(bay);
    let ends = [-half_length, half_length].into_iter().flat_map(|x| [(x, -1.0), (x, 1.0)]).map(gable);
    bays.chain(ends).collect()
}

/// Builds bars along the edges of all panes, one where two panes meet.
fn frame(panes: &[[DVec3; 4]]) -> Mesh {
    let mut frame = empty("frame", [0.85, 0.85, 0.82]);
    let mut edges: Vec<[DVec3; 2]> = vec![];
    for [a, b, c, d] in panes.iter().copied() {
        for [from, to] in [[a, b], [b, c], [c, d], [d, a]] {
            if !edges.contains(&[from, to]) && !edges.contains(&[to, from]) {
                edges.push([from, to]);
            }
        }
    }
    edges.iter().for_each(|ends| tube(&mut frame, &ends.map(|end| (end, BAR_WORLD)), 4));
    frame
}

/// Builds the panes of one alpha.
fn glass(group: usize, is_colored: bool, panes: &[[DVec3; 4]]) -> Mesh {
    let mut mesh = empty("glass", [0.8; 3]);
    // Twice as many steps as panes, so that neighbours differ.
    for (_, corners) in panes.iter().enumerate().filter(|(i, _)| 2 * i % ALPHAS.len() == group) {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(|corner| corner.as_vec3().to_array()));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let extinction_ratio = if is_colored { COLORS[group] } else { Scene::GREY };
    let alpha = Alpha::constant(AlphaMode::SeeThrough, ALPHAS[group], mesh.positions.len());
    let alpha = Alpha { extinction_ratio, ..alpha };
    Mesh { alpha: Some(alpha), ..mesh }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Side, sides};

    fn scene() -> Scene {
        glasshouse("glasshouse", false).expect("the time is in range")
    }

    /// Four panes have each alpha, and only panes have any.
    #[test]
    fn panes_have_five_alphas() {
        let scene = scene();
        let panes: Vec<_> = scene.meshes.iter().filter(|mesh| mesh.alpha.is_some()).collect();
        assert_eq!((scene.meshes.len(), panes.len()), (7, ALPHAS.len()));
        for (mesh, expected) in panes.iter().zip(ALPHAS) {
            let alpha = mesh.alpha.as_ref().expect("a pane");
            assert_eq!((mesh.triangles.len(), alpha.factors.len(), alpha.mode), (8, 16, AlphaMode::SeeThrough));
            assert!(alpha.factors.iter().all(|factor| *factor == expected));
            assert!(alpha.uvs.is_empty() && alpha.texture.is_none());
        }
    }

    /// The corners of a pane lie in a plane, and no two panes coincide.
    #[test]
    fn panes_are_flat() {
        let panes = panes();
        assert_eq!(panes.len(), 20);
        for (i, [a, b, c, d]) in panes.iter().copied().enumerate() {
            assert!((b - a).cross(c - a).dot(d - a).abs() < 1e-12, "pane {i}");
            assert!((b - a).cross(c - a).length() > 0.5 && (c - a).cross(d - a).length() > 0.5, "pane {i}");
            let middle = |[a, b, c, d]: [DVec3; 4]| 0.25 * (a + b + c + d);
            let near = |other: &&[DVec3; 4]| (middle(**other) - middle(panes[i])).length() < 0.3;
            assert_eq!(panes.iter().filter(near).count(), 1, "pane {i}");
        }
    }

    #[test]
    fn bars_are_closed() {
        let frame = &scene().meshes[1];
        assert!(frame.triangles.len() > 400 && frame.alpha.is_none());
        assert!(sides(frame).iter().all(|side| *side == Side::Outward));
    }

    /// No particle touches a pane.
    #[test]
    fn the_smoke_is_inside() {
        let particles = scene().particles;
        assert_eq!(particles.len(), 1_600);
        let steep = (RIDGE_WORLD - EAVE_WORLD) / HALF_WORLD[1];
        for particle in particles {
            let ([x, y, z], radius) = (particle.position.map(f64::from), f64::from(particle.radius));
            assert!(x.abs() + radius < HALF_WORLD[0] && y.abs() + radius < HALF_WORLD[1], "{particle:?}");
            let roof = RIDGE_WORLD - steep * y.abs() - radius * (1.0 + steep * steep).sqrt();
            assert!(z < roof, "{particle:?}");
        }
    }

    /// Colored panes differ from grey ones in color alone, and each light then stands once per color.
    #[test]
    fn panes_have_colors() {
        let colored = glasshouse("glasshouse-colored", true).expect("the time is in range");
        let ratios: Vec<_> = colored.ink_ratios().skip(colored.first_sheet()).step_by(8).take(5).collect();
        assert_eq!((ratios, colored.lights.len(), colored.inks.len()), (COLORS.to_vec(), 3, 6));
        let mut grey = colored;
        grey.meshes.iter_mut().filter_map(|mesh| mesh.alpha.as_mut()).for_each(|a| a.extinction_ratio = Scene::GREY);
        assert_eq!(grey.meshes, scene().meshes);
    }

    #[test]
    fn the_same_house_each_time() {
        assert_eq!(scene().fingerprint(), scene().fingerprint());
    }
}
