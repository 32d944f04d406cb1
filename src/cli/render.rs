//! `gobo render`

use super::sequence::Sequence;
use super::{
    ChangeArguments, DeviceArguments, LoadArguments, MovingArgument, VplArgument, check_messages, little, load,
    one_spec, particles, place, say,
};
use crate::consume::{Lighting, Renderer, Shading, Tiled};
use crate::reference::truth::{Casters, fog, picture};
use crate::report::StepRange;
use crate::scene::{Fog, View};
use crate::technique::{Spec, answers_in_space, open, usual};
use crate::world::World;
use crate::{Error, Result};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Clone, Copy, ValueEnum)]
enum Mesh {
    Forward,
    Deferred,
    Tiled,
    Interleaved,
    Reservoir,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum ColoursArgument {
    /// A triangle a particle, coloured by its speed, lit by the technique
    Speed,
    /// How many particles cover each pixel
    Density,
}

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Technique spec, or "reference" for the f64 reference on the CPU
    #[arg(long, default_value = usual::PICTURE, value_name = "SPEC")]
    pub(super) technique: String,
    /// The PNG to write
    #[arg(short, long, default_value = "gobo-render.png")]
    pub(super) out: PathBuf,
    /// Width of the picture, pixels
    #[arg(long, default_value_t = 1280, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(super) width: u32,
    /// Height of the picture, pixels
    #[arg(long, default_value_t = 720, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(super) height: u32,
    /// How meshes are shaded, whatever the spec's shading= says [default: as it says]
    #[arg(long, value_enum)]
    meshes: Option<Mesh>,
    /// Draw the triangles of lighting=vertex over the casters
    #[arg(long)]
    wireframe: bool,
    /// Fill the scene with fog of this extinction, 1 / world unit, which the technique lights
    #[arg(long, value_name = "EXTINCTION", allow_hyphen_values = true)]
    fog: Option<f32>,
    /// With --fog: equal steps along each camera ray
    #[arg(long, default_value_t = 64, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    fog_steps: u32,
    /// Instead of the picture, paint how many steps the look-ups of all lights take at what each pixel shows of the meshes
    #[arg(long, conflicts_with_all = ["fog", "wireframe"])]
    steps: bool,
    /// Draw simulated particles (of fountain) as the simulation left them: nothing of them leaves the device
    #[arg(long, value_enum, conflicts_with_all = ["fog", "wireframe", "steps", "vpls", "eye", "target", "direction", "extinction"])]
    particles: Option<ColoursArgument>,
    /// With --moving: how many pictures, FILE-00.png, FILE-01.png, … and an animated FILE.gif
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
    pub(super) device: DeviceArguments,
}

impl Arguments {
    /// What is run of it.
    pub fn little(mut self) -> Self {
        if little::is_asked() {
            (self.width, self.height, self.frames) = (32, 18, self.frames.min(2));
            self.vpls.vpls = self.vpls.vpls.map(|count| count.min(64));
        }
        self
    }

