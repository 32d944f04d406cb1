//! Many lights, divided into parts, one of which each pixel looks up, as in a deferred picture with only those lights; gathering equals its
//! twin; and a plane receives the light of all parts. Also virtual lights, which replace the ambient term.

mod gbuffer;
mod reservoir;

use crate::lamps;
use crate::support::scenes::{directional, level, quad};
use crate::support::{gpu_test, opened, some, spec};
use glam::DVec3;
use gobo::bench::{Effort, Extent, Frames, Traced, picture_error, with_case};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::{Casters, picture};
use gobo::reference::twin::interleaved::{gather, part_count, place};
use gobo::reference::twin::many_lights::frame::Frame;
use gobo::reference::twin::packed_normal::pack_normal;
use gobo::scene::{Camera, Light, LightKind, Picture, SKY, Scene, View};
use gobo::shading::many_lights::FrameData;
use gobo::shading::{Lighting, PainterKind, PartReadback, Renderer, Shading, Tiled, VERTEX_SPACING};
use gobo::technique::Opened;
use gobo::world::World;

const AMBIENT: [f32; 3] = [0.10, 0.12, 0.15];

struct Built {
    world: World,
    technique: Opened,
}

fn build(context: &Context, scene: &Scene, text: &str) -> Built {
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = opened(gobo::technique::open(context, &world, &spec(text)), text);
    technique.build(&world).expect(text);
    Built { world, technique }
}

fn camera(scene: &Scene, size: [u32; 2]) -> View {
    View::camera(&scene.camera, scene, size)
}

fn drawn(context: &Context, built: &Built, size: [u32; 2], shading: Shading, lighting: Lighting) -> Picture {
    let renderer = Renderer::new(context, &built.world, &camera(built.world.scene().expect("of a scene"), size))
        .expect("a renderer");
    renderer.picture(&built.technique.technique.answer(), shading, lighting).expect("drawn")
}

/// Draws a frame, and reads what it left on the device.
fn seen(context: &Context, built: &Built, size: [u32; 2]) -> (Picture, PartReadback) {
    let renderer = Renderer::new(context, &built.world, &camera(built.world.scene().expect("of a scene"), size))
        .expect("a renderer");
    let answer = built.technique.technique.answer();
    let kernels = renderer.kernels(&answer, Shading::Interleaved, Lighting::Fragment).expect("kernels");
    let passes = renderer.draw(&kernels).expect("drawn");
    let names: Vec<_> = passes.iter().map(|pass| &pass.name[..]).collect();
    assert!(
        names.is_empty()
            || names
                == ["shading.visible", "shading.gbuffer", "interleaved.ask", "interleaved.gather", "shading.caster"]
    );
    (renderer.read().expect("read"), renderer.read_parts(&kernels).expect("read").expect("parts"))
}

/// Returns the error bound for rounding of a color, stored in f32, or in half floats on a device that cannot blend f32.
fn rounding(context: &Context, color: [f32; 3]) -> f32 {
    let brightest = color.iter().fold(1.0f32, |most, c| most.max(*c));
    brightest * if context.features().float32_blend { 1e-5 } else { 2e-3 }
}

#[track_caller]
fn assert_near(context: &Context, found: [f32; 3], expected: [f32; 3], what: impl std::fmt::Display) {
    let allowed = rounding(context, expected);
    assert!((0..3).all(|i| (found[i] - expected[i]).abs() <= allowed), "{what}: {found:?}, not {expected:?}");
}

fn has_rays(context: &Context) -> bool {
    context.features().lacks(Requirement::RayQuery).is_none()
}

fn shaded(albedo: [f32; 4], light: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| albedo[i] * (AMBIENT[i] + light[i]))
}

