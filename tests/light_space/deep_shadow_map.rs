//! Deep shadow maps: within their error bound of the exact curve, at its points and between them; equal to their CPU twin; no nodes in
//! empty texels; budgets that are kept.

use crate::support::{ask, built, gpu_test, runs, scenes, some, spec};
use crate::twin;
use gobo::Error;
use gobo::bench::point_error;
use gobo::reference::truth::{Casters, map_truths};
use gobo::reference::twin::deep_shadow_map::{Removal, nodes, transmittance};
use gobo::reference::twin::segment::Segment;
use gobo::scene::{Scene, View};
use gobo::technique::{Facts, Technique, open};
use gobo::world::World;
use proptest::prelude::*;
use twin::{DEPTH_ROUNDING, Order, Twins};

const PATHS: [&str; 2] = ["two-pass", "binned"];

const REMOVALS: [Removal; 2] = [Removal::Bound, Removal::Area];

/// Error bound of a look-up in f32, from rounding alone.
const ROUNDING: f64 = 2e-5;

/// Quantization step of depths stored as integers.
const STEP: f64 = 1.0 / 16_777_216.0;

/// Returns the optical depth in front of `depth`, summed over all segments.
fn truth(segments: &[Segment], depth: f64) -> f64 {
    let taken = |s: &Segment| {
        let [entry, exit] = [s.entry, s.exit].map(f64::from);
        let share = if depth >= exit { 1.0 } else { ((depth - entry) / (exit - entry)).max(0.0) };
        f64::from(s.optical_depth) * share
    };
    (-segments.iter().map(taken).sum::<f64>()).exp()
}

/// Asserts that the nodes' curve deviates nowhere by more than `error` from the segments' curve; a depth may be rounded to a neighbour.
fn assert_within(segments: &[Segment], error: f32) {
    let found = nodes(segments, Removal::Bound, error);
    assert!(found.windows(2).all(|n| n[0].0 <= n[1].0 && n[0].1 <= n[1].1), "{segments:?}: {found:?}");
    let mut ends: Vec<f64> = segments.iter().flat_map(|s| [s.entry, s.exit]).map(f64::from).collect();
    ends.extend(found.iter().map(|node| f64::from(node.0)));
    ends.extend([0.0, 1.0]);
    ends.sort_by(f64::total_cmp);
    let between =
        |pair: &[f64]| (0..=24).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 24.0).collect::<Vec<_>>();
    for depth in ends.windows(2).flat_map(between) {
        let answer = f64::from(transmittance(&found, depth as f32));
        let [most, least] = [-2.0, 2.0].map(|by| truth(segments, depth + by * STEP));
        let margin = f64::from(error) + ROUNDING;
        let off = (answer - most).max(least - answer);
        assert!(off <= margin, "{off} at {depth}, of {error}: {segments:?}: {found:?}");
    }
    let tail = truth(segments, 2.0);
    assert!((f64::from(transmittance(&found, 2.0)) - tail).abs() <= 1e-4 + ROUNDING, "{segments:?}: {found:?}");
}

/// Generates segments: long, short, steps, thin or opaque, many at the same depth.
fn segment() -> impl Strategy<Value = Segment> {
    let depth = prop_oneof![3 => 0f32..1.0, 1 => (0u32..8).prop_map(|i| i as f32 / 8.0)];
    let length = prop_oneof![
        2 => 0f32..1.0,
        2 => 0f32..0.05,
        1 => (-24f32..-10.0).prop_map(f32::exp2),
        2 => Just(0.0),
    ];
    let takes = prop_oneof![4 => 0f32..0.3, 2 => 0f32..3.0, 1 => 0f32..80.0, 1 => Just(0.0), 1 => (-30f32..0.0).prop_map(f32::exp2)];
    (depth, length, takes).prop_map(|(entry, length, optical_depth)| Segment {
        entry,
        exit: (entry + length).min(1.0),
        optical_depth,
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(600) })]

    /// Lokovic and Veach bound the error only at points of the curve; here the bound also holds between them.
    #[test]
    fn curves_are_within_their_error(
        segments in prop::collection::vec(segment(), 1..40),
        error in prop_oneof![Just(1e-4f32), Just(0.01), Just(0.5), 1e-4f32..0.2],
    ) {
        assert_within(&segments, error);
    }
}

