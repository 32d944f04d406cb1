//! What the tests on a device share: how one is opened and watched, what is skipped and how it is logged, small scenes.

// Every file in tests/ is a program of its own and uses only a part of this.
#![allow(dead_code)]

pub mod alike;
#[allow(unsafe_code)]
pub mod counted;
#[allow(unsafe_code)]
pub mod foreign;
#[allow(unsafe_code)]
pub mod messenger;
pub mod scenes;
pub mod spirv;
pub mod within;

use gobo::Error;
use gobo::bench::{Effort, Extent, Row, Status, with_case};
use gobo::gpu::{Commands, Context, Messages, Options, Requirement};
use gobo::query::{PointBatch, Query};
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::reference::twin::avsm::pack::{Packed, unpack};
use gobo::scene::{Particle, Scene, View};
use gobo::shading::parse;
use gobo::technique::{self, Avsm, Casts, Entry, Name, NodeData, Opened, REGISTRY, Spec, Technique, Values, avsm};
use gobo::world::World;
use std::io::Write;
use std::panic::{AssertUnwindSafe, Location, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Whether everything is asked for: GOBO_TEST_ALL is set and not empty. Without it the costly tests take a part of their
/// cases, so that the loop of edit and test stays short.
pub fn all() -> bool {
    std::env::var_os("GOBO_TEST_ALL").is_some_and(|asked| !asked.is_empty())
}

/// Eight draws in a row run each case once that a short run leaves out.
const DRAWS: usize = 8;

/// Whether the one of these `number`s is run: with [`all`], and where GOBO_TEST_DRAW is the number of its draw.
pub fn is_drawn(number: usize) -> bool {
    let draw = std::env::var("GOBO_TEST_DRAW").ok().filter(|text| !text.is_empty());
    let draw = draw.map(|text| text.parse().unwrap_or_else(|_| panic!("GOBO_TEST_DRAW={text} is no whole number")));
    all() || draw.is_some_and(|draw: usize| number % DRAWS == draw % DRAWS)
}

/// All of `cases` where [`all`] are asked for, else the first `few`, and what is drawn of the others.
#[track_caller]
pub fn some<T>(cases: impl IntoIterator<Item = T>, few: usize) -> Vec<T> {
    let here = Location::caller().line() as usize;
    let stays = |i: usize| i < few || is_drawn(here + i);
    cases.into_iter().enumerate().filter(|(i, _)| stays(*i)).map(|(_, case)| case).collect()
}

/// Which third of the costly cases runs. In the usual loop, on one driver, that is the first, and what takes long stands aside. With
/// GOBO_TEST_THIRD, 1 to 3, it is that one, with half of the tests that take long in each of the first two. `None` is all of it: with [`all`], with
/// GOBO_TEST_KEEP and with GOBO_TEST_VALIDATION. CI runs all on one driver, and shares the thirds out among the others.
fn third() -> Option<usize> {
    let keeps = std::env::var_os("GOBO_TEST_KEEP").is_some_and(|value| value != "0");
    let whole = keeps || std::env::var_os("GOBO_TEST_VALIDATION").is_some();
    (!all() && !whole).then(|| asked_third().unwrap_or(1))
}

/// What GOBO_TEST_THIRD says.
fn asked_third() -> Option<usize> {
    let text = std::env::var("GOBO_TEST_THIRD").ok().filter(|text| !text.is_empty())?;
    let third = text.parse().ok().filter(|third| (1..=3).contains(third));
    Some(third.unwrap_or_else(|| panic!("GOBO_TEST_THIRD={text} is none of 1 to 3")))
}

/// Whether the `i`-th case of `test` is in a third: in another one for each test.
fn is_in_third(test: &str, i: usize, third: usize) -> bool {
    (test.bytes().map(usize::from).sum::<usize>() + i + third - 1).is_multiple_of(3)
}

/// Whether a part of the costly cases runs: in the usual loop, and where [`third`] says so.
pub fn is_usual() -> bool {
    third().is_some()
}

/// Whether a test that takes long stands aside, in the usual loop or in two of the thirds; it says so. The last of these is of a driver
/// that compiles pipelines most slowly, and has none.
pub fn is_long(test: &str) -> bool {
    let half = 1 + test.bytes().map(usize::from).sum::<usize>() % 2;
    let stands_aside = is_usual() && asked_third() != Some(half);
    if stands_aside {
        skipped(test, "it takes long; GOBO_TEST_ALL, GOBO_TEST_KEEP or another GOBO_TEST_THIRD runs it");
    }
    stands_aside
}

/// What a run may ask for beyond the usual loop: each stage of CI asks for one (tests/docs/workflows.rs).
pub const ASKED: [&str; 7] = ["ALL", "DRAW", "KEEP", "THIRD", "VALIDATION", "LIMITS", "FEATURES"];

/// Whether a test that takes seconds stands aside; it says so. It does where nothing is asked for, so that the loop of edit
/// and test stays short: no variable, and no test by a part of its name.
pub fn is_costly(test: &str) -> bool {
    let is_set = |name: &str| std::env::var_os(format!("GOBO_TEST_{name}")).is_some_and(|value| !value.is_empty());
    let of_option = ["--skip", "--test-threads", "--color", "--format", "--logfile", "--shuffle-seed", "-Z"];
    let arguments: Vec<String> = std::env::args().collect();
    let is_name = |pair: &[String]| !pair[1].starts_with('-') && !of_option.contains(&pair[0].as_str());
    let names_a_test = arguments.windows(2).any(is_name);
    let stands_aside = !names_a_test && !ASKED.into_iter().any(is_set);
    if stands_aside {
        skipped(test, "it takes seconds; CI runs it, and so do GOBO_TEST_KEEP=1 and its name");
    }
    stands_aside
}

/// The first case in the usual loop; elsewhere all of them.
pub fn some_usual<T>(cases: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    cases.into_iter().take(if is_usual() { 1 } else { usize::MAX })
}

/// In the usual loop every third of the cases, others for each test; elsewhere all of them.
pub fn every_third<T>(test: &str, cases: Vec<T>) -> Vec<T> {
    let stays = |i: usize| third().is_none_or(|third| is_in_third(test, i, third));
    cases.into_iter().enumerate().filter(|(i, _)| stays(*i)).map(|(_, case)| case).collect()
}

/// Whether a test that is left out of a short run, and not drawn, stands aside; it says so.
pub fn is_left_out(test: &str) -> bool {
    let runs = is_drawn(test.bytes().map(usize::from).sum());
    if !runs {
        skipped(test, "GOBO_TEST_ALL is not set, or another GOBO_TEST_DRAW runs it");
    }
    !runs
}

/// Runs `body` on the default device under the validation layer, and fails if the layer or the allocator has said
/// anything by the time that the device is closed. Without a device or the layer that is a failure too: a suite that
/// steps aside proves nothing.
pub fn gpu_test(name: &str, body: impl FnOnce(&Context)) {
    gpu_test_needing(name, &[], body);
}

/// As [`gpu_test`], but skipped, and logged as skipped, where the device lacks one of `requirements`.
pub fn gpu_test_needing(name: &str, requirements: &[Requirement], body: impl FnOnce(&Context)) {
    let (context, messages) = KEPT.lock().expect("unharmed").pop().unwrap_or_else(|| {
        let messages = Messages::default();
        (open(&messages), messages)
    });
    let before = held(&context);
    if let Some(missing) = requirements.iter().find_map(|r| context.features().lacks(*r)) {
        skipped(name, &format!("needs {missing}"));
        if keeps_devices() {
            KEPT.lock().expect("unharmed").push((context, messages));
        }
        return;
    }
    let device = format!("{}, {}", context.features().name, context.features().driver);
    let outcome = catch_unwind(AssertUnwindSafe(|| body(&context)));
    let refusal = outcome.as_ref().err().and_then(|panic| panic.downcast_ref::<Refusal>());
    match refusal {
        Some(Refusal(reason)) => skipped(name, reason),
        None => log("exercised", name, &device),
    }
    let refused = refusal.is_some();
    if keeps_devices() && outcome.is_ok() && !context.is_lost() && held(&context) == before && messages.all().is_empty()
    {
        context.time_passes(true);
        return KEPT.lock().expect("unharmed").push((context, messages));
    }
    // Destruction is watched too: what the body made is gone, and leaks are reported as the device closes.
    drop(context);
    let said = messages.all();
    if let Err(panic) = outcome
        && !refused
    {
        said.iter().for_each(|message| eprintln!("{message}"));
        resume_unwind(panic);
    }
    assert!(said.is_empty(), "{name}: {} messages:\n{}", said.len(), said.join("\n"));
}

/// Devices that are open and that no test uses, where [`keeps_devices`].
static KEPT: Mutex<Vec<(Context, Messages)>> = Mutex::new(Vec::new());

/// Whether a test leaves its device to the next one of its program: where GOBO_TEST_KEEP says so (0 is no), or it says nothing and not
/// [`all`] cases run. A driver that compiles on the processor then makes each pipeline once per thread and not once per test. A device is kept
/// only where nothing was said about it and what it holds is what it held before; any other is closed, which is watched. Objects
/// without memory that leak are found by runs without it. A layer that checks in shaders (GOBO_TEST_VALIDATION) has threads for each
/// device, and aborts where the process ends before the device.
fn keeps_devices() -> bool {
    let keep = std::env::var_os("GOBO_TEST_KEEP").map_or(!all(), |value| value != "0");
    keep && std::env::var_os("GOBO_TEST_VALIDATION").is_none()
}

/// Bytes of the device's memory that are held when all that was recorded is over, where it is asked for.
fn held(context: &Context) -> u64 {
    if !keeps_devices() || context.is_lost() {
        return 0;
    }
    ran(context, |_| {});
    context.allocated_bytes()
}

/// Why a test ends where a lowered device refuses what it asks for.
struct Refusal(String);

/// The passes that draw opaque maps where it is not said how: software devices have a rasterizer that is faster.
pub fn opaque_passes(is_software: bool) -> &'static [&'static str] {
    if is_software { &["maps.opaque"] } else { &["maps.opaque_clear", "maps.opaque_triangles", "maps.opaque_tiles"] }
}

