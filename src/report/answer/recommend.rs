//! Recommends a technique for a scene: among the measured rows within the limits, the best balanced row, the extremes, and one row with
//! less error.

use crate::bench::{Results, Row};
use crate::report::answer::pareto::scenes;
use crate::report::answer::selection::{
    CLOSE_ENOUGH, COMPUTE, FLIP, Measure, answer, dark, floor_ms, is_closer, measure_of_any, point, why_untimed,
};
use crate::report::format::{NOTHING, bytes, one_line, significant};
use crate::shading::parse;
use crate::technique::{Lifetime, REGISTRY};
use serde::Serialize;
use std::collections::BTreeSet;

/// Limits on time, memory and error. An absent limit is not applied.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Milliseconds that shadows add to a frame.
    pub ms: Option<f64>,
    /// Largest error, of the kind by which the scene's rows are compared.
    pub error: Option<f64>,
    /// Largest mean FLIP of the picture.
    pub flip: Option<f64>,
    /// Largest number of bytes that look-ups need.
    pub bytes: Option<u64>,
}

/// Name of a quantity, a row's value, its limit, and how to format both.
type Limited<'a> = (&'a str, Option<f64>, Option<f64>, &'a dyn Fn(f64) -> String);

/// A limit that a row breaks.
struct BrokenLimit {
    /// Value divided by the limit; infinite if the value was not measured.
    times: f64,
    words: String,
}

impl Limits {
    /// Whether no limit is set.
    pub fn are_none(&self) -> bool {
        self.ms.is_none() && self.error.is_none() && self.flip.is_none() && self.bytes.is_none()
    }

    /// Returns the kind of error to compare: FLIP if FLIP is the only error with a limit.
    pub(in crate::report) fn measure(&self, rows: &[(usize, &Row)]) -> Measure {
        let measure = measure_of_any(rows);
        match self.flip.is_some() && self.error.is_none() {
            true => Measure { time: measure.time, ..FLIP },
            false => measure,
        }
    }

    fn broken(&self, row: &Row, measure: &Measure) -> Vec<BrokenLimit> {
        let ms = (measure.time.of)(row).map(|ns| ns / 1e6);
        let size = |count: f64| bytes(count as u64);
        let all: [Limited; 4] = [
            ("time", ms, self.ms, &|ms| format!("{} {}", significant(ms), measure.time.unit)),
            (measure.name, (measure.of)(row), self.error, &significant),
            (FLIP.name, (FLIP.of)(row), self.flip, &significant),
            ("memory", row.bytes_resident.map(|b| b as f64), self.bytes.map(|b| b as f64), &size),
        ];
        let over = |(name, value, limit, words): Limited| {
            let limit = limit?;
            match value {
                // NaN breaks every limit.
                Some(value) if value <= limit => None,
                Some(value) => {
                    let words = format!("{name} {}, and the limit is {}", words(value), words(limit));
                    Some(BrokenLimit { times: value / limit, words })
                }
                None => Some(BrokenLimit { times: f64::INFINITY, words: format!("{name} was not measured") }),
            }
        };
        all.into_iter().filter_map(over).collect()
    }
}

/// A recommendation for one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Recommendation {
    /// Several lines of text for a person.
    #[serde(skip)]
    pub text: String,
    scene: String,
    device: String,
    /// Kind of the rows' errors, such as `seen error`.
    error: &'static str,
    /// Kind of the rows' times, such as `cost`.
    time: &'static str,
    /// Absent if times decide nothing.
    best: Option<ChosenRow>,
    closer: Option<ChosenRow>,
    fastest: Option<ChosenRow>,
    closest: ChosenRow,
    smallest: Option<ChosenRow>,
}

/// A recommended row.
#[derive(Clone, Debug, Serialize)]
struct ChosenRow {
    spec: String,
    time_ms: f64,
    error: f64,
    flip: Option<f64>,
    bytes_resident: Option<u64>,
    /// Time of the bake, which is paid once and is not part of the frame time.
    bake_ms: Option<f64>,
}

/// Returns one recommendation per scene, in the order in which the scenes were measured, or one line that explains why there is none.
pub fn recommend(results: &Results, limits: &Limits) -> Vec<Result<Recommendation, String>> {
    scenes(results).into_iter().map(|scene| of_scene(results, scene, limits)).collect()
}