    /// How meshes are shaded.
    pub(super) fn shading(&self, spec: &Spec) -> Shading {
        match (self.meshes, Shading::of(&spec.settings())) {
            (None, shading) | (Some(Mesh::Tiled), shading @ Shading::Tiled(_)) => shading,
            (Some(Mesh::Forward), _) => Shading::Forward,
            (Some(Mesh::Deferred), _) => Shading::Deferred,
            (Some(Mesh::Interleaved), _) => Shading::Interleaved,
            (Some(Mesh::Reservoir), _) => Shading::Reservoir,
            (Some(Mesh::Tiled), _) => Shading::Tiled(Tiled::default()),
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    place::check(&arguments.out, "png")?;
    let scene = load(&arguments.scene, &arguments.load)?;
    if let Some(colours) = arguments.particles {
        let mut times_s = arguments.moving.times(&scene, arguments.frames)?;
        if times_s.is_empty() {
            times_s.push(arguments.load.time);
        }
        return particles::run(arguments, &scene, &times_s, colours);
    }
    let mut states = arguments.moving.states(scene, arguments.frames)?;
    for state in &mut states {
        *state = arguments.change.change().of(state)?;
    }
    arguments.vpls.check(&states)?;
    let air = arguments.fog.map(|extinction| Fog::new(extinction, arguments.fog_steps)).transpose();
    let air = air.map_err(|error| error.with_name(|fog| format!("--fog: {fog}")))?;
    let size = [arguments.width, arguments.height];
    let mut sequence = Sequence::new(&arguments.out, size, states.len() as u32);
    if arguments.technique == "reference" {
        lines_spacing(arguments, Lighting::Fragment)?;
        if arguments.steps {
            let way_out = "name a technique, or leave --steps out";
            return Err(Error::input("--technique reference", "it takes no steps", way_out));
        }
        if arguments.vpls.is_given() {
            arguments.vpls.light(&arguments.device.open()?, &mut states)?;
        }
        for scene in &states {
            let camera = View::camera(&scene.camera, scene, size);
            let casters = Casters::new(scene);
            let mut picture = picture(&casters, scene, &camera);
            if let Some(air) = &air {
                picture = fog(&casters, &camera, &picture, air, |light, position| casters.arriving(light, position));
            }
            sequence.add(picture.to_srgb8())?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let spec = one_spec(&arguments.technique)?;
    let lighting = Lighting::of(&spec.settings());
    let spacing = lines_spacing(arguments, lighting)?;
    let context = arguments.device.open()?;
    context.features().require(lighting.requires())?;
    arguments.vpls.light(&context, &mut states)?;
    let mut world = World::new(&context, &states[0])?;
    let mut opened = open(&context, &world, &spec)?;
    if air.is_some() {
        answers_in_space(opened.technique.as_ref())?;
    }
    let shading = arguments.shading(&spec);
    let mut renderer = Renderer::new(&context, &world, &View::camera(&states[0].camera, &states[0], size))?;
    let mut counts = Vec::new();
    let mut path = "";
    for (frame, scene) in states.iter().enumerate() {
        if frame > 0 {
            world.replace(scene)?;
        }
        opened.build(&world)?;
        path = opened.technique.facts()?.path;
        renderer.look(&world, &View::camera(&scene.camera, scene, size))?;
        let answer = opened.technique.answer();
        if arguments.steps {
            counts.push(renderer.steps(&answer)?);
            continue;
        }
        let mut picture = match spacing {
            Some(spacing) => renderer.wireframe(&answer, shading, spacing)?,
            None if states.len() == 1 => renderer.picture_of(opened.technique.as_ref(), shading, lighting)?,
            // In a world that moves the frame before is another one.
            None => {
                renderer.draw(&renderer.kernels_of(opened.technique.as_ref(), shading, lighting)?)?;
                renderer.read()?
            }
        };
        if let Some(air) = &air {
            renderer.fog(&answer, air)?;
            picture = renderer.read()?;
        }
        if let Some(bad) = picture.pixels.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
            let name = format!("pixel {bad} of picture {frame}");
            return Err(Error::input(name, "not a number", "report this as a bug, with the scene"));
        }
        sequence.add(picture.to_srgb8())?;
    }
    let range = StepRange::of(&counts);
    for counts in &counts {
        sequence.add(StepRange::paint(range, counts))?;
    }
    check_messages()?;
    say(format!("{}: {spec} on {}, path {path}", sequence.names(), context.features().name))?;
    range.iter().try_for_each(say)?;
    Ok(ExitCode::SUCCESS)
}

/// The spacing of the vertices whose triangles `--wireframe` draws, where it is given.
fn lines_spacing(arguments: &Arguments, lighting: Lighting) -> Result<Option<f32>> {
    match lighting {
        _ if !arguments.wireframe => Ok(None),
        Lighting::Vertex { spacing } => Ok(Some(spacing)),
        Lighting::Fragment => Err(Error::input(
            "--wireframe",
            format!("--technique {} tessellates nothing", arguments.technique),
            "name a technique with lighting=vertex, such as avsm:lighting=vertex",
        )),
    }
}
