//! `gobo curve`

use super::{DeviceArguments, LoadArguments, MapArguments, check_messages, load_whole, say};
use crate::consume::Query;
use crate::reference::truth::Casters;
use crate::report::{Line, Points, curve, write_whole};
use crate::technique::keys::SIZE;
use crate::technique::{open, parse};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use glam::DVec2;
use std::path::PathBuf;
use std::process::ExitCode;

/// Points that a line is drawn through.
const SAMPLES: u32 = 1024;

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
    #[arg(long = "technique", value_name = "SPEC", default_value = "avsm:nodes=8,curve=linear|exponential")]
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
    let scene = load_whole(&arguments.scene, &arguments.load)?;
    let (light, map) = (arguments.map.light, arguments.map.of(&scene)?);
    let mut specs = Vec::new();
    for text in &arguments.techniques {
        specs.extend(parse(text)?);
    }
    let size = specs.first().map_or(0, |s| s.number(SIZE.name));
    let [x, y] = arguments.texel;
    let name = format!("--texel {x},{y}");
    if specs.iter().any(|s| s.number(SIZE.name) != size) {
        return Err(Error::input("--technique", "maps of different sizes", "give all the same size="));
    }
    if x >= size || y >= size {
        return Err(Error::input(name, format!("outside the map of {size} texels a side"), "choose one inside"));
    }
    let context = arguments.device.open()?;
    let world = World::new(&context, &scene)?;
    let mut opened = specs.iter().map(|spec| open(&context, &world, spec)).collect::<Result<Vec<_>>>()?;
    // All stand in the same maps.
    let Some(view) = opened.first().and_then(|o| o.technique.maps().get(map)).map(|m| m.volume) else {
        return Err(Error::input("--technique", "it has no maps", "name one that has, such as avsm"));
    };
    let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    if scene.first_map(light) + scene.lights[light].map_at(ray.at(view.z(1.0)).as_vec3().into()) != map {
        return Err(Error::input(name, "in the margin of the face, which another face is asked for", "go further in"));
    }
    let casters = Casters::new(&scene);
    let (true_curve, segments) = casters.true_curve(map, &view, &ray);
    if segments == 0 {
        return Err(Error::input(name, "nothing translucent covers it", "choose another (`gobo slice` shows the map)"));
    }
    let depths: Vec<f64> = (0..=SAMPLES).map(|i| f64::from(i) / f64::from(SAMPLES)).collect();
    let truth: Points = depths.iter().map(|d| (*d, true_curve.transmittance(*d))).collect();
    let positions: Vec<[f32; 3]> = depths.iter().map(|d| ray.at(view.z(*d)).as_vec3().into()).collect();

    let query = Query::new(&context, light, &positions)?;
    let mut lines = Vec::new();
    for (spec, opened) in specs.iter().zip(&mut opened) {
        opened.build(&world)?;
        let technique = &opened.technique;
        let answers = query.ask(&technique.answer())?;
        lines.push(Line {
            name: format!("{} ({})", spec.short(), technique.facts()?.path),
            points: depths.iter().copied().zip(answers.into_iter().map(f64::from)).collect(),
            nodes: technique.nodes(map, [x, y])?,
        });
    }
    let title = format!("{}, texel {x},{y}: {segments} segments", scene.name);
    let svg = curve(&title, &truth, &lines)?;
    write_whole(&arguments.out, svg.as_bytes())?;
    check_messages()?;
    say(format!("{}: {} on {}", arguments.out.display(), title, context.features().name))?;
    Ok(ExitCode::SUCCESS)
}
