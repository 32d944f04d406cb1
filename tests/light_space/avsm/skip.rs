//! Skipping loses nothing: `skip=off` builds everything and gives the same look-ups.

use crate::support::{self, ask, built_avsm, gpu_test, runs, scenes, some, spec};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::{Casters, space_points};
use gobo::reference::twin::bins::{TILE_TEXELS, horizon};
use gobo::scene::{LightKind, Particle, Scene};
use gobo::technique::{Avsm, Opened, Technique};
use gobo::world::World;

/// Returns every path that the device supports.
fn paths(context: &Context) -> Vec<&'static str> {
    let has = |r| context.features().lacks(r).is_none();
    let mut paths = vec!["path=two-pass", "path=binned,resolve=cells", "path=binned,resolve=streaming"];
    paths.extend(has(Requirement::PixelInterlock).then_some("path=interlock"));
    paths.extend(has(Requirement::RasterOrder).then_some("path=raster-order"));
    paths.retain(|path| runs("skip", context, &format!("avsm:{path}")));
    paths
}

/// Opens the technique for `world`. If the spec says so, it is not built again for an unchanged world.
fn opened(context: &Context, world: &World, text: &str) -> Opened<Avsm> {
    let spec = spec(text);
    let avsm = support::opened(Avsm::new(context, world, &spec.settings()), text);
    Opened::new(context, Box::new(avsm), spec.skips())
}

/// Returns points in and around the casters.
fn points() -> Vec<[f32; 3]> {
    let mut random = scenes::Random::new(77);
    (0..4000).map(|_| random.point(-1.6, 1.6)).collect()
}

/// Without meshes nothing is hidden, and every look-up gives the same bytes. A cone of 12° sees part of the casters.
#[test]
fn skipping_changes_no_answer() {
    if crate::support::is_costly("skipping_changes_no_answer") {
        return;
    }
    gpu_test("skipping_changes_no_answer", |context| {
        let cases = [
            scenes::spot([0.0, 0.5, 4.0], 12.0, scenes::random()),
            scenes::strands(),
            scenes::random(),
            scenes::point([0.2, 0.1, 0.0], scenes::opaque()),
        ];
        for scene in some(cases, 2) {
            for path in paths(context) {
                // A wider filter reaches farther; testing it on one path suffices.
                let filters = if path == "path=two-pass" { &["bilinear", "box"][..] } else { &["bilinear"] };
                for filter in filters {
                    let answers = |skip: &str| {
                        let text = format!("avsm:{path},size=40,filter={filter},skip={skip}");
                        let avsm = built_avsm(context, &scene, &text);
                        let counters = avsm.inspect().facts().expect("counted").counters;
                        (ask(context, avsm.as_ref(), 0, &points()), counters)
                    };
                    let ((all, _), (skipped, counters)) = (answers("off"), answers("on"));
                    assert!(all == skipped, "{} {path} {filter}", scene.name);
                    // A directional light's volume is fitted to all casters; a cone or a cube face leaves some out.
                    let fitted = matches!(scene.lights[0].kind, LightKind::Directional { .. });
                    assert!(fitted || counters["culled_casters"] > 0, "{} {path}", scene.name);
                }
            }
        }
    });
}

/// An unchanged scene is not built again.
#[test]
fn an_unchanged_scene_takes_no_pass() {
    gpu_test("an_unchanged_scene_takes_no_pass", |context| {
        let world = World::new(context, &scenes::nested()).expect("room for the scene");
        let timed = context.features().timestamp_valid_bits > 0;
        for path in paths(context) {
            let mut avsm = opened(context, &world, &format!("avsm:{path},size=16"));
            assert_eq!(avsm.build(&world).expect("built").passes.is_empty(), !timed, "{path}");
            assert_eq!(avsm.build(&world).expect("nothing to do").passes.len(), 0, "{path}");
            assert_eq!(avsm.rebuild(&world).expect("built").passes.is_empty(), !timed, "{path}");
            let mut eager = opened(context, &world, &format!("avsm:{path},size=16,skip=off"));
            eager.build(&world).expect("built");
            assert_eq!(eager.build(&world).expect("built again").passes.is_empty(), !timed, "{path}");
        }
    });
}

