//! Hashes the bytes that techniques build and their answers, to compare two editions of the program. Skipped unless GOBO_HASHES names an
//! output file:
//!
//!     GOBO_HASHES=$PWD/now.tsv cargo test --release --test hashes
//!     diff results/first-edition/hashes-lavapipe-22.3.tsv now.tsv | grep '^<'
//!
//! Hashes are specific to a driver and a processor: its SIMD width affects how sums of floats are rounded.
//!
//! Prints, and writes sorted to the file that GOBO_HASHES names: scene, spec, hash of the bytes built, hash of the answers at 4,096 points
//! per light. Built bytes are hashed for AVSM, PSM and the lists, in settings of many kinds, and for the files of `gobo bake`; all other
//! techniques have a line per path, with answers only, which the first edition lacks. `-`: not hashed, or not reproducible; `refused`: the
//! device lacks what the path needs. Lines with the spec `(scene)` hash the casters and the query points instead: if these differ, all
//! other lines may differ too.
//!
//! Two other tests cover related promises: `gpu/record.rs`, which the usual loop runs, checks that two devices give the same answers on
//! every path of every technique; tests of techniques, and `gobo stress`, check that the casters' order does not matter if a technique
//! promises so.

#![cfg(feature = "program")]

mod support;

use gobo::Error;
use gobo::gpu::{Context, Messages, Options};
use gobo::maps::SegmentData;
use gobo::query::Query;
use gobo::reference::truth::space_points;
use gobo::scene::{LightKind, Scene};
use gobo::technique::{self, Avsm, Name, Opened, Psm, Spec, Technique, Uncompressed, avsm, psm};
use gobo::world::World;
use std::io::Write;
use support::{all_paths, scenes, spec};

