//! Shared helpers for the tests on a device: opening and watching it, skipping and logging tests, small scenes.

// Every file in tests/ is its own program and uses only part of this.
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

/// Returns whether to run everything: GOBO_TEST_ALL is set and not empty. Otherwise costly tests run only some of their cases, which keeps
/// the edit-test loop short.
pub fn all() -> bool {
    std::env::var_os("GOBO_TEST_ALL").is_some_and(|asked| !asked.is_empty())
}

/// Number of consecutive values of GOBO_TEST_DRAW that together run every case left out of a short run once.
const DRAWS: usize = 8;

/// Returns the value of GOBO_TEST_DRAW.
fn draw() -> Option<usize> {
    let text = std::env::var("GOBO_TEST_DRAW").ok().filter(|text| !text.is_empty())?;
    Some(text.parse().unwrap_or_else(|_| panic!("GOBO_TEST_DRAW={text} is no whole number")))
}

/// Returns whether to run the case of this `number`: with [`all`], or if GOBO_TEST_DRAW draws it.
pub fn is_drawn(number: usize) -> bool {
    all() || draw().is_some_and(|draw| number % DRAWS == draw % DRAWS)
}

/// Returns all `cases` with [`all`], otherwise the first `few` and those of the rest that are drawn.
#[track_caller]
pub fn some<T>(cases: impl IntoIterator<Item = T>, few: usize) -> Vec<T> {
    let here = Location::caller().line() as usize;
    let stays = |i: usize| i < few || is_drawn(here + i);
    cases.into_iter().enumerate().filter(|(i, _)| stays(*i)).map(|(_, case)| case).collect()
}

/// Returns which third of the costly cases to run. The usual loop, on one driver, runs the first third and skips the long tests.
/// GOBO_TEST_THIRD (1 to 3) selects a third; the first two each run half of the long tests as well. Returns `None`, for all cases, with
/// [`all`], GOBO_TEST_KEEP or GOBO_TEST_VALIDATION. CI runs all cases on one driver and distributes the thirds among the others.
fn third() -> Option<usize> {
    let whole = is_kept() || std::env::var_os("GOBO_TEST_VALIDATION").is_some();
    (!all() && !whole).then(|| asked_third().unwrap_or(1))
}

/// Returns whether GOBO_TEST_KEEP asks for all cases, on devices that are kept.
fn is_kept() -> bool {
    std::env::var_os("GOBO_TEST_KEEP").is_some_and(|value| value != "0")
}

/// Returns the value of GOBO_TEST_THIRD.
fn asked_third() -> Option<usize> {
    let text = std::env::var("GOBO_TEST_THIRD").ok().filter(|text| !text.is_empty())?;
    let third = text.parse().ok().filter(|third| (1..=3).contains(third));
    Some(third.unwrap_or_else(|| panic!("GOBO_TEST_THIRD={text} is none of 1 to 3")))
}

/// Returns whether the `i`-th case of `test` belongs to a third; each test starts at a different case.
fn is_in_third(test: &str, i: usize, third: usize) -> bool {
    (test.bytes().map(usize::from).sum::<usize>() + i + third - 1).is_multiple_of(3)
}

/// Returns whether only some of the costly cases run: in the usual loop, or if [`third`] selects a part.
pub fn is_usual() -> bool {
    third().is_some()
}

/// Returns whether a long test is skipped, and logs it: in the usual loop, or in two of the thirds. The last third runs no long tests,
/// because its driver compiles pipelines slowest.
pub fn is_long(test: &str) -> bool {
    let half = 1 + test.bytes().map(usize::from).sum::<usize>() % 2;
    let stands_aside = is_usual() && asked_third() != Some(half);
    if stands_aside {
        skipped(test, "it takes long; GOBO_TEST_ALL, GOBO_TEST_KEEP or another GOBO_TEST_THIRD runs it");
    }
    stands_aside
}

