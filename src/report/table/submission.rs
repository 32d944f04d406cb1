//! `gobo submit`: a table in Markdown, for the text of a pull request.

use crate::bench::{Row, Status, Submission};
use crate::report::format::{
    NOTHING, Specs, bytes, milliseconds, one_line, outcome, path, percent, significant, spread_milliseconds,
};
use crate::report::warnings::{MARK, marked};

/// Formats the device and the run, and a line per row.
pub fn submission_table(submission: &Submission) -> String {
    let results = &submission.results;
    let device = &results.device;
    let changed = if submission.changed { ", changed" } else { "" };
    let mut text = format!(
        "**{}** ({}), {}, Vulkan {}; Gobo {}, commit {}{changed}; {:.0} s",
        device.name, device.kind, device.driver, device.api, results.gobo, submission.commit, submission.seconds
    );
    if let Some(noise) = submission.noise {
        text += &format!("; times vary by {} (median over the rows)", percent(noise));
    }
    if let Some(stages) = device.stages {
        text += &format!("; {}", stages.sentence());
    }
    let layers: Vec<&str> = submission.layers.iter().map(|tool| tool.name.as_str()).collect();
    if !layers.is_empty() {
        text += &format!("; layers: {}", layers.join(", "));
    }
    let mut text = one_line(&text);
    text += "\n\n| scene | technique | path | build, ms | look-up, ms/M | draw, ms | cost, ms | seen error | resident |\n|---|---|---|---|---|---|---|---|---|\n";
    let specs = Specs::of(&results.rows);
    for row in &results.rows {
        let spec = specs.compact(row).replace('|', "\\|");
        text += &format!("| {} | {spec} | {} | {} |\n", row.scene, path(row), cells(row).join(" | "));
    }
    text.extend(marked(&results.rows, device.stages).map(|note| format!("\n{note}.\n")));
    text
}

fn cells(row: &Row) -> [String; 6] {
    if row.status != Status::Ok {
        let mut cells = [const { String::new() }; 6];
        cells[0] = one_line(&outcome(row));
        return cells;
    }
    let mark = if row.marks.is_empty() { "" } else { MARK };
    let time = |ns: f64| milliseconds(ns) + mark;
    let median = |ns: Option<f64>| ns.map_or(NOTHING.into(), time);
    let build = row.build_ns.map(|build| format!("{} {}", time(build.median), spread_milliseconds(&build)));
    let seen = row.error.as_ref().and_then(|error| error.seen);
    [
        build.unwrap_or(NOTHING.into()),
        median(row.lookup_ns_per_million.map(|time| time.median)),
        median(row.draw_ns.map(|time| time.median)),
        median(row.cost_ns),
        seen.map_or(NOTHING.into(), |seen| significant(seen.mean)),
        row.bytes_resident.map_or(NOTHING.into(), bytes),
    ]
}
