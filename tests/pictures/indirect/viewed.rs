//! Virtual lights that follow the camera: their weights against the twin, and the effect.

use super::{cases, facets, lit, patches};
use crate::indirect::scenes::level;
use crate::support::{self, gpu_test};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::lights::indirect::{POINTS_ACROSS, ViewSeen, Vpls, VplsBy, VplsSeen, lit_by_vpls};
use gobo::reference::truth::Casters;
use gobo::reference::twin::indirect::{ViewPoint, importance, light, luminance, place, unit, view_point, weight};
use gobo::scene::{Camera, Light, LightKind, Mesh, Scene, View};
use gobo::world::World;

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, [16, 9])
}

fn made(context: &Context, scene: &Scene, count: u32) -> Vpls {
    let world = World::new(context, scene).expect("room for the scene");
    let mut vpls = support::opened(Vpls::by_view(context, &world, count, &camera(scene)), &scene.name);
    vpls.make(&world).expect("made");
    vpls
}

/// Returns the twin's view points, from the triangle numbers that the device saw.
fn points(scene: &Scene, view: &ViewSeen) -> Vec<ViewPoint> {
    let (facets, camera) = (facets(scene), camera(scene));
    let of = |i: usize| {
        let at = [i as u32 % POINTS_ACROSS, i as u32 / POINTS_ACROSS];
        Some(view_point(&camera, POINTS_ACROSS, facets.get((view.numbers[i] as usize).checked_sub(1)?)?, at))
    };
    (0..view.numbers.len()).filter_map(of).collect()
}

fn is_near(device: f32, twin: f64) -> bool {
    (f64::from(device) - twin).abs() <= 1e-3 * twin.abs().max(1e-30)
}

/// Asserts that the camera's triangle numbers are those of the nearest meshes in f64.
fn assert_numbers(scene: &Scene, view: &ViewSeen) {
    let (casters, facets) = (Casters::new(scene), facets(scene));
    let seen_by = View { width: POINTS_ACROSS, height: POINTS_ACROSS, ..camera(scene) };
    let mut off = 0;
    for (i, number) in view.numbers.iter().enumerate() {
        let at = [i as u32 % POINTS_ACROSS, i as u32 / POINTS_ACROSS].map(|at| f64::from(at) + 0.5);
        let ray = seen_by.ray(at.into());
        let hit = casters.meshes.hit(ray.origin, ray.direction);
        let shown = (*number as usize).checked_sub(1).and_then(|i| facets.get(i));
        off += usize::from(hit.map(|hit| hit.albedo) != shown.map(|facet| facet.albedo.as_vec3().to_array()));
    }
    // The rasterizer decides at edges.
    assert!(off <= 6, "{}: {off} of {}", scene.name, view.numbers.len());
}

fn share(seen: &VplsSeen) -> f64 {
    let [low, high] = *seen.starts.last().expect("all");
    let most = f32::from_bits(seen.greatest);
    (f64::from(high) * 2f64.powi(32) + f64::from(low)) * f64::from(unit(most)) / seen.picks.len() as f64
}

