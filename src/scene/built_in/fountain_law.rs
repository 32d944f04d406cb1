//! Constants of the motion of `fountain`'s particles, in world units and steps. The device and its twin read the same numbers.

use crate::scene::model::time::wave;
use crate::scene::{ParticleBox, Place, Reserve};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Simulation steps per second of the world's time.
const STEPS_PER_SECOND: f64 = 60.0;

/// Up to this number of particles, each has its maximum size and density; if there are more, they are smaller and thinner.
const FEW: f64 = 1024.0;

/// A source of particles. Twin: Jet in glsl/animate/simulate/law.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Jet {
    /// Centre of the cube in which particles are born.
    pub position: [f32; 3],
    /// Side of the cube.
    pub width: f32,
    /// Mean initial velocity of a particle, in world units per step.
    pub speed: [f32; 3],
    /// Maximum random change of the velocity along each axis.
    pub spread: f32,
}

/// Constants for all particles. Twin: Law in glsl/animate/simulate/law.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Law {
    /// Low corner of the box in which particle centres stay.
    pub low: [f32; 3],
    /// High corner of that box.
    pub high: [f32; 3],
    /// Change of velocity per step, downwards along −z.
    pub gravity: f32,
    /// Fraction of its velocity that a particle keeps per step.
    pub drag: f32,
    /// Velocity gained per step and unit of distance to the attractor, near the attractor.
    pub pull: f32,
    /// 1 over the square of the attractor's range.
    pub reach: f32,
    /// Fraction of its velocity with which a particle bounces back from a surface.
    pub bounce: f32,
    /// Fraction of its tangential velocity that a particle keeps when it hits a surface.
    pub slide: f32,
    /// Velocity components of a smaller magnitude become 0.
    pub rest: f32,
    /// Maximum velocity along an axis.
    pub fastest: f32,
    /// Radius of the largest particle.
    pub radius: f32,
    /// Extinction of a particle in the middle of its life.
    pub extinction: f32,
    /// 1 over the number of steps in which a new particle fades in.
    pub appear: f32,
    /// 1 over the number of steps in which an old particle fades out.
    pub vanish: f32,
    /// Number of steps from a particle's birth to its next birth.
    pub life: u32,
}

/// A fountain of particles that leap, fall and are pulled by an attractor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fountain {
    /// Number of particles, from 1 to 4,000,000.
    pub particles: u32,
    /// Fixed position of the attractor; None if it wanders.
    pub attractor: Option<[f32; 3]>,
    /// Gravity as a multiple of the earth's, 0 to [`MOST_GRAVITY`].
    pub gravity: f32,
}

/// The maximum gravity, as a multiple of the earth's. With more, particles would reach [`Law::fastest`].
pub const MOST_GRAVITY: f64 = 10.0;

impl Fountain {
    /// Creates a fountain of `particles` particles under the earth's gravity, with an attractor that wanders.
    pub fn new(particles: u32) -> Self {
        Self { particles, attractor: None, gravity: 1.0 }
    }

    /// Returns the constants of the motion. With more particles, each is smaller, so that in total they absorb the same amount of light.
    pub fn law(&self) -> Law {
        // A fourth root as two square roots, which give the same bits on every machine.
        let share = (FEW / f64::from(self.particles)).min(1.0).sqrt().sqrt();
        Law {
            low: [-3.75, -3.75, 0.125],
            high: [3.75, 3.75, 6.5],
            // 9.8 units / s², at STEPS_PER_SECOND.
            gravity: 0.002_725 * self.gravity,
            drag: 0.995,
            pull: 0.012,
            reach: 0.4,
            bounce: 0.4,
            slide: 0.85,
            rest: 1.0 / 1_048_576.0,
            fastest: 0.125,
            radius: (0.12 * share) as f32,
            extinction: (2.4 * share) as f32,
            appear: 0.125,
            vanish: 1.0 / 64.0,
            life: 240,
        }
    }

    /// Returns the upper bounds of a scene with this fountain.
    pub(in crate::scene) fn reserve(&self) -> Reserve {
        let law = self.law();
        let stay_in = Some(ParticleBox { low: law.low, high: law.high, radius: law.radius });
        Reserve { particles: self.particles as usize, stay_in, ..Reserve::default() }
    }

    /// Returns the jets at which particles are born, each with the same probability. Four entries are the same central jet, which thus
    /// emits half of the particles.
    pub fn jets(&self) -> [Jet; 8] {
        let middle = Jet { position: [0.0, 0.0, 1.85], width: 0.16, speed: [0.0, 0.0, 0.104], spread: 0.016 };
        let corner = |x: f32, y: f32| Jet {
            position: [2.6 * x, 2.6 * y, 0.4],
            width: 0.1,
            speed: [-0.032 * x, -0.032 * y, 0.088],
            spread: 0.008,
        };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        std::array::from_fn(|i| if i < 4 { middle } else { corners[i - 4] })
    }

    /// Returns the attractor's position at a step.
    pub fn attractor(&self, step: u32) -> [f32; 3] {
        if let Some(stands) = self.attractor {
            return stands;
        }
        let turn = |period_s: f64, phase: f64| wave(f64::from(step) / (period_s * STEPS_PER_SECOND) + phase);
        let at = DVec3::new(1.9 * turn(5.3, 0.0), 1.9 * turn(5.3, 0.25), 2.2 + 0.8 * turn(3.1, 0.4));
        at.as_vec3().to_array()
    }

    /// Returns the step nearest to a time. Time 0 is one particle lifetime after step 0, so that the fountain is already running then.
    pub fn step_at(&self, time_s: f64) -> u32 {
        self.law().life + (time_s * STEPS_PER_SECOND).round() as u32
    }

    /// Returns the grid of the meshes that particles bounce off. Its placement is constant, not fitted, so that the twin is bit-identical.
    pub fn place(&self) -> Place {
        // The ground, z = 0, runs through the middle of voxels.
        Place { origin: [-4.0, -4.0, -1.031_25], voxel: 0.0625, per_unit: 16.0, size: 128 }
    }
}
