//! `gobo slice`

use super::{DeviceArguments, MapArguments, TimeArgument, check_messages, load, one_spec, write_png};
use crate::consume::slice;
use crate::technique::open;
use crate::world::World;
use crate::{Error, Result};
use clap::Args;
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, Rgba, RgbaImage};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A frame of an animation, milliseconds.
const FRAME_MS: u32 = 80;

#[derive(Args)]
pub struct Arguments {
    /// Scene file, data file or built-in scene
    scene: String,
    /// Technique spec
    #[arg(long, default_value = "avsm", value_name = "SPEC")]
    technique: String,
    #[command(flatten)]
    map: MapArguments,
    /// Depth in the light's range: 0 nearest to the light, 1 farthest
    #[arg(long, default_value_t = 1.0)]
    depth: f32,
    /// Instead of one depth, this many from 0 to 1: FILE-00.png, FILE-01.png, … and an animated FILE.gif
    #[arg(long, conflicts_with = "depth", value_parser = clap::value_parser!(u32).range(2..=1000))]
    frames: Option<u32>,
    /// Pixels a side
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// The PNG to write
    #[arg(short, long, default_value = "gobo-slice.png")]
    out: PathBuf,
    #[command(flatten)]
    time: TimeArgument,
    #[command(flatten)]
    device: DeviceArguments,
}

/// Grey: linear visibility, shown as sRGB.
fn gray(visibility: &[f32], size: [u32; 2]) -> Vec<u8> {
    let pixels = visibility.iter().map(|v| [*v; 3]).collect();
    crate::scene::Picture { width: size[0], height: size[1], pixels }.to_srgb8()
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    if !(0.0..=1.0).contains(&arguments.depth) {
        let name = format!("--depth {}", arguments.depth);
        return Err(Error::input(name, "outside the light's range", "give a number from 0 to 1"));
    }
    let scene = load(&arguments.scene, &arguments.time)?;
    let map = arguments.map.of(&scene)?;
    let spec = one_spec(&arguments.technique)?;
    let context = arguments.device.open()?;
    let world = World::new(&context, &scene)?;
    let mut opened = open(&context, &world, &spec)?;
    opened.build(&world)?;
    let technique = &opened.technique;
    let Some(view) = technique.maps().get(map).map(|m| m.volume) else {
        return Err(Error::input("--technique", "it has no maps", "name one that has, such as avsm"));
    };
    let size = [arguments.size; 2];
    let at = |depth: f32| -> Result<Vec<u8>> {
        Ok(gray(&slice(&context, arguments.map.light, &view, &technique.answer(), depth, size)?, size))
    };
    match arguments.frames {
        None => write_png(&arguments.out, size, &at(arguments.depth)?)?,
        Some(frames) => {
            let mut pictures = Vec::new();
            for frame in 0..frames {
                let picture = at(frame as f32 / (frames - 1) as f32)?;
                write_png(&numbered(&arguments.out, frame, frames), size, &picture)?;
                pictures.push(picture);
            }
            write_gif(&arguments.out.with_extension("gif"), size, &pictures)?;
        }
    }
    check_messages(&context)?;
    println!("{}: {spec} on {}, path {}", arguments.out.display(), context.features().name, technique.facts()?.path);
    Ok(ExitCode::SUCCESS)
}

/// FILE-07.png, with as many digits as the last needs.
fn numbered(path: &Path, frame: u32, frames: u32) -> PathBuf {
    let digits = (frames - 1).to_string().len();
    let stem = path.file_stem().map_or_else(|| "gobo-slice".into(), |s| s.to_string_lossy());
    path.with_file_name(format!("{stem}-{frame:0digits$}.png"))
}

fn write_gif(path: &Path, size: [u32; 2], pictures: &[Vec<u8>]) -> Result<()> {
    let fail = |e: &dyn std::fmt::Display| Error::output(path, e);
    let file = std::fs::File::create(path).map_err(|e| fail(&e))?;
    let mut encoder = GifEncoder::new_with_speed(std::io::BufWriter::new(file), 10);
    encoder.set_repeat(Repeat::Infinite).map_err(|e| fail(&e))?;
    for picture in pictures {
        let mut image = RgbaImage::new(size[0], size[1]);
        for (pixel, rgb) in image.pixels_mut().zip(picture.chunks_exact(3)) {
            *pixel = Rgba([rgb[0], rgb[1], rgb[2], 255]);
        }
        let delay = Delay::from_numer_denom_ms(FRAME_MS, 1);
        encoder.encode_frame(Frame::from_parts(image, 0, 0, delay)).map_err(|e| fail(&e))?;
    }
    Ok(())
}
