//! Compares results of several devices, drivers or editions: which is fastest, whether they agree, and what interlock gains.

mod dots;
mod selection;
mod table;

pub use selection::devices_answer;
pub use table::{devices_csv, devices_json, devices_markdown};

use crate::bench::{BUILD_PATHS, Built, Comparison, Line, ROUNDING, Row, Status, Timing, Verdict};
use crate::report::format::{
    NOTHING, Specs, milliseconds, one_line, outcome, percent, significant, spread_milliseconds,
};
use crate::report::plot::colors::named;
use crate::report::plot::scatter::shape;
use crate::report::warnings::{MARK, warnings};
use crate::{Error, Result};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;
use std::collections::BTreeSet;

/// Names of lines: the keys in which shared lines differ, without the keys that agree in all of them.
struct Names<'a> {
    beside: &'a Comparison,
    specs: Specs,
}

impl<'a> Names<'a> {
    fn of(beside: &'a Comparison) -> Self {
        let rows: Vec<Row> = beside.shared().map(|line| beside.any(&beside.lines[line]).clone()).collect();
        Self { beside, specs: Specs::of(&rows) }
    }

    /// Names all lines, including those that only one column has.
    fn of_all(beside: &'a Comparison) -> Self {
        let rows: Vec<Row> = beside.lines.iter().map(|line| beside.any(line).clone()).collect();
        Self { beside, specs: Specs::of(&rows) }
    }

    fn compact(&self, line: usize) -> String {
        self.specs.compact(self.beside.any(&self.beside.lines[line]))
    }

    /// Returns the line's name, with the path if the spec names one. `auto` may choose a different path on each device, so a named path is
    /// part of the spec here.
    fn with_path(&self, line: usize) -> String {
        let name = self.compact(line);
        let row = self.beside.any(&self.beside.lines[line]);
        match row.variant.get("path").filter(|path| *path != "auto") {
            Some(path) if name.contains(':') => one_line(&format!("{name},path={path}")),
            Some(path) => one_line(&format!("{name}:path={path}")),
            None => name,
        }
    }
}

/// One row's entry in a device column.
#[derive(Clone, Default, Serialize)]
struct Cell {
    /// Milliseconds, or the reason why there are none.
    text: String,
    band: String,
    /// Time divided by that of the first unmarked column, such as `×1.20`, and whether the difference is significant.
    ratio: String,
    /// `faster`, `slower`, `same`, `unknown` or nothing.
    class: &'static str,
    /// Whether `text` states why there is no time.
    why: bool,
    /// Path that ran, if the spec leaves it open, and reasons not to trust the time.
    notes: Vec<String>,
    /// Whether the time is marked as not comparable.
    marked: bool,
}

fn cell(beside: &Comparison, line: &Line, column: usize) -> Cell {
    let Some(row) = beside.row(line, column) else { return Cell { text: NOTHING.into(), ..Cell::default() } };
    let mut cell = timed(row, beside.time(row));
    if row.variant.get("path").is_some_and(|path| path == "auto") && !row.path.is_empty() {
        cell.notes.insert(0, row.path.clone());
    }
    if column > 0 && beside.row(line, 0).is_some() && !beside.is_same_world(&row.scene, column, 0) {
        cell.notes.push("another scene or world".into());
    }
    if let Some(first) = beside.first(line).filter(|first| *first < column) {
        (cell.ratio, cell.class) = ratio_text(beside.ratio(line, column, first));
    }
    cell
}

/// Formats the build time of a path relative to the build by interlock.
fn interlock_cell(beside: &Comparison, built: &Built, path: usize) -> Cell {
    let Some(row) = beside.built_row(built, path) else { return Cell { text: NOTHING.into(), ..Cell::default() } };
    let mut cell = timed(row, row.build_ns);
    if path > 0 {
        (cell.ratio, cell.class) = ratio_text(beside.over_interlock(built, path));
    }
    cell
}

fn timed(row: &Row, time: Option<Timing>) -> Cell {
    if row.status != Status::Ok {
        return Cell { text: outcome(row), why: true, ..Cell::default() };
    }
    let text = time.map_or_else(|| NOTHING.into(), |time| milliseconds(time.median));
    Cell {
        text,
        band: time.map(|t| spread_milliseconds(&t)).unwrap_or_default(),
        notes: warnings(row).into_iter().chain(row.marks.iter().cloned()).collect(),
        marked: !row.marks.is_empty(),
        ..Cell::default()
    }
}

fn ratio_text(ratio: Option<(f64, Verdict)>) -> (String, &'static str) {
    let Some((ratio, verdict)) = ratio else { return (String::new(), "") };
    let times = format!("×{}", significant(ratio));
    match verdict {
        Verdict::Better => (times, "faster"),
        Verdict::Worse => (times, "slower"),
        Verdict::Same => (format!("{times}, no difference"), "same"),
        Verdict::Unknown => (format!("{times}, too unsteady to tell"), "unknown"),
    }
}