/// Suffixes of the GOBO_TEST_ variables that request more than the usual loop: each stage of CI sets one (tests/docs/workflows.rs).
pub const ASKED: [&str; 7] = ["ALL", "DRAW", "KEEP", "THIRD", "VALIDATION", "LIMITS", "FEATURES"];

/// Returns whether a test that takes seconds is skipped, and logs it. To keep the edit-test loop short, it is skipped unless one of these
/// variables is set or the command line names a test. With GOBO_TEST_DRAW alone, every other one of these tests runs, and in the last third
/// none, because its driver compiles pipelines slowest.
pub fn is_costly(test: &str) -> bool {
    let is_set = |name: &str| std::env::var_os(format!("GOBO_TEST_{name}")).is_some_and(|value| !value.is_empty());
    let of_option = ["--skip", "--test-threads", "--color", "--format", "--logfile", "--shuffle-seed", "-Z"];
    let arguments: Vec<String> = std::env::args().collect();
    let is_name = |pair: &[String]| !pair[1].starts_with('-') && !of_option.contains(&pair[0].as_str());
    let names_a_test = arguments.windows(2).any(is_name);
    if names_a_test {
        return false;
    }
    let is_of_next_draw = |draw: usize| test.bytes().map(usize::from).sum::<usize>() % 2 != draw % 2;
    let is_half = !all() && !is_kept() && asked_third().is_none();
    if is_half && draw().is_some_and(is_of_next_draw) {
        skipped(test, "it takes seconds; the next GOBO_TEST_DRAW runs it, and so do GOBO_TEST_KEEP=1 and its name");
        return true;
    }
    let stands_aside = asked_third() == Some(3) || !ASKED.into_iter().any(is_set);
    if stands_aside {
        skipped(test, "it takes seconds; CI runs it, and so do GOBO_TEST_KEEP=1 and its name");
    }
    stands_aside
}

/// Returns the first case in the usual loop, otherwise all of them.
pub fn some_usual<T>(cases: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    cases.into_iter().take(if is_usual() { 1 } else { usize::MAX })
}

/// Returns every third case in the usual loop, offset differently per test, otherwise all of them.
pub fn every_third<T>(test: &str, cases: Vec<T>) -> Vec<T> {
    let stays = |i: usize| third().is_none_or(|third| is_in_third(test, i, third));
    cases.into_iter().enumerate().filter(|(i, _)| stays(*i)).map(|(_, case)| case).collect()
}

/// Returns whether a test that short runs leave out, and that is not drawn, is skipped; logs it.
pub fn is_left_out(test: &str) -> bool {
    let runs = is_drawn(test.bytes().map(usize::from).sum());
    if !runs {
        skipped(test, "GOBO_TEST_ALL is not set, or another GOBO_TEST_DRAW runs it");
    }
    !runs
}

/// Runs `body` on the default device under the validation layer. Fails if the layer or the allocator has reported anything by the time the
/// device is closed. A missing device or layer is a failure too: a suite that skips itself proves nothing.
pub fn gpu_test(name: &str, body: impl FnOnce(&Context)) {
    gpu_test_needing(name, &[], body);
}

/// Same as [`gpu_test`], but skips the test, and logs that, if the device lacks one of `requirements`.
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
    // Destruction is watched too: everything that the body created is gone, and closing the device reports leaks.
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

/// Open devices that no test is using, if [`keeps_devices`].
static KEPT: Mutex<Vec<(Context, Messages)>> = Mutex::new(Vec::new());

/// Returns whether a test leaves its device to the next test of the program: if GOBO_TEST_KEEP says so (0 is no), or by default without
/// [`all`]. A driver that compiles on the CPU then creates each pipeline once per thread instead of once per test. A device is kept only if
/// nothing was reported about it and it holds no more memory than before; any other is closed, under observation. Leaked objects without
/// memory are found by runs that keep no devices. A layer that checks inside shaders (GOBO_TEST_VALIDATION) runs threads for each device,
/// and aborts if the process ends before the device is closed.
fn keeps_devices() -> bool {
    let keep = std::env::var_os("GOBO_TEST_KEEP").map_or(!all(), |value| value != "0");
    keep && std::env::var_os("GOBO_TEST_VALIDATION").is_none()
}