/// Spheres above and below a plate that extends past all of them.
fn over_and_under_a_plate() -> Scene {
    let mut random = scenes::Random::new(9);
    let particles = (0..120)
        .map(|i| {
            let [x, y, z] = random.point(0.3, 1.2);
            let sign = |bit: u32| if random_sign(i, bit) { 1.0 } else { -1.0 };
            Particle { position: [x * sign(0), y * sign(1), z * sign(2)], radius: 0.2, extinction: 1.0 }
        })
        .collect();
    let mut scene = scenes::directional("plate", [0.1, 0.05, -1.0], particles);
    scene.meshes.push(scenes::level(0.0, 4.0, [0.0, 0.0]));
    scene
}

fn random_sign(i: u32, bit: u32) -> bool {
    (i >> bit) & 1 == 1
}

/// Exactly the casters in the dark behind a mesh are culled, and look-ups in the lit part are at least as accurate.
#[test]
fn casters_in_the_dark_are_culled() {
    gpu_test("casters_in_the_dark_are_culled", |context| {
        let scene = over_and_under_a_plate();
        let below = scene.particles.iter().filter(|p| p.position[2] < 0.0).count() as u64;
        let casters = Casters::new(&scene);
        let points = space_points(&scene, 0, 4096);
        let truth: Vec<f64> =
            points.iter().map(|p| casters.visibility(0, glam::DVec3::from(p.map(f64::from)))).collect();
        for path in paths(context) {
            let error = |skip: &str| {
                let avsm = built_avsm(context, &scene, &format!("avsm:{path},size=64,skip={skip}"));
                let counters = avsm.inspect().facts().expect("counted").counters;
                if skip == "on" {
                    assert_eq!(counters["culled_casters"], below, "{path}");
                }
                let all = ask(context, avsm.as_ref(), 0, &points);
                all.iter().zip(&truth).map(|(a, t)| (f64::from(*a) - t).abs()).sum::<f64>() / truth.len() as f64
            };
            let (all, skipped) = (error("off"), error("on"));
            println!("{path}: space error {all:.6} with all casters, {skipped:.6} without those in the dark");
            // With fewer segments to compress, the error is no larger, up to a tolerance for a different choice of removed nodes.
            assert!(skipped <= all + 1e-4, "{path}: {skipped}, {all} with all casters");
        }
    });
}

/// The horizon of each tile equals its twin's: bit for bit where light passes, and up to rounding where it ends.
#[test]
fn the_horizon_equals_its_twin() {
    gpu_test("the_horizon_equals_its_twin", |context| {
        let mut slanted = over_and_under_a_plate();
        slanted.meshes = vec![
            scenes::quad([[-0.5, -0.6, 0.3], [0.7, -0.4, -0.2], [0.6, 0.8, 0.1], [-0.4, 0.5, 0.5]], 0.5),
            scenes::level(-0.9, 0.7, [0.3, 0.3]),
        ];
        for scene in [slanted.clone(), scenes::spot([0.5, 0.2, 4.0], 40.0, slanted.clone()), over_and_under_a_plate()] {
            for (size, filter, reach) in [(40u32, "bilinear", 1), (64, "box,radius=3", 4)] {
                let text = format!("avsm:path=binned,size={size},filter={filter}");
                let avsm = built_avsm(context, &scene, &text);
                let map = avsm.inspect().maps()[0];
                let opaque: Vec<f32> = avsm.opaque_image().read().expect("the opaque map");
                let bins = avsm.bins().expect("binned");
                let tiles = size.div_ceil(TILE_TEXELS);
                let all: Vec<f32> = bins.horizon().read((tiles * tiles) as usize).expect("the horizon");
                let mut ends = 0;
                for (place, found) in (0u32..).zip(&all) {
                    let tile = [place % tiles, place / tiles];
                    let twin = horizon(&map.caster_view, &map.opaque, &opaque, tile, reach);
                    let close = (twin - found).abs() <= 1e-5 * (map.opaque.far - map.opaque.near);
                    assert!(twin == *found || close, "{} {text} {tile:?}: {found}, the twin has {twin}", scene.name);
                    ends += u32::from(twin < 1e30);
                }
                assert!(ends > 0, "{} {text}: light goes on everywhere", scene.name);
            }
        }
    });
}
