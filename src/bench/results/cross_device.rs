//! Results of several devices, drivers or editions side by side: one column each, one line per scene and spec.

use crate::bench::results::regression::{ERRORS, FEWEST_SAMPLES, error_verdict, is_same, time_verdict};
use crate::bench::{Results, Row, Status, Timing, Verdict};
use crate::shading::keys;
use crate::technique::REGISTRY;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Relative tolerance when errors for the same casters and the same truth are compared. Drivers round differently; if
/// removing either of two nodes costs the same, they may remove different ones.
pub const ROUNDING: f64 = 1e-3;

/// The prefix of a scene's name in [`Results::conditions`].
const SCENE: &str = "scene ";
/// The prefix of a baked file's name in [`Results::conditions`].
const FILE: &str = "file ";

/// Conditions that change the world being measured, or the work being done.
const WORLD: [&str; 4] = ["--moving", "--turn", "--vpls", "--validation"];

/// Results of one device, one driver and one edition of this program.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The shortest name that distinguishes the column from the others.
    pub name: String,
    /// The files it was read from; several if each held some of the rows.
    pub files: Vec<String>,
    /// All of its rows.
    pub results: Results,
}

/// The rows of one scene and spec: per column, the row's index in that column's results.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Row index per column; `None` if the column lacks the row.
    pub rows: Vec<Option<usize>>,
}

/// Which times are compared: of frames, or of builds alone if the columns have no frame in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    /// Time of a build and a picture.
    Frame,
    /// Time of a build.
    Build,
}

/// An error that differs between columns, although it should be the same on every device.
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    /// Index of the line.
    pub line: usize,
    /// Name of the error.
    pub name: &'static str,
    /// The error in each column; `None` if the column lacks it or measured it at other points.
    pub values: Vec<Option<f64>>,
    /// Difference between the largest and the smallest value.
    pub apart: f64,
    /// `apart` as a fraction of the smallest value; infinite if that is 0.
    pub share: f64,
    /// The column whose removal makes the others agree, if there is one.
    pub odd: Option<usize>,
}

/// How well errors of the same casters agree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Number of errors that two or more columns have.
    pub compared: usize,
    /// The errors that disagree, the farthest apart first. Distances are in the units of the error: fractions of
    /// visibility or of FLIP.
    pub disagreements: Vec<Disagreement>,
}

/// The comparison of all columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The columns, in the order in which they were named.
    pub columns: Vec<Column>,
    /// The lines, scene by scene.
    pub lines: Vec<Line>,
    /// Which times are compared.
    pub times: Times,
}

impl Comparison {
    /// Puts results side by side, each with the name of its file. Files from one device under the same conditions that
    /// have no row in common become one column.
    ///
    /// # Errors
    /// [`Error::Input`] if a file occurs twice, or if no row is in two columns.
    pub fn of(files: Vec<(String, Results)>) -> Result<Self> {
        for (place, (name, results)) in files.iter().enumerate() {
            if let Some((before, _)) = files[..place].iter().find(|(_, other)| other == results) {
                let cause =
                    if name == before { "it is named twice".into() } else { format!("it is the same as {before}") };
                return Err(Error::input(name.clone(), cause, "name each result once"));
            }
        }
        let mut columns: Vec<Column> = Vec::new();
        for (name, results) in files {
            match columns.iter_mut().find(|column| is_part(&column.results, &results)) {
                Some(column) => {
                    column.files.push(name);
                    column.results.conditions.extend(results.conditions);
                    column.results.rows.extend(results.rows);
                }
                None => columns.push(Column { name: String::new(), files: vec![name], results }),
            }
        }
        name(&mut columns);
        let mut beside = Self { lines: lines(&columns), times: times(&columns), columns };
        if beside.columns.len() > 1 && beside.shared().next().is_none() {
            let [first, second, ..] = &beside.columns[..] else { unreachable!("two columns") };
            let has = |column: &Column| {
                let row = column.results.rows.first().map(|row| format!("{} on {}", row.spec(), row.scene));
                row.unwrap_or_else(|| "nothing".into())
            };
            let cause =
                format!("no row of it is in {}: that has {}, and this {}", first.files[0], has(first), has(second));
            return Err(Error::input(second.files[0].clone(), cause, "measure the same scenes and techniques on each"));
        }
        beside.lines.sort_by_key(|line| beside.columns.len() > 1 && line.rows.iter().flatten().count() < 2);
        let mut order = Vec::new();
        for line in &beside.lines {
            let scene = line.any(&beside.columns).scene.clone();
            if !order.contains(&scene) {
                order.push(scene);
            }
        }
        let (columns, all) = (&beside.columns, &mut beside.lines);
        all.sort_by_key(|line| order.iter().position(|scene| *scene == line.any(columns).scene));
        Ok(beside)
    }

