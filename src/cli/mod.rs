//! The command line: one file per subcommand.

mod commands;
mod output;

mod baseline;
mod candidates;
mod compared_frames;
mod default_specs;
mod frame_source;
mod help;
mod hooks;
mod picture;
mod resume;
mod scene_overrides;
mod test_reduction;

#[doc(hidden)]
pub use hooks::test_hooks;

use self::commands::{
    bake, compare, curve, devices, glsl, join, map, recommend, render, report, shell, slice, stress, submit, view,
    voxels,
};
use self::scene_overrides::ChangeArguments;
use crate::advice::advised;
use crate::animate::AnimatedScene;
use crate::gpu::{Context, Messages, Options, fault};
use crate::lights::indirect::{VplsBy, check_count, check_meshes, lit_by_vpls};
use crate::scene::{self, FACES, Scene, check_time};
use crate::shading::parse;
use crate::technique::Spec;
use crate::{Error, Result};
use clap::{Args, CommandFactory, Parser, Subcommand};
use glam::DVec3;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;
use std::sync::LazyLock;

/// How much of a light reaches a point? Gobo builds shadow techniques for smoke and other things that let some light
/// pass, and measures their run time against their error, side by side, on any Vulkan 1.3 device.
#[derive(Parser)]
#[command(version, max_term_width = help::WIDTH, after_long_help = help::techniques())]
struct Cli {
    /// Apply the variables of tests.
    #[arg(long, hide = true)]
    test_hooks: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure techniques on scenes: time, memory and error against the f64 reference, as table, JSON, CSV and a page
    #[command(after_long_help = help::techniques())]
    Compare(compare::Arguments),
    /// Combine the shards of one comparison, as if one run had measured all rows
    Join(join::Arguments),
    /// Find the best technique for a scene on this device, within limits of time, error and memory
    Recommend(recommend::Arguments),
    /// Put results of several devices, drivers or editions side by side: which is fastest, whether their errors agree
    Report(report::Arguments),
    /// Draw a scene, lit by one technique or by the reference
    #[command(after_long_help = help::techniques())]
    Render(render::Arguments),
    /// Open a window: techniques side by side, every setting a control (needs the feature `view`)
    #[command(after_long_help = help::techniques())]
    View(view::Arguments),
    /// Paint visibility at one depth of the light's range over the light's view, or a sweep through all depths
    #[command(after_long_help = help::techniques())]
    Slice(slice::Arguments),
    /// Plot the transmittance along one light ray: the truth, each technique and its nodes
    #[command(after_long_help = help::techniques())]
    Curve(curve::Arguments),
    /// Paint the distances in one light's map (ism): dark is near, orange is empty
    #[command(after_long_help = help::techniques())]
    Map(map::Arguments),
    /// Draw the voxels that a scene's meshes occupy, or the nodes of its shadow's tree
    Voxels(voxels::Arguments),
    /// Bake a technique for a static scene into a file, which --technique voxelized:file=FILE reads
    #[command(after_long_help = help::techniques())]
    Bake(bake::Arguments),
    /// Test techniques to their limits: vary one number of a scene at a time, and report how far each technique holds
    #[command(after_long_help = stress::help())]
    Stress(stress::Arguments),
    /// Measure the standard run, small rows of every technique, and write one file to share: nothing is sent
    Submit(submit::Arguments),
    /// Write look-ups for other programs' shaders: one GLSL file per technique, which lists its bindings and constants
    Glsl(glsl::Arguments),
    /// List Vulkan devices and, for each path of each technique, yes or the missing feature
    Devices(devices::Arguments),
    /// Print a completion script for a shell: `source <(gobo completions bash)`
    Completions(shell::Completions),
    /// Write the manual, one page per command
    Man(shell::Man),
}

/// Options that choose a device.
#[derive(Args)]
struct DeviceArguments {
    /// Device, by index or part of the name in `gobo devices` [default: discrete > integrated > virtual > CPU]
    #[arg(long, value_name = "INDEX|NAME")]
    device: Option<String>,
    /// Run under the validation layer with synchronization validation (slow); its messages make the run fail
    #[arg(long)]
    validation: bool,
}

impl DeviceArguments {
    fn open(&self) -> Result<Context> {
        let options = Options { device: self.device.clone(), validation: self.validation, messages: MESSAGES.clone() };
        Context::new(&options).map_err(|error| error.with_name(|device| format!("--{device}")))
    }
}

