//! What a spec comes to with a device and a scene: the path, how curves are made, the constants of its shaders; or why not.

use super::{BINNED, CELLS, ENTRY, INTERLOCK, RASTER_ORDER, TWO_PASS};
use crate::gpu::{Context, Requirement};
use crate::scene::Scene;
use crate::technique::{Spec, filter};
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
    pub path: &'static str,
    /// resolve=cells, asked for or chosen.
    pub cells: bool,
    /// LANES of glsl/bins/batch.glsl.
    pub lanes: bool,
    /// Why this path.
    pub reason: String,
    /// Texels around a texel from which look-ups read it.
    pub reach: u32,
    /// NODES, EXPONENTIAL, WORK, NUDGE, SORTED, TILED, FILTER, FILTER_RADIUS, PACKED, GROUPS, STRANDS, GROUPS.
    pub constants: [u32; 12],
}

impl Plan {
    /// # Errors
    /// [`Error::Refused`] where the device lacks what the path needs, or the path what the spec asks of it.
    pub fn new(context: &Context, scene: &Scene, spec: &Spec) -> Result<Self> {
        let (path, mut reason) = choose(context, scene, spec);
        for known in ENTRY.paths.iter().filter(|p| p.name == path) {
            crate::technique::require(context, known.requires)?;
        }
        let resolve = match spec.value("resolve") {
            "auto" if path == BINNED && scene.strands.is_empty() => CELLS,
            "auto" => "streaming",
            asked => asked,
        };
        let (whole, cells, sorted) = (resolve == "whole", resolve == CELLS, spec.value("order") == "sorted");
        if whole && [INTERLOCK, RASTER_ORDER].contains(&path) {
            let needs = format!("every segment of a texel (resolve=whole), which path={path} does not keep");
            return Err(Error::Refused { needs });
        }
        if cells && path != BINNED {
            return Err(Error::Refused { needs: "path=binned: resolve=cells adds up a tile's casters".into() });
        }
        let shared = context.features().max_compute_shared_memory_bytes;
        if cells && shared < CELLS_SHARED_BYTES {
            let needs =
                format!("maxComputeSharedMemorySize of at least {CELLS_SHARED_BYTES} (this device has {shared})");
            return Err(Error::Refused { needs });
        }
        if !sorted && path == BINNED {
            return Err(Error::Refused { needs: "order=sorted: path=binned has no other".into() });
        }
        if path == BINNED && spec.value("resolve") == "auto" {
            reason = format!("{reason}; resolve={resolve}: {}", if cells { "no hair" } else { "hair is steps" });
        }
        let more_nodes = match path {
            _ if whole => WHOLE_NODES,
            _ if cells => CELLS_NODES,
            BINNED => BINNED_NODES,
            _ => 0,
        };
        let ballot = context.features().subgroup_ballot;
        let lanes = match spec.value("batch") {
            "lanes" if !ballot => return Err(Error::Refused { needs: "subgroup ballots in compute shaders".into() }),
            "auto" => ballot && context.features().kind == "cpu",
            asked => asked == "lanes",
        };
        // Threads of a workgroup take turns on a CPU: more groups only repeat work there.
        let groups = if lanes || context.features().kind == "cpu" { 1 } else { 4 };
        let [filter, radius] = filter::constants(scene, spec)?;
        let on = |key: &str, value: &str| u32::from(spec.value(key) == value);
        let nodes = spec.number("nodes");
        let constants = [
            nodes,
            on("curve", "exponential"),
            nodes + more_nodes,
            on("nudge", "on"),
            sorted.into(),
            on("skip", "on"),
            filter,
            radius,
            on("storage", "packed"),
            groups,
            u32::from(!scene.strands.is_empty()),
            groups,
        ];
        // Bilinear weights reach one texel away.
        let reach = 1 + if spec.value("filter") == "bilinear" { 0 } else { radius };
        Ok(Self { path, cells, lanes, reason, reach, constants })
    }
}

/// The path and why. `auto` follows what was measured (README, "Which path"):
///
/// | device | path |
/// |---|---|
/// | a GPU | binned: fastest on the H200, at the least memory |
/// | a software device, curves from cells | binned: fastest on both lavapipes |
/// | a software device, hair or `resolve=streaming` or `whole` | two-pass: fastest on both |
///
/// Binned has no `order=captured`, which is left to interlock, where there is one, and to two-pass.
fn choose(context: &Context, scene: &Scene, spec: &Spec) -> (&'static str, String) {
    if let Some(asked) = [INTERLOCK, RASTER_ORDER, TWO_PASS, BINNED].into_iter().find(|p| *p == spec.value("path")) {
        return (asked, "asked for".into());
    }
    let features = context.features();
    if spec.value("order") == "captured" {
        return match features.lacks(Requirement::PixelInterlock) {
            None => (INTERLOCK, "auto: order=captured with fragmentShaderPixelInterlock".into()),
            Some(missing) => (TWO_PASS, format!("auto: order=captured on a device that lacks {missing}")),
        };
    }
    if features.kind != "cpu" {
        return (BINNED, format!("auto: {} device", features.kind));
    }
    match spec.value("resolve") {
        "auto" if !scene.strands.is_empty() => (TWO_PASS, "auto: hair on a software device".into()),
        "auto" | CELLS => (BINNED, "auto: a software device".into()),
        resolve => (TWO_PASS, format!("auto: resolve={resolve} on a software device")),
    }
}
