//! Settings of voxelized shadows.

use super::super::keys::{OneOf, words};
use super::super::settings::{Keyed, PCF, Setting, settings};
use crate::gpu::Constants;
use crate::shaders::constant;

words! {
    /// How nodes are stored.
    pub enum Structure {
        /// Sparse voxel octree: every node is stored, in whole words.
        Svo = "svo",
        /// Directed acyclic graph: equal nodes are stored once, and pointers have as many bits as they need.
        Dag = "dag",
    }
}

words! {
    /// Where a column's shadow begins, if it may begin anywhere inside a closed mesh.
    pub enum Free {
        /// Where light would leave the mesh.
        Exit = "exit",
        /// Where light enters the mesh.
        Entry = "entry",
        /// At as few different depths as the 8 × 8 columns of a block allow, and at multiples of high powers of two where possible.
        Shared = "shared",
    }
}

words! {
    /// Which triangles shadow a column of voxels.
    pub enum Coverage {
    /// Triangles that cover the column's centre.
    Middle = "middle",
    /// Triangles that touch the column's square anywhere, so nothing thin is lost.
        Conservative = "conservative",
    }
}

/// Keys whose values are stored in a file.
const IN_FILE: OneOf = &["size", "structure", "closed", "free", "coverage"];

settings! {
    /// Settings of the technique.
    pub struct Settings {
        /// Voxels per side of the cube around the meshes: a power of two from 64 to 65,536.
        size: u32 = Setting::one_of(
            "1024",
            &["64", "128", "256", "512", "1024", "2048", "4096", "8192", "16384", "32768", "65536"],
            "voxels per side of the cube about the meshes");
        /// A tree, or a graph in which equal nodes are stored once (Kämpe, Sintorn and Assarsson 2013).
        structure: Structure = Setting::word("dag", "a tree, or a graph in which equal nodes are one");
        /// Whether voxels inside closed and solid meshes are free, that is, lit or shadowed, whichever merges best (Sintorn et al. 2014).
        closed: bool = Setting::word("on", "voxels inside closed and solid meshes are free, whatever merges best");
        /// Where shadows begin inside closed meshes.
        free: Free = Setting::word(
            "shared", "where shadows begin inside closed things: at the exit, at the entry, or at depths that columns share");
        /// Which triangles shadow a column of voxels.
        coverage: Coverage = Setting::word(
            "middle", "what shadows a column of voxels: what covers its middle, or what touches its square anywhere");
        /// File of a bake, which [`super::Loaded::new`] opens instead of building one. The file states its size, structure, closed, free
        /// and coverage.
        file: Option<String> = Setting::file(
            IN_FILE, "what a bake was written to, in place of one that is built; size, structure, closed, free and coverage are its own");
        /// Columns per side of the square that a look-up averages: 1, 3, 5, 7 or 9.
        filter: u32 = PCF;
        /// How far a point is moved along its surface normal before the look-up, in hundredths of the distance that keeps a flat surface
        /// out of its own shadow: 0 to 400.
        bias: u32 = Setting::number(
            "100", 0, 400, "offset along a surface's normal, in hundredths of the distance that keeps a flat one out of its own shadow");
    }
}

/// The settings, resolved. For tests, a plan may also hold values that settings cannot express.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Voxels per side: a power of two from 64 to 65,536.
    pub size: u32,
    /// Tree or graph.
    pub structure: Structure,
    /// Whether closed meshes have an inside.
    pub closed: bool,
    /// Where shadows begin inside closed meshes.
    pub free: Free,
    /// Which triangles shadow a column of voxels.
    pub coverage: Coverage,
    /// Columns per side of the square that a look-up averages; odd.
    pub filter: u32,
    /// How far a point is moved along its surface normal before the look-up, in hundredths of the distance that keeps a flat surface out of
    /// its own shadow.
    pub bias: u32,
    /// Maximum number of columns per side of a tile, a power of two. [`Plan::TILE`] except in tests.
    pub tile: u32,
    /// Whether entries and exits of the last tile's columns are kept, for [`super::Voxelized::columns`].
    pub keep_columns: bool,
}

impl Plan {
    /// Side of the largest tile, in columns.
    pub const TILE: u32 = 4096;

    /// Returns the plan for these settings.
    pub(super) fn of(settings: &Settings) -> Self {
        let Settings { size, structure, closed, free, coverage, file: _, filter, bias } = *settings;
        Self { size, structure, closed, free, coverage, filter, bias, tile: Self::TILE, keep_columns: false }
    }

    /// Returns whether equal nodes are stored once.
    pub fn merges(self) -> bool {
        self.structure == Structure::Dag
    }

    /// Returns whether a triangle that touches a column's square but not its centre counts for the column.
    pub fn is_conservative(self) -> bool {
        self.coverage == Coverage::Conservative
    }

    /// Returns the keys that a bake depends on and a file stores, with their values.
    pub(super) fn baked(self) -> impl Iterator<Item = (&'static str, String)> {
        let Self { size, structure, closed, free, coverage, .. } = self;
        let settings = Settings { size, structure, closed, free, coverage, ..Settings::default() };
        settings.texts().into_iter().filter(|(key, _)| IN_FILE.contains(key))
    }

    /// Returns the number of bits of a node before its pointers, which is also the size of a unit: pointers count units. Twin: HEADER_BITS
    /// in glsl/technique/voxelized/tree.glsl.
    pub(super) fn header_bits(self) -> u32 {
        if self.merges() { 16 } else { 32 }
    }

    /// Adds the specialization constants of look-ups.
    pub(super) fn constants(self, constants: Constants) -> Constants {
        constants
            .set(constant::HEADER_BITS, self.header_bits())
            .set(constant::CONSERVATIVE, self.is_conservative())
            .set(constant::PCF, self.filter)
            .set(constant::NORMAL_BIAS, self.bias as f32 / 100.0)
    }
}
