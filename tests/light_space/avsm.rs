//! AVSM on the device against its CPU twins: every path, every node count, both curves, and the segments that compression handles worst.

mod ahead;
mod detail;
mod lanes;
mod levels;
mod list;
mod packed;
mod skip;
mod sort;
mod steps;

use crate::support::{
    all, built_avsm, gpu_test, gpu_test_needing, is_left_out, is_usual, nodes_of, opened, runs, scenes, some, spec,
    views,
};
use crate::twin;
use gobo::Error;
use gobo::gpu::{Context, Features, Requirement};
use gobo::reference::twin::avsm::curve::Build;
use gobo::reference::twin::avsm::pack;
use gobo::scene::Scene;
use gobo::technique::{Avsm, NodeData, Opened, Technique};
use gobo::world::World;
use twin::{DEPTH_ROUNDING, DEPTHS, Order, Twins, beyond, build, check_invariants, code, depth, half_code, look_up};

/// Largest difference in transmittance for curves with one right answer. Twice the threshold that makes a texel ambiguous, because the
/// twin's trials and the device's own rounding may err in opposite directions.
const TOLERANCE: f32 = 2e-4;

/// Maximum fraction of covered texels that may be ambiguous, so that most texels are still compared. The fraction is computed by the twin
/// alone: at most 27 %, or 38 % if curves are built with four or sixteen extra nodes, which produce more near-ties (23 of the 46 texels in
/// a tile of many casters). The last bits of the device's view make a few more texels ambiguous.
fn most_ambiguous(build: Build) -> f64 {
    if build.work >= build.nodes + 4 { 0.5 } else { 0.3 }
}

/// Minimum number of texels compared in `crowd`. Most of its texels are ambiguous, up to 71 % of 421, since each of the hundreds of
/// insertions into a texel chooses two nodes to remove. With this many, an error in one texel of 25 is found with a probability of 1 −
/// (24/25)¹¹³ = 99 %.
const ENOUGH: u32 = 113;

/// If rounding decides which node is removed, the device's curve may differ from the twin's but must be no worse. Either its mean distance
/// from the twin's curve is at most this tolerance, the sum of the errors of two curves of four nodes (0.008 each on the project's smoke),
/// or it is as near to the exact transmittance as the twin's curve ([`twin::Texel::is_no_worse`]).
const AMBIGUOUS_TOLERANCE: f32 = 0.016;

/// Maximum fraction of unambiguous texels in which the fit may place nodes differently from the twin. Texels that the twin's curve matches
/// almost exactly are not counted, since there the fit follows rounding errors alone. No texel's curve may be worse than the twin's.
const FITTED_ELSEWHERE: f64 = 0.02;

/// Reads the nodes of each texel, map after map.
fn nodes(avsm: &Avsm, texels: usize, count: usize) -> Vec<NodeData> {
    avsm.curves().read(texels * count).expect("they are there")
}

