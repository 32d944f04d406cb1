//! Settings of AVSM.

use crate::maps::DrawingOrder;
use crate::technique::keys::{word_of, words};
use crate::technique::map_settings::map_settings;
use crate::technique::settings::{LEVELS, SIZE, Setting};

words! {
    /// How curves are built.
    pub enum BuildPath {
        /// Lists, sorted and compressed.
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
    /// What a curve is made of.
    pub enum Resolve {
        /// Segment by segment.
        Streaming = "streaming",
        /// Compressed when all segments are in it.
        Whole = "whole",
        /// Sums in even cells.
        Cells = "cells",
    }
}

words! {
    /// Where nodes stand.
    pub enum Fit {
        /// On the curve that is compressed, save for nudging.
        Plain = "plain",
        /// At the places that fit the whole curve best.
        Refined = "refined",
    }
}

words! {
    /// How nodes are stored.
    pub enum Storage {
        /// 8 bytes per node.
        Full = "full",
        /// 4 bytes per node, and 8 per texel.
        Packed = "packed",
        /// 2 bytes per node.
        Tight = "tight",
    }
}

words! {
    /// Where a tile's casters stand while all texels look at them.
    pub enum Batch {
        /// In shared memory.
        Shared = "shared",
        /// In the lanes of subgroups.
        Lanes = "lanes",
    }
}

words! {
    /// How fine tiles of a map are.
    pub enum DetailMode {
        /// All alike.
        Even = "even",
        /// As fine as their casters need.
        Adaptive = "adaptive",
    }
}

words! {
    /// What a texel stands for.
    pub enum TexelSampling {
        /// The ray through its centre.
        Centre = "centre",
        /// The mean of all rays through it.
        Area = "area",
    }
}

map_settings! {
    /// The settings. Not all can be combined: [`super::Avsm::new`] refuses those that cannot.
    #[derive(Copy)]
    pub struct Settings {
        /// Nodes of a texel's curve: 4, 8 or 16. 8 bytes each, or fewer: see `storage`.
        nodes: u32 = Setting::one_of("8", &["4", "8", "16"], "nodes of a texel's curve");
        /// The quantity that is linear between two nodes: transmittance in Salvi et al. 2010, optical depth by default.
        curve: Interpolated = Setting::word(
            "exponential", "interpolate transmittance (linear, as published) or optical depth (exponential)");
        /// How curves are built; none: the fastest way on the device (docs/notebook/avsm-paths.md).
        path: Option<BuildPath> =
            Setting::auto("auto: binned, save for what software devices do faster and for order=captured");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// Whether every tile of a map has the resolution `size`, or each tile has its own, from half to four times `size`, as its casters
        /// need. The second works only with binned tiles and the bilinear filter.
        detail: DetailMode = Setting::word(
            "even", "all of a map is as fine as size= says, or each tile from half to four times that, as it needs (binned)");
        /// Bytes that the curves of all maps may take where `detail` is adaptive, 1 or more; none: as many as with even detail.
        bytes: Option<u32> = Setting::auto_number(
            1, u32::MAX, "detail=adaptive: bytes that the curves of all maps may take; auto: those of detail=even");
        /// What a texel stands for. [`TexelSampling::Area`] works only with binned tiles.
        texel: TexelSampling = Setting::word(
            "centre", "what a texel stands for: the ray through its centre, or the mean of all that it covers (binned)");
        /// Levels of detail, 1 to 12, the map itself included; each has half as many texels per side as the one before. Look-ups for
        /// pixels wider than a texel read the coarser levels. More than 1 is refused with adaptive detail.
        levels: u32 = LEVELS;
        /// The order of insertion. Binned tiles know only [`Order::Sorted`].
        order: Order =
            Setting::word("sorted", "insert by depth (single-pass paths: casters drawn by depth) or as drawn");
        /// What a curve is made of; none: sums in cells for binned tiles without hair, else segment by segment.
        resolve: Option<Resolve> = Setting::auto(
            "segment by segment, whole curves (two-pass, binned) or sums in cells (binned); auto chooses");
        /// With exponential curves, the area under the curve is kept when a node is removed; in Salvi et al. 2010 it is
        /// not.
        nudge: bool = Setting::word(
            "on", "keep the area under the curve when a node is removed (exponential only); off: as published");
        /// How the depths of nodes are chosen. [`Fit::Refined`] works for exponential curves that are made from cells, or on the two-pass
        /// path from whole curves. None: refined for exponential curves from cells, else not refined.
        fit: Option<Fit> = Setting::auto(
            "exponential: nodes on the curve, or moved to fit all of it (resolve=cells; two-pass whole); auto: refined for cells");
        /// Segments, over all texels, that the list of the two-pass path holds, 1 to 2^28; later ones are lost. None: the list grows.
        capacity: Option<u32> =
            Setting::auto_number(1, 1 << 28, "segments that the list holds (two-pass); auto grows to the demand");
        /// How nodes are stored. None: in full where `detail` is even. Where it is adaptive, tight for scenes with hair, and packed for
        /// other scenes, so that the bytes hold more texels.
        storage: Option<Storage> = Setting::auto(
            "full: 8 bytes per node; packed: 4, and 8 per texel; tight: 2; auto: full, or with detail=adaptive tight (hair) or packed");
        /// Where a tile's casters stand while all texels look at them. None: in lanes for hair and on software devices, else in shared
        /// memory.
        batch: Option<Batch> = Setting::auto(
            "binned: casters stand in shared memory or in the lanes of subgroups; auto: lanes for hair and on software devices");
    }
}

impl Settings {
    /// Optical depth is interpolated.
    pub(super) fn is_exponential(&self) -> bool {
        self.curve == Interpolated::OpticalDepth
    }

    /// Tiles are as fine as they need.
    pub(super) fn is_adaptive(&self) -> bool {
        self.detail == DetailMode::Adaptive
    }

    /// A texel stands for all that it covers.
    pub(super) fn is_of_areas(&self) -> bool {
        self.texel == TexelSampling::Area
    }

    /// Segments are inserted by depth.
    pub(super) fn is_sorted(&self) -> bool {
        self.order == Order::Sorted
    }

    /// How nodes are stored by default, with hair or without.
    pub(super) fn storage(&self, has_strands: bool) -> Storage {
        self.storage.unwrap_or(match (self.is_adaptive(), has_strands) {
            (false, _) => Storage::Full,
            (true, false) => Storage::Packed,
            (true, true) => Storage::Tight,
        })
    }

    /// Nodes are stored in codes.
    pub(super) fn is_packed(&self) -> bool {
        self.storage.is_some_and(|storage| storage != Storage::Full)
    }

    /// Nodes are stored in the shortest codes.
    pub(super) fn is_tight(&self) -> bool {
        self.storage == Some(Storage::Tight)
    }

    /// Texels per side of a map at its coarsest: adaptive tiles may have half the resolution of `size`.
    pub(super) fn base_size(&self) -> u32 {
        if self.is_adaptive() { self.size.div_ceil(2) } else { self.size }
    }

    /// The order in which casters are drawn: single-pass paths insert them in the same order.
    pub(super) fn drawing_order(&self) -> DrawingOrder {
        if self.is_sorted() { DrawingOrder::NearToFar } else { DrawingOrder::Index }
    }
}

impl BuildPath {
    /// Its word in specs.
    pub(super) fn name(self) -> &'static str {
        word_of(self)
    }
}
