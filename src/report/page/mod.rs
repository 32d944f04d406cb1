//! The HTML page: everything in one file.

pub(super) mod soak;
pub(super) mod stress;
pub(super) mod summary;

use crate::bench::{CASTER_CLASSES, DeviceFacts, PointError, Results, Row, Status};
use crate::report::answer::pareto::{rows_on_front, scenes};
use crate::report::file::store::is_plain_name;
use crate::report::format::{
    NOTHING, Specs, grouped, milliseconds, outcome, path, percent, signed, significant, status_word,
};
use crate::report::page::summary::{Choice, choice};
use crate::report::plot::axes::AXES;
use crate::report::plot::colors::distinct;
use crate::report::plot::plots;
use crate::report::table::casters::{ENDS, cell, heading};
use crate::report::table::columns::{Column, shown};
use crate::report::table::passes::pass_names;
use crate::report::warnings::{MARK, agreement, marked, warnings};
use crate::{Error, Result};
use base64::Engine;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior};
use plotters::style::RGBColor;
use serde::Serialize;
use std::path::Path;

/// Columns that stay folded until the reader opens them.
const FOLDED: [&str; 9] = ["host", "first", "bias", "RMS", "p99", "max", "× limit", "transient", "on disk"];

/// All data for the template, which escapes everything but the plots and the pictures.
#[derive(Serialize)]
struct Page<'a> {
    gobo: String,
    command: &'a str,
    device: &'a DeviceFacts,
    features: Vec<(&'a str, String)>,
    tally: String,
    /// Speed of fragment shading on the device, if measured.
    stages: Option<String>,
    /// Number of marked rows, and why they are marked.
    marked: Option<String>,
    /// Symbol printed after times that are not comparable.
    mark: &'static str,
    choice: Choice,
    shared: Option<String>,
    /// Rank correlation of seen error and FLIP.
    agreement: Option<String>,
    plots: Vec<String>,
    /// Colors of the passes, by their number in the run.
    colors: Vec<String>,
    fronts: Vec<Front>,
    scenes: Vec<Scene<'a>>,
}

/// A Pareto front and its mark.
#[derive(Clone, Copy, Serialize)]
struct Front {
    names: &'static str,
    mark: usize,
}

#[derive(Serialize)]
struct Heading {
    name: &'static str,
    meaning: &'static str,
    /// Name of the group of columns that begins here.
    group: Option<&'static str>,
    folded: bool,
}

#[derive(Serialize)]
struct Scene<'a> {
    name: &'a str,
    columns: Vec<Heading>,
    column_count: usize,
    rows: Vec<PageRow<'a>>,
    reference: Picture,
    passes: Vec<Pass>,
}

#[derive(Serialize)]
struct PageRow<'a> {
    /// Index in the results.
    index: usize,
    technique: &'a str,
    bare_path: &'a str,
    /// Nanoseconds of all passes, as a sort key.
    passes_ns: f64,
    total: String,
    /// Whether the bar is cut off because the build is longer than the scale.
    cut: bool,
    spec: String,
    /// `spec`, split where a line may break.
    spec_parts: Vec<String>,
    full_spec: String,
    path: String,
    /// Reasons not to trust its times, or the method.
    warnings: Vec<String>,
    /// Reasons not to compare its times.
    marks: &'a [String],
    /// Milliseconds of the passes that techniques share; `None` if there are none.
    shared: Option<String>,
    status: &'static str,
    outcome: String,
    reason: &'a str,
    /// Marks of the fronts that contain the row.
    on_fronts: Vec<usize>,
    cells: Vec<PageCell>,
    bars: Vec<Bar>,
    statistics: Statistics,
    casters: Statistics,
    counters: Vec<(&'a str, String)>,
    picture: Picture,
    difference: Picture,
}

#[derive(Serialize)]
struct PageCell {
    text: String,
    marked: bool,
    spread: String,
    value: Option<f64>,
}

