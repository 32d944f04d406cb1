//! `gobo render --particles`: simulated particles as their simulation left them.

use crate::animate::{AnimatedScene, Simulation};
use crate::cli::commands::render::{Arguments, ColorsArgument};
use crate::cli::output::render_frames::spec_alone;
use crate::cli::output::sequence::Sequence;
use crate::cli::{check_messages, say};
use crate::reference::truth::filmic;
use crate::report::with_scale;
use crate::scene::{Picture, Show};
use crate::shading::{Colors, Lighting, Pictures};
use crate::technique::{answers_in_space, open};
use crate::world::World;
use crate::{Error, Result};
use std::process::ExitCode;

/// End of the density scale, as a multiple of the number of particles per pixel given by [`Colors::Density`].
const MOST: f32 = 3.0;

/// Draws the scene at each of these times.
pub fn run(
    arguments: &Arguments,
    animated: &AnimatedScene,
    times_s: &[f64],
    colors: ColorsArgument,
) -> Result<ExitCode> {
    let scene = &animated.scene;
    if arguments.alone("--particles")? == "reference" {
        let way_out = "name a technique, or leave --particles out";
        return Err(Error::usage("--technique reference", "it knows of no speeds", way_out));
    }
    let spec = spec_alone(arguments, "--particles")?;
    let context = arguments.device.open()?;
    let mut world = World::new(&context, scene)?;
    let Some(fountain) = animated.fountain() else {
        let cause = format!("nothing of {} is simulated on the device", scene.name);
        return Err(Error::input("--particles", cause, "leave it out, or name fountain"));
    };
    let (mut simulation, law) = (Simulation::new(&context, &world, fountain)?, fountain.law());
    let colors = match colors {
        ColorsArgument::Speed => Colors::Speed { fastest: law.fastest },
        ColorsArgument::Color => Colors::Light,
        ColorsArgument::Density => Colors::density(fountain.particles, law.radius),
    };
    let (size, show) = (arguments.size(), arguments.show()?);
    let mut opened = open(&context, &world, &spec)?;
    answers_in_space(opened.technique.as_ref())?;
    let pictures = Pictures::new(&context, &world, scene, size, show)?;
    let renderer = &pictures.renderer;
    let mut sequence = Sequence::new(&arguments.out, times_s.len() as u32);
    let mut path = "";
    for time_s in times_s {
        simulation.move_to(&mut world, *time_s)?;
        opened.build(&world)?;
        path = opened.technique.inspect().facts()?.path;
        let answer = opened.technique.answer();
        let kernels = renderer.kernels(&answer, arguments.shading(&spec), Lighting::Fragment)?;
        let points = renderer.points(&answer, simulation.bodies(), fountain.particles, colors)?;
        renderer.draw_points(&kernels, &points)?;
        let (size, rgb8) = with_legend(&pictures.read()?, colors, show);
        sequence.add(size, rgb8)?;
    }
    check_messages()?;
    say(format!("{}: {spec} on {}, path {path}", sequence.names(), context.features().name))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the picture, with its color scale below it if the picture is for display.
fn with_legend(picture: &Picture, colors: Colors, show: Option<Show>) -> ([u32; 2], Vec<u8>) {
    let size = [picture.width, picture.height];
    let (last, what, more) = match colors {
        Colors::Speed { fastest } => (fastest, "speed, world units per step", ""),
        Colors::Density { many } => (MOST * many, "particles over a pixel", " and more"),
        Colors::Light => return (size, picture.to_srgb8()),
    };
    let Some(show) = show else { return (size, picture.to_srgb8()) };
    // The colors are shown as they appear under a light of radiance 1.
    let shown = |share: f64| {
        let linear = colors.of(last * share as f32).unwrap_or_default();
        let pixels = vec![linear.map(|c| filmic(f64::from(show.stops).exp2() * f64::from(c)) as f32)];
        let bytes = Picture { width: 1, height: 1, pixels }.to_srgb8();
        [bytes[0], bytes[1], bytes[2]]
    };
    let ends = ["0".into(), format!("{last:.2}{more}")];
    let paper = with_scale(&picture.to_srgb8(), size, shown, [&ends[0], what, &ends[1]]);
    (paper.size, paper.rgb8)
}
