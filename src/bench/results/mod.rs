//! The schema of `results.json`, version 4. Errors are over all points, and those within a technique's own resolution are also given
//! separately; in earlier versions, errors covered only the other points. A value that a row does not have is absent, never zero. Fields
//! may be added to a version, and are missing in older files; [`Results::read`] also accepts files of versions 1 to 3.

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

/// The schema version that is written.
pub const SCHEMA: u32 = 4;

/// A whole comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`], even if read from an older file.
    pub schema: u32,
    /// The version of this crate.
    pub gobo: String,
    /// The commit from which the program was built. Absent outside git. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Whether any source differed from that commit. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changed: Option<bool>,
    /// The command that produced the results.
    pub command: String,
    /// Conditions that affect the figures, apart from specs and device: option → value, `scene NAME` → the scene's fingerprint. New in
    /// version 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub conditions: BTreeMap<String, String>,
    /// The shard of the run's rows that the file holds. Absent if it holds all rows. New in version 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// The device and driver that the run used.
    pub device: DeviceFacts,
    /// One row per scene and variant, in the order in which they were measured.
    pub rows: Vec<Row>,
    /// The driver's reports about compiled shaders, if requested (`compare --pipeline-statistics`) and available. New in version 3.
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
    /// The Vulkan version that the device supports.
    pub api: String,
    /// Device type: discrete, integrated, virtual, cpu or other.
    #[serde(rename = "type")]
    pub kind: String,
    /// Feature name → value, as `gobo devices` prints them.
    pub features: BTreeMap<String, serde_json::Value>,
    /// Copy bandwidth in bytes per second, if measured (`compare --passes`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub copy_bytes_per_second: Option<f64>,
    /// Fragment-shader arithmetic throughput relative to compute shaders. Absent without timestamps. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<StageRates>,
}

impl DeviceFacts {
    /// Returns the facts of a device, without measured values.
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
    /// The row was measured.
    #[default]
    Ok,
    /// The device lacks a feature; `reason` names it.
    Refused,
    /// Something failed; `reason` names it.
    Failed,
}

