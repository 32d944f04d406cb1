//! `gobo bake`

use crate::cli::{DeviceArguments, LoadArguments, check_messages, load, one_spec, say};
use crate::report::Store;
use crate::technique::{Entry, Lifetime, REGISTRY, open, usual};
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Spec of a technique that is baked once
    #[arg(long, default_value = usual::BAKED, value_name = "SPEC")]
    technique: String,
    /// The file to write, which the technique opens with file=FILE
    #[arg(short, long, default_value = "gobo-bake.gobo", value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    load: LoadArguments,
    #[command(flatten)]
    device: DeviceArguments,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let spec = one_spec(&arguments.technique)?;
    let wrong = |cause: &str, way_out: String| {
        Err(Error::usage(format!("--technique {}", arguments.technique), cause, way_out))
    };
    if spec.entry.lifetime != Lifetime::Baked {
        let is_baked = |entry: &&&Entry| entry.lifetime == Lifetime::Baked;
        let baked: Vec<_> = REGISTRY.iter().filter(is_baked).map(|entry| entry.name).collect();
        return wrong("it is built each frame", format!("name one that is baked: {}", baked.join(", ")));
    }
    let scene = load(&arguments.scene, &arguments.load)?.scene;
    // A picture of nothing is still a picture; a bake of nothing is a mistake.
    if !spec.entry.casts.are_in(scene.kinds()) {
        return Err(spec.entry.casts_from_nothing(&scene.name));
    }
    // The output path is checked before the bake, which may take minutes.
    let (store, name) = place(&arguments.out)?;
    let context = arguments.device.open()?;
    let world = World::new(&context, &scene)?;
    let mut opened = open(&context, &world, &spec)?;
    opened.build(&world)?;
    check_messages()?;
    let Some(bytes) = opened.technique.inspect().file(&world)? else {
        return wrong("it is not baked here, so that there is nothing to write", "leave file= out".into());
    };
    store.write_file(name, &bytes)?;
    say(format!("{}: {spec} on {}, {} bytes", arguments.out.display(), context.features().name, bytes.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the folder of a file, and the file's name in it.
fn place(out: &Path) -> Result<(Store, &str)> {
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Error::output(out, "it names no file"))?;
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let store = Store::open(folder)?;
    store.check(name)?;
    Ok((store, name))
}
