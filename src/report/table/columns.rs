//! The measured columns that the table and the page share.

use crate::bench::{ColorError, PointError, Row, SeenError, Status};
use crate::report::format::{
    NOTHING, bytes, grouped, milliseconds, one_digit, percent, signed, significant, spread_milliseconds,
};
use crate::report::warnings::MARK;

/// Group of the time columns.
const TIMES: &str = "Time, ms";

/// One measured column.
pub(in crate::report) struct Column {
    /// Heading shared by neighbouring columns.
    pub(in crate::report) group: &'static str,
    /// Heading of this column, within the group.
    pub(in crate::report) name: &'static str,
    /// Group and name together, short enough for a terminal, with the unit.
    pub(in crate::report) heading: &'static str,
    /// One sentence, shown when the pointer is on the heading.
    pub(in crate::report) meaning: &'static str,
    /// On a narrow terminal, columns with larger numbers are left out first. Cost, seen error, resident, FLIP and build are worth most.
    pub(in crate::report) dispensable: u8,
    /// Returns the number to sort by.
    pub(in crate::report) value: fn(&Row) -> Option<f64>,
    /// Formats the number.
    pub(in crate::report) text: fn(f64) -> String,
    /// Formats the small text after the number.
    pub(in crate::report) spread: fn(&Row) -> Option<String>,
}

impl Column {
    /// Returns the number, its mark and its spread as one text.
    pub(in crate::report) fn cell(&self, row: &Row) -> String {
        let Some(value) = (self.value)(row) else { return NOTHING.into() };
        let number = (self.text)(value) + if self.is_marked(row) { MARK } else { "" };
        match (self.spread)(row) {
            Some(spread) => format!("{number} {spread}"),
            None => number,
        }
    }

    /// Whether the number is a time marked as not comparable.
    pub(in crate::report) fn is_marked(&self, row: &Row) -> bool {
        self.group == TIMES && !row.marks.is_empty() && (self.value)(row).is_some()
    }
}

const fn column(
    group: &'static str,
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
    dispensable: u8,
    value: fn(&Row) -> Option<f64>,
    text: fn(f64) -> String,
) -> Column {
    Column { group, name, heading, meaning, dispensable, value, text, spread: |_| None }
}

fn times(value: f64) -> String {
    format!("{}×", significant(value))
}

fn bytes_text(value: f64) -> String {
    bytes(value as u64)
}

fn seen(row: &Row) -> Option<SeenError> {
    row.error.as_ref()?.seen
}

/// Formats the band of the cost, as text after the cost.
fn cost_band(row: &Row) -> Option<String> {
    let [low, high] = row.cost_band_ns.filter(|_| row.technique != "none")?.map(milliseconds);
    Some(format!("[{low}–{high}]"))
}

fn map(row: &Row) -> Option<PointError> {
    row.error.as_ref()?.map
}

fn space(row: &Row) -> Option<PointError> {
    row.error.as_ref()?.space
}

fn surface(row: &Row) -> Option<PointError> {
    row.error.as_ref()?.surface
}

/// Returns the mean absolute error of one color.
fn color(row: &Row, name: &str, points: fn(&ColorError) -> Option<PointError>) -> Option<f64> {
    Some(row.colors.iter().find(|error| error.color == name).and_then(points)?.mean_abs)
}

/// Returns the number of leaks; `None` if nothing opaque casts, since nothing can leak then.
fn leaks(points: Option<PointError>) -> Option<f64> {
    let points = points.filter(|points| points.within.is_some())?;
    Some(points.leaks? as f64)
}

/// Formats the error of the points within the resolution, as text after their share.
fn error_within(points: Option<PointError>) -> Option<String> {
    Some(format!("({})", significant(points?.within?.mean_abs?)))
}

/// Formats the number of false shadows, as text after the number of leaks.
fn false_shadows(points: Option<PointError>) -> Option<String> {
    Some(format!("/ {}", grouped(points?.false_shadows?)))
}

fn count_text(value: f64) -> String {
    grouped(value as u64)
}

fn times_limit(row: &Row) -> Option<f64> {
    let limit = row.limit_mean_abs?;
    // A limit of zero has no multiples.
    (limit > 0.0).then_some(map(row)?.mean_abs / limit)
}