/// Compares every texel of every map of `scene` for 8, 4 and 16 nodes and all curves. A short run covers 8 nodes with two curves, and the
/// other node counts with one curve in one scene; the usual loop skips those for packed or fitted nodes.
fn compare(context: &Context, scene: &Scene, size: u32, settings: &str, order: Order) {
    // If the device hits a strand (or a splat in a texel's square) that the twin misses, the curves differ by a whole step.
    let steps = !scene.strands.is_empty() || settings.contains("texel=area");
    let met_alike = |twins: &Twins, texel| (!steps || twins.grazed(texel) == 0).then(|| twins.texel(texel, order));
    let twins: Vec<_> = views(context, scene, size)
        .into_iter()
        .map(|view| Twins::new(scene, view))
        .map(|twins| if settings.contains("texel=area") { twins.of_area() } else { twins })
        .flat_map(|twins| (0..size * size).map(|texel| met_alike(&twins, texel)).collect::<Vec<_>>())
        .collect();
    let is_variant = settings.contains("storage=packed") || settings.contains("fit=refined");
    let all_counts = scene.name == "random" && !(is_variant && is_usual());
    for count in some([8, 4, 16], if all_counts { 3 } else { 1 }) {
        for curve in some(["exponential,nudge=on", "linear", "exponential,nudge=off"], if count == 8 { 2 } else { 1 }) {
            if settings.contains("fit=refined") && curve == "linear" {
                continue; // refused: a fit needs optical depths
            }
            // `skip=off`: every tile is written, even those without casters.
            let text = format!("avsm:nodes={count},curve={curve},size={size},skip=off,{settings}");
            let build = build(&spec(&text));
            let interpolation = build.interpolation;
            let avsm = built_avsm(context, scene, &text);
            let all = nodes_of(&avsm, &text, twins.len());
            let packed = text.contains("storage=packed");
            let (mut covered, mut ambiguous, mut elsewhere, mut grazed) = (0, 0, 0, 0);
            let (mut worst, mut farthest) = (0.0f32, 0.0f32);
            for (texel, (nodes, twin)) in all.chunks_exact(count).zip(&twins).enumerate() {
                let what = format!("{}, {text}, texel {texel}", scene.name);
                let Some(twin) = twin else {
                    grazed += 1;
                    continue;
                };
                let segments = &twin.segments;
                let (mut curve, is_ambiguous) = twin.curve(build);
                // Tolerances of a packed texel: one code in depth, one code in the nodes' values, half a code at the tail.
                let (mut tail, mut tolerance, mut rounding) = (1e-5, TOLERANCE, DEPTH_ROUNDING);
                if packed {
                    curve = pack::packed(&curve);
                    tail += half_code(interpolation);
                    tolerance += code(interpolation, segments.iter().map(|s| s.optical_depth).sum());
                    rounding += 1.0 / 65535.0;
                }
                check_invariants(&what, nodes, segments, interpolation, tail);
                covered += u32::from(!segments.is_empty());
                if is_ambiguous {
                    ambiguous += 1;
                    let distance = |i| (look_up(nodes, depth(i), interpolation) - curve.transmittance(depth(i))).abs();
                    let mean = (0..DEPTHS).map(distance).sum::<f32>() / DEPTHS as f32;
                    farthest = farthest.max(mean);
                    let is_right = mean <= AMBIGUOUS_TOLERANCE || twin.is_no_worse(build, nodes);
                    assert!(is_right, "{what}: {mean} from the twin\n{nodes:?}\n{:?}", curve);
                    continue;
                }
                let off = |i| beyond(&curve, depth(i), look_up(nodes, depth(i), interpolation), rounding);
                if build.turns > 0 && (0..DEPTHS).any(|i| off(i) > tolerance) && twin.is_no_worse(build, nodes) {
                    elsewhere += u32::from(!twin.is_met(build));
                    continue;
                }
                for i in 0..DEPTHS {
                    let transmittance = look_up(nodes, depth(i), interpolation);
                    let difference = off(i);
                    worst = worst.max(difference);
                    assert!(
                        difference <= tolerance,
                        "{what}: {transmittance} at {}, the twin has {}\n{nodes:?}\n{:?}",
                        depth(i),
                        curve.transmittance(depth(i)),
                        curve,
                    );
                }
            }
            let share = f64::from(ambiguous) / f64::from(covered);
            println!(
                "{} {text}: {covered} covered, largest difference {worst:.1e}; {:.1} % ambiguous, mean up to {farthest:.1e}",
                scene.name,
                100.0 * share,
            );
            let compared = covered - ambiguous;
            let enough = if scene.name == "crowd" { compared >= ENOUGH } else { share <= most_ambiguous(build) };
            assert!(enough, "{} {text}: {share} of the texels are ambiguous, {compared} are not", scene.name);
            assert!(
                f64::from(elsewhere) <= (f64::from(compared) * FITTED_ELSEWHERE).max(1.0),
                "{} {text}: {elsewhere} of {compared} fitted elsewhere",
                scene.name
            );
            assert!(grazed * 20 < covered, "{} {text}: {grazed} texels are left out", scene.name);
            assert!(covered > 0, "{} {text}: nothing was compared", scene.name);
        }
    }
}

