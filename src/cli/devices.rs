//! `gobo devices`

use super::say;
use crate::Result;
use crate::gpu::{Context, Features, Options, Requirement, devices};
use crate::measure::{StageRates, stage_rates};
use crate::technique::{Entry, REGISTRY};
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// All facts as JSON
    #[arg(long)]
    json: bool,
}

/// Requirements of options that all techniques have, besides those of their paths.
const ANY: [(&str, &[Requirement]); 2] = [
    ("lighting=vertex", &[Requirement::Tessellation]),
    ("render --wireframe", &[Requirement::Tessellation, Requirement::Lines]),
];

/// (technique, path, missing features).
fn paths(features: &Features) -> Vec<(&'static str, &'static str, Option<String>)> {
    let of = |entry: &'static Entry| entry.paths.iter().map(move |path| (entry.name, path.name, path.requires));
    let all = REGISTRY.iter().flat_map(|entry| of(entry)).chain(ANY.map(|(name, requires)| ("any", name, requires)));
    all.map(|(technique, path, requires)| {
        let missing = || requires.iter().find_map(|r| features.lacks(*r)).map(str::to_owned);
        (technique, path, features.below_floor.clone().or_else(missing))
    })
    .collect()
}

/// How fast fragments compute on the device of this index, beside compute threads. The device is opened for it.
fn stages(index: usize) -> Result<Option<StageRates>> {
    stage_rates(&Context::new(&Options { device: Some(index.to_string()), ..Options::default() })?)
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let all = devices()?;
    if arguments.json {
        let list: Vec<_> = all
            .iter()
            .enumerate()
            .map(|(index, features)| {
                let paths: Vec<_> = paths(features)
                    .into_iter()
                    .map(|(technique, path, missing)| {
                        json!({ "technique": technique, "path": path, "runs": missing.is_none(), "missing": missing })
                    })
                    .collect();
                // A device that cannot be opened is listed all the same.
                let stages = stages(index).ok().flatten();
                json!({ "index": index, "facts": features, "stages": stages, "paths": paths })
            })
            .collect();
        say(serde_json::Value::from(list))?;
        return Ok(ExitCode::SUCCESS);
    }
    for (index, features) in all.iter().enumerate() {
        say(format!("{index}  {} ({}, {}, Vulkan {})", features.name, features.kind, features.driver, features.api))?;
        match stages(index) {
            Ok(Some(stages)) => say(format!("     {}", stages.sentence()))?,
            Ok(None) => {}
            Err(error) => say(format!("     fragments are not measured: {error}"))?,
        }
        for (technique, path, missing) in paths(features) {
            let answer = missing.map_or("yes".to_owned(), |m| format!("needs {m}"));
            say(format!("     {:<24} {answer}", format!("{technique}:{path}")))?;
        }
    }
    if all.is_empty() {
        say("no Vulkan device: install a driver (./setup.sh installs a software driver)")?;
    }
    Ok(ExitCode::SUCCESS)
}