/// Each pixel looks up the lights of its part and no others: the light it receives equals that in a deferred picture with only these
/// lights, including shadows.
#[test]
fn each_pixel_asks_for_its_part() {
    gpu_test("each_pixel_asks_for_its_part", |context| {
        let mut techniques = vec!["voxel-grid:size=64", "shadow-map:size=64"];
        if has_rays(context) {
            techniques.insert(0, "ray-query");
        }
        let cases = [(lamps::kinds(), [45, 27]), (lamps::lamps(40), [50, 29]), (lamps::lamps(3), [23, 14])];
        for (mut scene, size) in some(cases, 2) {
            // Makes the lights reach far enough that each part lights something.
            scene.lights.iter_mut().for_each(|light| light.radius *= 2.5);
            let parts = part_count(scene.lights.len() as u32);
            for text in some(techniques.clone(), 1) {
                let (_, seen) = seen(context, &build(context, &scene, text), size);
                let (mut lit, mut asked) = (0, 0);
                for part in 0..parts {
                    let mut alone = scene.clone();
                    let others = alone.lights.iter_mut().enumerate().filter(|(i, _)| *i as u32 % parts != part);
                    others.for_each(|(_, light)| light.radiance = [0.0; 3]);
                    let built = build(context, &alone, text);
                    let deferred = drawn(context, &built, size, Shading::Deferred, Lighting::Fragment);
                    for i in (0..size[0] * size[1]).filter(|i| place([i % size[0], i / size[0]]) % parts == part) {
                        let (found, albedo) = (seen.estimates[i as usize], seen.albedo[i as usize]);
                        let what = format!("{}, {text}, pixel {i}", scene.name);
                        if albedo[3] == 0.0 {
                            assert_eq!(found, [0.0; 3], "{what}: sky");
                            continue;
                        }
                        assert_near(context, shaded(albedo, found), deferred.pixels[i as usize], what);
                        (lit, asked) = (lit + usize::from(found != [0.0; 3]), asked + 1);
                    }
                }
                println!("{}, {text}: {lit} of {asked} pixels are lit by their part", scene.name);
                assert!(lit * 10 > asked && lit < asked, "{lit} of {asked}");
            }
        }
    });
}

/// Colors are those that the twin gathers from the pixels' estimates: for houses, where most pixels have different neighbours, at odd
/// sizes, at sizes smaller than 4 × 4, without lights, and in the sky. Two runs give the same bytes.
#[test]
fn gathering_equals_its_twin() {
    gpu_test("gathering_equals_its_twin", |context| {
        let more = [(lamps::lamps(17), [3, 2]), (lamps::lamps(16), [65, 19]), (lamps::lamps(5), [4, 4])];
        for (scene, size) in some(more.into_iter().chain(lamps::all()), 5) {
            let built = build(context, &scene, "voxel-grid:size=64");
            let (picture, seen_now) = seen(context, &built, size);
            let FrameData { camera, corner, across, down, edge } = FrameData::of(&camera(&scene, size));
            let frame = Frame { camera, corner, across, down, edge };
            let facing = |normal: &[f32; 4]| pack_normal([normal[0], normal[1], normal[2]]);
            let geometry = |i: usize| {
                let is_sky = seen_now.albedo[i][3] == 0.0;
                if is_sky { [0; 2] } else { [seen_now.z[i].to_bits(), facing(&seen_now.normal[i])] }
            };
            let geometry: Vec<_> = (0..seen_now.z.len()).map(geometry).collect();
            let light = gather(&frame, &geometry, &seen_now.estimates, scene.lights.len() as u32);
            for (i, color) in picture.pixels.iter().enumerate() {
                let albedo = seen_now.albedo[i];
                let expected = if albedo[3] == 0.0 { SKY } else { shaded(albedo, light[i]) };
                assert_near(context, *color, expected, format!("{}, {size:?}, pixel {i}", scene.name));
            }
            assert!(seen(context, &built, size).0 == picture, "{}: the same bytes", scene.name);
        }
    });
}

/// On a ground under any number of suns, every pixel has the light of all of them: closed forms for 0 to 17 suns and more.
#[test]
fn a_ground_has_the_light_of_all_suns() {
    gpu_test("a_ground_has_the_light_of_all_suns", |context| {
        let mut scene = directional("suns", [0.0, 0.0, -1.0], Vec::new());
        scene.meshes = vec![level(0.0, 40.0, [0.0, 0.0])];
        let position = DVec3::new(0.3, -3.0, 4.0);
        scene.camera = Camera { position, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 };
        for count in (0..=17).chain([33]) {
            let sun = |i: u32| {
                let (sin, cos) = (0.1 + 0.03 * f64::from(i)).sin_cos();
                let kind = LightKind::Directional { direction: DVec3::new(sin, 0.0, -cos) };
                Light {
                    kind,
                    radiance: [0.1 * (i + 1) as f32, 0.5, f32::from(i.is_multiple_of(3))],
                    radius: f64::INFINITY,
                }
            };
            scene.lights = (0..count).map(sun).collect();
            let cosine = |i: u32| (0.1 + 0.03 * f64::from(i)).cos() as f32;
            let shines = |light: &Light, i: u32| light.radiance.map(|c| c * cosine(i));
            let all = (0..).zip(&scene.lights).fold([0.0; 3], |sum: [f32; 3], (i, light)| {
                let one = shines(light, i);
                [0, 1, 2].map(|c| sum[c] + one[c])
            });
            let expected = shaded([0.6, 0.6, 0.6, 1.0], all);
            let (picture, _) = seen(context, &build(context, &scene, "voxel-grid:size=64"), [21, 13]);
            for (i, color) in picture.pixels.iter().enumerate() {
                assert_near(context, *color, expected, format!("{count} suns, pixel {i}"));
            }
        }
    });
}

