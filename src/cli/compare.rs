//! `gobo compare`

use super::{DeviceArguments, TimeArgument, check_messages, load};
use crate::Result;
use crate::gpu::{Context, Features};
use crate::measure::{
    Case, DeviceFacts, Effort, Results, Row, SCHEMA, Status, copy_bytes_per_second, difference_srgb8,
};
use crate::report::{Store, page, passes, plots, table};
use crate::scene::Picture;
use crate::technique::{Spec, parse};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;

/// What is compared when no technique is named, as far as the device has what it needs.
const DEFAULT: [&str; 6] = [
    "avsm:nodes=4|8|16,curve=linear|exponential,path=two-pass|interlock",
    "avsm:nodes=8,path=raster-order|binned",
    "psm:path=raster|fused",
    "translucency-map:path=raster|binned",
    "beer-shadow-map:path=raster|binned",
    "uncompressed",
];

/// Texels a side of the light's map in [`DEFAULT`] on a software device, which would take minutes for 256.
const DEFAULT_SIZE_ON_CPU: u32 = 64;

/// Pixels of a picture of a quick look, and of [`DEFAULT`] on a software device.
const SMALL_PICTURE: [u32; 2] = [320, 180];

#[derive(Args)]
pub struct Arguments {
    /// Scene files or built-in scenes [default: three-emitters]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Technique spec, repeatable [default: everything the device can run]
    #[arg(long = "technique", value_name = "SPEC")]
    techniques: Vec<String>,
    /// Folder for results.json, results.csv, pictures, plots and report.html
    #[arg(long, default_value = "gobo-report", value_name = "DIR")]
    out: PathBuf,
    /// Timed frames a row
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// A quick look: 8 frames, an eighth of the space points, a quarter of the picture
    #[arg(long)]
    quick: bool,
    /// Build everything, also what no look-up misses and where nothing has changed: skip=off for every technique
    #[arg(long)]
    no_skip: bool,
    /// Print the time of each pass of a build too, and the whole over that of copying as many bytes as it leaves behind
    #[arg(long)]
    passes: bool,
    #[command(flatten)]
    time: TimeArgument,
    #[command(flatten)]
    device: DeviceArguments,
}

fn effort(arguments: &Arguments, features: &Features) -> Effort {
    let frames = arguments.frames as usize;
    if arguments.quick {
        return Effort { frames: frames.min(8), warm_up: 2, space_points: 8192, picture: SMALL_PICTURE };
    }
    let small = arguments.techniques.is_empty() && features.is_software();
    Effort { frames, warm_up: 5, space_points: 65536, picture: if small { SMALL_PICTURE } else { [640, 360] } }
}

fn device_facts(features: &Features) -> DeviceFacts {
    DeviceFacts {
        name: features.name.clone(),
        driver: features.driver.clone(),
        api: features.api.clone(),
        kind: features.kind.to_string(),
        features: features.facts(),
        copy_bytes_per_second: None,
    }
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let scene_names =
        if arguments.scenes.is_empty() { vec!["three-emitters".to_owned()] } else { arguments.scenes.clone() };
    // Everything that can be wrong with the input is found before the first measurement.
    let mut specs: Vec<Spec> = Vec::new();
    for text in &arguments.techniques {
        specs.extend(parse(text)?);
    }
    let scenes = scene_names.iter().map(|name| load(name, &arguments.time)).collect::<Result<Vec<_>>>()?;
    let context = arguments.device.open()?;
    if specs.is_empty() {
        specs = default_specs(context.features())?;
    }
    if arguments.no_skip {
        specs.iter_mut().for_each(|spec| spec.set("skip", "off"));
    }
    let store = Store::open(&arguments.out)?;
    let mut results = Results {
        schema: SCHEMA,
        gobo: env!("CARGO_PKG_VERSION").into(),
        command: command_line(),
        device: device_facts(context.features()),
        rows: Vec::new(),
    };
    if arguments.passes {
        results.device.copy_bytes_per_second = copy_bytes_per_second(&context)?;
    }
    let bar = ProgressBar::new((specs.len() * scenes.len()) as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} {wide_msg}") {
        bar.set_style(style);
    }
    for scene in &scenes {
        bar.set_message(format!("{}: reference", scene.name));
        bar.tick();
        let mut case = Case::new(&context, scene, effort(arguments, context.features()))?;
        let reference = format!("{}-reference.png", scene.name);
        write_picture(&store, &reference, &case.reference, &case.reference.to_srgb8())?;
        for spec in &specs {
            bar.set_message(format!("{}: {spec}", scene.name));
            let (mut row, picture) = case.measure(spec);
            if let Some(picture) = picture {
                row.picture = Some(picture_name(&row, &results, ""));
                row.difference = Some(picture_name(&row, &results, "-difference"));
                let difference = difference_srgb8(&picture, &case.reference);
                let names = [&row.picture, &row.difference];
                for (name, rgb8) in names.into_iter().flatten().zip([picture.to_srgb8(), difference]) {
                    write_picture(&store, name, &picture, &rgb8)?;
                }
            }
            results.rows.push(row);
            store.write(&results)?;
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    for (file, svg) in plots(&results) {
        store.write_text(file, &svg)?;
    }
    store.write_text("report.html", &page(&results, store.dir())?)?;
    println!("{}", table(&results));
    if arguments.passes {
        println!("{}", passes(&results));
    }
    println!("{}", arguments.out.join("report.html").display());
    check_messages(&context)?;
    Ok(exit_code(&context, &results))
}

fn default_specs(features: &Features) -> Result<Vec<Spec>> {
    let mut specs = Vec::new();
    for text in DEFAULT {
        let on_cpu = format!("{text}{}size={DEFAULT_SIZE_ON_CPU}", if text.contains(':') { ',' } else { ':' });
        specs.extend(parse(if features.is_software() { &on_cpu } else { text })?);
    }
    specs.retain(|spec| {
        let path = spec.entry.paths.iter().find(|p| p.name == spec.value("path"));
        path.is_none_or(|p| p.requires.iter().all(|r| features.lacks(*r).is_none()))
    });
    Ok(specs)
}

/// Success where every row is ok or refused.
fn exit_code(context: &Context, results: &Results) -> ExitCode {
    let failed: Vec<_> = results.rows.iter().filter(|r| r.status == Status::Failed).collect();
    for row in &failed {
        eprintln!("gobo: {} on {} ({}): {}", row.spec(), row.scene, context.features().name, row.reason);
    }
    if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The command as it was given, without the path of the program.
fn command_line() -> String {
    std::iter::once("gobo".to_owned()).chain(std::env::args().skip(1)).collect::<Vec<_>>().join(" ")
}

/// SCENE-NN-TECHNIQUE.png: the number is the row's place among its scene's.
fn picture_name(row: &Row, results: &Results, suffix: &str) -> String {
    let place = results.rows.iter().filter(|r| r.scene == row.scene).count() + 1;
    format!("{}-{place:02}-{}{suffix}.png", row.scene, row.technique)
}

fn write_picture(store: &Store, name: &str, picture: &Picture, rgb8: &[u8]) -> Result<()> {
    store.write_picture(name, picture.width, picture.height, rgb8)
}
