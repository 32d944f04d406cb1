//! The head of the report: which device is fastest and by what factor, which technique is best there, and what interlock gains.

use super::Names;
use crate::bench::{Agreement, BUILD_PATHS, Built, Column, Comparison, Line, Row, Status, Times, Verdict};
use crate::report::answer::selection::{answer, measure};
use crate::report::format::{one_line, outcome, significant, status_word};
use crate::report::warnings::marked;

/// Returns the answer in one sentence.
pub fn devices_answer(beside: &Comparison) -> String {
    one_line(&format!("{}; {}.", fastest(beside), errors(beside, &beside.agreement())))
}

/// Returns the word for the times that are compared, of a frame or of a build.
pub(super) fn what(beside: &Comparison) -> &'static str {
    match beside.times {
        Times::Frame => "frame",
        Times::Build => "build",
    }
}

fn rows(count: usize) -> String {
    if count == 1 { "1 row".into() } else { format!("{count} rows") }
}

/// Describes how fast fragments are on each device, if measured, and how many of its rows are marked for that reason.
pub(super) fn stages(beside: &Comparison) -> Vec<String> {
    let of = |column: &Column| {
        let stages = column.results.device.stages.map(|stages| stages.sentence());
        let told = [stages, marked(&column.results.rows, None)];
        let told: Vec<String> = told.into_iter().flatten().collect();
        (!told.is_empty()).then(|| one_line(&format!("{}: {}", column.name, told.join("; "))))
    };
    beside.columns.iter().filter_map(of).collect()
}

fn is_marked(row: Option<&Row>) -> bool {
    row.is_some_and(|row| !row.marks.is_empty())
}

/// Compares two devices over all rows that both have and that are marked on neither.
struct Pair {
    rows: usize,
    /// Median over the rows of one device's time divided by the other's.
    median: f64,
    /// Number of rows whose difference is within the noise.
    same: usize,
}

fn pair(beside: &Comparison, of: usize, to: usize) -> Option<Pair> {
    let counts = |line: &&Line| [of, to].iter().all(|&column| !is_marked(beside.row(line, column)));
    let all: Vec<_> = beside.lines.iter().filter(counts).filter_map(|line| beside.ratio(line, of, to)).collect();
    let same = all.iter().filter(|(_, verdict)| matches!(verdict, Verdict::Same | Verdict::Unknown)).count();
    Some(Pair { rows: all.len(), median: median(all.into_iter().map(|(ratio, _)| ratio).collect())?, same })
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let low = values.get(middle.checked_sub(usize::from(values.len().is_multiple_of(2)))?)?;
    Some((low * values.get(middle)?).sqrt())
}

fn fastest(beside: &Comparison) -> String {
    let count = beside.columns.len();
    if count == 1 {
        let column = &beside.columns[0];
        return format!("All {} are of one device, {}", rows(column.results.rows.len()), column.name);
    }
    let pairs = |of: usize| -> Vec<(usize, Pair)> {
        (0..count).filter(|&to| to != of).filter_map(|to| Some((to, pair(beside, to, of)?))).collect()
    };
    // The fastest device is the one whose times are the smallest share of the others' times.
    let score = |of: usize| {
        let pairs = pairs(of);
        let sum: f64 = pairs.iter().map(|(_, pair)| pair.median.ln()).sum();
        (!pairs.is_empty()).then(|| sum / pairs.len() as f64)
    };
    let scores = (0..count).filter_map(|of| Some((of, score(of)?)));
    let Some((best, _)) = scores.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))) else {
        let marked = beside.columns.iter().flat_map(|column| &column.results.rows).any(|row| is_marked(Some(row)));
        let that = if marked { " that is not marked" } else { "" };
        return format!("No two devices have a time of the same rows{that}");
    };
    let others = pairs(best);
    let what = what(beside);
    if others.iter().all(|(_, pair)| pair.same == pair.rows) {
        let least = others.iter().map(|(_, pair)| pair.rows).min().unwrap_or(0);
        return format!("No difference in time: noise bands overlap in all {} that each two have", rows(least));
    }
    let parts = others.iter().enumerate().map(|(place, (other, pair))| {
        let name = &beside.columns[*other].name;
        let all = match (place, pair.rows) {
            (_, 1) => "1 row".to_owned(),
            (0, rows) => format!("median of the {rows} rows that both have"),
            (_, rows) => format!("{rows} rows"),
        };
        match pair.same {
            same if same == pair.rows => format!("no longer on {name} ({all})"),
            0 => format!("{} times as long on {name} ({all})", significant(pair.median)),
            same => {
                format!("{} times as long on {name} ({all}, {same} of them no difference)", significant(pair.median))
            }
        }
    });
    let parts: Vec<_> = parts.collect();
    let is_unranked = |place: &usize| {
        let rows = &beside.columns[*place].results.rows;
        *place != best && others.iter().all(|(other, _)| other != place) && rows.iter().any(|row| is_marked(Some(row)))
    };
    let unranked: Vec<String> =
        (0..count).filter(is_unranked).map(|place| beside.columns[place].name.clone()).collect();
    let name = &beside.columns[best].name;
    let of_all = match unranked.is_empty() {
        true => format!("{name} is the fastest"),
        false => format!("Without {}, whose times are marked, {name} is the fastest", listed(&unranked)),
    };
    format!("{of_all}: a {what} takes {}", listed(&parts))
}

