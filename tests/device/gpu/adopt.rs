//! Gobo on an adopted device: it only records, with frames in flight; it refuses features that are not enabled, and leaves nothing behind.

use crate::support::foreign::{Foreign, Wanted};
use crate::support::{ask, built, gpu_test, log, scenes, spec};
use gobo::gpu::{Buffer, Commands, Context, Enabled, Features, Memory, Messages, ReadBack};
use gobo::query::Query;
use gobo::reference::truth::space_points;
use gobo::scene::Scene;
use gobo::technique::{self, BuildStatus};
use gobo::world::World;
use gobo::{Error, Need};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// Returns the features of the device that Gobo opens by default.
fn features() -> Features {
    gobo::gpu::devices().expect("devices").into_iter().min_by_key(|d| d.kind).expect("a device")
}

/// Returns everything that the device supports.
pub fn everything() -> Enabled {
    Enabled { debug_utils: true, ..Enabled::all_of(&features()) }
}

/// Runs `body` on a foreign device, then closes it, and fails if anything is left or the layer complains.
pub fn adopted(test: &str, wanted: &Wanted, body: impl FnOnce(&mut Foreign, &Context)) {
    let messages = Messages::default();
    let mut foreign = Foreign::open(wanted);
    let context = foreign.adopt(&messages).expect("it has the floor");
    log("exercised", test, &format!("{}, {}", context.features().name, context.features().driver));
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        body(&mut foreign, &context);
        foreign.wait();
    }));
    // Waits even if the body failed, since frames in flight may still use the context's resources.
    foreign.finish();
    drop(context);
    let calls = foreign.calls();
    let said = [foreign.close(), messages.all()].concat();
    if let Err(panic) = outcome {
        said.iter().for_each(|message| eprintln!("{message}"));
        resume_unwind(panic);
    }
    assert!(said.is_empty(), "{test}: {} messages:\n{}", said.len(), said.join("\n"));
    assert!(calls.is_empty(), "{test}: Gobo called {calls:?}");
}

/// Builds `text` and queries it in each of several frames. Returns the last look-ups, the frames after which the technique grew, and the
/// bytes held after each frame.
fn in_flight(foreign: &mut Foreign, context: &Context, scene: &Scene, text: &str, points: &[[f32; 3]]) -> Answered {
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = technique::open(context, &world, &spec(text)).expect(text).technique;
    let query = Query::new(context, 0, points).expect("room for the points");
    let kernel = query.kernel(&technique.answer()).expect("compiled");
    let answers = ReadBack::new(context, "answers", 4 * points.len() as u64).expect("room");
    let frames = u64::from(context.frames_in_flight());
    let mut answered = Answered::default();
    for number in 0..4 * frames + 2 {
        let frame = foreign.begin();
        if let Some(over) = frame.checked_sub(frames) {
            let settled = technique.settle(over).expect(text);
            answered.grew.extend((settled == BuildStatus::Retry).then(|| number.saturating_sub(frames)));
            // A frame recorded before this loop has no read-back: `None`.
            answered.last = answers.read(over, points.len()).expect("they are there").unwrap_or_default();
            answered.passes = context.times(over).len();
        }
        foreign.record(context, frame, |commands| {
            technique.record(commands, &world).expect(text);
            query.record(commands, &kernel);
            commands.read_back(query.buffer(), &answers);
        });
        answered.bytes.push(context.allocated_bytes());
    }
    // Everything is dropped while frames are in flight; the resources they use stay alive.
    answered
}

#[derive(Default)]
struct Answered {
    last: Vec<f32>,
    /// Frames after which the technique grew, counted from the first.
    grew: Vec<u64>,
    /// Number of timed passes in a frame.
    passes: usize,
    bytes: Vec<u64>,
}