/// Options for loading a scene.
#[derive(Args)]
struct LoadArguments {
    /// Time in moving scenes (three-emitters, lantern, courtyard, fountain, sequences of files), in seconds
    #[arg(long, default_value_t = 20.0, value_name = "SECONDS")]
    time: f64,
    /// Number of lights in courtyard, 1 to 1024 [default: 32]
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Hold the attractor of fountain here, in world units [default: it wanders]
    #[arg(long, value_name = "X,Y,Z", value_parser = scene_overrides::vector, allow_hyphen_values = true)]
    attractor: Option<DVec3>,
    /// Gravity in fountain, as a multiple of the earth's, 0 to 10
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", allow_hyphen_values = true)]
    gravity: f64,
    /// Axis of a data file that points up: x, y, z, -x, -y or -z [default: as its format's main writers have it]
    #[arg(long, value_name = "AXIS", value_parser = scene::axis, allow_hyphen_values = true)]
    up: Option<DVec3>,
}

/// The option that replaces the scene's lights with virtual lights.
#[derive(Args)]
struct VplArgument {
    /// Replace the scene's lights with N virtual lights, 64 to 4096: the light that its meshes reflect
    #[arg(long, value_name = "N")]
    vpls: Option<u32>,
    /// Density of virtual lights: by the light that leaves surfaces, or by how much of it reaches what the camera sees
    #[arg(long, value_name = "BY", requires = "vpls", value_enum, default_value_t)]
    vpls_by: VplsBy,
}

impl VplArgument {
    /// Whether the scene's lights are to be replaced.
    fn is_given(&self) -> bool {
        self.vpls.is_some()
    }

    /// Whether virtual lights are placed where the camera sees their light.
    fn follow_the_view(&self) -> bool {
        self.is_given() && self.vpls_by == VplsBy::View
    }

    /// Checks, before a device is opened, that this many virtual lights are allowed, and that these scenes can have them.
    fn check<'a>(&self, scenes: impl IntoIterator<Item = &'a Scene>) -> Result<()> {
        let Some(count) = self.vpls else { return Ok(()) };
        check_count(count).map_err(|error| error.with_name(|_| format!("--vpls {count}")))?;
        let way_out = "leave --vpls out, or name a scene of meshes, such as cornell";
        scenes.into_iter().try_for_each(check_meshes).map_err(|error| error.with_way_out(way_out))
    }

    /// Gives each state of a scene its own virtual lights, if they are requested.
    fn light(&self, context: &Context, states: &mut [Scene]) -> Result<()> {
        let Some(count) = self.vpls else { return Ok(()) };
        for state in states {
            *state = lit_by_vpls(context, state, count, self.vpls_by).map_err(|error| match error {
                Error::Input { .. } => error.with_way_out("leave --vpls out, or name another scene"),
                error => error,
            })?;
        }
        Ok(())
    }
}

/// Times of a moving world.
#[derive(Args)]
struct MovingArgument {
    /// Move the world from the first time to the second, evenly over the frames; with one time, from there on at 30 frames per second
    #[arg(long, value_name = "SECONDS[..SECONDS]", value_parser = span, allow_hyphen_values = true)]
    moving: Option<Span>,
}

/// The first and the last time, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    from: f64,
    to: Option<f64>,
}

/// Frames per second if no last time is given.
const FRAMES_PER_SECOND: f64 = 30.0;

fn span(text: &str) -> std::result::Result<Span, String> {
    let time = |text: &str| text.trim().parse::<f64>().ok().filter(|t| t.is_finite());
    let span = match text.split_once("..") {
        None => time(text).map(|from| Span { from, to: None }),
        Some((from, to)) => time(from).zip(time(to)).map(|(from, to)| Span { from, to: Some(to) }),
    };
    span.ok_or_else(|| "give seconds, or from..to in seconds".into())
}

impl MovingArgument {
    /// Whether the world is to move.
    fn is_given(&self) -> bool {
        self.moving.is_some()
    }

    /// Returns the times of `frames` frames; empty if the world is not to move.
    fn times(&self, scene: &AnimatedScene, frames: u32) -> Result<Vec<f64>> {
        let Some(span) = self.moving else { return Ok(Vec::new()) };
        if !scene.moves() {
            let way_out =
                "leave --moving out, or name three-emitters, lantern, courtyard, fountain or a sequence of files";
            return Err(Error::input(scene.scene.name.clone(), "nothing moves in it", way_out));
        }
        if frames < 2 {
            return Err(Error::usage("--frames", "a world moves from one frame to another", "give 2 or more"));
        }
        let time = |frame: u32| match span.to {
            Some(to) => span.from + (to - span.from) * f64::from(frame) / f64::from(frames - 1),
            None => span.from + f64::from(frame) / FRAMES_PER_SECOND,
        };
        (0..frames).map(time).map(|time_s| check_time(&scene.scene.name, time_s).map(|()| time_s)).collect()
    }

