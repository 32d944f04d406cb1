//! Fog in front of the picture: against closed forms, against its CPU twin at the same points, lit by every technique, and within the
//! bounds that the truth allows for techniques with shadows resolved to a texel.

use crate::support::{built, gpu_test, scenes, skipped, some, those_that_run};
use glam::{DVec2, DVec3};
use gobo::Error;
use gobo::gpu::Context;
use gobo::query::Query;
use gobo::reference::truth::{Casters, fog};
use gobo::scene::{Camera, Fog, Light, LightKind, Particle, Picture, Resolution, Scene, View};
use gobo::shading::{Lighting, Renderer, Shading};
use gobo::technique::{Entry, Name, Path, REGISTRY, Spec, Technique, open};
use gobo::world::World;
use std::collections::HashMap;
use std::sync::Mutex;

const SIZE: [u32; 2] = [64, 36];

/// Returns the camera's picture without fog and with it.
fn drawn(context: &Context, scene: &Scene, technique: &dyn Technique, fog: &Fog) -> [Picture; 2] {
    let world = World::new(context, scene).expect("room for the scene");
    let renderer = Renderer::new(context, &world, &camera(scene)).expect("a renderer");
    let clear = renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
    renderer.fog(&technique.answer(), fog).expect("fog");
    [clear, renderer.read().expect("read")]
}

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

/// Returns the centre of each pixel, in row-major order.
fn middles() -> impl Iterator<Item = DVec2> {
    (0..SIZE[0] * SIZE[1]).map(|i| DVec2::new(f64::from(i % SIZE[0]), f64::from(i / SIZE[0])) + 0.5)
}

/// Returns the error bound for rounding of a color near 1, stored in f32, or in half floats on a device that cannot blend f32.
fn rounding(context: &Context) -> f32 {
    if context.features().float32_blend { 1e-5 } else { 2e-3 }
}

/// A square ground of half-extent `half`, seen from above its centre, with the horizon in the picture.
fn ground(half: f32) -> Scene {
    let mut scene = scenes::directional("ground", [0.3, 0.2, -0.9], Vec::new());
    scene.meshes = vec![scenes::level(0.0, half, [0.0, 0.0])];
    let position = DVec3::new(0.0, -2.0, 1.5);
    scene.camera = Camera { position, target: DVec3::new(0.0, 3.0, 1.2), up: DVec3::Z, fov_y_degrees: 50.0 };
    scene
}

fn light(kind: LightKind, radiance: [f32; 3]) -> Light {
    Light { kind, radiance, radius: f64::INFINITY }
}

/// Without casters, fog along a ray of length d, to the ground or the end of the scene, transmits e^(−σd) of the picture, and scatters a
/// quarter of 1 − e^(−σd) of each light towards the camera.
#[test]
fn without_shadows_fog_has_its_closed_form() {
    gpu_test("without_shadows_fog_has_its_closed_form", |context| {
        let mut scene = ground(20.0);
        let point = LightKind::Point { position: DVec3::new(1.0, 0.5, 4.0) };
        let aside = LightKind::Spot { position: DVec3::new(0.0, 0.0, 9.0), direction: DVec3::Z, cone_degrees: 40.0 };
        scene.lights[0].radiance = [0.5, 0.1, 0.0];
        scene.lights.push(light(point, [0.3, 0.0, 0.7]));
        // A light that shines on nothing in this scene.
        scene.lights.push(light(aside, [9.0; 3]));
        let camera = camera(&scene);
        // A depth map darkens points in space less than a texel above the ground if the ground slants in its view; a sun straight above
        // avoids that.
        let mut above = scene.clone();
        above.lights.remove(1);
        above.lights[0].kind = LightKind::Directional { direction: -DVec3::Z };
        let listed = those_that_run("without_shadows_fog_has_its_closed_form", context, ["uncompressed:size=64"]);
        for text in ["none", "shadow-map:size=64", "beer-shadow-map:size=64"].into_iter().chain(listed) {
            let (scene, sums) = if text == "none" { (&scene, [0.8, 0.1, 0.7]) } else { (&above, [0.5, 0.1, 0.0]) };
            let technique = built(context, scene, text);
            for (extinction, steps) in [(0.0, 8), (0.05, 8), (1.5, 8), (0.2, 1), (0.2, 333), (1e30, 8)] {
                let fog = Fog::new(extinction, steps).expect("fog");
                let [clear, foggy] = drawn(context, scene, technique.as_ref(), &fog);
                let (mut sky, mut seen) = (0, 0);
                for ((at, clear), foggy) in middles().zip(&clear.pixels).zip(&foggy.pixels) {
                    let ray = camera.ray(at);
                    let end = -ray.origin.z / ray.direction.z;
                    let past_the_edge = ray.at(end).truncate().abs().max_element() > 19.0;
                    if end > 0.0 && past_the_edge {
                        continue; // a corner of the ground may cut the pixel
                    }
                    let length = if end > 0.0 { end } else { f64::from(camera.far) } * ray.direction.length();
                    (sky, seen) = (sky + usize::from(end <= 0.0), seen + usize::from(end > 0.0));
                    let left = (-f64::from(extinction) * length).exp();
                    for (i, sum) in sums.into_iter().enumerate() {
                        let expected = f64::from(clear[i]) * left + 0.25 * sum * (1.0 - left);
                        let wrong = (f64::from(foggy[i]) - expected).abs();
                        let foggy = foggy[i];
                        assert!(
                            wrong < f64::from(rounding(context)),
                            "{text}, {fog:?}, pixel {at}: {foggy}, not {expected}"
                        );
                    }
                }
                assert!(sky > 300 && seen > 300, "{sky} pixels of sky, {seen} of ground");
            }
        }
    });
}

