//! A small renderer that uses Gobo to shadow its smoke: `cargo run --release --example engine -- avsm:nodes=8,size=256 -o smoke.png`.
//! docs/guide/embedding.md walks through it; everything that involves Gobo is in renderer/shadows.rs.

mod renderer;

use renderer::{Gpu, Instance, Options, Renderer, Result};

const USAGE: &str = "\
usage: engine TECHNIQUE [options]
  TECHNIQUE       as `gobo compare` takes it: avsm:nodes=8,size=256
  -o FILE         the picture, a PNG (smoke.png)
  --frames N      frames before it, 60 per second (180)
  --device-light  the device turns the sun, and the host does not know where it is
  --painted       Gobo's compute passes make the picture, of smoke and sky alone
  --validation    load the validation layer, which prints what it finds";

fn main() {
    let Err(error) = run() else { return };
    eprintln!("{error}");
    std::process::exit(1)
}

fn run() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let technique = gobo::technique::parse(&words.next().ok_or(USAGE)?, &[])?.remove(0);
    let mut options = Options { technique, turn_per_s: 0.0, painted: false, size: [640, 480] };
    let (mut output, mut frames, mut validation) = ("smoke.png".to_owned(), 180, false);
    while let Some(word) = words.next() {
        match &word[..] {
            "-o" => output = words.next().ok_or(USAGE)?,
            "--frames" => frames = words.next().ok_or(USAGE)?.parse()?,
            "--device-light" => options.turn_per_s = 0.4,
            "--painted" => options.painted = true,
            "--validation" => validation = true,
            _ => return Err(USAGE.into()),
        }
    }
    let gpu = Gpu::new(&Instance::new(validation)?, |all| all)?;
    let mut renderer = Renderer::new(gpu, &options)?;
    for frame in 0..frames {
        renderer.frame(frame as f32 / 60.0)?;
    }
    let [width, height] = options.size;
    image::save_buffer(&output, &renderer.picture()?, width, height, image::ExtendedColorType::Rgba8)?;
    println!("{output}: {width}x{height} pixels, after {frames} frames on {}", renderer.gpu.name);
    Ok(())
}
