//! Marched curves: each against its twin, their ends against the grid, and look-ups against a density grid that is marched at each look-up;
//! also, what skipping, order and lights may and may not change.

use crate::support::{ask, gpu_test, scenes, scenes::Random, some, spec};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::reference::truth::Casters;
use gobo::reference::twin::avsm::curve::Build;
use gobo::reference::twin::avsm::levels::merged;
use gobo::reference::twin::avsm::node::Interpolation;
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::marched::{Errors, marched};
use gobo::reference::twin::media::Media;
use gobo::reference::twin::soft::way;
use gobo::scene::{FARTHEST, Particle, Scene, View};
use gobo::technique::marched::Settings;
use gobo::technique::{Marched, NodeData, Opened, Technique, open};
use gobo::world::World;
use proptest::prelude::*;

/// Depths at which curves are compared.
const DEPTHS: usize = 65;

fn depth(i: usize) -> f32 {
    i as f32 / (DEPTHS - 1) as f32
}

/// Reads all nodes, including those of coarser levels.
fn nodes(marched: &Marched) -> Vec<NodeData> {
    marched.curves().read((marched.curves().bytes() / 8) as usize).expect("read")
}

struct Made {
    world: World,
    opened: Opened<Marched>,
    settings: Settings,
    build: Build,
    place: Place,
    views: Vec<View>,
    /// One curve per texel.
    curves: Vec<Vec<NodeData>>,
}

/// Builds the technique, and reads its grid and curves.
fn made(context: &Context, scene: &Scene, text: &str) -> Made {
    let settings: Settings = spec(&format!("marched:{text}")).settings();
    let world = World::new(context, scene).expect("room for the scene");
    let technique = crate::support::opened(Marched::new(context, &world, &settings), text);
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect(text);
    let data = opened.technique.grid().data().expect("read");
    let place = Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size };
    let views: Vec<View> = opened.technique.inspect().maps().iter().map(|map| map.caster_view).collect();
    let (all, counts) = (nodes(&opened.technique), opened.technique.counts().expect("read"));
    let (side, tiles) = (settings.size as usize, settings.size.div_ceil(8) as usize);
    let curve = |texel: usize| {
        let (map, x, y) = (texel / (side * side), texel % side, texel / side % side);
        let is_met = counts[(map * tiles + y / 8) * tiles + x / 8] > 0;
        let own = &all[texel * settings.nodes as usize..][..settings.nodes as usize];
        own.iter().filter(|node| is_met && node.depth < FARTHEST).copied().collect()
    };
    let curves = (0..side * side * views.len()).map(curve).collect();
    let build = Build {
        nodes: settings.nodes as usize,
        work: settings.samples.max(settings.nodes) as usize,
        interpolation: Interpolation::Exponential,
        nudge: true,
        turns: 0,
    };
    Made { world, opened, settings, build, place, views, curves }
}

/// Returns a curve's transmittance at a depth.
fn look_up(curve: &[NodeData], depth: f32) -> f32 {
    let before = curve.iter().filter(|node| node.depth <= depth).count();
    let Some(near) = before.checked_sub(1).map(|i| curve[i]) else { return 1.0 };
    let far = curve[before.min(curve.len() - 1)];
    let along = if far.depth > near.depth { ((depth - near.depth) / (far.depth - near.depth)).min(1.0) } else { 0.0 };
    (-(near.value * (1.0 - along) + far.value * along)).exp()
}

/// Full voxels beside thin ones, spheres as small as points, and light along the grid's axes, so that rays run within voxel faces.
fn adversarial() -> Scene {
    let mut random = Random::new(91);
    let mut particles: Vec<_> = (0..60)
        .map(|i| Particle {
            position: random.point(-1.0, 1.0),
            radius: [0.3, 0.1, 1e-3, 0.02][i % 4],
            extinction: [0.2, 1e5, 3000.0, 20.0][i % 4],
        })
        .collect();
    particles.push(Particle { position: [0.0; 3], radius: 1.0, extinction: 1e-4 });
    scenes::directional("adversarial", [0.0, 0.0, -1.0], particles)
}

