//! Small scenes that make the cases a shadow technique goes wrong at.

use glam::DVec3;
use gobo::scene::{Camera, Light, LightKind, Mesh, Particle, Scene};
use rand::Rng;
use rand_pcg::Pcg32;

/// A scene of these particles under a directional light.
pub fn directional(name: &str, direction: [f64; 3], particles: Vec<Particle>) -> Scene {
    Scene {
        name: name.into(),
        particles,
        meshes: Vec::new(),
        light: Light {
            kind: LightKind::Directional { direction: DVec3::from(direction).normalize() },
            radiance: [1.0; 3],
        },
        camera: Camera { position: DVec3::new(4.0, -5.0, 3.0), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
    }
}

/// The same under a spot light at `position` that looks at the origin.
pub fn spot(position: [f64; 3], cone_degrees: f64, scene: Scene) -> Scene {
    let position = DVec3::from(position);
    let kind = LightKind::Spot { position, direction: -position.normalize(), cone_degrees };
    Scene { light: Light { kind, radiance: [1.0; 3] }, ..scene }
}

/// Numbers that are the same on every machine.
pub struct Random(Pcg32);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0x60b0))
    }

    pub fn bits(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// In [low, high].
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() as f32 / u32::MAX as f32)
    }

    pub fn point(&mut self, low: f32, high: f32) -> [f32; 3] {
        [(); 3].map(|()| self.between(low, high))
    }
}

/// Slanted against all axes, so that no coordinate drops out of the arithmetic.
const SLANTED: [f64; 3] = [0.5, 0.3, -0.81];

/// Spheres of many sizes, thin and dense, at random in a cube. One in eight has extinction 0.
pub fn random() -> Scene {
    let mut random = Random::new(1);
    let particles = (0..400)
        .map(|i| {
            let radius = random.between(0.05, 0.45);
            let depth = random.between(0.02, 0.8);
            let extinction = if i % 8 == 0 { 0.0 } else { depth / (2.0 * radius) };
            Particle { position: random.point(-1.0, 1.0), radius, extinction }
        })
        .collect();
    directional("random", SLANTED, particles)
}

/// Every sphere three times, two of them with the same extinction: equal entry depths everywhere.
pub fn duplicates() -> Scene {
    let mut random = Random::new(2);
    let mut particles = Vec::new();
    for _ in 0..24 {
        let first = Particle { position: random.point(-1.0, 1.0), radius: random.between(0.2, 0.6), extinction: 0.5 };
        particles.extend([first, Particle { extinction: 1.5, ..first }, first]);
    }
    directional("duplicates", SLANTED, particles)
}

/// Concentric spheres: every segment lies inside the one before. Listed from the inside out, so that index order is
/// the opposite of depth order.
pub fn nested() -> Scene {
    let mut random = Random::new(3);
    let mut particles = Vec::new();
    for _ in 0..6 {
        let position = random.point(-0.8, 0.8);
        let extinction = random.between(0.05, 0.5);
        particles.extend((1..=14).map(|i| Particle { position, radius: 0.06 * i as f32, extinction }));
    }
    directional("nested", SLANTED, particles)
}

/// Thin spheres, and among them some so dense that their optical depth is cut off at 80.
pub fn opaque() -> Scene {
    let mut random = Random::new(4);
    let particles = (0..90)
        .map(|i| Particle {
            position: random.point(-1.0, 1.0),
            radius: random.between(0.1, 0.35),
            extinction: if i % 9 == 0 { 1e6 } else { 0.4 },
        })
        .collect();
    directional("opaque", SLANTED, particles)
}

/// Hundreds of large thin spheres over each other: many more segments a texel than the list starts with.
pub fn crowd() -> Scene {
    let mut random = Random::new(5);
    let particles = (0..400)
        .map(|_| Particle {
            position: random.point(-0.7, 0.7),
            radius: random.between(0.5, 0.9),
            extinction: random.between(0.002, 0.02),
        })
        .collect();
    directional("crowd", SLANTED, particles)
}

/// A flat quad, two triangles, facing any way.
pub fn quad(corners: [[f32; 3]; 4], albedo: f32) -> Mesh {
    Mesh {
        name: "quad".into(),
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [albedo; 3],
    }
}

/// A square at `height` of half side `half` about (x, y).
pub fn level(height: f32, half: f32, [x, y]: [f32; 2]) -> Mesh {
    let corner = |dx: f32, dy: f32| [x + dx * half, y + dy * half, height];
    quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], 0.6)
}
