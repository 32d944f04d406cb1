//! Decides, for a spec, a device and a scene, which path runs, how it builds curves and which constants its shaders get, or why the spec is
//! refused.

use super::curves::pairs;
use super::promises::promises;
use super::settings::{Batch, BuildPath, Fit, Resolve, Settings};
use super::{ENTRY, raster_order};
use crate::gpu::{Constants, Context, Features, Limit, Requirement};
use crate::maps::{BLOCK_TEXELS, Entries, FilterKind, MANY_CASTERS, leveled_texels};
use crate::shaders::constant::{
    AHEAD, AREA, BATCH, DETAIL, EXPONENTIAL, GROUPS, LEVELS, NODES, NUDGE, PACKED, SORTED, TIGHT, TILED, TURNS, WORK,
    WORKGROUP,
};
use crate::technique::keys::word_of;
use crate::technique::{Path, PathPlan, Spec};
use crate::world::World;
use crate::{Error, Need, Result};

/// Number of spare nodes (WORK − NODES in glsl/maps/curve/curve.glsl) if a texel's whole curve is compressed at once. A curve has spare
/// nodes only while it is built. 112 spare nodes would hold almost every curve exactly. With 16, some nodes are removed before the curve is
/// complete, starting with the nodes whose removal changes the area under the curve least. The error on plume_8k is then within 2 % of the
/// error with 112.
const WHOLE_NODES: u32 = 16;

/// Number of spare nodes (see [`WHOLE_NODES`]) on the binned path, which keeps curves in registers. Casters are sorted per tile, not per
/// texel, so they arrive slightly out of order; the spare nodes make up for that.
const BINNED_NODES: u32 = 4;

/// Number of spare nodes (see [`WHOLE_NODES`]) of curves built from cells, which are even ranges of depth. The ends of cells are few and
/// arrive in order of depth, so more spare nodes would gain little.
const CELLS_NODES: u32 = 2;

/// Threads per texel of glsl/technique/avsm/cells.comp with very many casters. The number of casters then varies widely between tiles, and
/// the whole build waits for the fullest tile.
const MANY_GROUPS: u32 = 16;

/// Threads per texel of cells.comp with 16 nodes, which use so many registers that few workgroups run at a time.
const WIDE_GROUPS: u32 = 8;

/// Number of casters that a thread of cells.comp tests before it adds up the ones that its ray hits, in scenes with very many casters,
/// which are small.
const MOST_AHEAD: u32 = 32;

/// Number of refinement passes with fit=refined, which move the odd and the even nodes alternately. Two passes reach four fifths of the
/// gain of eight passes; three reach nine tenths.
const FIT_TURNS: u32 = 3;

/// Minimum subgroup size at which software devices insert segments tile by tile at least about as fast as from lists, in less memory.
const WIDE: u32 = 8;

/// Shared memory per tile for fit=refined with resolve=whole: 64 cells and at most 16 nodes per texel (glsl/technique/avsm/resolve.comp).
const FIT_ROOM: Limit = Limit::shared_memory((64 * 4 + 16 * 8) * 64);

/// Variants of glsl/technique/avsm/cells.comp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// One workgroup per tile, with casters in shared memory.
    Whole,
    /// One workgroup per half tile, with casters in the lanes of subgroups.
    Lanes,
    /// One workgroup per half tile, with casters in shared memory.
    Half,
}

impl Cells {
    /// Returns the number of texels per workgroup, which is also its number of threads along x.
    fn texels(self) -> u32 {
        if self == Self::Whole { 64 } else { 32 }
    }

    /// Returns the number of casters that shared memory holds at a time: 32 for each of the `groups` threads per texel, or more if the
    /// memory, which is reused later to fit the nodes, has room for more. [`Cells::Lanes`] holds no casters there.
    fn batch(self, groups: u32, nodes: u32) -> u32 {
        (nodes * self.texels() / 4).max(32 * groups)
    }

    /// Returns the number of bytes of shared memory. Per texel: 65 cells of 4 bytes; four 64-bit masks, one per threshold, of the cell ends
    /// that are kept; and four depths of 4 bytes. Per workgroup: a batch of casters of 32 bytes each, whose memory later holds up to 16
    /// nodes per texel; 8 bytes for a bound; and 24 bytes for totals over all texels.
    fn shared_bytes(self, groups: u32) -> u32 {
        (65 * 4 + 4 * 8 + 4 * 4) * self.texels() + self.batch(groups, 16) * 32 + 8 + 24
    }