/// The error bound holds in the worst case for curves that are linear in optical depth between exact nodes, a long ramp from clear to dark,
/// and for thousands of overlapping segments.
#[test]
fn long_rises_and_crowds_are_within_their_error() {
    let one = |entry, exit, optical_depth| Segment { entry, exit, optical_depth };
    let thin = |count: u32| {
        let each = move |i| one(0.2 + i as f32 * 1e-7, 0.6 + i as f32 * 2e-7, 3.0 / count as f32);
        (0..count).map(each).collect::<Vec<_>>()
    };
    for error in [1e-4, 0.003, 0.01, 0.05, 0.5] {
        for takes in [0.01, 1.0, 4.0, 16.0, 80.0] {
            assert_within(&[one(0.1, 0.9, takes)], error);
            assert_within(&[one(0.1, 0.9, takes), one(0.5, 0.5, 0.3), one(0.3, 0.4, 2.0)], error);
        }
        assert_within(&[one(0.0, 1.0, 1e-9)], error);
    }
    // Every depth is evaluated against every segment, so a short run tries only the tightest bound and one that drops most nodes.
    for error in some([1e-4, 0.05, 0.003, 0.01, 0.5], 2) {
        assert_within(&thin(if crate::support::all() { 5000 } else { 2000 }), error);
    }
    // A line needs two nodes, a step one, an empty curve none.
    for removal in REMOVALS {
        assert_eq!(nodes(&[one(0.1, 0.9, 1.0)], removal, 0.01).len(), 2);
        assert_eq!(nodes(&[one(0.5, 0.5, 1.0)], removal, 0.01), [(0.5, 1.0)]);
        assert!(nodes(&[], removal, 0.01).is_empty() && nodes(&[one(0.1, 0.9, 0.0)], removal, 0.01).is_empty());
    }
}

/// Removal by area bounds the error at no single depth, but its mean over all depths is within the bound, and the tail is exact.
#[test]
fn curves_by_area_are_near_in_the_mean() {
    let mut random = scenes::Random::new(3);
    for (error, count) in [0.0025, 0.01, 0.04].into_iter().flat_map(|error| [1, 5, 60, 800].map(|count| (error, count)))
    {
        let segments: Vec<Segment> = (0..count)
            .map(|i| {
                let entry = random.between(0.1, 0.8);
                let exit = if i % 4 == 0 { entry } else { entry + random.between(0.0, 0.1) };
                Segment { entry, exit, optical_depth: random.between(0.0, 6.0 / count as f32) }
            })
            .collect();
        let found = nodes(&segments, Removal::Area, error);
        assert!(found.windows(2).all(|n| n[0].0 <= n[1].0 && n[0].1 <= n[1].1), "{found:?}");
        let depths = (0..4000).map(|i| (f64::from(i) + 0.5) / 4000.0);
        let off = |depth| (f64::from(transmittance(&found, depth as f32)) - truth(&segments, depth)).abs();
        let mean = depths.map(off).sum::<f64>() / 4000.0;
        let whole = nodes(&segments, Removal::Bound, error).len();
        println!("{error}, {count} segments: {} nodes, {whole} within it; mean {mean:.5}", found.len());
        assert!(
            mean <= f64::from(error) / 2.0 && found.len() <= 2 * count && off(2.0) < 1e-5,
            "{error}, {count}: {mean}"
        );
    }
}

/// The order of segments does not matter.
#[test]
fn twins_know_no_order() {
    let mut random = scenes::Random::new(7);
    let mut segments: Vec<Segment> = (0..300)
        .map(|i| {
            let entry = random.between(0.0, 0.8);
            let exit = if i % 5 == 0 { entry } else { entry + random.between(0.0, 0.2) };
            Segment { entry, exit, optical_depth: random.between(0.0, 0.1) }
        })
        .collect();
    let first = REMOVALS.map(|removal| nodes(&segments, removal, 0.01));
    for _ in 0..5 {
        segments.rotate_left(41);
        segments.reverse();
        assert_eq!(REMOVALS.map(|removal| nodes(&segments, removal, 0.01)), first);
    }
}

fn cases() -> Vec<(Scene, u32)> {
    let all = [
        (scenes::random(), 20),
        (scenes::opaque(), 20),
        (scenes::strands(), 24),
        (scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::locks()), 20),
        (scenes::duplicates(), 20),
        (scenes::nested(), 20),
        (scenes::crowd(), 8),
        (scenes::four_lights(), 12),
    ];
    some(all, 4)
}

fn facts(technique: &dyn Technique) -> Facts {
    technique.inspect().facts().expect("counted")
}

