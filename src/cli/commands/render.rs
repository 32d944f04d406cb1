//! `gobo render`

use crate::animate::AnimatedScene;
use crate::bench::picture_error;
use crate::cli::commands::{particles, steps};
use crate::cli::frame_source::States;
use crate::cli::output::output_path;
use crate::cli::output::render_frames::{RenderedFrame, by_reference, by_technique, lines_spacing};
use crate::cli::output::sequence::Sequence;
use crate::cli::{
    ChangeArguments, DeviceArguments, LoadArguments, MovingArgument, VplArgument, check_messages, load, one_spec,
    picture, say, test_reduction,
};
use crate::report::{Panel, panels};
use crate::scene::{Fog, Show};
use crate::shading::{Lighting, Shading, Tiled};
use crate::technique::{Spec, usual};
use crate::{Error, Result};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

/// The name of the reference, which is not a technique.
const REFERENCE: &str = "reference";

#[derive(Clone, Copy, ValueEnum)]
enum Mesh {
    Forward,
    Deferred,
    Tiled,
    Interleaved,
    Reservoir,
}

#[derive(Clone, Copy, ValueEnum)]
pub(in crate::cli) enum ColorsArgument {
    /// A triangle per particle, colored by its speed, lit by the technique
    Speed,
    /// A triangle per particle, as white as smoke, in the color of the light that the technique lets through
    Color,
    /// How many particles cover each pixel
    Density,
}

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Technique spec, or "reference" for the f64 reference on the CPU; several make one picture of panels, with their errors below if the
    /// reference is one of them
    #[arg(long = "technique", default_value = usual::PICTURE, value_name = "SPEC")]
    pub(in crate::cli) techniques: Vec<String>,
    /// The PNG to write
    #[arg(short, long, default_value = "gobo-render.png")]
    pub(in crate::cli) out: PathBuf,
    /// Size of the picture, or of each panel, in pixels, up to 16384 per side
    #[arg(long, default_value = "1280x720", value_name = picture::VALUE, value_parser = picture::size)]
    picture: [u32; 2],
    /// Samples per pixel: 1, 4, 8 or 16
    #[arg(long, default_value_t = 4, value_name = "N")]
    samples: u32,
    /// How much brighter, in stops: 1 is twice as bright
    #[arg(long, default_value_t = 0.0, value_name = "STOPS", allow_hyphen_values = true)]
    exposure: f32,
    /// The picture that `compare` measures: one sample, a grey sky, no filmic curve
    #[arg(long, conflicts_with_all = ["samples", "exposure"])]
    plain: bool,
    /// With several techniques: panels per row [default: as many as make the whole about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    columns: Option<u32>,
    /// With several techniques: time a frame of each, build and plain picture, and write its device time below
    #[arg(long)]
    pub(in crate::cli) timed: bool,
    /// How meshes are shaded, regardless of the spec's shading= [default: as in the spec]
    #[arg(long, value_enum)]
    meshes: Option<Mesh>,
    /// Draw the triangles of lighting=vertex over some of the casters
    #[arg(long)]
    pub(in crate::cli) wireframe: bool,
    /// Fill the scene with fog of this extinction, in 1 / world unit, lit by the technique
    #[arg(long, value_name = "EXTINCTION", allow_hyphen_values = true)]
    fog: Option<f32>,
    /// With --fog: equal steps along each camera ray
    #[arg(long, default_value_t = 64, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    fog_steps: u32,
    /// Instead of the picture, paint how many steps the look-ups of all lights take on the surface that each pixel sees
    #[arg(long, conflicts_with_all = ["fog", "wireframe"])]
    steps: bool,
    /// Draw simulated particles (of fountain) straight from the simulation, without copying any from the device
    #[arg(long, value_enum, conflicts_with_all = ["fog", "wireframe", "steps", "vpls", "eye", "target", "direction", "extinction"])]
    particles: Option<ColorsArgument>,
    /// With --moving: number of pictures, FILE-00.png, FILE-01.png, … and an animated FILE.gif
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(2..=1000))]
    frames: u32,
    #[command(flatten)]
    moving: MovingArgument,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    change: ChangeArguments,
    #[command(flatten)]
    vpls: VplArgument,
    #[command(flatten)]
    pub(in crate::cli) device: DeviceArguments,
}