fn two_pass(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("two_pass_{name}"), |context| {
        compare(context, scene, size, "path=two-pass,order=sorted", Order::Entry);
    });
}

/// Compares the single-pass paths with the same twins.
fn single_pass(name: &str, path: &str, requirement: Requirement, scene: &Scene, size: u32) {
    gpu_test_needing(&format!("{path}_{name}"), &[requirement], |context| {
        compare(context, scene, size, &format!("path={path},order=captured"), Order::Index);
        compare(context, scene, size, &format!("path={path},order=sorted"), Order::Near);
    });
}

fn interlock(name: &str, scene: &Scene, size: u32) {
    single_pass(name, "interlock", Requirement::PixelInterlock, scene, size);
}

fn raster_order(name: &str, scene: &Scene, size: u32) {
    single_pass(name, "raster-order", Requirement::RasterOrder, scene, size);
}

fn binned(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("binned_{name}"), |context| {
        compare(context, scene, size, "path=binned,resolve=streaming", Order::Tile);
        // A software device has lanes, so in some scenes the other way of combining casters is tested too.
        let has_lanes = context.features().is_software();
        if has_lanes && (all() || scene.name == "strands") {
            compare(context, scene, size, "path=binned,resolve=streaming,batch=shared", Order::Tile);
        }
    });
}

fn cells(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("cells_{name}"), |context| {
        // Devices with lanes run the other variant, which combines casters and segments differently, in some scenes only.
        let lanes = runs(name, context, "avsm:path=binned,resolve=cells,batch=lanes");
        if lanes {
            compare(context, scene, size, "path=binned,resolve=cells,batch=lanes", Order::Cells);
        }
        if !lanes
            || (all() && ["random", "opaque", "strands", "inside"].contains(&scene.name.as_str()))
            || scene.name == "strands"
        {
            compare(context, scene, size, "path=binned,resolve=cells,batch=shared", Order::Cells);
        }
        if all() || scene.name == "random" {
            compare(context, scene, size, "path=binned,resolve=cells,fit=plain", Order::Cells);
        }
    });
}

/// Scenes that a short run leaves out.
const COSTLY: [&str; 6] = ["duplicates", "nested", "opaque", "crowd", "locks", "beside"];

macro_rules! twin_tests {
    ($($scene:ident $size:literal),+) => {
        twin_tests!(two_pass_equals_its_twin two_pass $($scene $size),+);
        twin_tests!(interlock_equals_its_twin interlock $($scene $size),+);
        twin_tests!(raster_order_equals_its_twin raster_order $($scene $size),+);
        twin_tests!(binned_equals_its_twin binned $($scene $size),+);
        twin_tests!(cells_equal_their_twin cells $($scene $size),+);
    };
    ($module:ident $path:ident $($scene:ident $size:literal),+) => {
        mod $module { $(#[test] fn $scene() {
            let name = stringify!($scene);
            if !super::COSTLY.contains(&name) || !super::is_left_out(concat!(stringify!($path), "_", stringify!($scene))) {
                super::$path(name, &super::scenes::$scene(), $size);
            }
        })+ }
    };
}

twin_tests!(random 24, duplicates 16, nested 16, opaque 16, crowd 24, strands 24, splats 20, locks 16, inside 12, beside 12);

/// Compares texels that represent their whole area.
fn area(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("area_{name}"), |context| {
        let (resolve, order) =
            if scene.strands.is_empty() { ("cells", Order::Cells) } else { ("streaming", Order::Tile) };
        compare(context, scene, size, &format!("path=binned,resolve={resolve},texel=area"), order);
        if scene.name == "bundles" {
            compare(context, scene, size, "path=binned,resolve=streaming,texel=area,batch=shared", order);
        }
    });
}

