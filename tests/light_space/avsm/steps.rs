//! Depths that are the same f32: segments so short that entry and exit coincide, and segments that begin together.

use crate::support::{built_avsm, gpu_test_needing, scenes, some, spec, views};
use crate::twin::{DEPTHS, build, check_invariants, curve, depth, look_up};
use glam::DVec2;
use gobo::gpu::{Context, Requirement};
use gobo::reference::twin::segment::{Segment, sort, texel_segment};
use gobo::scene::{Caster, Particle, Scene, Strand, View};

const SIZE: u32 = 8;

/// z of the tiny spheres. Just below a power of two, floats are twice as dense as just above it, so the ends of a sphere smaller than that
/// spacing are rounded to the power of two and to the float below it. The segment's length is not zero, but so small that its entry and
/// exit depths, relative to the light's range, where floats are sparser, may be equal.
const Z: f32 = 128.0;

/// Half the chord, 0.66 times the spacing of floats below 128: the chord's end beyond 128 rounds to 128, its other end to the next float
/// below 128.
const RADIUS: f32 = 5e-6;

/// A light along −z over a deep and narrow box, spanned by two spheres at opposite corners, with a tiny dense sphere on the light ray of
/// some texels' centres. Nothing else is in their texels.
///
/// The light is axis-aligned so that every operation from a particle to z is exact, on any device.
fn scene(context: &Context, deep: f32) -> Scene {
    let anchor = |x: f32, z: f32| Particle { position: [x, x, z], radius: 0.125, extinction: 0.5 };
    let mut scene = scenes::directional("steps", [0.0, 0.0, -1.0], vec![anchor(-0.875, 0.0), anchor(0.875, -deep)]);
    let view = views(context, &scene, SIZE)[0];
    for (x, y) in [(2, 1), (3, 3), (1, 6), (5, 2)] {
        let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let [x, y] = [ray.origin.x as f32, ray.origin.y as f32];
        let position = [x, y, view.origin[2] - Z];
        scene.particles.push(Particle { position, radius: RADIUS, extinction: 1e5 });
        // A thinner sphere at exactly the same place: equal depths and zero length at once.
        scene.particles.push(Particle { position, radius: RADIUS, extinction: 4e4 });
    }
    assert_eq!(views(context, &scene, SIZE)[0], view, "the tiny spheres stand within the box");
    scene
}

fn segments(scene: &Scene, view: &View, texel: u32) -> Vec<Segment> {
    let cut = |(i, p)| texel_segment(view, [texel % SIZE, texel / SIZE], &Caster::from(p)).map(|s| (i, s));
    let mut all: Vec<_> = (0u32..).zip(&scene.particles).filter_map(cut).collect();
    sort(&mut all);
    all.into_iter().map(|(_, s)| s).collect()
}

/// Returns a scene in which the segments of all tiny spheres have zero length and still absorb light, according to the twin.
fn scene_of_steps(context: &Context) -> (Scene, View) {
    for i in 0..200 {
        let scene = scene(context, 150.0 + 0.5 * i as f32);
        let view = views(context, &scene, SIZE)[0];
        let all: Vec<_> = (0..SIZE * SIZE).flat_map(|t| segments(&scene, &view, t)).collect();
        if all.iter().filter(|s| s.entry == s.exit && s.optical_depth > 0.1).count() == 8 {
            return (scene, view);
        }
    }
    panic!("no depth of the box makes a segment of no length");
}

