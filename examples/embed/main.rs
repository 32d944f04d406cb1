//! A renderer of its own making that has Gobo shadow its smoke: `cargo run --release --example embed -- avsm -o smoke.png`.
//! docs/guide/embedding.md goes through it.

mod engine;
mod time;

use engine::{Choice, Engine, How, Optional, Options, PARTICLES, Result};
use glam::DVec3;
use gobo::reference::truth::Casters;
use gobo::scene::{Camera, Light, LightKind, Particle, Scene};
use gobo::technique::{avsm, beer_shadow_map, parse, psm};
use std::process::ExitCode;

const USAGE: &str = "\
usage: embed avsm|psm|beer-shadow-map [options]
usage: embed avsm:nodes=8,path=binned [options]   as the program has what is not said
  -o FILE             the picture, a PNG (smoke.png)
  --device-light      the device turns the sun, and the host does not know where it is
  --painted           Gobo's compute passes make the picture, of smoke and sky alone
  --frames N          frames before it, 60 a second (180)
  --size WIDTHxHEIGHT pixels (640x480)
  --device NAME       part of the device's name
  --answers FILE      where the last frame's particles are, and how much of the sun reaches each
  --truth             how far these answers are from the truth
  --validation        load the validation layer, and fail where it complains
  --no-interlock      switch fragment shader interlock off
  --nothing-optional  switch off all that is optional
  --no-timestamps     measure nothing on the device
  --time              time the host alone: small maps and pictures, each frame waits for the one before
  --scene NAME        with --time: shadows alone of a scene of the program's, in maps as large as they are
  --row NAME          a row of the table of results/embed.sh";

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
    truth: bool,
    /// None: as many as it takes.
    frames: Option<u64>,
    /// Nothing but the host's time counts.
    times_host: bool,
    scene: Option<String>,
    row: Option<String>,
}

fn arguments() -> Result<Run> {
    let mut words = std::env::args().skip(1);
    let how = how(&words.next().ok_or(USAGE)?)?;
    let choice = Choice { timestamps: true, ..Choice::default() };
    let options = Options { how, choice, device_light: false, painted: false, size: [640, 480] };
    let mut run = Run {
        options,
        output: "smoke.png".into(),
        answers: None,
        truth: false,
        frames: None,
        times_host: false,
        scene: None,
        row: None,
    };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        let options = &mut run.options;
        match &word[..] {
            "-o" => run.output = value()?,
            "--answers" => run.answers = Some(value()?),
            "--truth" => run.truth = true,
            "--frames" => run.frames = Some(value()?.parse::<u64>()?.max(1)),
            "--size" => options.size = size(&value()?).ok_or("--size is as in 640x480")?,
            "--device" => options.choice.device = Some(value()?),
            "--device-light" => options.device_light = true,
            "--painted" => options.painted = true,
            "--validation" => options.choice.validation = true,
            "--no-interlock" => options.choice.optional = Optional::NoInterlock,
            "--nothing-optional" => options.choice.optional = Optional::Nothing,
            "--time" => run.times_host = true,
            "--scene" => run.scene = Some(value()?),
            "--row" => run.row = Some(value()?),
            "--no-timestamps" => options.choice.timestamps = false,
            _ => return Err(USAGE.into()),
        }
    }
    if run.scene.is_some() && !run.times_host {
        return Err("--scene is for --time: pictures are of the renderer's own particles".into());
    }
    if run.times_host && run.scene.is_none() {
        run.options.size = [16; 2];
        match &mut run.options.how {
            How::Avsm(settings) => settings.size = 16,
            How::Psm(settings) => settings.size = 16,
            How::BeerShadowMap(settings) => settings.size = 16,
        }
    }
    Ok(run)
}

/// What is not said here is as the program has it.
fn how(text: &str) -> Result<How> {
    match text {
        "avsm" => return Ok(How::Avsm(avsm::Settings { nodes: 8, size: 256, ..Default::default() })),
        "psm" => return Ok(How::Psm(psm::Settings { size: 128, slices: 128, ..Default::default() })),
        "beer-shadow-map" => {
            return Ok(How::BeerShadowMap(beer_shadow_map::Settings { size: 256, ..Default::default() }));
        }
        _ => {}
    }
    match &parse(text, &[])?[..] {
        [spec] if spec.entry.name == "avsm" => Ok(How::Avsm(spec.settings())),
        [spec] if spec.entry.name == "psm" => Ok(How::Psm(spec.settings())),
        [spec] if spec.entry.name == "beer-shadow-map" => Ok(How::BeerShadowMap(spec.settings())),
        _ => Err(USAGE.into()),
    }
}

fn size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|side| (1..=8192).contains(side));
    Some([side(width)?, side(height)?])
}

fn render(run: &Run) -> Result<()> {
    if let Some(name) = &run.scene {
        return time::scene(&run.options, name, run.frames.unwrap_or(300));
    }
    let mut engine = Engine::open(&run.options)?;
    println!("{}", engine.gpu().name());
    let frames = run.frames.unwrap_or(if run.times_host { 1000 } else { 180 });
    let mut row = Row { frames, ..Row::default() };
    if run.times_host {
        row.host_ms = time::particles(&mut engine, frames)?;
    } else {
        draw(run, &mut engine, &mut row)?;
    }
    let calls = engine.gpu().counted.1.calls();
    row.calls = calls.iter().map(|(_, count)| count).sum();
    println!("Gobo grew after {} frames, and called of what submits or waits: {calls:?}", engine.shadows().grew);
    let said = engine.gpu().said();
    // Closing the device is part of the run: the layer says what was left open.
    drop(engine);
    let said = said.all();
    said.iter().for_each(|message| eprintln!("validation: {message}"));
    if let Some(name) = &run.row {
        println!("{}", row.line(name));
    }
    if said.is_empty() { Ok(()) } else { Err(format!("the validation layer said {} things", said.len()).into()) }
}

