//! Which technique for a scene: among the measured rows within limits, the best balanced one, the extremes, and one
//! with less error.

use crate::consume::parse;
use crate::measure::{Results, Row};
use crate::report::answer::{CLOSE_ENOUGH, FLIP, Measure, answer, measure_of_any, point};
use crate::report::pareto::scenes;
use crate::report::wording::{NOTHING, bytes, one_line, significant};
use crate::technique::{Lifetime, REGISTRY};
use serde::Serialize;
use std::collections::BTreeSet;

/// Limits of an answer's time, memory and error; an absent one is no limit.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Milliseconds of a frame.
    pub ms: Option<f64>,
    /// Error of the kind by which the scene's rows are compared.
    pub error: Option<f64>,
    /// Mean FLIP of the picture.
    pub flip: Option<f64>,
    /// Bytes that look-ups need.
    pub bytes: Option<u64>,
}

/// A quantity's name, a row's value, its limit, and how both are written.
type Limited<'a> = (&'a str, Option<f64>, Option<f64>, &'a dyn Fn(f64) -> String);

/// A limit that a row breaks.
struct Broken {
    /// How many times the limit it is; infinite where it was not measured.
    times: f64,
    words: String,
}

impl Limits {
    /// Whether nothing is limited.
    pub fn are_none(&self) -> bool {
        self.ms.is_none() && self.error.is_none() && self.flip.is_none() && self.bytes.is_none()
    }

    /// The kind of error that is compared: FLIP where only FLIP is limited.
    pub(super) fn measure(&self, rows: &[(usize, &Row)]) -> Measure {
        let measure = measure_of_any(rows);
        match self.flip.is_some() && self.error.is_none() {
            true => Measure { time: measure.time, ..FLIP },
            false => measure,
        }
    }

    fn broken(&self, row: &Row, measure: &Measure) -> Vec<Broken> {
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
                // A value that is not a number breaks every limit.
                Some(value) if value <= limit => None,
                Some(value) => {
                    let words = format!("{name} {}, and the limit is {}", words(value), words(limit));
                    Some(Broken { times: value / limit, words })
                }
                None => Some(Broken { times: f64::INFINITY, words: format!("{name} was not measured") }),
            }
        };
        all.into_iter().filter_map(over).collect()
    }
}

/// An answer.
#[derive(Clone, Debug, Serialize)]
pub struct Recommendation {
    /// Several lines, for a person.
    #[serde(skip)]
    pub text: String,
    scene: String,
    device: String,
    /// The kind of the rows' errors, such as `surface error`.
    error: &'static str,
    best: Chosen,
    closer: Option<Chosen>,
    /// A row that is about as quick as the best and far closer by FLIP.
    by_flip: Option<Chosen>,
    fastest: Chosen,
    closest: Chosen,
    smallest: Option<Chosen>,
}

/// A row of an answer.
#[derive(Clone, Debug, Serialize)]
struct Chosen {
    spec: String,
    time_ms: f64,
    error: f64,
    flip: Option<f64>,
    bytes_resident: Option<u64>,
    /// The time of its bake, which is spent once and is not in the time of a frame.
    bake_ms: Option<f64>,
}

/// When a second row is named beside the best one: it takes at most `ABOUT_AS_QUICK` times as long, and its error by
/// FLIP is smaller by a factor of at least `FAR_CLOSER`.
const ABOUT_AS_QUICK: f64 = 1.25;
const FAR_CLOSER: f64 = 3.0;

/// For each scene, in the order in which scenes were measured, an answer, or in one line why there is none.
pub fn recommend(results: &Results, limits: &Limits) -> Vec<Result<Recommendation, String>> {
    scenes(results).into_iter().map(|scene| of_scene(results, scene, limits)).collect()
}