#[test]
fn weights_and_lights_equal_their_twin() {
    gpu_test("viewed::weights_and_lights_equal_their_twin", |context| {
        for scene in cases().into_iter().take(2) {
            let vpls = made(context, &scene, 256);
            let seen = vpls.seen().expect("read");
            let view = seen.view.as_ref().expect("by view");
            assert_numbers(&scene, view);
            let (points, patches) = (points(&scene, view), patches(&scene, &seen));
            let data: Vec<_> = view.points.iter().filter(|point| point.weight > 0.0).collect();
            assert!(data.len() > 100 && data.len() == points.len(), "{} of {}", data.len(), points.len());
            for (device, twin) in data.iter().zip(&points) {
                let position = DVec3::from(device.position.map(f64::from));
                assert!(position.distance(twin.position) < 1e-4, "{device:?}: {}", twin.position);
                assert!(DVec3::from(device.normal.map(f64::from)).dot(twin.normal) > 0.999_99);
                assert!(is_near(device.area, twin.area) && is_near(device.weight, twin.weight), "{device:?}");
                assert_eq!(device.is_open == 1, twin.is_open);
            }
            let importances: Vec<f64> =
                patches.iter().map(|patch| patch.as_ref().map_or(0.0, |patch| importance(patch, &points))).collect();
            let flux = |i: usize| patches[i].as_ref().map_or(0.0, |patch| luminance(patch.flux));
            let [all, weighed] = (0..patches.len())
                .fold([0.0, 0.0], |[all, weighed], i| [all + flux(i), weighed + flux(i) * importances[i]]);
            let mean = weighed / all;
            assert!((f64::from(view.mean) / mean - 1.0).abs() < 1e-3, "{} {mean}", view.mean);
            let (mut off, mut lit) = (0, 0);
            for i in (0..patches.len()).filter(|i| flux(*i) > 0.0) {
                lit += 1;
                let is = is_near(view.importances[i], importances[i])
                    && is_near(seen.fluxes[i], weight(flux(i), importances[i], mean));
                // Weights may differ at the edge of a light's cone or cube face, or if a point is in a patch's plane.
                off += usize::from(!is);
            }
            println!("{}: {off} of {lit} lit texels differ", scene.name);
            assert!(lit > 2000 && off * 500 < lit, "{}: {off} of {lit}", scene.name);
            assert_eq!(seen.greatest, seen.fluxes.iter().fold(0.0f32, |most, flux| most.max(*flux)).to_bits());
            for (pick, made) in seen.picks.iter().zip(vpls.read().expect("read")) {
                let patch = patches[*pick as usize].as_ref().expect("it has flux");
                let origin = DVec3::from(seen.maps[place(*pick, seen.side_bits).0].opaque.origin.map(f64::from));
                let twin = light(patch, origin, f64::from(seen.fluxes[*pick as usize]), share(&seen));
                for (twin, made) in twin.radiance.iter().zip(made.radiance) {
                    assert!(is_near(made, f64::from(*twin)), "{}: {twin} {made}", scene.name);
                }
                let nearest = |light: &Light| match light.kind {
                    LightKind::Virtual { nearest, .. } => nearest,
                    _ => panic!("{light:?}"),
                };
                assert!((nearest(&twin) / nearest(&made) - 1.0).abs() < 1e-3);
            }
        }
    });
}

/// If the camera sees no mesh, virtual lights are exactly those chosen by flux alone, to the bit.
#[test]
fn without_a_view_flux_decides() {
    gpu_test("viewed::without_a_view_flux_decides", |context| {
        let mut cornell = Scene::load("cornell", 0.0).expect("built in");
        cornell.camera.target = 2.0 * cornell.camera.position - cornell.camera.target;
        let [by_flux, by_view] =
            [VplsBy::Flux, VplsBy::View].map(|by| lit_by_vpls(context, &cornell, 64, by).expect("lit"));
        assert_eq!(by_flux.lights, by_view.lights);
        assert_eq!(by_view.name, "cornell-64-vpls-by-view");
    });
}

/// A wall that the camera looks at, with ground in front of it; and the same area of ground behind the wall, raised so that it faces away
/// from the wall and the camera.
fn wall() -> Scene {
    let upright = |x: f32| {
        let corners = [[x, -1.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 2.0], [x, -1.0, 2.0]];
        Mesh { albedo: [0.5; 3], ..crate::indirect::scenes::quad(corners, 0.0) }
    };
    let ground = |x: f64| Mesh { albedo: [0.8, 0.2, 0.1], ..level(0.0, 1.0, [x as f32, 0.0]) };
    let down = LightKind::Directional { direction: DVec3::NEG_Z };
    let mut above = ground(9.0);
    above.positions.iter_mut().for_each(|p| p[2] = 5.0);
    Scene {
        camera: Camera {
            position: DVec3::new(-6.0, 0.0, 1.0),
            target: DVec3::new(0.0, 0.0, 1.0),
            up: DVec3::Z,
            fov_y_degrees: 15.0,
        },
        ..lit("wall", vec![upright(0.0), ground(-1.1), above], &[down])
    }
}

