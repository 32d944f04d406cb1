//! Settings of deep shadow maps.

use crate::technique::keys::{word_of, words};
use crate::technique::map_settings::map_settings;
use crate::technique::settings::{SIZE, Setting};

words! {
    /// How the lists of segments are made.
    pub enum BuildPath {
        /// Casters are drawn.
        TwoPass = "two-pass",
        /// Tile by tile, in compute shaders.
        Binned = "binned",
    }
}

words! {
    /// Which nodes are left out of a curve.
    pub enum Removal {
        /// Those without which the curve stays within the error.
        Bound = "bound",
        /// Those whose removal changes the area under the curve little.
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
    /// What there is to set.
    #[derive(Copy)]
    pub struct Settings {
        /// By how many ten-thousandths of the light a curve may be off at any depth, 1 to 5,000; ignored where `bytes` is given.
        error: u32 = Setting::number(
            "100", 1, 5000, "ten-thousandths of the light by which a curve may be off at any depth");
        /// Bytes that the curves of all maps may take, 1 or more; the build finds the least error that fits. None: `error` decides.
        bytes: Option<u32> = Setting::auto_number(
            1, u32::MAX, "bytes that the curves of all maps may take: the least error is found that fits; auto: error= decides");
        /// Which nodes are left out of a curve. [`Removal::Bound`]: nodes without which the curve stays within the error.
        /// [`Removal::Area`], as in AVSM: nodes whose removal changes the area under the curve by no more than four times the error's
        /// square; this needs fewer nodes for the same mean error. None: by area where `bytes` is given, else by bound.
        removal: Option<Removal> = Setting::auto(
            "remove nodes that a curve stays within error= without, or that change its area by 4 error²; auto: bound, with bytes= area");
        /// How nodes are stored.
        storage: Storage = Setting::word("full", "full: 8 bytes per node; packed: 4");
        /// How the lists of segments are made; none: tile by tile, or drawn on software devices.
        path: Option<BuildPath> = Setting::auto(
            "lists of segments are drawn, or made tile by tile; auto: binned, on software devices two-pass");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
    }
}

impl Settings {
    /// Which nodes are left out, with `None` decided.
    pub(super) fn removal(&self) -> Removal {
        let usual = if self.bytes.is_some() { Removal::Area } else { Removal::Bound };
        self.removal.unwrap_or(usual)
    }

    /// Nodes are stored in codes.
    pub(super) fn is_packed(&self) -> bool {
        self.storage == Storage::Packed
    }

    /// By how much of the light a curve may be off.
    pub(super) fn error(&self) -> f32 {
        self.error as f32 / 1e4
    }
}

impl BuildPath {
    /// Its word in specs.
    pub(super) fn name(self) -> &'static str {
        word_of(self)
    }
}