/// 64-bit FNV-1a. Words are hashed in little-endian order.
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn words(&mut self, words: &[u32]) {
        words.iter().for_each(|word| self.bytes(&word.to_le_bytes()));
    }

    fn floats(&mut self, floats: &[f32]) {
        floats.iter().for_each(|float| self.bytes(&float.to_bits().to_le_bytes()));
    }

    fn text(&self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Number of query points per light.
const POINTS: usize = 4096;

/// Fill values that would reveal undefined bytes: each spec is built twice, over a different one.
const JUNK: [f32; 2] = [0.375, 0.75];

fn plate() -> Scene {
    let mut scene = scenes::random();
    scene.meshes.push(scenes::level(-0.2, 0.9, [0.1, 0.0]));
    scene.name = "plate".into();
    scene
}

/// Returns a scene with the only kind of light for which `ism` has maps.
fn lamp() -> Scene {
    let mut scene = plate();
    scene.lights[0].kind =
        LightKind::Virtual { position: glam::DVec3::Z * 2.5, normal: glam::DVec3::NEG_Z, nearest: 0.1 };
    scene.name = "lamp".into();
    scene
}

/// Returns scenes and the sizes of their maps: some are not multiples of the tile size; maps of point lights have a margin for the filter.
fn all_scenes() -> Vec<(Scene, u32)> {
    vec![
        (scenes::random(), 44),
        (scenes::strands(), 40),
        (scenes::locks(), 36),
        (scenes::inside(), 28),
        (scenes::four_lights(), 24),
        (scenes::opaque(), 40),
        (plate(), 44),
        (lamp(), 32),
        (Scene::load("three-emitters", 20.0).expect("built in"), 64),
        (Scene::load("lantern", 20.0).expect("built in"), 32),
    ]
}

/// Specs with the scenes that they are built for. With skip=on AVSM leaves tiles without casters unwritten.
const SPECS: &[(&str, &[&str])] = &[
    // Chosen by auto.
    ("avsm:skip=off", &["random", "strands", "lantern"]),
    ("psm:skip=off", &["random", "strands", "lantern"]),
    // AVSM, two-pass.
    ("avsm:path=two-pass,skip=off", &["random", "strands", "inside"]),
    ("avsm:path=two-pass,nodes=4,curve=linear,skip=off", &["random", "locks", "three-emitters"]),
    ("avsm:path=two-pass,nodes=16,nudge=off,storage=packed,skip=off", &["opaque", "four-lights", "lantern"]),
    ("avsm:path=two-pass,nodes=4,nudge=off,filter=box,skip=off", &["opaque", "inside", "plate"]),
    ("avsm:path=two-pass,nodes=16,curve=linear,filter=gaussian,skip=off", &["plate", "inside"]),
    ("avsm:path=two-pass,resolve=whole,skip=off", &["random", "locks", "three-emitters"]),
    (
        "avsm:path=two-pass,resolve=whole,nodes=4,curve=linear,storage=packed,skip=off",
        &["strands", "opaque", "lantern"],
    ),
    ("avsm:path=two-pass,skip=on", &["random", "plate", "lantern"]),
    // AVSM, interlock.
    ("avsm:path=interlock,skip=off", &["random", "strands", "inside"]),
    ("avsm:path=interlock,nodes=4,curve=linear,order=captured,skip=off", &["random", "locks", "opaque"]),
    ("avsm:path=interlock,nodes=16,nudge=off,storage=packed,skip=off", &["random", "four-lights", "lantern"]),
    ("avsm:path=interlock,storage=packed,skip=on", &["plate", "strands", "three-emitters"]),
    // AVSM, raster-order.
    ("avsm:path=raster-order,skip=off", &["random", "strands", "inside"]),
    ("avsm:path=raster-order,nodes=4,curve=linear,order=captured,skip=off", &["random", "locks", "opaque"]),
    ("avsm:path=raster-order,nodes=16,nudge=off,storage=packed,skip=off", &["random", "four-lights", "lantern"]),
    ("avsm:path=raster-order,storage=packed,skip=on", &["plate", "strands", "three-emitters"]),
    // AVSM, binned.
    ("avsm:path=binned,resolve=streaming,skip=off", &["random", "strands", "inside"]),
    ("avsm:path=binned,resolve=streaming,nodes=4,curve=linear,skip=off", &["opaque", "locks", "three-emitters"]),
    (
        "avsm:path=binned,resolve=streaming,nodes=16,nudge=off,storage=packed,skip=off",
        &["random", "four-lights", "lantern"],
    ),
    ("avsm:path=binned,resolve=streaming,filter=box,radius=3,skip=on", &["plate", "locks"]),
    ("avsm:path=binned,resolve=whole,skip=off", &["random", "strands"]),
    ("avsm:path=binned,resolve=cells,batch=shared,skip=off", &["random", "strands", "inside"]),
    (
        "avsm:path=binned,resolve=cells,batch=shared,nodes=4,curve=linear,storage=packed,skip=off",
        &["opaque", "locks", "three-emitters"],
    ),
    (
        "avsm:path=binned,resolve=cells,batch=shared,nodes=16,nudge=off,filter=gaussian,skip=off",
        &["four-lights", "lantern"],
    ),
    ("avsm:path=binned,resolve=cells,batch=shared,skip=on", &["plate", "three-emitters"]),
    ("avsm:path=binned,resolve=cells,batch=lanes,skip=off", &["random", "strands", "inside"]),
    (
        "avsm:path=binned,resolve=cells,batch=lanes,nodes=4,curve=linear,storage=packed,skip=off",
        &["opaque", "locks", "three-emitters"],
    ),
    ("avsm:path=binned,resolve=cells,batch=lanes,nodes=16,nudge=off,skip=off", &["four-lights", "lantern"]),
    ("avsm:path=binned,resolve=cells,batch=lanes,skip=on", &["plate", "three-emitters", "lantern"]),
    // PSM, raster.
    ("psm:path=raster,route=vertex,slices=64", &["random", "inside", "three-emitters"]),
    (
        "psm:path=raster,route=geometry,storage=rgba16f,assign=split,coverage=viewport,slices=64",
        &["random", "locks", "plate"],
    ),
    (
        "psm:path=raster,route=vertex,storage=optical-depth,assign=split,coverage=tiles,slices=256",
        &["random", "strands", "three-emitters"],
    ),
    ("psm:path=raster,route=vertex,assign=split,coverage=viewport,slices=256", &["opaque", "three-emitters"]),
    ("psm:path=raster,route=geometry,storage=rgba16f,coverage=tiles,slices=64", &["strands", "four-lights", "lantern"]),
    ("psm:path=raster,route=geometry,storage=optical-depth,filter=gaussian,slices=64", &["locks", "inside"]),
    // PSM, fused.
    ("psm:path=fused,slices=256,skip=off", &["random", "inside", "three-emitters"]),
    ("psm:path=fused,storage=rgba16f,assign=split,slices=64,skip=off", &["locks", "four-lights", "lantern"]),
    ("psm:path=fused,storage=optical-depth,assign=split,slices=256,skip=off", &["strands", "opaque"]),
    ("psm:path=fused,slices=64,skip=on", &["random", "plate", "lantern"]),
    ("psm:path=fused,storage=optical-depth,filter=box,slices=64,skip=on", &["random", "inside", "three-emitters"]),
    // The lists.
    ("uncompressed:skip=off", &["random", "strands", "inside", "three-emitters"]),
    ("uncompressed:filter=box,skip=off", &["locks", "four-lights", "plate"]),
    ("uncompressed:skip=on", &["opaque", "lantern"]),
];

/// Returns a spec for each path of each technique not listed above, and the scenes that it is built for.
fn other_specs() -> Vec<(String, &'static [&'static str])> {
    let others = all_paths().into_iter().filter(|spec| !["avsm", "psm", "uncompressed"].contains(&spec.entry.name));
    let with_scenes = |mut spec: Spec| {
        if spec.entry.keys.iter().any(|key| key.name == "filter") && spec.entry.name != "voxelized" {
            spec.set(Name::SIZE, "32");
        }
        let scenes: &[&str] = match spec.entry.name {
            "ism" => &["lamp"],
            _ if spec.entry.casts.particles => &["random", "plate"],
            _ => &["plate"],
        };
        (spec.short(), scenes)
    };
    others.map(with_scenes).collect()
}