/// Smoke, a plate and a wall over a ground, under one light of each kind.
fn room() -> Scene {
    let sphere = |position, radius, extinction| Particle { position, radius, extinction };
    let mut scene = ground(4.0);
    scene.particles = vec![sphere([-0.8, 0.5, 1.2], 0.6, 1.0), sphere([0.7, 1.2, 0.7], 0.5, 2.0)];
    let wall = [[-1.6, 1.0, 0.0], [-1.0, 1.4, 0.0], [-1.0, 1.4, 1.1], [-1.6, 1.0, 1.1]];
    scene.meshes.extend([scenes::level(1.6, 0.8, [0.4, 1.0]), scenes::quad(wall, 0.5)]);
    let (position, target) = (DVec3::new(3.0, -3.0, 4.0), DVec3::new(0.0, 1.0, 0.0));
    let spot = LightKind::Spot { position, direction: (target - position).normalize(), cone_degrees: 40.0 };
    let point = LightKind::Point { position: DVec3::new(-2.0, 2.5, 1.5) };
    scene.lights[0].radiance = [0.5, 0.1, 0.0];
    scene.lights.extend([light(spot, [0.0, 0.6, 0.2]), light(point, [0.3, 0.0, 0.7])]);
    scene.name = "room".into();
    scene
}

/// Returns the room with only its first light, for techniques that support no others.
fn under_the_sun(mut room: Scene) -> Scene {
    room.lights.truncate(1);
    room.name = "sun".into();
    room
}

/// Returns why a technique refuses a scene on this device.
fn refusal(context: &Context, scene: &Scene, spec: &Spec) -> Option<Error> {
    let world = World::new(context, scene).expect("room for the scene");
    let error = open(context, &world, spec).err()?;
    assert!(matches!(error, Error::Refused(_)), "{error}");
    Some(error)
}

/// Returns a spec for each path of a technique that the device runs, with the scene whose lights it supports.
fn those_that_open(test: &str, context: &Context, entry: &Entry) -> Vec<(String, Scene)> {
    let opens = |path: &Path| {
        let mut spec = crate::support::spec(entry.name);
        spec.set(Name::PATH, path.name);
        spec.set(Name::SIZE, "128");
        // With 64 slices, every device can draw the maps of two lights at once.
        spec.set(Name::SLICES, "64");
        let refused = |scene: &Scene| refusal(context, scene, &spec);
        let scene = [room(), under_the_sun(room())].into_iter().find(|scene| refused(scene).is_none());
        if let (None, Some(refusal)) = (&scene, refused(&room())) {
            skipped(test, &format!("{}: {refusal}", spec.short()));
        }
        scene.map(|scene| (spec.short(), scene))
    };
    entry.paths.iter().filter_map(opens).collect()
}