/// Nodes equal the twin's where rounding decides nothing; elsewhere both are within the error of the same curve.
#[test]
fn nodes_are_the_twins() {
    const TEST: &str = "nodes_are_the_twins";
    gpu_test(TEST, |context| {
        for (scene, size) in cases() {
            let ways = REMOVALS.into_iter().zip(["bound", "area"]);
            for (path, (removal, word)) in ways.flat_map(|way| PATHS.map(|path| (path, way))) {
                let text = format!("deep-shadow-map:error=100,size={size},path={path},removal={word}");
                if !runs(TEST, context, &text) {
                    continue;
                }
                let technique = built(context, &scene, &text);
                let views: Vec<View> = technique.inspect().maps().iter().map(|map| map.caster_view).collect();
                let (mut all, mut alike, mut covered, mut counted) = (0u64, 0u64, 0u64, 0u64);
                for (map, view) in views.iter().enumerate() {
                    let twins = Twins::new(&scene, *view);
                    // Each texel is read back separately.
                    let is_small = view.texels() <= 64;
                    let texels =
                        (0..view.texels() as u32).step_by(if crate::support::all() || is_small { 1 } else { 3 });
                    for texel in texels.filter(|texel| twins.grazed(*texel) == 0) {
                        let found =
                            technique.inspect().nodes(map, [texel % view.width, texel / view.width]).expect("nodes");
                        let segments = twins.texel(texel, Order::Entry).segments;
                        let expected = nodes(&segments, removal, 0.01);
                        assert_eq!(found.is_empty(), expected.is_empty(), "{} {text}, texel {texel}", scene.name);
                        covered += u64::from(!found.is_empty());
                        counted += found.len() as u64;
                        all += 1;
                        let is_near = |(found, expected): (&(f64, f64), &(f32, f32))| {
                            (found.0 - f64::from(expected.0)).abs() < f64::from(10.0 * DEPTH_ROUNDING)
                                && (found.1 - f64::from((-expected.1).exp())).abs() < 1e-3
                        };
                        alike += u64::from(found.len() == expected.len() && found.iter().zip(&expected).all(is_near));
                    }
                }
                println!("{} {text}: {alike} of {all} alike, {covered} covered, {counted} nodes", scene.name);
                assert!(alike * 20 >= all * 19 && covered > 20, "{} {text}: {alike} of {all}", scene.name);
            }
        }
    });
}

/// Look-ups on the device, under any light, against exact curves in f64.
#[test]
fn answers_are_within_their_error() {
    const TEST: &str = "answers_are_within_their_error";
    gpu_test(TEST, |context| {
        for (scene, size) in cases() {
            let truths = map_truths(&Casters::new(&scene), &scene, &View::volumes(&scene, size));
            for (path, error) in
                PATHS.into_iter().flat_map(|path| some([100, 10, 1000], 2).into_iter().map(move |e| (path, e)))
            {
                let text = format!("deep-shadow-map:error={error},size={size},path={path}");
                if !runs(TEST, context, &text) {
                    continue;
                }
                let technique = built(context, &scene, &text);
                for truth in &truths {
                    let answers = ask(context, technique.as_ref(), truth.light, &truth.points);
                    let Some(found) = point_error(&answers, &truth.visibility).expect("numbers") else { continue };
                    println!("{} {text}: {found:?}", scene.name);
                    // The query point is rounded, so near a step it may fall on the wrong side.
                    let bound = f64::from(error) / 1e4 + 1e-4;
                    assert!(
                        found.p99.is_none_or(|p99| p99 <= bound) && found.mean_abs <= bound / 2.0,
                        "{text}: {found:?}"
                    );
                }
            }
        }
    });
}

/// The order of casters does not matter, nor does the path by which they are found.
#[test]
fn casters_have_no_order() {
    const TEST: &str = "casters_have_no_order";
    gpu_test(TEST, |context| {
        for path in PATHS {
            let text = format!("deep-shadow-map:size=20,path={path}");
            if !runs(TEST, context, &text) {
                continue;
            }
            let scene = scenes::locks();
            let mut other = scene.clone();
            other.particles.reverse();
            other.strands.rotate_left(17);
            let [a, b] = [&scene, &other].map(|scene| built(context, scene, &text));
            for texel in 0..400 {
                let nodes = |t: &dyn Technique| t.inspect().nodes(0, [texel % 20, texel / 20]).expect("nodes");
                assert_eq!(nodes(a.as_ref()), nodes(b.as_ref()), "{text}, texel {texel}");
            }
        }
    });
}