/// A room with a pillar, in which one wall glows: `side` patches per side.
fn room(side: u32) -> Scene {
    let mut scene = directional("room", [0.0, 0.0, -1.0], Vec::new());
    let wall = |corners| quad(corners, 0.7);
    scene.meshes = vec![
        level(0.0, 1.0, [0.0, 0.0]),
        level(2.0, 1.0, [0.0, 0.0]),
        wall([[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, 1.0, 2.0], [-1.0, -1.0, 2.0]]),
        wall([[1.0, -1.0, 0.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 1.0, 0.0]]),
        wall([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]]),
        wall([[-0.4, 0.0, 0.0], [0.1, 0.3, 0.0], [0.1, 0.3, 1.2], [-0.4, 0.0, 1.2]]),
    ];
    let area = 4.0 / f64::from(side * side);
    let patch = |i: u32| {
        let at = [i % side, i / side].map(|c| 2.0 * (f64::from(c) + 0.5) / f64::from(side));
        // Far enough off the wall that rounding does not put it behind.
        let position = DVec3::new(-0.9999, at[0] - 1.0, at[1]);
        let kind = LightKind::Virtual { position, normal: DVec3::X, nearest: area.sqrt() };
        let radiance = [1.0, 0.8, 0.5 + 0.5 * (i % 2) as f32].map(|c| c * (area / std::f64::consts::PI) as f32);
        Light { kind, radiance, radius: f64::INFINITY }
    };
    scene.lights = (0..side * side).map(patch).collect();
    let position = DVec3::new(0.2, -3.2, 1.1);
    scene.camera = Camera { position, target: DVec3::new(0.0, 0.0, 1.0), up: DVec3::Z, fov_y_degrees: 42.0 };
    scene
}

/// In a room lit by one wall, a sixteenth of the lights per pixel nearly gives the picture of all of them, and nearly the truth; without
/// gathering it does not.
#[test]
fn a_room_is_lit_by_a_sixteenth_of_its_lights() {
    gpu_test("a_room_is_lit_by_a_sixteenth_of_its_lights", |context| {
        let scene = room(if crate::support::all() { 24 } else { 12 });
        let size = [96, 64];
        let text = if has_rays(context) { "ray-query" } else { "shadow-map:size=64" };
        let built = build(context, &scene, text);
        let deferred = drawn(context, &built, size, Shading::Deferred, Lighting::Fragment);
        let (gathered, seen) = seen(context, &built, size);
        let alone = |(estimate, albedo): (&[f32; 3], &[f32; 4])| match albedo[3] == 0.0 {
            true => SKY,
            false => [0, 1, 2].map(|i| 16.0 * estimate[i] * albedo[i]),
        };
        let pixels = seen.estimates.iter().zip(&seen.albedo).map(alone).collect();
        let alone = picture_error(&Picture { width: size[0], height: size[1], pixels }, &deferred).rmse;
        let found = picture_error(&gathered, &deferred).rmse;
        let truth = picture(&Casters::new(&scene), &scene, &camera(&scene, size));
        let [of_all, of_parts] = [&deferred, &gathered].map(|picture| picture_error(picture, &truth).rmse);
        println!(
            "{text}: from all lights {found:.4}, not gathered {alone:.4}; from the truth {of_parts:.4}, all {of_all:.4}"
        );
        assert!(found < 0.03 && alone > 2.0 * found, "{found} gathered, {alone} not");
        assert!(
            of_parts < of_all + 0.02 && (text != "ray-query" || of_all < 0.02),
            "{of_parts}, of all lights {of_all}"
        );
    });
}

/// A floor at the foot of a wall that the sun hits at a right angle, so that it does not hit the floor; or the same floor under the virtual
/// lights that replace the wall.
fn sunlit(side: Option<u32>) -> Scene {
    let mut scene = room(side.unwrap_or(1));
    let wall = scene.meshes.swap_remove(2);
    scene.meshes = vec![level(0.0, 1.0, [0.0, 0.0]), wall];
    scene.camera.position = DVec3::new(1.0, -2.5, 2.5);
    scene.camera.target = DVec3::new(-0.4, 0.0, 0.4);
    for light in &mut scene.lights {
        // Radiance of a white wall in this light, scaled by this wall's albedo.
        light.radiance = light.radiance.map(|c| 0.7 * c);
        if side.is_none() {
            light.kind = LightKind::Directional { direction: DVec3::NEG_X };
            light.radiance = [1.0, 0.8, 0.5];
        }
    }
    scene
}

