//! How a volume is laid out. Twin: glsl/psm/constants.glsl.

use super::OPTICAL_DEPTH;
use crate::Result;
use crate::gpu::{Context, Format, Image};
use crate::technique::Spec;

/// Twins of the same names.
pub const COVERAGE_VIEWPORT: u32 = 1;
/// As above.
pub const COVERAGE_TILES: u32 = 2;

/// Rays a side of what coverage knows as one. Twin: the workgroup of glsl/psm/propagate.comp.
const TILE_TEXELS: u32 = 8;

/// What the keys of a spec make of a volume.
pub struct Volume {
    /// Texels a side of a map.
    pub size: u32,
    slices: u32,
    /// assign=split
    pub split: bool,
    /// Optical depths are added.
    pub additive: bool,
    /// COVERAGE.
    pub coverage: u32,
    /// Of the image.
    pub format: Format,
    /// Bits a channel.
    pub bits: u32,
}

impl Volume {
    /// What `spec` says.
    pub fn new(spec: &Spec) -> Self {
        let rgba8 = spec.value("storage") == "rgba8";
        Self {
            size: spec.number("size"),
            slices: spec.number("slices"),
            split: spec.value("assign") == "split",
            additive: spec.value("storage") == OPTICAL_DEPTH,
            coverage: match spec.value("coverage") {
                "viewport" => COVERAGE_VIEWPORT,
                "tiles" => COVERAGE_TILES,
                _ => 0,
            },
            format: if rgba8 { Format::R8G8B8A8_UNORM } else { Format::R16G16B16A16_SFLOAT },
            bits: if rgba8 { 8 } else { 16 },
        }
    }

    /// Layers of a map.
    fn layers(&self) -> u32 {
        self.slices / 4 + u32::from(self.coverage == COVERAGE_VIEWPORT)
    }

    /// The image for `maps` maps; whether it is drawn to.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where it is past the device's limits.
    pub fn image(&self, context: &Context, maps: u32, drawn: bool) -> Result<Image> {
        Image::volume(
            context,
            "psm.volume",
            self.format,
            [self.size, self.size, maps.saturating_mul(self.layers())],
            drawn,
        )
    }

    /// SLICES, SPLIT, ADDITIVE, LAYERS, COVERAGE, those of the filter, STRANDS.
    pub fn constants(&self, [filter, radius]: [u32; 2], strands: bool) -> [u32; 8] {
        let [split, additive, strands] = [self.split, self.additive, strands].map(u32::from);
        [self.slices, split, additive, self.layers(), self.coverage, filter, radius, strands]
    }

    /// Workgroups, tiles or coverage texels of a map.
    pub fn tiles(&self) -> [u32; 3] {
        let tiles = self.size.div_ceil(TILE_TEXELS);
        [tiles, tiles, 1]
    }

    /// Of the slices and, where it is drawn, of the coverage, a texel for each tile.
    pub fn viewports(&self) -> Vec<u32> {
        let all = [self.size, self.size.div_ceil(TILE_TEXELS)];
        all[..if self.coverage == COVERAGE_VIEWPORT { 2 } else { 1 }].to_vec()
    }
}