/// Opens a technique and builds it over junk; returns the hash of the bytes built, `None` if some stay unwritten, and the hash of its
/// answers.
fn built(
    context: &Context,
    world: &World,
    spec: &Spec,
    points: &[Vec<[f32; 3]>],
    junk: f32,
) -> Result<[Option<String>; 2], Error> {
    let mut hash = Fnv::new();
    let skip = spec.skips();
    let (whole, answers) = match spec.entry.name {
        "avsm" => {
            let settings: avsm::Settings = spec.settings();
            let mut avsm = Opened::new(context, Box::new(Avsm::new(context, world, &settings)?), skip);
            let pairs = match settings.nodes {
                nodes if settings.storage == Some(avsm::Storage::Packed) => 1 + nodes / 2,
                nodes => nodes,
            };
            let size = settings.size;
            let words = world.map_count() * (size * size * pairs * 2) as usize;
            avsm.technique.curves().write(&vec![junk; words])?;
            avsm.build(world)?;
            hash.words(&avsm.technique.curves().read(words)?);
            (!skip, answers(context, avsm.technique.as_ref(), points)?)
        }
        "psm" => {
            let settings: psm::Settings = spec.settings();
            let mut psm = Opened::new(context, Box::new(Psm::new(context, world, &settings)?), skip);
            let volume = psm.technique.volume.clone();
            context.submit(|commands| commands.pass("junk", |pass| pass.clear_volume(&volume, junk)))?;
            psm.build(world)?;
            if settings.storage == psm::Storage::Rgba8 {
                hash.bytes(&volume.read::<[u8; 4]>()?.concat());
            } else {
                for texel in volume.read::<[u16; 4]>()? {
                    texel.iter().for_each(|half| hash.bytes(&half.to_le_bytes()));
                }
            }
            (true, answers(context, psm.technique.as_ref(), points)?)
        }
        "uncompressed" => {
            let technique = Box::new(Uncompressed::new(context, world, &spec.settings())?);
            let mut uncompressed = Opened::new(context, technique, skip);
            uncompressed.build(world)?;
            let list = &uncompressed.technique.list;
            let segments: Vec<SegmentData> = list.segments.read(list.fragments() as usize)?;
            for head in list.heads.read::<u32>()? {
                let follow = |index: u32| segments.get(index as usize).copied();
                let mut list: Vec<_> = std::iter::successors(follow(head), |s| follow(s.next)).collect();
                list.sort_by_key(|s| [s.entry, s.exit, s.optical_depth].map(f32::to_bits));
                for s in list {
                    hash.words(&[s.entry, s.exit, s.optical_depth].map(f32::to_bits));
                }
                hash.words(&[u32::MAX]);
            }
            (true, answers(context, uncompressed.technique.as_ref(), points)?)
        }
        _ => {
            let mut opened = technique::open(context, world, spec)?;
            opened.build(world)?;
            let file = opened.technique.inspect().file(world)?;
            file.iter().for_each(|file| hash.bytes(file));
            (file.is_some(), answers(context, opened.technique.as_ref(), points)?)
        }
    };
    Ok([whole.then(|| hash.text()), Some(answers)])
}

