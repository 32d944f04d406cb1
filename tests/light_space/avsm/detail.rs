//! detail=adaptive: survey and choice against their twins, each texel of each block against its curve's twin, and look-ups through the
//! table.

use crate::avsm::{AMBIGUOUS_TOLERANCE, FITTED_ELSEWHERE, TOLERANCE};
use crate::support::{all, ask, built_avsm, gpu_test, nodes_of, runs, scenes, spec};
use crate::twin::{DEPTH_ROUNDING, DEPTHS, Order, Twins, beyond, build, check_invariants, depth, look_up};
use gobo::gpu::Context;
use gobo::maps::Survey;
use gobo::reference::truth::Casters;
use gobo::reference::twin::avsm::pack::tight_value;
use gobo::reference::twin::detail::{SLOTS, Tile, choose, finer, survey};
use gobo::scene::{Projection, Scene, View};
use gobo::technique::{Avsm, NodeData, Technique, avsm};

/// Texels per block.
const BLOCK: usize = 64;

/// A built technique with its survey and its choice.
struct Built {
    avsm: Box<Avsm>,
    known: Vec<Tile>,
    slots: Vec<u32>,
    views: Vec<View>,
    text: String,
}

impl Built {
    fn new(context: &Context, scene: &Scene, text: &str) -> Self {
        let avsm = built_avsm(context, scene, text);
        let views: Vec<View> = avsm.inspect().maps().iter().map(|map| map.caster_view).collect();
        let tiles = views.iter().map(|v| (v.width.div_ceil(8) * v.height.div_ceil(8)) as usize).sum::<usize>();
        let detail = avsm.bins().and_then(|bins| bins.detail()).expect("detail");
        let known: Vec<Survey> = detail.surveys().read(tiles).expect("the surveys");
        let known =
            known.iter().map(|s| Tile { cells: s.cells, edges: s.edges, optical_depth: s.optical_depth }).collect();
        let mut slots: Vec<u32> = detail.slots().read(tiles * SLOTS).expect("the table");
        // Words past side² are undefined.
        slots.chunks_mut(SLOTS).for_each(|words| {
            let side = words[0] >> 28;
            words[(side * side) as usize..].fill(side << 28);
        });
        Self { known, slots, views, text: text.into(), avsm }
    }

    /// Returns, for a texel of a map `side` times as fine as its tile: (the tile's side, place of the texel's curve).
    fn place(&self, map: usize, at: [u32; 2], side: u32) -> (u32, Option<usize>) {
        let across = self.views[map].width.div_ceil(8);
        let tiles = across * self.views[map].height.div_ceil(8);
        let tile = at.map(|t| t / (8 * side));
        let words = &self.slots[(map as u32 * tiles + tile[1] * across + tile[0]) as usize * SLOTS..][..SLOTS];
        let its_side = words[0] >> 28;
        // The tile's own texel that contains the given texel's centre.
        let its = at.map(|t| (2 * t + 1) * its_side / (2 * side));
        let block = [0, 1].map(|i| its[i] / 8 - tile[i] * its_side);
        let place = words[(block[1] * its_side + block[0]) as usize] & 0xFFF_FFFF;
        let within = its[1] % 8 * 8 + its[0] % 8;
        (its_side, (place > 0).then(|| (place as usize - 1) * BLOCK + within as usize))
    }
}

fn scenes_of(cells: bool) -> Vec<Scene> {
    let inside = scenes::inside();
    if cells { vec![scenes::random(), inside] } else { vec![scenes::strands(), scenes::locks(), inside] }
}

