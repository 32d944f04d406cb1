//! The schema of `results.json`, version 4. Errors are over all points, and those within a technique's own resolution
//! are also given separately; in earlier versions, errors were over the other points alone. A value that a row does not
//! have is absent, never zero. Fields may be added to a version, and are missing in older files; [`Results::read`]
//! takes files of versions 1 to 3 too.

pub(super) mod cross_device;
pub(super) mod regression;
pub(super) mod shards;
pub mod standard;
pub(super) mod submission;

use crate::bench::{
    CasterError, ColorError, FootprintError, PointError, SeenError, Shard, Stability, StageRates, Timing, Unshadowed,
};
use crate::gpu::{Executable, Features, PassCounts};
use crate::technique::settings::AUTO;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The version that is written.
pub const SCHEMA: u32 = 4;

/// A whole comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`], also when it was read from an older file.
    pub schema: u32,
    /// The version of this crate.
    pub gobo: String,
    /// The commit that the program was built from. Absent outside git. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Whether a source differed from that commit. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changed: Option<bool>,
    /// The command that made it.
    pub command: String,
    /// Conditions that the figures depend on, besides specs and device: option → value, `scene NAME` → the scene's
    /// fingerprint. New in version 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub conditions: BTreeMap<String, String>,
    /// Which part of the run's rows the file holds. Absent where it holds all. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// The device and driver that it ran on.
    pub device: DeviceFacts,
    /// One per scene and variant, in the order they were measured.
    pub rows: Vec<Row>,
    /// The driver's reports about compiled shaders, where asked for (`compare --pipeline-statistics`) and available. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub executables: Vec<Executable>,
}

/// The device and driver.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceFacts {
    /// The device's own name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// The Vulkan version it speaks.
    pub api: String,
    /// discrete, integrated, virtual, cpu or other.
    #[serde(rename = "type")]
    pub kind: String,
    /// Feature name → value, as `gobo devices` prints them.
    pub features: BTreeMap<String, serde_json::Value>,
    /// How fast it copies, where that was measured (`compare --passes`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub copy_bytes_per_second: Option<f64>,
    /// How fast fragments compute, beside compute threads. Absent without timestamps. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<StageRates>,
}

impl DeviceFacts {
    /// The facts of a device, without what is measured.
    pub fn of(features: &Features) -> Self {
        Self {
            name: features.name.clone(),
            driver: features.driver.clone(),
            api: features.api.clone(),
            kind: features.kind.to_string(),
            features: features.facts(),
            copy_bytes_per_second: None,
            stages: None,
        }
    }
}

/// How a row ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Measured.
    #[default]
    Ok,
    /// The device lacks a feature; `reason` names it.
    Refused,
    /// Something broke; `reason` names it.
    Failed,
}

