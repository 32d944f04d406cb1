//! `compare --baseline`: what has changed since an earlier run, and whether the changes make this run fail.

use crate::bench::{Change, Margins, Results, Row, change_of, changes, together};
use crate::cli::{complain, say, say_json};
use crate::report::{Fails, bencher, changes_json, changes_table, junit, write_whole};
use crate::technique::Spec;
use crate::{Error, Result};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// An earlier run to compare with, and files for other tools.
#[derive(Args)]
pub struct BaselineArguments {
    /// Compare with an earlier run of the same command, by its results.json, and list the changes. With several --baseline, a time's noise
    /// includes the differences between these runs
    #[arg(long, value_name = "RESULTS.JSON")]
    baseline: Vec<PathBuf>,
    /// Fail if a time is longer than in the baseline, beyond its noise and by more than this [5% if none is given]
    #[arg(long, value_name = "SHARE", requires = "baseline", num_args = 0..=1, default_missing_value = "5%", value_parser = share)]
    fail_slower: Option<f64>,
    /// Fail if an error is larger than in the baseline by more than this [1% if none is given]
    #[arg(long, value_name = "SHARE", requires = "baseline", num_args = 0..=1, default_missing_value = "1%", value_parser = share)]
    fail_worse: Option<f64>,
    /// Fail if a row of the baseline is missing from this run
    #[arg(long, requires = "baseline")]
    fail_gone: bool,
    /// Write the rows as test cases for CI: JUnit XML
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write the figures in Bencher's metric format: JSON
    #[arg(long, value_name = "FILE")]
    bencher: Option<PathBuf>,
}

fn share(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().strip_suffix('%').unwrap_or(text).trim().parse::<f64>().ok();
    let share = number.map(|n| n / 100.0).filter(|share| share.is_finite() && *share >= 0.0);
    share.ok_or_else(|| "give percent: 5%, say".into())
}

/// The printed JSON: the results and their changes.
#[derive(Serialize)]
struct Document<'a> {
    #[serde(flatten)]
    results: &'a Results,
    #[serde(skip_serializing_if = "Option::is_none")]
    changes: Option<serde_json::Value>,
}

/// The earlier results with which a run is compared.
pub struct Baseline<'a> {
    arguments: &'a BaselineArguments,
    /// The runs, in the order given.
    runs: Vec<Results>,
    /// All runs merged into one.
    before: Option<Results>,
    margins: Margins,
    fails: Fails,
}

impl BaselineArguments {
    /// Reads the baseline.
    ///
    /// # Errors
    /// Fails if [`Results::read`] does.
    pub fn read(&self) -> Result<Baseline<'_>> {
        let runs = self.baseline.iter().map(|path| Results::read(path)).collect::<Result<Vec<_>>>()?;
        let usual = Margins::default();
        let margins =
            Margins { time: self.fail_slower.unwrap_or(usual.time), error: self.fail_worse.unwrap_or(usual.error) };
        let fails =
            Fails { slower: self.fail_slower.is_some(), worse: self.fail_worse.is_some(), gone: self.fail_gone };
        Ok(Baseline { arguments: self, before: together(&runs), runs, margins, fails })
    }
}

impl Baseline<'_> {
    /// Checks, before anything is measured, that `now` can be compared with the baseline.
    ///
    /// # Errors
    /// [`Error::Input`] if the baseline is from another device or driver, was measured under other conditions, or has another scene.
    pub fn check(&self, now: &Results) -> Result<()> {
        let device = |results: &Results| {
            let device = &results.device;
            [("device", device.name.clone()), ("driver", device.driver.clone())]
                .map(|(name, value)| (name.to_owned(), value))
        };
        let all = |results: &Results| device(results).into_iter().chain(results.conditions.clone()).collect::<Vec<_>>();
        for (path, before) in self.arguments.baseline.iter().zip(&self.runs) {
            let was = all(before);
            let differs = |(name, new): (String, String)| {
                let old = was.iter().find(|(other, _)| *other == name)?;
                (old.1 != new).then(|| (name, old.1.clone(), new))
            };
            if let Some((what, old, new)) = all(now).into_iter().find_map(differs) {
                let cause = format!("it was measured with {what} {old}, and this is {new}");
                let name = format!("--baseline {}", path.display());
                return Err(Error::input(name, cause, "measure it again there, or repeat its command"));
            }
        }
        Ok(())
    }

    /// Checks, before anything is measured, that each baseline has at least one of the requested rows. Otherwise no change could be found,
    /// and every run would pass.
    ///
    /// # Errors
    /// [`Error::Input`], naming the baseline and a row from each side.
    pub fn check_rows(&self, asked: &[(&str, &Spec)]) -> Result<()> {
        let row = |(scene, spec): &(&str, &Spec)| Row {
            scene: (*scene).to_owned(),
            technique: spec.entry.name.to_owned(),
            variant: spec.variant(),
            ..Row::default()
        };
        let asked: Vec<Row> = asked.iter().map(row).collect();
        self.arguments.baseline.iter().zip(&self.runs).try_for_each(|(path, before)| in_common(path, before, &asked))
    }

    /// Returns the earlier run and the tolerated changes; `None` without `--baseline`.
    pub fn before(&self) -> Option<(&Results, Margins)> {
        self.before.as_ref().map(|before| (before, self.margins))
    }

    /// Prints the changes, or with `json` all results and the changes, and writes the files for other tools. Returns false if the changes
    /// make the run fail.
    ///
    /// # Errors
    /// [`Error::Output`] if a file cannot be written.
    pub fn finish(&self, now: &Results, json: bool) -> Result<bool> {
        let none = Results::default();
        let mut all: Vec<Change> = match &self.before {
            Some(before) => changes(before, now, self.margins),
            None => Vec::new(),
        };
        if now.shard.is_some() {
            // Rows that seem to be gone are in another shard.
            all.retain(|change| !matches!(change, Change::Gone(_)));
        }
        if let Some(path) = &self.arguments.junit {
            write_whole(path, junit(now, &all, self.fails)?.as_bytes())?;
        }
        if let Some(path) = &self.arguments.bencher {
            write_whole(path, bencher(now)?.as_bytes())?;
        }
        let is_held = !self.before.as_ref().unwrap_or(&none).rows.is_empty();
        if json {
            say_json(&Document { results: now, changes: is_held.then(|| changes_json(&all)) })?;
        }
        if !is_held {
            return Ok(true);
        }
        if !json {
            say(format!("\n{}", changes_table(&all, now)))?;
        }
        let failed: Vec<_> = all.iter().filter_map(|change| Some((change, self.fails.why(change)?))).collect();
        for (change, why) in &failed {
            let row = change.row();
            complain(format!("gobo: {} on {}: {why}", row.spec(), row.scene));
        }
        Ok(failed.is_empty())
    }
}

/// Fails if no row of the baseline is among `rows`.
fn in_common(path: &Path, before: &Results, rows: &[Row]) -> Result<()> {
    if rows.iter().any(|row| change_of(before, row, Margins::default()).is_some()) {
        return Ok(());
    }
    let of = |rows: &[Row]| match rows.first() {
        Some(row) => {
            format!("{} ({} on {}{})", rows.len(), row.spec(), row.scene, if rows.len() > 1 { ", …" } else { "" })
        }
        None => "none".into(),
    };
    let cause = format!("of its rows, {}, none is in this run, {}", of(&before.rows), of(rows));
    Err(Error::input(
        format!("--baseline {}", path.display()),
        cause,
        "repeat its command, or measure a baseline with this one",
    ))
}
