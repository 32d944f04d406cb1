//! What Gobo takes of a frame, on the host and on the device, and what its steps take that come once.

use crate::engine::alone::{Alone, Times};
use crate::engine::{Engine, Options, Result, Steps};
use gobo::scene::Scene;
use std::time::Instant;

/// By then all particles of `three-emitters` are there.
const SCENE_S: f64 = 20.0;

/// Frames that are not timed: lists grow in them, and a driver may put work off to them.
const WARM_UP: u64 = 100;

/// The middle one, and those that a tenth is less than and more than; none of nothing.
pub fn parts(mut times: Vec<f64>) -> Option<[f64; 3]> {
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times.get((part * times.len().saturating_sub(1) as f64) as usize).copied();
    Some([at(0.5)?, at(0.1)?, at(0.9)?])
}

fn print(what: &str, times: Vec<f64>) {
    match parts(times) {
        Some([median, low, high]) => println!("{what:>42} {median:9.4} {low:9.4} {high:9.4}"),
        None => println!("{what:>42}         –         –         –"),
    }
}

fn print_steps(steps: &Steps) {
    println!("once, ms:");
    for (step, time) in steps {
        println!("{step:>42} {:9.3}", time.as_secs_f64() * 1e3);
    }
}

/// Times the renderer's particles, in small maps: while the host records, the device does nothing. Returns the host's time, milliseconds.
pub fn particles(engine: &mut Engine, frames: u64) -> Result<Vec<f64>> {
    print_steps(engine.steps());
    let mut times = Vec::new();
    for frame in 0..frames {
        engine.frame(frame as f32 / 60.0)?;
        engine.wait()?;
        times.push(engine.recording().as_secs_f64() * 1e3);
    }
    println!(
        "a frame with {} timed passes of Gobo's, ms: median of {frames}, lowest and highest tenth",
        engine.passes().len()
    );
    print("Gobo on the host", times.clone());
    Ok(times)
}

/// Measures a scene of the program's, with two frames in flight, and one after the other as where each is waited for.
pub fn scene(options: &Options, name: &str, frames: u64) -> Result<()> {
    let scene = Scene::load(name, SCENE_S)?;
    let mut alone = Alone::open(&options.how, &options.choice, &scene)?;
    println!("{}: {name}, {} particles", alone.gpu().name(), scene.particles.len());
    print_steps(alone.steps());
    for _ in 0..WARM_UP {
        alone.frame()?;
    }
    alone.wait()?;
    println!("a frame, ms: median of {frames}, lowest and highest tenth");
    let start = Instant::now();
    let times = (0..frames).map(|_| alone.frame()).collect::<Result<Vec<_>>>()?;
    alone.wait()?;
    let wall_ms = start.elapsed().as_secs_f64() * 1e3 / frames as f64;
    let of = |part: fn(&Times) -> f64| times.iter().map(part).collect::<Vec<_>>();
    print("Gobo on the host", of(|times| times.recording_ms));
    print("the renderer's submission", of(|times| times.submission_ms));
    print("Gobo on the device", times.iter().filter_map(|times| times.device_ms).collect());
    println!("{:>42} {wall_ms:9.4}", "frame to frame, two in flight, mean");
    let mut waited = Vec::new();
    for _ in 0..frames {
        let start = Instant::now();
        alone.frame()?;
        alone.wait()?;
        waited.push(start.elapsed().as_secs_f64() * 1e3);
    }
    print("record, submit and wait, one after the other", waited);
    println!("Gobo called of what submits or waits: {:?}", alone.gpu().counted.1.calls());
    Ok(())
}