/// Whether the environment makes the device a lesser one, which may refuse what others have.
pub fn is_lowered() -> bool {
    ["GOBO_TEST_LIMITS", "GOBO_TEST_FEATURES"].iter().any(|name| std::env::var_os(name).is_some())
}

/// What was opened for `what`. Where the environment makes the device a lesser one (GOBO_TEST_LIMITS,
/// GOBO_TEST_FEATURES), a refusal ends the test, which is then skipped and says why; on a device as it is a refusal is
/// a failure, and a test has to know what it needs.
pub fn opened<T>(result: gobo::Result<T>, what: &str) -> T {
    match result {
        Err(Error::Refused(needs)) if is_lowered() => {
            resume_unwind(Box::new(Refusal(format!("{what}: needs {needs}"))))
        }
        result => result.unwrap_or_else(|e| panic!("{what}: {e}")),
    }
}

/// The default device with validation; `messages` outlives it.
pub fn open(messages: &Messages) -> Context {
    gobo::cli::test_hooks();
    let options = Options { device: None, validation: true, messages: messages.clone() };
    Context::new(&options).expect("a Vulkan 1.3 device and VK_LAYER_KHRONOS_validation; ./setup.sh installs both")
}

/// Records and runs commands; the frame that they were.
pub fn ran(context: &Context, record: impl FnOnce(&mut Commands)) -> u64 {
    let mut frame = 0;
    let recorded = context.submit(|commands| {
        frame = commands.frame();
        record(commands);
    });
    recorded.expect("submitted");
    frame
}

