//! What a scene that moves has at other times.

use glam::DVec3;

/// What a scene has at most, over all times. A [`crate::world::World`] made from it has room for as much, and states that come later fit. Numbers
/// below what the scene has now do not count, so a scene that does not move leaves them at their default, 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reserve {
    /// The most particles.
    pub particles: usize,
    /// The most cells of all volumes together.
    pub cells: usize,
    /// The most blocks of each volume's field.
    pub blocks: Vec<usize>,
    /// The box that particles stay in, where passes on the device move them: views are fitted to it instead of to the particles.
    pub stay_in: Option<ParticleBox>,
}

/// A box that holds the middles of particles at all times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleBox {
    /// Low corner, world units.
    pub low: [f32; 3],
    /// High corner, world units.
    pub high: [f32; 3],
    /// The largest particle's radius, world units.
    pub radius: f32,
}

impl ParticleBox {
    /// Spheres at the corners: all particles lie in their convex hull.
    pub(in crate::scene) fn corners(self) -> impl Iterator<Item = (DVec3, f64)> {
        let end =
            move |i: usize, axis: usize| f64::from(if i >> axis & 1 == 1 { self.high[axis] } else { self.low[axis] });
        (0..8).map(move |i| (DVec3::new(end(i, 0), end(i, 1), end(i, 2)), f64::from(self.radius)))
    }
}