fn cases() -> Vec<Scene> {
    let far = |mut scene: Scene| {
        scene.particles.iter_mut().for_each(|p| p.position = p.position.map(|x| x + 1000.0));
        Scene { name: "far".into(), ..scene }
    };
    let cases = [
        scenes::random(),
        scenes::four_lights(),
        adversarial(),
        scenes::locks(),
        scenes::point([0.1, 0.2, 0.4], scenes::random()),
        far(scenes::random()),
        scenes::strands(),
        scenes::opaque(),
        scenes::inside(),
        scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::nested()),
    ];
    some(cases, 4)
}

/// Margin of a removal or a threshold within which rounding may decide.
const AMBIGUOUS: f32 = 1e-3;

#[test]
fn curves_equal_their_twin() {
    gpu_test("curves_equal_their_twin", |context| {
        for scene in cases() {
            for text in [
                "size=28,grid=64",
                "size=28,grid=64,nodes=4,samples=16,absolute=50",
                "size=20,grid=64,nodes=16,samples=32,relative=20",
            ] {
                let made = made(context, &scene, text);
                let media = Media::deposit(&scene.casters(), &made.place);
                let Settings { relative, absolute, size, .. } = made.settings;
                let errors = Errors { relative: relative as f32 / 1e4, absolute: absolute as f32 / 1e4 };
                let [mut near, mut unsure, mut covered] = [0, 0, 0];
                for (i, curve) in (0u32..).zip(&made.curves) {
                    let (map, at) = (i / (size * size), [i % size, i / size % size]);
                    let view = &made.views[map as usize];
                    let (twin, margin) = marched(&media, &made.place, view, at, made.build, errors);
                    let off: Vec<_> =
                        (0..DEPTHS).map(|i| (look_up(curve, depth(i)) - twin.transmittance(depth(i))).abs()).collect();
                    let mean = off.iter().sum::<f32>() / DEPTHS as f32;
                    let is_clear = margin.min(twin.margin) > AMBIGUOUS;
                    assert!(curve.len() <= made.build.nodes);
                    if twin.nodes().is_empty() && curve.is_empty() {
                        continue;
                    }
                    // The transmittance at the far end is the same, whichever node is removed; a ray within a voxel face may take either
                    // voxel.
                    unsure += usize::from(mean > if is_clear { 2e-4 } else { 2e-2 } || off[DEPTHS - 1] > 5e-4);
                    near += usize::from(mean <= 2e-4);
                    covered += 1;
                }
                println!("{} {text}: {near} near, {unsure} unsure of {covered}", scene.name);
                // If two removals cost the same, as for samples at a light's near plane, the curve is mostly the same either way.
                assert!(covered > 100 && near * 10 > covered * 9, "{} {text}: {near} near of {covered}", scene.name);
                assert!(unsure * 100 <= covered, "{} {text}: {unsure} unsure of {covered}", scene.name);
            }
        }
    });
}

/// Returns points on the rays of texels, at depths between `low` and `high`.
fn on_rays(view: &View, count: usize, [low, high]: [f32; 2]) -> Vec<[f32; 3]> {
    let mut random = Random::new(92);
    let mut point = |_| {
        let texel = [view.width, view.height].map(|side| f64::from(random.bits() % side) + 0.5);
        view.ray(texel.into()).at(view.z(f64::from(random.between(low, high)))).as_vec3().to_array()
    };
    (0..count).map(&mut point).collect()
}