fn of_scene(results: &Results, scene: &str, limits: &Limits) -> Result<Recommendation, String> {
    let rows: Vec<(usize, &Row)> = results.rows.iter().enumerate().filter(|(_, row)| row.scene == scene).collect();
    let measure = limits.measure(&rows);
    let name = one_line(&format!("{scene} on {}", results.device.name));
    let within: Vec<_> = rows
        .iter()
        .copied()
        // `none` stays, however long it takes: a row that is no closer than no shadow is no answer.
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
    let at = |index: usize| point(row(index), &measure).unwrap_or_default();
    let (time, error) = at(found.best);
    let mut text = format!(
        "{name}: {} is best balanced: {} {}, {} {}.\n",
        to_paste(row(found.best)),
        significant(time),
        measure.time.unit,
        measure.name,
        significant(error)
    );
    text += &match next_closer(&within, &measure, found.best) {
        Some(next) => {
            let (longer, smaller) = (at(next).0 / time, at(next).1 / error);
            format!(
                "{} of its error: {} takes {} times as long.\n",
                significant(smaller),
                to_paste(row(next)),
                significant(longer)
            )
        }
        None => "Nothing within the limits is closer by a tenth or more.\n".into(),
    };
    let beside = if measure.name == FLIP.name { measure_of_any(&rows) } else { FLIP };
    let three = [("fastest", Some(found.fastest)), ("closest", Some(found.closest)), ("smallest", found.smallest)];
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
        let bake_ms = bake_ms(row, &measure);
        Chosen {
            spec: to_paste(row),
            time_ms,
            error,
            flip: (FLIP.of)(row),
            bytes_resident: row.bytes_resident,
            bake_ms,
        }
    };
    let next = next_closer(&within, &measure, found.best);
    let by_flip = closer_by_flip(&within, &measure, found.best);
    let mut notes = String::new();
    if let (Some(other), Some(own)) = (by_flip, (FLIP.of)(row(found.best))) {
        notes += &format!(
            "\nBy FLIP {} is far closer: {} for {}, in {} times the time; --max-flip chooses by it.",
            to_paste(row(other)),
            second(row(other)),
            significant(own),
            significant(at(other).0 / time)
        );
    }
    let mut named: Vec<usize> = [found.best, found.fastest, found.closest].into();
    named.extend(next.into_iter().chain(by_flip).chain(found.smallest));
    let mut told = BTreeSet::new();
    for (index, ms) in named.into_iter().filter_map(|index| Some((index, bake_ms(row(index), &measure)?))) {
        if told.insert(index) {
            notes += &format!("\n{} is baked: {} ms, once, in no frame's time.", to_paste(row(index)), significant(ms));
        }
    }
    let unsteady = row(found.best).steadiness.map(|s| s.warnings()).filter(|warnings| !warnings.is_empty());
    let unsteady = unsteady.map(|warnings| {
        format!("\nTimes of {} were not steady ({}): measure again.", to_paste(row(found.best)), warnings.join(", "))
    });
    Ok(Recommendation {
        text: text + &aligned(&lines) + &notes + &unsteady.unwrap_or_default(),
        scene: scene.to_owned(),
        device: results.device.name.clone(),
        error: measure.name,
        best: chosen(found.best),
        closer: next.map(chosen),
        by_flip: by_flip.map(chosen),
        fastest: chosen(found.fastest),
        closest: chosen(found.closest),
        smallest: found.smallest.map(chosen),
    })
}

/// The row whose worst break of a limit is the smallest, and the limits that it breaks.
fn nearest<'a>(rows: &[(usize, &'a Row)], measure: &Measure, limits: &Limits) -> Option<(&'a Row, Vec<Broken>)> {
    let dark = rows.iter().filter(|(_, row)| row.technique == "none").filter_map(|(_, row)| point(row, measure));
    let dark = dark.map(|point| point.1).fold(f64::INFINITY, f64::min);
    let could = |row: &Row| row.technique != "none" && point(row, measure).is_some_and(|point| point.1 < dark);
    let worst = |broken: &[Broken]| broken.iter().map(|broken| broken.times).fold(0.0, f64::max);
    rows.iter()
        .filter(|(_, row)| could(row))
        .map(|(_, row)| (*row, limits.broken(row, measure)))
        .min_by(|a, b| worst(&a.1).total_cmp(&worst(&b.1)))
}

/// The quickest row whose error is at least a tenth less than that of row `best`. Errors that are too small to be worth
/// time count as equal.
fn next_closer(rows: &[(usize, &Row)], measure: &Measure, best: usize) -> Option<usize> {
    let points = |&(index, row): &(usize, &Row)| Some((index, point(row, measure)?));
    let all: Vec<_> = rows.iter().filter(|(_, row)| row.technique != "none").filter_map(points).collect();
    let error = all.iter().find(|(index, _)| *index == best)?.1.1;
    let worth = |error: f64| error.max(CLOSE_ENOUGH);
    let closer = all.iter().filter(|(_, point)| worth(point.1) <= 0.9 * worth(error));
    let least = closer.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    least.map(|(index, _)| *index)
}

/// The time of a row's bake, where the row's time of a frame is without it.
fn bake_ms(row: &Row, measure: &Measure) -> Option<f64> {
    let build = row.build_ns?.median;
    let is_baked = REGISTRY.iter().any(|entry| entry.name == row.technique && entry.lifetime == Lifetime::Baked);
    let is_left_out = (measure.time.of)(row)? < build + row.draw_ns.map_or(0.0, |draw| draw.median);
    (is_baked && is_left_out).then_some(build / 1e6)
}

/// The row with the least error by FLIP among those that take about as long as row `best`, or less. None where that
/// error is not far less than that of `best`, and where `best` was itself chosen by FLIP.
fn closer_by_flip(rows: &[(usize, &Row)], measure: &Measure, best: usize) -> Option<usize> {
    let (dark, lit): (Vec<_>, Vec<_>) = rows.iter().partition(|(_, row)| row.technique == "none");
    let dark = dark.iter().filter_map(|(_, row)| Some(point(row, measure)?.1)).fold(f64::INFINITY, f64::min);
    let points = |&(index, row): &(usize, &Row)| {
        let (time, error) = point(row, measure)?;
        // A row that is no closer than no shadow is no answer.
        (error < dark).then_some((index, time, (FLIP.of)(row)?))
    };
    let all: Vec<_> = lit.iter().filter_map(points).collect();
    let &(_, time, own) = all.iter().find(|(index, ..)| *index == best)?;
    let near = all.iter().filter(|(_, other, flip)| {
        measure.name != FLIP.name && *other <= ABOUT_AS_QUICK * time && FAR_CLOSER * flip.max(CLOSE_ENOUGH) <= own
    });
    near.min_by(|a, b| a.2.total_cmp(&b.2).then(a.1.total_cmp(&b.1))).map(|(index, ..)| *index)
}

