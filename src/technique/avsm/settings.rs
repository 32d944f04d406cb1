//! Settings of AVSM.

use crate::maps::DrawingOrder;
use crate::technique::keys::{word_of, words};
use crate::technique::map_settings::map_settings;
use crate::technique::settings::{LEVELS, SIZE, Setting};

words! {
    /// How curves are built.
    pub enum BuildPath {
        /// From lists, which are sorted and compressed.
        TwoPass = "two-pass",
        /// Fragment by fragment, under pixel interlock.
        Interlock = "interlock",
        /// Fragment by fragment, in ordered color attachments.
        RasterOrder = "raster-order",
        /// Tile by tile, in compute shaders.
        Binned = "binned",
    }
}

words! {
    /// The quantity that is linear between two nodes.
    pub enum Interpolated {
        /// Transmittance.
        Transmittance = "linear",
        /// Optical depth.
        OpticalDepth = "exponential",
    }
}

words! {
    /// The order of insertion.
    pub enum Order {
        /// By depth.
        Sorted = "sorted",
        /// As drawn.
        Captured = "captured",
    }
}

words! {
    /// How segments become a curve.
    pub enum Resolve {
        /// Inserted one by one.
        Streaming = "streaming",
        /// Compressed once the curve holds all of them.
        Whole = "whole",
        /// Summed in even cells.
        Cells = "cells",
    }
}

words! {
    /// Where nodes are placed.
    pub enum Fit {
        /// At nodes of the full curve, moved only to preserve its area (see `nudge`).
        Plain = "plain",
        /// At the positions that fit the whole curve best.
        Refined = "refined",
    }
}

words! {
    /// How nodes are stored.
    pub enum Storage {
        /// 8 bytes per node.
        Full = "full",
        /// 4 bytes per node, plus 8 per texel.
        Packed = "packed",
        /// 2 bytes per node.
        Tight = "tight",
    }
}

words! {
    /// Where a tile's casters are held while its texels are built.
    pub enum Batch {
        /// In shared memory.
        Shared = "shared",
        /// In the lanes of subgroups.
        Lanes = "lanes",
    }
}

words! {
    /// Resolution of a map's tiles.
    pub enum DetailMode {
        /// The same for all tiles.
        Even = "even",
        /// As fine as each tile's casters need.
        Adaptive = "adaptive",
    }
}

words! {
    /// What a texel represents.
    pub enum TexelSampling {
        /// The ray through its centre.
        Centre = "centre",
        /// The mean of all rays through it.
        Area = "area",
    }
}