/// Returns the columns in which a measured row has a value.
pub(in crate::report) fn shown<'a>(rows: impl Iterator<Item = &'a Row> + Clone) -> Vec<&'static Column> {
    let has_value = |column: &&Column| rows.clone().any(|r| r.status == Status::Ok && (column.value)(r).is_some());
    COLUMNS.iter().filter(has_value).collect()
}

const WITHIN: &str = "The share of the points that is nearer to an opaque shadow's edge than the technique resolves, \
                      and their mean absolute error";

const LEAKS: &str = "Points that no light reaches but the answer is more than half, / that all \
                     light reaches but it is less than half";

/// All columns, in display order.
const COLUMNS: [Column; 37] = [
    Column {
        spread: |row| row.build_ns.as_ref().map(spread_milliseconds),
        ..column(
            TIMES,
            "build",
            "build ms",
            "One build of the representation on the device: median [5th–95th percentile]",
            6,
            |row| Some(row.build_ns?.median),
            milliseconds,
        )
    },
    Column {
        spread: |row| Some(format!("(host {})", milliseconds(row.first_host_ns?))),
        ..column(
            TIMES,
            "first",
            "first ms",
            "The first build of a baked technique, by the device and by the host, with all that was recorded again in it",
            14,
            |row| row.first_ns.filter(|_| row.bytes_on_disk.is_some()),
            milliseconds,
        )
    },
    column(
        TIMES,
        "host",
        "host ms",
        "One build on the host: recording, submitting, waiting and settling, median",
        13,
        |row| Some(row.host_ns?.median),
        milliseconds,
    ),
    column(
        TIMES,
        "10⁶ look-ups",
        "look-up ms/M",
        "A million look-ups at random points on the device, median",
        8,
        |row| Some(row.lookup_ns_per_million?.median),
        milliseconds,
    ),
    column(
        TIMES,
        "draw",
        "draw ms",
        "The picture, drawn and lit once on the device: meshes and casters, median",
        12,
        |row| Some(row.draw_ns?.median),
        milliseconds,
    ),
    column(
        TIMES,
        "frame",
        "frame ms",
        "A build and the lit picture, as in a frame whose light has moved; for baked techniques in a still world, the picture alone",
        7,
        |row| row.frame_ns,
        milliseconds,
    ),
    Column {
        spread: cost_band,
        ..column(
            "Time, ms",
            "cost",
            "cost ms",
            "What shadows add to a frame: the frame less the picture without shadows, drawn the same way [5th–95th percentile]",
            0,
            |row| row.cost_ns,
            milliseconds,
        )
    },
    column(
        "Memory",
        "resident",
        "resident",
        "Bytes that the look-up needs",
        1,
        |row| Some(row.bytes_resident? as f64),
        bytes_text,
    ),
    column(
        "Memory",
        "transient",
        "transient",
        "Bytes that only the build needs",
        11,
        |row| Some(row.bytes_transient? as f64),
        bytes_text,
    ),
    column(
        "Memory",
        "on disk",
        "on disk",
        "Bytes of the file that gobo bake writes",
        20,
        |row| Some(row.bytes_on_disk? as f64),
        bytes_text,
    ),
    Column {
        spread: |row| Some(format!("±{}", one_digit(seen(row)?.standard_error?))),
        ..column(
            "Seen",
            "error",
            "seen error",
            "The share of the light in the picture that is wrong, at points from which light comes to the camera ± its standard error",
            0,
            |row| Some(seen(row)?.mean),
            significant,
        )
    },
    column(
        "Seen",
        "bias",
        "seen bias",
        "The same with its sign: positive is too bright",
        9,
        |row| Some(seen(row)?.bias),
        signed,
    ),
    Column {
        spread: |row| Some(format!("±{}", one_digit(row.standard_error?))),
        ..column(
            "Error at map points",
            "mean abs",
            "map |err|",
            "Mean absolute error of visibility at covered texel centres ± its standard error, where they were sampled",
            4,
            |row| Some(map(row)?.mean_abs),
            significant,
        )
    },
    column(
        "Error at map points",
        "× limit",
        "× limit",
        "Mean absolute error, as a multiple of the least that as many nodes can have",
        7,
        times_limit,
        times,
    ),
    column(
        "Error at map points",
        "bias",
        "bias",
        "Signed mean: positive is too bright",
        14,
        |row| map(row)?.bias,
        signed,
    ),
    column("Error at map points", "RMS", "RMS", "Root mean square", 19, |row| map(row)?.rms, significant),
    column("Error at map points", "p99", "p99", "99th percentile", 18, |row| map(row)?.p99, significant),
    column("Error at map points", "max", "max", "Largest absolute error", 15, |row| map(row)?.max, significant),
    column(
        "In space",
        "mean abs",
        "space |err|",
        "Mean absolute error at points all over the casters' bounds",
        5,
        |row| Some(space(row)?.mean_abs),
        significant,
    ),
    Column {
        spread: |row| error_within(space(row)),
        ..column("In space", "within", "space within", WITHIN, 16, |row| space(row)?.share_within(), percent)
    },
    Column {
        spread: |row| false_shadows(space(row)),
        ..column("In space", "leaks / false", "space leaks/false", LEAKS, 10, |row| leaks(space(row)), count_text)
    },
    column(
        "On surfaces",
        "mean abs",
        "surface |err|",
        "Mean absolute error at surface points: those that the camera sees, and others on all meshes",
        3,
        |row| Some(surface(row)?.mean_abs),
        significant,
    ),
    Column {
        spread: |row| error_within(surface(row)),
        ..column("On surfaces", "within", "surface within", WITHIN, 15, |row| surface(row)?.share_within(), percent)
    },
    Column {
        spread: |row| false_shadows(surface(row)),
        ..column("On surfaces", "leaks / false", "surface leaks/false", LEAKS, 9, |row| leaks(surface(row)), count_text)
    },
    column(
        "In space, by color",
        "red",
        "space red",
        "Mean absolute error of the red light that is left at points all over the casters' bounds",
        17,
        |row| color(row, "red", |error| error.space),
        significant,
    ),
    column(
        "In space, by color",
        "green",
        "space green",
        "Mean absolute error of the green light that is left at points all over the casters' bounds",
        17,
        |row| color(row, "green", |error| error.space),
        significant,
    ),
    column(
        "In space, by color",
        "blue",
        "space blue",
        "Mean absolute error of the blue light that is left at points all over the casters' bounds",
        17,
        |row| color(row, "blue", |error| error.space),
        significant,
    ),
    column(
        "On surfaces, by color",
        "red",
        "surface red",
        "Mean absolute error of the red light that is left at surface points",
        18,
        |row| color(row, "red", |error| error.surface),
        significant,
    ),
    column(
        "On surfaces, by color",
        "green",
        "surface green",
        "Mean absolute error of the green light that is left at surface points",
        18,
        |row| color(row, "green", |error| error.surface),
        significant,
    ),
    column(
        "On surfaces, by color",
        "blue",
        "surface blue",
        "Mean absolute error of the blue light that is left at surface points",
        18,
        |row| color(row, "blue", |error| error.surface),
        significant,
    ),
    column(
        "Moving",
        "flicker",
        "flicker",
        "Root mean square of the answer's change minus the truth's, from frame to frame at fixed points",
        6,
        |row| row.flicker_rms,
        significant,
    ),
    column(
        "Image",
        "RMSE",
        "image RMSE",
        "Root mean square error of the shaded picture, display-referred",
        16,
        |row| Some(row.error.as_ref()?.image?.rmse),
        significant,
    ),
    column(
        "Image",
        "FLIP",
        "FLIP",
        "Mean of the FLIP map of the shaded picture",
        2,
        |row| Some(row.error.as_ref()?.image?.flip_mean),
        significant,
    ),
    column(
        "Image",
        "bounce RMSE",
        "bounce RMSE",
        "The same under virtual lights, against one path-traced bounce of the lights that they stand for",
        6,
        |row| row.error.as_ref()?.image?.bounce_rmse,
        significant,
    ),
    column(
        "Image",
        "noise",
        "bounce noise",
        "The standard error of that reference, in the same units",
        6,
        |row| row.error.as_ref()?.image?.bounce_noise,
        significant,
    ),
    column(
        "Frames",
        "RMSE",
        "frames RMSE",
        "Root mean square error of consecutive pictures, with the camera going round",
        6,
        |row| Some(row.frames?.rmse),
        significant,
    ),
    column(
        "Frames",
        "flicker",
        "frames flicker",
        "Root mean square of these pictures' change from frame to frame minus the truth's",
        6,
        |row| Some(row.frames?.flicker_rms),
        significant,
    ),
];