/// A table with one column per kind of points and one line per statistic: its name, then its values.
#[derive(Serialize)]
struct Statistics {
    points: Vec<&'static str>,
    lines: Vec<Vec<String>>,
}

/// A pass and its color.
#[derive(Serialize)]
struct Pass {
    name: String,
    color: usize,
}

#[derive(Serialize)]
struct Bar {
    /// Whether techniques share the pass.
    shared: bool,
    name: String,
    color: usize,
    percent: String,
    milliseconds: String,
    spread: String,
}

/// An embedded picture, or the reason why there is none.
#[derive(Serialize)]
struct Picture {
    uri: Option<String>,
    note: String,
}

/// Renders the page as HTML. Pictures are read from `dir`; a missing one is replaced by a note.
///
/// # Errors
/// Only if the template itself is broken, which a test rules out.
pub fn page(results: &Results, dir: &Path) -> Result<String> {
    let specs = Specs::of(&results.rows);
    let shared = Shared { specs: &specs, passes: pass_names(results.rows.iter()), fronts: fronts(results) };
    let page = Page {
        gobo: results.edition(),
        command: &results.command,
        device: &results.device,
        features: results.device.features.iter().map(|(name, value)| (name.as_str(), plain(value))).collect(),
        tally: tally(results),
        stages: results.device.stages.map(|stages| stages.sentence()),
        marked: marked(&results.rows, results.device.stages),
        mark: MARK,
        choice: choice(results, &specs),
        shared: specs.shared_line(),
        agreement: agreement(results),
        plots: plots(results).into_iter().map(|(_, svg)| svg).collect(),
        colors: distinct(shared.passes.len()).iter().map(hexadecimal).collect(),
        fronts: shared.fronts.iter().map(|&(front, _)| front).collect(),
        scenes: scenes(results).into_iter().map(|name| scene(results, name, &shared, dir)).collect(),
    };
    let mut environment = Environment::new();
    // A misspelt name in the template must fail in a test instead of leaving a gap in a report.
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let broken = |cause: minijinja::Error| Error::input("report.html", format!("{cause:#}"), "report this as a bug");
    // The file extension turns on autoescaping.
    for (name, text) in [
        ("page.html", include_str!("page.html")),
        ("page.css", include_str!("page.css")),
        ("page.js", include_str!("page.js")),
    ] {
        environment.add_template(name, text).map_err(broken)?;
    }
    environment
        .get_template("page.html")
        .and_then(|template| template.render(Value::from(Serde(&page))))
        .map_err(broken)
}

/// Data shared by all scenes.
struct Shared<'a> {
    specs: &'a Specs,
    /// Numbered over the whole run, so that a pass has the same color in every scene.
    passes: Vec<&'a str>,
    /// Each front, with the indices of the rows on it.
    fronts: Vec<(Front, Vec<usize>)>,
}

/// Returns the fronts that contain any rows.
fn fronts(results: &Results) -> Vec<(Front, Vec<usize>)> {
    let all = AXES.iter().enumerate();
    let fronts = all.map(|(mark, axes)| (Front { names: axes.names, mark }, rows_on_front(results, axes)));
    fronts.filter(|(_, rows)| !rows.is_empty()).collect()
}