/// Says that a test stood aside, and why.
pub fn skipped(name: &str, reason: &str) {
    println!("skipped: {name}: {reason}");
    log("skipped", name, reason);
}

/// Appends a line to the file that GOBO_TEST_LOG names, from which .ci/run reports what really ran.
pub fn log(what: &str, name: &str, detail: &str) {
    let line = format!("{what}\t{name}\t{detail}\n");
    print!("{line}");
    if let Some(path) = std::env::var_os("GOBO_TEST_LOG") {
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).expect("open GOBO_TEST_LOG");
        // One write, so that lines of tests that run side by side do not mix.
        file.write_all(line.as_bytes()).expect("write to GOBO_TEST_LOG");
    }
}

/// The data beside the project's own checkout, or `None` and a line that says so.
pub fn shared_data(test: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    skipped(test, "../shared/data is absent");
    None
}

/// The one spec of a text that is no sweep.
pub fn spec(text: &str) -> Spec {
    let mut specs = parse(text).expect(text);
    assert_eq!(specs.len(), 1, "{text} is a sweep");
    specs.remove(0)
}

/// A spec for each path of each technique that shadows and that this device can run; for the others `test` says that they are
/// skipped. In the usual loop [`every_third`] of them.
pub fn every_path(test: &str, context: &Context) -> Vec<Spec> {
    // What takes one light alone, and answers with a picture, has tests of its own.
    let takes_lights = |spec: &Spec| spec.entry.name != "half-angle";
    let paths = all_paths().into_iter().filter(takes_lights).collect();
    every_third(test, paths).into_iter().filter(|spec| runs(test, context, &spec.short())).collect()
}

