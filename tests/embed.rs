//! The renderer of examples/embed, which has a device of its own: Gobo answers there what the program's path answers for the same
//! particles, submits and waits for nothing, and takes no more memory as frames go by.

#![cfg(feature = "program")]

mod support;

// What the program of the example has for itself is not used here.
#[allow(dead_code)]
#[path = "../examples/embed/engine/mod.rs"]
mod engine;

use engine::{Choice, Engine, How, MOST_POINTS, Optional, Options, TO_SUN};
use gobo::gpu::Context;
use gobo::scene::{Particle, Scene};
use gobo::technique::{Avsm, BeerShadowMap, Opened, Psm, Technique, avsm, beer_shadow_map, psm};
use gobo::world::World;
use support::scenes::{self, Random};
use support::{gpu_test, log};

fn avsm() -> avsm::Settings {
    avsm::Settings { nodes: 8, size: 64, ..Default::default() }
}

fn techniques() -> [(&'static str, How); 3] {
    [
        ("avsm", How::Avsm(avsm())),
        ("psm", How::Psm(psm::Settings { size: 64, slices: 64, ..Default::default() })),
        ("beer-shadow-map", How::BeerShadowMap(beer_shadow_map::Settings { size: 64, ..Default::default() })),
    ]
}

/// The renderer on the device of `context`, with few pixels.
fn options(context: &Context, how: How, optional: Optional, timestamps: bool) -> Options {
    let device = Some(context.features().name.clone());
    Options { how, choice: Choice { device, validation: true, optional, timestamps }, size: [64, 48] }
}

/// Opens the renderer, hands it to `body` and closes it. The validation layer has to be silent to the end.
fn rendered<T>(options: &Options, what: &str, body: impl FnOnce(&mut Engine) -> engine::Result<T>) -> T {
    let mut engine = Engine::open(options).unwrap_or_else(|e| panic!("{what}: {e}"));
    let said = engine.gpu().said();
    let result = body(&mut engine).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_eq!(engine.shadows().calls(), 0, "{what}: Gobo submitted or waited");
    drop(engine);
    let said = said.all();
    assert!(said.is_empty(), "{what}: {} messages:\n{}", said.len(), said.join("\n"));
    result
}

/// In the smoke, about it and in its shadow on the ground.
fn points() -> Vec<[f32; 3]> {
    let mut random = Random::new(8);
    let place = |i| {
        let [x, y, z] = random.point(-1.0, 1.0);
        if i % 4 == 0 { [1.5 + 1.5 * x, 1.5 * y, 0.0] } else { [0.3 + 0.7 * x, 0.5 * y, 1.1 + 1.1 * z] }
    };
    (0..MOST_POINTS).map(place).collect()
}

/// What the renderer's shader is told after a few frames, and its particles then.
fn asked(options: &Options, what: &str, points: &[[f32; 3]]) -> (Vec<Particle>, Vec<f32>) {
    rendered(options, what, |engine| {
        // What grew in the first frames has room in the last.
        for frame in 0..6 {
            let times = engine.frame(3.0 + 0.0 * frame as f32)?;
            assert!(options.choice.timestamps || times.is_none(), "{what}: times without timestamps");
        }
        let has_times = options.choice.timestamps && engine.gpu().tick_ns > 0.0;
        assert_eq!(!engine.passes().is_empty(), has_times, "{what}");
        let answers = engine.ask(points)?;
        let particle =
            |p: &engine::Particle| Particle { position: p.position, radius: p.radius, extinction: p.extinction };
        Ok((engine.particles()?.iter().map(particle).collect(), answers))
    })
}

/// What the program's path answers.
fn expected(context: &Context, how: &How, particles: Vec<Particle>, points: &[[f32; 3]]) -> Vec<f32> {
    let scene: Scene = scenes::directional("embed", (-TO_SUN.as_dvec3().normalize()).to_array(), particles);
    let world = World::new(context, &scene).expect("room for the scene");
    let technique: Box<dyn Technique> = match how {
        How::Avsm(settings) => Box::new(Avsm::new(context, &world, settings).expect("avsm")),
        How::Psm(settings) => Box::new(Psm::new(context, &world, settings).expect("psm")),
        How::BeerShadowMap(settings) => Box::new(BeerShadowMap::new(context, &world, settings).expect("bsm")),
    };
    let mut opened = Opened::new(context, technique, true);
    opened.build(&world).expect("built");
    support::ask(context, opened.technique.as_ref(), 0, points)
}

/// On a device with all that Gobo has a use for, with nothing optional, and without timestamps: the same bits.
#[test]
fn the_renderer_is_told_what_the_program_says() {
    gpu_test("the_renderer_is_told_what_the_program_says", |context| {
        let (points, mut worst) = (points(), 0.0f32);
        let devices =
            [(Optional::All, true), (Optional::NoInterlock, true), (Optional::Nothing, true), (Optional::All, false)];
        for (name, how) in techniques() {
            for (optional, timestamps) in devices {
                let what = format!("{name}, {optional:?}, timestamps {timestamps}");
                let (particles, answers) = asked(&options(context, how.clone(), optional, timestamps), &what, &points);
                let program = expected(context, &how, particles, &points);
                let shadowed = answers.iter().filter(|answer| **answer < 0.5).count();
                assert!((400..3700).contains(&shadowed), "{what}: {shadowed} points are dark");
                let pairs = answers.iter().zip(&program);
                let differ = pairs.clone().filter(|(a, b)| a.to_bits() != b.to_bits()).count();
                let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                println!("{what}: {differ} differ, by {most} at most; {shadowed} dark");
                worst = worst.max(most);
            }
        }
        assert!(worst < 1e-5, "{worst}");
    });
}

/// The smoke is as it was every 80 frames, so that what has to grow has grown by frame 100.
#[test]
fn a_thousand_frames_take_no_more_memory() {
    let name = "a_thousand_frames_take_no_more_memory";
    gpu_test(name, |context| {
        let options = options(context, How::Avsm(avsm::Settings { nodes: 4, ..avsm() }), Optional::All, true);
        rendered(&options, name, |engine| {
            let mut at_100 = 0;
            for frame in 1..=1000 {
                engine.frame((frame % 80) as f32 / 10.0)?;
                if frame == 100 {
                    at_100 = engine.gpu().allocated_bytes();
                }
            }
            let (at_1000, grew) = (engine.gpu().allocated_bytes(), engine.shadows().grew);
            assert_eq!(at_100, at_1000, "bytes after 100 and 1,000 frames");
            assert!(at_100 > 0 && grew > 0, "{at_100} bytes, grew {grew} times");
            log("exercised", name, &format!("1,000 frames, {at_1000} bytes, grew after {grew}"));
            Ok(())
        });
    });
}

/// A path that the device was not opened for is refused by name, and the renderer goes on without harm.
#[test]
fn what_was_not_enabled_is_refused() {
    gpu_test("what_was_not_enabled_is_refused", |context| {
        let settings = avsm::Settings { path: Some(avsm::Way::Interlock), ..avsm() };
        let options = options(context, How::Avsm(settings), Optional::NoInterlock, true);
        let refused = Engine::open(&options).err().expect("it is refused").to_string();
        assert!(refused.contains("fragmentShaderPixelInterlock"), "{refused}");
    });
}