    /// Returns the row of a line in a column.
    pub fn row(&self, line: &Line, column: usize) -> Option<&Row> {
        line.rows[column].map(|place| &self.columns[column].results.rows[place])
    }

    /// Returns the first row of a line.
    pub fn any<'a>(&'a self, line: &Line) -> &'a Row {
        line.any(&self.columns)
    }

    /// Returns indices of the lines that two or more columns have, or of all lines if there is only one column.
    pub fn shared(&self) -> impl Iterator<Item = usize> + '_ {
        let least = self.columns.len().min(2);
        (0..self.lines.len()).filter(move |&line| self.lines[line].rows.iter().flatten().count() >= least)
    }

    /// Returns the time of the row that the comparison uses.
    pub fn time(&self, row: &Row) -> Option<Timing> {
        match self.times {
            Times::Frame => frame(row),
            Times::Build => row.build_ns,
        }
    }

    /// Returns the time of column `of` divided by the time of column `to`, and whether the two differ by more than
    /// noise: [`Verdict::Worse`] means that `of` is slower. `None` if either has no time, or if they measured different
    /// worlds.
    pub fn ratio(&self, line: &Line, of: usize, to: usize) -> Option<(f64, Verdict)> {
        let (row, other) = (self.row(line, of)?, self.row(line, to)?);
        if row.status != Status::Ok || other.status != Status::Ok || !self.is_same_world(&row.scene, of, to) {
            return None;
        }
        // Marked rows are shown, but not compared.
        if !row.marks.is_empty() || !other.marks.is_empty() {
            return None;
        }
        ratio([row, other], |row| self.time(row))
    }

    /// Returns the first column whose time in a line is not marked: the other times are given as multiples of it.
    pub fn first(&self, line: &Line) -> Option<usize> {
        let counts = |row: &Row| row.status == Status::Ok && row.marks.is_empty();
        (0..self.columns.len()).find(|column| self.row(line, *column).is_some_and(counts))
    }

    /// Whether two columns measured the same scene with the same movement. A condition that one column does not state
    /// counts as equal.
    pub fn is_same_world(&self, scene: &str, one: usize, other: usize) -> bool {
        let moves = |column: usize| {
            let is = |key: &str| self.columns[column].results.conditions.get(key).is_some_and(|value| value != "none");
            is("--moving") || is("--turn")
        };
        let frames = moves(one) || moves(other);
        let keys = WORLD.into_iter().chain(frames.then_some("--frames"));
        keys.chain([format!("{SCENE}{scene}").as_str()]).all(|key| self.agree(key, one, other))
    }

    fn agree(&self, key: &str, one: usize, other: usize) -> bool {
        let of = |column: usize| self.columns[column].results.conditions.get(key);
        of(one).zip(of(other)).is_none_or(|(a, b)| a == b)
    }

    /// Returns the conditions of measurement in which columns differ: the condition, and each column's value.
    pub fn differing_conditions(&self) -> Vec<(String, Vec<Option<String>>)> {
        let mut all: BTreeMap<&str, Vec<Option<String>>> = BTreeMap::new();
        for (place, column) in self.columns.iter().enumerate() {
            for (key, value) in &column.results.conditions {
                let values = all.entry(key).or_insert_with(|| vec![None; self.columns.len()]);
                values[place] = Some(value.clone());
            }
        }
        let differ = |values: &[Option<String>]| {
            let mut said = values.iter().flatten();
            said.next().is_some_and(|first| said.any(|other| other != first))
        };
        all.into_iter().filter(|(_, values)| differ(values)).map(|(key, values)| (key.to_owned(), values)).collect()
    }

    /// Checks whether all errors that columns have in common are the same, up to rounding.
    pub fn agreement(&self) -> Agreement {
        let mut agreement = Agreement::default();
        for (place, line) in self.lines.iter().enumerate() {
            for (name, of) in ERRORS {
                let error = |column: usize| self.row(line, column).filter(|row| row.status == Status::Ok).and_then(of);
                let Some(first) = (0..self.columns.len()).find(|&column| error(column).is_some()) else { continue };
                let scene = &self.any(line).scene;
                let same = |&column: &usize| {
                    self.is_same_world(scene, first, column)
                        && points_of(name).iter().all(|key| self.agree(key, first, column))
                };
                let values: Vec<Option<f64>> =
                    (0..self.columns.len()).map(|column| error(column).filter(|_| same(&column))).collect();
                if values.iter().flatten().count() < 2 {
                    continue;
                }
                let (least, most) = range(&values);
                agreement.compared += 1;
                let share = if most > least { most / least - 1.0 } else { 0.0 };
                if !agree(&values) {
                    let odd = odd(&values);
                    agreement.disagreements.push(Disagreement {
                        line: place,
                        name,
                        values,
                        apart: most - least,
                        share,
                        odd,
                    });
                }
            }
        }
        agreement.disagreements.sort_by(|a, b| b.apart.total_cmp(&a.apart));
        agreement
    }
}