/// The device's choice equals the twin's for the device's own survey, and the survey matches the casters in parallel views, except where
/// rounding decides whether a caster meets a cell.
#[test]
fn the_choice_equals_its_twin() {
    if crate::support::is_long("the_choice_equals_its_twin") {
        return;
    }
    gpu_test("the_choice_equals_its_twin", |context| {
        for scene in scenes_of(true).into_iter().chain(scenes_of(false)) {
            // With more than 1,024 tiles each caster is surveyed separately.
            let many = (scene.name == "random").then_some((600, "4000000", "on"));
            let sizes = [(64, "auto", "on"), (100, "1000000", "on"), (31, "600000", "on"), (64, "auto", "off")];
            for (size, bytes, skip) in sizes.into_iter().chain(many) {
                let text = format!("avsm:path=binned,detail=adaptive,nodes=4,size={size},bytes={bytes},skip={skip}");
                let built = Built::new(context, &scene, &text);
                let what = format!("{}, {text}", scene.name);
                let facts = built.avsm.inspect().facts().expect("facts");
                let [blocks, at_most] = ["blocks", "blocks_at_most"].map(|name| facts.counters[name]);
                assert!(blocks <= at_most, "{what}");
                let known = |tile: &Tile| Tile { cells: if skip == "on" { tile.cells } else { 0xFFFF }, ..*tile };
                let tiles: Vec<_> = built.known.iter().map(known).collect();
                let words = choose(&tiles, built.views[0].width.div_ceil(8), at_most as usize);
                assert!(words == built.slots, "{what}: another choice");
                let sides: Vec<u32> = words.iter().step_by(SLOTS).map(|word| word >> 28).collect();
                println!(
                    "{what}: {blocks} of {at_most} blocks, sides {} to {}",
                    sides.iter().min().unwrap_or(&0),
                    sides.iter().max().unwrap_or(&0)
                );
                if built.views[0].projection() == Projection::Parallel {
                    surveyed(&what, &scene, &built);
                }
            }
        }
    });
}

fn surveyed(what: &str, scene: &Scene, built: &Built) {
    let (view, casters) = (&built.views[0], scene.casters());
    let across = view.width.div_ceil(8);
    for (i, known) in built.known.iter().enumerate() {
        let tile = [i as u32 % across, i as u32 / across];
        // Surveys by the twin with cells a hundredth of a texel smaller and larger than the device's, as lower and upper bounds.
        let [sure, possible] = [-0.01, 0.01].map(|more| survey(view, &casters, tile, 0.0625 + more));
        assert_eq!(sure.cells & !known.cells, 0, "{what}, tile {i}: {sure:?}, not {known:?}");
        assert_eq!(known.cells & !possible.cells, 0, "{what}, tile {i}: {possible:?}, not {known:?}");
        // Allows one unit of rounding per caster.
        let units = casters.len() as u32;
        let between = |low: u32, n: u32, high: u32| (low.saturating_sub(units)..=high + units).contains(&n);
        assert!(between(sure.edges, known.edges, possible.edges), "{what}, tile {i}: {sure:?}, not {known:?}");
        let [low, high] = [sure, possible].map(|tile| tile.optical_depth);
        assert!(between(low, known.optical_depth, high), "{what}, tile {i}: {sure:?}, not {known:?}");
    }
}

fn compare(context: &Context, scene: &Scene, settings: &str, order: Order) {
    let (size, bytes) = if scene.name == "inside" { (32, 786_432) } else { (48, 500_000) };
    let storage = if settings.contains("storage=") { "" } else { ",storage=full" };
    let text = format!("avsm:path=binned,detail=adaptive,size={size},bytes={bytes},{settings}{storage}");
    let built = Built::new(context, scene, &text);
    let build = build(&spec(&text));
    let blocks = built.avsm.inspect().facts().expect("facts").counters["blocks"] as usize;
    let nodes = nodes_of(&built.avsm, &text, blocks * BLOCK);
    let (mut compared, mut covered, mut elsewhere, mut empty, mut sides) = (0, 0, 0, 0, [0; 9]);
    for (map, view) in built.views.iter().enumerate() {
        for side in 1..=8 {
            let twins = Twins::new(scene, finer(view, side));
            let twins = if settings.contains("texel=area") { twins.of_area() } else { twins };
            let width = twins.view.width;
            // Fine tiles have many texels: only some are compared.
            for texel in (0..width * twins.view.height).step_by(if all() { 1 } else { 5 }) {
                let (its_side, place) = built.place(map, [texel % width, texel / width], side);
                if its_side != side || (!scene.strands.is_empty() && twins.grazed(texel) > 0) {
                    continue;
                }
                let what = format!("{}, {text}, side {side}, texel {texel}", scene.name);
                let twin = twins.texel(texel, order);
                let Some(place) = place else {
                    assert!(twin.segments.is_empty(), "{what}: casters, and no place");
                    empty += 1;
                    continue;
                };
                sides[side as usize] += 1;
                let nodes = &nodes[place * build.nodes..][..build.nodes];
                let rounding = 1e-5 + twins.chord_rounding(texel) + twins.area_rounding(texel);
                check_invariants(&what, nodes, &twin.segments, build.interpolation, rounding);
                covered += u32::from(!twin.segments.is_empty());
                let (curve, is_ambiguous) = twin.curve(build);
                let at = |i| look_up(nodes, depth(i), build.interpolation);
                if is_ambiguous {
                    let mean = (0..DEPTHS).map(|i| (at(i) - curve.transmittance(depth(i))).abs()).sum::<f32>();
                    let mean = mean / DEPTHS as f32;
                    assert!(mean <= AMBIGUOUS_TOLERANCE || twin.is_no_worse(build, nodes), "{what}: {mean}");
                    continue;
                }
                compared += u32::from(!twin.segments.is_empty());
                let off = |i| beyond(&curve, depth(i), at(i), DEPTH_ROUNDING);
                if build.turns > 0 && (0..DEPTHS).any(|i| off(i) > TOLERANCE) && twin.is_no_worse(build, nodes) {
                    elsewhere += u32::from(!twin.is_met(build));
                    continue;
                }
                for i in 0..DEPTHS {
                    let difference = off(i);
                    assert!(difference <= TOLERANCE, "{what}: {difference} at {}\n{nodes:?}\n{curve:?}", depth(i));
                }
            }
        }
    }
    println!("{} {text}: {compared} of {covered} compared, {empty} without a place, sides {sides:?}", scene.name);
    assert!(f64::from(elsewhere) <= (f64::from(compared) * FITTED_ELSEWHERE).max(1.0), "{elsewhere} fitted elsewhere");
    assert!(2 * compared >= covered && covered > 0, "{} {text}: too few", scene.name);
    assert!(sides.iter().filter(|count| **count > 0).count() > 1, "{} {text}: all tiles are alike", scene.name);
}

