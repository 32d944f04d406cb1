//! The head of the page: the answer in one sentence, and the plots that support it.

use crate::bench::{Results, Row};
use crate::report::answer::pareto::says_nothing;
use crate::report::answer::pareto::scenes;
use crate::report::answer::selection::{FLIP, Measure, answer, floor_ms, measure, point, why_untimed};
use crate::report::format::{Specs, bytes, path, significant};
use crate::report::plot::colors::named;
use crate::report::plot::scatter::{Dot, SIZES, scatter, shape};
use serde::Serialize;

/// Recommendations for all scenes.
#[derive(Serialize)]
pub(in crate::report) struct Choice {
    scenes: Vec<SceneChoice>,
    /// In the order in which they were first measured, which determines color and shape.
    techniques: Vec<Look>,
    paths: Vec<Look>,
}

/// Look of a technique or a path in plots.
#[derive(Serialize)]
struct Look {
    name: String,
    color: String,
    shape: &'static str,
}

#[derive(Serialize)]
struct SceneChoice {
    name: String,
    /// Kind of error by which rows are compared.
    measure: &'static str,
    best: Option<RowSummary>,
    fastest: Option<RowSummary>,
    closest: Option<RowSummary>,
    smallest: Option<RowSummary>,
    /// Why times are not compared; empty if they are.
    marked: String,
    plots: Vec<Plot>,
}

/// A row, as the sentence names it.
#[derive(Serialize)]
struct RowSummary {
    row: usize,
    spec: String,
    path: String,
    milliseconds: String,
    /// Words after the milliseconds.
    unit: &'static str,
    error: String,
    bytes: String,
    /// Whether its time may not be trustworthy.
    unsteady: bool,
}

#[derive(Serialize)]
struct Plot {
    title: String,
    /// The same plot for each size of the window.
    svgs: Vec<String>,
}

pub(in crate::report) fn choice(results: &Results, specs: &Specs) -> Choice {
    let techniques = names(results, |row| &row.technique);
    let mut paths = names(results, |row| &row.path);
    // A refused row took no path.
    paths.retain(|path| !path.is_empty());
    let of_scene = |name: &str| scene(results, specs, name, &techniques, &paths);
    let scenes = scenes(results).into_iter().map(of_scene).collect();
    let colors = named(techniques.len());
    let techniques = techniques.iter().zip(colors).map(|(name, c)| Look {
        name: (*name).to_owned(),
        color: format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2),
        shape: shape(0),
    });
    let paths = paths.iter().enumerate().map(|(place, name)| Look {
        name: (*name).to_owned(),
        color: String::new(),
        shape: shape(place),
    });
    Choice { scenes, techniques: techniques.collect(), paths: paths.collect() }
}

/// Returns the distinct names in the measured rows.
fn names(results: &Results, of: fn(&Row) -> &String) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in &results.rows {
        if !names.contains(&of(row).as_str()) {
            names.push(of(row));
        }
    }
    names
}