/// Draws frames, and tells of the last.
fn draw(run: &Run, engine: &mut Engine, row: &mut Row) -> Result<()> {
    let mut times = Vec::new();
    for frame in 0..row.frames {
        times.extend(engine.frame(frame as f32 / 60.0)?);
        row.host_ms.push(engine.recording().as_secs_f64() * 1e3);
        if frame == (row.frames / 2).min(100) {
            row.bytes[0] = engine.gpu().allocated_bytes();
        }
    }
    row.bytes[1] = engine.gpu().allocated_bytes();
    let [width, height] = run.options.size;
    image::save_buffer(&run.output, &engine.picture()?, width, height, image::ExtendedColorType::Rgba8)?;
    println!("{}: {width}x{height} pixels, after {} frames", run.output, row.frames);
    if let Some(file) = &run.answers {
        let lines = answers(engine)?.into_iter().map(|([x, y, z], answer)| format!("{x} {y} {z} {answer}\n"));
        std::fs::write(file, lines.collect::<String>())?;
    }
    if run.options.device_light {
        println!("the sun shines along {:?}", engine.sun()?.direction);
    }
    if run.truth {
        let error = mean_error(engine)?;
        println!("answers at the particles are {error:.5} from the truth, the mean of all");
        row.error = Some(error);
    }
    for (i, step) in ["move and sort", "shadow", "draw"].into_iter().enumerate() {
        let median_ms = time::parts(times.iter().map(|times| times[i] / 1e6).collect()).map(|[median, ..]| median);
        if let Some(median_ms) = median_ms {
            println!("{step:>14} {median_ms:8.3} ms");
        }
        if i == 1 {
            row.device_ms = median_ms;
        }
    }
    println!("Gobo's passes, of one frame:");
    for pass in engine.passes() {
        println!("  {:>28} {:8.3} ms", pass.name, (pass.end_ns - pass.start_ns) / 1e6);
    }
    if let Some([median_ms, ..]) = time::parts(row.host_ms.clone()) {
        println!("Gobo's part of a frame on the host {median_ms:.4} ms");
    }
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let (all, gobo) = (engine.gpu().allocated_bytes(), engine.shadows().bytes());
    println!("device memory: {:.2} MiB, of which {:.2} are Gobo's", mib(all), mib(gobo));
    Ok(())
}

/// What a run came to.
#[derive(Default)]
struct Row {
    frames: u64,
    calls: u64,
    /// The device's memory, after frame 100, or half of all, and after the last.
    bytes: [u64; 2],
    /// Gobo's part of each frame on the host.
    host_ms: Vec<f64>,
    /// Likewise on the device, the median.
    device_ms: Option<f64>,
    error: Option<f64>,
}

impl Row {
    fn line(&self, name: &str) -> String {
        let number = |number: Option<f64>| number.map_or("–".into(), |number| format!("{number:.4}"));
        let [before, after] = self.bytes;
        let memory = match self.bytes {
            [0, 0] => "–".into(),
            _ if before == after => format!("flat, {after} bytes"),
            _ => format!("not flat: {before} bytes, then {after}"),
        };
        let host_ms = time::parts(self.host_ms.clone()).map(|[median, ..]| median);
        let numbers = [host_ms, self.device_ms, self.error].map(number).join(" | ");
        format!("| {name} | {} | {} | {memory} | {numbers} |", self.frames, self.calls)
    }
}

/// Where the particles are, and the share of the sun's light that reaches each.
fn answers(engine: &mut Engine) -> Result<Vec<([f32; 3], f32)>> {
    let places: Vec<_> = engine.particles()?.iter().map(|particle| particle.position).collect();
    let answers = engine.ask(&places)?;
    Ok(places.into_iter().zip(answers).collect())
}

/// How far the answers are from the truth, which knows of the particles and the sun alone.
fn mean_error(engine: &mut Engine) -> Result<f64> {
    let particles = engine.particles()?.into_iter();
    let particles = particles.map(|p| Particle { position: p.position, radius: p.radius, extinction: p.extinction });
    let direction = match engine.turns_sun() {
        true => DVec3::from(glam::Vec3::from(engine.sun()?.direction)).normalize(),
        false => -engine::TO_SUN.as_dvec3().normalize(),
    };
    let scene = Scene {
        name: "embed".into(),
        particles: particles.collect(),
        lights: vec![Light { kind: LightKind::Directional { direction }, radiance: [1.0; 3], radius: f64::INFINITY }],
        camera: Camera { position: DVec3::NEG_Y, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
        ..Scene::default()
    };
    let casters = Casters::new(&scene);
    let off = |(place, answer): ([f32; 3], f32)| {
        (f64::from(answer) - casters.visibility(0, glam::Vec3::from(place).as_dvec3())).abs()
    };
    Ok(answers(engine)?.into_iter().map(off).sum::<f64>() / f64::from(PARTICLES))
}