/// On the rays of texels, look-ups converge to those of the marched density grid with more nodes and samples: the two differ only by the
/// compression of curves. Behind all casters they are equal from the start.
#[test]
fn more_samples_come_to_what_the_grid_says() {
    if crate::support::is_costly("more_samples_come_to_what_the_grid_says") {
        return;
    }
    gpu_test("more_samples_come_to_what_the_grid_says", |context| {
        let scenes = [scenes::random(), scenes::locks(), scenes::point([0.1, 0.2, 0.4], scenes::random())];
        for scene in some(scenes, 2) {
            let world = World::new(context, &scene).expect("room for the scene");
            let mut grid = open(context, &world, &spec("density-grid:size=64")).expect("opens");
            grid.build(&world).expect("built");
            let errors = [
                "nodes=4,samples=4",
                "nodes=8,samples=8",
                "nodes=8,samples=32,relative=50",
                "nodes=16,samples=32,relative=0",
            ]
            .map(|text| {
                let made = made(context, &scene, &format!("{text},size=32,grid=64"));
                let mut sums = [0.0, 0.0];
                for view in some(made.views.clone(), 2) {
                    let points = on_rays(&view, 3000, [0.0, 1.1]);
                    let expected = ask(context, grid.technique.as_ref(), 0, &points);
                    let found = ask(context, made.opened.technique.as_ref(), 0, &points);
                    for (i, (expected, found)) in expected.iter().zip(&found).enumerate() {
                        // Skips points near the edge of a face: a cube's faces overlap, and the other face's texel has another ray.
                        let offset = DVec3::from(points[i].map(f64::from));
                        if made.views.len() > 1 && (view.project(offset).0 - 16.0).abs().max_element() > 12.0 {
                            continue;
                        }
                        let (error, z) = (f64::from((expected - found).abs()), view.project(offset).1);
                        sums = [sums[0] + error, sums[1] + 1.0];
                        assert!(
                            z < f64::from(view.far) * 1.001 || error < 2e-3,
                            "{} {text}: {found}, not {expected} behind all",
                            scene.name
                        );
                    }
                }
                sums[0] / sums[1]
            });
            println!("{}: {errors:?}", scene.name);
            assert!(errors.is_sorted_by(|a, b| a >= b), "{}: {errors:?}", scene.name);
            assert!(errors[3] < 0.25 * errors[0] && errors[3] < 3e-3, "{}: {errors:?}", scene.name);
        }
        // Sixteen nodes represent a sphere of a few voxels exactly, except in the voxels at the ends of the range, which extend beyond it.
        let sphere = Particle { position: [0.2, 0.1, 0.3], radius: 0.07, extinction: 10.0 };
        let bounds = [-1.0, 1.0].map(|x| Particle { position: [x; 3], radius: 0.05, extinction: 1.0 });
        let mut scene = scenes::directional("few voxels", [0.3, 0.2, -0.9], vec![sphere]);
        scene.particles.extend(bounds);
        let made = made(context, &scene, "nodes=16,samples=32,relative=0,size=64,grid=64");
        let grid = crate::support::built(context, &scene, "density-grid:size=64");
        let points = on_rays(&made.views[0], 6000, [0.1, 0.9]);
        let (expected, found) =
            (ask(context, grid.as_ref(), 0, &points), ask(context, made.opened.technique.as_ref(), 0, &points));
        let mut shadowed = 0;
        for (expected, found) in expected.iter().zip(&found) {
            assert!((expected - found).abs() < 1e-3, "{found}, not {expected}");
            shadowed += usize::from(*expected < 0.9);
        }
        assert!(shadowed > 10, "{shadowed}");
    });
}

