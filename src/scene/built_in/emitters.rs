//! The built-in scene `three-emitters`: two smoke plumes and a steam jet over a ground plane.
//!
//! A particle's path depends only on its emitter, its number and the time. So the scene at any time is computed from the particles alive
//! then, no matter how long the emitters have been running. Only operations with results fixed by IEEE 754 are used (no `sin`, no `exp`),
//! so the bytes are the same on every machine.

use crate::Result;
use crate::scene::model::time::{check_time, wave};
use crate::scene::{Camera, Light, LightKind, Mesh, Particle, Reserve, Scene};
use glam::{DVec2, DVec3};
use rand::Rng;
use rand_pcg::Pcg32;
use rayon::prelude::*;

/// The simulation's time step, in seconds. A particle takes whole steps from its birth and one shorter step at the end.
const STEP_S: f64 = 1.0 / 30.0;

/// Number of random numbers reserved for each particle, which is more than it draws.
const DRAWS_PER_PARTICLE: u64 = 16;

/// Half the side of the ground.
const GROUND_HALF_WORLD: f32 = 5.0;

/// A continuous emitter.
pub(in crate::scene) struct Emitter {
    /// State and stream of its random numbers.
    pub(in crate::scene) seed: [u64; 2],
    /// Number of particles alive at once, from `lifetime_s` on.
    pub(in crate::scene) capacity: u64,
    pub(in crate::scene) lifetime_s: f64,
    pub(in crate::scene) position: DVec3,
    /// Radius of the disc around `position` on which particles start.
    pub(in crate::scene) nozzle_radius_world: f64,
    /// Velocity at birth, in units / s.
    pub(in crate::scene) velocity: DVec3,
    /// Maximum random addition to `velocity`, in units / s.
    pub(in crate::scene) velocity_spread: f64,
    /// How fast the air carries a particle up, in units / s: hot at birth, cooled at the end of its life.
    pub(in crate::scene) rise: [f64; 2],
    /// How fast a particle adopts the air's velocity, in 1 / s.
    pub(in crate::scene) drag: f64,
    /// Speed of the swirling air, in units / s.
    pub(in crate::scene) swirl: f64,
    /// Maximum random sideways drift, in units / s: turbulence finer than the swirl, which widens the plume.
    pub(in crate::scene) drift: f64,
    /// Radius at birth and at the end of life.
    pub(in crate::scene) radius_world: [f64; 2],
    /// Optical depth across a particle's diameter where it is densest.
    pub(in crate::scene) optical_depth: f64,
}

/// Three emitters, as in Intel's AVSM sample: a plume (particles live 15 s), another plume (18 s) and a steam jet (6 s); 5,000 particles in
/// total.
const EMITTERS: [Emitter; 3] = [
    Emitter {
        seed: [0x5eed_0001, 11],
        capacity: 1_800,
        lifetime_s: 15.0,
        position: DVec3::new(-2.7, -1.3, 0.25),
        nozzle_radius_world: 0.25,
        velocity: DVec3::new(0.0, 0.0, 0.7),
        velocity_spread: 0.25,
        rise: [0.55, 0.22],
        drag: 1.5,
        swirl: 0.16,
        drift: 0.06,
        radius_world: [0.15, 0.5],
        optical_depth: 0.09,
    },
    Emitter {
        seed: [0x5eed_0002, 22],
        capacity: 2_000,
        lifetime_s: 18.0,
        position: DVec3::new(-0.3, 0.9, 0.25),
        nozzle_radius_world: 0.35,
        velocity: DVec3::new(0.0, 0.0, 0.5),
        velocity_spread: 0.25,
        rise: [0.45, 0.14],
        drag: 1.5,
        swirl: 0.16,
        drift: 0.07,
        radius_world: [0.18, 0.55],
        optical_depth: 0.09,
    },
    Emitter {
        seed: [0x5eed_0003, 33],
        capacity: 1_200,
        lifetime_s: 6.0,
        position: DVec3::new(4.0, -2.6, 0.35),
        nozzle_radius_world: 0.06,
        velocity: DVec3::new(-1.9, 0.3, 1.9),
        velocity_spread: 0.35,
        rise: [0.1, 0.2],
        drag: 0.75,
        swirl: 0.16,
        drift: 0.05,
        radius_world: [0.06, 0.42],
        optical_depth: 0.1,
    },
];