fn scene<'a>(results: &'a Results, name: &'a str, shared: &Shared, dir: &Path) -> Scene<'a> {
    let specs = shared.specs;
    let rows: Vec<(usize, &Row)> = results.rows.iter().enumerate().filter(|(_, row)| row.scene == name).collect();
    let color_of = |name: &str| shared.passes.iter().position(|&known| known == name).unwrap_or(0);
    let passes = pass_names(rows.iter().map(|&(_, row)| row));
    let passes = passes.into_iter().map(|name| Pass { name: name.to_owned(), color: color_of(name) }).collect();
    let columns = shown(rows.iter().map(|&(_, row)| row));
    let longest_ns = scale(rows.iter().map(|(_, row)| passes_ns(row)).collect());
    let rows = rows.into_iter().map(|(index, row)| {
        let mut bars: Vec<Bar> = row
            .passes
            .iter()
            .map(|pass| Bar {
                shared: pass.is_shared(),
                name: pass.name.clone(),
                color: color_of(&pass.name),
                percent: format!("{:.2}", if longest_ns > 0.0 { 100.0 * pass.median_ns / longest_ns } else { 0.0 }),
                milliseconds: milliseconds(pass.median_ns),
                spread: format!("{}–{}", milliseconds(pass.p05_ns), milliseconds(pass.p95_ns)),
            })
            .collect();
        bars.sort_by_key(|bar| !bar.shared);
        let cells = columns.iter().map(|column| PageCell {
            text: (column.value)(row).map(column.text).unwrap_or_else(|| NOTHING.into()),
            marked: column.is_marked(row),
            spread: (column.spread)(row).unwrap_or_default(),
            value: (column.value)(row).filter(|value| value.is_finite()),
        });
        PageRow {
            index,
            technique: &row.technique,
            bare_path: &row.path,
            passes_ns: passes_ns(row),
            total: milliseconds(passes_ns(row)),
            cut: passes_ns(row) > longest_ns * 1.0001,
            spec_parts: specs.compact(row).split_inclusive(',').map(String::from).collect(),
            spec: specs.compact(row),
            full_spec: row.spec(),
            path: path(row),
            warnings: warnings(row),
            marks: &row.marks,
            shared: row.shared_ns().filter(|ns| *ns > 0.0).map(milliseconds),
            status: status_word(row.status),
            outcome: outcome(row),
            reason: &row.reason,
            on_fronts: shared
                .fronts
                .iter()
                .filter(|(_, on)| on.contains(&index))
                .map(|(front, _)| front.mark)
                .collect(),
            cells: cells.collect(),
            bars,
            statistics: statistics(row),
            casters: by_caster(row),
            counters: row.counters.iter().map(|(name, &count)| (name.as_str(), grouped(count))).collect(),
            picture: embedded(dir, row.picture.as_deref()),
            difference: embedded(dir, row.difference.as_deref()),
        }
    });
    let rows = rows.collect();
    let reference = embedded(dir, Some(&format!("{name}-reference.png")));
    Scene {
        name,
        columns: headings(&columns),
        // The reason of a refused row spans all columns, at least one.
        column_count: columns.len().max(1),
        rows,
        reference,
        passes,
    }
}

/// Returns the length of the scale: the time of the slowest build that takes at most four times the median build time. The bars of slower
/// builds are cut off.
fn scale(mut all_ns: Vec<f64>) -> f64 {
    all_ns.retain(|ns| *ns > 0.0);
    all_ns.sort_by(f64::total_cmp);
    let most = 4.0 * all_ns.get(all_ns.len() / 2).copied().unwrap_or(0.0);
    all_ns.into_iter().filter(|ns| *ns <= most).fold(0.0, f64::max)
}

fn passes_ns(row: &Row) -> f64 {
    row.passes.iter().map(|pass| pass.median_ns).filter(|ns| ns.is_finite()).sum()
}