    /// Returns the Vulkan limit, on shared memory or threads, that is too low on the device for `groups` threads per texel. `None` if the
    /// device has enough of both.
    fn lacks(self, features: &Features, groups: u32) -> Option<Need> {
        let threads = Limit::threads((groups * self.texels()).into());
        [self.room(groups), threads].iter().find_map(|limit| limit.lacks(features, ""))
    }

    fn room(self, groups: u32) -> Limit {
        Limit::shared_memory(self.shared_bytes(groups).into())
    }
}

/// Decisions made before anything is created.
pub struct Plan {
    /// The requested settings, with `storage` resolved.
    pub settings: Settings,
    pub way: BuildPath,
    /// Variant of cells.comp; `None` without resolve=cells.
    pub cells: Option<Cells>,
    /// Whether glsl/technique/avsm/binned.comp keeps casters in the lanes of subgroups.
    pub lanes: bool,
    /// Whether nodes are fitted to the whole curve.
    pub refined: bool,
    /// Reason for choosing this path.
    pub reason: String,
    pub constants: Constants,
}

impl Plan {
    /// # Errors
    /// [`Error::Refused`] if the device lacks what the path needs, or the path cannot do what the settings ask for.
    pub fn new(context: &Context, world: &World, asked: Settings) -> Result<Self> {
        let settings = Settings { storage: Some(asked.storage(world.has_strands())), ..asked };
        let (way, mut reason) = choose(context, world, &settings);
        ENTRY.require(context, way.name())?;
        let resolve = settings.resolve.unwrap_or(match way {
            BuildPath::Binned if !world.has_strands() => Resolve::Cells,
            _ => Resolve::Streaming,
        });
        let cells = resolve == Resolve::Cells;
        let refused = |needs: Need| Err(Error::Refused(needs));
        if resolve == Resolve::Whole && matches!(way, BuildPath::Interlock | BuildPath::RasterOrder) {
            return refused(
                format!("every segment of a texel (resolve=whole), which path={} does not keep", way.name()).into(),
            );
        }
        if cells && way != BuildPath::Binned {
            return refused("path=binned: resolve=cells adds up a tile's casters".into());
        }
        if !settings.is_sorted() && way == BuildPath::Binned {
            return refused("order=sorted: path=binned has no other".into());
        }
        if settings.is_adaptive() && way != BuildPath::Binned {
            return refused("path=binned: detail=adaptive builds tiles".into());
        }
        if settings.is_adaptive() && settings.filter != FilterKind::Bilinear {
            return refused("filter=bilinear: with detail=adaptive texels differ in size".into());
        }
        if settings.is_adaptive() && settings.levels > 1 {
            return refused("detail=even: levels= needs maps whose texels are alike".into());
        }
        if settings.is_of_areas() && way != BuildPath::Binned {
            return refused("path=binned: texel=area builds tiles".into());
        }
        if way == BuildPath::Binned && settings.resolve.is_none() {
            reason =
                format!("{reason}; resolve={}: {}", word_of(resolve), if cells { "no hair" } else { "hair is steps" });
        }
        let asks_fit = settings.fit == Some(Fit::Refined);
        let whole = resolve == Resolve::Whole && way == BuildPath::TwoPass;
        if asks_fit && !(settings.is_exponential() && (cells || whole)) {
            let ways = "resolve=cells, or path=two-pass,resolve=whole";
            return refused(
                format!("{ways}, and curve=exponential: fit=refined fits a whole curve of optical depth").into(),
            );
        }
        if asks_fit
            && whole
            && let Some(needs) = FIT_ROOM.lacks(context.features(), " for fit=refined")
        {
            return refused(needs);
        }
        let refined = asks_fit || (cells && settings.is_exponential() && settings.fit.is_none());
        let turns = if refined { FIT_TURNS } else { 0 };
        let more_nodes = match (resolve, way) {
            (Resolve::Whole, _) => WHOLE_NODES,
            (Resolve::Cells, _) => CELLS_NODES,
            (Resolve::Streaming, BuildPath::Binned) => BINNED_NODES,
            (Resolve::Streaming, _) => 0,
        };
        let features = context.features();
        let way_of_cells = if cells { Some(choose_cells(features, settings.batch)?) } else { None };
        let suits_lanes = features.is_software() || (world.has_strands() && resolve == Resolve::Streaming);
        let lanes = !cells && way == BuildPath::Binned && choose_lanes(features, settings.batch, suits_lanes)?;
        // Threads of software devices take turns, so more groups would only repeat work.
        let has_many = world.caster_capacity() >= MANY_CASTERS && !features.is_software();
        let groups = match way_of_cells {
            Some(Cells::Lanes) => 1,
            Some(Cells::Whole) if has_many && Cells::Whole.lacks(features, MANY_GROUPS).is_none() => MANY_GROUPS,
            Some(Cells::Whole)
                if !features.is_software()
                    && settings.nodes == 16
                    && Cells::Whole.lacks(features, WIDE_GROUPS).is_none() =>
            {
                WIDE_GROUPS
            }
            _ => groups(features),
        };
        // Looking ahead needs a thread for each caster of a batch (glsl/technique/avsm/cells_shared.glsl).
        let fits = |way: Cells| way != Cells::Lanes && way.batch(groups, settings.nodes) <= groups * way.texels();
        let ahead = if has_many && way_of_cells.is_some_and(fits) { MOST_AHEAD } else { 1 };
        settings.filter().check(world, settings.base_size())?;
        let constants = Constants::new()
            .set(NODES, settings.nodes)
            .set(EXPONENTIAL, settings.is_exponential())
            .set(WORK, settings.nodes + more_nodes)
            .set(NUDGE, settings.nudge)
            .set(TURNS, turns)
            .set(AHEAD, ahead)
            .set(BATCH, way_of_cells.map_or(0, |way| way.batch(groups, settings.nodes)))
            .set(SORTED, settings.is_sorted())
            .set(TILED, settings.skip)
            .set(PACKED, settings.is_packed())
            .set(TIGHT, settings.is_tight())
            .set(DETAIL, settings.is_adaptive())
            .set(AREA, settings.is_of_areas())
            .set(LEVELS, settings.levels)
            .set(GROUPS, groups)
            .set(WORKGROUP, groups);
        let constants = settings.filter().constants(constants.and(&world.constants()));
        Ok(Self { settings, way, cells: way_of_cells, lanes, refined, reason, constants })
    }