/// A mode of the swirling air: a wave of velocity that varies along `wave_vector` (periods / unit).
struct SwirlMode {
    wave_vector: DVec3,
    /// The cross product of the wave vector and this vector is the direction of the air.
    potential: DVec3,
    /// Temporal frequency, in periods / s.
    frequency: f64,
    /// Phase, in periods.
    phase: f64,
    /// Factor of the emitter's swirl.
    strength: f64,
}

/// A few modes with wavelengths from the size of the scene down to the size of a plume, incommensurable so that they do not repeat.
const SWIRL_MODES: [SwirlMode; 6] = [
    mode([0.11, 0.07, 0.13], [0.3, -0.8, 0.4], 0.031, 0.10, 1.0),
    mode([-0.09, 0.15, 0.08], [0.9, 0.2, 0.5], -0.043, 0.55, 1.0),
    mode([0.23, -0.12, 0.21], [-0.2, 0.7, 0.6], 0.071, 0.31, 0.8),
    mode([0.14, 0.27, -0.24], [0.6, 0.5, -0.4], -0.083, 0.83, 0.8),
    mode([-0.43, 0.31, 0.37], [0.5, -0.1, 0.9], 0.127, 0.47, 0.5),
    mode([0.38, 0.45, 0.52], [-0.7, 0.6, 0.1], -0.149, 0.69, 0.5),
];

const fn mode(wave_vector: [f64; 3], potential: [f64; 3], frequency: f64, phase: f64, strength: f64) -> SwirlMode {
    SwirlMode {
        wave_vector: DVec3::from_array(wave_vector),
        potential: DVec3::from_array(potential),
        frequency,
        phase,
        strength,
    }
}

/// Returns the particles of `emitters` after they have been running for `time_s` seconds; `scene` is the name used in messages.
///
/// # Errors
/// Same as [`check_time`].
pub(in crate::scene) fn smoke(scene: &str, emitters: &[Emitter], time_s: f64) -> Result<Vec<Particle>> {
    smoke_after(scene, emitters, time_s, &mut Smoke::default())
}

/// The state of particles after their last whole step, from which the next frame continues. The result is bit-identical to simulating each
/// particle from its birth.
#[derive(Clone, Debug, Default)]
pub struct Smoke(Vec<Traces>);

/// States of an emitter's particles, numbered from `first`.
#[derive(Clone, Debug, Default)]
struct Traces {
    first: u64,
    all: Vec<Trace>,
}

/// State of a particle after `steps` whole steps.
#[derive(Clone, Copy, Debug)]
struct Trace {
    drift: DVec2,
    rise_factor: f64,
    size_factor: f64,
    position: DVec3,
    velocity: DVec3,
    steps: u32,
}

/// Like [`smoke`], but continues from the states in `before`.
pub(in crate::scene) fn smoke_after(
    scene: &str,
    emitters: &[Emitter],
    time_s: f64,
    before: &mut Smoke,
) -> Result<Vec<Particle>> {
    check_time(scene, time_s)?;
    before.0.resize_with(emitters.len(), Traces::default);
    // The air's direction in each mode is perpendicular to the wave vector, so the air is divergence-free.
    let directions = SWIRL_MODES.map(|mode| {
        let direction = mode.wave_vector.cross(mode.potential).normalize_or_zero();
        (mode, direction)
    });
    let emitted = emitters.iter().zip(&mut before.0).flat_map(|(emitter, was)| emit(emitter, &directions, time_s, was));
    Ok(emitted.collect())
}

/// Builds the square ground plane at z = 0.
pub(in crate::scene) fn ground(half: f32) -> Mesh {
    Mesh {
        name: "ground".into(),
        positions: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        albedo: [0.6; 3],
        solid: false,
        alpha: None,
    }
}

