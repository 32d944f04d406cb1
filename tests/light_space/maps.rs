//! Shared parts of all techniques with maps: fitting the views on the device, and the order in which single-pass insertion draws casters.

use crate::support::scenes::{self, Random};
use crate::support::{all, gpu_test, ran, some};
use glam::{DVec3, Vec3};
use gobo::gpu::Context;
use gobo::maps::{Extents, Map, Maps, NearToFar, OPAQUE_SIZE, OpaqueMaps, Order, Ranking};
use gobo::reference::twin::{fit, order};
use gobo::scene::{Caster, Casting, Particle, Projection, Scene, View};
use gobo::world::World;
use proptest::prelude::*;

fn world(context: &Context, scene: &Scene) -> World {
    World::new(context, scene).expect("room for the scene")
}

/// Returns the maps that the device fits.
fn fitted(context: &Context, scene: &Scene, size: u32) -> Vec<Map> {
    let world = world(context, scene);
    let mut maps = Maps::new(context, &world, size, OpaqueMaps::SHARED).expect("room");
    let frame = ran(context, |commands| maps.record(commands, &world).expect("its lights"));
    maps.settle(frame, false).expect("read");
    maps.all().to_vec()
}

/// Scenes of all kinds, two of them moved far from the origin, where floats are coarse.
fn cases() -> Vec<Scene> {
    let away = |mut scene: Scene, by: [f32; 3]| {
        scene.name += " away";
        let moved = |p: [f32; 3]| [0, 1, 2].map(|i| p[i] + by[i]);
        scene.particles.iter_mut().for_each(|p| p.position = moved(p.position));
        scene.meshes.iter_mut().flat_map(|m| &mut m.positions).for_each(|p| *p = moved(*p));
        scene
    };
    let mut plates = scenes::nested();
    plates.particles.clear();
    plates.meshes.push(scenes::level(-1.0, 2.0, [0.3, -0.2]));
    let mut one = scenes::nested();
    one.particles.truncate(1);
    let mut nothing = one.clone();
    nothing.particles.clear();
    let cases = [
        scenes::inside(),
        scenes::random(),
        scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random()),
        scenes::strands(),
        plates,
        one,
        nothing,
        away(scenes::random(), [1e4, -3e4, 2e5]),
        scenes::opaque(),
        away(scenes::crowd(), [-7e5, 1e3, 0.0]),
    ];
    some(cases, 8)
}

fn vertices(scene: &Scene) -> Vec<[f32; 3]> {
    let of = |m: &gobo::scene::Mesh| -> Vec<[f32; 3]> {
        m.triangles.iter().flatten().map(|i| m.positions[*i as usize]).collect()
    };
    scene.meshes.iter().flat_map(of).collect()
}

/// Returns the twin's maps.
fn twins(scene: &Scene, size: u32) -> Vec<[View; 2]> {
    let (casters, vertices) = (scene.casters(), vertices(scene));
    let twin = |map: Map| {
        let bounds = fit::bounds([&map.caster_view, &map.opaque], &casters, &vertices);
        fit::fit([map.caster_view, map.opaque], bounds, casters.is_empty())
    };
    Map::aimed(&scene.aim(), size, OPAQUE_SIZE, 1).into_iter().map(twin).collect()
}

/// Returns how far apart two views of the same map are, relative to their size plus the spacing of floats at their position.
fn apart(a: &View, b: &View) -> f64 {
    assert_eq!((a.projection, a.right, a.up, a.forward), (b.projection, b.right, b.up, b.forward));
    let extent = f64::from(a.far).max(1.0 / f64::from(a.scale_x)).max(1.0 / f64::from(a.scale_y));
    let at = Vec3::from(a.origin).as_dvec3();
    let resolved = extent + at.length();
    let shares = [
        (at - Vec3::from(b.origin).as_dvec3()).length() / resolved,
        f64::from(a.scale_x / b.scale_x - 1.0).abs() * extent / resolved,
        f64::from(a.scale_y / b.scale_y - 1.0).abs() * extent / resolved,
        f64::from(a.near - b.near).abs() / resolved,
        f64::from(a.far - b.far).abs() / resolved,
    ];
    shares.into_iter().fold(0.0, f64::max)
}

/// Some ten roundings of numbers as large as the distance from the origin plus the size.
const ROUNDINGS: f64 = 10.0 * f32::EPSILON as f64;