twin_tests!(areas_equal_their_twin area random 12, strands 20, bundles 20, splats 20, locks 16, inside 4);

/// In perspective, a texel's square grows with distance.
#[test]
fn areas_under_a_spot_light() {
    let scene = scenes::spot([2.0, 1.0, 3.0], 60.0, scenes::locks());
    area("locks_under_a_spot_light", &scene, 12);
}

/// Compares whole curves whose nodes are moved to fit the entire curve.
fn refined(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("refined_{name}"), |context| {
        let text = format!("avsm:path=two-pass,resolve=whole,fit=refined,size={size}");
        if runs(name, context, &text) {
            compare(context, scene, size, "path=two-pass,resolve=whole,fit=refined", Order::Entry);
        }
    });
}

twin_tests!(refined_equals_its_twin refined random 16, opaque 16, strands 16);

/// A tile with more entries than can be sorted in shared memory.
#[test]
fn a_tile_of_many_casters() {
    let scene = scenes::dense();
    gpu_test("a_tile_of_many_casters_is_one", |context| {
        let avsm = built_avsm(context, &scene, "avsm:path=binned,resolve=streaming,size=8");
        let counters = avsm.inspect().facts().expect("counted").counters;
        assert!(counters["tiles"] == 1 && counters["bin_entries"] > 1024, "{counters:?}");
    });
    binned("a_tile_of_many_casters", &scene, 8);
}

/// Compares every path with packed storage.
fn packed(name: &str, scene: &Scene, size: u32) {
    gpu_test(&format!("packed_{name}"), |context| {
        for (path, order) in [
            ("two-pass", Order::Entry),
            ("binned,resolve=streaming", Order::Tile),
            ("binned,resolve=cells", Order::Cells),
        ] {
            compare(context, scene, size, &format!("path={path},storage=packed"), order);
        }
    });
    for (path, requirement) in SINGLE_PASS {
        gpu_test_needing(&format!("packed_{path}_{name}"), &[requirement], |context| {
            compare(context, scene, size, &format!("path={path},storage=packed"), Order::Near);
        });
    }
}

twin_tests!(packed_equals_its_twin packed random 24, opaque 16, strands 24, inside 12);

/// In perspective, bins are not clipped to the tile's rays, and keys are computed on the tile's central ray.
#[test]
fn strands_under_a_spot_light() {
    let scene = scenes::spot([2.0, 1.0, 3.0], 60.0, scenes::locks());
    two_pass("locks_under_a_spot_light", &scene, 16);
    binned("locks_under_a_spot_light", &scene, 16);
}

/// Some strands cross edges between the faces of the point light's cube map.
#[test]
fn strands_under_a_point_light() {
    let scene = scenes::point([0.9, 1.1, 1.4], scenes::locks());
    two_pass("locks_under_a_point_light", &scene, 12);
    binned("locks_under_a_point_light", &scene, 12);
}

const SINGLE_PASS: [(&str, Requirement); 2] =
    [("interlock", Requirement::PixelInterlock), ("raster-order", Requirement::RasterOrder)];

/// Both single-pass paths run the same insertion in the same order: if a device has both, one's nodes in memory equal the other's in
/// attachments, bit for bit.
#[test]
fn single_pass_paths_agree() {
    let needs = SINGLE_PASS.map(|(_, requirement)| requirement);
    gpu_test_needing("single_pass_paths_agree", &needs, |context| {
        for scene in [scenes::random(), scenes::crowd()] {
            for count in some([8, 4, 16], 1) {
                // Interlock inserts into groups of eight texels: in rows of 11, the last group is incomplete.
                for (order, size) in [("sorted", 24), ("captured", 24), ("sorted", 11)] {
                    let [interlock, raster_order] = SINGLE_PASS.map(|(path, _)| {
                        let text = format!("avsm:nodes={count},path={path},order={order},size={size}");
                        nodes(&built_avsm(context, &scene, &text), size * size, count)
                    });
                    assert!(interlock == raster_order, "{}: {count} nodes, order={order}, {size}", scene.name);
                }
            }
        }
    });
}