/// Returns the smoke of `three-emitters` at a given time.
///
/// # Errors
/// Same as [`smoke`].
pub(crate) fn particles(time_s: f64, before: &mut Smoke) -> Result<Vec<Particle>> {
    smoke_after("three-emitters", &EMITTERS, time_s, before)
}

/// Returns the largest number of particles of these emitters that are alive at once.
pub(in crate::scene) const fn most(emitters: &[Emitter]) -> usize {
    let (mut sum, mut i) = (0, 0);
    while i < emitters.len() {
        sum += emitters[i].capacity as usize;
        i += 1;
    }
    sum
}

/// Builds the scene after the emitters have been running for `time_s` seconds, with units of about a metre, z up: 5,000 particles from 18 s
/// on. The light is slanted so that one plume's shadow falls on the other and on the ground.
///
/// # Errors
/// Same as [`smoke`].
pub(in crate::scene) fn three_emitters(time_s: f64) -> Result<Scene> {
    let particles = particles(time_s, &mut Smoke::default())?;
    Ok(Scene {
        name: "three-emitters".into(),
        reserve: Reserve { particles: most(&EMITTERS), ..Reserve::default() },
        particles,
        meshes: vec![ground(GROUND_HALF_WORLD)],
        lights: vec![Light {
            kind: LightKind::Directional { direction: DVec3::new(0.47, 0.3, -0.83).normalize() },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        }],
        camera: Camera {
            position: DVec3::new(3.5, -17.0, 8.5),
            target: DVec3::new(-0.2, 0.0, 2.6),
            up: DVec3::Z,
            fov_y_degrees: 33.0,
        },
        ..Scene::default()
    })
}

/// Returns the emitter's living particles, oldest first.
fn emit(emitter: &Emitter, modes: &[(SwirlMode, DVec3)], time_s: f64, was: &mut Traces) -> Vec<Particle> {
    let interval_s = emitter.lifetime_s / emitter.capacity as f64;
    let newest = (time_s / interval_s) as u64;
    let oldest = (newest + 1).saturating_sub(emitter.capacity);
    let before = std::mem::take(was);
    let living = (oldest..=newest).into_par_iter().map(|number| {
        let birth_s = number as f64 * interval_s;
        let age_s = (time_s - birth_s).max(0.0);
        let known = number.checked_sub(before.first).and_then(|at| before.all.get(at as usize));
        // If time moved backwards, the known state may be later than this frame. It can be used only if all its steps are whole steps at
        // this age too.
        let goes_on = |trace: &&Trace| trace.steps == 0 || age_s - f64::from(trace.steps - 1) * STEP_S >= STEP_S;
        let mut trace = known.filter(goes_on).copied().unwrap_or_else(|| born(emitter, number));
        let particle = go(emitter, modes, &mut trace, birth_s, age_s);
        (trace, particle)
    });
    let (all, particles) = living.unzip();
    *was = Traces { first: oldest, all };
    particles
}

/// Returns the state of particle `number` at its birth.
fn born(emitter: &Emitter, number: u64) -> Trace {
    let mut random = Pcg32::new(emitter.seed[0], emitter.seed[1]);
    random.advance(number * DRAWS_PER_PARTICLE);
    let mut fraction = || f64::from(random.next_u32()) / f64::from(u32::MAX);
    // The square root fills the disc uniformly.
    let start = direction(fraction()) * fraction().sqrt() * emitter.nozzle_radius_world;
    let kick = direction(fraction()) * fraction() * emitter.velocity_spread;
    let drift = direction(fraction()) * fraction() * emitter.drift;
    let rise_factor = 0.85 + 0.3 * fraction();
    let size_factor = 0.85 + 0.3 * fraction();

    let position = emitter.position + start.extend(0.0);
    Trace { drift, rise_factor, size_factor, position, velocity: emitter.velocity + kick.extend(0.0), steps: 0 }
}

