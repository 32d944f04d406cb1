//! Measures the renderer of examples/engine, and a frame of Gobo alone. `results/embed.sh` keeps the output.

use crate::engine::{Engine, Optional, Particle, Setup};
use crate::renderer::frames::{FRAMES_IN_FLIGHT, Frames};
use crate::renderer::memory::Set;
use crate::renderer::shadows::adopt;
use crate::renderer::{Gpu, Instance, Result};
use crate::support::counted::counted;
use crate::{TURN_PER_S, scene, setup, spec};
use ash::vk;
use gobo::gpu::Features;
use gobo::reference::truth::Casters;
use gobo::scene::{LightKind, Scene};
use gobo::technique::open;
use gobo::world::World;
use std::time::{Duration, Instant};

const TECHNIQUES: [&str; 3] = ["avsm:nodes=8,size=256", "psm:size=128,slices=128", "beer-shadow-map:size=256"];

/// Time at which all particles of `three-emitters` exist.
const SCENE_S: f64 = 20.0;

/// Number of untimed frames: lists grow during them, and a driver may defer work to them.
const WARM_UP: u32 = 100;

/// Returns the median and the 10th and 90th percentiles; `None` if there are no times.
fn parts(mut times: Vec<f64>) -> Option<[f64; 3]> {
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times.get((part * times.len().saturating_sub(1) as f64) as usize).copied();
    Some([at(0.5)?, at(0.1)?, at(0.9)?])
}

fn print(what: &str, times: Vec<f64>) {
    match parts(times) {
        Some([median, low, high]) => println!("    {what:>42} {median:9.4} {low:9.4} {high:9.4}"),
        None => println!("    {what:>42}         –         –         –"),
    }
}

/// Runs a one-time step, and prints its host time.
fn step<T>(name: &str, what: impl FnOnce() -> Result<T>) -> Result<T> {
    let start = Instant::now();
    let done = what()?;
    println!("    {name:>42} {:9.3}", start.elapsed().as_secs_f64() * 1e3);
    Ok(done)
}

/// Timestamps before and after each of a frame's three steps: moving and sorting, shadows, drawing.
struct Stamps {
    pools: Vec<vk::QueryPool>,
    tick_ns: f64,
}

impl Stamps {
    const COUNT: u32 = 4;

    /// Creates the timestamps; `None` if the queue has none.
    fn new(gpu: &mut Gpu) -> Result<Option<Self>> {
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(Self::COUNT);
        // SAFETY: the device belongs to this instance, and each handle is stored at once.
        unsafe {
            let features = Features::of(&gpu.instance.handle, gpu.physical, gpu.queue_family);
            if features.timestamp_valid_bits != 64 {
                return Ok(None);
            }
            let mut pools = Vec::new();
            for _ in 0..FRAMES_IN_FLIGHT {
                let pool = gpu.device.create_query_pool(&info, None)?;
                gpu.keep(move |device| device.destroy_query_pool(pool, None));
                pools.push(pool);
            }
            Ok(Some(Self { pools, tick_ns: features.timestamp_period_ns.into() }))
        }
    }

    fn pool(&self, frame: u64) -> vk::QueryPool {
        self.pools[frame as usize % self.pools.len()]
    }

    /// Records the time at which the device has finished everything before.
    fn stamp(&self, device: &ash::Device, commands: vk::CommandBuffer, frame: u64, index: u32) {
        // SAFETY: the frame is being recorded, outside rendering, and the frame that used the pool before is complete.
        unsafe {
            if index == 0 {
                device.cmd_reset_query_pool(commands, self.pool(frame), 0, Self::COUNT);
            }
            let all = vk::PipelineStageFlags2::ALL_COMMANDS;
            device.cmd_write_timestamp2(commands, all, self.pool(frame), index);
        }
    }