    /// Returns the scene in each of `frames` frames, or only the scene as it is if it is not to move.
    fn states(&self, scene: AnimatedScene, frames: u32) -> Result<Vec<Scene>> {
        let times_s = self.times(&scene, frames)?;
        if times_s.is_empty() {
            Ok(vec![scene.scene])
        } else {
            times_s.iter().map(|time_s| scene.at(*time_s)).collect()
        }
    }
}

/// Returns the error for a light that the scene does not have.
fn no_light(scene: &Scene, light: usize) -> Error {
    let thrice = if scene.colors() > 1 { ": all in red, then all in green, then all in blue" } else { "" };
    let cause = format!("the scene has {} lights, from 0{thrice}", scene.lights.len());
    Error::input(format!("--light {light}"), cause, "choose one of them")
}

/// Options that choose a map of a light.
#[derive(Args)]
struct MapArguments {
    /// The light, from 0 in the scene's order; if casters have several extinction ratios, all in red come first, then green, then blue
    #[arg(long, default_value_t = 0, value_name = "N")]
    light: usize,
    /// For a point light, the face of the cube around it: +x, -x, +y, -y, +z or -z
    #[arg(long, allow_hyphen_values = true)]
    face: Option<String>,
}

impl MapArguments {
    /// Returns the caption of a picture of the map: the scene, and the light if there are several.
    fn caption(&self, scene: &Scene) -> String {
        let light = if scene.lights.len() > 1 { format!(", light {}", self.light) } else { String::new() };
        let face = self.face.as_ref().map(|face| format!(", face {face}")).unwrap_or_default();
        format!("{}{light}{face}", scene.name)
    }

    /// Returns the index of the map among the maps of all lights.
    fn of(&self, scene: &Scene) -> Result<usize> {
        let Some(light) = scene.lights.get(self.light) else {
            return Err(no_light(scene, self.light));
        };
        let names = FACES.map(|(name, _)| name).join(", ");
        let face = match (&self.face, light.map_count()) {
            (None, 1) => 0,
            (None, _) => {
                let cause = "a point light has six maps";
                return Err(Error::input(format!("--light {}", self.light), cause, format!("add --face: {names}")));
            }
            (Some(face), 1) => {
                let cause = format!("light {} is no point light", self.light);
                return Err(Error::input(format!("--face {face}"), cause, "leave it out or choose another --light"));
            }
            (Some(face), _) => FACES.iter().position(|(name, _)| name == face).ok_or_else(|| {
                Error::usage(format!("--face {face}"), "no such face", format!("choose one of: {names}"))
            })?,
        };
        Ok(scene.first_map(self.light) + face)
    }
}

/// Returns the specs given by `--technique`.
fn specs(text: &str) -> Result<Vec<Spec>> {
    parse(text).map_err(|error| error.with_name(|spec| format!("--technique {spec}")))
}

/// Returns the one spec of a command that draws a single picture.
fn one_spec(text: &str) -> Result<Spec> {
    let mut specs = test_reduction::specs(specs(text)?);
    match (specs.pop(), specs.is_empty()) {
        (Some(spec), true) => Ok(spec),
        _ => Err(Error::usage(format!("--technique {text}"), "a sweep", "name one value per key, or use compare")),
    }
}

/// Loads the scene, with a name that is safe in file names, and prints notes about its files.
fn load(name: &str, with: &LoadArguments) -> Result<AnimatedScene> {
    let loaded = load_whole(&test_reduction::name(name), with)?;
    Ok(AnimatedScene { scene: test_reduction::scene(loaded.scene), ..loaded })
}

/// Prints notes about the files of a scene.
fn tell(notes: &[String]) {
    notes.iter().for_each(|note| complain(format!("gobo: note: {note}")));
}

