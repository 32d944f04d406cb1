//! Packed curves: their drift under thousands of insertions, their size, and the nodes that `gobo curve` gets.

use crate::support::{
    all, built_avsm, gpu_test_needing, is_long, nodes_of, opened, scenes, scenes::Random, some, spec, views,
};
use crate::twin::{build, half_code};
use gobo::gpu::Requirement;
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::reference::twin::avsm::pack::pack_value;
use gobo::reference::twin::segment::texel_segment;
use gobo::scene::{Caster, Particle, Scene};
use gobo::technique::{Avsm, Opened, Technique};
use gobo::world::World;

const PATHS: [(&str, &[Requirement]); 6] = [
    ("two-pass", &[]),
    ("two-pass,resolve=whole", &[]),
    ("binned,resolve=streaming", &[]),
    ("binned,resolve=cells", &[]),
    ("interlock", &[Requirement::PixelInterlock]),
    ("raster-order", &[Requirement::RasterOrder]),
];

/// Returns the number of insertions into one texel, and the curve sizes. 10,000 and all sizes for paths that store the curve at each
/// insertion, so that it could drift. The other paths store the curve once and get fewer insertions: on lavapipe 22.3 an invocation's loops
/// end after some 65,536 rounds in total (README). A short run has a tenth.
fn insertions(path: &str) -> (usize, &'static [u32]) {
    match path {
        _ if !all() => (1_000, &[8]),
        "binned,resolve=streaming" => (500, &[4, 16]),
        "two-pass" | "two-pass,resolve=whole" | "binned,resolve=cells" => (3_000, &[8]),
        _ => (10_000, &[4, 8, 16]),
    }
}

/// Returns a column of spheres along the single light ray of a one-texel map, each with optical depth about 1e-4; if `mixed`, one in a
/// thousand absorbs about a third of the light.
fn column(mixed: bool, count: usize) -> Scene {
    let mut random = Random::new(if mixed { 2 } else { 1 });
    let sphere = |i| {
        let radius = random.between(0.05, 1.0);
        let optical_depth =
            if mixed && i % 1000 == 0 { random.between(0.3, 0.5) } else { random.between(0.5e-4, 1.5e-4) };
        let position = [0.0, 0.0, random.between(-10.0, 10.0)];
        Particle { position, radius, extinction: optical_depth / (2.0 * radius) }
    };
    let name = if mixed { "mixed column" } else { "thin column" };
    scenes::directional(name, [0.0, 0.0, -1.0], (0..count).map(sphere).collect())
}

/// A packed curve matches the full one to half a code, however many insertions built it. Its tail is the product of all segments to within
/// half a code and the f32 rounding of as many insertions.
#[test]
fn thousands_of_insertions_do_not_drift() {
    if is_long("thousands_of_insertions_do_not_drift") {
        return;
    }
    for (path, needs) in PATHS {
        gpu_test_needing(&format!("thousands_of_insertions_{path}"), needs, |context| {
            let (count, sizes) = insertions(path);
            for scene in [column(false, count), column(true, count)] {
                let view = views(context, &scene, 1)[0];
                let segments: Vec<_> =
                    scene.particles.iter().filter_map(|p| texel_segment(&view, [0, 0], &Caster::from(p))).collect();
                assert_eq!(segments.len(), count);
                let product = (-segments.iter().map(|s| f64::from(s.optical_depth)).sum::<f64>()).exp();
                for curve in ["linear", "exponential"] {
                    for nodes in sizes {
                        let text = format!("avsm:nodes={nodes},curve={curve},size=1,path={path}");
                        let interpolation = build(&spec(&text)).interpolation;
                        let avsm = built_avsm(context, &scene, &text);
                        let full = nodes_of(&avsm, &text, 1);
                        let text = format!("{text},storage=packed");
                        let packed = nodes_of(&built_avsm(context, &scene, &text), &text, 1);
                        let what = format!("{}, {text}:\n{full:?}\n{packed:?}", scene.name);
                        let used = full.iter().filter(|n| n.depth < 2.0).count();
                        assert!(used > 1, "{what}");
                        let extent = full[used - 1].depth - full[0].depth;
                        // Error bound of a depth: half a code, plus the f32 rounding error of a depth up to 1.
                        let half_depth = 0.51 * extent / 65535.0 + f32::EPSILON;
                        let through = |value: f32| match interpolation {
                            Interpolation::Linear => f64::from(value),
                            Interpolation::Exponential => (-f64::from(value)).exp(),
                        };
                        for (full, packed) in full.iter().zip(&packed).take(used) {
                            assert!((full.depth - packed.depth).abs() <= half_depth, "{what}");
                            let codes = [full, packed].map(|n| pack_value(n.value, interpolation));
                            assert!(codes[0].abs_diff(codes[1]) <= 1, "{what}");
                            let apart = (through(full.value) - through(packed.value)).abs();
                            assert!(apart <= half_code(interpolation), "{apart}: {what}");
                        }
                        assert_eq!(packed[0].depth, full[0].depth, "{what}");
                        assert!(packed[used - 1..].windows(2).all(|n| n[0] == n[1]), "{what}");
                        let [full, packed] = [&full, &packed].map(|n| through(n[used - 1].value) - product);
                        println!("{}, {text}: tail off by {full:.1e}, packed {packed:.1e}", scene.name);
                        // Error bound: an insertion rounds a few times, each time by at most half of 2^-23 times a value up to 8, or times
                        // T.
                        let rounding = segments.len() as f64 * f64::from(f32::EPSILON) * product * 4.0;
                        assert!(full.abs() <= rounding, "{full}: {what}");
                        assert!(packed.abs() <= rounding + half_code(interpolation), "{packed}: {what}");
                    }
                }
            }
        });
    }
}