/// The spec as it can be given again, without keys that have their default.
fn to_paste(row: &Row) -> String {
    let keys: Vec<_> = row.variant.keys().filter_map(|key| Some(format!("{key}={}", row.value(key)?))).collect();
    match parse(&format!("{}:{}", row.technique, keys.join(","))).as_deref() {
        Ok([spec]) => spec.short(),
        // A file of another version has other keys, which are kept as they are.
        _ => one_line(&row.spec()),
    }
}

/// Columns under their headings; the last one is not padded.
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
    use crate::consume::runs;
    use crate::measure::{ImageError, PointError, RowError, Status};

    /// A spec of the device's default list is the same after its row is turned back into a spec.
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

    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state >> 33
    }

    /// Few values, so that many are equal; some are missing.
    fn row(state: &mut u64, index: usize) -> Row {
        let mut number = |count: u64| random(state) % count;
        let technique = if number(6) == 0 { "none" } else { "avsm" };
        let surface = (number(8) > 0).then(|| PointError { mean_abs: number(6) as f64 / 8.0, ..PointError::default() });
        let image = (number(4) > 0).then(|| ImageError {
            flip_mean: number(5) as f64 / 8.0,
            rmse: 0.0,
            bounce_rmse: None,
            bounce_noise: None,
        });
        Row {
            scene: "s".into(),
            technique: technique.into(),
            // The technique has no such key; the test finds the row again by it.
            variant: [("row".to_owned(), index.to_string())].into(),
            status: if number(8) == 0 { Status::Failed } else { Status::Ok },
            frame_ns: (number(8) > 0).then(|| (1 + number(6)) as f64 * 1e6),
            bytes_resident: (number(8) > 0).then(|| number(6)),
            error: Some(RowError { map: None, space: None, surface, casters: None, image }),
            ..Row::default()
        }
    }

    /// The answer is compared with the definition, row by row: every row that is named is within the limits, and no row
    /// there is better.
    #[test]
    fn the_choice_is_that_of_brute_force() {
        let (mut state, mut answered, mut refused, mut told) = (7, 0, 0, 0);
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
            // Without surface errors, FLIP takes their place.
            let measured = |row: &Row| row.status == Status::Ok && row.frame_ns.is_some();
            let by_flip = limits.flip.is_some() && limits.error.is_none();
            let is_surface = !by_flip
                && rows.iter().any(|row| measured(row) && row.error.as_ref().is_some_and(|e| e.surface.is_some()));
            let flip = |row: &Row| row.error.as_ref().and_then(|e| Some(e.image?.flip_mean));
            let error = |row: &Row| match is_surface {
                true => row.error.as_ref().and_then(|e| Some(e.surface?.mean_abs)),
                false => flip(row),
            };
            let dark = rows.iter().filter(|r| r.technique == "none" && measured(r)).filter_map(error).reduce(f64::min);
            let over =
                |value: Option<f64>, limit: Option<f64>| limit.is_some_and(|limit| value.is_none_or(|v| v > limit));
            let is_choice = |row: &&Row| {
                row.technique != "none"
                    && measured(row)
                    && error(row).is_some_and(|error| dark.is_none_or(|dark| error < dark))
            };
            let is_within = |row: &&Row| {
                !over(row.frame_ns.map(|ns| ns / 1e6), limits.ms)
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
            let time = |row: &Row| row.frame_ns.expect("measured");
            let worth = |row: &Row| time(row) * error(row).expect("measured").max(1e-3);
            let best = named(&text);
            assert!(within.contains(&best) && within.iter().all(|row| worth(best) <= worth(row)), "{text}");
            let closer: Vec<_> = within
                .iter()
                .filter(|row| error(row).expect("measured").max(1e-3) <= 0.9 * error(best).expect("measured").max(1e-3))
                .collect();
            let second = text.lines().nth(1).expect("what is closer");
            assert_eq!(closer.is_empty(), second.starts_with("Nothing"), "{text}");
            if !closer.is_empty() {
                let next = named(second);
                assert!(within.contains(&next) && error(next) < error(best), "{text}");
                assert!(closer.iter().all(|row| time(next) <= time(row)), "{text}");
            }
            // The row that is named by FLIP is about as quick as the best, and far closer.
            if let Some(line) = text.lines().find(|line| line.starts_with("By FLIP")) {
                let other = named(line);
                assert!(within.contains(&other) && time(other) <= 1.25 * time(best), "{text}");
                assert!(3.0 * flip(other).expect("told") <= flip(best).expect("told"), "{text}");
                told += 1;
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
        assert!(answered > 500 && refused > 500 && told > 50, "{answered}, {refused} and {told}");
    }
}
