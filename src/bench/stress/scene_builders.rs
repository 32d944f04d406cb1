//! Building blocks of cases: smoke at random places, lights, and a scene that contains them.

use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Random, Scene};
use glam::DVec3;

/// A light direction oblique to all axes, so that no component is 0.
pub(super) const SLANTED: DVec3 = DVec3::new(0.5, 0.3, -0.81);

/// Returns a scene of the given casters under one light.
pub(super) fn scene(kind: LightKind, particles: Vec<Particle>, meshes: Vec<Mesh>) -> Scene {
    Scene {
        name: "stress".into(),
        particles,
        meshes,
        lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }],
        camera: Camera { position: DVec3::new(4.0, -5.0, 3.0), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
        ..Scene::default()
    }
}

/// A directional light.
pub(super) fn along(direction: DVec3) -> LightKind {
    LightKind::Directional { direction: direction.normalize() }
}

/// Returns a spot light aimed at the origin.
pub(super) fn spot(position: DVec3, cone_degrees: f64) -> LightKind {
    LightKind::Spot { position, direction: -position.normalize(), cone_degrees }
}

/// A sphere.
pub(super) fn sphere(position: DVec3, radius: f64, extinction: f64) -> Particle {
    let finite = |number: f64| number.min(f32::MAX.into()) as f32;
    Particle { position: position.as_vec3().into(), radius: finite(radius), extinction: finite(extinction) }
}

/// Returns random numbers for a case, the same on every machine.
pub(super) fn random(stream: u64) -> Random {
    Random::new([0x57e55, stream])
}

/// Returns spheres of many sizes in the unit ball, each of which absorbs a tenth to two thirds of the light through its
/// centre.
pub(super) fn cloud(count: usize) -> Vec<Particle> {
    let mut random = random(1);
    let one = |_| {
        let (position, radius) = (random.in_ball(), random.between(0.08, 0.35));
        sphere(position, radius, random.between(0.1, 1.0) / (2.0 * radius))
    };
    (0..count).map(one).collect()
}

/// Number of spheres in cases that do not sweep this number.
pub(super) const USUAL: usize = 48;

/// Applies `change` to each sphere, together with its index.
pub(super) fn changed(mut particles: Vec<Particle>, change: impl Fn(usize, &Particle) -> Particle) -> Vec<Particle> {
    particles.iter_mut().enumerate().for_each(|(i, p)| *p = change(i, p));
    particles
}

/// Returns a sphere with `factor` times the extinction, clamped to the largest finite float.
pub(super) fn denser(particle: &Particle, factor: f64) -> Particle {
    let extinction = (f64::from(particle.extinction) * factor).min(f32::MAX.into()) as f32;
    Particle { extinction, ..*particle }
}

/// Returns spheres without extinction that make the light's view extend from −1 to 1 along all axes.
pub(super) fn corners() -> Vec<Particle> {
    [-0.9, 0.9].map(|at| sphere(DVec3::splat(at), 0.1, 0.0)).to_vec()
}

/// Moves all casters by `by`. Positions are rounded to floats.
pub(super) fn step(scene: &mut Scene, by: DVec3) {
    let step = |p: &mut [f32; 3]| *p = (DVec3::from(p.map(f64::from)) + by).as_vec3().into();
    scene.particles.iter_mut().for_each(|particle| step(&mut particle.position));
    scene.strands.iter_mut().for_each(|strand| [&mut strand.start, &mut strand.end].into_iter().for_each(step));
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(step);
}
