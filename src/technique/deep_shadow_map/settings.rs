//! Settings of deep shadow maps.

use crate::technique::keys::{word_of, words};
use crate::technique::map_settings::map_settings;
use crate::technique::settings::{SIZE, Setting};

words! {
    /// How the lists of segments are built.
    pub enum BuildPath {
        /// By drawing the casters.
        TwoPass = "two-pass",
        /// Tile by tile, in compute shaders.
        Binned = "binned",
    }
}

words! {
    /// Which nodes are removed from a curve.
    pub enum Removal {
        /// Nodes whose removal keeps the curve within the error bound.
        Bound = "bound",
        /// Nodes whose removal hardly changes the area under the curve.
        Area = "area",
    }
}

words! {
    /// How nodes are stored.
    pub enum Storage {
        /// 8 bytes per node.
        Full = "full",
        /// 4 bytes per node.
        Packed = "packed",
    }
}

map_settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Maximum error of a curve at any depth or, with [`Removal::Area`], mean error, in ten-thousandths of the light: 1 to 5,000.
        /// Ignored if `bytes` is given.
        error: u32 = Setting::number(
            "100", 1, 5000, "ten-thousandths of the light by which a curve may be off at any depth; with removal=area, on average");
        /// Number of bytes that the curves of all maps may take, at least 1; the build finds the smallest error bound at which the curves
        /// fit. `None`: `error` decides.
        bytes: Option<u32> = Setting::auto_number(
            1, u32::MAX, "bytes that the curves of all maps may take: the least error is found that fits; auto: error= decides");
        /// Which nodes are removed from a curve. [`Removal::Bound`]: nodes whose removal keeps the curve within the error bound.
        /// [`Removal::Area`], as in AVSM: nodes whose removal changes the area under the curve by no more than four times the square of the
        /// error; this leaves fewer nodes for the same mean error. `None`: by area if `bytes` is given, else by bound.
        removal: Option<Removal> = Setting::auto(
            "remove nodes that a curve stays within error= without, or that change its area by 4 error²; auto: bound, with bytes= area");
        /// How nodes are stored.
        storage: Storage = Setting::word("full", "full: 8 bytes per node; packed: 4");
        /// How the lists of segments are built. `None`: tile by tile, or drawn on software devices.
        path: Option<BuildPath> = Setting::auto(
            "lists of segments are drawn, or made tile by tile; auto: binned, on software devices two-pass");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
    }
}

impl Settings {
    /// Returns which nodes are removed, with `None` resolved.
    pub(super) fn removal(&self) -> Removal {
        let usual = if self.bytes.is_some() { Removal::Area } else { Removal::Bound };
        self.removal.unwrap_or(usual)
    }

    /// Returns whether nodes are stored as codes.
    pub(super) fn is_packed(&self) -> bool {
        self.storage == Storage::Packed
    }

    /// Returns the setting `error`, as a fraction of the light.
    pub(super) fn error(&self) -> f32 {
        self.error as f32 / 1e4
    }
}

impl BuildPath {
    /// Returns the path's name in specs.
    pub(super) fn name(self) -> &'static str {
        word_of(self)
    }
}