/// Returns the text printed below the table of a run: the recommendation for each scene, or why there is none. Empty if no errors were
/// measured.
pub fn answers(results: &Results) -> Vec<String> {
    if results.rows.iter().all(|row| row.error.is_none()) {
        return Vec::new();
    }
    let all = recommend(results, &Limits::default());
    all.into_iter().map(|answer| answer.map_or_else(|why| why, |answer| answer.text)).collect()
}

fn of_scene(results: &Results, scene: &str, limits: &Limits) -> Result<Recommendation, String> {
    let rows: Vec<(usize, &Row)> = results.rows.iter().enumerate().filter(|(_, row)| row.scene == scene).collect();
    let measure = limits.measure(&rows);
    let name = one_line(&format!("{scene} on {}", results.device.name));
    let within: Vec<_> = rows
        .iter()
        .copied()
        // Keeps `none`, however long it takes: a row that is no closer than no shadow cannot be recommended.
        .filter(|(_, row)| row.technique == "none" || limits.broken(row, &measure).is_empty())
        .collect();
    let Some(found) = answer(&within, &measure) else {
        return Err(match nearest(&rows, &measure, limits) {
            Some((row, broken)) => {
                let words: Vec<_> = broken.into_iter().map(|broken| broken.words).collect();
                format!("{name}: no row is within the limits; {} comes nearest: {}", to_paste(row), words.join("; "))
            }
            None => format!("{name}: no row has a time and an error less than without shadow; measure more techniques"),
        });
    };
    let row = |index: usize| &results.rows[index];
    let floor = floor_ms(&within, &measure);
    let at = |index: usize| {
        let (ms, error) = point(row(index), &measure).unwrap_or_default();
        (ms.max(floor), error)
    };
    let next = found.best.and_then(|best| next_closer(&within, &measure, best));
    let text = match found.best {
        Some(best) => {
            let (time, error) = at(best);
            let figures =
                format!("{} {}, {} {}", significant(time), measure.time.unit, measure.name, significant(error));
            let dark = dark(&rows, &measure);
            let without =
                if dark.is_finite() { format!(" (without shadows {})", significant(dark)) } else { "".into() };
            let mut text = format!("{name}: {} is best balanced: {figures}{without}.\n", to_paste(row(best)));
            if !found.equal.is_empty() {
                text += &format!("{}\n", equals(found.equal.iter().map(|index| to_paste(row(*index)))));
            }
            text += &match next {
                Some(next) => {
                    let (longer, smaller) = (significant(at(next).0 / time), significant(at(next).1 / error));
                    let spec = to_paste(row(next));
                    format!("{smaller} of its error: {spec}, {longer} times the {}.\n", measure.time.name)
                }
                None => "Nothing within the limits is closer by a tenth or more.\n".into(),
            };
            text
        }
        None => format!("{name}: no row is named by its time: {}.\n", why_untimed(&found, &rows)),
    };
    let beside = if measure.name == FLIP.name { measure_of_any(&rows) } else { FLIP };
    let three = [("fastest", found.fastest), ("closest", Some(found.closest)), ("smallest", found.smallest)];
    let head = ["", measure.time.unit, measure.name, beside.name, "memory", "spec"].map(str::to_owned);
    let second = |row: &Row| (beside.of)(row).map_or_else(|| NOTHING.into(), significant);
    let line = |(what, index): (&str, Option<usize>)| {
        let index = index?;
        let (time, error) = at(index);
        let memory = row(index).bytes_resident.map_or_else(|| NOTHING.into(), bytes);
        let figures = [what.into(), significant(time), significant(error), second(row(index)), memory];
        let [a, b, c, d, e] = figures;
        Some([a, b, c, d, e, to_paste(row(index))])
    };
    let lines: Vec<_> = std::iter::once(head).chain(three.into_iter().filter_map(line)).collect();
    let chosen = |index: usize| {
        let (row, (time_ms, error)) = (row(index), at(index));
        let bake_ms = bake_ms(row);
        ChosenRow {
            spec: to_paste(row),
            time_ms,
            error,
            flip: (FLIP.of)(row),
            bytes_resident: row.bytes_resident,
            bake_ms,
        }
    };
    let mut notes = String::new();
    for &index in &found.left_out {
        let flip = (FLIP.of)(row(index)).map(significant).unwrap_or_default();
        notes += &format!(
            "\n{} is left out: it paints the picture and answers at no point (FLIP {flip}).",
            to_paste(row(index))
        );
    }
    if measure.time.name == COMPUTE.name {
        let why = results.device.stages.map(|stages| format!(" ({})", stages.sentence())).unwrap_or_default();
        notes += &format!("\nTimes of frames decide nothing here{why}: a build and a million look-ups stand for them.");
    }
    if let [first, ..] = found.untimed[..] {
        let rows = match found.untimed.len() {
            1 => format!("{} is", to_paste(row(first))),
            count => format!("{count} rows ({}, …) are", to_paste(row(first))),
        };
        let why = if measure.time.name == COMPUTE.name { "builds that draw" } else { "rows without times" };
        notes += &format!("\n{rows} not judged: {why} have no {}.", measure.time.name);
    }
    let named = [found.best, found.fastest, Some(found.closest), next, found.smallest];
    let is_at_floor = |index: &usize| point(row(*index), &measure).is_some_and(|(ms, _)| ms < floor);
    if named.iter().flatten().any(is_at_floor) {
        let (floor, name) = (significant(floor), measure.time.name);
        notes +=
            &format!("\n{floor} ms stand for any {name} below that: it is the noise of the picture without shadows.");
    }
    let mut told = BTreeSet::new();
    for (index, ms) in named.into_iter().flatten().filter_map(|index| Some((index, bake_ms(row(index))?))) {
        if told.insert(index) {
            notes += &format!("\n{} is baked: {} ms, once, in no frame's time.", to_paste(row(index)), significant(ms));
        }
    }
    let unsteady = found.best.and_then(|best| Some((best, row(best).steadiness?.warnings())));
    let unsteady = unsteady.filter(|(_, warnings)| !warnings.is_empty()).map(|(best, warnings)| {
        format!("\nTimes of {} were not steady ({}): measure again.", to_paste(row(best)), warnings.join(", "))
    });
    Ok(Recommendation {
        text: text + &aligned(&lines) + &notes + &unsteady.unwrap_or_default(),
        scene: scene.to_owned(),
        device: results.device.name.clone(),
        error: measure.name,
        time: measure.time.name,
        best: found.best.map(chosen),
        closer: next.map(chosen),
        fastest: found.fastest.map(chosen),
        closest: chosen(found.closest),
        smallest: found.smallest.map(chosen),
    })
}