impl Line {
    fn any<'a>(&self, columns: &'a [Column]) -> &'a Row {
        let row = self.rows.iter().zip(columns).find_map(|(row, column)| Some(&column.results.rows[(*row)?]));
        row.expect("a line is of a row")
    }
}

fn range(values: &[Option<f64>]) -> (f64, f64) {
    let values = || values.iter().flatten().copied();
    (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max))
}

/// Whether errors are the same, up to rounding.
fn agree(values: &[Option<f64>]) -> bool {
    let (least, most) = range(values);
    error_verdict(least, most, ROUNDING) == Verdict::Same
}

/// Returns the column, of three or more, whose removal makes the others agree.
fn odd(values: &[Option<f64>]) -> Option<usize> {
    let without = |column: usize| {
        let mut others = values.to_vec();
        others[column] = None;
        others.iter().flatten().count() > 1 && agree(&others)
    };
    (0..values.len()).find(|&column| values[column].is_some() && without(column))
}

/// Returns the conditions that determine the points of an error.
fn points_of(error: &str) -> &'static [&'static str] {
    match error {
        "map error" => &["--truth"],
        "space error" => &["--quick"],
        "surface error" => &["--quick", "--picture"],
        "seen error" => &["seen points", "--picture"],
        _ => &["--picture"],
    }
}

/// Returns the time of the first row divided by the time of the second, and whether the two differ. Rows that were not
/// steady, or have few samples, must differ by a large factor to count as different.
pub(in crate::bench) fn ratio(rows: [&Row; 2], of: impl Fn(&Row) -> Option<Timing>) -> Option<(f64, Verdict)> {
    let [time, other] = [of(rows[0])?, of(rows[1])?];
    let steady = rows.iter().all(|row| row.steadiness.is_none_or(|s| s.warnings().is_empty()));
    let enough = [time, other].iter().all(|time| time.samples >= FEWEST_SAMPLES);
    let [time, other] = [time, other].map(|time| Timing { samples: time.samples.max(FEWEST_SAMPLES), ..time });
    (other.median > 0.0).then(|| (time.median / other.median, time_verdict(other, time, 0.0, steady && enough)))
}

/// Returns the timing of a build and a picture together. The two are timed separately, so each end of the band is the
/// sum of the ends of the two bands. The band of the true sums cannot be wider than this.
fn frame(row: &Row) -> Option<Timing> {
    let (median, build, draw) = (row.frame_ns?, row.build_ns?, row.draw_ns?);
    if median < build.median + draw.median {
        // A baked technique: no frame of a static world includes the bake.
        return Some(Timing { median, ..draw });
    }
    let (p05, p95) = (build.p05 + draw.p05, build.p95 + draw.p95);
    Some(Timing { median, p05: p05.min(median), p95: p95.max(median), samples: build.samples.min(draw.samples) })
}

fn times(columns: &[Column]) -> Times {
    let mut pictures: Vec<_> = columns.iter().filter_map(|c| c.results.conditions.get("--picture")).collect();
    pictures.dedup();
    let have = columns.iter().all(|column| column.results.rows.iter().any(|row| frame(row).is_some()));
    if pictures.len() < 2 && have { Times::Frame } else { Times::Build }
}