/// Each cascade equals the twin's: the widest map narrowed to the space in front of the camera.
#[test]
fn cascades_equal_their_twin() {
    gpu_test("cascades_equal_their_twin", |context| {
        let mut scene = scenes::directional("cascades", [0.4, 0.3, -0.8], Vec::new());
        scene.meshes.push(scenes::level(0.0, 5.0, [0.0, 0.0]));
        for position in [DVec3::new(3.0, -2.0, 1.5), DVec3::new(0.1, 0.2, 0.3), DVec3::new(-40.0, 90.0, 7.0)] {
            scene.camera.position = position;
            let world = world(context, &scene);
            let opaque = OpaqueMaps { size: 64, cascades: 3, ..OpaqueMaps::SHARED };
            let mut maps = Maps::with_opaque(context, &world, 64, opaque).expect("room");
            let frame = ran(context, |commands| maps.record(commands, &world).expect("recorded"));
            maps.settle(frame, false).expect("read");
            let ahead = (scene.camera.target - position).normalize().as_vec3();
            let views: Vec<View> = maps.all().iter().map(|map| map.opaque).collect();
            assert_eq!(views.len(), 3);
            for cascade in [1, 2] {
                let twin = fit::narrow(views[0], cascade, position.as_vec3(), ahead);
                let by = apart(&views[cascade as usize], &twin);
                assert!(by < ROUNDINGS, "cascade {cascade} from {position}: {by}");
                assert!(twin.scale_x > 1.9 * views[cascade as usize - 1].scale_x, "it is no narrower");
            }
        }
    });
}

/// The device's fit equals its twin's, and both equal the f64 fit, up to rounding.
#[test]
fn fit_equals_its_twin() {
    gpu_test("fit_equals_its_twin", |context| {
        for scene in cases() {
            let f64s = View::volumes(&scene, 24)
                .into_iter()
                .zip(View::opaques(&scene, if scene.has_triangles() { 1024 } else { 1 }));
            for (map, ((device, twin), (volume, opaque))) in
                fitted(context, &scene, 24).iter().zip(twins(&scene, 24)).zip(f64s).enumerate()
            {
                for (device, twin, truth) in [(device.caster_view, twin[0], volume), (device.opaque, twin[1], opaque)] {
                    let (by_twin, by_truth) = (apart(&device, &twin), apart(&device, &truth));
                    assert!(by_twin <= ROUNDINGS, "{}, map {map}: {by_twin}\n{device:?}\n{twin:?}", scene.name);
                    assert!(by_truth <= ROUNDINGS, "{}, map {map}: {by_truth}\n{device:?}\n{truth:?}", scene.name);
                }
            }
        }
    });
}

/// Returns how far a sphere extends outside the view, in texels across or as a share of the depth range.
fn outside(view: &View, centre: DVec3, radius: f64) -> f64 {
    let (_, z) = view.project(centre);
    let depths = [view.depth(z - radius), view.depth(z + radius)];
    let mut most = (-depths[0]).max(depths[1] - 1.0);
    if view.projection() == Projection::Parallel {
        for axis in [view.right, view.up] {
            for side in [-radius, radius] {
                let (texel, _) = view.project(centre + side * Vec3::from(axis).as_dvec3());
                most = most.max(-texel.min_element()).max(texel.max_element() - f64::from(view.width));
            }
        }
    }
    most
}

/// Every caster lies within every directional light's view, wherever the scene is: casters outside the map would lose their shadow.
#[test]
fn the_fit_holds_all_casters() {
    gpu_test("the_fit_holds_all_casters", |context| {
        for scene in cases() {
            for map in fitted(context, &scene, 64).iter().filter(|m| m.caster_view.projection() == Projection::Parallel)
            {
                for caster in scene.casters() {
                    for end in [caster.start(), caster.end()] {
                        let out = outside(&map.caster_view, end, caster.radius.into());
                        assert!(out <= 1e-6, "{}: {out} outside {:?}", scene.name, map.caster_view);
                    }
                }
            }
        }
    });
}

#[test]
fn no_extents_are_none() {
    let none = fit::Range::NONE;
    assert!(Extents::NONE.low.iter().all(|l| order::float_order(none.low.x) < *l));
    assert!(Extents::NONE.high.iter().all(|h| order::float_order(none.high.x) > *h));
    let view = View::aimed(&scenes::nested().aim(), 8, Casting::Volume)[0];
    assert_eq!(fit::bounds([&view; 2], &[], &[]), [none, none]);
}

/// Sorts these keys, each list separately.
fn sorted(context: &Context, keys: &[Vec<u32>], ranking: Ranking) -> Vec<Vec<u32>> {
    let (lists, count) = (keys.len(), keys[0].len());
    let order = Order::ranked(context, count as u32, lists as u32, ranking).expect("room");
    let items: Vec<[u32; 2]> = keys.iter().flat_map(|k| k.iter().zip(0..).map(|(k, i)| [*k, i])).collect();
    order.items.write(&items).expect("written");
    context.submit(|commands| order.sort(commands, count as u32)).expect("sorted");
    let sorted: Vec<u32> = order.sorted.read(lists * count).expect("read");
    sorted.chunks_exact(count).map(<[u32]>::to_vec).collect()
}

