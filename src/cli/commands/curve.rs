//! `gobo curve`

use crate::bench::{BuiltTechniques, LightRay, telling_texel};
use crate::cli::output::output_path;
use crate::cli::{ChangeArguments, DeviceArguments, LoadArguments, MapArguments, check_messages, load_whole, say};
use crate::reference::truth::Casters;
use crate::report::{curve, write_whole};
use crate::technique::{Name, usual};
use crate::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Texel, from the map's upper left [default: of many, the one with the most casters on its ray, and with some light left]
    #[arg(long, value_name = "X,Y", value_parser = texel)]
    texel: Option<[u32; 2]>,
    #[command(flatten)]
    map: MapArguments,
    /// Technique spec, repeatable; all with the same map size
    #[arg(long = "technique", value_name = "SPEC", default_value = usual::CURVE)]
    techniques: Vec<String>,
    /// The SVG to write
    #[arg(short, long, default_value = "gobo-curve.svg")]
    out: PathBuf,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    change: ChangeArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

fn texel(text: &str) -> std::result::Result<[u32; 2], String> {
    let numbers: Vec<u32> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    <[u32; 2]>::try_from(numbers).map_err(|_| "give two whole numbers, X,Y".into())
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    output_path::check(&arguments.out, "svg")?;
    let scene = arguments.change.change().of(&load_whole(&arguments.scene, &arguments.load)?.scene)?;
    let map = arguments.map.of(&scene)?;
    let mut specs = Vec::new();
    for text in &arguments.techniques {
        specs.extend(crate::cli::specs(text)?);
    }
    if specs.iter().any(|s| s.text(Name::SIZE) != specs[0].text(Name::SIZE)) {
        return Err(Error::usage("--technique", "maps of different sizes", "give all the same size="));
    }
    let context = arguments.device.open()?;
    let standing = BuiltTechniques::new(&context, &scene, &specs)?;
    let casters = Casters::new(&scene);
    let texel = match arguments.texel {
        Some(texel) => texel,
        None => telling_texel(&casters, &standing.opened, map)?,
    };
    let ray = LightRay::new(&context, &casters, &standing.opened, map, texel)?;
    let title = ray.title(&scene.name, texel);
    let svg = curve(&title, &ray, &standing.names)?;
    write_whole(&arguments.out, svg.as_bytes())?;
    check_messages()?;
    say(format!("{}: {} on {}", arguments.out.display(), title, context.features().name))?;
    if arguments.texel.is_none() {
        say(format!(
            "it has the most casters of the texels that were looked at; --texel {},{} names it",
            texel[0], texel[1]
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}