    /// Returns the time of each step of the pool's last frame, in milliseconds, once it is complete.
    fn read(&self, device: &ash::Device, frame: u64) -> Result<[f64; 3]> {
        let mut ticks = [0u64; Self::COUNT as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the frame wrote all of these timestamps.
        unsafe { device.get_query_pool_results(self.pool(frame), 0, &mut ticks, flags) }?;
        Ok([0, 1, 2].map(|i| ticks[i + 1].saturating_sub(ticks[i]) as f64 * self.tick_ns / 1e6))
    }
}

/// Measurements of some frames.
#[derive(Default)]
struct Run {
    /// Bytes of device memory after frame 100, or after half of the frames, and after the last.
    bytes: [u64; 2],
    /// Gobo's host time of each frame, in milliseconds.
    host_ms: Vec<f64>,
    /// Device time of each frame's steps, in milliseconds.
    device_ms: Vec<[f64; 3]>,
}

/// Runs frames. If each is waited for, the device is idle while the host records.
fn run(engine: &mut Engine, frames: u32, timestamps: bool, waits: bool) -> Result<Run> {
    let stamps = if timestamps { Stamps::new(&mut engine.renderer.gpu)? } else { None };
    let mut run = Run::default();
    for i in 0..frames {
        let renderer = &mut engine.renderer;
        let (device, frame, commands) = (renderer.gpu.device.clone(), renderer.frames.next, renderer.frames.begin()?);
        if let Some(stamps) = stamps.as_ref().filter(|_| i >= FRAMES_IN_FLIGHT) {
            run.device_ms.push(stamps.read(&device, frame)?);
        }
        let stamp = |index| stamps.iter().for_each(|stamps| stamps.stamp(&device, commands, frame, index));
        stamp(0);
        renderer.simulate(commands, i as f32 / 60.0);
        stamp(1);
        let start = Instant::now();
        renderer.shadow(commands)?;
        run.host_ms.push(start.elapsed().as_secs_f64() * 1e3);
        stamp(2);
        renderer.draw(commands);
        stamp(3);
        renderer.frames.submit()?;
        if waits {
            renderer.frames.wait(frame)?;
        }
        if i == (frames / 2).min(100) {
            run.bytes[0] = engine.allocated_bytes();
        }
    }
    run.bytes[1] = engine.allocated_bytes();
    Ok(run)
}

/// Returns the mean error of look-ups at the particles; the truth is computed from the particles and the sun alone.
fn mean_error(engine: &mut Engine, turns: bool) -> Result<f64> {
    let particles = engine.particles()?;
    let mut scene = scene(&particles);
    if turns {
        let direction = glam::Vec3::from(engine.sun()?.direction).as_dvec3().normalize();
        scene.lights[0].kind = LightKind::Directional { direction };
    }
    let casters = Casters::new(&scene);
    let points: Vec<_> = particles.iter().map(|particle: &Particle| particle.position).collect();
    let answers = engine.ask(&points)?;
    let off = |(point, answer): (&[f32; 3], f32)| {
        (f64::from(answer) - casters.visibility(0, glam::Vec3::from(*point).as_dvec3())).abs()
    };
    Ok(points.iter().zip(answers).map(off).sum::<f64>() / points.len() as f64)
}

/// Prints a row of the table.
fn row(name: &str, variant: &str, setup: &Setup, frames: u32) -> Result<()> {
    let mut engine = Engine::open(setup)?;
    let run = run(&mut engine, frames, setup.timestamps, false)?;
    let error = mean_error(&mut engine, setup.options.turn_per_s != 0.0)?;
    let (said, counts) = (engine.said.clone(), engine.counts.clone());
    // Closing the device is part of the run: the layer reports what was left open.
    drop(engine);
    let memory = match run.bytes {
        [before, after] if before == after => format!("flat, {after} bytes"),
        [before, after] => format!("not flat: {before} bytes, then {after}"),
    };
    let median = |times| parts(times).map_or("–".into(), |[median, ..]| format!("{median:.4}"));
    let device = median(run.device_ms.iter().map(|steps| steps[1]).collect());
    let (host, calls) = (median(run.host_ms), counts.calls().iter().map(|(_, count)| count).sum::<u64>());
    println!("| {name} | {variant} | {frames} | {calls} | {memory} | {host} | {device} | {error:.4} |");
    match said.all().is_empty() {
        true => Ok(()),
        false => Err(format!("the validation layer said: {}", said.all().join("; ")).into()),
    }
}

/// Prints a Markdown row per technique and variant: frames; how often Gobo called a function that submits or waits; whether device memory
/// was the same after the last frame as after frame 100; Gobo's median host and device times per frame; and the mean error.
#[test]
#[ignore = "measures"]
fn rows() {
    println!("\n| technique | variant | frames | calls that submit or wait | memory | host, ms | device, ms | error |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut failed = 0;
    for text in TECHNIQUES {
        let name = spec(text).entry.name;
        let plain = |optional, timestamps| {
            let mut setup = setup(text, optional, timestamps);
            (setup.validation, setup.options.size) = (false, [640, 480]);
            setup
        };
        let mut turning = plain(Optional::All, true);
        turning.options.turn_per_s = TURN_PER_S;
        let mut painted = Setup { validation: true, ..plain(Optional::All, true) };
        painted.options.painted = true;
        for (variant, setup, frames) in [
            ("validation layer", Setup { validation: true, ..plain(Optional::All, true) }, 1000),
            ("painted, validation layer", painted, 1000),
            ("", plain(Optional::All, true), 300),
            ("device light", turning, 300),
            ("no interlock", plain(Optional::NoInterlock, true), 300),
            ("nothing optional", plain(Optional::Nothing, true), 300),
            ("nothing optional, no timestamps", plain(Optional::Nothing, false), 300),
        ] {
            if let Err(error) = row(name, variant, &setup, frames) {
                println!("| {name} | {variant} | failed: {error} | | | | | |");
                failed += 1;
            }
        }
    }
    assert_eq!(failed, 0, "rows failed");
}

/// Prints the device time of each step of the renderer's frame, and Gobo's passes of one frame; then Gobo's host time with small maps and
/// pictures, where each frame waits for the one before.
#[test]
#[ignore = "measures"]
fn steps() {
    for text in TECHNIQUES {
        let mut setup = setup(text, Optional::All, true);
        (setup.validation, setup.options.size) = (false, [640, 480]);
        println!("\n{text}\n");
        let mut engine = step("the renderer with Gobo, opened, ms", || Engine::open(&setup)).expect("opened");
        let drawn = run(&mut engine, 180, true, false).expect("frames");
        for (i, what) in ["move and sort, ms", "shadows", "draw"].into_iter().enumerate() {
            print(what, drawn.device_ms.iter().map(|steps| steps[i]).collect());
        }
        let last = engine.renderer.shadows.frame - u64::from(FRAMES_IN_FLIGHT);
        for pass in engine.renderer.shadows.context.times(last) {
            println!("    {:>42} {:9.4}", pass.name, (pass.end_ns - pass.start_ns) / 1e6);
        }
        println!("    {:>42} {} bytes", "Gobo has", engine.renderer.shadows.context.allocated_bytes());
        let small = text.split([':', ',']).map(|part| if part.starts_with("size=") { "size=16" } else { part });
        let small = small.collect::<Vec<_>>().join(",").replacen(',', ":", 1);
        setup.options.technique = spec(&small);
        setup.options.size = [16; 2];
        let waited = run(&mut Engine::open(&setup).expect("opened"), 1000, false, true).expect("frames");
        print("Gobo on the host, small, waited for", waited.host_ms);
    }
}

/// Prints the times of Gobo alone for `three-emitters`: frames in which nothing else is moved, drawn or looked up, with all casters treated
/// as moved in each frame. First come one-time costs, then frames with two in flight, then frames that are waited for one by one.
#[test]
#[ignore = "measures"]
fn alone() {
    for text in [TECHNIQUES[0], TECHNIQUES[1], TECHNIQUES[2], "avsm:path=binned"] {
        frames_alone(text, 300).expect("frames");
    }
}

fn frames_alone(text: &str, frames: u32) -> Result<()> {
    let scene = Scene::load("three-emitters", SCENE_S)?;
    println!(
        "\n{text}, three-emitters, {} particles: once, ms, and a frame, median of {frames}, lowest and highest tenth\n",
        scene.particles.len()
    );
    let mut gpu = step("instance and device", || Gpu::new(&Instance::new(false)?, |all| all))?;
    // SAFETY: the handles belong together, and the instance has Vulkan 1.3.
    let (lent, counts) = unsafe { counted(&gpu.instance.entry, &gpu.instance.handle, &gpu.device, gpu.queue) };
    gpu.lent = lent;
    let (mut slots, stamps) = (Frames::new(&mut gpu)?, Stamps::new(&mut gpu)?);
    let context = step("adopt", || adopt(&gpu))?;
    let mut world = step("world", || Ok(World::new(&context, &scene)?))?;
    let mut technique = step("technique", || Ok(open(&context, &world, &spec(text))?.technique))?;
    let bindings = technique.answer().layout(0);
    let sets = (0..FRAMES_IN_FLIGHT).map(|_| Set::new(&mut gpu, &bindings)).collect::<Result<Vec<_>>>()?;
    // Returns the host's time to record and to submit a frame, and the device time in milliseconds of the frame before the last.
    let mut frame = || -> Result<([Duration; 2], Option<f64>)> {
        let (frame, commands) = (slots.next, slots.begin()?);
        let over = stamps.as_ref().filter(|_| frame >= FRAMES_IN_FLIGHT.into());
        let device_ms = over.map(|stamps| stamps.read(&gpu.device, frame)).transpose()?.map(|steps| steps[1]);
        let stamp = |index| stamps.iter().for_each(|stamps| stamps.stamp(&gpu.device, commands, frame, index));
        (0..2).for_each(stamp);
        let start = Instant::now();
        technique.settle(frame.saturating_sub(FRAMES_IN_FLIGHT.into()))?;
        world.casters_move()?;
        technique.forget();
        // SAFETY: as in `Shadows::record`.
        let mut recorded = unsafe { gobo::gpu::Commands::on(&context, commands, frame) }?;
        technique.record(&mut recorded, &world)?;
        recorded.end();
        // SAFETY: the set has these bindings, and the frame that used it is complete.
        unsafe { technique.answer().write_into(sets[frame as usize % sets.len()].handle, 0) };
        let recording = start.elapsed();
        (2..4).for_each(stamp);
        let start = Instant::now();
        slots.submit()?;
        Ok(([recording, start.elapsed()], device_ms))
    };
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let idle = |gpu: &Gpu| {
        // SAFETY: nothing else uses the device.
        unsafe { gpu.device.device_wait_idle() }
    };
    for _ in 0..WARM_UP {
        frame()?;
    }
    idle(&gpu)?;
    let start = Instant::now();
    let times = (0..frames).map(|_| frame()).collect::<Result<Vec<_>>>()?;
    idle(&gpu)?;
    let wall_ms = ms(start.elapsed()) / f64::from(frames);
    let mut waited = Vec::new();
    for _ in 0..frames {
        let start = Instant::now();
        frame()?;
        idle(&gpu)?;
        waited.push(ms(start.elapsed()));
    }
    print("Gobo on the host", times.iter().map(|([recording, _], _)| ms(*recording)).collect());
    print("the renderer's submission", times.iter().map(|([_, submission], _)| ms(*submission)).collect());
    print("Gobo on the device", times.iter().filter_map(|(_, device_ms)| *device_ms).collect());
    println!("    {:>42} {wall_ms:9.4}", "frame to frame, two in flight, mean");
    print("record, submit and wait, one after the other", waited);
    println!("Gobo called {:?} of what submits or waits", counts.calls());
    drop((technique, world, context));
    Ok(())
}
