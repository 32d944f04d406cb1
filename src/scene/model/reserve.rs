//! Upper bounds of an animated scene, over all times.

use glam::DVec3;

/// Upper bounds of a scene over all times. A [`crate::world::World`] created from the scene reserves these capacities, so that later states
/// fit. Numbers below the scene's current ones have no effect, so a static scene leaves them at their default, 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reserve {
    /// The largest number of particles.
    pub particles: usize,
    /// The largest number of cells of all volumes together.
    pub cells: usize,
    /// The largest number of blocks in each volume's field.
    pub blocks: Vec<usize>,
    /// The box that particles stay in if passes on the device move them; views are fitted to it instead of to the particles.
    pub stay_in: Option<ParticleBox>,
}

/// A box that contains the centres of particles at all times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleBox {
    /// Low corner, in world units.
    pub low: [f32; 3],
    /// High corner, in world units.
    pub high: [f32; 3],
    /// The largest particle's radius, in world units.
    pub radius: f32,
}

impl ParticleBox {
    /// Returns spheres at the corners, whose convex hull contains all particles.
    pub(in crate::scene) fn corners(self) -> impl Iterator<Item = (DVec3, f64)> {
        let end =
            move |i: usize, axis: usize| f64::from(if i >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] });
        (0..8).map(move |i| (DVec3::new(end(i, 0), end(i, 1), end(i, 2)), f64::from(self.radius)))
    }
}