/// Returns the bytes of device memory still held after all recorded work has finished, or 0 if devices are not kept.
fn held(context: &Context) -> u64 {
    if !keeps_devices() || context.is_lost() {
        return 0;
    }
    ran(context, |_| {});
    context.allocated_bytes()
}

/// Why a test ends early: a lowered device refused what it needs.
struct Refusal(String);

/// Returns the passes that draw opaque maps by default: software devices rasterize them, because that is faster there.
pub fn opaque_passes(is_software: bool) -> &'static [&'static str] {
    if is_software { &["maps.opaque"] } else { &["maps.opaque_clear", "maps.opaque_triangles", "maps.opaque_tiles"] }
}

/// Returns whether the environment lowers the device's limits or features, so that it may refuse what others accept.
pub fn is_lowered() -> bool {
    ["GOBO_TEST_LIMITS", "GOBO_TEST_FEATURES"].iter().any(|name| std::env::var_os(name).is_some())
}

/// Unwraps what was opened for `what`. On a device lowered by the environment (GOBO_TEST_LIMITS, GOBO_TEST_FEATURES), a refusal ends the
/// test, which is then logged as skipped with the reason; on a real device a refusal is a failure, because each test must state its
/// requirements.
pub fn opened<T>(result: gobo::Result<T>, what: &str) -> T {
    match result {
        Err(Error::Refused(needs)) if is_lowered() => {
            resume_unwind(Box::new(Refusal(format!("{what}: needs {needs}"))))
        }
        result => result.unwrap_or_else(|e| panic!("{what}: {e}")),
    }
}

/// Opens the default device with validation; `messages` outlives it.
pub fn open(messages: &Messages) -> Context {
    gobo::cli::test_hooks();
    let options = Options { device: None, validation: true, messages: messages.clone() };
    Context::new(&options).expect("a Vulkan 1.3 device and VK_LAYER_KHRONOS_validation; ./setup.sh installs both")
}

/// Records and runs commands, and returns their frame number.
pub fn ran(context: &Context, record: impl FnOnce(&mut Commands)) -> u64 {
    let mut frame = 0;
    let recorded = context.submit(|commands| {
        frame = commands.frame();
        record(commands);
    });
    recorded.expect("submitted");
    frame
}

/// Logs that a test was skipped, and why.
pub fn skipped(name: &str, reason: &str) {
    println!("skipped: {name}: {reason}");
    log("skipped", name, reason);
}

/// Appends a line to the file named by GOBO_TEST_LOG, from which .ci/run reports what really ran.
pub fn log(what: &str, name: &str, detail: &str) {
    let line = format!("{what}\t{name}\t{detail}\n");
    print!("{line}");
    if let Some(path) = std::env::var_os("GOBO_TEST_LOG") {
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).expect("open GOBO_TEST_LOG");
        // One write, so that lines of parallel tests do not mix.
        file.write_all(line.as_bytes()).expect("write to GOBO_TEST_LOG");
    }
}

/// Returns the data folder beside the project's checkout, or `None` after logging that the test is skipped.
pub fn shared_data(test: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    skipped(test, "../shared/data is absent");
    None
}

/// Parses a text that is a single spec, not a sweep.
pub fn spec(text: &str) -> Spec {
    let mut specs = parse(text).expect(text);
    assert_eq!(specs.len(), 1, "{text} is a sweep");
    specs.remove(0)
}