impl Arguments {
    /// With `GOBO_TEST_LITTLE`, returns a smaller version of the command.
    pub fn little(mut self) -> Self {
        if test_reduction::is_asked() {
            (self.picture, self.frames) = ([32, 18], self.frames.min(2));
            self.vpls.vpls = self.vpls.vpls.map(|count| count.min(64));
        }
        self
    }

    /// Returns how meshes are shaded.
    pub(in crate::cli) fn shading(&self, spec: &Spec) -> Shading {
        match (self.meshes, Shading::of(&spec.settings())) {
            (None, shading) | (Some(Mesh::Tiled), shading @ Shading::Tiled(_)) => shading,
            (Some(Mesh::Forward), _) => Shading::Forward,
            (Some(Mesh::Deferred), _) => Shading::Deferred,
            (Some(Mesh::Interleaved), _) => Shading::Interleaved,
            (Some(Mesh::Reservoir), _) => Shading::Reservoir,
            (Some(Mesh::Tiled), _) => Shading::Tiled(Tiled::default()),
        }
    }

    /// Returns how the picture is converted for display; `None` for a picture to be measured.
    pub(in crate::cli) fn show(&self) -> Result<Option<Show>> {
        let show = Show::new(self.samples, self.exposure);
        if self.plain {
            Ok(None)
        } else {
            show.map(Some).map_err(|error| error.as_usage().with_name(|what| format!("render: {what}")))
        }
    }

    /// Returns the scene's name.
    pub(in crate::cli) fn scene(&self) -> &str {
        &self.scene
    }

    /// Returns the options with which the scene is loaded.
    pub(in crate::cli) fn load(&self) -> &LoadArguments {
        &self.load
    }

    /// Returns the size of the picture, or of each panel, in pixels.
    pub(in crate::cli) fn size(&self) -> [u32; 2] {
        self.picture
    }

    /// Returns the fog that fills the scene.
    pub(in crate::cli) fn air(&self) -> Result<Option<Fog>> {
        let air = self.fog.map(|extinction| Fog::new(extinction, self.fog_steps)).transpose();
        air.map_err(|error| error.as_usage().with_name(|fog| format!("--fog: {fog}")))
    }

    /// Returns the only technique of a command that draws no panels.
    pub(in crate::cli) fn alone(&self, what: &str) -> Result<&str> {
        match &self.techniques[..] {
            [technique] => Ok(technique),
            _ => Err(Error::usage("--technique", format!("{what} is of one technique"), "name one alone")),
        }
    }
}

/// What lights a picture: a technique or the reference.
enum LitBy {
    Reference,
    Technique(Spec),
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    output_path::check(&arguments.out, "png")?;
    arguments.show()?;
    run_scene(arguments, load(&arguments.scene, &arguments.load)?)
}

