//! Changes since a baseline: a table, and files for other tools.

use crate::bench::{Change, Figure, Results, Verdict};
use crate::report::format::{Specs, bytes, milliseconds, one_line, outcome, significant};
use crate::{Error, Result};
use comfy_table::presets::NOTHING;
use comfy_table::{ContentArrangement, Table};
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;

/// Words for a row that the run lacks.
const GONE: &str = "gone since the baseline";

/// Which changes make a run fail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fails {
    /// Whether slower rows make the run fail.
    pub slower: bool,
    /// Whether rows with larger errors make the run fail.
    pub worse: bool,
    /// Whether missing rows make the run fail.
    pub gone: bool,
}

impl Fails {
    /// Returns briefly why a row fails; `None` if it does not. If times or errors can fail the run, so does a row that was measured before
    /// and cannot be measured any more.
    pub fn why(self, change: &Change) -> Option<String> {
        if self.gone && matches!(change, Change::Gone(_)) {
            return Some(GONE.into());
        }
        if (self.slower || self.worse) && change.is_lost() {
            return Some("not measured any more".into());
        }
        let mut words = Vec::new();
        if self.slower && change.is_slower() {
            words.push("slower");
        }
        if self.worse && change.is_worse() {
            words.push("worse");
        }
        (!words.is_empty()).then(|| format!("{} than the baseline", words.join(" and ")))
    }
}

/// Formats a line per row: every figure before and now, and its change. Rows have the names that the table of `now` uses.
pub fn changes_table(changes: &[Change], now: &Results) -> String {
    let names = Specs::of(&now.rows);
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["since the baseline", "what", "before", "now", "change", "verdict"]);
    for change in changes {
        let row = change.row();
        let name = one_line(&format!("{}: {}", row.scene, names.compact(row)));
        let mut said = |what: &str, rest: [String; 4]| {
            table.add_row([name.clone(), what.to_owned()].into_iter().chain(rest));
        };
        let words = |text: &str| [String::new(), String::new(), String::new(), text.to_owned()];
        match change {
            Change::Both { figures, .. } if figures.is_empty() => said("", words(&outcome(row))),
            Change::Both { figures, .. } => {
                for figure in figures {
                    said(figure.name, cells(figure));
                }
            }
            Change::Status { before, now } => {
                let status = |row| one_line(&outcome(row));
                said("", [status(before), status(now), String::new(), "otherwise".into()]);
            }
            Change::New(_) => said("", words("new")),
            Change::Gone(_) => said("", words("gone")),
        }
    }
    table.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

/// Returns the same data as JSON: times are in nanoseconds, and `share` is the increase of a figure relative to its earlier value.
pub fn changes_json(changes: &[Change]) -> serde_json::Value {
    let of_figure = |figure: &Figure| {
        let [.., verdict] = cells(figure);
        let (share, verdict) = (figure.share(), verdict.to_lowercase());
        json!({ "what": figure.name, "before": figure.before, "now": figure.now, "share": share, "verdict": verdict })
    };
    let of_row = |change: &Change| {
        let row = change.row();
        let (verdict, before, figures) = match change {
            Change::Both { figures, .. } => (None, None, figures.iter().map(of_figure).collect::<Vec<_>>()),
            Change::Status { before, .. } => (Some("otherwise"), Some(outcome(before)), Vec::new()),
            Change::New(_) => (Some("new"), None, Vec::new()),
            Change::Gone(_) => (Some("gone"), None, Vec::new()),
        };
        let now = (!matches!(change, Change::Gone(_))).then(|| outcome(row));
        json!({
            "scene": row.scene, "spec": row.spec(), "path": row.path,
            "before": before, "now": now, "verdict": verdict, "figures": figures,
        })
    };
    changes.iter().map(of_row).collect()
}

fn cells(figure: &Figure) -> [String; 4] {
    let text = |value: f64| match figure {
        _ if figure.is_time() => format!("{} ms", milliseconds(value)),
        _ if figure.is_error() => significant(value),
        _ => bytes(value as u64),
    };
    let share = figure.share().map(|share| format!("{:+.1} %", 100.0 * share)).unwrap_or_default();
    let verdict = match (figure.verdict, figure.is_time()) {
        (Verdict::Same, _) if figure.before == figure.now => "the same",
        (Verdict::Same, true) => "within the noise",
        (Verdict::Same, false) if figure.is_error() => "within the margin",
        (Verdict::Same, false) => "",
        (Verdict::Better, true) => "faster",
        (Verdict::Worse, true) => "SLOWER",
        (Verdict::Better, false) => "better",
        (Verdict::Worse, false) => "WORSE",
        (Verdict::Unknown, _) => "too unsteady to tell",
    };
    [text(figure.before), text(figure.now), share, verdict.into()]
}