/// One technique variant on one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Scene name.
    pub scene: String,
    /// Technique name.
    pub technique: String,
    /// Key → value of the spec, every key spelt out.
    pub variant: BTreeMap<String, String>,
    /// The path that ran.
    pub path: String,
    /// What made its picture: `compute` or `raster`; empty in older files, whose pictures are the rasterizer's, and without a picture.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub painter: String,
    /// How it ended.
    pub status: Status,
    /// Why this path ran, why the row was refused, or what failed.
    pub reason: String,
    /// Casters of the scene that the technique does not see: `smoke`, `hair`, `meshes`. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unseen: Vec<String>,
    /// Device time of the first build since the technique was opened, with commands that were recorded again because a
    /// buffer had too little room. New in version 3.
    #[serde(default)]
    pub first_ns: Option<f64>,
    /// Host time of that first build. New in version 3.
    #[serde(default)]
    pub first_host_ns: Option<f64>,
    /// How far the times of the builds may be trusted. New in version 3.
    #[serde(default)]
    pub steadiness: Option<Stability>,
    /// One build of the representation, host time: recording, submitting, waiting and settling. New in version 2.
    #[serde(default)]
    pub host_ns: Option<Timing>,
    /// Device time of one build of the representation, once it is warm and everything has room.
    pub build_ns: Option<Timing>,
    /// Device time of a million look-ups at random points.
    pub lookup_ns_per_million: Option<Timing>,
    /// Device time of drawing and lighting the picture once: meshes and casters, with any shading. In files of schemas 1 and 2, with
    /// `shading=forward`, the time of the meshes is not in it. Slow devices have one sample, which is not warmed up.
    pub draw_ns: Option<Timing>,
    /// The times of a build and of `draw_ns` together: the time of a frame whose light has moved. For baked techniques in a still world it
    /// is `draw_ns` alone; in files of earlier programs it includes the bake there too. New in version 2.
    #[serde(default)]
    pub frame_ns: Option<f64>,
    /// What shadows add to a frame: `frame_ns` less the picture without shadows. Below 0 where the noise of times is larger. New in
    /// version 4; for rows of older files it comes from their row `none`, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_ns: Option<f64>,
    /// Between which times the cost lies, by the 5th and 95th percentiles of the times that it is made of. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_band_ns: Option<[f64; 2]>,
    /// The picture without shadows, drawn the same way. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unshadowed: Option<Unshadowed>,
    /// Reasons why its times decide no answer. Empty where they may. New in version 4.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<String>,
    /// The passes of a build, in order. A pass that is no part of the build may stand before them: `world.move` where the world moves, or
    /// `simulate.step`, all steps of a frame together, where the device simulates the scene.
    pub passes: Vec<PassTiming>,
    /// The passes of drawing the picture, in order. New in version 2.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub draw_passes: Vec<PassTiming>,
    /// Counts of the passes of a build, and behind them of drawing the picture. Absent unless asked for. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counts: Vec<PassCount>,
    /// Bytes that the look-up needs. Absent where nothing was built.
    pub bytes_resident: Option<u64>,
    /// Bytes needed only while building. Absent where nothing was built.
    pub bytes_transient: Option<u64>,
    /// Bytes of the file that `gobo bake` writes. Absent for techniques that are not baked. New in version 2.
    #[serde(default)]
    pub bytes_on_disk: Option<u64>,
    /// Counts such as `fragments`, `overflowed`, `covered_texels`.
    pub counters: BTreeMap<String, u64>,
    /// Against the f64 reference.
    pub error: Option<RowError>,
    /// The lowest mean absolute map error that a curve with as many nodes can have, if its vertices lie on the true
    /// curve.
    pub limit_mean_abs: Option<f64>,
    /// Standard error of the map error's mean absolute error, where only a sample of the covered texels was asked.
    /// Absent where all were. New in version 2.
    #[serde(default)]
    pub standard_error: Option<f64>,
    /// Over the frames of a moving world, the root mean square of (change of the answer − change of the truth) at fixed points.
    /// Absent where nothing moves. New in version 2.
    #[serde(default)]
    pub flicker_rms: Option<f64>,
    /// Errors of pictures of consecutive frames, with a camera that goes around. Absent where the camera is still. New
    /// in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesError>,
    /// Errors against means over areas, for each size of area. Absent unless asked for. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub footprints: Vec<FootprintError>,
    /// Errors of each color, where smoke absorbs some colors more than others. Absent elsewhere. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colors: Vec<ColorError>,
    /// The picture's file name in the output folder.
    pub picture: Option<String>,
    /// The difference picture's file name in the output folder.
    pub difference: Option<String>,
}

/// The time of one pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassTiming {
    /// The pass's label.
    pub name: String,
    /// Nanoseconds.
    pub median_ns: f64,
    /// Nanoseconds.
    pub p05_ns: f64,
    /// Nanoseconds.
    pub p95_ns: f64,
    /// Whether anything is drawn in it. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<bool>,
}

/// Counts of all passes of one name in a build, or in drawing a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassCount {
    /// The passes' label.
    pub name: String,
    /// How many.
    pub runs: u64,
    /// Sums over all of them.
    #[serde(flatten)]
    pub counts: PassCounts,
}

/// Errors of one row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowError {
    /// Where the light of the picture comes from: the error that rows are chosen by. Absent for a technique without a look-up. New in
    /// version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<SeenError>,
    /// At the centres of covered texels: the representation's own error. Absent for a technique without maps.
    pub map: Option<PointError>,
    /// At low-discrepancy points in the casters' bounds. Absent for a technique without a look-up.
    pub space: Option<PointError>,
    /// At points on surfaces that the camera sees and on all meshes. Absent without meshes. New in version 2.
    #[serde(default)]
    pub surface: Option<PointError>,
    /// Errors at surface points in the shadow of meshes, by the distance of the meshes. Absent without such points. New
    /// in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub casters: Option<CasterError>,
    /// Errors of the shaded picture. Absent where its truth would have taken longer than all else.
    #[serde(default)]
    pub image: Option<ImageError>,
}

/// Errors of pictures of consecutive frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FramesError {
    /// Root mean square over frames, pixels and channels, display-referred [0, 1].
    pub rmse: f64,
    /// Root mean square of (change of the picture − change of the true picture) from frame to frame.
    pub flicker_rms: f64,
}

/// Error of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageError {
    /// Root mean square over pixels and channels, display-referred [0, 1].
    pub rmse: f64,
    /// Mean of the FLIP map.
    pub flip_mean: f64,
    /// Under virtual lights, RMSE against one bounce of the lights that they represent. Absent unless asked for. New in
    /// version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounce_rmse: Option<f64>,
    /// The standard error of that reference, in the same units. New in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounce_noise: Option<f64>,
}

impl Results {
    /// No row yet, from this program.
    pub fn new(command: String, conditions: BTreeMap<String, String>, device: DeviceFacts) -> Self {
        let (commit, changed) = match env!("GOBO_COMMIT") {
            "unknown" => (None, None),
            commit => (Some(commit.into()), Some(env!("GOBO_CHANGED") != "false")),
        };
        let gobo = env!("CARGO_PKG_VERSION").into();
        Self { schema: SCHEMA, gobo, commit, changed, command, conditions, device, ..Self::default() }
    }

