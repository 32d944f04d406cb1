//! The plot: one track per scene and spec, with one lane per device. In a lane, the mark is the median time, and the line spans the band.
//! The browser does the layout, so the plot is as wide as the window and its text has the size of all other text.

use super::Names;
use crate::bench::Comparison;
use crate::report::format::{one_line, significant};
use crate::report::plot::scatter::{escaped, shape};
use crate::report::plot::series::{range_with_air, ticks};
use std::fmt::Write;

/// Position along the track, in percent, beyond which a mark's number is to the left of the mark instead of to the right.
const BEHIND: f64 = 72.0;

/// Returns the plot as HTML; empty if no line has a time.
pub(super) fn dots(beside: &Comparison, names: &Names, lines: &[usize]) -> String {
    let count = beside.columns.len();
    let has = |column: &usize| lines.iter().any(|&line| beside.row(&beside.lines[line], *column).is_some());
    let columns: Vec<usize> = (0..count).filter(has).collect();
    let time = |line: usize, column: usize| {
        let row = beside.row(&beside.lines[line], column)?;
        beside.time(row).filter(|time| time.median > 0.0 && time.p05 > 0.0)
    };
    let all = lines.iter().flat_map(|&line| (0..count).filter_map(move |column| time(line, column)));
    let ends: Vec<f64> = all.flat_map(|time| [time.p05 / 1e6, time.p95 / 1e6]).collect();
    let Some((low, high)) = range_with_air(ends.into_iter()) else { return String::new() };
    let along = |ms: f64| 100.0 * (ms / low).ln() / (high / low).ln();
    let mut html = String::from(r#"<div class="dots">"#);
    for &line in lines {
        if (0..count).all(|column| time(line, column).is_none()) {
            continue;
        }
        let name = names.with_path(line);
        let parts: String = name.split_inclusive([',', ':']).map(|part| escaped(part) + "<wbr>").collect();
        write!(html, r#"<div class="name"><code>{parts}</code></div><div class="track" data-line="{line}">"#).ok();
        for (tick, _) in ticks((low, high)).into_iter().filter(|(_, labelled)| *labelled) {
            write!(html, r#"<i style="left:{:.2}%"></i>"#, along(tick)).ok();
        }
        for &column in &columns {
            let Some(time) = time(line, column) else {
                html += r#"<div class="lane"></div>"#;
                continue;
            };
            let [at, from, to] = [time.median, time.p05, time.p95].map(|ns| along(ns / 1e6));
            let text = significant(time.median / 1e6);
            let title = escaped(&one_line(&format!("{}: {text} ms, {name}", beside.columns[column].name)));
            let (side, beyond) = if at > BEHIND { ("before", at.min(from)) } else { ("after", at.max(to)) };
            write!(
                html,
                r#"<div class="lane" title="{title}"><b style="left:{from:.2}%;width:{:.2}%"></b><svg class="mark" style="left:{at:.2}%" data-column="{column}" data-ms="{}" width="14" height="14" viewBox="-8 -8 16 16" aria-hidden="true"><path class="t{column}" d="{}"/></svg><span class="{side}" style="left:{beyond:.2}%">{text}</span></div>"#,
                to - from,
                time.median / 1e6,
                shape(column)
            )
            .ok();
        }
        html += "</div>";
    }
    html += r#"<div class="name"></div><div class="track axis">"#;
    let mut last = f64::NEG_INFINITY;
    for (tick, _) in ticks((low, high)).into_iter().filter(|(_, labelled)| *labelled) {
        // Keeps labels at least as far apart as they are wide on a phone.
        if along(tick) > last + 11.0 {
            last = along(tick);
            write!(html, r#"<span style="left:{last:.2}%">{}</span>"#, significant_tick(tick)).ok();
        }
    }
    html + "</div></div>"
}

fn significant_tick(value: f64) -> String {
    if (0.9e-4..0.9e6).contains(&value) { format!("{value}") } else { format!("{value:e}") }
}
