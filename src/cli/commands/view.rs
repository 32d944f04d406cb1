//! `gobo view`

use crate::Result;
use crate::cli::{ChangeArguments, DeviceArguments, LoadArguments, picture};
use crate::technique::usual;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
#[cfg_attr(not(feature = "view"), allow(dead_code))]
pub struct Arguments {
    /// Scene files, data files or built-in scenes, to choose from in the window; the first is shown
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<String>,
    /// Technique spec A
    #[arg(long, default_value = usual::PICTURE, value_name = "SPEC")]
    technique: String,
    /// Technique spec B, or "reference" for the f64 reference, which fills in while nothing changes
    #[arg(long, default_value = "reference", value_name = "SPEC")]
    against: String,
    /// Size of the picture in pixels, up to 8192 per side; the panel is beside it
    #[arg(long, default_value = "960x720", value_name = picture::VALUE, value_parser = picture::shown)]
    picture: [u32; 2],
    /// Follow the lines of this file instead of keys and mouse: set KEY VALUE, key NAME, frames N, screenshot FILE, …
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    change: ChangeArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

#[cfg(not(feature = "view"))]
pub fn run(_: &Arguments) -> Result<ExitCode> {
    Err(crate::Error::input("gobo view", "this build has no window", "rebuild with --features view"))
}

#[cfg(feature = "view")]
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    use crate::view::{Options, Side, State, open};
    let change = arguments.change.change();
    let mut state = State::new(&arguments.scenes[0], arguments.load.time, arguments.load.lights);
    (state.attractor, state.gravity) = (arguments.load.attractor, arguments.load.gravity);
    (state.eye, state.target, state.up) = (change.eye, change.target, arguments.load.up);
    (state.direction, state.extinction) = (change.direction, change.extinction);
    let named = |option: &str, text: &str| {
        Side::read(text).map_err(|error| error.with_name(|spec| format!("--{option} {spec}")))
    };
    state.sides = [named("technique", &arguments.technique)?, named("against", &arguments.against)?];
    let options = Options {
        scenes: arguments.scenes.clone(),
        size: arguments.picture,
        script: arguments.script.clone(),
        device: arguments.device.device.clone(),
        validation: arguments.device.validation,
        messages: crate::cli::MESSAGES.clone(),
    };
    open(options, state)?;
    crate::cli::check_messages()?;
    Ok(ExitCode::SUCCESS)
}
