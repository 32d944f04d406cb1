//! Results of `gobo stress`: the table for the terminal, the CSV file and the page.

use crate::bench::PointError;
use crate::bench::stress::{CaseResult, Figures, Outcome, Results, Verdict, about};
use crate::report::format::{NOTHING, one_line, signed, significant};
use crate::{Error, Result};
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;

/// Headings of a verdict's figures, with their meaning.
const COLUMNS: [(&str, &str); 8] = [
    ("mean", "mean absolute error, on the rays of texels where there are any, else in space"),
    ("bias", "signed mean: positive is too bright"),
    ("worst", "largest absolute error"),
    ("seen", "seen error: the share of the light in the picture that is wrong"),
    ("not finite", "answers that are infinite or not a number"),
    ("wrong", "leaks and false shadows beyond the technique's own resolution, in space and on surfaces"),
    ("order", "the most by which answers differ over eight orders of the same casters"),
    ("step", "RMS of how much more than the truth answers change in a tiny motion"),
];

/// Returns the errors that the columns show.
fn leading(figures: &Figures) -> Option<PointError> {
    figures.map.and_then(|map| map.error).or(figures.space.and_then(|space| space.error))
}

/// Formats the cells of [`COLUMNS`].
fn cells(figures: Option<&Figures>) -> [String; COLUMNS.len()] {
    let Some(figures) = figures else { return COLUMNS.map(|_| NOTHING.into()) };
    let shown = |value: Option<f64>, text: fn(f64) -> String| value.map_or_else(|| NOTHING.into(), text);
    let error = leading(figures);
    [
        shown(error.map(|e| e.mean_abs), significant),
        shown(error.and_then(|e| e.bias), signed),
        shown(error.and_then(|e| e.max), significant),
        shown(figures.seen.map(|seen| seen.mean), significant),
        figures.not_finite.to_string(),
        figures.wrong().map_or_else(|| NOTHING.into(), |wrong| wrong.to_string()),
        shown(figures.order_spread, significant),
        shown(figures.step_rms, significant),
    ]
}

/// Formats a verdict in words, with the value at which the technique breaks.
fn words(verdict: &Verdict) -> String {
    let at = verdict.breaks_at.filter(|_| verdict.holds_up_to.is_some());
    let at = at.map(|at| format!(" at {}", crate::bench::stress::number(at))).unwrap_or_default();
    let why = if verdict.why.is_empty() { String::new() } else { format!(";{at} {}", verdict.why) };
    one_line(&format!("{}{why}", verdict.verdict))
}

/// Returns the cases of the run, in order.
fn cases(results: &Results) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for verdict in &results.verdicts {
        if !names.contains(&verdict.case.as_str()) {
            names.push(&verdict.case);
        }
    }
    names
}

/// Returns a heading: what a case sweeps, and over which values.
fn heading(results: &Results, name: &str) -> String {
    let mut values: Vec<f64> = Vec::new();
    for row in results.rows.iter().filter(|row| row.case == name) {
        if !values.contains(&row.value) {
            values.push(row.value);
        }
    }
    let values: Vec<_> = values.into_iter().map(crate::bench::stress::number).collect();
    let about = about(name).map(|about| format!(": {about}")).unwrap_or_default();
    format!("{name}{about}: {}", values.join(", "))
}

/// Describes the device of the run in one line.
pub fn stress_device(results: &Results) -> String {
    let device = &results.device;
    one_line(&format!("{} ({}), {}, Vulkan {}", device.name, device.kind, device.driver, device.api))
}

/// Formats a sweep's table with one line per technique: its figures, and how far it holds.
pub fn stress_table(results: &Results, case: &str) -> String {
    let mut table = Table::new();
    table.load_style(comfy_table::presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["  technique"].into_iter().chain(COLUMNS.map(|(heading, _)| heading)).chain(["verdict"]));
    for verdict in results.verdicts.iter().filter(|verdict| verdict.case == case) {
        let number = |text| Cell::new(text).set_alignment(CellAlignment::Right);
        let figures = cells(verdict.figures.as_ref()).map(number);
        let name = Cell::new(format!("  {}", one_line(&verdict.technique)));
        table.add_row([name].into_iter().chain(figures).chain([Cell::new(words(verdict))]));
    }
    let lines = table.lines().map(|line| line.trim_end().to_owned() + "\n").collect::<String>();
    format!("\n{}\n{lines}", one_line(&heading(results, case)))
}

/// Columns of an error, prefixed with the kind of points.
const ERROR_COLUMNS: [&str; 5] = ["points", "mean_abs", "bias", "max", "wrong"];