/// A segment of zero length is a step: not 0/0, not nothing, and entirely at its depth.
fn steps(name: &str, needs: &[Requirement], path: &str) {
    gpu_test_needing(name, needs, |context| {
        let (scene, view) = scene_of_steps(context);
        for count in some([8, 4, 16], 1) {
            for values in ["linear", "exponential"] {
                let text = format!("avsm:nodes={count},curve={values},size={SIZE},path={path}");
                let build = build(&spec(&text));
                let interpolation = build.interpolation;
                let avsm = built_avsm(context, &scene, &text);
                let nodes = avsm.curves().read((SIZE * SIZE) as usize * count).expect("the nodes");
                for (texel, nodes) in (0..).zip(nodes.chunks_exact(count)) {
                    let segments = segments(&scene, &view, texel);
                    let what = format!("{text}, texel {texel}");
                    check_invariants(&what, nodes, &segments, interpolation, 1e-5);
                    // At most two segments: four nodes hold them without a removal, so nothing is ambiguous.
                    let twin = curve(&segments, None, build);
                    for i in 0..DEPTHS {
                        let (got, wanted) = (look_up(nodes, depth(i), interpolation), twin.transmittance(depth(i)));
                        assert!((got - wanted).abs() < 1e-5, "{what} at {}: {got}, not {wanted}", depth(i));
                    }
                    if segments.iter().any(|s| s.entry == s.exit) {
                        // z is exact; depth is a division, in which Vulkan allows an error of 2.5 ulp.
                        let takes = |depth: &f32| look_up(nodes, *depth, interpolation) < 1.0;
                        let step = nodes.iter().map(|n| n.depth).find(takes).expect("a node that takes light");
                        let ulps = step.to_bits().abs_diff(segments[0].entry.to_bits());
                        assert!(ulps <= 3, "{what}: {step}, not {}", segments[0].entry);
                        assert_eq!(look_up(nodes, step.next_down(), interpolation), 1.0, "{what}: in front");
                        let behind = look_up(nodes, step, interpolation);
                        let product = (-segments.iter().map(|s| s.optical_depth).sum::<f32>()).exp();
                        assert!((behind - product).abs() < 1e-5, "{what}: {behind} behind, not {product}");
                        assert!(behind < 0.9, "{what}: the step takes light");
                    }
                }
            }
        }
    });
}

#[test]
fn two_pass_makes_steps() {
    steps("two_pass_makes_steps", &[], "two-pass");
}

#[test]
fn interlock_makes_steps() {
    steps("interlock_makes_steps", &[Requirement::PixelInterlock], "interlock");
}

#[test]
fn raster_order_makes_steps() {
    steps("raster_order_makes_steps", &[Requirement::RasterOrder], "raster-order");
}

/// Spheres that touch at one point, where the single light ray of a one-texel map enters them all at once. The light is axis-aligned, every
/// number is a multiple of 1/8 and the light's plane is some 10 units away, so no operation rounds.
fn tangent(order: impl Iterator<Item = u8>) -> Scene {
    let at = |z: f32, radius: f32, extinction: f32| Particle { position: [0.0, 0.0, z], radius, extinction };
    // Larger spheres are thinner; the two with extinction 0 keep the box's extent.
    let mut particles: Vec<_> =
        order.map(|i| f32::from(i) / 8.0).map(|radius| at(-radius, radius, 0.1 / radius)).collect();
    particles.extend([at(9.5, 0.5, 0.0), at(-9.5, 0.5, 0.0)]);
    scenes::directional("tangent", [0.0, 0.0, -1.0], particles)
}

/// Segments with equal entry depths are ordered by exit, whatever the order of their particles: the curve is the same to the bit. Inserting
/// them in particle order would give other curves.
#[test]
fn ties_go_by_exit() {
    if crate::support::is_costly("ties_go_by_exit") {
        return;
    }
    gpu_test_needing("ties_go_by_exit", &[], |context| {
        for curve_of in ["linear", "exponential,nudge=off", "exponential,nudge=on"] {
            let text = format!("avsm:nodes=4,curve={curve_of},size=1,path=two-pass");
            let build = build(&spec(&text));
            let both = [tangent(1..=10), tangent((1..=10).rev())].map(|scene| {
                let view = views(context, &scene, 1)[0];
                let cut = |(i, p)| texel_segment(&view, [0, 0], &Caster::from(p)).map(|s| (i, s));
                let mut all: Vec<_> = (0u32..).zip(&scene.particles).filter_map(cut).collect();
                all.retain(|(_, s)| s.optical_depth > 0.0);
                assert!(all.len() == 10 && all.iter().all(|(_, s)| s.entry == all[0].1.entry), "{all:?}");
                let curve_in =
                    |all: &[(u32, Segment)]| curve(&all.iter().map(|(_, s)| *s).collect::<Vec<_>>(), None, build);
                let as_they_come = curve_in(&all);
                sort(&mut all);
                let twin = curve_in(&all);
                let avsm = built_avsm(context, &scene, &text);
                let nodes = avsm.curves().read(4).expect("the nodes");
                for i in 0..DEPTHS {
                    let (got, wanted) = (look_up(&nodes, depth(i), build.interpolation), twin.transmittance(depth(i)));
                    assert!((got - wanted).abs() < 1e-5, "{text} at {}: {got}, not {wanted}\n{twin:?}", depth(i));
                }
                (as_they_come, nodes)
            });
            assert_eq!(both[0].1, both[1].1, "{text}");
            let apart = |i| (both[0].0.transmittance(depth(i)) - both[1].0.transmittance(depth(i))).abs();
            let apart = (0..DEPTHS).map(apart).fold(0.0, f32::max);
            assert!(apart > 1e-3, "{text}: the order makes no difference, so that the test says nothing of it");
        }
    });
}

