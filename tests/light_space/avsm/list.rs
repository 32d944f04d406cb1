//! The per-texel lists lose no fragment; if they must, they report it.

use crate::support::{ask, built_avsm, gpu_test, opaque_passes, opened, runs, scenes, spec, views};
use crate::twin::{Twins, look_up};
use gobo::gpu::Context;
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::scene::{Particle, Scene};
use gobo::technique::{self, Avsm, NodeData, Opened, Technique};
use gobo::world::World;

/// Texels per side.
const SIZE: u32 = 8;

/// Returns the counters of a build of `text`.
fn counters(context: &Context, scene: &Scene, text: &str) -> (u64, u64, String) {
    let facts = built_avsm(context, scene, text).inspect().facts().expect("counted");
    (facts.counters["fragments"], facts.counters["overflowed"], facts.reason)
}

/// A list that starts too small grows until it holds everything: its nodes equal those of a list that was large enough from the start.
#[test]
fn growing_loses_nothing() {
    gpu_test("growing_loses_nothing", |context| {
        let scene = scenes::crowd();
        let twins = Twins::new(&scene, views(context, &scene, SIZE)[0]);
        let (fragments, overflowed, reason) = counters(context, &scene, "avsm:path=two-pass,size=8");
        assert_eq!(overflowed, 0, "{reason}");
        assert!(!reason.contains("overflowed"), "{reason}");
        let first_capacity = 16 * u64::from(SIZE * SIZE);
        assert!(fragments > 2 * first_capacity, "{fragments} fragments do not make the list grow");
        let (expected, grazing) = (twins.fragments(), twins.grazing());
        println!("{fragments} fragments, the twin has {expected}, {grazing} graze");
        assert!(fragments.abs_diff(expected) <= grazing, "{fragments}, the twin has {expected}, {grazing} graze");

        let grown = built_avsm(context, &scene, "avsm:path=two-pass,size=8");
        let roomy = built_avsm(context, &scene, "avsm:path=two-pass,size=8,capacity=1000000");
        let read = |avsm: &Avsm| avsm.curves().read::<u32>(8 * 8 * 8 * 2).expect("the nodes");
        assert!(read(&grown) == read(&roomy), "the grown list lost or doubled something");
    });
}

/// The device counts as many fragments as the twin in every scene: one per texel whose ray meets a particle.
#[test]
fn fragments_are_counted_exactly() {
    gpu_test("fragments_are_counted_exactly", |context| {
        let fixed = [scenes::random(), scenes::duplicates(), scenes::nested(), scenes::opaque(), scenes::strands()];
        let spot = [[2.0, 1.0, 3.0], [0.3, 0.2, 0.9]];
        let spot = spot.iter().flat_map(|p| [scenes::random(), scenes::locks()].map(|s| scenes::spot(*p, 70.0, s)));
        let spot: Vec<_> = spot.collect();
        for scene in fixed.iter().chain(&spot) {
            let twins = Twins::new(scene, views(context, scene, 24)[0]);
            let (fragments, _, _) = counters(context, scene, "avsm:path=two-pass,size=24");
            let (expected, grazing) = (twins.fragments(), twins.grazing());
            println!("{}: {fragments} fragments, the twin has {expected}, {grazing} graze", scene.name);
            assert!(fragments.abs_diff(expected) <= grazing, "{}: {fragments} not {expected}", scene.name);
        }
    });
}

/// A fixed capacity loses exactly what does not fit, and the row reports how much.
#[test]
fn a_fixed_capacity_says_what_it_lost() {
    gpu_test("a_fixed_capacity_says_what_it_lost", |context| {
        let scene = scenes::crowd();
        let (fragments, _, _) = counters(context, &scene, "avsm:path=two-pass,size=8");
        let tails = |capacity: u64| -> Vec<f32> {
            let avsm = built_avsm(context, &scene, &format!("avsm:path=two-pass,size=8,capacity={capacity}"));
            let nodes: Vec<NodeData> = avsm.curves().read(8 * 8 * 8).expect("the nodes");
            nodes.chunks_exact(8).map(|texel| look_up(texel, 2.0, Interpolation::Exponential)).collect()
        };
        let whole = tails(fragments + 1);
        assert_eq!(tails(fragments), whole, "a list that just fits holds all");
        // The last segment to arrive is missing, so its texel is brighter.
        let brighter = tails(fragments - 1).iter().zip(&whole).filter(|(t, w)| **t > **w * 1.0001).count();
        assert_eq!(brighter, 1, "one segment less makes one texel brighter");
        for (capacity, lost) in
            [(100, fragments - 100), (fragments - 1, 1), (fragments, 0), (fragments + 1, 0), (1, fragments - 1)]
        {
            let text = format!("avsm:path=two-pass,size=8,capacity={capacity}");
            let (demand, overflowed, reason) = counters(context, &scene, &text);
            assert_eq!((demand, overflowed), (fragments, lost), "{text}");
            assert_eq!(reason.contains(&format!("overflowed: {lost}")), lost > 0, "{text}: {reason}");
            assert_eq!(reason.contains("overflowed"), lost > 0, "{text}: {reason}");
        }
    });
}