/// Every texel of every block has the curve of its own ray; in tiles without a block, no ray meets a caster.
#[test]
fn blocks_equal_their_twin() {
    if crate::support::is_long("blocks_equal_their_twin") {
        return;
    }
    gpu_test("blocks_equal_their_twin", |context| {
        for scene in scenes_of(false) {
            compare(context, &scene, "resolve=streaming", Order::Tile);
        }
        compare(context, &scenes::strands(), "resolve=streaming,texel=area", Order::Tile);
        for batch in ["lanes", "shared"] {
            let settings = format!("resolve=cells,batch={batch}");
            if runs("blocks_equal_their_twin", context, &format!("avsm:path=binned,{settings}")) {
                for scene in &scenes_of(true)[..if batch == "lanes" || all() { 2 } else { 1 }] {
                    compare(context, scene, &settings, Order::Cells);
                }
            }
        }
    });
}

/// Returns points around a scene, and on the borders between tiles.
fn points(view: &View) -> Vec<[f32; 3]> {
    let mut random = scenes::Random::new(77);
    let mut point = |i: u32| {
        let across = f64::from(random.between(-0.02, 1.02)) * f64::from(view.width);
        let down = f64::from(random.between(-0.02, 1.02)) * f64::from(view.height);
        let across = if i.is_multiple_of(4) {
            (across / 8.0).round() * 8.0 + f64::from(random.between(-0.1, 0.1))
        } else {
            across
        };
        let z = view.z(f64::from(random.between(0.05, 1.1)));
        view.ray([across, down].into()).at(z).as_vec3().to_array()
    };
    (0..2000).map(&mut point).collect()
}