/// A texel takes 8 bytes plus 4 per node; interlock needs the full nodes of all maps only during the build. `gobo curve` draws the nodes
/// that the look-up reads.
#[test]
fn bytes_and_nodes_of_packed_curves() {
    if crate::support::is_long("bytes_and_nodes_of_packed_curves") {
        return;
    }
    for (path, needs) in PATHS {
        gpu_test_needing(&format!("bytes_and_nodes_of_packed_{path}"), needs, |context| {
            let scene = scenes::point([0.9, 1.1, 1.4], scenes::random());
            // Interlock inserts into groups of eight texels: in rows of 19, the last group is incomplete.
            let texels = 6 * 19 * 19;
            for count in some([4, 16], 1) {
                let text = format!("avsm:nodes={count},size=19,path={path}");
                let full = built_avsm(context, &scene, &text);
                let text = format!("{text},storage=packed");
                let world = World::new(context, &scene).expect("room for the scene");
                let packed = Box::new(opened(Avsm::new(context, &world, &spec(&text).settings()), &text));
                let mut packed = Opened::new(context, packed, true);
                let passes = packed.build(&world).expect(&text).passes;
                let packed = packed.technique;
                let [full_facts, packed_facts] = [&full, &packed].map(|avsm| avsm.inspect().facts().expect("counted"));
                let saved = full_facts.bytes_resident - packed_facts.bytes_resident;
                assert_eq!(saved, texels * (8 * count - (8 + 4 * count)), "{text}");
                let more = packed_facts.bytes_transient - full_facts.bytes_transient;
                assert_eq!(more, if path == "interlock" { texels * 8 * count } else { 0 }, "{text}");
                if context.features().timestamp_valid_bits > 0 {
                    let packs = passes.iter().any(|p| p.name == "avsm.pack");
                    assert_eq!(packs, path == "interlock", "{text}");
                }
                let [full_covered, covered] = [full_facts, packed_facts].map(|f| f.counters["covered_texels"]);
                assert_eq!(covered, full_covered, "{text}");
                let unpacked = nodes_of(&packed, &text, texels as usize);
                let mut drawn = 0;
                // Each texel needs its own read-back, so only one in thirteen is checked, which still reaches every row and column.
                let (step, least) = if all() { (13, 15) } else { (29, 5) };
                for (texel, nodes) in (0u32..).zip(unpacked.chunks_exact(count as usize)).step_by(step) {
                    let (map, at) = (texel / 361, [texel % 19, texel % 361 / 19]);
                    let told = packed.inspect().nodes(map as usize, at).expect("the nodes");
                    let full = full.inspect().nodes(map as usize, at).expect("the nodes");
                    assert!(
                        told.len() <= full.len() && told.is_empty() == full.is_empty(),
                        "{text}: {told:?} {full:?}"
                    );
                    let last = nodes[count as usize - 1];
                    if let Some(&(depth, through)) = told.last() {
                        assert!((depth - f64::from(last.depth)).abs() < 1e-6, "{text}");
                        assert!((through - (-f64::from(last.value)).exp()).abs() < 1e-6, "{text}");
                        let (depth, through) = full[full.len() - 1];
                        assert!((depth - f64::from(last.depth)).abs() < 1e-6, "{text}");
                        assert!((through - (-f64::from(last.value)).exp()).abs() <= 2e-5, "{text}");
                        drawn += 1;
                    }
                }
                assert!(drawn > least, "{text}: {drawn} texels");
            }
        });
    }
}