/// Returns the particle `age_s` after its birth, and advances `trace` by the whole steps.
fn go(emitter: &Emitter, modes: &[(SwirlMode, DVec3)], trace: &mut Trace, birth_s: f64, age_s: f64) -> Particle {
    let Trace { drift, rise_factor, size_factor, mut position, mut velocity, steps } = *trace;
    for step in steps..(age_s / STEP_S).ceil() as u32 {
        let done_s = f64::from(step) * STEP_S;
        let step_s = STEP_S.min((age_s - done_s).max(0.0));
        let rise = mix(emitter.rise, done_s / emitter.lifetime_s) * rise_factor;
        // The air is calm at the nozzle.
        let swirl = swirl(modes, position, birth_s + done_s) * emitter.swirl * done_s.min(1.0);
        let air = drift.extend(rise) + swirl;
        // An implicit step, which is stable for any drag.
        velocity = (velocity + emitter.drag * step_s * air) / (1.0 + emitter.drag * step_s);
        position += velocity * step_s;
        if step_s == STEP_S && trace.steps == step {
            *trace = Trace { position, velocity, steps: step + 1, ..*trace };
        }
    }
    let age = (age_s / emitter.lifetime_s).min(1.0);
    let radius = mix(emitter.radius_world, age) * size_factor;
    // Fades in at the nozzle and out over the second half of life, so that no particle pops.
    let fade = smooth(age / 0.06) * smooth((1.0 - age) / 0.6);
    Particle {
        // Smoke may touch the ground but not sink into it.
        position: position.with_z(position.z.max(radius)).as_vec3().to_array(),
        radius: radius as f32,
        extinction: (emitter.optical_depth * fade / (2.0 * radius)) as f32,
    }
}

/// Returns the velocity of the swirling air, at most a few units / s. Any function of the phase alone is divergence-free if its direction
/// is perpendicular to the wave vector.
fn swirl(modes: &[(SwirlMode, DVec3)], position: DVec3, time_s: f64) -> DVec3 {
    let velocity = |(mode, direction): &(SwirlMode, DVec3)| {
        let periods = mode.wave_vector.dot(position) + mode.frequency * time_s + mode.phase;
        *direction * mode.strength * wave(periods)
    };
    modes.iter().map(velocity).sum()
}

/// Returns the unit vector `turn` full turns counter-clockwise from +x.
pub(in crate::scene) fn direction(turn: f64) -> DVec2 {
    DVec2::new(wave(turn + 0.25), wave(turn)).normalize_or_zero()
}

fn mix([from, to]: [f64; 2], fraction: f64) -> f64 {
    from + (to - from) * fraction
}

/// Returns 0 below 0, 1 above 1, and a smooth transition in between.
fn smooth(fraction: f64) -> f64 {
    let fraction = fraction.clamp(0.0, 1.0);
    fraction * fraction * (3.0 - 2.0 * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smoke that continues from earlier states must be bit-identical to smoke simulated from its birth: for frames of any length, for
    /// steps back in time, and after a leap.
    #[test]
    fn smoke_goes_on_as_it_began() {
        let mut before = Smoke::default();
        for time_s in
            [0.0, 0.02, 1.0 / 30.0, 0.1, 3.0, 3.0 + 1.0 / 30.0, 3.2, 3.2, 3.1, 1.0, 19.0, 19.0 + 2.0 / 30.0, 7.5]
        {
            let went_on = particles(time_s, &mut before).expect("a time");
            let bytes = |particles: &[Particle]| bytemuck::cast_slice::<_, u8>(particles).to_vec();
            assert_eq!(bytes(&went_on), bytes(&particles(time_s, &mut Smoke::default()).expect("a time")), "{time_s}");
        }
        let steps =
            |smoke: &Smoke| smoke.0.iter().flat_map(|of| &of.all).map(|trace| u64::from(trace.steps)).sum::<u64>();
        assert!(steps(&before) > 100 * 2000, "and keeps the steps that it took: {}", steps(&before));
    }
}
