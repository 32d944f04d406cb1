//! A renderer of its own making that has Gobo shadow its smoke: `cargo run --release --example embed -- avsm -o smoke.png`.
//! docs/guide/embedding.md goes through it.

mod engine;

use engine::{Choice, Engine, How, Optional, Options, Result};
use gobo::technique::{avsm, beer_shadow_map, psm};
use std::process::ExitCode;

const USAGE: &str = "\
usage: embed avsm|psm|beer-shadow-map [options]
  -o FILE             the picture, a PNG (smoke.png)
  --device-light      the device turns the sun, and the host does not know where it is
  --frames N          frames before it, 60 a second (180)
  --size WIDTHxHEIGHT pixels (640x480)
  --device NAME       part of the device's name
  --answers FILE      where the last frame's particles are, and how much of the sun reaches each
  --validation        load the validation layer, and fail where it complains
  --no-interlock      switch fragment shader interlock off
  --nothing-optional  switch off all that is optional
  --no-timestamps     measure nothing on the device
  --time              time the host alone: small maps and pictures, each frame waits for the one before";

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
    /// None: as many as it takes.
    frames: Option<u64>,
    /// Nothing but the host's time counts.
    times_host: bool,
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
    let options = Options { how, choice, device_light: false, size: [640, 480] };
    let mut run = Run { options, output: "smoke.png".into(), answers: None, frames: None, times_host: false };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        let options = &mut run.options;
        match &word[..] {
            "-o" => run.output = value()?,
            "--answers" => run.answers = Some(value()?),
            "--frames" => run.frames = Some(value()?.parse::<u64>()?.max(1)),
            "--size" => options.size = size(&value()?).ok_or("--size is as in 640x480")?,
            "--device" => options.choice.device = Some(value()?),
            "--device-light" => options.device_light = true,
            "--validation" => options.choice.validation = true,
            "--no-interlock" => options.choice.optional = Optional::NoInterlock,
            "--nothing-optional" => options.choice.optional = Optional::Nothing,
            "--time" => run.times_host = true,
            "--no-timestamps" => options.choice.timestamps = false,
            _ => return Err(USAGE.into()),
        }
    }
    if run.times_host {
        run.options.size = [16; 2];
        match &mut run.options.how {
            How::Avsm(settings) => settings.size = 16,
            How::Psm(settings) => settings.size = 16,
            How::BeerShadowMap(settings) => settings.size = 16,
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
    if run.times_host {
        return time_host(&mut engine, run.frames.unwrap_or(1000));
    }
    let (mut times, frames) = (Vec::new(), run.frames.unwrap_or(180));
    for frame in 0..frames {
        times.extend(engine.frame(frame as f32 / 60.0)?);
    }
    let [width, height] = run.options.size;
    image::save_buffer(&run.output, &engine.picture()?, width, height, image::ExtendedColorType::Rgba8)?;
    println!("{}: {width}x{height} pixels, after {frames} frames", run.output);
    if let Some(file) = &run.answers {
        std::fs::write(file, answers(&mut engine)?)?;
    }
    if run.options.device_light {
        println!("the sun shines along {:?}", engine.sun()?.direction);
    }
    for (i, step) in ["move and sort", "shadow", "draw"].into_iter().enumerate() {
        let mut step_times: Vec<_> = times.iter().map(|times| times[i]).collect();
        step_times.sort_by(f64::total_cmp);
        if let Some(median) = step_times.get(step_times.len() / 2) {
            println!("{step:>14} {:8.3} ms", median / 1e6);
        }
    }
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

/// What Gobo's part of a frame takes the host while the device does nothing.
fn time_host(engine: &mut Engine, frames: u64) -> Result<()> {
    let mut times = Vec::new();
    for frame in 0..frames {
        engine.frame(frame as f32 / 60.0)?;
        engine.wait()?;
        times.push(engine.recording().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times[(part * (times.len() - 1) as f64) as usize];
    let passes = engine.passes().len();
    println!("Gobo's part of a frame, {passes} timed passes, takes the host {:.4} ms (median of {frames})", at(0.5));
    println!("a tenth of the frames take less than {:.4} ms, a tenth more than {:.4} ms", at(0.1), at(0.9));
    Ok(())
}

/// A line per particle: x, y, z and the share of the sun's light.
fn answers(engine: &mut Engine) -> Result<String> {
    let places: Vec<_> = engine.particles()?.iter().map(|particle| particle.position).collect();
    let answers = engine.ask(&places)?;
    Ok(places.iter().zip(answers).map(|([x, y, z], answer)| format!("{x} {y} {z} {answer}\n")).collect())
}