/// The device's order equals the twin's for random keys, few distinct ones, equal ones, rising and falling ones; for counts that end within
/// a block, at its end and past it; and for several maps at once.
#[test]
fn order_equals_its_twin() {
    gpu_test("order_equals_its_twin", |context| {
        let mut random = Random::new(7);
        for count in some([1, 2, 127, 129, 1023, 1024, 1025, 5000, 40_000, 300_000], if all() { 10 } else { 8 }) {
            let n = count as u32;
            let keys: [Vec<u32>; 5] = [
                (0..n).map(|_| random.between(0.0, 1e3).to_bits() ^ 0x8000_0000).collect(),
                (0..n).map(|_| random.between(0.0, 3.0) as u32 * 0x0101_0101).collect(),
                vec![u32::MAX; count],
                (0..n).collect(),
                (0..n).rev().map(|i| i << 12).collect(),
            ];
            for ranking in [Ranking::Serial, Ranking::Shared, Ranking::Ballots] {
                if ranking == Ranking::Ballots && context.features().lacks_full_subgroups(128).is_some() {
                    continue;
                }
                for (which, (sorted, keys)) in sorted(context, &keys, ranking).into_iter().zip(&keys).enumerate() {
                    assert!(sorted == order::sort(keys), "{count} keys, list {which}, {ranking:?}");
                }
            }
        }
    });
}

/// Casters are drawn by rising depth of their nearest points, ties by index, in every map and after the world has moved.
#[test]
fn casters_are_drawn_near_to_far() {
    gpu_test("casters_are_drawn_near_to_far", |context| {
        for scene in [scenes::inside(), scenes::strands(), scenes::duplicates(), scenes::random()] {
            let mut world = world(context, &scene);
            let mut maps = Maps::new(context, &world, 16, OpaqueMaps::SHARED).expect("room");
            let near_to_far = NearToFar::new(context, &world, &maps).expect("room");
            let mut fewer = scene.clone();
            fewer.particles.truncate(scene.particles.len() / 2);
            for state in [scene.clone(), fewer] {
                world.replace(&state).expect("as many or fewer");
                let run = |commands: &mut gobo::gpu::Commands| {
                    maps.record(commands, &world).expect("its lights");
                    near_to_far.record(commands, &world);
                };
                let frame = ran(context, run);
                maps.settle(frame, false).expect("read");
                let (casters, room) = (state.casters(), world.caster_capacity() as usize);
                let all: Vec<u32> = near_to_far.order.sorted.read(room * maps.count() as usize).expect("read");
                for (map, sorted) in maps.all().iter().zip(all.chunks_exact(room)) {
                    are_near_to_far(&state.name, &map.caster_view, &casters, &sorted[..casters.len()]);
                }
            }
        }
    });
}

fn are_near_to_far(name: &str, view: &View, casters: &[Caster], sorted: &[u32]) {
    let mut seen = sorted.to_vec();
    seen.sort_unstable();
    assert!(seen.into_iter().eq(0..casters.len() as u32), "{name}: each once");
    let keys = order::keys(view, casters);
    let size = casters.iter().fold(0.0f32, |m, c| m.max((Vec3::from(c.position) - Vec3::from(view.origin)).length()));
    for pair in sorted.windows(2) {
        let [a, b] = [keys[pair[0] as usize], keys[pair[1] as usize]];
        assert!(a <= b + 8.0 * f32::EPSILON * size, "{name}: {a} comes before {b}");
        let alike = casters[pair[0] as usize] == casters[pair[1] as usize];
        assert!(!alike || pair[0] < pair[1], "{name}: {pair:?} are alike");
    }
}

/// The host gets the views that the device fitted once the frame is settled, and not before.
#[test]
fn the_host_has_what_the_device_fitted() {
    gpu_test("the_host_has_what_the_device_fitted", |context| {
        let scene = scenes::inside();
        let world = world(context, &scene);
        let mut maps = Maps::new(context, &world, 16, OpaqueMaps::SHARED).expect("room");
        let before = maps.all().to_vec();
        let frame = ran(context, |commands| maps.record(commands, &world).expect("its lights"));
        assert_eq!(maps.all(), before, "not before it is settled");
        maps.settle(frame, false).expect("read");
        assert_ne!(maps.all(), before);
    });
}

proptest! {
    /// The twin's fit contains random spheres, however far from the origin, to a fraction of a texel.
    #[test]
    fn the_twin_holds_random_spheres(
        spheres in prop::collection::vec((prop::array::uniform3(-5.0f32..5.0), 0.001f32..2.0), 1..20),
        far in prop::array::uniform3(-1e5f32..1e5),
        direction in prop::array::uniform3(-1.0f32..1.0),
    ) {
        prop_assume!(direction.iter().any(|d| d.abs() > 0.1));
        let particle = |(p, radius): &([f32; 3], f32)| {
            Particle { position: [0, 1, 2].map(|i| p[i] + far[i]), radius: *radius, extinction: 1.0 }
        };
        let scene = scenes::directional("random", direction.map(f64::from), spheres.iter().map(particle).collect());
        let view = twins(&scene, 64)[0][0];
        for caster in scene.casters() {
            prop_assert!(outside(&view, caster.start(), caster.radius.into()) <= 1e-6);
        }
    }
}