/// All data for the template, which escapes everything but the plots.
#[derive(Serialize)]
struct Page {
    gobo: &'static str,
    answer: String,
    best: Vec<String>,
    /// Speed of fragment shading on each device, and the number of its marked rows.
    stages: Vec<String>,
    mark: &'static str,
    what: &'static str,
    columns: Vec<PageColumn>,
    /// Devices, in the fields that report.html uses for techniques, so that both pages share a style sheet.
    choice: Choice,
    colors: Vec<String>,
    scenes: Vec<PageScene>,
    shared: Option<String>,
    /// What interlock gains: in one line, and with numbers.
    interlock_short: Option<String>,
    interlock: Vec<String>,
    paths: [&'static str; BUILD_PATHS.len()],
    built: Vec<PageBuilt>,
    compared: usize,
    rounding: String,
    disagreements: Vec<PageDisagreement>,
    conditions: Vec<(String, Vec<String>)>,
    features: Vec<(String, Vec<String>)>,
    same_features: Vec<(String, String)>,
    lone: Vec<PageLine>,
}

#[derive(Serialize)]
struct Choice {
    techniques: Vec<Look>,
}

#[derive(Serialize)]
struct Look {
    color: String,
}

#[derive(Serialize)]
struct PageColumn {
    name: String,
    shape: &'static str,
    device: String,
    driver: String,
    gobo: String,
    files: String,
    command: String,
    rows: usize,
}

#[derive(Serialize)]
struct PageScene {
    name: String,
    /// Conditions of the scene that differ between columns.
    notes: Vec<String>,
    plot: String,
    lines: Vec<PageLine>,
}

#[derive(Serialize)]
struct PageLine {
    place: usize,
    scene: String,
    /// Spec, split where a line may break.
    spec: Vec<String>,
    full: String,
    cells: Vec<Cell>,
}

#[derive(Serialize)]
struct PageBuilt {
    name: String,
    device: String,
    cells: Vec<Cell>,
}

#[derive(Serialize)]
struct PageDisagreement {
    scene: String,
    spec: Vec<String>,
    error: &'static str,
    values: Vec<String>,
    apart: String,
    share: String,
}

fn parts(name: &str) -> Vec<String> {
    name.split_inclusive([',', ':']).map(String::from).collect()
}

fn page_line(beside: &Comparison, names: &Names, place: usize) -> PageLine {
    let line = &beside.lines[place];
    let row = beside.any(line);
    PageLine {
        place,
        scene: row.scene.clone(),
        spec: parts(&names.with_path(place)),
        full: row.spec(),
        cells: (0..beside.columns.len()).map(|column| cell(beside, line, column)).collect(),
    }
}

fn scenes(beside: &Comparison, names: &Names) -> Vec<PageScene> {
    let mut scenes: Vec<(String, Vec<usize>)> = Vec::new();
    for place in beside.shared() {
        let name = &beside.any(&beside.lines[place]).scene;
        match scenes.iter_mut().find(|(known, _)| known == name) {
            Some((_, lines)) => lines.push(place),
            None => scenes.push((name.clone(), vec![place])),
        }
    }
    let scene = |(name, places): (String, Vec<usize>)| PageScene {
        notes: prints(beside, &name),
        plot: dots::dots(beside, names, &places),
        lines: places.into_iter().map(|place| page_line(beside, names, place)).collect(),
        name,
    };
    scenes.into_iter().map(scene).collect()
}

/// Returns notes on a scene whose contents differ between columns under one name, or whose contents a column did not record.
fn prints(beside: &Comparison, scene: &str) -> Vec<String> {
    let key = format!("scene {scene}");
    let print = |column: usize| beside.columns[column].results.conditions.get(&key);
    let has = |column: &usize| beside.columns[*column].results.rows.iter().any(|row| row.scene == scene);
    let columns: Vec<usize> = (0..beside.columns.len()).filter(has).collect();
    let Some(&first) = columns.first() else { return Vec::new() };
    let note = |&column: &usize| {
        let name = &beside.columns[column].name;
        match (print(first), print(column)) {
            (Some(one), Some(other)) if one != other => Some(format!(
                "{name} had another {scene}: its fingerprint is {other}, and {one} on {}; they are not held against each other.",
                beside.columns[first].name
            )),
            (_, None) => Some(format!("{name} does not say which {scene} it had; it is taken for the same.")),
            _ => None,
        }
    };
    columns.iter().filter_map(note).collect()
}

/// Renders the page as one self-contained file that needs no network.
///
/// # Errors
/// Only if the template itself is broken, which a test rules out.
pub fn devices_page(beside: &Comparison) -> Result<String> {
    let names = Names::of(beside);
    let agreement = beside.agreement();
    let built = beside.built();
    let bought = selection::interlock(beside, &built);
    let colors = named(beside.columns.len());
    let columns = beside.columns.iter().enumerate().map(|(place, column)| {
        let results = &column.results;
        PageColumn {
            name: column.name.clone(),
            shape: shape(place),
            device: one_line(&format!(
                "{} ({}), Vulkan {}",
                results.device.name, results.device.kind, results.device.api
            )),
            driver: one_line(&results.device.driver),
            gobo: one_line(&results.edition()),
            files: column.files.join(", "),
            command: one_line(&results.command),
            rows: results.rows.len(),
        }
    });
    let (features, same_features) = features(beside);
    let shared: BTreeSet<usize> = beside.shared().collect();
    let all_names = Names::of_all(beside);
    let lone = (0..beside.lines.len()).filter(|place| !shared.contains(place));
    let conditions = beside.differing_conditions().into_iter().filter(|(key, _)| !key.starts_with("scene "));
    let page = Page {
        gobo: env!("CARGO_PKG_VERSION"),
        answer: devices_answer(beside),
        best: selection::best(beside, &names),
        stages: selection::stages(beside),
        mark: MARK,
        what: selection::what(beside),
        columns: columns.collect(),
        choice: Choice {
            techniques: colors.iter().map(|c| Look { color: format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2) }).collect(),
        },
        colors: Vec::new(),
        scenes: scenes(beside, &names),
        shared: names.specs.shared_line(),
        interlock_short: selection::interlock_short(&bought),
        interlock: bought.into_iter().map(|bought| bought.long).collect(),
        paths: BUILD_PATHS,
        built: built
            .iter()
            .flatten()
            .map(|of| {
                let first = of.lines.iter().flatten().next().copied().unwrap_or(0);
                let scene = &beside.any(&beside.lines[first]).scene;
                PageBuilt {
                    name: one_line(&format!(
                        "{scene} {}",
                        if shared.contains(&first) { names.compact(first) } else { all_names.compact(first) }
                    )),
                    device: beside.columns[of.column].name.clone(),
                    cells: (0..BUILD_PATHS.len()).map(|path| interlock_cell(beside, of, path)).collect(),
                }
            })
            .collect(),
        compared: agreement.compared,
        rounding: percent(ROUNDING),
        disagreements: agreement
            .disagreements
            .iter()
            .map(|found| PageDisagreement {
                scene: beside.any(&beside.lines[found.line]).scene.clone(),
                spec: parts(&names.with_path(found.line)),
                error: found.name,
                values: found.values.iter().map(|value| value.map_or(NOTHING.into(), significant)).collect(),
                apart: significant(found.apart),
                share: selection::share(found.share),
            })
            .collect(),
        conditions: conditions
            .map(|(key, values)| (key, values.into_iter().map(|v| v.unwrap_or_else(|| NOTHING.into())).collect()))
            .collect(),
        features,
        same_features,
        lone: lone.map(|place| page_line(beside, &all_names, place)).collect(),
    };
    let mut environment = Environment::new();
    // A misspelt name in the template must fail in a test instead of leaving a gap in a report.
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let broken = |cause: minijinja::Error| Error::input("devices.html", format!("{cause:#}"), "report this as a bug");
    // The file extensions turn on autoescaping.
    for (name, text) in [
        ("devices.html", include_str!("page.html")),
        ("devices.css", include_str!("page.css")),
        ("page.css", include_str!("../page/page.css")),
    ] {
        environment.add_template(name, text).map_err(broken)?;
    }
    environment
        .get_template("devices.html")
        .and_then(|template| template.render(Value::from(Serde(&page))))
        .map_err(broken)
}

type Features = (Vec<(String, Vec<String>)>, Vec<(String, String)>);

/// Returns the features that differ between devices, with each device's value; and the other features.
fn features(beside: &Comparison) -> Features {
    let plain = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => text.clone(),
        serde_json::Value::Bool(true) => "yes".into(),
        serde_json::Value::Bool(false) => "no".into(),
        serde_json::Value::Null => NOTHING.into(),
        other => other.to_string(),
    };
    let features = |column: usize| &beside.columns[column].results.device.features;
    let count = beside.columns.len();
    // The device's name is in the heading.
    let keys: BTreeSet<&String> = (0..count)
        .flat_map(|column| features(column).keys())
        .filter(|key| !["name", "driver", "api", "type"].contains(&key.as_str()))
        .collect();
    let (mut differ, mut same) = (Vec::new(), Vec::new());
    for key in keys {
        let values: Vec<String> =
            (0..count).map(|column| features(column).get(key).map_or("?".into(), plain)).collect();
        if values.iter().all(|value| *value == values[0]) {
            same.push((key.clone(), values[0].clone()));
        } else {
            differ.push((key.clone(), values));
        }
    }
    (differ, same)
}