/// Returns the sentence that lists rows indistinguishable from the best one.
fn equals(specs: impl Iterator<Item = String>) -> String {
    /// Largest number of rows listed by name.
    const NAMED: usize = 3;
    let all: Vec<String> = specs.collect();
    let more = if all.len() > NAMED { format!(" and {} more", all.len() - NAMED) } else { String::new() };
    format!("Equal to it within the noise of times: {}{more}.", all[..all.len().min(NAMED)].join("; "))
}

/// Returns the row whose worst violation of a limit is the smallest, with the limits that it breaks.
fn nearest<'a>(rows: &[(usize, &'a Row)], measure: &Measure, limits: &Limits) -> Option<(&'a Row, Vec<BrokenLimit>)> {
    let could = |row: &Row| point(row, measure).is_some() && is_closer(row, rows, measure);
    let worst = |broken: &[BrokenLimit]| broken.iter().map(|broken| broken.times).fold(0.0, f64::max);
    rows.iter()
        .filter(|(_, row)| could(row))
        .map(|(_, row)| (*row, limits.broken(row, measure)))
        .min_by(|a, b| worst(&a.1).total_cmp(&worst(&b.1)))
}

/// Returns the quickest row whose error is at least a tenth smaller than that of row `best`. Errors too small to be worth any time count as
/// equal.
fn next_closer(rows: &[(usize, &Row)], measure: &Measure, best: usize) -> Option<usize> {
    let floor = floor_ms(rows, measure);
    let points = |&(index, row): &(usize, &Row)| {
        let (ms, error) = point(row, measure)?;
        Some((index, (ms.max(floor), error)))
    };
    let counts = |row: &Row| row.marks.is_empty() || measure.time.name == COMPUTE.name;
    let is_timed = |(_, row): &&(usize, &Row)| counts(row) && is_closer(row, rows, measure);
    let all: Vec<_> = rows.iter().filter(is_timed).filter_map(points).collect();
    let error = all.iter().find(|(index, _)| *index == best)?.1.1;
    let worth = |error: f64| error.max(CLOSE_ENOUGH);
    let closer = all.iter().filter(|(_, point)| worth(point.1) <= 0.9 * worth(error));
    let least = closer.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    least.map(|(index, _)| *index)
}