/// Whether `more` holds another part of the run in `there`: same device, driver, commit and conditions, and no row
/// twice. Files without conditions are kept apart.
fn is_part(there: &Results, more: &Results) -> bool {
    let device = |results: &Results| {
        let device = &results.device;
        (device.name.clone(), device.driver.clone(), device.api.clone(), device.features.clone(), results.edition())
    };
    let of_all = |results: &Results| {
        let named = |key: &String| !key.starts_with(SCENE) && !key.starts_with(FILE);
        results.conditions.clone().into_iter().filter(|(key, _)| named(key)).collect::<BTreeMap<_, _>>()
    };
    let agree = |(key, value): (&String, &String)| more.conditions.get(key).is_none_or(|other| other == value);
    let twice = || more.rows.iter().any(|row| there.rows.iter().any(|other| is_same(&whole(other), &whole(row))));
    device(there) == device(more)
        && !there.conditions.is_empty()
        && of_all(there) == of_all(more)
        && there.conditions.iter().all(agree)
        && !twice()
}

/// Returns a row with every key of its technique: a key unknown to an older program gets its default.
fn whole(row: &Row) -> Row {
    let mut row = Row {
        scene: row.scene.clone(),
        technique: row.technique.clone(),
        variant: row.variant.clone(),
        ..Row::default()
    };
    if let Some(entry) = REGISTRY.iter().find(|entry| entry.name == row.technique) {
        for key in keys(entry).filter(|key| !key.default.is_empty()) {
            row.variant.entry(key.name.to_owned()).or_insert_with(|| key.default.to_owned());
        }
    }
    row
}

/// Sorts rows into lines, each of which holds the same scene and spec in several columns. A row joins a line if it is
/// the same ([`is_same`]) as all rows already there. A line has at most one row per column.
fn lines(columns: &[Column]) -> Vec<Line> {
    let mut lines: Vec<(Line, Vec<Row>)> = Vec::new();
    for (column, Column { results, .. }) in columns.iter().enumerate() {
        for (place, row) in results.rows.iter().enumerate() {
            let row = whole(row);
            let same = |line: &&mut (Line, Vec<Row>)| {
                line.0.rows[column].is_none() && line.1.iter().all(|other| is_same(other, &row))
            };
            match lines.iter_mut().find(same) {
                Some((line, rows)) => {
                    line.rows[column] = Some(place);
                    rows.push(row);
                }
                None => {
                    let mut line = Line { rows: vec![None; columns.len()] };
                    line.rows[column] = Some(place);
                    lines.push((line, vec![row]));
                }
            }
        }
    }
    lines.into_iter().map(|(line, _)| line).collect()
}

/// Names each column by its device if that distinguishes it from the others, otherwise also by driver, then by commit,
/// then by file.
fn name(columns: &mut [Column]) {
    // Brackets hold versions of the driver's parts; after a dash comes the version of a distribution's package.
    let whole = |text: &str| text.split(" (").next().unwrap_or_default().trim().to_owned();
    let short = |text: &str| {
        let words = whole(text);
        let version =
            |word: &str| word.starts_with(|c: char| c.is_ascii_digit()).then(|| word.find(['-', '~', '+'])).flatten();
        words.split(' ').map(|word| &word[..version(word).unwrap_or(word.len())]).collect::<Vec<_>>().join(" ")
    };
    let file = |column: &Column| {
        let parts: Vec<&str> = column.files[0].rsplit(['/', '\\']).take(2).collect();
        parts.into_iter().rev().collect::<Vec<_>>().join("/")
    };
    let devices: Vec<String> = columns.iter().map(|column| whole(&column.results.device.name)).collect();
    let with_driver = |text: &dyn Fn(&str) -> String| -> Vec<String> {
        let named = columns.iter().zip(&devices).map(|(column, device)| {
            let driver = text(&column.results.device.driver);
            if driver.starts_with(device.as_str()) { driver } else { format!("{device}, {driver}") }
        });
        named.collect()
    };
    let drivers = with_driver(&short);
    let packages = with_driver(&whole);
    let editions =
        columns.iter().zip(&drivers).map(|(column, driver)| format!("{driver}, gobo {}", column.results.edition()));
    let editions: Vec<String> = editions.collect();
    let kinds = [devices, drivers, packages, editions];
    let names: Vec<[&String; 4]> = (0..columns.len()).map(|place| kinds.each_ref().map(|kind| &kind[place])).collect();
    let alone = |kind: usize, name: &str| names.iter().filter(|other| other[kind] == name).count() == 1;
    let named = |(column, of): (&Column, &[&String; 4])| {
        let name = (0..of.len()).find(|&kind| alone(kind, of[kind])).map(|kind| of[kind].clone());
        name.unwrap_or_else(|| format!("{} ({})", of[1], file(column)))
    };
    let named: Vec<String> = columns.iter().zip(&names).map(named).collect();
    columns.iter_mut().zip(named).for_each(|(column, name)| column.name = name);
}