/// JUnit XML: one test case per row, which fails if the row does.
const JUNIT: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<testsuites name="gobo compare" tests="{{ tests }}" failures="{{ failures }}">
  <testsuite name="{{ device }}" tests="{{ tests }}" failures="{{ failures }}" skipped="{{ skipped }}">
{%- for case in cases %}
    <testcase classname="{{ case.scene }}" name="{{ case.spec }}" time="{{ case.seconds }}">
    {%- if case.failure %}<failure message="{{ case.failure }}">{{ case.text }}</failure>{% endif %}
    {%- if case.skipped %}<skipped message="{{ case.skipped }}"/>{% endif -%}
    </testcase>
{%- endfor %}
  </testsuite>
</testsuites>
"#;

#[derive(Serialize)]
struct JunitCase {
    scene: String,
    spec: String,
    seconds: String,
    failure: Option<String>,
    text: String,
    skipped: Option<String>,
}

/// Formats `results` as JUnit XML: a failed row is a failure, and a refused row is skipped. With a baseline, rows also fail if [`Fails`]
/// says so, and missing rows come last, as failures or skipped.
///
/// # Errors
/// [`Error::Output`] if the template fails, which is a bug.
pub fn junit(results: &Results, changes: &[Change], fails: Fails) -> Result<String> {
    use crate::bench::Status;
    let device = one_line(&format!("{}, {}", results.device.name, results.device.driver));
    let case = |row: &crate::bench::Row| JunitCase {
        scene: one_line(&row.scene),
        spec: one_line(&row.spec()),
        seconds: row.build_ns.map(|timing| format!("{:.9}", timing.median / 1e9)).unwrap_or_default(),
        failure: (row.status == Status::Failed).then(|| outcome(row)),
        text: String::new(),
        skipped: (row.status == Status::Refused).then(|| outcome(row)),
    };
    let mut cases: Vec<JunitCase> = results.rows.iter().map(case).collect();
    for change in changes {
        let why = fails.why(change);
        if let Change::Gone(row) = change {
            let skipped = why.is_none().then(|| GONE.into());
            cases.push(JunitCase { seconds: String::new(), failure: why, skipped, ..case(row) });
        } else if let (Some(place), Some(why)) = (results.rows.iter().position(|row| row == change.row()), why) {
            cases[place].failure = Some(why);
            cases[place].text = figures_text(change);
            cases[place].skipped = None;
        }
    }
    let failures = cases.iter().filter(|case| case.failure.is_some()).count();
    let skipped = cases.iter().filter(|case| case.skipped.is_some()).count();
    let mut environment = Environment::new();
    let fail = |cause: minijinja::Error| Error::output("junit.xml".as_ref(), cause);
    environment.set_auto_escape_callback(|_| minijinja::AutoEscape::Html);
    environment.add_template("junit.xml", JUNIT).map_err(fail)?;
    let template = environment.get_template("junit.xml").map_err(fail)?;
    template
        .render(context! { tests => cases.len(), cases => Value::from(Serde(&cases)), failures, skipped, device })
        .map_err(fail)
}

fn figures_text(change: &Change) -> String {
    let Change::Both { figures, .. } = change else { return String::new() };
    let worse = figures.iter().filter(|figure| figure.verdict == Verdict::Worse);
    let lines = worse.map(|figure| {
        let [before, now, share, _] = cells(figure);
        format!("{}: {before} before, {now} now ({share})", figure.name)
    });
    lines.collect::<Vec<_>>().join("; ")
}

/// Formats `results` in Bencher's metric format, JSON: benchmark → measure → value, with its band if it has one. Times are in nanoseconds.
///
/// # Errors
/// [`Error::Output`] if a figure is not a number, which JSON cannot express.
pub fn bencher(results: &Results) -> Result<String> {
    #[derive(Serialize)]
    struct Metric {
        value: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        lower_value: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        upper_value: Option<f64>,
    }
    let mut all: BTreeMap<String, BTreeMap<&str, Metric>> = BTreeMap::new();
    for row in &results.rows {
        let exact = |value: f64| Metric { value, lower_value: None, upper_value: None };
        let timed = |timing: crate::bench::Timing| Metric {
            value: timing.median,
            lower_value: Some(timing.p05),
            upper_value: Some(timing.p95),
        };
        let error = row.error.as_ref();
        let metrics = [
            ("build_ns", row.build_ns.map(timed)),
            ("lookup_ns_per_million", row.lookup_ns_per_million.map(timed)),
            ("draw_ns", row.draw_ns.map(timed)),
            ("frame_ns", row.frame_ns.map(exact)),
            ("bytes_resident", row.bytes_resident.map(|count| exact(count as f64))),
            ("map_error", error.and_then(|e| e.map).map(|e| exact(e.mean_abs))),
            ("space_error", error.and_then(|e| e.space).map(|e| exact(e.mean_abs))),
            ("surface_error", error.and_then(|e| e.surface).map(|e| exact(e.mean_abs))),
            ("flip", error.and_then(|e| e.image).map(|e| exact(e.flip_mean))),
        ];
        let metrics: BTreeMap<_, _> = metrics.into_iter().filter_map(|(name, metric)| Some((name, metric?))).collect();
        if !metrics.is_empty() {
            all.insert(format!("{}/{}", row.scene, row.spec()), metrics);
        }
    }
    serde_json::to_string_pretty(&all).map_err(|cause| Error::output("Bencher's JSON".as_ref(), cause))
}