/// A look-up interpolates four texels at the resolution of the point's tile. A texel that falls in a tile of another resolution is replaced
/// by the texel of that tile that contains its centre.
#[test]
fn look_ups_go_through_the_table() {
    gpu_test("look_ups_go_through_the_table", |context| {
        for (scene, storage) in [(scenes::random(), "full"), (scenes::strands(), "full"), (scenes::random(), "tight")] {
            let text = format!("avsm:path=binned,detail=adaptive,size=64,storage={storage}");
            let built = Built::new(context, &scene, &text);
            let (view, interpolation) = (built.views[0], build(&spec(&text)).interpolation);
            let blocks = built.avsm.inspect().facts().expect("facts").counters["blocks"] as usize;
            let nodes = if storage == "full" {
                nodes_of(&built.avsm, &text, blocks * BLOCK)
            } else {
                tight_nodes(&built, blocks)
            };
            let points = points(&view);
            let answers = ask(context, &*built.avsm, 0, &points);
            let mut partly = 0;
            for (point, answer) in points.iter().zip(answers) {
                let (at, z) = view.project(glam::DVec3::from(point.map(f64::from)));
                let last = f64::from(view.width - 1);
                let tile_at = [at.x, at.y].map(|t| t.clamp(0.0, last) as u32);
                let side = built.place(0, tile_at, 1).0;
                let scaled = at * f64::from(side) - 0.5;
                let (corner, rest) = (scaled.floor(), scaled - scaled.floor());
                // On the edge of a tile, rounding decides which tile the point is in.
                let edge = [at.x, at.y].iter().any(|t| (t / 8.0 - (t / 8.0).round()).abs() < 1e-4);
                if edge || z <= f64::from(view.near) {
                    continue;
                }
                let depth = view.depth(z) as f32;
                let texel = |i: u32| {
                    let at = [corner.x + f64::from(i % 2), corner.y + f64::from(i / 2)];
                    let weight = (if i % 2 == 1 { rest.x } else { 1.0 - rest.x })
                        * (if i / 2 == 1 { rest.y } else { 1.0 - rest.y });
                    let inside = at.iter().all(|t| (0.0..f64::from(view.width * side)).contains(t));
                    let place = if inside { built.place(0, at.map(|t| t as u32), side).1 } else { None };
                    let count = nodes.len() / (blocks * BLOCK);
                    // Rounding decides on which side of a step a depth lies.
                    let of = |depth| place.map_or(1.0, |p| look_up(&nodes[p * count..][..count], depth, interpolation));
                    [of(depth - DEPTH_ROUNDING), of(depth + DEPTH_ROUNDING)].map(|t| weight * f64::from(t))
                };
                let [high, low] = (0..4).map(texel).fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
                let answer = f64::from(answer);
                assert!(answer <= high + 1e-4 && answer >= low - 1e-4, "{text}: {answer} at {at:?}, {low} to {high}");
                partly += u32::from(answer > 0.0 && answer < 1.0);
            }
            assert!(partly > 300, "{}: {partly} points are partly lit", scene.name);
        }
    });
}

/// Returns the unpacked nodes of tight curves.
fn tight_nodes(built: &Built, blocks: usize) -> Vec<NodeData> {
    let count = spec(&built.text).settings::<avsm::Settings>().nodes as usize;
    let words: Vec<u16> = built.avsm.curves().read(blocks * BLOCK * count).expect("the words");
    let node = |word: &u16| {
        let value = word & 0xFF;
        NodeData { depth: f32::from(word >> 8) * (1.0 / 255.0), value: f32::from(value) / f32::from(256 - value) }
    };
    words.iter().map(node).collect()
}

/// Tight curves are the full curves, quantized once.
#[test]
fn tight_curves_are_rounded_once() {
    if crate::support::is_costly("tight_curves_are_rounded_once") {
        return;
    }
    gpu_test("tight_curves_are_rounded_once", |context| {
        for (scene, path) in
            [(scenes::random(), "two-pass"), (scenes::strands(), "binned"), (scenes::random(), "binned")]
        {
            for curve in ["exponential", "linear"] {
                let text = format!("avsm:size=24,nodes=8,curve={curve},path={path},skip=off");
                let full = nodes_of(&built_avsm(context, &scene, &text), &text, 24 * 24);
                let words: Vec<u16> = built_avsm(context, &scene, &format!("{text},storage=tight"))
                    .curves()
                    .read(24 * 24 * 8)
                    .expect("read");
                let interpolation = build(&spec(&text)).interpolation;
                let mut last = [0; 2];
                for (i, (node, word)) in full.iter().zip(words).enumerate() {
                    last = if i % 8 == 0 { [0; 2] } else { last };
                    let codes = [u32::from(word >> 8), u32::from(word & 0xFF)];
                    assert!(codes[0] >= last[0] && codes[1] >= last[1], "{text}: node {i} turns back");
                    if node.depth < 1e30 {
                        // A device may pick the adjacent code if the value is within a few rounding errors of the boundary between two
                        // codes.
                        let near = |value: f32| [value * (1.0 - 1e-5) - 1e-7, value * (1.0 + 1e-5) + 1e-7];
                        let depths = near(node.depth).map(|d| (d * 255.0 + 0.5).min(255.0) as u32);
                        let mut values = near(node.value).map(|v| tight_value(v.max(0.0), interpolation));
                        values.sort_unstable();
                        assert!((depths[0]..=depths[1]).contains(&codes[0]), "{text}: node {i}, {node:?}, {codes:?}");
                        assert!((values[0]..=values[1]).contains(&codes[1]), "{text}: node {i}, {node:?}, {codes:?}");
                        last = codes;
                    } else {
                        assert_eq!(codes, last, "{text}: unused node {i}");
                    }
                }
            }
        }
    });
}

