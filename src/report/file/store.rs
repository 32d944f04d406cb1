//! The output folder. Its files are written completely or not at all.

use crate::bench::{COLORS, ColorError, FOOTPRINTS, PassTiming, PointError, Results, Row, Timing};
use crate::report::file::atomic_write::{write_png, write_whole};
use crate::report::format::status_word;
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// A folder for results.
#[derive(Clone, Debug)]
pub struct Store {
    dir: PathBuf,
}

impl Store {
    /// Creates the folder and its parents, unless it exists.
    ///
    /// # Errors
    /// [`Error::Output`] if the name is taken by something else, or permission is missing.
    pub fn open(dir: &Path) -> Result<Self> {
        std::fs::create_dir_all(dir).map_err(|cause| Error::output(dir, cause))?;
        Ok(Self { dir: dir.to_path_buf() })
    }

    /// Returns the folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Writes `results.json` and `results.csv`. Meant to be called after every row, so that an interrupted run keeps its rows.
    ///
    /// # Errors
    /// [`Error::Output`] names the file; an older file of that name stays unchanged.
    pub fn write(&self, results: &Results) -> Result<()> {
        let mut json =
            serde_json::to_vec_pretty(results).map_err(|cause| Error::output(&self.dir.join("results.json"), cause))?;
        json.push(b'\n');
        self.write_bytes("results.json", &json)?;
        let csv = comma_separated(results).map_err(|cause| Error::output(&self.dir.join("results.csv"), cause))?;
        self.write_bytes("results.csv", &csv)
    }

    /// Writes a text file, such as `report.html` or `time-vs-error.svg`.
    ///
    /// # Errors
    /// See [`Store::write`].
    pub fn write_text(&self, name: &str, text: &str) -> Result<()> {
        self.write_bytes(name, text.as_bytes())
    }

    /// Writes a PNG of `width` × `height` pixels from `rgb8`: rows from the top, three bytes per pixel.
    ///
    /// # Errors
    /// See [`Store::write`]; also if `rgb8` does not have `width * height * 3` bytes.
    pub fn write_picture(&self, name: &str, width: u32, height: u32, rgb8: &[u8]) -> Result<()> {
        self.check(name)?;
        write_png(&self.dir.join(name), [width, height], rgb8)
    }

    /// Writes a file with arbitrary bytes.
    ///
    /// # Errors
    /// See [`Store::write`].
    pub fn write_file(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.write_bytes(name, bytes)
    }

    /// Checks that a file of that name may be created or replaced. Writing checks again.
    ///
    /// # Errors
    /// [`Error::Output`] if the name belongs to a folder or a device.
    pub fn check(&self, name: &str) -> Result<()> {
        let path = self.dir.join(name);
        if !is_plain_name(name) {
            return Err(Error::output(&path, "the name must be that of a file in the output folder"));
        }
        match std::fs::metadata(&path) {
            Ok(there) if !there.is_file() => Err(Error::output(&path, "what is there is not a regular file")),
            _ => Ok(()),
        }
    }

    fn write_bytes(&self, name: &str, bytes: &[u8]) -> Result<()> {
        self.check(name)?;
        write_whole(&self.dir.join(name), bytes)
    }
}

/// Whether a name stays inside the folder that it is joined to.
pub(in crate::report) fn is_plain_name(name: &str) -> bool {
    let mut components = Path::new(name).components();
    matches!((components.next(), components.next()), (Some(Component::Normal(only)), None) if only == name)
}

/// Columns for each kind of points, prefixed with the kind's name: `map_mean_abs`.
const POINT_COLUMNS: [&str; 15] = [
    "points",
    "mean_abs",
    "bias",
    "rms",
    "p99",
    "max",
    "leaks",
    "false_shadows",
    "within_points",
    "within_mean_abs",
    "within_leaks",
    "within_false_shadows",
    "beyond_mean_abs",
    "beyond_leaks",
    "beyond_false_shadows",
];

/// Columns for each kind of points and each color, prefixed with both names: `space_red_mean_abs`. Omitted if no scene has colors.
const COLOR_COLUMNS: [&str; 3] = ["mean_abs", "bias", "max"];

