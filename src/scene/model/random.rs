//! Random numbers for built-in scenes, identical on every machine.

use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg32;

/// A sequence of random numbers.
pub(crate) struct Random(Pcg32);

impl Random {
    /// Creates the sequence with this state and stream.
    pub(crate) fn new([state, stream]: [u64; 2]) -> Self {
        Self(Pcg32::new(state, stream))
    }

    /// Returns a number from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// Returns true with a probability of `share`.
    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    /// Returns a point that is uniformly distributed in the unit ball.
    pub(crate) fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if point.length_squared() <= 1.0 {
                return point;
            }
        }
    }
}