/// Neither the casters' order nor skipping empty tiles changes a bit of a look-up, and a second build gives the same curve.
#[test]
fn orders_and_skipping_change_nothing() {
    if crate::support::is_costly("orders_and_skipping_change_nothing") {
        return;
    }
    gpu_test("orders_and_skipping_change_nothing", |context| {
        let mut corner = scenes::random();
        corner.particles.iter_mut().for_each(|p| {
            p.position = p.position.map(|x| 0.1 * x);
            p.radius *= 0.1;
        });
        corner.particles.push(Particle { position: [2.0, 2.0, 2.0], radius: 0.1, extinction: 3.0 });
        for scene in [corner, scenes::four_lights()] {
            let text = "size=44,grid=64,levels=3";
            let first = made(context, &scene, text);
            let mut turned = scene.clone();
            turned.particles.reverse();
            let (again, whole) = (made(context, &turned, text), made(context, &scene, &format!("{text},skip=off")));
            for light in 0..scene.lights.len() {
                let points = gobo::reference::truth::space_points(&scene, light, 3000);
                let of = |made: &Made| {
                    let answers = ask(context, made.opened.technique.as_ref(), light, &points);
                    answers.into_iter().map(f32::to_bits).collect::<Vec<_>>()
                };
                assert!(of(&first) == of(&again), "{}: another order", scene.name);
                assert!(of(&first) == of(&whole), "{}: skipping", scene.name);
            }
            let empty = first.opened.technique.counts().expect("read").iter().filter(|count| **count == 0).count();
            assert!(empty > 0, "{}: no tile is empty", scene.name);
            let mut opened = first.opened;
            let before = nodes(&whole.opened.technique);
            opened.rebuild(&first.world).expect("built");
            let mut whole = whole;
            whole.opened.rebuild(&whole.world).expect("built");
            let bits =
                |nodes: &[NodeData]| nodes.iter().map(|n| [n.depth, n.value].map(f32::to_bits)).collect::<Vec<_>>();
            assert!(bits(&before) == bits(&nodes(&whole.opened.technique)), "{}: built twice", scene.name);
        }
    });
}

/// Each texel of the first coarser level equals the twin's merge of the four curves below it.
#[test]
fn levels_are_means() {
    gpu_test("levels_are_means", |context| {
        let scene = scenes::random();
        let made = made(context, &scene, "size=20,grid=64,levels=2,skip=off");
        let all = nodes(&made.opened.technique);
        let mut compared = 0;
        for texel in 0..100usize {
            let (x, y) = (texel % 10, texel / 10);
            let own: Vec<_> = all[(400 + texel) * 8..][..8].iter().filter(|n| n.depth < FARTHEST).copied().collect();
            let below = [0, 1, 2, 3].map(|i| &made.curves[(2 * y + i / 2) * 20 + 2 * x + i % 2]);
            let nodes = below.map(|curve| curve.iter().map(|n| (n.depth, n.value)).collect::<Vec<_>>());
            let twin = merged([0, 1, 2, 3].map(|i| &nodes[i][..]), made.build);
            let tail = below.iter().map(|curve| look_up(curve, 1.0)).sum::<f32>() / 4.0;
            assert!((look_up(&own, 1.0) - tail).abs() < 1e-4, "texel {x}, {y}");
            if twin.margin > AMBIGUOUS {
                let off = |i| (look_up(&own, depth(i)) - twin.transmittance(depth(i))).abs();
                let mean = (0..DEPTHS).map(off).sum::<f32>() / DEPTHS as f32;
                assert!(mean < 2e-4, "texel {x}, {y}: {mean} from the twin");
                compared += usize::from(!twin.nodes().is_empty());
            }
        }
        assert!(compared > 20, "{compared}");
    });
}

/// All lights share one grid; moving a light costs a march but no grid.
#[test]
fn lights_share_a_grid() {
    gpu_test("lights_share_a_grid", |context| {
        let passes = |scene: &Scene| {
            let world = World::new(context, scene).expect("room");
            let mut opened = open(context, &world, &spec("marched:size=16,grid=64")).expect("opens");
            let passes = opened.build(&world).expect("built").passes;
            let of = |start: &str| passes.iter().filter(|pass| pass.name.starts_with(start)).count();
            [of("grid."), of("marched.march")]
        };
        if context.features().timestamp_valid_bits == 0 {
            return crate::support::skipped("lights_share_a_grid", "the device has no timestamps");
        }
        let (one, four) = (passes(&scenes::random()), passes(&scenes::four_lights()));
        assert!(one[0] > 3 && one[1] == 1, "{one:?}");
        assert_eq!(one, four);
    });
}

