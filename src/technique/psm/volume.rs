//! Layout of a volume, as set by the settings. Twin: glsl/technique/psm/constants.glsl.

use super::Settings;
use crate::Result;
use crate::gpu::{Blend, Border, Constants, Context, Format, Image};
use crate::maps::{Filter, TILE_TEXELS};
use crate::shaders::constant::{ADDITIVE, COVERAGE, LAYERS, SLICES, SPLIT};
use crate::technique::keys::words;
use crate::world::World;

words! {
    /// What the volume holds.
    pub enum Storage {
        /// Transmittances in 8 bits.
        Rgba8 = "rgba8",
        /// Transmittances in half floats.
        Rgba16f = "rgba16f",
        /// Fraction of light lost, computed from sums of optical depths, in half floats.
        OpticalDepth = "optical-depth",
    }
}

words! {
    /// Which slices a caster is added to.
    pub enum Assign {
        /// The slice of its centre.
        Nearest = "nearest",
        /// The two slices around its centre.
        Split = "split",
    }
}

words! {
    /// How rays without casters are found. Twins: COVERAGE_OFF and so on.
    pub enum Coverage {
        /// Not at all: the last pass covers all rays.
        Off = "off",
        /// From a second viewport.
        Viewport = "viewport",
        /// From the bins.
        Tiles = "tiles",
    }
}

/// The layout of a volume.
#[derive(Clone, Copy, Debug)]
pub struct Volume {
    /// Texels per side of a map.
    pub size: u32,
    pub slices: u32,
    pub storage: Storage,
    pub split: bool,
    pub coverage: Coverage,
    pub filter: Filter,
}

impl Volume {
    /// Returns the layout for the settings.
    pub fn of(settings: &Settings) -> Self {
        let Settings { size, slices, storage, assign, coverage, .. } = *settings;
        Self { size, slices, storage, split: assign == Assign::Split, coverage, filter: settings.filter() }
    }

    /// Returns whether optical depths are added.
    fn additive(&self) -> bool {
        self.storage == Storage::OpticalDepth
    }

    /// Returns whether channels have 8 bits, not 16.
    pub fn is_8_bit(&self) -> bool {
        self.storage == Storage::Rgba8
    }

    /// Returns the image's format.
    pub fn format(&self) -> Format {
        if self.is_8_bit() { Format::R8G8B8A8_UNORM } else { Format::R16G16B16A16_SFLOAT }
    }

    /// Returns how a caster is blended with earlier casters.
    pub fn blend(&self) -> Blend {
        if self.additive() { Blend::Add } else { Blend::Multiply }
    }

    /// Returns the value of an empty slice, and the border that a sampler reads past the edge.
    pub fn empty(&self) -> (f32, Border) {
        if self.additive() { (0.0, Border::Zero) } else { (1.0, Border::One) }
    }

    /// Returns the number of layers per map.
    pub fn layers(&self) -> u32 {
        self.slices / 4 + u32::from(self.coverage == Coverage::Viewport)
    }

    /// Creates the image for `maps` maps. `drawn`: whether it is a render target.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the image is larger than the device allows.
    pub fn image(&self, context: &Context, maps: u32, drawn: bool) -> Result<Image> {
        let size = [self.size, self.size, maps.saturating_mul(self.layers())];
        Image::volume(context, "psm.volume", self.format(), size, drawn)
    }

    /// Returns the specialization constants of the volume and of the filter.
    pub fn constants(&self, world: &World) -> Constants {
        let constants = Constants::new()
            .set(SLICES, self.slices)
            .set(SPLIT, self.split)
            .set(ADDITIVE, self.additive())
            .set(LAYERS, self.layers())
            .set(COVERAGE, self.coverage as u32);
        self.filter.constants(constants.and(&world.constants()))
    }

    /// Returns the viewports of the slices and, if it is drawn, of the coverage, which has one texel per tile.
    pub fn viewports(&self) -> Vec<u32> {
        let all = [self.size, self.size.div_ceil(TILE_TEXELS)];
        all[..if self.coverage == Coverage::Viewport { 2 } else { 1 }].to_vec()
    }
}