/// One texel has more fragments than some drivers' limit on loop iterations (docs/reference/drivers.md). Either all fragments count, or the
/// row is refused with the reason; none is dropped silently. 1,000 fragments work on every driver.
#[test]
fn long_lists_are_whole_or_refused() {
    gpu_test("long_lists_are_whole_or_refused", |context| {
        // The second number is the distance, along x and y, between the column's axis and the nearest texel's ray.
        let paths = [
            ("avsm:path=two-pass,size=1", 0.0f32),
            ("avsm:path=binned,resolve=streaming,size=1", 0.0),
            ("avsm:path=binned,resolve=cells,size=1", 0.0),
            ("psm:path=fused,size=8,slices=16", 0.125),
        ];
        for (count, (text, aside)) in [1_000, 20_000].into_iter().flat_map(|count| paths.map(|path| (count, path))) {
            if !runs("long_lists_are_whole_or_refused", context, text) {
                continue;
            }
            let extinction = 0.5 / count as f32;
            let sphere = |i| Particle { position: [0.0, 0.0, i as f32 / count as f32], radius: 1.0, extinction };
            let mut scene = scenes::directional("column", [0.0, 0.0, -1.0], (0..count).map(sphere).collect());
            // Transparent sphere that extends the map's range to the point where the tail is queried.
            scene.particles.push(Particle { position: [0.0, 0.0, -4.0], radius: 1.0, extinction: 0.0 });
            let world = World::new(context, &scene).expect("room");
            let mut built = technique::open(context, &world, &spec(text)).expect("opens");
            match built.build(&world) {
                Ok(_) => {
                    let tail = ask(context, built.technique.as_ref(), 0, &[[0.0, 0.0, -4.0]])[0];
                    let half_chord = (1.0 - 2.0 * aside * aside).sqrt();
                    // Half of an 8-bit step, plus the rounding of thousands of float additions.
                    assert!((tail - (-half_chord).exp()).abs() < 4e-3, "{text}, {count}: {tail}");
                }
                Err(gobo::Error::Refused(needs)) => {
                    println!("{text}, {count}: {needs}");
                    assert!(
                        count > 1_000 && needs.to_string().contains("rounds of a shader's loops"),
                        "{text}, {count}: {needs}"
                    );
                }
                Err(error) => panic!("{text}, {count}: {error}"),
            }
        }
    });
}

/// An empty scene is valid: no fragments, no covered texels, no error.
#[test]
fn nothing_casts_nothing() {
    gpu_test("nothing_casts_nothing", |context| {
        let mut scene = scenes::directional("empty", [0.0, 0.3, -1.0], Vec::new());
        scene.meshes.push(scenes::level(0.0, 1.0, [0.0, 0.0]));
        let world = World::new(context, &scene).expect("room for nothing");
        let text = "avsm:path=two-pass,size=8,skip=off";
        let avsm = opened(Avsm::new(context, &world, &spec(text).settings()), text);
        let mut avsm = Opened::new(context, Box::new(avsm), false);
        let passes = avsm.build(&world).expect("builds").passes;
        let counters = avsm.technique.inspect().facts().expect("counted").counters;
        assert_eq!((counters["fragments"], counters["overflowed"], counters["covered_texels"]), (0, 0, 0));
        let names: Vec<_> = passes.iter().map(|p| p.name.as_str()).collect();
        if context.features().timestamp_valid_bits > 0 {
            let before = ["maps.aim", "maps.bounds", "maps.fit"];
            let behind = ["list.clear", "list.capture", "avsm.resolve"];
            let opaque = opaque_passes(context.features().is_software());
            assert_eq!(names, [&before[..], opaque, &behind].concat());
        }
    });
}