/// Same as [`load`], but never leaves out casters, for commands that show a single place of the scene.
fn load_whole(name: &str, with: &LoadArguments) -> Result<AnimatedScene> {
    let mut scene = AnimatedScene::load_upright(name, with.time, with.up)?;
    tell(&scene.notes);
    if let Some(lights) = with.lights {
        scene = scene.with_lights(lights, with.time)?;
    }
    if with.attractor.is_some() || with.gravity != 1.0 {
        scene = scene.pulled(with.attractor, with.gravity, with.time)?;
    }
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    scene.scene.name = scene.scene.name.chars().map(safe).collect();
    Ok(scene)
}

/// Returns the command as given, without the path of the program. `--resume` is left out: such a command continues an earlier one, and both
/// together must write the same files as a single run without it.
fn command_line() -> String {
    let given = std::env::args().skip(1).filter(|argument| !["--resume", hooks::OPTION].contains(&argument.as_str()));
    std::iter::once("gobo".to_owned()).chain(given).collect::<Vec<_>>().join(" ")
}

/// Messages of the validation layer, and leaks, from all devices opened. The list outlives the devices.
static MESSAGES: LazyLock<Messages> = LazyLock::new(Messages::default);

/// Fails if the validation layer has sent a message.
fn check_messages() -> Result<()> {
    match MESSAGES.all().first() {
        None => Ok(()),
        Some(first) => Err(Error::Gpu {
            operation: "pass",
            name: "validation".into(),
            cause: first.replace('\n', " ").into(),
            way_out: "report this as a bug, with the driver's version".into(),
        }),
    }
}

/// Prints a line. Fails if the disk behind standard output is full, or its reader is gone.
fn say(line: impl Display) -> Result<()> {
    let said = || -> std::io::Result<()> {
        fault::write()?;
        let mut out = std::io::stdout().lock();
        writeln!(out, "{line}")?;
        out.flush()
    };
    said().map_err(|cause| Error::Output {
        path: "stdout".into(),
        cause: cause.to_string(),
        way_out: "what was measured or drawn is in its files; print to a place with room".into(),
    })
}

/// Prints a JSON document instead of tables.
fn say_json(document: &impl serde::Serialize) -> Result<()> {
    say(serde_json::to_string_pretty(document).map_err(|cause| Error::output("stdout".as_ref(), cause))?)
}

/// Prints a line on standard error. A failure is ignored, since there is no other place to report it.
fn complain(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Exit status if the command line is wrong, the same as clap's.
const WRONG_COMMAND: u8 = 2;

/// Runs the program.
pub fn main() -> ExitCode {
    let commands = Cli::command();
    match help::asked(commands.get_subcommands().map(clap::Command::get_name)) {
        Ok(None) => {}
        Ok(Some(page)) => return say(page).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS),
        Err(error) => {
            complain(format!("gobo: {error}"));
            return exit_code(&error);
        }
    }
    let cli = Cli::parse();
    if cli.test_hooks {
        test_hooks();
    }
    let result = match cli.command {
        Command::Compare(arguments) => compare::run(&arguments.little()),
        Command::Join(arguments) => join::run(&arguments),
        Command::Recommend(arguments) => recommend::run(&arguments.little()),
        Command::Report(arguments) => report::run(&arguments),
        Command::Render(arguments) => render::run(&arguments.little()),
        Command::View(arguments) => view::run(&arguments),
        Command::Slice(arguments) => slice::run(&arguments.little()),
        Command::Curve(arguments) => curve::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Voxels(arguments) => voxels::run(&arguments.little()),
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Stress(arguments) => stress::run(&arguments.little()),
        Command::Submit(arguments) => submit::run(&arguments),
        Command::Glsl(arguments) => glsl::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::man(&arguments),
    };
    let result = result.map_err(advised);
    // The device is closed by now, and the layer may have sent messages while it closed.
    let mut errors: Vec<String> = [result.as_ref().err(), check_messages().as_ref().err()]
        .into_iter()
        .flatten()
        .map(ToString::to_string)
        .collect();
    errors.dedup();
    errors.iter().for_each(|error| complain(format!("gobo: {error}")));
    fault::counted().into_iter().for_each(|calls| complain(format!("GOBO_TEST_FAULT: {calls}")));
    match result {
        Ok(code) if errors.is_empty() => code,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => exit_code(&error),
    }
}

/// Returns the exit status of a command that failed: mistyped input gets the same status as errors that clap finds.
fn exit_code(error: &Error) -> ExitCode {
    match error {
        Error::Usage { .. } => ExitCode::from(WRONG_COMMAND),
        _ => ExitCode::FAILURE,
    }
}