/// Returns a spec for each path of each shadow technique that this device can run; logs `test` as skipped for the others. The usual loop
/// gets [`every_third`] of them.
pub fn every_path(test: &str, context: &Context) -> Vec<Spec> {
    // half-angle takes a single light and yields a picture; it has its own tests.
    let takes_lights = |spec: &Spec| spec.entry.name != "half-angle";
    let paths = all_paths().into_iter().filter(takes_lights).collect();
    every_third(test, paths).into_iter().filter(|spec| runs(test, context, &spec.short())).collect()
}

/// Returns a spec for each path of each shadow technique.
pub fn all_paths() -> Vec<Spec> {
    let shadows = REGISTRY.iter().filter(|entry| entry.casts != Casts::NONE);
    let one = |(entry, path): (&&Entry, &technique::Path)| {
        let mut spec = spec(entry.name);
        spec.set(Name::PATH, path.name);
        if entry.name == "shadow-map" {
            spec.set(Name::OPAQUE, path.name);
        }
        if entry.name == "psm" {
            // With 64 slices, every device can draw the layers of 14 maps at once.
            spec.set(Name::SLICES, "64");
        }
        for key in entry.keys.iter().filter(|key| ["size", "grid", "cells"].contains(&key.name)) {
            if let Values::OneOf(sizes) = &key.values {
                // The smallest of the few sizes: a software device takes seconds for all voxels of a larger grid.
                spec.set(Name::from(key), sizes[0]);
            }
        }
        spec
    };
    shadows.flat_map(|entry| entry.paths.iter().map(move |path| (entry, path))).map(one).collect()
}

/// Returns whether this device runs `text`; if it is refused, logs `test` as skipped with the reason.
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

/// Returns the specs that this device runs, as [`runs`] decides.
pub fn those_that_run<'a>(test: &str, context: &Context, specs: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    specs.into_iter().filter(|text| runs(test, context, text)).collect()
}

/// Returns the technique of a spec, built for `scene`.
pub fn built(context: &Context, scene: &Scene, text: &str) -> Box<dyn Technique> {
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = opened(technique::open(context, &world, &spec(text)), text);
    technique.build(&world).expect(text);
    technique.technique
}

/// Returns the volume views that the device fits to `scene`, the first light's first, so that twins compared bit by bit start from the same
/// numbers.
pub fn views(context: &Context, scene: &Scene, size: u32) -> Vec<View> {
    built(context, scene, &format!("beer-shadow-map:size={size}"))
        .inspect()
        .maps()
        .iter()
        .map(|map| map.caster_view)
        .collect()
}

/// Returns the technique's look-ups at `points` for one of the scene's lights.
pub fn ask(context: &Context, technique: &dyn Technique, light: usize, points: &[[f32; 3]]) -> Vec<f32> {
    let query = Query::new(context, light, points).expect("room for the points");
    query.ask(&technique.answer()).expect("answered")
}

/// Returns the technique's look-ups at surface points with these normals; a zero normal marks a point in space.
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

/// Builds an AVSM of `scene` once.
pub fn built_avsm(context: &Context, scene: &Scene, text: &str) -> Box<Avsm> {
    let world = World::new(context, scene).expect("room for the scene");
    let avsm = Box::new(opened(Avsm::new(context, &world, &spec(text).settings()), text));
    let mut opened = Opened::new(context, avsm, true);
    opened.build(&world).expect(text);
    opened.technique
}

/// Returns the curves of the first `texels` texels as `text` stores them, unpacked if packed.
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

/// Measures these specs for a scene with little effort.
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

/// Asserts that there are no leaks and no false shadows beyond the technique's resolution, in space and on surfaces. The technique must not
/// get away with calling every point "within": the share within may not exceed the share of points for which shadow rays give another
/// result nearer than `reach` (world units, in space and on surfaces), whatever resolution the technique claims.
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
        // Both shares are estimated from samples.
        assert!(within <= share + 0.02, "{what}: {within} of {kind} within, {share} by rays");
    }
}