/// The order of the casters does not matter, and no build exceeds its byte budget.
#[test]
fn adaptive_maps_have_no_order() {
    if crate::support::is_costly("adaptive_maps_have_no_order") {
        return;
    }
    gpu_test("adaptive_maps_have_no_order", |context| {
        for scene in [scenes::random(), scenes::strands()] {
            let mut turned = scene.clone();
            turned.particles.reverse();
            turned.strands.reverse();
            for storage in ["full", "packed", "tight"] {
                let text = format!("avsm:path=binned,detail=adaptive,size=64,bytes=200000,nodes=4,storage={storage}");
                let [a, b] = [&scene, &turned].map(|scene| Built::new(context, scene, &text));
                assert!(a.slots == b.slots && a.known == b.known, "{}, {text}: another choice", scene.name);
                let facts = a.avsm.inspect().facts().expect("facts");
                let bytes = facts.bytes_resident - a.avsm.opaque_image().bytes();
                assert!(bytes <= 200_000, "{}, {text}: {bytes} bytes", scene.name);
                let words = facts.counters["blocks"] as usize
                    * BLOCK
                    * match storage {
                        "full" => 8,
                        "packed" => 6,
                        _ => 2,
                    };
                let [a, b] = [a, b].map(|built| built.avsm.curves().read::<u32>(words).expect("the curves"));
                // Whole buffers are comparable: here the map's edge coincides with a block's edge, so every texel of every block is
                // written.
                assert!(a == b, "{}, {text}: other curves", scene.name);
            }
        }
    });
}

/// With all other keys at their defaults, `detail=adaptive` has clearly less error than the uniform map, in no more bytes.
#[test]
fn alone_it_has_less_error() {
    gpu_test("alone_it_has_less_error", |context| {
        for scene in [scenes::random(), scenes::locks()] {
            let casters = Casters::new(&scene);
            let of = |text: &str| {
                let avsm = built_avsm(context, &scene, text);
                let points = points(&avsm.inspect().maps()[0].caster_view);
                let answers = ask(context, &*avsm, 0, &points);
                let off = points.iter().zip(answers).map(|(point, answer)| {
                    (f64::from(answer) - casters.visibility(0, glam::DVec3::from(point.map(f64::from)))).abs()
                });
                let facts = avsm.inspect().facts().expect("facts");
                (off.sum::<f64>() / points.len() as f64, facts.bytes_resident - avsm.opaque_image().bytes())
            };
            let (even, bytes) = of("avsm:path=binned,size=64");
            let (error, its_bytes) = of("avsm:detail=adaptive,size=64");
            println!("{}: {error:.5} of {even:.5}, {its_bytes} of {bytes} bytes", scene.name);
            assert!(error < 0.85 * even && its_bytes <= bytes, "{}: {error} of {even}", scene.name);
        }
    });
}

/// Unsupported settings are refused by name.
#[test]
fn what_adaptive_maps_need() {
    gpu_test("what_adaptive_maps_need", |context| {
        for (settings, needs) in [
            ("bytes=1000", "bytes, for the coarsest texels"),
            ("path=two-pass", "path=binned"),
            ("filter=box", "filter=bilinear"),
        ] {
            // A device may lack what two passes need, which is reported first.
            if settings.starts_with("path") && !runs("what_adaptive_maps_need", context, "avsm:path=two-pass") {
                continue;
            }
            let world = gobo::world::World::new(context, &scenes::random()).expect("room");
            let text = format!("avsm:detail=adaptive,size=64,{settings}");
            match Avsm::new(context, &world, &spec(&text).settings()) {
                Err(gobo::Error::Refused(said)) => assert!(said.to_string().contains(needs), "{text}: {said}"),
                Err(error) => panic!("{text}: {error}"),
                Ok(_) => panic!("{text} is not refused"),
            }
        }
    });
}