/// Returns CSV with one flat line per row. Numbers have full precision; missing values are empty fields.
fn comma_separated(results: &Results) -> std::result::Result<Vec<u8>, Box<dyn std::error::Error>> {
    let counters: BTreeSet<&str> =
        results.rows.iter().flat_map(|row| row.counters.keys()).map(String::as_str).collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let naming = ["scene", "technique", "variant", "path", "painter", "status", "reason", "unseen", "marks"];
    let mut names: Vec<String> = naming.map(String::from).into();
    names.extend(["build_median_ns", "build_p05_ns", "build_p95_ns", "samples"].map(String::from));
    names.extend(["host_median_ns", "host_p05_ns", "host_p95_ns", "host_samples"].map(String::from));
    names.extend(["first_ns", "first_host_ns", "shared_median_ns"].map(String::from));
    names.extend(["spread", "clock_low_mhz", "clock_high_mhz", "busy", "measured_again"].map(String::from));
    names.extend(["pass_median_ns", "lookup_median_ns_per_million"].map(String::from));
    names.extend(
        ["draw_median_ns", "draw_p05_ns", "draw_p95_ns", "draw_samples", "draw_pass_median_ns"].map(String::from),
    );
    names.extend(["frame_ns", "cost_ns", "cost_low_ns", "cost_high_ns"].map(String::from));
    names.extend(["unshadowed_draw_median_ns", "unshadowed_seen_mean", "unshadowed_flip_mean"].map(String::from));
    names.extend(["bytes_resident", "bytes_transient", "bytes_on_disk"].map(String::from));
    names.extend(["seen_points", "seen_mean", "seen_bias", "seen_p99", "seen_standard_error"].map(String::from));
    for points in ["map", "space", "surface"] {
        names.extend(POINT_COLUMNS.map(|column| format!("{points}_{column}")));
    }
    names.extend(["image_rmse", "image_flip_mean", "image_bounce_rmse", "image_bounce_noise"].map(String::from));
    names.extend(["limit_mean_abs", "standard_error", "flicker_rms"].map(String::from));
    names.extend(["frames_rmse", "frames_flicker_rms"].map(String::from));
    let asked = results.rows.iter().any(|row| !row.footprints.is_empty());
    if asked {
        names.extend(
            FOOTPRINTS
                .iter()
                .flat_map(|texels| ["rms", "noise", "bias"].map(|what| format!("footprint_{texels}_{what}"))),
        );
    }
    let colored = results.rows.iter().any(|row| !row.colors.is_empty());
    if colored {
        let columns = |points: &'static str| {
            let of = move |color: &&'static str| COLOR_COLUMNS.map(|column| format!("{points}_{color}_{column}"));
            COLORS.iter().flat_map(of)
        };
        names.extend(["space", "surface"].into_iter().flat_map(columns));
    }
    // Prefixed, since a counter may have the name of a column.
    names.extend(counters.iter().map(|name| format!("counter_{name}")));
    writer.write_record(&names)?;
    for row in &results.rows {
        writer.write_record(fields(row, asked, colored, &counters))?;
    }
    Ok(writer.into_inner().map_err(|failed| failed.into_error())?)
}

