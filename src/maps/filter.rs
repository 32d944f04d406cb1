//! Filters that average texels in a look-up, for all techniques with a map of texels. Twin: glsl/maps/filter.glsl.

use crate::gpu::Constants;
use crate::scene::gutter_texels;
use crate::shaders::constant::{FILTER, FILTER_RADIUS};
use crate::world::World;
use crate::{Error, Result};

/// How texels are weighted. Twins: FILTER_BILINEAR and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// The four texels around the position.
    Bilinear,
    /// Each texel weighted by the fraction of it that a square covers.
    Box,
    /// Each texel weighted by the fraction of it that a square covers, times a Gaussian.
    Gaussian,
}

/// A filter and its radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// How texels are weighted.
    pub kind: FilterKind,
    /// Radius in texels; unused by the bilinear filter.
    pub radius: u32,
}

impl Filter {
    /// Adds the constants of glsl/maps/filter.glsl.
    pub fn constants(self, constants: Constants) -> Constants {
        constants.set(FILTER, self.kind as u32).set(FILTER_RADIUS, self.radius)
    }

    /// Returns how far from a texel look-ups still read it, in texels: bilinear weights reach one texel.
    pub fn reach(self) -> u32 {
        1 + if self.kind == FilterKind::Bilinear { 0 } else { self.radius }
    }

    /// Checks that the filter fits into the margins of a point light's faces of `size` texels per side.
    ///
    /// # Errors
    /// [`Error::Input`] if the margins are too small for the filter.
    pub fn check(self, world: &World, size: u32) -> Result<()> {
        let bilinear = self.kind == FilterKind::Bilinear;
        // One texel more than the filter reaches, to allow for rounding.
        let needed = if bilinear { 1 } else { self.radius + 1 };
        if world.has_faces() && (size < 4 || needed > gutter_texels(size)) {
            let cause = "too small for this filter across the edges of a point light's faces";
            let least = if bilinear { 4 } else { 8 * needed };
            let way_out = format!("use a size of {least} or more, or a smaller radius");
            return Err(Error::input(format!("a map of size {size}"), cause, way_out));
        }
        Ok(())
    }
}