    /// The program that made the results: `0.1.0, commit 1a2b3c4d5, changed`, as far as the file says.
    pub fn edition(&self) -> String {
        let commit = self.commit.as_ref().map(|commit| format!(", commit {}", commit.get(..9).unwrap_or(commit)));
        let changed = if self.changed == Some(true) { ", changed" } else { "" };
        format!("{}{}{changed}", self.gobo, commit.unwrap_or_default())
    }

    /// Reads a `results.json` of this version or an older one, as one of this version.
    ///
    /// # Errors
    /// [`Error::Input`] names the file where it is missing, cut off, not a file of results, or of a newer version.
    pub fn read(path: &Path) -> Result<Self> {
        /// The part that is read first, to know whether the rest can be read.
        #[derive(Deserialize)]
        struct Version {
            schema: u32,
        }
        const AGAIN: &str = "measure again with gobo compare";
        let input = |cause: String, way_out: &str| Error::input(path.display().to_string(), cause, way_out);
        let damaged = |cause: serde_json::Error| input(format!("no whole results.json: {cause}"), AGAIN);
        let json = std::fs::read(path)
            .map_err(|cause| input(cause.to_string(), "name the results.json in a folder that gobo compare wrote"))?;
        let Version { schema } = serde_json::from_slice(&json).map_err(damaged)?;
        if !(1..=SCHEMA).contains(&schema) {
            let cause = format!("schema {schema}, and this gobo reads 1 to {SCHEMA}");
            return Err(input(cause, &format!("use the gobo that wrote it, or {AGAIN}")));
        }
        let mut results: Self = serde_json::from_slice(&json).map_err(damaged)?;
        if schema == 1 {
            // Version 1 wrote zeros where nothing was built.
            let unbuilt = |row: &&mut Row| row.status != Status::Ok && row.bytes_resident == Some(0);
            for row in results.rows.iter_mut().filter(unbuilt) {
                (row.bytes_resident, row.bytes_transient) = (None, None);
            }
        }
        if schema < 3 {
            for row in &mut results.rows {
                let Some(error) = &mut row.error else { continue };
                let sampled = error.map.and_then(|map| map.within).is_some_and(|within| within.points > 0);
                // In files of versions 1 and 2 the standard error is over a part of the points. So are the classes of
                // `casters`, which do not say how many points are left out.
                row.standard_error = row.standard_error.filter(|_| !sampled);
                error.casters = None;
                let kinds = [&mut error.map, &mut error.space, &mut error.surface];
                kinds.into_iter().flatten().for_each(PointError::over_all_points);
            }
        }
        if schema < 4 {
            cost_by_rows(&mut results.rows);
        }
        results.schema = SCHEMA;
        Ok(results)
    }
}

/// The cost of rows of older files, from the row of the same scene without shadows whose picture was drawn the same way.
fn cost_by_rows(rows: &mut [Row]) {
    const WAYS: [&str; 7] = ["painter", "shading", "lighting", "dither", "blur", "history", "shadows"];
    let way = |row: &Row| (row.scene.clone(), WAYS.map(|key| row.variant.get(key).cloned()));
    let bare: Vec<_> = rows.iter().filter(|row| row.technique == "none").map(|row| (way(row), row.draw_ns)).collect();
    for row in rows {
        let without = bare.iter().find(|(drawn, _)| *drawn == way(row)).and_then(|(_, draw)| *draw);
        row.cost_ns = row.frame_ns.zip(without).map(|(frame, without)| frame - without.median);
    }
}

impl PassTiming {
    /// Whether techniques share it: it moves the world, fits views, orders casters or draws opaque maps.
    pub fn is_shared(&self) -> bool {
        ["world.", "simulate.", "maps."].iter().any(|room| self.name.starts_with(room))
    }
}

/// A default that older files write as a word, and that is `auto` now: technique, key, word. Both mean the same, except
/// with `detail=adaptive`.
const WAS: (&str, &str, &str) = ("avsm", "storage", "full");

impl Row {
    /// The value of a key of its variant. A default that an older program wrote as another word is given as the present
    /// word.
    pub fn value(&self, key: &str) -> Option<&str> {
        let value = self.variant.get(key)?;
        let was = (self.technique.as_str(), key, value.as_str()) == WAS;
        let is_even = self.variant.get("detail").is_none_or(|detail| detail == "even");
        Some(if was && is_even { AUTO } else { value })
    }

    /// Device time of the passes of a build that techniques share: passes that move the world, fit views, order casters
    /// and draw opaque maps. Absent where no pass was timed.
    pub fn shared_ns(&self) -> Option<f64> {
        (!self.passes.is_empty())
            .then(|| self.passes.iter().filter(|pass| pass.is_shared()).map(|pass| pass.median_ns).sum())
    }

    /// The spec that made this row, short enough for a table: `avsm:nodes=8,curve=linear,…`.
    pub fn spec(&self) -> String {
        let keys: Vec<_> = self.variant.iter().map(|(k, v)| format!("{k}={v}")).collect();
        format!("{}:{}", self.technique, keys.join(","))
    }
}
