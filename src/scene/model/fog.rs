//! Fog: a medium that fills the scene.

use crate::{Error, Result};

/// A homogeneous medium that absorbs nothing: all light that it removes from a ray is scattered evenly in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// Extinction σ, in 1 / world unit.
    pub extinction: f32,
    /// Number of equal steps along each camera ray.
    pub steps: u32,
}

impl Fog {
    /// Creates fog of the given extinction, marched in `steps` steps.
    ///
    /// # Errors
    /// [`Error::Input`] if the extinction is negative or not finite, or `steps` is 0.
    pub fn new(extinction: f32, steps: u32) -> Result<Self> {
        if !(extinction >= 0.0 && extinction.is_finite()) {
            let way_out = "give an extinction from 0 on, 1 / world unit";
            return Err(Error::input(format!("an extinction of {extinction}"), "no fog has it", way_out));
        }
        if steps == 0 {
            return Err(Error::input("0 steps", "nothing would be seen of the fog", "give 1 or more"));
        }
        Ok(Self { extinction, steps })
    }
}
