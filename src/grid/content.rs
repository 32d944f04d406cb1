//! The contents of a grid's voxels: meshes, and smoke and hair.

use super::cells::Cells;
use super::lists::{CastLists, Lists};
use super::masks::Masks;
use super::media::Media;
use super::voxelize::{Voxelize, Voxelizer};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context};
use crate::world::World;

/// Extra mesh data in a grid, besides a bit per voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// No extra data.
    Nothing,
    /// Number of occupied voxels in larger cells, for cone tracing.
    Counts,
    /// For each occupied voxel, which of its 4 × 4 × 4 cells are occupied.
    Masks,
}

/// The voxels' mesh data.
pub(super) enum MeshVoxels {
    /// Nothing: the grid contains only smoke and hair.
    Nothing,
    /// A bit per voxel, or lists of triangles if [`Voxelize`] is `Listed`.
    Bits(Voxelize),
    /// A bit, and counts in larger cells, for cone tracing.
    Counts(Voxelize, Cells),
    /// A bit, and which parts of the voxel are occupied, for shadows finer than voxels.
    Masks(Voxelize, Masks),
}

impl MeshVoxels {
    /// Creates the mesh data of a grid of `size` voxels per side, whose buffers are in the set `grid`.
    pub(super) fn new(
        context: &Context,
        world: &World,
        size: u32,
        grid: &Bindings,
        (voxelizer, finer): (Voxelizer, Refinement),
    ) -> Result<Self> {
        let voxelize = match voxelizer {
            Voxelizer::Listed => Voxelize::Listed(Box::new(Lists::new(context, world, size, grid)?)),
            voxelizer => Voxelize::new(context, voxelizer, &[grid], world.constants())?,
        };
        Ok(match finer {
            Refinement::Nothing => Self::Bits(voxelize),
            Refinement::Counts => Self::Counts(voxelize, Cells::new(context, size, grid)?),
            Refinement::Masks => Self::Masks(voxelize, Masks::new(context, world, size, voxelizer, grid)?),
        })
    }

    pub(super) fn voxelize(&self) -> Option<&Voxelize> {
        match self {
            Self::Nothing => None,
            Self::Bits(voxelize) | Self::Counts(voxelize, _) | Self::Masks(voxelize, _) => Some(voxelize),
        }
    }

    pub(super) fn lists(&self) -> Option<&Lists> {
        if let Self::Bits(Voxelize::Listed(lists)) = self { Some(lists) } else { None }
    }

    pub(super) fn cells(&self) -> Option<&Cells> {
        if let Self::Counts(_, cells) = self { Some(cells) } else { None }
    }

    pub(super) fn masks(&self) -> Option<&Masks> {
        if let Self::Masks(_, masks) = self { Some(masks) } else { None }
    }

    /// Returns whether the lists or masks of the completed frame `frame` did not fit, in which case their buffers have been enlarged.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        match self {
            Self::Bits(Voxelize::Listed(lists)) => lists.settle(frame),
            Self::Masks(_, masks) => masks.settle(frame),
            Self::Nothing | Self::Bits(_) | Self::Counts(..) => Ok(false),
        }
    }

    /// Fills the voxels of an empty grid of `size` voxels per side. `large` lists the triangles that overlap many voxels.
    pub(super) fn record(&self, commands: &mut Commands, world: &World, size: u32, large: &Buffer) {
        if let Some(voxelize) = self.voxelize() {
            voxelize.record(commands, "grid.voxelize", world, size);
        }
        match self {
            Self::Counts(_, cells) => cells.record(commands),
            Self::Masks(_, masks) => masks.record(commands, world, large),
            Self::Nothing | Self::Bits(_) => {}
        }
    }

    /// Returns the number of bytes that a look-up needs.
    pub(super) fn resident_bytes(&self) -> u64 {
        match self {
            Self::Bits(Voxelize::Listed(lists)) => lists.words.bytes(),
            Self::Counts(_, cells) => cells.counts.bytes(),
            Self::Masks(_, masks) => masks.words.bytes(),
            Self::Nothing | Self::Bits(_) => 0,
        }
    }

    /// Returns the number of bytes that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        match self {
            Self::Bits(Voxelize::Listed(lists)) => lists.transient_bytes(),
            Self::Masks(_, masks) => masks.transient_bytes(),
            Self::Nothing | Self::Bits(_) | Self::Counts(..) => 0,
        }
    }
}

/// The voxels' smoke and hair data.
pub(super) enum CasterVoxels {
    /// Nothing: the grid contains only meshes.
    Nothing,
    /// An optical depth per voxel.
    Media(Media),
    /// The casters that overlap each voxel.
    Lists(CastLists),
}

impl CasterVoxels {
    pub(super) fn media(&self) -> Option<&Media> {
        if let Self::Media(media) = self { Some(media) } else { None }
    }

    pub(super) fn lists(&self) -> Option<&CastLists> {
        if let Self::Lists(lists) = self { Some(lists) } else { None }
    }

    /// Returns the number of bytes that a look-up needs.
    pub(super) fn resident_bytes(&self) -> u64 {
        match self {
            Self::Nothing => 0,
            Self::Media(media) => media.resident_bytes(),
            Self::Lists(cast) => cast.resident_bytes(),
        }
    }

    /// Returns the number of bytes that only a build needs.
    pub(super) fn transient_bytes(&self) -> u64 {
        match self {
            Self::Nothing => 0,
            Self::Media(media) => media.large.bytes(),
            Self::Lists(cast) => cast.transient_bytes(),
        }
    }
}