/// The counters match the stored nodes, and empty texels have none.
#[test]
fn texels_without_casters_have_no_nodes() {
    if crate::support::is_long("texels_without_casters_have_no_nodes") {
        return;
    }
    const TEST: &str = "texels_without_casters_have_no_nodes";
    gpu_test(TEST, |context| {
        let mut empty = scenes::directional("empty", [0.0, 0.3, -1.0], Vec::new());
        empty.meshes.push(scenes::level(0.0, 1.0, [0.0, 0.0]));
        for path in PATHS {
            let text = format!("deep-shadow-map:size=21,path={path}");
            if !runs(TEST, context, &text) {
                continue;
            }
            let none = facts(built(context, &empty, &text).as_ref()).counters;
            assert_eq!((none["nodes"], none["covered_texels"]), (0, 0), "{text}");
            let technique = built(context, &scenes::beside(), &text);
            let counters = facts(technique.as_ref()).counters;
            let texels = (0..technique.inspect().maps().len())
                .flat_map(|map| (0..21 * 21).map(move |i| (map, [i % 21, i / 21])));
            let counts: Vec<_> =
                texels.map(|(map, at)| technique.inspect().nodes(map, at).expect("nodes").len() as u64).collect();
            assert_eq!(counts.iter().sum::<u64>(), counters["nodes"], "{text}");
            assert_eq!(counts.iter().filter(|count| **count > 0).count() as u64, counters["covered_texels"], "{text}");
            assert!(counters["covered_texels"] < 5 * 21 * 21, "{text}: {counters:?}");
            // One word per texel of whole tiles, plus one.
            assert_eq!(counters["bytes_used"], 8 * counters["nodes"] + 4 * (6 * 9 * 64 + 1), "{text}");
        }
    });
}

/// The chosen error is the smallest that fits, and it does fit; less room means more error; too little room is refused by name.
#[test]
fn budgets_are_kept() {
    const TEST: &str = "budgets_are_kept";
    if crate::support::is_costly(TEST) {
        return;
    }
    gpu_test(TEST, |context| {
        let scene = scenes::four_lights();
        let size = 16;
        for path in some(PATHS, 1) {
            if !runs(TEST, context, &format!("deep-shadow-map:path={path}")) {
                continue;
            }
            let of =
                |bytes: u64| built(context, &scene, &format!("deep-shadow-map:size={size},path={path},bytes={bytes}"));
            let mut errors = Vec::new();
            let mut budgets = some([60_000, 150_000, 90_000], 2);
            budgets.sort();
            for bytes in budgets {
                let technique = of(bytes);
                let counters = facts(technique.as_ref()).counters;
                println!("{path}, {bytes}: {counters:?}");
                let error = counters["error_millionths"] as f64 / 1e6;
                assert!(counters["bytes_used"] <= bytes, "{path}, {bytes}: {counters:?}");
                // An error 3 % smaller would not fit.
                let less = ((error * 0.97 * 1e4).floor() as u32).max(1);
                let plain = built(
                    context,
                    &scene,
                    &format!("deep-shadow-map:size={size},path={path},removal=area,error={less}"),
                );
                let wanted = facts(plain.as_ref()).counters["bytes_used"];
                assert!(less < 20 || wanted > bytes, "{path}, {bytes}: {error} was found, {less} takes {wanted}");
                errors.push(error);
            }
            assert!(errors.len() > 1 && errors.windows(2).all(|pair| pair[0] > pair[1]), "{path}: {errors:?}");
            let world = World::new(context, &scene).expect("room");
            for bytes in some([60_000 / 3, 100], 1) {
                let text = format!("deep-shadow-map:size={size},path={path},bytes={bytes}");
                let refused =
                    open(context, &world, &spec(&text)).and_then(|mut opened| opened.build(&world).map(|_| ()));
                let Err(Error::Refused(needs)) = refused else { panic!("{text} is not refused") };
                assert!(needs.to_string().contains("at least bytes="), "{needs}");
            }
        }
    });
}

/// Packed nodes equal full ones to within half a code, in half of the bytes.
#[test]
fn packed_nodes_are_the_same_rounded() {
    if crate::support::is_costly("packed_nodes_are_the_same_rounded") {
        return;
    }
    gpu_test("packed_nodes_are_the_same_rounded", |context| {
        for (scene, size) in some(cases(), 2) {
            let text = format!("deep-shadow-map:size={size},path=binned");
            let [full, packed] =
                ["full", "packed"].map(|storage| built(context, &scene, &format!("{text},storage={storage}")));
            let (mut all, mut most) = (0, [0f64; 2]);
            for (map, texel) in
                (0..full.inspect().maps().len()).flat_map(|map| (0..size * size).map(move |texel| (map, texel)))
            {
                let [a, b] =
                    [&full, &packed].map(|t| t.inspect().nodes(map, [texel % size, texel / size]).expect("nodes"));
                assert_eq!(a.len(), b.len(), "{}", scene.name);
                all += a.len() as u64;
                for (a, b) in a.iter().zip(&b) {
                    most = [most[0].max((a.0 - b.0).abs()), most[1].max((a.1 - b.1).abs())];
                }
            }
            println!("{}: {all} nodes, off by {most:?}", scene.name);
            assert!(most[0] <= 0.51 / 262_143.0 && most[1] <= 1.01 * 2.0 / 1f64.exp() / 16384.0, "{most:?}");
            let [a, b] = [full, packed].map(|t| facts(t.as_ref()).counters["bytes_used"]);
            assert_eq!(a - b, 4 * all, "{}", scene.name);
        }
    });
}
