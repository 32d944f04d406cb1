//! `gobo join`

use crate::bench::{Results, Row, join};
use crate::cli::output::exit_code::exit_code;
use crate::cli::output::writer::picture_name;
use crate::cli::resume::pictures;
use crate::cli::{say, say_json};
use crate::report::{Store, answers, page, plots, table};
use crate::{Error, Result};
use clap::Args;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Folders written by gobo compare --shard, each once, in any order
    #[arg(value_name = "DIR", required = true)]
    shards: Vec<PathBuf>,
    /// Folder for results.json, results.csv, pictures, plots and report.html of all rows
    #[arg(short, long, default_value = "gobo-report", value_name = "DIR")]
    out: PathBuf,
    /// Print JSON instead of tables: the same figures, not rounded
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let mut shards = Vec::new();
    for folder in &arguments.shards {
        shards.push((folder.display().to_string(), Results::read(&folder.join("results.json"))?));
    }
    let mut all = join(&shards)?;
    let store = Store::open(&arguments.out)?;
    if let Some(shard) = arguments.shards.iter().find(|shard| is_same(shard, &arguments.out)) {
        let cause = "it is one of the shards, whose results would be lost";
        return Err(Error::input(format!("--out {}", shard.display()), cause, "choose another folder"));
    }
    let of = arguments.shards.len();
    let folders: BTreeMap<usize, &PathBuf> =
        shards.iter().zip(&arguments.shards).filter_map(|((_, r), f)| Some((r.shard.as_ref()?.number, f))).collect();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    for (i, row) in all.rows.iter_mut().enumerate() {
        let place = places.entry(row.scene.clone()).or_default();
        *place += 1;
        copy(row, *place, folders[&(i % of + 1)], &store)?;
    }
    store.write(&all)?;
    for (file, svg) in plots(&all) {
        store.write_text(file, &svg)?;
    }
    store.write_text("report.html", &page(&all, store.dir())?)?;
    if arguments.json {
        say_json(&all)?;
    } else {
        say(table(&all))?;
        for answer in answers(&all) {
            say(format!("\n{answer}"))?;
        }
        say(arguments.out.join("report.html").display())?;
    }
    Ok(exit_code(&all))
}

fn is_same(one: &Path, other: &Path) -> bool {
    one.canonicalize().ok().zip(other.canonicalize().ok()).is_some_and(|(a, b)| a == b)
}

/// Copies a row's pictures. Their names get the number that a single run would give: the row's place among its scene's
/// rows.
fn copy(row: &mut Row, place: usize, from: &Path, to: &Store) -> Result<()> {
    let mut named = row.clone();
    named.picture = row.picture.as_ref().map(|_| picture_name(row, place, ""));
    named.difference = row.difference.as_ref().map(|_| picture_name(row, place, "-difference"));
    let of_shard = Store::open(from)?;
    for (old, new) in pictures(row).iter().zip(pictures(&named)) {
        of_shard.check(old)?;
        let path = from.join(old);
        let bytes = std::fs::read(&path).map_err(|cause| {
            Error::input(path.display().to_string(), cause.to_string(), "repeat the shard's command with --resume")
        })?;
        to.write_file(&new, &bytes)?;
    }
    *row = named;
    Ok(())
}
