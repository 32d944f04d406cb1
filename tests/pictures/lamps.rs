//! Houses among lamps.

use crate::support::scenes::{Random, cuboid, directional, level, quad};
use glam::DVec3;
use gobo::scene::{Camera, Light, LightKind, Particle, Scene};

/// A lamp with infinite reach.
pub fn lamp(position: [f64; 3]) -> Light {
    Light { kind: LightKind::Point { position: position.into() }, radiance: [1.0; 3], radius: f64::INFINITY }
}

/// Houses, and a roof on posts, on a ground under `count` lamps of different reach and color; the horizon is in the picture.
pub fn lamps(count: usize) -> Scene {
    let mut scene = directional("lamps", [0.0, 0.0, -1.0], Vec::new());
    scene.meshes = vec![level(0.0, 6.0, [0.0, 0.0])];
    let mut random = Random::new(31);
    for _ in 0..14 {
        let [x, y, _] = random.point(-3.0, 3.0);
        let [w, d, h] = random.point(0.15, 0.6);
        scene.meshes.push(cuboid([x - w, y - d, -0.01], [x + w, y + d, 1.5 * h]));
    }
    let roof = [[-1.0, -2.6, 0.7], [0.6, -2.8, 0.9], [0.6, -1.6, 0.9], [-1.0, -1.5, 0.7]];
    scene.meshes.push(quad(roof, 0.6));
    scene.lights = (0..count)
        .map(|_| {
            let [x, y, z] = random.point(-3.5, 3.5).map(f64::from);
            let radiance = [(); 3].map(|()| random.between(0.2, 1.5));
            let radius = f64::from(random.between(0.4, 1.8));
            Light { radius, radiance, ..lamp([x, y, 0.1 + 0.3 * z.abs()]) }
        })
        .collect();
    let position = DVec3::new(0.5, -5.5, 2.2);
    scene.camera = Camera { position, target: DVec3::new(0.0, 0.0, 0.6), up: DVec3::Z, fov_y_degrees: 50.0 };
    scene.name = format!("lamps-{count}");
    scene
}

/// A light of each kind, lights whose reach ends near or contains the camera, and some that reach nothing visible.
pub fn kinds() -> Scene {
    let mut scene = lamps(3);
    let aimed = |position: [f64; 3], target: [f64; 3], cone_degrees: f64, radius: f64| {
        let (position, target) = (DVec3::from(position), DVec3::from(target));
        let kind = LightKind::Spot { position, direction: (target - position).normalize(), cone_degrees };
        Light { kind, radiance: [0.9, 0.7, 0.3], radius }
    };
    let sun = LightKind::Directional { direction: DVec3::new(0.3, 0.5, -0.8).normalize() };
    let eye = scene.camera.position.to_array();
    scene.lights.extend([
        Light { kind: sun, radiance: [0.4, 0.3, 0.2], radius: f64::INFINITY },
        aimed([2.0, -2.0, 3.0], [0.0, 0.0, 0.0], 50.0, f64::INFINITY),
        aimed([-2.0, -1.0, 1.5], [0.0, -1.0, 0.0], 70.0, 2.5),
        Light { radius: 3.5, ..lamp(eye) },
        Light { radius: 1.0, ..lamp([eye[0], eye[1] - 3.0, eye[2]]) },
        Light { radius: 0.5, ..lamp([0.0, 40.0, 1.0]) },
        Light { radius: 4.0, ..lamp([-3.0, 1.0, 2.0]) },
    ]);
    scene.name = "kinds".into();
    scene
}

/// A ground under smoke, lit only by the sun and a lamp, seen from above.
pub fn smoke() -> Scene {
    let mut scene = directional("smoke", [0.2, 0.1, -1.0], Vec::new());
    let mut random = Random::new(5);
    scene.particles = (0..60)
        .map(|_| {
            let [x, y, z] = random.point(-1.5, 1.5);
            Particle { position: [x, y, 3.5 + 0.3 * z], radius: random.between(0.4, 0.8), extinction: 0.5 }
        })
        .collect();
    scene.meshes = vec![level(0.0, 8.0, [0.0, 0.0])];
    scene.lights[0].radiance = [0.6; 3];
    scene.lights.push(lamp([0.5, 0.0, 6.0]));
    // The camera is below the smoke, so that it sees none.
    let camera =
        Camera { position: DVec3::new(0.0, -3.5, 1.8), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 60.0 };
    Scene { camera, ..scene }
}

/// Only sky: everything lies behind the camera.
fn sky() -> Scene {
    let mut scene = lamps(5);
    scene.camera.target = scene.camera.position + DVec3::new(0.0, -1.0, 3.0);
    scene.name = "sky".into();
    scene
}

/// Scenes and picture sizes: few lights and more than fit in a word, clipped tiles, a single pixel.
pub fn all() -> Vec<(Scene, [u32; 2])> {
    let mut none = lamps(1);
    none.lights.clear();
    none.name = "none".into();
    vec![
        (lamps(40), [96, 54]),
        (kinds(), [96, 54]),
        (lamps(1), [33, 17]),
        (lamps(33), [1, 1]),
        (lamps(64), [16, 16]),
        (none, [20, 20]),
        (sky(), [31, 15]),
    ]
}
