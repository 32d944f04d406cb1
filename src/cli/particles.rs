//! `gobo render --particles`: simulated particles as their simulation left them.

use super::render::{Arguments, ColoursArgument};
use super::sequence::Sequence;
use super::{check_messages, one_spec, say};
use crate::consume::{Colours, Lighting, Renderer};
use crate::scene::{Scene, View};
use crate::simulate::Simulation;
use crate::technique::{answers_in_space, open};
use crate::world::World;
use crate::{Error, Result};
use std::process::ExitCode;

/// Draws `scene` at each of these times.
pub fn run(arguments: &Arguments, scene: &Scene, times_s: &[f64], colours: ColoursArgument) -> Result<ExitCode> {
    if arguments.technique == "reference" {
        let way_out = "name a technique, or leave --particles out";
        return Err(Error::input("--technique reference", "it knows of no speeds", way_out));
    }
    let spec = one_spec(&arguments.technique)?;
    let context = arguments.device.open()?;
    let mut world = World::new(&context, scene)?;
    let Some(mut simulation) = Simulation::of(&context, &world)? else {
        let cause = format!("nothing of {} is simulated on the device", scene.name);
        return Err(Error::input("--particles", cause, "leave it out, or name fountain"));
    };
    let fountain = simulation.fountain();
    let colours = match colours {
        ColoursArgument::Speed => Colours::speed(&fountain),
        ColoursArgument::Density => Colours::density(&fountain),
    };
    let size = [arguments.width, arguments.height];
    let mut opened = open(&context, &world, &spec)?;
    answers_in_space(opened.technique.as_ref())?;
    let renderer = Renderer::new(&context, &world, &View::camera(&scene.camera, scene, size))?;
    let mut sequence = Sequence::new(&arguments.out, size, times_s.len() as u32);
    let mut path = "";
    for time_s in times_s {
        simulation.move_to(&mut world, *time_s)?;
        opened.build(&world)?;
        path = opened.technique.facts()?.path;
        let answer = opened.technique.answer();
        let kernels = renderer.kernels(&answer, arguments.shading(&spec), Lighting::Fragment)?;
        let points = renderer.points(&answer, simulation.bodies(), fountain.particles, colours)?;
        renderer.draw_points(&kernels, &points)?;
        sequence.add(renderer.read()?.to_srgb8())?;
    }
    check_messages()?;
    say(format!("{}: {spec} on {}, path {path}", sequence.names(), context.features().name))?;
    Ok(ExitCode::SUCCESS)
}