/// Collects the statistics of a row's errors, without kinds of points that have no error and statistics that have no value.
fn statistics(row: &Row) -> Statistics {
    let Some(error) = &row.error else { return Statistics { points: Vec::new(), lines: Vec::new() } };
    let kinds = [("map points", error.map), ("in space", error.space), ("on surfaces", error.surface)];
    let (points, errors): (Vec<_>, Vec<_>) = kinds.into_iter().filter_map(|(name, e)| Some((name, e?))).unzip();
    let line = |name: &str, text: &dyn Fn(&PointError) -> Option<String>| {
        let values = errors.iter().map(|e| text(e).unwrap_or_else(|| NOTHING.into()));
        std::iter::once(name.to_owned()).chain(values).collect::<Vec<_>>()
    };
    let mut lines = vec![
        line("points", &|e| e.points.map(grouped)),
        line("mean abs", &|e| Some(significant(e.mean_abs))),
        line("bias", &|e| e.bias.map(signed)),
        line("RMS", &|e| e.rms.map(significant)),
        line("p99", &|e| e.p99.map(significant)),
        line("max", &|e| e.max.map(significant)),
        line("leaks", &|e| e.leaks.map(grouped)),
        line("false shadows", &|e| e.false_shadows.map(grouped)),
        line("within: points", &|e| e.within.map(|w| grouped(w.points))),
        line("within: share", &|e| e.share_within().map(percent)),
        line("within: mean abs", &|e| e.within?.mean_abs.map(significant)),
        line("within: leaks", &|e| e.within.map(|w| grouped(w.leaks))),
        line("within: false shadows", &|e| e.within.map(|w| grouped(w.false_shadows))),
        line("beyond: mean abs", &|e| e.beyond()?.mean_abs.map(significant)),
        line("beyond: leaks", &|e| e.beyond().map(|b| grouped(b.leaks))),
        line("beyond: false shadows", &|e| e.beyond().map(|b| grouped(b.false_shadows))),
    ];
    lines.retain(|line| line[1..].iter().any(|value| value != NOTHING));
    Statistics { points, lines }
}

/// Collects errors by caster distance: one column per end from which distances are measured, one line per class of distances.
fn by_caster(row: &Row) -> Statistics {
    let error = row.error.as_ref().and_then(|error| error.casters.as_ref());
    let found = ENDS.into_iter().filter_map(|(name, end)| Some((name, error.and_then(end)?)));
    let (points, ends): (Vec<_>, Vec<_>) = found.unzip();
    let count = ends.first().map_or(0, |classes| classes.len());
    let line = |class| {
        let cells = ends.iter().map(|classes| classes.get(class).map_or(NOTHING.into(), cell));
        std::iter::once(heading(class)).chain(cells).collect()
    };
    Statistics { points, lines: (0..count.min(CASTER_CLASSES.len())).map(line).collect() }
}

/// Formats a color as `#0072b2`.
fn hexadecimal(color: &RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", color.0, color.1, color.2)
}

/// Embeds a picture as a data URI. Only PNG files directly in `dir` are read: the name comes from a file that anyone may have edited.
fn embedded(dir: &Path, name: Option<&str>) -> Picture {
    let missing = |note: String| Picture { uri: None, note };
    let Some(name) = name else { return missing("no picture".into()) };
    if !is_plain_name(name) {
        return missing(format!("{name} is not in the output folder"));
    }
    match std::fs::read(dir.join(name)) {
        Ok(png) if png.starts_with(b"\x89PNG\r\n\x1a\n") => {
            let text = base64::engine::general_purpose::STANDARD.encode(png);
            Picture { uri: Some(format!("data:image/png;base64,{text}")), note: String::new() }
        }
        Ok(_) => missing(format!("{name} is not a PNG")),
        Err(cause) => missing(format!("{name}: {cause}")),
    }
}

fn headings(columns: &[&Column]) -> Vec<Heading> {
    let mut before = "";
    let headings = columns.iter().map(|column| {
        let group = (column.group != before).then_some(column.group);
        before = column.group;
        Heading { name: column.name, meaning: column.meaning, group, folded: FOLDED.contains(&column.name) }
    });
    headings.collect()
}

/// Counts rows by status: `12 measured, 2 refused`.
fn tally(results: &Results) -> String {
    let count = |status| results.rows.iter().filter(|row| row.status == status).count();
    let mut parts = vec![format!("{} measured", count(Status::Ok))];
    for (status, word) in [(Status::Refused, "refused"), (Status::Failed, "failed")] {
        if count(status) > 0 {
            parts.push(format!("{} {word}", count(status)));
        }
    }
    parts.join(", ")
}

/// Formats a feature's value without JSON's quotes.
fn plain(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::String(text) => text.clone(),
        serde_json::Value::Bool(true) => "yes".into(),
        serde_json::Value::Bool(false) => "no".into(),
        other => other.to_string(),
    }
}