/// Draws a scene that is already loaded.
pub(in crate::cli) fn run_scene(arguments: &Arguments, scene: AnimatedScene) -> Result<ExitCode> {
    if let Some(colors) = arguments.particles {
        let mut times_s = arguments.moving.times(&scene, arguments.frames)?;
        if times_s.is_empty() {
            times_s.push(arguments.load.time);
        }
        return particles::run(arguments, &scene, &times_s, colors);
    }
    let mut states = States::new(scene, &arguments.moving, arguments.frames, arguments.change.change())?;
    // Problems in a frame usually occur in the first one too, and are reported before a device is opened.
    arguments.vpls.check([&states.at(0)?])?;
    arguments.air()?;
    if arguments.steps {
        let technique = arguments.alone("--steps")?;
        if technique == REFERENCE {
            let way_out = "name a technique, or leave --steps out";
            return Err(Error::usage("--technique reference", "it takes no steps", way_out));
        }
    }
    let lit_by = |text: &String| {
        let lit_by = if text == REFERENCE { LitBy::Reference } else { LitBy::Technique(one_spec(text)?) };
        let lighting = match &lit_by {
            LitBy::Reference => Lighting::Fragment,
            LitBy::Technique(spec) => Lighting::of(&spec.settings()),
        };
        lines_spacing(arguments, text, lighting)?;
        Ok(lit_by)
    };
    let lit_by: Vec<LitBy> = arguments.techniques.iter().map(lit_by).collect::<Result<_>>()?;
    // No device is needed if only the reference is requested.
    let needs_device = arguments.vpls.is_given() || lit_by.iter().any(|lit_by| matches!(lit_by, LitBy::Technique(_)));
    let context = if needs_device { Some(arguments.device.open()?) } else { None };
    states.lit = context.as_ref().map(|context| (&arguments.vpls, context));
    let states = states;
    let draw = |lit_by: &LitBy, plain: bool, each: &mut dyn FnMut(RenderedFrame) -> Result<()>| match (lit_by, &context)
    {
        (LitBy::Technique(spec), Some(context)) if arguments.steps => {
            steps::by_technique(arguments, context, spec, &states, each)
        }
        (LitBy::Technique(spec), Some(context)) => by_technique(arguments, context, spec, &states, plain, each),
        _ => by_reference(arguments, &states, plain, each).map(|()| Vec::new()),
    };
    if let [lit_by] = &lit_by[..] {
        let mut sequence = Sequence::new(&arguments.out, states.len() as u32);
        let said = draw(lit_by, false, &mut |drawn| sequence.add(drawn.size, drawn.rgb8))?;
        check_messages()?;
        return said_of(&sequence.names(), &said);
    }
    // Techniques on the device come first: a refusal should not wait for the reference, which may take minutes.
    let is_reference = |lit_by: &LitBy| matches!(lit_by, LitBy::Reference);
    let mut order: Vec<usize> = (0..lit_by.len()).collect();
    order.sort_by_key(|i| is_reference(&lit_by[*i]));
    let mut all: Vec<(Vec<RenderedFrame>, Vec<String>)> = lit_by.iter().map(|_| Default::default()).collect();
    for i in order {
        let frames = &mut all[i].0;
        let said = draw(&lit_by[i], true, &mut |drawn| {
            frames.push(drawn);
            Ok(())
        });
        all[i].1 = said.map_err(|error| match error {
            Error::Refused(needs) => {
                Error::Refused(format!("{needs} (--technique {})", arguments.techniques[i]).into())
            }
            error => error,
        })?;
    }
    let (all, said): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    let said = said.concat();
    check_messages()?;
    let reference = lit_by.iter().position(is_reference);
    let sequence = in_panels(arguments, states.len(), &all, reference)?;
    said_of(&sequence.names(), &said)
}

/// Prints which files were written, and by which device.
fn said_of(names: &str, said: &[String]) -> Result<ExitCode> {
    for (i, line) in said.iter().enumerate() {
        if i == 0 { say(format!("{names}: {line}"))? } else { say(line)? }
    }
    Ok(ExitCode::SUCCESS)
}

/// Draws one picture per frame: a panel per technique, with the technique's figures below it.
fn in_panels(
    arguments: &Arguments,
    frames: usize,
    all: &[Vec<RenderedFrame>],
    reference: Option<usize>,
) -> Result<Sequence> {
    let size = arguments.size();
    let mut sequence = Sequence::new(&arguments.out, frames as u32);
    let columns = arguments.columns.unwrap_or_else(|| (1..).find(|c| c * c >= all.len() as u32).unwrap_or(1));
    for frame in 0..frames {
        let panel = |(i, drawn): (usize, &Vec<RenderedFrame>)| {
            let drawn = &drawn[frame];
            let mut known = Vec::new();
            known.extend(drawn.frame_ms.map(|ms| format!("{ms:.2} ms")));
            if let (Some(plain), Some(r)) = (&drawn.plain, reference)
                && let Some(truth) = all[r][frame].plain.as_ref().filter(|_| r != i)
            {
                let error = picture_error(plain, truth);
                known.push(format!("FLIP {:.4}, RMSE {:.4}", error.flip_mean, error.rmse));
            }
            Panel { rgb8: drawn.rgb8.clone(), lines: vec![arguments.techniques[i].clone(), known.join(", ")] }
        };
        let mut all_panels: Vec<Panel> = all.iter().enumerate().map(panel).collect();
        if all_panels.iter().all(|panel| panel.lines[1].is_empty()) {
            all_panels.iter_mut().for_each(|panel| panel.lines.truncate(1));
        }
        let paper = panels(&all_panels, size, columns);
        sequence.add(paper.size, paper.rgb8)?;
    }
    Ok(sequence)
}
