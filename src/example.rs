// Shared by the examples in the documentation, each of which includes this file. It is not part of the crate.

use glam::DVec3;
use gobo::gpu::{Context, Options};
use gobo::scene::{Camera, Mesh, Particle, Scene};
use gobo::{Error, Result};

/// Runs an example. If there is no driver, or the device lacks a feature that the example needs, prints why.
#[allow(dead_code)]
pub fn on_a_device(example: impl FnOnce(&Context) -> Result<()>) {
    match Context::new(&Options::default()).and_then(|context| example(&context)) {
        Ok(()) => {}
        Err(error @ (Error::Refused(_) | Error::Gpu { operation: "load" | "create" | "find", .. })) => {
            println!("skipped: {error}");
        }
        Err(error) => panic!("{error}"),
    }
}

/// Returns a scene with one light from above and no casters.
pub fn empty() -> Scene {
    Scene {
        name: "example".into(),
        camera: Camera { position: DVec3::splat(4.0), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
        ..Scene::default()
    }
}

/// Returns a scene with a ball of smoke, one unit across, whose centre is one unit above the origin. It transmits
/// exp(−2) of the light through its centre.
#[allow(dead_code)]
pub fn smoke() -> Scene {
    Scene { particles: vec![Particle { position: [0.0, 0.0, 1.0], radius: 0.5, extinction: 2.0 }], ..empty() }
}

/// Returns a scene with an opaque box in place of the smoke.
#[allow(dead_code)]
pub fn solid() -> Scene {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 });
    let positions = (0..8).map(|i| corner(i)).map(|[x, y, z]| [x, y, z + 1.0]).collect();
    let sides: [[u32; 4]; 6] = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Scene { meshes: vec![Mesh { name: "box".into(), positions, triangles, albedo: [0.5; 3], solid: false, alpha: None }], ..empty() }
}