    /// Returns which per-tile caster data the path needs from the bins.
    pub fn entries(&self) -> Entries {
        match (self.way, self.cells) {
            (BuildPath::Binned, Some(_)) => Entries::Summed,
            (BuildPath::Binned, None) => Entries::Sorted,
            _ => Entries::None,
        }
    }
}

/// Returns the limits and promises of a spec on a path.
pub fn of_path(spec: &Spec, path: &'static Path) -> PathPlan {
    let settings: Settings = spec.settings();
    PathPlan { path, limits: limits(&settings, path), promises: promises(&settings, path) }
}

/// Returns the limits of a path; devices that do not meet them are refused. For curves from cells, they are the limits of [`Cells::Half`],
/// the variant that needs the least shared memory; every device has enough threads for it. With detail=adaptive, the size of the curves is
/// a setting, so it is not limited here.
fn limits(settings: &Settings, path: &Path) -> Vec<Limit> {
    let refines = settings.resolve == Some(Resolve::Whole) && settings.fit == Some(Fit::Refined);
    let mut limits = Vec::new();
    if !settings.is_adaptive() {
        limits.push(Limit::buffer_range(8 * pairs(settings) as u64 * leveled_texels(settings.size, settings.levels)));
    }
    if path.is(BuildPath::RasterOrder) {
        limits.extend(raster_order::limits(settings));
    } else if path.is(BuildPath::Binned) && settings.resolve.is_none_or(|resolve| resolve == Resolve::Cells) {
        limits.push(Cells::Half.room(GPU_GROUPS));
    } else if path.is(BuildPath::TwoPass) && refines {
        limits.push(FIT_ROOM);
    }
    limits
}

/// Threads per texel of glsl/technique/avsm/cells.comp on GPUs, with casters in shared memory.
const GPU_GROUPS: u32 = 4;

