//! `gobo curve`

use super::{DeviceArguments, LoadArguments, MapArguments, check_messages, load_whole, place, say};
use crate::measure::LightRay;
use crate::reference::truth::Casters;
use crate::report::{curve, write_whole};
use crate::technique::{Name, open, usual};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// The texel, from the map's upper left
    #[arg(long, value_name = "X,Y", value_parser = texel)]
    texel: [u32; 2],
    #[command(flatten)]
    map: MapArguments,
    /// Technique spec, repeatable; all of one map size
    #[arg(long = "technique", value_name = "SPEC", default_value = usual::CURVE)]
    techniques: Vec<String>,
    /// The SVG to write
    #[arg(short, long, default_value = "gobo-curve.svg")]
    out: PathBuf,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

fn texel(text: &str) -> std::result::Result<[u32; 2], String> {
    let numbers: Vec<u32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    <[u32; 2]>::try_from(numbers).map_err(|_| "give two whole numbers, X,Y".into())
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    place::check(&arguments.out, "svg")?;
    let scene = load_whole(&arguments.scene, &arguments.load)?;
    let map = arguments.map.of(&scene)?;
    let mut specs = Vec::new();
    for text in &arguments.techniques {
        specs.extend(super::specs(text)?);
    }
    if specs.iter().any(|s| s.text(Name::SIZE) != specs[0].text(Name::SIZE)) {
        return Err(Error::input("--technique", "maps of different sizes", "give all the same size="));
    }
    let context = arguments.device.open()?;
    let world = World::new(&context, &scene)?;
    let mut opened = Vec::new();
    let mut names = Vec::new();
    for spec in &specs {
        let mut technique = open(&context, &world, spec)?;
        technique.build(&world)?;
        names.push(format!("{} ({})", spec.short(), technique.technique.facts()?.path));
        opened.push(technique);
    }
    let ray = LightRay::new(&context, &Casters::new(&scene), &opened, map, arguments.texel)?;
    let [x, y] = arguments.texel;
    let title = format!("{}, texel {x},{y}: {} segments", scene.name, ray.segments);
    let svg = curve(&title, &ray, &names)?;
    write_whole(&arguments.out, svg.as_bytes())?;
    check_messages()?;
    say(format!("{}: {} on {}", arguments.out.display(), title, context.features().name))?;
    Ok(ExitCode::SUCCESS)
}