/// Returns the hash of the answers at the lights' points.
fn answers(context: &Context, technique: &dyn Technique, points: &[Vec<[f32; 3]>]) -> Result<String, Error> {
    let mut hash = Fnv::new();
    for (light, points) in points.iter().enumerate() {
        hash.floats(&Query::new(context, light, points)?.ask(&technique.answer())?);
    }
    Ok(hash.text())
}

/// Returns the two hashes of a spec, which is built and queried twice.
fn hashes(context: &Context, world: &World, points: &[Vec<[f32; 3]>], text: &str) -> [String; 2] {
    let [first, second] = JUNK.map(|junk| built(context, world, &spec(text), points, junk));
    match (first, second) {
        (Ok(first), Ok(second)) => {
            [0, 1].map(|i| first[i].clone().filter(|_| first[i] == second[i]).unwrap_or("-".into()))
        }
        (Err(Error::Refused(_)), _) => ["refused".into(), "refused".into()],
        (Err(error), _) | (_, Err(error)) => panic!("{} {text}: {error}", world.name()),
    }
}

#[test]
fn hashes_of_all_representations() {
    let Some(path) = std::env::var_os("GOBO_HASHES") else {
        return support::skipped("hashes_of_all_representations", "GOBO_HASHES names no file");
    };
    gobo::cli::test_hooks();
    let options = Options { device: None, validation: false, messages: Messages::default() };
    let context = Context::new(&options).expect("a Vulkan 1.3 device");
    eprintln!("{}, {}", context.features().name, context.features().driver);
    let mut lines = Vec::new();
    let others = other_specs();
    let mut line = |scene: &str, spec: &str, [built, answers]: [String; 2]| {
        let line = format!("{scene}\t{spec}\t{built}\t{answers}");
        println!("{line}");
        lines.push(line);
    };
    for (scene, size) in all_scenes() {
        let world = World::new(&context, &scene).expect("room for the scene");
        let points: Vec<_> = (0..scene.lights.len()).map(|light| space_points(&scene, light, POINTS)).collect();
        let [mut casters, mut asked] = [Fnv::new(), Fnv::new()];
        for caster in scene.casters() {
            casters.floats(&[&caster.position[..], &[caster.radius], &caster.axis, &[caster.density]].concat());
        }
        for mesh in &scene.meshes {
            casters.floats(mesh.positions.as_flattened());
            casters.words(mesh.triangles.as_flattened());
        }
        points.iter().for_each(|points| asked.floats(points.as_flattened()));
        line(&scene.name, "(scene)", [casters.text(), asked.text()]);
        for (settings, _) in SPECS.iter().filter(|(_, scenes)| scenes.contains(&scene.name.as_str())) {
            let separator = if settings.contains(':') { ',' } else { ':' };
            let text = format!("{settings}{separator}size={size}");
            line(&scene.name, &text, hashes(&context, &world, &points, &text));
        }
        for (text, _) in others.iter().filter(|(_, scenes)| scenes.contains(&scene.name.as_str())) {
            line(&scene.name, text, hashes(&context, &world, &points, text));
        }
    }
    let known = SPECS.iter().map(|(_, scenes)| scenes.len());
    let all: usize = known.chain(others.iter().map(|(_, scenes)| scenes.len())).sum();
    assert_eq!(lines.len(), all + all_scenes().len(), "a scene's name is wrong");
    lines.sort();
    let mut file = std::fs::File::create(path).expect("create the file that GOBO_HASHES names");
    lines.iter().for_each(|line| writeln!(file, "{line}").expect("write to the file that GOBO_HASHES names"));
}
