//! The keys of AVSM's specs, and what they are read into.

use crate::maps::{DrawingOrder, Filter};
use crate::technique::Spec;
use crate::technique::keys::{FILTER, Key, OPAQUE, RADIUS, SIZE, SKIP, Switch, Values, Word, filter, words};

words! {
    /// How curves are built.
    pub enum Way {
        /// Lists, sorted and compressed.
        TwoPass = "two-pass",
        /// Fragment by fragment, under pixel interlock.
        Interlock = "interlock",
        /// Fragment by fragment, in ordered colour attachments.
        RasterOrder = "raster-order",
        /// Tile by tile, in compute shaders.
        Binned = "binned",
    }
}

words! {
    /// What is between two nodes a straight line.
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
        /// Where they fit best to all of it.
        Refined = "refined",
    }
}

words! {
    /// How nodes are stored.
    pub enum Storage {
        /// 8 bytes a node.
        Full = "full",
        /// 4 bytes a node, and 8 a texel.
        Packed = "packed",
        /// 2 bytes a node.
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
    pub enum Fineness {
        /// All alike.
        Even = "even",
        /// As fine as their casters need.
        Adaptive = "adaptive",
    }
}

words! {
    /// What a texel stands for.
    pub enum Stands {
        /// The ray through its centre.
        Centre = "centre",
        /// The mean of all rays through it.
        Area = "area",
    }
}

/// The keys.
pub const KEYS: &[Key] = &[
    Key { name: "nodes", values: Values::OneOf(&["4", "8", "16"]), default: "8", about: "nodes of a texel's curve" },
    Key {
        name: "curve",
        values: Values::OneOf(Interpolated::WORDS),
        default: "exponential",
        about: "interpolate transmittance (linear, as published) or optical depth (exponential)",
    },
    Key {
        name: "path",
        values: Values::OneOf(Way::WORDS),
        default: "auto",
        about: "auto: binned, save for what software devices do faster and for order=captured",
    },
    SIZE,
    Key {
        name: "detail",
        values: Values::OneOf(Fineness::WORDS),
        default: "even",
        about: "all of a map is as fine as size= says, or each tile from half to four times that, as it needs (binned)",
    },
    Key {
        name: "bytes",
        values: Values::Number(1, u32::MAX),
        default: "auto",
        about: "detail=adaptive: bytes that the curves of all maps may take; auto: those of detail=even",
    },
    Key {
        name: "texel",
        values: Values::OneOf(Stands::WORDS),
        default: "centre",
        about: "what a texel stands for: the ray through its centre, or the mean of all that it covers (binned)",
    },
    Key {
        name: "order",
        values: Values::OneOf(Order::WORDS),
        default: "sorted",
        about: "insert by depth (single-pass paths: casters drawn by depth) or as drawn",
    },
    Key {
        name: "resolve",
        values: Values::OneOf(Resolve::WORDS),
        default: "auto",
        about: "segment by segment, whole curves (two-pass, binned) or sums in cells (binned); auto chooses",
    },
    Key {
        name: "nudge",
        values: Values::OneOf(Switch::WORDS),
        default: "on",
        about: "keep the area under the curve when a node is removed (exponential only); off: as published",
    },
    Key {
        name: "fit",
        values: Values::OneOf(Fit::WORDS),
        default: "auto",
        about: "exponential: nodes on the curve, or moved to fit all of it (resolve=cells; two-pass whole); auto: refined for cells",
    },
    Key {
        name: "capacity",
        values: Values::Number(1, 1 << 28),
        default: "auto",
        about: "segments that the list holds (two-pass); auto grows to the demand",
    },
    Key {
        name: "storage",
        values: Values::OneOf(Storage::WORDS),
        default: "full",
        about: "full: 8 bytes a node; packed: 4, and 8 a texel; tight: 2",
    },
    Key {
        name: "batch",
        values: Values::OneOf(Batch::WORDS),
        default: "auto",
        about: "binned: casters stand in shared memory or in the lanes of subgroups; auto: lanes for hair and on software devices",
    },
    FILTER,
    RADIUS,
    OPAQUE,
];

/// What a spec says; none is `auto`.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub nodes: u32,
    /// Optical depth is interpolated.
    pub exponential: bool,
    pub way: Option<Way>,
    pub size: u32,
    /// Tiles are as fine as they need.
    pub adaptive: bool,
    /// With that, of the curves of all maps.
    pub bytes: Option<u32>,
    /// A texel stands for all that it covers.
    pub area: bool,
    pub sorted: bool,
    pub resolve: Option<Resolve>,
    pub nudge: bool,
    pub fit: Option<Fit>,
    pub skip: bool,
    pub capacity: Option<u32>,
    /// In codes.
    pub packed: bool,
    /// In the shortest.
    pub tight: bool,
    pub batch: Option<Batch>,
    pub filter: Filter,
}

impl Settings {
    pub fn of(spec: &Spec) -> Self {
        Self {
            nodes: spec.number("nodes"),
            exponential: spec.word("curve") != Some(Interpolated::Transmittance),
            way: spec.word("path"),
            size: spec.number(SIZE.name),
            adaptive: spec.word("detail") == Some(Fineness::Adaptive),
            bytes: Some(spec.number("bytes")).filter(|n| *n > 0),
            area: spec.word("texel") == Some(Stands::Area),
            sorted: spec.word("order") != Some(Order::Captured),
            resolve: spec.word("resolve"),
            nudge: spec.is_on("nudge"),
            fit: spec.word("fit"),
            skip: spec.is_on(SKIP.name),
            capacity: Some(spec.number("capacity")).filter(|n| *n > 0),
            packed: spec.word("storage") != Some(Storage::Full),
            tight: spec.word("storage") == Some(Storage::Tight),
            batch: spec.word("batch"),
            filter: filter(spec),
        }
    }
}

impl Settings {
    /// Texels a side of a map whose tiles are looked at: the coarsest that they may be.
    pub fn base_size(&self) -> u32 {
        if self.adaptive { self.size.div_ceil(2) } else { self.size }
    }

    /// Single-pass paths insert casters in the order in which they are drawn.
    pub fn drawing_order(&self) -> DrawingOrder {
        if self.sorted { DrawingOrder::NearToFar } else { DrawingOrder::Index }
    }
}

impl Way {
    /// Its word in specs.
    pub fn name(self) -> &'static str {
        <Self as Word>::ALL.iter().find(|(_, way)| *way == self).map_or("", |(word, _)| word)
    }
}