map_settings! {
    /// Settings of AVSM. Not all of them can be combined: [`super::Avsm::new`] refuses the combinations that do not work.
    #[derive(Copy)]
    pub struct Settings {
        /// Number of nodes per curve: 4, 8 or 16. Each takes 8 bytes or fewer: see `storage`.
        nodes: u32 = Setting::one_of("8", &["4", "8", "16"], "nodes of a texel's curve");
        /// The quantity that is linear between two nodes: transmittance in Salvi et al. 2010, optical depth by default.
        curve: Interpolated = Setting::word(
            "exponential", "interpolate transmittance (linear, as published) or optical depth (exponential)");
        /// How curves are built. `None`: in the fastest way on the device (docs/notebook/avsm-paths.md).
        path: Option<BuildPath> =
            Setting::auto("auto: binned, save for what software devices do faster and for order=captured");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// Whether every tile of a map has the resolution `size`, or each tile has its own, from half to four times `size`, as its casters
        /// need. Adaptive detail requires binned tiles and the bilinear filter.
        detail: DetailMode = Setting::word(
            "even", "all of a map is as fine as size= says, or each tile from half to four times that, as it needs (binned)");
        /// Number of bytes that the curves of all maps may take with adaptive detail, at least 1. `None`: as many as with even detail.
        bytes: Option<u32> = Setting::auto_number(
            1, u32::MAX, "detail=adaptive: bytes that the curves of all maps may take; auto: those of detail=even");
        /// What a texel represents. [`TexelSampling::Area`] requires binned tiles.
        texel: TexelSampling = Setting::word(
            "centre", "what a texel stands for: the ray through its centre, or the mean of all that it covers (binned)");
        /// Number of levels of detail, 1 to 12, including the map itself; each has half as many texels per side as the one before. Look-ups
        /// for pixels wider than a texel read the coarser levels. More than 1 is refused with adaptive detail.
        levels: u32 = LEVELS;
        /// The order of insertion. Binned tiles support only [`Order::Sorted`].
        order: Order =
            Setting::word("sorted", "insert by depth (single-pass paths: casters drawn by depth) or as drawn");
        /// How segments become a curve. `None`: summed in cells for binned tiles without hair, else inserted one by one.
        resolve: Option<Resolve> = Setting::auto(
            "segment by segment, whole curves (two-pass, binned) or sums in cells (binned); auto chooses");
        /// Whether removing a node preserves the area under the curve, if the curve is exponential; in Salvi et al. 2010 it does not.
        nudge: bool = Setting::word(
            "on", "keep the area under the curve when a node is removed (exponential only); off: as published");
        /// How the depths of nodes are chosen. [`Fit::Refined`] works for exponential curves that are built from cells or, on the two-pass
        /// path, compressed whole. `None`: refined for exponential curves from cells, else plain.
        fit: Option<Fit> = Setting::auto(
            "exponential: nodes on the curve, or moved to fit all of it (resolve=cells; two-pass whole); auto: refined for cells");
        /// Number of segments, over all texels, that the list of the two-pass path holds, 1 to 2^28; later ones are lost. `None`: the list
        /// grows.
        capacity: Option<u32> =
            Setting::auto_number(1, 1 << 28, "segments that the list holds (two-pass); auto grows to the demand");
        /// How nodes are stored. `None`: in full with even detail. With adaptive detail, tight for scenes with hair and packed for other
        /// scenes, so that the bytes hold more texels.
        storage: Option<Storage> = Setting::auto(
            "full: 8 bytes per node; packed: 4, and 8 per texel; tight: 2; auto: full, or with detail=adaptive tight (hair) or packed");
        /// Where a tile's casters are held while its texels are built. `None`: in lanes for hair and on software devices, else in shared
        /// memory.
        batch: Option<Batch> = Setting::auto(
            "binned: casters stand in shared memory or in the lanes of subgroups; auto: lanes for hair and on software devices");
    }
}

impl Settings {
    /// Returns whether optical depth is interpolated.
    pub(super) fn is_exponential(&self) -> bool {
        self.curve == Interpolated::OpticalDepth
    }

    /// Returns whether tiles are as fine as their casters need.
    pub(super) fn is_adaptive(&self) -> bool {
        self.detail == DetailMode::Adaptive
    }

    /// Returns whether a texel represents the whole area that it covers.
    pub(super) fn is_of_areas(&self) -> bool {
        self.texel == TexelSampling::Area
    }

    /// Returns whether segments are inserted by depth.
    pub(super) fn is_sorted(&self) -> bool {
        self.order == Order::Sorted
    }

    /// Returns how nodes are stored, with the default resolved for scenes with or without hair.
    pub(super) fn storage(&self, has_strands: bool) -> Storage {
        self.storage.unwrap_or(match (self.is_adaptive(), has_strands) {
            (false, _) => Storage::Full,
            (true, false) => Storage::Packed,
            (true, true) => Storage::Tight,
        })
    }

    /// Returns whether nodes are stored as codes.
    pub(super) fn is_packed(&self) -> bool {
        self.storage.is_some_and(|storage| storage != Storage::Full)
    }

    /// Returns whether nodes are stored as the shortest codes.
    pub(super) fn is_tight(&self) -> bool {
        self.storage == Some(Storage::Tight)
    }

    /// Returns the number of texels per side of a map at its coarsest resolution: adaptive tiles may have half the resolution of `size`.
    pub(super) fn base_size(&self) -> u32 {
        if self.is_adaptive() { self.size.div_ceil(2) } else { self.size }
    }

    /// Returns the order in which casters are drawn, and in which single-pass paths insert them.
    pub(super) fn drawing_order(&self) -> DrawingOrder {
        if self.is_sorted() { DrawingOrder::NearToFar } else { DrawingOrder::Index }
    }
}

impl BuildPath {
    /// Returns the path's name in specs.
    pub(super) fn name(self) -> &'static str {
        word_of(self)
    }
}
