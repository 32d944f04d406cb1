//! `gobo map`

use crate::cli::output::output_path;
use crate::cli::{DeviceArguments, LoadArguments, VplArgument, check_messages, load, no_light, one_spec, say};
use crate::report::write_png;
use crate::technique::{open, usual};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Color where nothing was found.
const HOLE: [u8; 3] = [213, 94, 0];

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Technique spec
    #[arg(long, default_value = usual::DISTANCES, value_name = "SPEC")]
    technique: String,
    /// The light, from 0; if casters have several extinction ratios, all in red come first, then green, then blue
    #[arg(long, default_value_t = 0, value_name = "N")]
    light: usize,
    /// Pixels per side of a texel
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    scale: u32,
    /// The PNG to write
    #[arg(short, long, default_value = "gobo-map.png")]
    out: PathBuf,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    vpls: VplArgument,
    #[command(flatten)]
    device: DeviceArguments,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    output_path::check(&arguments.out, "png")?;
    let mut states = [load(&arguments.scene, &arguments.load)?.scene];
    let spec = one_spec(&arguments.technique)?;
    arguments.vpls.check(&states)?;
    let context = arguments.device.open()?;
    arguments.vpls.light(&context, &mut states)?;
    if arguments.light >= states[0].lights.len() {
        return Err(no_light(&states[0], arguments.light));
    }
    let world = World::new(&context, &states[0])?;
    let mut opened = open(&context, &world, &spec)?;
    opened.build(&world)?;
    let distances = opened.technique.inspect().distances(arguments.light)?;
    check_messages()?;
    if distances.is_empty() {
        let cause = "its maps have no distances";
        return Err(Error::usage(format!("--technique {}", arguments.technique), cause, "name ism"));
    }
    let side = distances.len().isqrt() as u32;
    let pixels = side * arguments.scale;
    let farthest = distances.iter().copied().filter(|d| d.is_finite()).fold(0.0, f32::max);
    let painted = paint(&distances, farthest);
    let texel = |i: u32| painted[((i / pixels / arguments.scale) * side + i % pixels / arguments.scale) as usize];
    let rgb8: Vec<u8> = (0..pixels * pixels).flat_map(texel).collect();
    write_png(&arguments.out, [pixels; 2], &rgb8)?;
    let empty = distances.iter().filter(|d| !d.is_finite()).count();
    say(format!(
        "{}: {spec} on {}, light {}: {empty} of {} texels empty (orange), white at {farthest}",
        arguments.out.display(),
        context.features().name,
        arguments.light,
        distances.len(),
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Converts distances to greys, from black at the light to white at the farthest.
fn paint(distances: &[f32], farthest: f32) -> Vec<[u8; 3]> {
    let grey = |distance: &f32| match distance.is_finite() {
        true => [(255.0 * distance / farthest.max(f32::MIN_POSITIVE)).round() as u8; 3],
        false => HOLE,
    };
    distances.iter().map(grey).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_dark_and_holes_are_marked() {
        let painted = paint(&[0.0, 2.0, 1.0, f32::INFINITY], 2.0);
        assert_eq!(painted, [[0; 3], [255; 3], [128; 3], HOLE]);
        assert_eq!(paint(&[f32::INFINITY], 0.0), [HOLE]);
    }
}