fn scene(results: &Results, specs: &Specs, name: &str, techniques: &[&str], paths: &[&str]) -> SceneChoice {
    let rows: Vec<(usize, &Row)> = results.rows.iter().enumerate().filter(|(_, row)| row.scene == name).collect();
    let measure = measure(&rows);
    let answer = answer(&rows, &measure);
    let said = |index: usize| {
        let row = &results.rows[index];
        let (milliseconds, error) = point(row, &measure)?;
        Some(RowSummary {
            row: index,
            spec: specs.compact(row),
            path: path(row),
            milliseconds: significant(milliseconds),
            unit: measure.time.unit,
            error: significant(error),
            bytes: row.bytes_resident.map(bytes).unwrap_or_default(),
            unsteady: row.steadiness.is_some_and(|s| !s.warnings().is_empty()),
        })
    };
    let place = |names: &[&str], name: &str| names.iter().position(|known| *known == name).unwrap_or(0);
    let dots = |of: &dyn Fn(&Row) -> Option<(f64, f64)>, units: [&str; 2]| -> Vec<Dot> {
        let dot = |&(index, row): &(usize, &Row)| {
            let (x, y) = of(row)?;
            let is = |of: Option<usize>| of == Some(index);
            let answer = answer.as_ref();
            let said = match () {
                () if is(answer.and_then(|a| a.best)) => Some("best balanced"),
                () if is(answer.and_then(|a| a.fastest)) => Some("fastest"),
                () if is(answer.map(|a| a.closest)) => Some("closest"),
                () => None,
            };
            let said_so = said.map(|words| format!(", {words}")).unwrap_or_default();
            let [unit, error] = units;
            // The table names the keys; the values suffice to distinguish points.
            let values = specs.differing(row).map(|(_, value)| value);
            let label = std::iter::once(row.technique.as_str()).chain(values).collect::<Vec<_>>().join(" ");
            let spec = specs.compact(row);
            let (x_text, y_text) = (significant(x), significant(y));
            let title = format!("{spec}, {}{said_so}: {x_text} {unit}, {error} {y_text}", path(row));
            let (technique, path) = (place(techniques, &row.technique), place(paths, &row.path));
            Some(Dot { row: index, x, y, technique, path, label, title, said, aside: row.technique == "none" })
        };
        rows.iter().filter_map(dot).collect()
    };
    let plot = |title: String, of: &dyn Fn(&Row) -> Option<(f64, f64)>, units: [&str; 2], titles: [&str; 2]| {
        let dots = dots(of, units);
        if says_nothing(&dots.iter().map(|dot| (dot.x, dot.y)).collect::<Vec<_>>()) {
            return None;
        }
        let label = format!("{title}, {name}: each point is a row of the table below");
        let svgs: Vec<String> = SIZES.iter().filter_map(|size| scatter(&dots, *size, titles, &label)).collect();
        (!svgs.is_empty()).then_some(Plot { title, svgs })
    };
    const MIB: f64 = 1_048_576.0;
    let error_title = format!("mean {}", measure.name);
    let of_bytes = |row: &Row| {
        let (_, error) = point(row, &measure)?;
        Some((row.bytes_resident.filter(|bytes| *bytes > 0)? as f64 / MIB, error))
    };
    let mut plots = Vec::new();
    let named = measure.name;
    let (what, time) = match measure.time.name {
        "cost" => ("What shadows cost", "what shadows add to a frame, ms"),
        "frame time" => ("Frame time", "time of a frame, ms"),
        _ => ("Build and look-ups", "a build and a million look-ups, ms"),
    };
    let floor = floor_ms(&rows, &measure);
    let timed = |row: &Row, measure: &Measure| {
        let (ms, error) = point(row, measure)?;
        // `none` costs zero, which a logarithmic axis cannot show.
        (measure.time.name != "cost" || row.technique != "none").then_some((ms.max(floor), error))
    };
    plots.extend(plot(format!("{what} against {named}"), &|r| timed(r, &measure), ["ms", named], [time, &error_title]));
    plots.extend(plot(
        format!("Memory against {named}"),
        &of_bytes,
        ["MiB", named],
        ["memory of the look-up, MiB", &error_title],
    ));
    if measure.name != FLIP.name {
        let of = |row: &Row| timed(row, &Measure { time: measure.time, ..FLIP });
        plots.extend(plot(format!("{what} against FLIP"), &of, ["ms", "FLIP"], [time, "mean FLIP of the picture"]));
    }
    SceneChoice {
        name: name.to_owned(),
        measure: measure.name,
        best: answer.as_ref().and_then(|a| said(a.best?)),
        fastest: answer.as_ref().and_then(|a| said(a.fastest?)),
        closest: answer.as_ref().and_then(|a| said(a.closest)),
        smallest: answer.as_ref().and_then(|a| said(a.smallest?)),
        marked: answer.as_ref().map(|a| why_untimed(a, &rows)).unwrap_or_default(),
        plots,
    }
}