/// A spec for each path of each technique that shadows.
pub fn all_paths() -> Vec<Spec> {
    let shadows = REGISTRY.iter().filter(|entry| entry.casts != Casts::NONE);
    let one = |(entry, path): (&&Entry, &technique::Path)| {
        let mut spec = spec(entry.name);
        spec.set(Name::PATH, path.name);
        if entry.name == "shadow-map" {
            spec.set(Name::OPAQUE, path.name);
        }
        if entry.name == "psm" {
            // 14 maps' layers are drawn at once on every device.
            spec.set(Name::SLICES, "64");
        }
        for key in entry.keys.iter().filter(|key| ["size", "grid", "cells"].contains(&key.name)) {
            if let Values::OneOf(sizes) = &key.values {
                // The smallest of a few: a software device goes through all voxels of a grid in seconds.
                spec.set(Name::from(key), sizes[0]);
            }
        }
        spec
    };
    shadows.flat_map(|entry| entry.paths.iter().map(move |path| (entry, path))).map(one).collect()
}

/// Whether this device runs what `text` asks for; where it is refused, `test` says that it is skipped and why.
pub fn runs(test: &str, context: &Context, text: &str) -> bool {
    let particle = Particle { position: [0.0; 3], radius: 1.0, extinction: 1.0 };
    let scene = scenes::directional("one", [0.0, 0.0, -1.0], vec![particle]);
    let world = World::new(context, &scene).expect("room for one");
    match technique::open(context, &world, &spec(text)) {
        Ok(_) => true,
        Err(Error::Refused(needs)) => {
            skipped(test, &format!("{text}: needs {needs}"));
            false
        }
        Err(error) => panic!("{text}: {error}"),
    }
}

/// Those of the specs that this device runs, as [`runs`].
pub fn those_that_run<'a>(test: &str, context: &Context, specs: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    specs.into_iter().filter(|text| runs(test, context, text)).collect()
}

/// The technique of a spec, built for `scene`.
pub fn built(context: &Context, scene: &Scene, text: &str) -> Box<dyn Technique> {
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = opened(technique::open(context, &world, &spec(text)), text);
    technique.build(&world).expect(text);
    technique.technique
}

/// The volume views that the device fits to `scene`, those of the first light first: twins that are compared text by text
/// start from the same numbers.
pub fn views(context: &Context, scene: &Scene, size: u32) -> Vec<View> {
    built(context, scene, &format!("beer-shadow-map:size={size}"))
        .inspect()
        .maps()
        .iter()
        .map(|map| map.caster_view)
        .collect()
}

/// What the technique answers at `points` of one of the scene's lights.
pub fn ask(context: &Context, technique: &dyn Technique, light: usize, points: &[[f32; 3]]) -> Vec<f32> {
    let query = Query::new(context, light, points).expect("room for the points");
    query.ask(&technique.answer()).expect("answered")
}

