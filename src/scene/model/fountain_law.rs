//! Constants of the motion of `fountain`'s particles: numbers that the device and its twin read alike, in world units
//! and steps.

use crate::scene::model::time::wave;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Steps a second of the world's time.
const STEPS_PER_SECOND: f64 = 60.0;

/// Particles up to whose number each is as large and as dense as it gets.
const FEW: f64 = 1024.0;

/// A particle as the device keeps it. Twin: Body in glsl/simulate/body.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// Its middle, and its radius at the end.
    pub place: [f32; 4],
    /// Its speed along each axis, a step; and its extinction at the end.
    pub speed: [f32; 4],
}

/// Where particles are born. Twin: Jet in glsl/simulate/law.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Jet {
    /// The middle of a cube.
    pub position: [f32; 3],
    /// The cube's side.
    pub width: f32,
    /// Speed of a particle, per step.
    pub speed: [f32; 3],
    /// By how much more or less along each axis at most.
    pub spread: f32,
}

/// What holds for all particles. Twin: Law in glsl/simulate/law.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Law {
    /// The box that particles stay in, by their middles.
    pub low: [f32; 3],
    /// Its other corner.
    pub high: [f32; 3],
    /// Speed lost along z.
    pub gravity: f32,
    /// The share of its speed that a particle keeps in a step.
    pub drag: f32,
    /// Speed won for each unit of the way to the attractor, right at it.
    pub pull: f32,
    /// 1 over the square of how far it reaches.
    pub reach: f32,
    /// The share of its speed that a particle keeps across what it hits, turned round; and along it.
    pub bounce: f32,
    /// Along it.
    pub slide: f32,
    /// Less speed than this along an axis is none.
    pub rest: f32,
    /// More there never is.
    pub fastest: f32,
    /// Radius of the largest particle.
    pub radius: f32,
    /// Extinction of a particle in the middle of its life.
    pub extinction: f32,
    /// 1 over the steps in which a particle appears, and in which it goes.
    pub appear: f32,
    /// In which it goes.
    pub vanish: f32,
    /// Steps from a particle's birth to its next.
    pub life: u32,
}

/// Where a grid stands. Twin: Grid in glsl/grid/grid.glsl.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its corner, world units.
    pub origin: [f32; 3],
    /// A voxel's side, world units.
    pub voxel: f32,
    /// Voxels per world unit.
    pub per_unit: f32,
    /// Voxels per side.
    pub size: u32,
}

/// So many particles that jump, fall and are drawn about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fountain {
    /// How many, from 1 to 4,000,000.
    pub particles: u32,
    /// Where the attractor stands; none where it wanders.
    pub attractor: Option<[f32; 3]>,
    /// Gravity, so many times that of the earth, 0 to [`MOST_GRAVITY`].
    pub gravity: f32,
}

/// So many times the earth's: more would be faster than particles get.
pub const MOST_GRAVITY: f64 = 10.0;

impl Fountain {
    /// So many particles, under the earth's gravity, with an attractor that wanders.
    pub fn new(particles: u32) -> Self {
        Self { particles, attractor: None, gravity: 1.0 }
    }

    /// The constants that move them. The more particles there are the smaller they are, so that all together take as
    /// much light.
    pub fn law(&self) -> Law {
        // Its fourth root, of which every machine makes the same.
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

    /// Corners of the box: spheres in whose hull all particles lie, at any time.
    pub(in crate::scene) fn corners(&self) -> [(DVec3, f64); 8] {
        let law = self.law();
        let end = |i: usize, axis: usize| f64::from(if i >> axis & 1 == 1 { law.high[axis] } else { law.low[axis] });
        std::array::from_fn(|i| (DVec3::new(end(i, 0), end(i, 1), end(i, 2)), f64::from(law.radius)))
    }

    /// Where they are born: each in any of these alike, so that the one in the middle has half of them.
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

    /// Where the attractor is at a step.
    pub fn attractor(&self, step: u32) -> [f32; 3] {
        if let Some(stands) = self.attractor {
            return stands;
        }
        let turn = |period_s: f64, phase: f64| wave(f64::from(step) / (period_s * STEPS_PER_SECOND) + phase);
        let at = DVec3::new(1.9 * turn(5.3, 0.0), 1.9 * turn(5.3, 0.25), 2.2 + 0.8 * turn(3.1, 0.4));
        at.as_vec3().to_array()
    }

    /// The step that a time is nearest to. The first has as many before it as a particle lives, so that the fountain has always
    /// been running.
    pub fn step_at(&self, time_s: f64) -> u32 {
        self.law().life + (time_s * STEPS_PER_SECOND).round() as u32
    }

    /// The grid of the things that particles bounce off. It is given and not fitted: the twin has it to the bit.
    pub fn place(&self) -> Place {
        // The ground, z = 0, runs through the middle of voxels.
        Place { origin: [-4.0, -4.0, -1.031_25], voxel: 0.0625, per_unit: 16.0, size: 128 }
    }
}