/// Finer grids are nearer to the truth, in space and for every kind of light.
#[test]
fn finer_grids_are_nearer_to_the_truth() {
    if crate::support::is_costly("finer_grids_are_nearer_to_the_truth") {
        return;
    }
    gpu_test("finer_grids_are_nearer_to_the_truth", |context| {
        let scene = scenes::four_lights();
        let truth = Casters::new(&scene);
        let errors = [64, 128].map(|size| {
            let text = format!("marched:size=48,nodes=16,samples=32,grid={size}");
            let built = crate::support::built(context, &scene, &text);
            (0..scene.lights.len())
                .map(|light| {
                    let points = gobo::reference::truth::space_points(&scene, light, 1000);
                    let off = |(point, answer): (&[f32; 3], f32)| {
                        (f64::from(answer) - truth.visibility(light, DVec3::from(point.map(f64::from)))).abs()
                    };
                    points.iter().zip(ask(context, built.as_ref(), light, &points)).map(off).sum::<f64>() / 1000.0
                })
                .collect::<Vec<_>>()
        });
        println!("{errors:?}");
        for (light, (coarse, fine)) in errors[0].iter().zip(&errors[1]).enumerate() {
            assert!(fine < coarse && *coarse < 0.03, "light {light}: {fine}, not below {coarse}");
        }
    });
}

/// With meshes alone there is nothing to march, and their shadows stay sharp.
#[test]
fn meshes_alone_leave_empty_curves() {
    gpu_test("meshes_alone_leave_empty_curves", |context| {
        let meshes = vec![scenes::cuboid([-0.5; 3], [0.5; 3])];
        let scene = Scene { particles: Vec::new(), meshes, ..scenes::random() };
        let made = made(context, &scene, "size=16,grid=64");
        assert!(made.curves.iter().all(Vec::is_empty));
        let answers = ask(context, made.opened.technique.as_ref(), 0, &[[0.0, 0.0, 3.0], [0.0, 0.0, 0.0]]);
        assert_eq!(answers, [1.0, 0.0]);
    });
}

/// Builds a scene on the host alone, with its grid and view.
fn host(particles: &[([u8; 3], u8, u8)]) -> (Scene, Place, Media, View) {
    let number = |i: u8| f32::from(i) / 4.0 - 1.0;
    let one = |(at, radius, extinction): &([u8; 3], u8, u8)| Particle {
        position: at.map(number),
        radius: [0.4, 0.11, 0.03, 1e-3][usize::from(*radius)],
        extinction: [0.3, 2.0, 40.0, 1e5][usize::from(*extinction)],
    };
    let scene = scenes::directional("host", [0.5, 0.3, -0.81], particles.iter().map(one).collect());
    let corners = scene.casters().into_iter().flat_map(|c| [-c.radius, c.radius].map(|by| c.position.map(|p| p + by)));
    let place = Place::about(corners, 64);
    let media = Media::deposit(&scene.casters(), &place);
    let view = View::volumes(&scene, 12)[0];
    (scene, place, media, view)
}

fn particles() -> impl Strategy<Value = Vec<([u8; 3], u8, u8)>> {
    prop::collection::vec(([0u8..9, 0u8..9, 0u8..9], 0u8..4, prop_oneof![0u8..3, 0u8..4]), 1..40)
}