/// One technique variant on one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Scene name.
    pub scene: String,
    /// Technique name.
    pub technique: String,
    /// Key → value of the spec, with every key spelt out.
    pub variant: BTreeMap<String, String>,
    /// The path that ran.
    pub path: String,
    /// Painter of the row's picture: `compute` or `raster`; empty without a picture, and in older files, whose pictures were rasterized.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub painter: String,
    /// How it ended.
    pub status: Status,
    /// Why this path ran, why the row was refused, or what failed.
    pub reason: String,
    /// Kinds of casters in the scene that the technique does not see: `smoke`, `hair`, `meshes`, `see-through meshes`. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unseen: Vec<String>,
    /// Device time of the first build after the technique was opened, including commands that were recorded again because a buffer was too
    /// small. New in version 3.
    #[serde(default)]
    pub first_ns: Option<f64>,
    /// Host time of that first build. New in version 3.
    #[serde(default)]
    pub first_host_ns: Option<f64>,
    /// How far the times of the builds can be trusted. New in version 3.
    #[serde(default)]
    pub steadiness: Option<Stability>,
    /// Host time of one build of the representation: recording, submitting, waiting and settling. New in version 2.
    #[serde(default)]
    pub host_ns: Option<Timing>,
    /// Device time of one build of the representation, once it is warm and all buffers are large enough.
    pub build_ns: Option<Timing>,
    /// Device time of a million look-ups at random points.
    pub lookup_ns_per_million: Option<Timing>,
    /// Device time to draw and light the picture once: meshes and casters, with any shading. In files of schemas 1 and 2, with
    /// `shading=forward`, it excludes the time of the meshes. Slow devices have one sample, without a warm-up.
    pub draw_ns: Option<Timing>,
    /// Build time plus `draw_ns`: the time of a frame in which the light has moved. For baked techniques in a static world it is `draw_ns`
    /// alone; files of earlier programs include the bake even then. New in version 2.
    #[serde(default)]
    pub frame_ns: Option<f64>,
    /// What shadows add to a frame: `frame_ns` minus the picture without shadows. Negative if the timing noise is larger. New in version 4;
    /// for rows of older files it is computed from their row `none`, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_ns: Option<f64>,
    /// Band of the cost, from the 5th and 95th percentiles of the times it is computed from. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost_band_ns: Option<[f64; 2]>,
    /// The picture without shadows, drawn in the same way. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unshadowed: Option<Unshadowed>,
    /// Reasons why the row's times must not be compared; empty if there are none. New in version 4.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<String>,
    /// The passes of a build, in order. They may be preceded by a pass that is not part of the build: `world.move` if the world moves, or
    /// `simulate.step`, all steps of a frame together, if the device simulates the scene.
    pub passes: Vec<PassTiming>,
    /// The passes that draw the picture, in order. New in version 2.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub draw_passes: Vec<PassTiming>,
    /// Counts of the passes of a build, followed by those of drawing the picture. Absent unless requested. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub counts: Vec<PassCount>,
    /// Number of bytes that look-ups need. Absent if nothing was built.
    pub bytes_resident: Option<u64>,
    /// Number of bytes needed only during a build. Absent if nothing was built.
    pub bytes_transient: Option<u64>,
    /// Size in bytes of the file that `gobo bake` writes. Absent for techniques that are not baked. New in version 2.
    #[serde(default)]
    pub bytes_on_disk: Option<u64>,
    /// Counts such as `fragments`, `overflowed`, `covered_texels`.
    pub counters: BTreeMap<String, u64>,
    /// Errors against the f64 reference.
    pub error: Option<RowError>,
    /// The lowest mean absolute map error possible for a curve with the same number of nodes, all of which lie on the true curve.
    pub limit_mean_abs: Option<f64>,
    /// Standard error of the map error's mean absolute error, if only a sample of the covered texels was queried. Absent if all were. New
    /// in version 2.
    #[serde(default)]
    pub standard_error: Option<f64>,
    /// Root mean square of (change of the answer − change of the truth) at fixed points, over the frames of a moving world. Absent if
    /// nothing moves. New in version 2.
    #[serde(default)]
    pub flicker_rms: Option<f64>,
    /// Errors of pictures of consecutive frames while the camera circles the scene. Absent if the camera does not move. New in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesError>,
    /// Errors against means over areas, for each size of area. Absent unless requested. New in version 3.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub footprints: Vec<FootprintError>,
    /// Errors in each color, if smoke absorbs some colors more than others; absent otherwise. New in version 3.
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
    /// Median, in nanoseconds.
    pub median_ns: f64,
    /// 5th percentile, in nanoseconds.
    pub p05_ns: f64,
    /// 95th percentile, in nanoseconds.
    pub p95_ns: f64,
    /// Whether the pass draws anything. New in version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<bool>,
}

/// Counts of all passes with the same name in a build, or in drawing a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassCount {
    /// Label of the passes.
    pub name: String,
    /// Number of passes.
    pub runs: u64,
    /// Sums over all of these passes.
    #[serde(flatten)]
    pub counts: PassCounts,
}

/// Errors of one row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowError {
    /// Error at the points from which the picture's light comes, by which rows are chosen. Absent for a technique without a look-up. New in
    /// version 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<SeenError>,
    /// Error at the centres of covered texels: the representation's own error. Absent for a technique without maps.
    pub map: Option<PointError>,
    /// Error at low-discrepancy points in the casters' bounds. Absent for a technique without a look-up.
    pub space: Option<PointError>,
    /// Error at points on surfaces that the camera sees and on all meshes. Absent without meshes. New in version 2.
    #[serde(default)]
    pub surface: Option<PointError>,
    /// Errors at surface points in the shadow of meshes, by the distance of those meshes. Absent without such points. New in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub casters: Option<CasterError>,
    /// Errors of the shaded picture. Absent if its truth would have taken longer than everything else.
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
    /// Under virtual lights, RMSE against one bounce of the lights they represent. Absent unless requested. New in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounce_rmse: Option<f64>,
    /// Standard error of that reference, in the same units. New in version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounce_noise: Option<f64>,
}

