//! A renderer of its own making that has Gobo shadow its smoke: `cargo run --release --example embed -- avsm -o smoke.png`.
//! docs/guide/embedding.md goes through it.

mod engine;

use engine::{Choice, Engine, How, Optional, Options, Result};
use gobo::technique::{avsm, beer_shadow_map, psm};
use std::process::ExitCode;

const USAGE: &str = "\
usage: embed avsm|psm|beer-shadow-map [options]
  -o FILE             the picture, a PNG (smoke.png)
  --frames N          frames before it, 60 a second (180)
  --size WIDTHxHEIGHT pixels (640x480)
  --device NAME       part of the device's name
  --answers FILE      where the last frame's particles are, and how much of the sun reaches each
  --validation        load the validation layer, and fail where it complains
  --no-interlock      switch fragment shader interlock off
  --nothing-optional  switch off all that is optional
  --no-timestamps     measure nothing";

fn main() -> ExitCode {
    match arguments().and_then(|run| render(&run)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("embed: {error}");
            ExitCode::FAILURE
        }
    }
}

struct Run {
    options: Options,
    output: String,
    answers: Option<String>,
    frames: u64,
}

fn arguments() -> Result<Run> {
    let mut words = std::env::args().skip(1);
    // What is not said here is as the program has it.
    let how = match words.next().as_deref() {
        Some("avsm") => How::Avsm(avsm::Settings { nodes: 8, size: 256, ..Default::default() }),
        Some("psm") => How::Psm(psm::Settings { size: 128, slices: 128, ..Default::default() }),
        Some("beer-shadow-map") => How::BeerShadowMap(beer_shadow_map::Settings { size: 256, ..Default::default() }),
        _ => return Err(USAGE.into()),
    };
    let choice = Choice { timestamps: true, ..Choice::default() };
    let options = Options { how, choice, size: [640, 480] };
    let mut run = Run { options, output: "smoke.png".into(), answers: None, frames: 180 };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        let options = &mut run.options;
        match &word[..] {
            "-o" => run.output = value()?,
            "--answers" => run.answers = Some(value()?),
            "--frames" => run.frames = value()?.parse::<u64>()?.max(1),
            "--size" => options.size = size(&value()?).ok_or("--size is as in 640x480")?,
            "--device" => options.choice.device = Some(value()?),
            "--validation" => options.choice.validation = true,
            "--no-interlock" => options.choice.optional = Optional::NoInterlock,
            "--nothing-optional" => options.choice.optional = Optional::Nothing,
            "--no-timestamps" => options.choice.timestamps = false,
            _ => return Err(USAGE.into()),
        }
    }
    Ok(run)
}

fn size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|side| (1..=8192).contains(side));
    Some([side(width)?, side(height)?])
}

fn render(run: &Run) -> Result<()> {
    let mut engine = Engine::open(&run.options)?;
    println!("{}", engine.gpu().name());
    let (mut times, mut recordings) = (Vec::new(), Vec::new());
    for frame in 0..run.frames {
        times.extend(engine.frame(frame as f32 / 60.0)?);
        recordings.push(engine.recording().as_secs_f64());
    }
    let [width, height] = run.options.size;
    image::save_buffer(&run.output, &engine.picture()?, width, height, image::ExtendedColorType::Rgba8)?;
    println!("{}: {width}x{height} pixels, after {} frames", run.output, run.frames);
    if let Some(file) = &run.answers {
        std::fs::write(file, answers(&mut engine)?)?;
    }
    for (i, step) in ["move and sort", "shadow", "draw"].into_iter().enumerate() {
        let mut step_times: Vec<_> = times.iter().map(|times| times[i]).collect();
        step_times.sort_by(f64::total_cmp);
        if let Some(median) = step_times.get(step_times.len() / 2) {
            println!("{step:>14} {:8.3} ms", median / 1e6);
        }
    }
    recordings.sort_by(f64::total_cmp);
    println!("the host's time for Gobo's part of a frame: {:.3} ms", recordings[recordings.len() / 2] * 1e3);
    println!("Gobo's passes, of one frame:");
    for pass in engine.passes() {
        println!("  {:>28} {:8.3} ms", pass.name, (pass.end_ns - pass.start_ns) / 1e6);
    }
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let (all, gobo) = (engine.gpu().allocated_bytes(), engine.shadows().bytes());
    println!("device memory: {:.2} MiB, of which {:.2} are Gobo's", mib(all), mib(gobo));
    println!(
        "Gobo grew after {} frames, submitted or waited {} times",
        engine.shadows().grew,
        engine.shadows().calls()
    );
    let said = engine.gpu().said();
    // Closing the device is part of the run: the layer says what was left open.
    drop(engine);
    let said = said.all();
    said.iter().for_each(|message| eprintln!("validation: {message}"));
    if said.is_empty() { Ok(()) } else { Err(format!("the validation layer said {} things", said.len()).into()) }
}

/// A line a particle: x, y, z and the share of the sun's light.
fn answers(engine: &mut Engine) -> Result<String> {
    let places: Vec<_> = engine.particles()?.iter().map(|particle| particle.position).collect();
    let answers = engine.ask(&places)?;
    Ok(places.iter().zip(answers).map(|([x, y, z], answer)| format!("{x} {y} {z} {answer}\n")).collect())
}