/// Returns CSV with one flat line per row. Numbers have full precision; missing values are empty fields.
///
/// # Errors
/// [`Error::Output`] if memory runs out.
pub fn stress_csv(results: &Results) -> Result<String> {
    let fail = |cause: &dyn std::fmt::Display| Error::output("stress.csv".as_ref(), cause);
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut names: Vec<String> = ["case", "value", "technique", "path", "outcome", "reason"].map(String::from).into();
    for points in ["map", "space", "surface"] {
        names.extend(ERROR_COLUMNS.map(|column| format!("{points}_{column}")));
    }
    names.extend(["points", "mean", "bias", "standard_error"].map(|column| format!("seen_{column}")));
    names.extend(["not_finite", "outside", "rise", "tail", "order_spread", "step_rms", "messages"].map(String::from));
    writer.write_record(&names).map_err(|cause| fail(&cause))?;
    for row in &results.rows {
        writer.write_record(fields(row)).map_err(|cause| fail(&cause))?;
    }
    let bytes = writer.into_inner().map_err(|failed| fail(failed.error()))?;
    String::from_utf8(bytes).map_err(|cause| fail(&cause))
}

fn fields(row: &CaseResult) -> Vec<String> {
    let outcome = match row.outcome {
        Outcome::Answered => "answered",
        Outcome::Refused => "refused",
        Outcome::Failed => "failed",
        Outcome::NoAnswer => "no-answer",
    };
    let mut fields: Vec<String> =
        [&row.case, &row.value.to_string(), &row.technique, &row.path, outcome, &row.reason].map(Into::into).into();
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let figures = row.figures.as_ref();
    for asked in [figures.and_then(|f| f.map), figures.and_then(|f| f.space), figures.and_then(|f| f.surface)] {
        let error = asked.and_then(|asked| asked.error);
        let wrong = asked.and_then(|asked| asked.wrong()).map(|wrong| wrong.to_string());
        fields.push(asked.map(|asked| asked.points.to_string()).unwrap_or_default());
        fields.extend([error.map(|e| e.mean_abs), error.and_then(|e| e.bias), error.and_then(|e| e.max)].map(number));
        fields.push(wrong.unwrap_or_default());
    }
    let seen = figures.and_then(|figures| figures.seen);
    fields.push(seen.map(|seen| seen.points.to_string()).unwrap_or_default());
    fields.extend([seen.map(|s| s.mean), seen.map(|s| s.bias), seen.and_then(|s| s.standard_error)].map(number));
    let count = |of: fn(&Figures) -> u64| figures.map(|f| of(f).to_string()).unwrap_or_default();
    fields.extend([count(|f| f.not_finite), count(|f| f.outside)]);
    let figure = |of: fn(&Figures) -> Option<f64>| number(figures.and_then(of));
    fields.extend([figure(|f| f.rise), figure(|f| f.tail), figure(|f| f.order_spread), figure(|f| f.step_rms)]);
    fields.push(count(|f| f.messages));
    fields
}

/// All data for the template, which escapes it.
#[derive(Serialize)]
struct Page<'a> {
    results: &'a Results,
    columns: [(&'static str, &'static str); COLUMNS.len()],
    cases: Vec<PageCase<'a>>,
}

#[derive(Serialize)]
struct PageCase<'a> {
    heading: String,
    verdicts: Vec<PageVerdict<'a>>,
}

#[derive(Serialize)]
struct PageVerdict<'a> {
    technique: &'a str,
    words: String,
    /// Style of the verdict: `holds`, `part`, `broken` or `refused`.
    mark: &'static str,
    cells: [String; COLUMNS.len()],
}

/// Renders the page: one table per case, in one self-contained file.
///
/// # Errors
/// Only if the template itself is broken, which a test rules out.
pub fn stress_page(results: &Results) -> Result<String> {
    let verdict = |verdict: &'_ Verdict| match (verdict.holds_up_to, verdict.breaks_at) {
        _ if !verdict.invariants.is_empty() => "broken",
        (Some(_), None) => "holds",
        (_, Some(_)) => "part",
        (None, None) => "refused",
    };
    let case = |name: &str| PageCase {
        heading: heading(results, name),
        verdicts: results
            .verdicts
            .iter()
            .filter(|verdict| verdict.case == name)
            .map(|v| PageVerdict {
                technique: &v.technique,
                words: words(v),
                mark: verdict(v),
                cells: cells(v.figures.as_ref()),
            })
            .collect(),
    };
    let page = Page { results, columns: COLUMNS, cases: cases(results).into_iter().map(case).collect() };
    render("stress.html", include_str!("stress.html"), &Value::from(Serde(&page)))
}

/// Renders a template that escapes its data.
pub(in crate::report) fn render(name: &str, template: &str, page: &Value) -> Result<String> {
    let broken = |cause: minijinja::Error| Error::input(name, format!("{cause:#}"), "report this as a bug");
    let mut environment = Environment::new();
    // A misspelt name in the template must fail in a test instead of leaving a gap in a report.
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_global("style", Value::from_safe_string(include_str!("stress.css").into()));
    // The file extension turns on autoescaping.
    environment.add_template(name, template).map_err(broken)?;
    environment.get_template(name).and_then(|template| template.render(page)).map_err(broken)
}