impl Results {
    /// Creates results of this program without any rows.
    pub fn new(command: String, conditions: BTreeMap<String, String>, device: DeviceFacts) -> Self {
        let (commit, changed) = match env!("GOBO_COMMIT") {
            "unknown" => (None, None),
            commit => (Some(commit.into()), Some(env!("GOBO_CHANGED") != "false")),
        };
        let gobo = env!("CARGO_PKG_VERSION").into();
        Self { schema: SCHEMA, gobo, commit, changed, command, conditions, device, ..Self::default() }
    }

    /// Returns the edition of the program that produced the results, as far as the file states it: `0.1.0, commit 1a2b3c4d5, changed`.
    pub fn edition(&self) -> String {
        let commit = self.commit.as_ref().map(|commit| format!(", commit {}", commit.get(..9).unwrap_or(commit)));
        let changed = if self.changed == Some(true) { ", changed" } else { "" };
        format!("{}{}{changed}", self.gobo, commit.unwrap_or_default())
    }

    /// Reads a `results.json` of this or an older version, converted to this version.
    ///
    /// # Errors
    /// [`Error::Input`], naming the file, if it is missing, truncated, not a results file, or of a newer version.
    pub fn read(path: &Path) -> Result<Self> {
        /// The part that is read first, to decide whether the rest can be read.
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
            // Version 1 wrote zeros if nothing was built.
            let unbuilt = |row: &&mut Row| row.status != Status::Ok && row.bytes_resident == Some(0);
            for row in results.rows.iter_mut().filter(unbuilt) {
                (row.bytes_resident, row.bytes_transient) = (None, None);
            }
        }
        if schema < 3 {
            for row in &mut results.rows {
                let Some(error) = &mut row.error else { continue };
                let sampled = error.map.and_then(|map| map.within).is_some_and(|within| within.points > 0);
                // In files of versions 1 and 2 the standard error covers only some of the points. So do the classes of `casters`, which do
                // not state how many points are left out.
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

/// Computes the cost for rows of older files, from the row without shadows of the same scene whose picture was drawn in the same way.
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
    /// Whether techniques share this pass: it moves the world, fits views, orders casters or draws opaque maps.
    pub fn is_shared(&self) -> bool {
        ["world.", "simulate.", "maps."].iter().any(|room| self.name.starts_with(room))
    }
}

/// A default that older files spell as a word and that is now `auto`: technique, key, word. Both mean the same, except with
/// `detail=adaptive`.
const WAS: (&str, &str, &str) = ("avsm", "storage", "full");

impl Row {
    /// Returns the value of a key of its variant. A default that an older program spelt differently is returned in its current spelling.
    pub fn value(&self, key: &str) -> Option<&str> {
        let value = self.variant.get(key)?;
        let was = (self.technique.as_str(), key, value.as_str()) == WAS;
        let is_even = self.variant.get("detail").is_none_or(|detail| detail == "even");
        Some(if was && is_even { AUTO } else { value })
    }

    /// Returns the device time of those passes of a build that techniques share: passes that move the world, fit views, order casters and
    /// draw opaque maps. `None` if no pass was timed.
    pub fn shared_ns(&self) -> Option<f64> {
        (!self.passes.is_empty())
            .then(|| self.passes.iter().filter(|pass| pass.is_shared()).map(|pass| pass.median_ns).sum())
    }

    /// Returns the spec of this row, short enough for a table: `avsm:nodes=8,curve=linear,…`.
    pub fn spec(&self) -> String {
        let keys: Vec<_> = self.variant.iter().map(|(k, v)| format!("{k}={v}")).collect();
        format!("{}:{}", self.technique, keys.join(","))
    }
}