/// The picture under virtual lights is close to one bounce of the light that they replace: the error is more than noise, but small. It is
/// reported only if the bounce is requested.
#[test]
fn a_picture_is_compared_with_one_bounce() {
    gpu_test("a_picture_is_compared_with_one_bounce", |context| {
        let (mut lit, direct) = (sunlit(Some(12)), sunlit(None));
        lit.lights.iter_mut().for_each(|light| light.radiance[2] = light.radiance[1] * 0.625);
        let lit = [lit];
        let effort = Effort {
            frames: 1,
            warm_up: 0,
            space_points: 64,
            seen_points: 64,
            lookups: 0,
            picture: [48, 32],
            footprints: false,
            counts: false,
            turning: false,
            truth: Extent::Sample,
        };
        let text = if has_rays(context) { "ray-query" } else { "shadow-map:size=32" };
        let image = |bounce, shading: &str| {
            let frames = Frames { bounce, ..Frames::from(&lit[..]) };
            let spec = spec(&format!("{text}{}shading={shading}", if text.contains(':') { ',' } else { ':' }));
            let row = with_case(context, frames, effort, |case| Ok(case.measure(&spec).0)).expect("measured");
            row.error.unwrap_or_else(|| panic!("{}", row.reason)).image.expect("a picture")
        };
        let traced = Some(Traced { scene: &direct, samples: 256 });
        for shading in ["deferred", "interleaved"] {
            let error = image(traced, shading);
            println!("{shading}: {error:?}");
            let (found, noise) = (error.bounce_rmse.expect("asked for"), error.bounce_noise.expect("asked for"));
            assert!(noise > 0.0 && noise < 0.01 && found > noise && found < 0.04, "{shading}: {error:?}");
        }
        let error = image(None, "deferred");
        assert_eq!((error.bounce_rmse, error.bounce_noise), (None, None));
    });
}

/// If all lights are virtual there is no ambient term: what they do not reach is black, meshes and smoke alike, in every shading and in the
/// reference. If a lamp replaces them, it is not black.
#[test]
fn virtual_lights_stand_for_what_is_ambient() {
    gpu_test("virtual_lights_stand_for_what_is_ambient", |context| {
        let mut scene = lamps::smoke();
        scene.camera.target = DVec3::new(0.0, 0.0, 2.0);
        let [position, normal] = [DVec3::new(0.0, 0.0, -1.0), DVec3::NEG_Z];
        let below = Light {
            kind: LightKind::Virtual { position, normal, nearest: 0.1 },
            radiance: [1.0; 3],
            radius: f64::INFINITY,
        };
        let size = [40, 30];
        for light in [below, Light { radius: 0.5, ..lamps::lamp(position.to_array()) }] {
            scene.lights = vec![light];
            let is_virtual = matches!(light.kind, LightKind::Virtual { .. });
            let built = build(context, &scene, "beer-shadow-map:size=64");
            let shadings = [Shading::Forward, Shading::Deferred, Shading::Tiled(Tiled::BARE), Shading::Interleaved];
            let mut pictures = shadings.map(|s| drawn(context, &built, size, s, Lighting::Fragment)).to_vec();
            pictures.push(picture(&Casters::new(&scene), &scene, &camera(&scene, size)));
            let vertex = Lighting::Vertex { spacing: VERTEX_SPACING };
            let needs = vertex.requires(PainterKind::usual(context.features()));
            if context.features().require(needs).is_ok() {
                pictures.push(drawn(context, &built, size, Shading::Interleaved, vertex));
            }
            for (i, picture) in pictures.iter().enumerate() {
                // Counts pixels that show the ground or the sky; smoke in front of the sky is neither.
                let is = |p: &&[f32; 3], color: [f32; 3]| (0..3).all(|c| (p[c] - color[c]).abs() < 1e-3);
                let ground = [0, 1, 2].map(|c| if is_virtual { 0.0 } else { 0.6 * AMBIENT[c] });
                let shown = picture.pixels.iter().filter(|p| is(p, ground)).count();
                let sky = picture.pixels.iter().filter(|p| is(p, SKY)).count();
                let darker = picture.pixels.iter().filter(|p| p[2] < 0.9 * SKY[2] && p[2] > 1.1 * ground[2]).count();
                println!("virtual {is_virtual}, picture {i}: {shown} ground, {sky} sky, {darker} smoke");
                assert!(shown > 200 && sky > 50 && darker > 50, "picture {i}: {shown}, {sky}, {darker}");
            }
        }
    });
}