fn groups(features: &Features) -> u32 {
    if features.is_software() { 1 } else { GPU_GROUPS }
}

/// Chooses the variant of cells.comp. `auto`: lanes on software devices, else whole tiles if they fit into shared memory, else half tiles.
fn choose_cells(features: &Features, batch: Option<Batch>) -> Result<Cells> {
    let lanes = || features.lacks_full_subgroups(Cells::Lanes.texels()).or_else(|| Cells::Lanes.lacks(features, 1));
    if batch == Some(Batch::Lanes) {
        return lanes().map_or(Ok(Cells::Lanes), |needs| Err(Error::Refused(needs)));
    }
    if batch.is_none() && features.is_software() && lanes().is_none() {
        return Ok(Cells::Lanes);
    }
    if Cells::Whole.lacks(features, groups(features)).is_none() {
        return Ok(Cells::Whole);
    }
    Cells::Half.lacks(features, groups(features)).map_or(Ok(Cells::Half), |needs| Err(Error::Refused(needs)))
}

/// Decides whether binned.comp keeps casters in lanes. `auto`: if `suit` is true and the device has full subgroups.
fn choose_lanes(features: &Features, batch: Option<Batch>, suit: bool) -> Result<bool> {
    match (batch, features.lacks_full_subgroups(BLOCK_TEXELS)) {
        (Some(Batch::Lanes), Some(needs)) => Err(Error::Refused(needs)),
        (asked, lacks) => Ok(lacks.is_none() && (asked == Some(Batch::Lanes) || asked.is_none() && suit)),
    }
}

/// Chooses the path and gives the reason. `auto` follows measurements (docs/notebook/avsm-paths.md):
///
/// | device | path |
/// |---|---|
/// | a GPU | binned: fastest on the H200, with the least memory |
/// | a software device, curves from cells | binned: fastest or nearly so on both lavapipes, with the least error |
/// | a software device, hair or `resolve=streaming` or `whole` | binned with lanes of 8 or more, else two-pass |
/// | any, `resolve=whole,fit=refined` | two-pass, the only path that supports it |
///
/// The binned path does not support `order=captured`: interlock handles it on devices that have the feature, two-pass on others.
fn choose(context: &Context, world: &World, settings: &Settings) -> (BuildPath, String) {
    if let Some(asked) = settings.path {
        return (asked, "asked for".into());
    }
    if settings.is_adaptive() {
        return (BuildPath::Binned, "auto: detail=adaptive".into());
    }
    if settings.is_of_areas() {
        return (BuildPath::Binned, "auto: texel=area".into());
    }
    if settings.resolve == Some(Resolve::Whole) && settings.fit == Some(Fit::Refined) {
        return (BuildPath::TwoPass, "auto: resolve=whole,fit=refined".into());
    }
    let features = context.features();
    if !settings.is_sorted() {
        return match features.lacks(Requirement::PixelInterlock) {
            None => (BuildPath::Interlock, "auto: order=captured with fragmentShaderPixelInterlock".into()),
            Some(missing) => (BuildPath::TwoPass, format!("auto: order=captured on a device that lacks {missing}")),
        };
    }
    if !features.is_software() {
        return (BuildPath::Binned, format!("auto: {} device", features.kind));
    }
    if settings.batch.is_some() {
        return (BuildPath::Binned, "auto: batch= needs tiles".into());
    }
    if let Some(missing) = features.lacks(Requirement::FragmentStores) {
        return (BuildPath::Binned, format!("auto: a device that lacks {missing}"));
    }
    let cells = settings.resolve.map_or(!world.has_strands(), |resolve| resolve == Resolve::Cells);
    let wide = features.subgroup_size >= WIDE && choose_lanes(features, settings.batch, true).unwrap_or(false);
    match settings.resolve {
        _ if cells => (BuildPath::Binned, "auto: a software device".into()),
        _ if wide => {
            (BuildPath::Binned, format!("auto: a software device with subgroups of {}", features.subgroup_size))
        }
        None => (BuildPath::TwoPass, "auto: hair on a software device without wide lanes".into()),
        Some(resolve) => {
            (BuildPath::TwoPass, format!("auto: resolve={} on a software device without wide lanes", word_of(resolve)))
        }
    }
}
