//! What a spec comes to with a device and a scene: the path, how curves are made, the constants of its shaders; or why not.

use super::ENTRY;
use super::settings::{Batch, Resolve, Settings, Way};
use crate::gpu::{Constants, Context, Requirement};
use crate::shaders::constant::{EXPONENTIAL, GROUPS, NODES, NUDGE, PACKED, SORTED, STRANDS, TILED, WORK, WORKGROUP};
use crate::technique::keys::Word;
use crate::world::World;
use crate::{Error, Result};

/// WORK − NODES where a texel's whole curve is compressed at once. With 16 the error on plume_8k is within 2 % of what
/// 112 give, which hold almost every curve exactly; what does go on the way is what changes the area least.
const WHOLE_NODES: u32 = 16;

/// WORK − NODES of the binned path, whose curves stay in registers. They make up for sorting by tile and not by texel.
const BINNED_NODES: u32 = 4;

/// WORK − NODES of curves from cells: ends of cells come in order and few, so that little is gained by more.
const CELLS_NODES: u32 = 2;

/// Shared memory of glsl/avsm/cells.comp: 64 cells of 64 texels, or of 32 twice, 128 casters, ends, ranges and the bound.
const CELLS_SHARED_BYTES: u32 = 64 * 64 * 4 + 128 * 32 + 4 * 64 * 8 + 2 * 64 * 4 + 4;

/// What is decided before anything is made.
pub struct Plan {
    pub settings: Settings,
    pub way: Way,
    /// resolve=cells, asked for or chosen.
    pub cells: bool,
    /// Casters stand in the lanes of subgroups.
    pub lanes: bool,
    /// Why this path.
    pub reason: String,
    pub constants: Constants,
}

impl Plan {
    /// # Errors
    /// [`Error::Refused`] where the device lacks what the path needs, or the path what the settings ask of it.
    pub fn new(context: &Context, world: &World, settings: Settings) -> Result<Self> {
        let (way, mut reason) = choose(context, world, &settings);
        ENTRY.require(context, way.name())?;
        let resolve = settings.resolve.unwrap_or(match way {
            Way::Binned if !world.has_strands() => Resolve::Cells,
            _ => Resolve::Streaming,
        });
        let cells = resolve == Resolve::Cells;
        let refused = |needs: String| Err(Error::Refused { needs });
        if resolve == Resolve::Whole && matches!(way, Way::Interlock | Way::RasterOrder) {
            return refused(format!(
                "every segment of a texel (resolve=whole), which path={} does not keep",
                way.name()
            ));
        }
        if cells && way != Way::Binned {
            return refused("path=binned: resolve=cells adds up a tile's casters".into());
        }
        let shared = context.features().max_compute_shared_memory_bytes;
        if cells && shared < CELLS_SHARED_BYTES {
            return refused(format!(
                "maxComputeSharedMemorySize of at least {CELLS_SHARED_BYTES} (this device has {shared})"
            ));
        }
        if !settings.sorted && way == Way::Binned {
            return refused("order=sorted: path=binned has no other".into());
        }
        if way == Way::Binned && settings.resolve.is_none() {
            reason =
                format!("{reason}; resolve={}: {}", word(resolve), if cells { "no hair" } else { "hair is steps" });
        }
        let more_nodes = match (resolve, way) {
            (Resolve::Whole, _) => WHOLE_NODES,
            (Resolve::Cells, _) => CELLS_NODES,
            (Resolve::Streaming, Way::Binned) => BINNED_NODES,
            (Resolve::Streaming, _) => 0,
        };
        let (ballot, software) = (context.features().subgroup_ballot, context.features().is_software());
        let lanes = match settings.batch {
            Some(Batch::Lanes) if !ballot => return refused("subgroup ballots in compute shaders".into()),
            Some(batch) => batch == Batch::Lanes,
            None => ballot && software,
        };
        // More groups only repeat work where threads take turns.
        let groups = if lanes || software { 1 } else { 4 };
        settings.filter.check(world.scene(), settings.size)?;
        let constants = Constants::new()
            .set(NODES, settings.nodes)
            .set(EXPONENTIAL, settings.exponential)
            .set(WORK, settings.nodes + more_nodes)
            .set(NUDGE, settings.nudge)
            .set(SORTED, settings.sorted)
            .set(TILED, settings.skip)
            .set(PACKED, settings.packed)
            .set(GROUPS, groups)
            .set(WORKGROUP, groups)
            .set(STRANDS, world.has_strands());
        let constants = settings.filter.constants(constants);
        Ok(Self { settings, way, cells, lanes, reason, constants })
    }
}

fn word(resolve: Resolve) -> &'static str {
    Resolve::ALL.iter().find(|(_, r)| *r == resolve).map_or("", |(word, _)| word)
}

/// The path and why. `auto` follows what was measured (docs/avsm-paths.md):
///
/// | device | path |
/// |---|---|
/// | a GPU | binned: fastest on the H200, at the least memory |
/// | a software device, curves from cells | binned: fastest on both lavapipes |
/// | a software device, hair or `resolve=streaming` or `whole` | two-pass: fastest on both |
///
/// Binned has no `order=captured`, which is left to interlock, where there is one, and to two-pass.
fn choose(context: &Context, world: &World, settings: &Settings) -> (Way, String) {
    if let Some(asked) = settings.way {
        return (asked, "asked for".into());
    }
    let features = context.features();
    if !settings.sorted {
        return match features.lacks(Requirement::PixelInterlock) {
            None => (Way::Interlock, "auto: order=captured with fragmentShaderPixelInterlock".into()),
            Some(missing) => (Way::TwoPass, format!("auto: order=captured on a device that lacks {missing}")),
        };
    }
    if !features.is_software() {
        return (Way::Binned, format!("auto: {} device", features.kind));
    }
    match settings.resolve {
        None if world.has_strands() => (Way::TwoPass, "auto: hair on a software device".into()),
        None | Some(Resolve::Cells) => (Way::Binned, "auto: a software device".into()),
        Some(resolve) => (Way::TwoPass, format!("auto: resolve={} on a software device", word(resolve))),
    }
}