fn build(nodes: usize, work: usize) -> Build {
    Build { nodes, work, interpolation: Interpolation::Exponential, nudge: true, turns: 0 }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// With enough nodes for every sample, a curve that keeps all samples is the grid's exact march from the point to the light. A curve
    /// that drops each sample whose error is below a threshold is off by at most twice that threshold: once for an extrapolation, and once
    /// for the sample that ends a line.
    #[test]
    fn samples_are_as_near_as_their_thresholds(particles in particles(), texel in 0u32..144) {
        let (scene, place, media, view) = host(&particles);
        let at = [texel % 12, texel / 12];
        let all = marched(&media, &place, &view, at, build(4000, 4000), Errors { absolute: 0.0, relative: 0.0 }).0;
        let some = marched(&media, &place, &view, at, build(4000, 4000), Errors { absolute: 0.0, relative: 0.05 }).0;
        prop_assert!(some.nodes().len() <= all.nodes().len());
        let ray = view.ray(glam::DVec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5));
        for i in 0..40 {
            let depth = i as f32 / 32.0 + 0.01;
            let (from, way) = way(&place, &scene.lights[0], ray.at(view.z(depth.into())).as_vec3().to_array());
            let exact = (-media.march_exact(from, way)).exp();
            // A voxel with extinction 1e5 absorbs everything within the rounding error of a depth.
            let [before, behind] = [depth - 1e-4, depth + 1e-4].map(|depth| all.transmittance(depth));
            prop_assert!(behind - 2e-3 <= exact && exact <= before + 2e-3, "{depth}: {exact}, not {behind} to {before}");
            let [before, behind] = [depth - 1e-4, depth + 1e-4].map(|depth| some.transmittance(depth));
            prop_assert!(exact <= before * 1.11 + 2e-3 && behind * 0.9 - 2e-3 <= exact, "{depth}: {behind}, not {exact}");
        }
    }

    /// A dense ball at the near end of the range extends to a grid voxel in front of the range: what that voxel absorbs counts from the
    /// first depth on.
    #[test]
    fn what_is_in_front_of_the_range_counts_at_its_near_end(at in [0u8..9, 0u8..9, 7u8..9], texel in 0u32..144) {
        let (scene, place, media, view) = host(&[(at, 0, 2), ([4, 4, 0], 1, 0)]);
        let at = [texel % 12, texel / 12];
        let all = marched(&media, &place, &view, at, build(4000, 4000), Errors { absolute: 0.0, relative: 0.0 }).0;
        let ray = view.ray(glam::DVec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5));
        for depth in [1e-4, 0.002, 0.005, 0.01, 0.02] {
            let (from, way) = way(&place, &scene.lights[0], ray.at(view.z(depth.into())).as_vec3().to_array());
            let exact = (-media.march_exact(from, way)).exp();
            let found = all.transmittance(depth);
            prop_assert!((found - exact).abs() < 2e-3, "{depth}: {found}, not {exact}");
        }
    }

    /// Whichever nodes are removed: transmittance is in [0, 1] and never rises, and behind everything it equals the grid's.
    #[test]
    fn curves_fall_to_what_the_grid_says(
        particles in particles(),
        texel in 0u32..144,
        nodes in prop::sample::select(vec![4usize, 8, 16]),
        more in prop::sample::select(vec![0usize, 16]),
        absolute in prop::sample::select(vec![0.0f32, 0.01]),
        relative in prop::sample::select(vec![0.0f32, 0.05, 1.0]),
    ) {
        let (scene, place, media, view) = host(&particles);
        let at = [texel % 12, texel / 12];
        let curve = marched(&media, &place, &view, at, build(nodes, nodes + more), Errors { absolute, relative }).0;
        prop_assert!(curve.nodes().len() <= nodes);
        prop_assert!(curve.nodes().iter().all(|(depth, value)| (0.0..=1.0).contains(depth) && *value >= 0.0));
        let mut last = 1.0f32;
        for i in 0..=64 {
            let through = curve.transmittance(i as f32 / 64.0);
            prop_assert!((0.0..=1.0).contains(&through) && through <= last + 1e-6, "{through} behind {last}");
            last = through;
        }
        let ray = view.ray(glam::DVec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5));
        let (from, way) = way(&place, &scene.lights[0], ray.at(view.z(3.0)).as_vec3().to_array());
        let exact = (-media.march_exact(from, way)).exp();
        prop_assert!((last - exact).abs() < 1e-3, "{last} behind all, not {exact}");
    }
}
