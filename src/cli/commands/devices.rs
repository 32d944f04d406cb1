//! `gobo devices`

use crate::Result;
use crate::bench::{RasterWork, StageRates, raster_worth, stage_rates};
use crate::cli::say;
use crate::gpu::{Context, Features, Options, Requirement, devices};
use crate::technique::{Entry, REGISTRY};
use clap::Args;
use serde_json::json;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Print all facts as JSON
    #[arg(long)]
    json: bool,

    /// Print what each device's rasterizer is worth: the same work drawn and computed
    #[arg(long)]
    raster: bool,
}

/// Requirements of options that all techniques have, in addition to those of their paths.
const ANY: [(&str, &[Requirement]); 2] = [
    ("lighting=vertex", &[Requirement::Tessellation]),
    ("render --wireframe", &[Requirement::Tessellation, Requirement::Lines]),
];

/// Returns (technique, path, missing feature).
fn paths(features: &Features) -> Vec<(&'static str, &'static str, Option<String>)> {
    let of = |entry: &'static Entry| entry.paths.iter().map(move |path| (entry.name, path.name, path.requires));
    let all = REGISTRY.iter().flat_map(|entry| of(entry)).chain(ANY.map(|(name, requires)| ("any", name, requires)));
    all.map(|(technique, path, requires)| {
        let missing = || requires.iter().find_map(|r| features.lacks(*r)).map(str::to_owned);
        (technique, path, features.below_floor.clone().or_else(missing))
    })
    .collect()
}

/// Opens the device with this index, and measures its fragment-shader arithmetic throughput relative to compute shaders.
fn stages(index: usize) -> Result<Option<StageRates>> {
    stage_rates(&Context::new(&Options { device: Some(index.to_string()), ..Options::default() })?)
}

/// Times the same work in the rasterizer and in compute shaders of the device with this index.
fn worth(index: usize) -> Result<Vec<RasterWork>> {
    raster_worth(&Context::new(&Options { device: Some(index.to_string()), ..Options::default() })?)
}

/// Formats one kind of work: `blending 16 layers  0.123 ms drawn, 0.045 ms computed: 2.7 times as long`.
fn worth_line(work: &RasterWork) -> String {
    let ms = |ns: Option<f64>| ns.map(|ns| format!("{:.4} ms", 1e-6 * ns));
    let times = match (ms(work.raster_ns), ms(work.compute_ns)) {
        (Some(drawn), Some(computed)) => format!("{drawn} drawn, {computed} computed: "),
        _ => String::new(),
    };
    match (work.needs, work.ratio) {
        (Some(needs), _) => format!("{:<26} needs {needs}", work.name),
        (None, Some(ratio)) => format!("{:<26} {times}{ratio:.2} times as long", work.name),
        (None, None) => format!("{:<26} not timed: the device has no timestamps", work.name),
    }
}

/// Prints, for each device, the times of the same work in the rasterizer and in compute shaders.
fn say_worth(all: &[Features], json: bool) -> Result<ExitCode> {
    if json {
        let of = |(index, features): (usize, &Features)| {
            Ok(json!({ "index": index, "facts": features, "raster": worth(index)? }))
        };
        say(serde_json::Value::from(all.iter().enumerate().map(of).collect::<Result<Vec<_>>>()?))?;
        return Ok(ExitCode::SUCCESS);
    }
    for (index, features) in all.iter().enumerate() {
        say(format!("{index}  {} ({}, {}, Vulkan {})", features.name, features.kind, features.driver, features.api))?;
        for work in worth(index)? {
            say(format!("     {}", worth_line(&work)))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let all = devices()?;
    if arguments.raster {
        return say_worth(&all, arguments.json);
    }
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
                // A device that cannot be opened is still listed.
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
