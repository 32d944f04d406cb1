//! `gobo slice`

use crate::cli::frame_source::States;
use crate::cli::output::sequence::Sequence;
use crate::cli::output::{output_path, silhouette};
use crate::cli::{
    ChangeArguments, DeviceArguments, LoadArguments, MapArguments, MovingArgument, check_messages, load, one_spec,
    picture, say, test_reduction,
};
use crate::query::slice;
use crate::technique::{answers_in_space, open, usual};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Technique spec
    #[arg(long, default_value = usual::PICTURE, value_name = "SPEC")]
    technique: String,
    #[command(flatten)]
    map: MapArguments,
    /// Depth in the light's range: 0 nearest to the light, 1 farthest
    #[arg(long, value_name = "DEPTH")]
    depth: Option<f32>,
    /// Draw this many depths from 0 to 1, or with --moving this many times: FILE-00.png, FILE-01.png, … and an animated
    /// FILE.gif
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=1000))]
    frames: Option<u32>,
    #[command(flatten)]
    moving: MovingArgument,
    /// Size of the slice in pixels, square like the light's view, up to 8192 per side
    #[arg(long, default_value = "512x512", value_name = picture::VALUE, value_parser = picture::square)]
    picture: u32,
    /// Visibility only: no silhouette of the casters, no scale, no words
    #[arg(long)]
    plain: bool,
    /// The PNG to write
    #[arg(short, long, default_value = "gobo-slice.png")]
    out: PathBuf,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    change: ChangeArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() {
            (self.picture, self.frames) = (32, self.frames.map(|frames| frames.min(2)));
        }
        self
    }
}

/// Converts linear visibility to grey, shown as sRGB.
fn gray(visibility: &[f32], size: [u32; 2]) -> Vec<u8> {
    let pixels = visibility.iter().map(|v| [*v; 3]).collect();
    crate::scene::Picture { width: size[0], height: size[1], pixels }.to_srgb8()
}

/// Number of frames of a moving world if `--frames` is not given.
const FRAMES: u32 = 30;

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let depth = arguments.depth.unwrap_or(1.0);
    if !(0.0..=1.0).contains(&depth) {
        return Err(Error::usage(format!("--depth {depth}"), "outside the light's range", "give a number from 0 to 1"));
    }
    let moves = arguments.moving.is_given();
    if arguments.frames.is_some() && arguments.depth.is_some() && !moves {
        return Err(Error::usage("--frames", "they go through all depths, and --depth names one", "leave one out"));
    }
    output_path::check(&arguments.out, "png")?;
    let scene = load(&arguments.scene, &arguments.load)?;
    let spec = one_spec(&arguments.technique)?;
    let frames = arguments.frames.unwrap_or(if moves { FRAMES } else { 1 });
    let states = States::new(scene, &arguments.moving, frames, arguments.change.change())?;
    let first = states.at(0)?;
    let map = arguments.map.of(&first)?;
    let context = arguments.device.open()?;
    let mut world = World::new(&context, &first)?;
    let mut opened = open(&context, &world, &spec)?;
    let size = [arguments.picture; 2];
    let caption = [arguments.map.caption(&first), spec.short()];
    let mut sequence = Sequence::new(&arguments.out, frames);
    let mut path = "";
    let mut first = Some(first);
    for frame in 0..frames {
        // The previous frame is freed before the next is created.
        let scene = &first.take().map_or_else(|| states.at(frame as usize), Ok)?;
        if frame > 0 && moves {
            world.replace(scene)?;
        }
        opened.build(&world)?;
        path = opened.technique.inspect().facts()?.path;
        let technique = &opened.technique;
        answers_in_space(technique.as_ref())?;
        let Some(view) = technique.inspect().maps().get(map).map(|m| m.caster_view) else {
            return Err(Error::usage("--technique", "it has no maps", "name one that has"));
        };
        let sweeps = frames > 1 && !moves;
        let depth = if sweeps { frame as f32 / (frames - 1) as f32 } else { depth };
        let visibility = slice(&context, arguments.map.light, &view, &technique.answer(), depth, size)?;
        let painted = gray(&visibility, size);
        if arguments.plain {
            sequence.add(size, painted)?;
            continue;
        }
        let paper = silhouette::shown(scene, &view, depth, arguments.picture, painted, &caption);
        sequence.add(paper.size, paper.rgb8)?;
    }
    check_messages()?;
    say(format!("{}: {} on {}, path {path}", sequence.names(), spec.short(), context.features().name))?;
    Ok(ExitCode::SUCCESS)
}