/// After some frames, with two or three in flight, each path returns the same look-ups as on a device of its own. Buffers that are too
/// small grow over the first frames; after that nothing grows.
#[test]
fn techniques_answer_as_on_a_device_of_their_own() {
    if crate::support::is_costly("techniques_answer_as_on_a_device_of_their_own") {
        return;
    }
    const TEST: &str = "techniques_answer_as_on_a_device_of_their_own";
    let specs = [
        "avsm:path=binned,size=64",
        "avsm:path=binned,size=64,nodes=4,skip=off",
        "psm:path=fused,slices=64,size=64",
        "beer-shadow-map:path=binned,size=64",
        "beer-shadow-map:path=raster,size=64,opaque=compute",
    ];
    // record.rs covers every path.
    let cases = [(scenes::crowd(), &specs[..], 2, true), (scenes::opaque(), &specs[..1], 3, false)];
    for (scene, specs, frames, allocator) in cases {
        let points = space_points(&scene, 0, 2000);
        let mut own = Vec::new();
        gpu_test(TEST, |context| {
            own = specs.iter().map(|text| ask(context, built(context, &scene, text).as_ref(), 0, &points)).collect();
        });
        adopted(TEST, &Wanted { enabled: everything(), frames, allocator }, |foreign, context| {
            for (text, own) in specs.iter().zip(&own) {
                let answered = in_flight(foreign, context, &scene, text, &points);
                assert!(answered.last == *own, "{}, {text}: another answer than on a device of its own", scene.name);
                println!("{}, {text}: grew after {:?}, {:?} bytes", scene.name, answered.grew, answered.bytes);
                assert!(text.contains("raster") || answered.grew.first() == Some(&0), "{text}: {:?}", answered.grew);
                let steady = &answered.bytes[answered.bytes.len() - frames as usize..];
                assert!(steady.iter().all(|bytes| *bytes == steady[0]), "{text}: {:?}", answered.bytes);
                let timed = context.features().timestamp_valid_bits > 0;
                assert_eq!(answered.passes > 0, timed, "{text}: {} passes are timed", answered.passes);
            }
        });
    }
}

/// A device with only the required features: no interlock, no timestamps, no labels. A spec that needs more is refused with the feature's
/// name.
#[test]
fn what_is_not_switched_on_is_refused() {
    const TEST: &str = "what_is_not_switched_on_is_refused";
    let scene = scenes::random();
    let points = space_points(&scene, 0, 500);
    let specs = ["avsm:size=32", "psm:path=fused,slices=64,size=32", "beer-shadow-map:size=32"];
    let mut own = Vec::new();
    gpu_test(TEST, |context| {
        // Subgroups are not enabled on that device.
        let of_binned = ["avsm:size=32,path=binned,batch=shared", specs[1], specs[2]];
        own = of_binned.map(|text| ask(context, built(context, &scene, text).as_ref(), 0, &points)).into();
    });
    adopted(TEST, &Wanted { enabled: Enabled::FLOOR, frames: 2, allocator: true }, |foreign, context| {
        let refused = [
            ("avsm:path=interlock", "fragmentStoresAndAtomics"),
            ("avsm:path=raster-order", "rasterizationOrderColorAttachmentAccess"),
            ("psm:path=raster", "shaderOutputLayer and shaderOutputViewportIndex, or geometryShader and multiViewport"),
            ("translucency-map:path=binned", "shaderStorageImageExtendedFormats"),
            ("uncompressed", "fragmentStoresAndAtomics"),
        ];
        let world = World::new(context, &scene).expect("room");
        for (text, needs) in refused {
            let result = technique::open(context, &world, &spec(text)).map(|_| ());
            assert!(matches!(&result, Err(Error::Refused(named)) if named.to_string() == needs), "{text}: {result:?}");
        }
        for (text, own) in specs.iter().zip(&own) {
            let answered = in_flight(foreign, context, &scene, text, &points);
            assert!(answered.last == *own, "{text}: another answer than on a device of its own");
            assert_eq!(answered.passes, 0, "{text}: nothing is timed");
        }
    });
    for (switched_off, name) in [
        (Enabled { synchronization2: false, ..Enabled::FLOOR }, "synchronization2"),
        (Enabled { dynamic_rendering: false, ..Enabled::FLOOR }, "dynamicRendering"),
        (Enabled { scalar_block_layout: false, ..Enabled::FLOOR }, "scalarBlockLayout"),
    ] {
        let foreign = Foreign::open(&Wanted { enabled: switched_off, frames: 1, allocator: false });
        let error = foreign.adopt(&Messages::default()).map(|_| ()).expect_err("it is below the floor").to_string();
        assert!(error.contains(name), "{error}");
        assert_eq!(foreign.close(), [""; 0]);
    }
}