/// Builds twice in each of two contexts and expects the same bytes.
#[test]
fn two_runs_give_the_same_bytes() {
    if crate::support::is_costly("two_runs_give_the_same_bytes") {
        return;
    }
    let run = |name: &str, needs: &[Requirement], text: &str| {
        let mut runs: Vec<Vec<u32>> = Vec::new();
        for _ in 0..2 {
            gpu_test_needing(name, needs, |context| {
                let world = World::new(context, &scenes::crowd()).expect("room for the scene");
                let avsm = Box::new(opened(Avsm::new(context, &world, &spec(text).settings()), text));
                let mut avsm = Opened::new(context, avsm, true);
                for _ in 0..2 {
                    avsm.rebuild(&world).expect("built");
                    runs.push(avsm.technique.curves().read(24 * 24 * 8 * 2).expect("the nodes"));
                }
            });
        }
        assert!(runs.windows(2).all(|r| r[0] == r[1]), "{text}: not the same bytes");
    };
    run("two_runs_of_two_pass", &[], "avsm:path=two-pass,size=24");
    run("two_runs_of_whole_curves", &[], "avsm:path=two-pass,resolve=whole,size=24");
    run("two_runs_of_binned", &[], "avsm:path=binned,resolve=streaming,size=24");
    run("two_runs_of_cells", &[], "avsm:path=binned,resolve=cells,size=24");
    for (path, requirement) in SINGLE_PASS {
        for order in ["sorted", "captured"] {
            let text = format!("avsm:path={path},order={order},size=24");
            run(&format!("two_runs_of_{path}"), &[requirement], &text);
        }
    }
}

/// A path that the device cannot run is refused with the feature's name; `auto` reports its choice and the reason.
#[test]
fn paths_are_what_the_device_can_do() {
    if crate::support::is_costly("paths_are_what_the_device_can_do") {
        return;
    }
    gpu_test("paths_are_what_the_device_can_do", |context| {
        const INTERLOCK: &str = "fragmentShaderPixelInterlock";
        const RASTER_ORDER: &str = "rasterizationOrderColorAttachmentAccess";
        let scene = scenes::nested();
        let world = World::new(context, &scene).expect("room for the scene");
        let open = |text: &str| {
            let mut avsm = Opened::new(context, Box::new(Avsm::new(context, &world, &spec(text).settings())?), true);
            avsm.build(&world)?;
            avsm.technique.inspect().facts()
        };
        let features = context.features();
        let interlock = features.fragment_shader_pixel_interlock;
        let raster_order = features.rasterization_order_color_attachment_access;
        for (path, has, feature) in [("interlock", interlock, INTERLOCK), ("raster-order", raster_order, RASTER_ORDER)]
        {
            // Four nodes, so that no device runs out of attachments.
            let asked = open(&format!("avsm:path={path},nodes=4,size=8"));
            let has = has && features.fragment_stores_and_atomics;
            if has {
                assert_eq!(asked.expect("the device has it").path, path);
                // A single pass never sees the whole curve.
                let Err(error) = open(&format!("avsm:path={path},resolve=whole,size=8")) else { panic!("{path}") };
                assert!(error.to_string().contains("resolve=whole"), "{error}");
            } else {
                let Err(error) = asked else { panic!("the device lacks {feature}") };
                let stores = "fragmentStoresAndAtomics";
                assert!(
                    matches!(&error, Error::Refused(needs) if needs.to_string() == feature || needs.to_string() == stores),
                    "{error}"
                );
            }
        }
        // A fit needs sums, which insertion does not have either.
        for text in ["avsm:path=binned,resolve=streaming,fit=refined,size=8", "avsm:curve=linear,fit=refined,size=8"] {
            let Err(error) = open(text) else { panic!("{text}") };
            assert!(error.to_string().contains("fit=refined"), "{error}");
        }
        let auto = |scene: &Scene, text: &str| {
            let facts = built_avsm(context, scene, text).inspect().facts().expect("counted");
            assert!(facts.reason.starts_with("auto: "), "{}", facts.reason);
            facts.path
        };
        let lists = features.is_software() && features.fragment_stores_and_atomics;
        let wide = features.subgroup_size >= 8 && features.lacks_full_subgroups(64).is_none();
        let segment_by_segment = if lists && !wide { "two-pass" } else { "binned" };
        assert_eq!(auto(&scene, "avsm:size=8"), "binned");
        assert_eq!(auto(&scenes::strands(), "avsm:size=8"), segment_by_segment);
        assert_eq!(auto(&scene, "avsm:size=8,resolve=whole"), segment_by_segment);
        if features.fragment_stores_and_atomics {
            assert_eq!(auto(&scene, "avsm:size=8,resolve=whole,fit=refined"), "two-pass");
            let captured = if interlock { "interlock" } else { "two-pass" };
            assert_eq!(auto(&scene, "avsm:size=8,order=captured"), captured);
        }
    });
}