/// A hair that the light hits head-on: a bundle of strands one behind another, each a step. The light is axis-aligned and every number is a
/// multiple of 1/8, so no operation rounds.
fn bundle() -> Scene {
    let across = |z: f32, opacity: f32| Strand { start: [-1.0, -0.125, z], radius: 0.5, end: [1.0, 0.125, z], opacity };
    let mut scene = scenes::directional("bundle", [0.0, 0.0, -1.0], Vec::new());
    scene.strands = [(4.0, 0.25), (2.0, 0.5), (2.0, 0.5), (-1.0, 0.0), (-2.0, 1.0)].map(|(z, o)| across(z, o)).to_vec();
    // A strand along the light's direction, on the same ray: seen edge-on, so it absorbs nothing.
    scene.strands.push(Strand { start: [0.0, 0.0, 5.0], radius: 0.5, end: [0.0, 0.0, -5.0], opacity: 1.0 });
    scene
}

/// Checks four steps at three depths against values computed by hand: 3/4 of the light behind the first step, a quarter of that behind the
/// two at z = 2, and e⁻⁸⁰, i.e. nothing, behind the last.
fn strand_steps(name: &str, needs: &[Requirement], path: &str) {
    gpu_test_needing(name, needs, |context| {
        let scene = bundle();
        let view = views(context, &scene, 1)[0];
        for values in ["linear", "exponential"] {
            let text = format!("avsm:nodes=8,curve={values},size=1,path={path}");
            let interpolation = build(&spec(&text)).interpolation;
            let nodes: Vec<_> = built_avsm(context, &scene, &text).curves().read(8).expect("the nodes");
            for (z, wanted) in [(4.5, 1.0), (3.0, 0.75), (1.5, 0.1875), (-0.5, 0.1875), (-1.5, 0.1875), (-2.5, 0.0)] {
                let depth = view.depth(f64::from(view.origin[2]) - z) as f32;
                let got = look_up(&nodes, depth, interpolation);
                assert!((got - wanted).abs() < 1e-5, "{text} at z = {z}: {got}, not {wanted}: {nodes:?}");
            }
            let first = view.depth(f64::from(view.origin[2]) - 4.0) as f32;
            assert_eq!(look_up(&nodes, first - 1e-5, interpolation), 1.0, "{text}: in front of the first step");
            assert!((look_up(&nodes, first + 1e-5, interpolation) - 0.75).abs() < 1e-5, "{text}: behind it");
        }
    });
}

#[test]
fn strands_are_steps() {
    if crate::support::is_costly("strands_are_steps") {
        return;
    }
    strand_steps("strands_are_steps_two_pass", &[], "two-pass");
    strand_steps("strands_are_steps_whole", &[], "two-pass,resolve=whole");
    strand_steps("strands_are_steps_binned", &[], "binned");
    strand_steps("strands_are_steps_interlock", &[Requirement::PixelInterlock], "interlock");
    strand_steps("strands_are_steps_raster_order", &[Requirement::RasterOrder], "raster-order");
}