/// Without a queue, calls that would wait are refused and leave nothing behind. Frame numbers must rise. Writes are ordered with the next
/// recorded pass, and images created during a recording can be used in it.
#[test]
fn an_adopted_device_is_only_recorded_for() {
    const TEST: &str = "an_adopted_device_is_only_recorded_for";
    adopted(TEST, &Wanted { enabled: everything(), frames: 2, allocator: true }, |foreign, context| {
        let refused = |result: gobo::Result<()>| {
            assert!(matches!(&result, Err(Error::Refused(Need::Queue))), "{result:?}");
        };
        let buffer = Buffer::with_data(context, "words", &[1u32; 16]).expect("64 bytes");
        refused(buffer.read::<u32>(1).map(|_| ()));
        refused(context.submit(|_| ()).map(|_| ()));
        let back = ReadBack::new(context, "back", 64).expect("64 bytes");
        assert_eq!(back.bytes(), 2 * 64);
        buffer.write(&[2u32; 4]).expect("it fits");
        let first = foreign.begin();
        foreign.record(context, first, |commands| {
            commands.pass("before", |pass| pass.fill_part(&buffer, 60, 4, 5));
            buffer.write(&[3u32; 2]).expect("it fits");
            let format = gobo::gpu::Format::R32_UINT;
            let usage = gobo::gpu::ImageUse::Storage;
            let image = gobo::gpu::Image::new(context, "inner", format, [4, 4], usage).expect("room");
            commands.pass("after", |pass| pass.clear_image(&image, 1));
            commands.read_back(&buffer, &back);
        });
        let second = foreign.begin();
        foreign.record(context, second, |_| ());
        assert!(foreign.refused(context, first).contains("frame 1 was recorded before it"));
        let third = foreign.begin();
        let expected = [3, 3, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 5];
        assert_eq!(back.read::<u32>(first, 16).expect("read"), Some(expected.to_vec()));
        assert_eq!(back.read::<u32>(second, 16).expect("read"), None);
        let names = |frame| context.times(frame).into_iter().map(|time| time.name).collect::<Vec<_>>();
        let timed: &[&str] = if context.features().timestamp_valid_bits > 0 { &["before", "after"] } else { &[] };
        assert_eq!(names(first), timed);
        // Two recordings of one frame.
        let fill = |commands: &mut Commands| commands.pass("part", |pass| pass.fill(&buffer, 7));
        foreign.record(context, third, fill);
        assert_eq!(names(first), timed, "they are kept as long as frames run");
        let held = context.allocated_bytes();
        let large = Buffer::new(context, "large", 1 << 20, Memory::Device).expect("1 MiB");
        let fourth = foreign.begin();
        foreign.record(context, fourth, |commands| commands.pass("large", |pass| pass.fill(&large, 1)));
        drop(large);
        assert!(context.allocated_bytes() >= held + (1 << 20), "the frame runs");
        for _ in 0..2 {
            let frame = foreign.begin();
            foreign.record(context, frame, |_| ());
        }
        assert!(context.allocated_bytes() <= held, "the frame is over");
    });
    gpu_test(TEST, |context| {
        let foreign = Foreign::open(&Wanted { enabled: Enabled::FLOOR, frames: 1, allocator: false });
        assert!(foreign.refused(context, 0).contains("an adopted device"));
        assert_eq!(foreign.close(), [""; 0]);
    });
}