/// Lanes are available if subgroups are full and no wider than the workgroup of 32 threads; otherwise the missing feature is named.
#[test]
fn lanes_need_full_subgroups() {
    gpu_test("lanes_need_full_subgroups", |context| {
        let mut features = context.features().clone();
        (features.subgroup_ballot, features.compute_full_subgroups) = (true, true);
        for (size, has) in [(1, true), (4, true), (8, true), (32, true), (64, false), (128, false), (0, false)] {
            features.subgroup_size = size;
            assert_eq!(features.lacks_full_subgroups(32).is_none(), has, "subgroups of {size}");
        }
        features.subgroup_size = 64;
        let missing = features.lacks_full_subgroups(32).expect("too wide");
        assert!(
            missing.to_string().contains("subgroups of 32 threads") && missing.to_string().contains("have 64"),
            "{missing}"
        );
        features.subgroup_size = 32;
        features.compute_full_subgroups = false;
        assert!(features.lacks_full_subgroups(32).is_some_and(|m| m.to_string().contains("computeFullSubgroups")));
        features.subgroup_ballot = false;
        assert!(features.lacks_full_subgroups(32).is_some_and(|m| m.to_string().contains("ballots")));
    });
}

/// Two nodes per attachment: checks the limits that a raster-order curve needs, and which one is named if it is too low.
#[test]
fn attachments_within_the_limits() {
    gpu_test("attachments_within_the_limits", |context| {
        let mut features = context.features().clone();
        features.rasterization_order_color_attachment_access = false;
        let missing = features.lacks(Requirement::RasterOrder);
        assert_eq!(missing, Some("rasterizationOrderColorAttachmentAccess"));

        features.max_color_attachments = 4;
        features.max_fragment_output_attachments = 4;
        features.max_per_stage_descriptor_input_attachments = 4;
        features.max_fragment_combined_output_resources = 6;
        assert_eq!(features.attachment_limit(4, 2), None);
        let short = |change: fn(&mut Features)| {
            let mut features = features.clone();
            change(&mut features);
            features.attachment_limit(4, 2).expect("one too many")
        };
        assert!(short(|f| f.max_color_attachments = 3).to_string().contains("maxColorAttachments of at least 4"));
        assert!(
            short(|f| f.max_fragment_output_attachments = 3)
                .to_string()
                .contains("maxFragmentOutputAttachments of at least 4")
        );
        let input = short(|f| f.max_per_stage_descriptor_input_attachments = 3);
        assert!(input.to_string().contains("maxPerStageDescriptorInputAttachments of at least 4"), "{input}");
        let combined = short(|f| f.max_fragment_combined_output_resources = 5);
        assert!(
            combined.to_string().contains("maxFragmentCombinedOutputResources of at least 6 (this device has 5)"),
            "{combined}"
        );
    });
}