/// `a, b and c`.
pub(super) fn listed(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn errors(beside: &Comparison, agreement: &Agreement) -> String {
    let (all, wrong) = (agreement.compared, agreement.disagreements.len());
    let Some(worst) = agreement.disagreements.first() else {
        return match all {
            0 => "no error is in two of them".into(),
            _ => format!("all {all} errors that two or more have agree to rounding"),
        };
    };
    let apart = |column: usize| agreement.disagreements.iter().filter(|found| found.odd == Some(column)).count();
    let who: Vec<String> = (0..beside.columns.len())
        .filter(|&column| apart(column) > 0)
        .map(|column| format!("{} alone in {}", beside.columns[column].name, apart(column)))
        .collect();
    let who = if who.is_empty() { String::new() } else { format!(" ({})", listed(&who)) };
    format!(
        "{wrong} of {all} errors that two or more have differ by more than rounding{who}, by {} at most",
        significant(worst.apart)
    )
}

/// Formats a share as `12 %`, or as a factor if that is clearer.
pub(super) fn share(share: f64) -> String {
    match share {
        s if !s.is_finite() => "from 0".into(),
        s if s >= 10.0 => format!("{} times", significant(s + 1.0)),
        s => format!("{} %", significant(100.0 * s)),
    }
}

/// Names, for each scene, the best balanced technique on each device, among the rows that all devices with that scene have.
pub(super) fn best(beside: &Comparison, names: &Names) -> Vec<String> {
    let mut scenes: Vec<&str> = Vec::new();
    for line in &beside.lines {
        let scene = beside.any(line).scene.as_str();
        if !scenes.contains(&scene) {
            scenes.push(scene);
        }
    }
    scenes.into_iter().filter_map(|scene| best_on(beside, names, scene)).collect()
}

fn best_on(beside: &Comparison, names: &Names, scene: &str) -> Option<String> {
    let of_scene: Vec<usize> =
        (0..beside.lines.len()).filter(|&line| beside.any(&beside.lines[line]).scene == scene).collect();
    let measured = |column: usize, line: usize| {
        let counts = |row: &&Row| row.status == Status::Ok && row.frame_ns.is_some() && row.marks.is_empty();
        beside.row(&beside.lines[line], column).filter(counts)
    };
    let columns: Vec<usize> = (0..beside.columns.len())
        .filter(|&column| of_scene.iter().any(|&line| measured(column, line).is_some()))
        .collect();
    let common: Vec<usize> =
        of_scene.into_iter().filter(|&line| columns.iter().all(|&column| measured(column, line).is_some())).collect();
    if columns.len() < beside.columns.len().min(2) || common.len() < 2 {
        return None;
    }
    // Techniques with their devices.
    let mut groups: Vec<(usize, Vec<String>)> = Vec::new();
    let (mut by, mut time) = ("", "");
    for &column in &columns {
        let rows: Vec<_> = common.iter().filter_map(|&line| Some((line, measured(column, line)?))).collect();
        let measure = measure(&rows);
        (by, time) = (measure.name, measure.time.name);
        let best = answer(&rows, &measure)?.best?;
        let name = beside.columns[column].name.clone();
        match groups.iter_mut().find(|(line, _)| *line == best) {
            Some((_, devices)) => devices.push(name),
            None => groups.push((best, vec![name])),
        }
    }
    let on = |(line, devices): &(usize, Vec<String>)| {
        let devices = if devices.len() == columns.len() && devices.len() > 1 {
            format!("all {}", devices.len())
        } else {
            listed(devices)
        };
        format!("{} on {devices}", names.with_path(*line))
    };
    let parts: Vec<String> = groups.iter().map(on).collect();
    let all = common.len();
    Some(one_line(&format!(
        "On {scene} the best balanced by {time} and {by}, of {all} specs that all have, is {}",
        listed(&parts)
    )))
}

/// What interlock gains on a device.
pub(super) struct Bought {
    /// Short form, which several devices may share: the words before and after the devices' names.
    short: (String, String),
    device: String,
    /// Long form: a sentence with numbers.
    pub(super) long: String,
}

/// Returns what interlock gains on each device that has rows with interlock.
pub(super) fn interlock(beside: &Comparison, all: &[Vec<Built>]) -> Vec<Bought> {
    let of = |column: usize| {
        let built: Vec<&Built> = all.iter().flatten().filter(|built| built.column == column).collect();
        let device = beside.columns[column].name.clone();
        let bought = |short: (String, String), long: String| {
            Some(Bought { short, long: one_line(&long), device: device.clone() })
        };
        let first = built.iter().find_map(|built| beside.built_row(built, 0));
        if let Some(refused) = first.filter(|row| row.status != Status::Ok) {
            let short = status_word(refused.status).to_owned();
            return bought((short, String::new()), format!("{device}: {}", outcome(refused)));
        }
        let over = |path: usize| {
            let counts = |built: &&&Built| [0, path].iter().all(|&path| !is_marked(beside.built_row(built, path)));
            let counted = built.iter().filter(counts);
            let found: Vec<_> = counted.filter_map(|built| beside.over_interlock(built, path)).collect();
            let same = found.iter().filter(|(_, verdict)| *verdict == Verdict::Same).count();
            let count = found.len();
            let ratio = median(found.into_iter().map(|(ratio, _)| ratio).collect())?;
            Some((BUILD_PATHS[path], ratio, count, same))
        };
        let found: Vec<_> = (1..BUILD_PATHS.len()).filter_map(over).collect();
        let all =
            built.iter().flat_map(|built| (0..BUILD_PATHS.len()).filter_map(|path| beside.built_row(built, path)));
        let (count, marked) = (all.clone().count(), all.filter(|row| is_marked(Some(row))).count());
        let left_out = match marked {
            0 => String::new(),
            1 => format!("; 1 of {} is marked and left out", rows(count)),
            _ => format!("; {marked} of {} are marked and left out", rows(count)),
        };
        if found.is_empty() && marked > 0 {
            let short = ("not known".to_owned(), ", where rows are marked".to_owned());
            return bought(short, format!("{device}: not known{left_out}"));
        }
        let (quickest, ratio, count, same) = *found.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let part = |(path, ratio, count, same): &(&str, f64, usize, usize)| {
            let same =
                if *same > 0 { format!(" (no difference in {same} of {})", rows(*count)) } else { String::new() };
            format!("{path} takes ×{}{same}", significant(*ratio))
        };
        let parts: Vec<String> = found.iter().map(part).collect();
        let short = match ratio {
            _ if same == count => (format!("no more than {quickest}"), String::new()),
            r if r < 1.0 => ("nothing".into(), format!(", where {quickest} is faster")),
            _ => (format!("×{} over {quickest}, the next,", significant(ratio)), String::new()),
        };
        let long = format!("{device}: {}{}; of interlock's build time {}{left_out}", short.0, short.1, listed(&parts));
        bought(short, long)
    };
    (0..beside.columns.len()).filter_map(of).collect()
}

/// Returns one line that names devices with the same result together.
pub(super) fn interlock_short(all: &[Bought]) -> Option<String> {
    let mut groups: Vec<(&(String, String), Vec<String>)> = Vec::new();
    for Bought { short, device, .. } in all {
        match groups.iter_mut().find(|(known, _)| *known == short) {
            Some((_, devices)) => devices.push(device.clone()),
            None => groups.push((short, vec![device.clone()])),
        }
    }
    let part = |((before, behind), devices): &(&(String, String), Vec<String>)| {
        format!("{before} on {}{behind}", listed(devices))
    };
    let parts: Vec<_> = groups.iter().map(part).collect();
    (!parts.is_empty()).then(|| format!("What interlock buys: {}", parts.join("; ")))
}