/// Returns the twin's picture, lit by the technique's look-ups at the twin's points.
fn twin(context: &Context, scene: &Scene, technique: &dyn Technique, clear: &Picture, air: &Fog) -> Picture {
    let (casters, camera) = (Casters::new(scene), camera(scene));
    let asked: Vec<_> = scene.lights.iter().map(|_| Mutex::new(Vec::new())).collect();
    let place = |position: DVec3| position.as_vec3().to_array();
    fog(&casters, &camera, clear, air, |light, position| {
        asked[light].lock().expect("no panic").push(place(position));
        0.0
    });
    let answers = |(light, points): (usize, Mutex<Vec<[f32; 3]>>)| -> HashMap<[u32; 3], f32> {
        let points = points.into_inner().expect("no panic");
        let query = Query::new(context, light, &points).expect("room for the points");
        let answers = query.ask(&technique.answer()).expect("answered");
        points.into_iter().map(|p| p.map(f32::to_bits)).zip(answers).collect()
    };
    let answers: Vec<_> = asked.into_iter().enumerate().map(answers).collect();
    fog(&casters, &camera, clear, air, |light, position| {
        let shines = scene.lights[light].shines_on(position);
        if shines { answers[light][&place(position).map(f32::to_bits)].into() } else { 0.0 }
    })
}

/// Returns whether the plane that a pixel's ray meets extends a quarter of a pixel around it, so that a rasterizer has no choice.
fn is_steady(casters: &Casters, camera: &View, at: DVec2) -> bool {
    let normal = |offset: [f64; 2]| {
        let ray = camera.ray(at + DVec2::from(offset));
        casters.meshes.hit(ray.origin, ray.direction).map(|hit| (hit.normal, hit.normal.dot(ray.at(hit.distance))))
    };
    let same = |a: Option<(DVec3, f64)>, b: Option<(DVec3, f64)>| match (a, b) {
        (None, None) => true,
        (Some((n, d)), Some((m, e))) => (n - m).length() < 1e-6 && (d - e).abs() < 1e-6,
        _ => false,
    };
    let middle = normal([0.0; 2]);
    [[-0.25, 0.0], [0.25, 0.0], [0.0, -0.25], [0.0, 0.25]].into_iter().all(|offset| same(middle, normal(offset)))
}

/// At the same points, fog gets the same light from every technique as a query does. If rounding moves a point across a shadow's edge, the
/// pixel is wrong by at most the light that one step scatters; this is rare.
#[test]
fn every_technique_lights_fog() {
    let name = "every_technique_lights_fog";
    gpu_test(name, |context| {
        let air = Fog::new(0.15, 12).expect("fog");
        let entries = crate::support::every_third(name, REGISTRY.iter().collect());
        for (text, scene) in entries.into_iter().flat_map(|entry| some(those_that_open(name, context, entry), 1)) {
            let technique = built(context, &scene, &text);
            let [clear, foggy] = drawn(context, &scene, technique.as_ref(), &air);
            let twin = twin(context, &scene, technique.as_ref(), &clear, &air);
            let (casters, camera) = (Casters::new(&scene), camera(&scene));
            let (mut compared, mut differing) = (0, 0);
            for (at, (drawn, twin)) in middles().zip(foggy.pixels.iter().zip(&twin.pixels)) {
                if is_steady(&casters, &camera, at) {
                    compared += 1;
                    let apart = (0..3).map(|i| (drawn[i] - twin[i]).abs()).fold(0.0, f32::max);
                    differing += usize::from(apart > 1e-4f32.max(rounding(context)));
                    let step = 0.25 * 0.8 * (1.0 - (-0.15 * f64::from(camera.far) * 1.3 / 12.0).exp());
                    assert!(f64::from(apart) < 3.0 * step, "{text}, pixel {at}: {drawn:?}, not {twin:?}");
                }
            }
            println!("{text}, {}: {differing} of {compared} pixels differ", scene.name);
            assert!(compared > 2000 && differing * 100 <= compared, "{text}: {differing} of {compared} pixels differ");
        }
    });
}

