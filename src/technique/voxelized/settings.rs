//! What a spec of voxelized shadows says.

use super::super::Spec;
use super::super::keys::{Key, PCF, Switch, Values, Word, word_of, words};
use crate::gpu::Constants;
use crate::shaders::constant;

words! {
    /// How nodes are kept.
    pub enum Structure {
        /// Sparse voxel octree: each node for itself, in whole words.
        Svo = "svo",
        /// Directed acyclic graph: equal nodes once, pointers of as many bits as they need.
        Dag = "dag",
    }
}

words! {
    /// Where the shadow of a column begins that may begin anywhere inside a closed thing.
    pub enum Free {
        /// Where light would leave the thing.
        Exit = "exit",
        /// Where it enters.
        Entry = "entry",
        /// At as few depths as the 8 × 8 columns of a block allow, as round ones as possible.
        Shared = "shared",
    }
}

words! {
    /// What a column of voxels is met by.
    pub enum Coverage {
        /// What covers its middle.
        Middle = "middle",
        /// What touches its square anywhere: nothing thin is lost.
        Conservative = "conservative",
    }
}

/// Voxels a side.
pub const SIZE: Key = Key {
    name: "size",
    values: Values::OneOf(&["64", "128", "256", "512", "1024", "2048", "4096", "8192", "16384", "32768", "65536"]),
    default: "1024",
    about: "voxels a side of the cube about the meshes",
};

/// Tree or graph.
pub const STRUCTURE: Key = Key {
    name: "structure",
    values: Values::OneOf(Structure::WORDS),
    default: "dag",
    about: "a tree, or a graph in which equal nodes are one",
};

/// Whether closed things have insides.
pub const CLOSED: Key = Key {
    name: "closed",
    values: Values::OneOf(Switch::WORDS),
    default: "on",
    about: "voxels inside closed and solid meshes are free, whatever merges best",
};

/// What free voxels are.
pub const FREE: Key = Key {
    name: "free",
    values: Values::OneOf(Free::WORDS),
    default: "shared",
    about: "where shadows begin inside closed things: at the exit, at the entry, or at depths that columns share",
};

/// What a column is met by.
pub const COVERAGE: Key = Key {
    name: "coverage",
    values: Values::OneOf(Coverage::WORDS),
    default: "middle",
    about: "what shadows a column of voxels: what covers its middle, or what touches its square anywhere",
};

/// A bake that was written before.
pub const FILE: Key = Key {
    name: "file",
    values: Values::Path(&[SIZE.name, STRUCTURE.name, CLOSED.name, FREE.name, COVERAGE.name]),
    default: "none",
    about: "what gobo bake wrote, in place of a bake; size, structure, closed, free and coverage are its own",
};

/// A spec, read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Voxels a side: a power of two from 64 to 65,536.
    pub size: u32,
    /// Tree or graph.
    pub structure: Structure,
    /// Closed things have insides.
    pub closed: bool,
    /// Where free boundaries are put.
    pub free: Free,
    /// What a column is met by.
    pub coverage: Coverage,
    /// Columns a side of the square that a look-up averages; odd.
    pub filter: u32,
    /// Columns a side of a tile, at most: a power of two. [`Settings::TILE`] but in tests.
    pub tile: u32,
    /// Entries and exits of the last tile's columns are kept, for [`super::Voxelized::columns`].
    pub keep_columns: bool,
}

impl Settings {
    /// Side of the largest tile, columns.
    pub const TILE: u32 = 4096;

    /// The defaults, for a file to say otherwise.
    pub(super) const PLAIN: Self = Self {
        size: 1024,
        structure: Structure::Dag,
        closed: true,
        free: Free::Shared,
        coverage: Coverage::Middle,
        filter: 1,
        tile: Self::TILE,
        keep_columns: false,
    };

    /// What `spec` says.
    pub fn of(spec: &Spec) -> Self {
        Self {
            size: spec.number(SIZE.name),
            structure: spec.word(STRUCTURE.name).unwrap_or(Structure::Dag),
            closed: spec.is_on(CLOSED.name),
            free: spec.word(FREE.name).unwrap_or(Free::Shared),
            coverage: spec.word(COVERAGE.name).unwrap_or(Coverage::Middle),
            filter: spec.number(PCF.name),
            ..Self::PLAIN
        }
    }

    /// Whether equal nodes are one.
    pub fn merges(self) -> bool {
        self.structure == Structure::Dag
    }

    /// Whether a column is met by what touches its square.
    pub fn is_conservative(self) -> bool {
        self.coverage == Coverage::Conservative
    }

    /// The keys that a bake depends on and a file has, with their values.
    pub(super) fn baked(self) -> [(&'static str, String); 5] {
        [
            (SIZE.name, self.size.to_string()),
            (STRUCTURE.name, word_of(self.structure).into()),
            (CLOSED.name, word_of(if self.closed { Switch::On } else { Switch::Off }).into()),
            (FREE.name, word_of(self.free).into()),
            (COVERAGE.name, word_of(self.coverage).into()),
        ]
    }

    /// Bits of a node before its pointers, and of the units that they count. Twin: HEADER_BITS in glsl/voxelized/tree.glsl.
    pub(super) fn header_bits(self) -> u32 {
        if self.merges() { 16 } else { 32 }
    }

    /// What look-ups are built with.
    pub(super) fn constants(self, constants: Constants) -> Constants {
        constants
            .set(constant::HEADER_BITS, self.header_bits())
            .set(constant::CONSERVATIVE, self.is_conservative())
            .set(constant::PCF, self.filter)
    }
}