fn fields(row: &Row, footprints: bool, colored: bool, counters: &BTreeSet<&str>) -> Vec<String> {
    let mut fields = vec![
        row.scene.clone(),
        row.technique.clone(),
        row.spec(),
        row.path.clone(),
        row.painter.clone(),
        status_word(row.status).into(),
        row.reason.clone(),
        row.unseen.join(" "),
        row.marks.join("; "),
    ];
    let timing = |timing: Option<Timing>| {
        let [median, p05, p95] =
            [|t: Timing| t.median, |t: Timing| t.p05, |t: Timing| t.p95].map(|of| number(timing.map(of)));
        [median, p05, p95, timing.map(|t| t.samples.to_string()).unwrap_or_default()]
    };
    fields.extend(timing(row.build_ns));
    fields.extend(timing(row.host_ns));
    fields.extend([row.first_ns, row.first_host_ns, row.shared_ns()].map(number));
    let steady = row.steadiness.unwrap_or_default();
    let [low, high] = steady.clock_mhz.map_or([None; 2], |[low, high]| [Some(low), Some(high)]);
    fields.extend([steady.spread, low, high, steady.busy].map(number));
    fields.push(row.steadiness.map(|s| s.measured_again.to_string()).unwrap_or_default());
    let passes = |of: &[PassTiming]| {
        of.iter().map(|pass| format!("{}={}", pass.name, pass.median_ns)).collect::<Vec<_>>().join(" ")
    };
    fields.push(passes(&row.passes));
    fields.push(number(row.lookup_ns_per_million.map(|timing| timing.median)));
    fields.extend(timing(row.draw_ns));
    fields.push(passes(&row.draw_passes));
    let [low, high] = row.cost_band_ns.map_or([None; 2], |band| band.map(Some));
    fields.extend([row.frame_ns, row.cost_ns, low, high].map(number));
    let bare = row.unshadowed.unwrap_or_default();
    fields.extend([bare.draw_ns.map(|draw| draw.median), bare.seen, bare.flip_mean].map(number));
    fields.extend([row.bytes_resident, row.bytes_transient, row.bytes_on_disk].map(count));
    let error = row.error.as_ref();
    let seen = error.and_then(|error| error.seen);
    fields.push(count(seen.map(|seen| seen.points)));
    fields.extend([seen.map(|s| s.mean), seen.map(|s| s.bias), seen.map(|s| s.p99)].map(number));
    fields.push(number(seen.and_then(|seen| seen.standard_error)));
    for points in [error.and_then(|e| e.map), error.and_then(|e| e.space), error.and_then(|e| e.surface)] {
        fields.extend(point_fields(points));
    }
    let image = error.and_then(|error| error.image);
    fields.extend([image.map(|image| image.rmse), image.map(|image| image.flip_mean)].map(number));
    fields.extend([image.and_then(|image| image.bounce_rmse), image.and_then(|image| image.bounce_noise)].map(number));
    fields.extend([row.limit_mean_abs, row.standard_error, row.flicker_rms].map(number));
    fields.extend([row.frames.map(|frames| frames.rmse), row.frames.map(|frames| frames.flicker_rms)].map(number));
    let sizes = if footprints { &FOOTPRINTS[..] } else { &[] };
    for texels in sizes {
        let of = row.footprints.iter().find(|error| error.texels == *texels);
        fields.extend([of.map(|e| e.rms), of.map(|e| e.noise), of.map(|e| e.bias)].map(number));
    }
    if colored {
        let of = |points: fn(&ColorError) -> Option<PointError>| {
            let error = move |color: &&str| row.colors.iter().find(|e| e.color == **color).and_then(points);
            COLORS
                .iter()
                .map(error)
                .flat_map(|e| [e.map(|e| e.mean_abs), e.and_then(|e| e.bias), e.and_then(|e| e.max)])
        };
        fields.extend(of(|e| e.space).chain(of(|e| e.surface)).map(number));
    }
    fields.extend(counters.iter().map(|&name| row.counters.get(name).map(u64::to_string).unwrap_or_default()));
    fields
}

/// Returns the fields for [`POINT_COLUMNS`].
fn point_fields(points: Option<PointError>) -> [String; POINT_COLUMNS.len()] {
    let statistic = |of: fn(PointError) -> Option<f64>| number(points.and_then(of));
    let (within, beyond) = (points.and_then(|e| e.within), points.and_then(|e| e.beyond()));
    [
        count(points.and_then(|e| e.points)),
        statistic(|e| Some(e.mean_abs)),
        statistic(|e| e.bias),
        statistic(|e| e.rms),
        statistic(|e| e.p99),
        statistic(|e| e.max),
        count(points.and_then(|e| e.leaks)),
        count(points.and_then(|e| e.false_shadows)),
        count(within.map(|w| w.points)),
        number(within.and_then(|w| w.mean_abs)),
        count(within.map(|w| w.leaks)),
        count(within.map(|w| w.false_shadows)),
        number(beyond.and_then(|b| b.mean_abs)),
        count(beyond.map(|b| b.leaks)),
        count(beyond.map(|b| b.false_shadows)),
    ]
}

fn number(value: Option<f64>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}

fn count(value: Option<u64>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}