/// Returns the time of a row's bake if the row's frame time excludes it.
fn bake_ms(row: &Row) -> Option<f64> {
    let build = row.build_ns?.median;
    let is_baked = REGISTRY.iter().any(|entry| entry.name == row.technique && entry.lifetime == Lifetime::Baked);
    let is_left_out = row.frame_ns? < build + row.draw_ns.map_or(0.0, |draw| draw.median);
    (is_baked && is_left_out).then_some(build / 1e6)
}

/// Returns the spec in a form that can be pasted into a command, without keys at their defaults.
fn to_paste(row: &Row) -> String {
    let keys: Vec<_> = row.variant.keys().filter_map(|key| Some(format!("{key}={}", row.value(key)?))).collect();
    match parse(&format!("{}:{}", row.technique, keys.join(","))).as_deref() {
        Ok([spec]) => spec.short(),
        // A file of another version may have other keys, which are kept unchanged.
        _ => one_line(&row.spec()),
    }
}

/// Aligns columns under their headings; the last column is not padded.
fn aligned(lines: &[[String; 6]]) -> String {
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..5).map(width).collect();
    let mut text = String::new();
    for [what, figures @ .., spec] in lines {
        text += &format!("{what:<0$}", widths[0]);
        for (figure, width) in figures.iter().zip(&widths[1..]) {
            text += &format!("  {figure:>width$}");
        }
        text += &format!("  {spec}\n");
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{ImageError, PassTiming, RowError, SeenError, Status, Timing, Unshadowed};
    use crate::report::answer::selection;
    use crate::shading::runs;

    /// Turns each spec of the device's default lists into a row and back; the result must equal the original spec.
    #[test]
    fn a_spec_to_paste_is_the_row_again() {
        for spec in
            [runs(|runs| runs.compare, false), runs(|runs| runs.many_lights, true)].map(|s| s.expect("known")).concat()
        {
            let row = Row { technique: spec.entry.name.into(), variant: spec.variant(), ..Row::default() };
            let again = parse(&to_paste(&row)).expect("a spec");
            assert_eq!(again.iter().map(ToString::to_string).collect::<Vec<_>>(), [spec.to_string()]);
        }
    }

    #[test]
    fn an_old_word_of_a_default_is_not_pasted() {
        for (spec, pasted) in [
            ("avsm:nodes=4,storage=full", "avsm:nodes=4"),
            ("avsm:storage=packed", "avsm:storage=packed"),
            ("avsm:detail=adaptive,storage=full", "avsm:detail=adaptive,storage=full"),
        ] {
            let spec = parse(spec).expect(spec).remove(0);
            let row = Row { technique: spec.entry.name.into(), variant: spec.variant(), ..Row::default() };
            assert_eq!(to_paste(&row), pasted);
        }
    }

    /// Rows without the deciding time must be counted, and the text must name the time used instead of marked ones.
    #[test]
    fn what_is_not_judged_is_said() {
        let pass = |raster| PassTiming {
            name: "build".into(),
            median_ns: 1e6,
            p05_ns: 1e6,
            p95_ns: 1e6,
            raster: Some(raster),
        };
        let row = |technique: &str, error: f64, raster| Row {
            scene: "s".into(),
            marks: vec!["81 % raster work".into()],
            build_ns: Timing::of(&[1e6]),
            lookup_ns_per_million: Timing::of(&[1e6]),
            passes: vec![pass(raster)],
            ..selection::tests::row(technique, 5.0, error)
        };
        let rows = vec![row("none", 0.5, false), row("avsm", 0.02, false), row("layers", 0.01, true)];
        let text = answers(&Results { rows, ..Results::default() }).remove(0);
        assert!(text.starts_with("s on: avsm is best balanced: 2.00 ms for a build and 10⁶ look-ups"), "{text}");
        assert!(text.contains("\nTimes of frames decide nothing here: a build and a million look-ups stand"), "{text}");
        assert!(text.contains("\nlayers is not judged: builds that draw have no time of build"), "{text}");
        // Without errors there is nothing to recommend.
        assert!(answers(&Results { rows: vec![Row::default()], ..Results::default() }).is_empty());
    }

    /// A cost below the noise of the unshadowed picture must be raised to that noise, also when the next closer row is chosen.
    #[test]
    fn a_cost_below_the_noise_is_the_noise() {
        let draw = Timing { median: 100e6, p05: 98e6, p95: 102e6, samples: 30 };
        let unshadowed = Some(Unshadowed { draw_ns: Some(draw), seen: Some(0.5), flip_mean: None });
        let row = |technique: &str, ms, error| Row {
            scene: "s".into(),
            unshadowed,
            ..selection::tests::row(technique, ms, error)
        };
        let rows = vec![row("avsm", -3.0, 0.02), row("layers", 8.0, 0.01)];
        let text = answers(&Results { rows, ..Results::default() }).remove(0);
        assert!(text.starts_with("s on: avsm is best balanced: 2.00 ms added to a frame"), "{text}");
        assert!(text.contains("0.500 of its error: layers, 4.00 times the cost."), "{text}");
        assert!(text.contains("\n2.00 ms stand for any cost below that"), "{text}");
    }

    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state >> 33
    }

    /// Builds a random row from few distinct values, so that many rows tie; some values are missing.
    fn row(state: &mut u64, index: usize) -> Row {
        let mut number = |count: u64| random(state) % count;
        let technique = if number(6) == 0 { "none" } else { "avsm" };
        let seen = (number(8) > 0).then(|| SeenError { mean: number(6) as f64 / 8.0, ..SeenError::default() });
        let image = (number(4) > 0).then(|| ImageError {
            flip_mean: number(5) as f64 / 8.0,
            rmse: 0.0,
            bounce_rmse: None,
            bounce_noise: None,
        });
        Row {
            scene: "s".into(),
            technique: technique.into(),
            // Not a real key of the technique; the test uses it to find the row again.
            variant: [("row".to_owned(), index.to_string())].into(),
            status: if number(8) == 0 { Status::Failed } else { Status::Ok },
            cost_ns: (number(8) > 0).then(|| (1 + number(6)) as f64 * 1e6),
            bytes_resident: (number(8) > 0).then(|| number(6)),
            error: Some(RowError { seen, map: None, space: None, surface: None, casters: None, image }),
            ..Row::default()
        }
    }

    /// Checks the recommendation against its definition, row by row: every named row must be within the limits, and no row within the
    /// limits may be better.
    #[test]
    fn the_choice_is_that_of_brute_force() {
        let (mut state, mut answered, mut refused) = (7, 0, 0);
        for _ in 0..4000 {
            let count = 1 + random(&mut state) as usize % 7;
            let rows: Vec<Row> = (0..count).map(|index| row(&mut state, index)).collect();
            let mut limit = |scale: f64| {
                let value = random(&mut state) % 12;
                (value < 6).then_some((value + 1) as f64 * scale)
            };
            let limits = Limits {
                ms: limit(1.0),
                error: limit(0.125),
                flip: limit(0.125),
                bytes: limit(1.0).map(|bytes| bytes as u64),
            };
            let results = Results { rows: rows.clone(), ..Results::default() };
            let said = recommend(&results, &limits).remove(0);
            // Without seen errors, FLIP decides.
            let measured = |row: &Row| row.status == Status::Ok && row.cost_ns.is_some();
            let by_flip = limits.flip.is_some() && limits.error.is_none();
            let seen = |row: &Row| row.error.as_ref().and_then(|e| Some(e.seen?.mean));
            let shadows = |row: &&Row| row.technique != "none" && row.status == Status::Ok;
            let is_seen = !by_flip && rows.iter().filter(shadows).any(|row| seen(row).is_some());
            let flip = |row: &Row| row.error.as_ref().and_then(|e| Some(e.image?.flip_mean));
            let error = |row: &Row| if is_seen { seen(row) } else { flip(row) };
            let bare = || rows.iter().filter(|r| r.technique == "none" && r.status == Status::Ok);
            let dark = bare().filter_map(error).reduce(f64::min);
            let dark_flip = bare().filter_map(flip).fold(f64::INFINITY, f64::min);
            let over =
                |value: Option<f64>, limit: Option<f64>| limit.is_some_and(|limit| value.is_none_or(|v| v > limit));
            let is_choice = |row: &&Row| {
                row.technique != "none"
                    && measured(row)
                    && error(row).is_some_and(|error| dark.is_none_or(|dark| error < dark))
                    && flip(row).is_none_or(|flip| flip < dark_flip)
            };
            let is_within = |row: &&Row| {
                !over(row.cost_ns.map(|ns| ns / 1e6), limits.ms)
                    && !over(error(row), limits.error)
                    && !over(flip(row), limits.flip)
                    && !over(row.bytes_resident.map(|b| b as f64), limits.bytes.map(|b| b as f64))
            };
            let within: Vec<&Row> = rows.iter().filter(is_choice).filter(is_within).collect();
            let named = |line: &str| {
                let number = line.split("row=").nth(1).expect("a row is named");
                &rows[number
                    .split(|c: char| !c.is_ascii_digit())
                    .next()
                    .and_then(|n| n.parse::<usize>().ok())
                    .expect("its number")]
            };
            let text = match said {
                Ok(answer) => answer.text,
                Err(why) => {
                    refused += 1;
                    assert!(within.is_empty() && !why.contains('\n'), "{why}");
                    assert_eq!(why.contains("comes nearest"), rows.iter().any(|row| is_choice(&row)), "{why}");
                    if why.contains("comes nearest") {
                        assert!(is_choice(&named(&why)));
                    }
                    continue;
                }
            };
            answered += 1;
            let time = |row: &Row| row.cost_ns.expect("measured");
            let worth = |row: &Row| time(row) * error(row).expect("measured").max(1e-3);
            // The best row must not have a wrong picture: no row of about the same cost may have a far better one.
            let is_right = |row: &&&Row| {
                let as_dear = within.iter().filter(|other| time(other) <= 1.25 * time(row)).filter_map(|o| flip(o));
                flip(row).is_none_or(|own| as_dear.fold(f64::INFINITY, f64::min) * 1.5 >= own)
            };
            let best = named(&text);
            assert!(within.iter().filter(is_right).any(|row| *row == best), "{text}");
            assert!(within.iter().filter(is_right).all(|row| worth(best) <= worth(row)), "{text}");
            let equal = within.iter().filter(is_right).any(|row| *row != best && worth(row) == worth(best));
            assert_eq!(text.contains("Equal to it"), equal, "{text}");
            let closer: Vec<_> = within
                .iter()
                .filter(|row| error(row).expect("measured").max(1e-3) <= 0.9 * error(best).expect("measured").max(1e-3))
                .collect();
            let second = text.lines().skip(1).find(|line| !line.starts_with("Equal")).expect("what is closer");
            assert_eq!(closer.is_empty(), second.starts_with("Nothing"), "{text}");
            if !closer.is_empty() {
                let next = named(second);
                assert!(within.contains(&next) && error(next) < error(best), "{text}");
                assert!(closer.iter().all(|row| time(next) <= time(row)), "{text}");
            }
            let is_table = |line: &&str| ["fastest", "closest", "smallest"].iter().any(|word| line.starts_with(word));
            for line in text.lines().filter(is_table) {
                let row = named(line);
                assert!(within.contains(&row), "{text}");
                let no_better = |other: &&Row| match line.split(' ').next() {
                    Some("fastest") => time(row) <= time(other),
                    Some("closest") => error(row) <= error(other),
                    _ => other.bytes_resident.is_none_or(|bytes| row.bytes_resident.is_some_and(|own| own <= bytes)),
                };
                assert!(within.iter().all(no_better), "{text}");
            }
        }
        assert!(answered > 500 && refused > 500, "{answered} and {refused}");
    }
}