/// Every pixel lies between the darkest and the brightest value that its points allow: points in the boundary of an opaque shadow, where a
/// technique need not be right, may be dark or lit; all others match the truth.
#[test]
fn fog_is_between_what_the_truth_allows() {
    let name = "fog_is_between_what_the_truth_allows";
    gpu_test(name, |context| {
        let air = Fog::new(0.15, 12).expect("fog");
        let mut room = room();
        room.particles.clear();
        let sun = under_the_sun(room.clone());
        let cases = [
            (&sun, "voxelized:size=512"),
            (&room, "ray-query"),
            (&room, "shadow-map:size=512"),
            (&room, "uncompressed:size=512"),
        ];
        for (scene, text) in cases {
            if let Some(refusal) = refusal(context, scene, &crate::support::spec(text)) {
                skipped(name, &format!("{text}: {refusal}"));
                continue;
            }
            let technique = built(context, scene, text);
            let [clear, foggy] = drawn(context, scene, technique.as_ref(), &air);
            let (casters, camera, resolution) = (Casters::new(scene), camera(scene), technique.inspect().resolution());
            let bound = |of_boundary: f64| {
                fog(&casters, &camera, &clear, &air, |light, position| {
                    let unknown = in_boundary(scene, &casters, &resolution, light, position);
                    if unknown { of_boundary } else { casters.arriving(light, position) }
                })
            };
            let (low, high) = (bound(0.0), bound(1.0));
            let shines = |light: usize, position| f64::from(u8::from(scene.lights[light].shines_on(position)));
            let unshadowed = fog(&casters, &camera, &clear, &air, shines);
            let (mut compared, mut shadowed, mut room) = (0, 0, 0.0);
            for (i, at) in middles().enumerate().filter(|(_, at)| is_steady(&casters, &camera, *at)) {
                compared += 1;
                let rounding = rounding(context);
                let [low, high, foggy, lit] = [&low, &high, &foggy, &unshadowed].map(|p| p.pixels[i]);
                for c in 0..3 {
                    let between = low[c] - rounding..=high[c] + rounding;
                    assert!(between.contains(&foggy[c]), "{text}, pixel {at}: {} is not in {between:?}", foggy[c]);
                    room += f64::from(high[c] - low[c]);
                }
                shadowed += usize::from((0..3).any(|c| lit[c] > high[c] + 1e-3));
            }
            room /= 3.0 * f64::from(compared);
            println!(
                "{text}: {compared} pixels, {shadowed} in whose way a shadow stands, {room:.1e} between the bounds"
            );
            assert!(compared > 2000 && shadowed > 250 && room < 5e-3, "{compared}, {shadowed}, {room}: proves nothing");
        }
    });
}

/// Returns whether a point is in the boundary of an opaque shadow, or of a spot light's cone, up to rounding.
fn in_boundary(scene: &Scene, casters: &Casters, resolution: &[Resolution], light: usize, position: DVec3) -> bool {
    let of_map = scene.first_map(light) + scene.lights[light].map_at(position.as_vec3().into());
    let at_cone = match scene.lights[light].kind {
        LightKind::Spot { direction, cone_degrees, .. } => {
            let cosine = -scene.lights[light].towards(position).dot(direction);
            (cosine - (cone_degrees.to_radians() * 0.5).cos()).abs() < 1e-5
        }
        _ => false,
    };
    // A technique without texels is exact up to float rounding.
    let rounded = || {
        let blocked = !casters.unblocked(light, position);
        let mut about = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [1e-4 * axis, -1e-4 * axis]);
        about.any(|offset| casters.unblocked(light, position + offset) == blocked)
    };
    let in_boundary = || resolution.get(of_map).map_or_else(rounded, |r| casters.in_boundary(light, r, position));
    at_cone || scene.lights[light].shines_on(position) && in_boundary()
}

/// An empty scene, with or without lights: no visible fog, and no NaN.
#[test]
fn fog_in_an_empty_scene() {
    gpu_test("fog_in_an_empty_scene", |context| {
        let mut scene = room();
        (scene.particles, scene.meshes) = (Vec::new(), Vec::new());
        let technique = built(context, &scene, "shadow-map:size=16");
        let [clear, foggy] = drawn(context, &scene, technique.as_ref(), &Fog::new(1.0, 64).expect("fog"));
        // The scene's far end is a thousandth of a unit in front of the camera, so fog may change a pixel by about as much.
        let apart = clear.pixels.iter().flatten().zip(foggy.pixels.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f32::max) < 2e-3);
        assert!(foggy.pixels.iter().flatten().all(|c| c.is_finite() && *c > 0.0));
    });
}