/// Half of the flux leaves ground that faces nothing visible. That ground gets only the lights that are drawn by flux alone: an eighth of
/// all lights, each four times as bright as if all were drawn by flux. The light arriving at the wall is the same either way, but less
/// noisy if lights are drawn by view.
#[test]
fn lights_are_where_they_are_seen() {
    gpu_test("viewed::lights_are_where_they_are_seen", |context| {
        let scene = wall();
        let lights = |count: u32, by: VplsBy| lit_by_vpls(context, &scene, count, by).expect("lit").lights;
        let x = |light: &Light| match light.kind {
            LightKind::Virtual { position, .. } => position.x,
            _ => panic!("{light:?}"),
        };
        let far = |lights: &[Light]| lights.iter().filter(|light| x(light) > 0.0).count();
        let sum = |lights: &[Light], far: bool| -> f64 {
            lights.iter().filter(|light| (x(light) > 0.0) == far).map(|light| f64::from(light.radiance[0])).sum()
        };
        let [flux, view] = [VplsBy::Flux, VplsBy::View].map(|by| lights(1024, by));
        println!("{} and {} of 1,024 are far", far(&flux), far(&view));
        assert!(far(&flux).abs_diff(512) <= 8 && far(&view).abs_diff(128) <= 8);
        for is_far in [false, true] {
            let ratio = sum(&view, is_far) / sum(&flux, is_far);
            assert!((ratio - 1.0).abs() < 0.05, "{ratio} of all light, far: {is_far}");
        }
        // Light arriving at points of the wall, without shadows: from many lights, and from few.
        let at = |lights: &[Light]| -> Vec<f64> {
            let place = |i: usize| DVec3::new(0.0, (i % 12) as f64 / 6.0 - 0.92, (i / 12) as f64 / 6.0 + 0.08);
            let arriving = |place: DVec3| {
                let of = |light: &Light| light.falloff(place) * light.towards(place).dot(DVec3::NEG_X).max(0.0);
                lights.iter().map(|light| of(light) * f64::from(light.radiance[0])).sum()
            };
            (0..144).map(place).map(arriving).collect()
        };
        let truth = at(&lights(4096, VplsBy::Flux));
        let error = |lights: &[Light]| {
            let squares: f64 = at(lights).iter().zip(&truth).map(|(is, truth)| (is / truth - 1.0).powi(2)).sum();
            (squares / 144.0).sqrt()
        };
        assert!(error(&lights(4096, VplsBy::View)) < 0.02, "{}", error(&lights(4096, VplsBy::View)));
        let mean = |by: VplsBy| (0..8).map(|i| error(&lights(64 + 16 * i, by))).sum::<f64>() / 8.0;
        let [flux, view] = [VplsBy::Flux, VplsBy::View].map(mean);
        println!("few lights err by {flux:.4} by flux, {view:.4} by view");
        assert!(view < flux, "{view} {flux}");
    });
}

/// The virtual lights' total equals the patches' total, as closely as the weights allow: for lights drawn at random, a channel's standard
/// error would be the spread of flux over weight.
#[test]
fn light_is_kept_on_average() {
    gpu_test("viewed::light_is_kept_on_average", |context| {
        let mut scene = Scene::load("cornell", 0.0).expect("built in");
        let patches = patches(&scene, &super::made(context, &scene, 64).seen().expect("read"));
        let flux: DVec3 = patches.iter().flatten().map(|patch| patch.flux).sum();
        let first = scene.camera;
        let world = World::new(context, &scene).expect("room for the scene");
        for count in [64, 1024] {
            let mut vpls = Vpls::by_view(context, &world, count, &camera(&scene)).expect("room");
            let (mut sums, mut errors) = (Vec::new(), Vec::new());
            for i in 0..16 {
                // Moves the camera from in front of the open wall to inside the room.
                scene.camera = first.turned(f64::from(i % 4) * 8.0 - 12.0);
                let nearer = 1.0 - 0.2 * f64::from(i / 4);
                scene.camera.position = first.target + nearer * (scene.camera.position - first.target);
                vpls.look(&camera(&scene));
                vpls.make(&world).expect("made");
                let seen = vpls.seen().expect("read");
                let weighed = || patches.iter().zip(&seen.fluxes).filter_map(|(patch, w)| Some((patch.as_ref()?, *w)));
                let all: f64 = weighed().map(|(_, weight)| f64::from(weight)).sum();
                let squares: DVec3 = weighed()
                    .filter(|(_, weight)| *weight > 0.0)
                    .map(|(patch, weight)| patch.flux * patch.flux * (all / f64::from(weight)))
                    .sum();
                errors.push(((squares - flux * flux) / f64::from(count)).powf(0.5) / flux);
                sums.push(super::sum(&vpls.read().expect("read")) / flux);
            }
            let mean = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len() as f64;
            let (sum, error) = (mean(&sums), mean(&errors));
            println!("{count} lights: {sum:.4} of all light, standard error of random ones {error:.4}");
            assert!((sum - 1.0).abs().cmple(error).all(), "{sum} {error}");
            for (sum, error) in sums.iter().zip(&errors) {
                assert!((*sum - 1.0).abs().cmple(2.0 * *error).all(), "{sum} {error}");
            }
            // Nothing of the previous camera remains.
            let again = vpls.read().expect("read");
            assert!(made(context, &scene, count).read().expect("read") == again, "as if it had been made for it");
            scene.camera = first;
        }
    });
}