/// What it answers at points of surfaces with these normals; one of 0 is that of a point in space.
pub fn ask_on(
    context: &Context,
    technique: &dyn Technique,
    light: usize,
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
) -> Vec<f32> {
    let is_space = |i: &usize| normals[*i] == [0.0; 3];
    let (space, surfaces): (Vec<usize>, Vec<usize>) = (0..points.len()).partition(is_space);
    let of = |all: &[[f32; 3]], which: &[usize]| which.iter().map(|i| all[*i]).collect::<Vec<_>>();
    let mut answers = vec![f32::NAN; points.len()];
    for (which, normals) in [(&space, Vec::new()), (&surfaces, of(normals, &surfaces))] {
        let asked = PointBatch { light, points: &of(points, which), normals: &normals };
        let query = Query::of_lights(context, &[asked]).expect("room for the points");
        for (i, answer) in which.iter().zip(query.ask(&technique.answer()).expect("answered")) {
            answers[*i] = answer;
        }
    }
    answers
}

/// An AVSM of `scene`, built once.
pub fn built_avsm(context: &Context, scene: &Scene, text: &str) -> Box<Avsm> {
    let world = World::new(context, scene).expect("room for the scene");
    let avsm = Box::new(opened(Avsm::new(context, &world, &spec(text).settings()), text));
    let mut opened = Opened::new(context, avsm, true);
    opened.build(&world).expect(text);
    opened.technique
}

/// The curves of the first `texels` texels as `text` stores them; the packed ones are unpacked.
pub fn nodes_of(avsm: &Avsm, text: &str, texels: usize) -> Vec<NodeData> {
    let settings: avsm::Settings = spec(text).settings();
    let count = settings.nodes as usize;
    if matches!(settings.storage, None | Some(avsm::Storage::Full)) {
        return avsm.curves().read(texels * count).expect("the nodes");
    }
    let interpolation = match settings.curve {
        avsm::Interpolated::Transmittance => Interpolation::Linear,
        avsm::Interpolated::OpticalDepth => Interpolation::Exponential,
    };
    let words: Vec<u32> = avsm.curves().read(texels * (2 + count)).expect("the words");
    let texel = |words: &[u32]| {
        let packed =
            Packed { first: f32::from_bits(words[0]), extent: f32::from_bits(words[1]), words: words[2..].to_vec() };
        unpack(&packed, interpolation)
    };
    let nodes = words.chunks_exact(2 + count).flat_map(texel);
    nodes.map(|(depth, value)| NodeData { depth, value }).collect()
}

/// Rows of these specs for a scene, quickly.
pub fn rows(context: &Context, scene: &Scene, specs: &[&str]) -> Vec<Row> {
    let effort = Effort {
        frames: 1,
        warm_up: 0,
        space_points: 6000,
        seen_points: 2048,
        lookups: 0,
        picture: [96, 64],
        turning: false,
        footprints: false,
        counts: false,
        truth: Extent::Sample,
    };
    let mut rows = Vec::new();
    with_case(context, std::slice::from_ref(scene), effort, |case| {
        rows.extend(specs.iter().map(|text| case.measure(&spec(text)).0));
        Ok(())
    })
    .expect("measured");
    rows
}

/// Beyond its resolution no leak and no false shadow, in space and on surfaces; and not because all of it is within: no more than has
/// another answer nearer than `reach`, world units in space and on surfaces, by rays, whatever the technique says of itself.
pub fn assert_right_beyond_the_resolution(scene: &Scene, row: Row, least_points: u64, reach: [f64; 2]) {
    let shares = within::shares_within(scene, reach, 1600);
    let what = format!("{}, {:?}", scene.name, row.variant);
    assert_eq!(row.status, Status::Ok, "{what}: {}", row.reason);
    let error = row.error.expect("a truth");
    for ((kind, points), share) in [("space", error.space), ("surface", error.surface)].into_iter().zip(shares) {
        let points = points.unwrap_or_else(|| panic!("{what}: no {kind} points"));
        println!("{what}: {kind} {points:?}");
        let beyond = points.beyond().unwrap_or_else(|| panic!("{what}: nothing opaque casts"));
        assert!(beyond.points > least_points, "{what}: too few {kind} points beyond the resolution");
        assert_eq!((beyond.leaks, beyond.false_shadows), (0, 0), "{what}: {kind}");
        let within = points.share_within().unwrap_or(f64::NAN);
        println!("{what}: {kind}, {within:.4} within, {share:.4} by rays");
        // Both are samples.
        assert!(within <= share + 0.02, "{what}: {within} of {kind} within, {share} by rays");
    }
}
