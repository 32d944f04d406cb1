//! Pictures of casters with several extinction ratios.

use super::truth::two_balls;
use super::{Both, all_kinds};
use crate::support::{built, gpu_test, those_that_run};
use glam::{DVec2, DVec3};
use gobo::gpu::{Context, Requirement};
use gobo::reference::truth::{Casters, fog as true_fog, picture};
use gobo::scene::{Camera, Fog, Picture, SKY, Scene, View};
use gobo::shading::{Lighting, Renderer, Shading};
use gobo::technique::Technique;
use gobo::world::World;

const SIZE: [u32; 2] = [48, 27];
/// Twins: PARTICLE_ALBEDO, AMBIENT.
const ALBEDO: [f64; 3] = [0.92, 0.92, 0.95];
const AMBIENT: [f64; 3] = [0.10, 0.12, 0.15];

pub fn renderer(context: &Context, scene: &Scene) -> Renderer {
    let world = World::new(context, scene).expect("room for the scene");
    Renderer::new(context, &world, &View::camera(&scene.camera, scene, SIZE)).expect("a renderer")
}

fn channel(picture: &Picture, color: usize) -> impl Iterator<Item = f32> {
    picture.pixels.iter().map(move |pixel| pixel[color])
}

/// Returns the mean difference of one color between two pictures.
fn apart(a: &Picture, b: &Picture, color: usize) -> f64 {
    let off = channel(a, color).zip(channel(b, color)).map(|(a, b)| f64::from(a - b).abs());
    off.sum::<f64>() / a.pixels.len() as f64
}

/// Bound on the mean difference of pictures with the same look-ups: less than half an ulp of a half float near 1, since some devices blend
/// in half floats. The look-ups themselves differ in the last bits of floats, by the order of sums.
const HALF_A_STEP: f64 = 2e-4;

/// Each channel of a picture equals the picture of the grey scene scaled by hand for that color, with and without fog.
#[test]
fn each_channel_of_a_picture_is_that_of_a_scene_made_by_hand() {
    if crate::support::is_costly("each_channel_of_a_picture_is_that_of_a_scene_made_by_hand") {
        return;
    }
    let test = "each_channel_of_a_picture_is_that_of_a_scene_made_by_hand";
    gpu_test(test, |context| {
        let both = Both::of(all_kinds(), 4);
        let air = Fog { extinction: 0.1, steps: 8 };
        let tessellates = context.features().lacks(Requirement::Tessellation).is_none();
        let vertex = tessellates.then_some((Shading::Forward, Lighting::Vertex { spacing: 8.0 }));
        let ways = [(Shading::Forward, Lighting::Fragment), (Shading::Deferred, Lighting::Fragment)];
        for text in those_that_run(test, context, ["avsm:path=binned,size=64", "uncompressed:size=64"]) {
            let technique = built(context, &both.inks, text);
            let by_hand = both.grey.each_ref().map(|grey| built(context, grey, text));
            for (shading, lighting) in ways.into_iter().chain(vertex) {
                let drawn = |scene: &Scene, technique: &dyn Technique| {
                    let renderer = renderer(context, scene);
                    let clear = renderer.picture(&technique.answer(), shading, lighting).expect("drawn");
                    renderer.fog(&technique.answer(), &air).expect("fog");
                    (clear, renderer.read().expect("read"))
                };
                let found = drawn(&both.inks, technique.as_ref());
                let expected: Vec<_> =
                    both.grey.iter().zip(&by_hand).map(|(grey, by_hand)| drawn(grey, by_hand.as_ref())).collect();
                for (color, expected) in expected.iter().enumerate() {
                    for (found, expected) in [(&found.0, &expected.0), (&found.1, &expected.1)] {
                        let mean = apart(found, expected, color);
                        assert!(mean < HALF_A_STEP, "{text}, {shading:?}, {lighting:?}, color {color}: {mean}");
                    }
                }
                assert!(apart(&expected[0].0, &expected[1].0, 0) > 0.01, "the scenes look different");
            }
        }
    });
}

/// Pictures equal the reference's, with and without fog, and the view of two balls in front of the sky has a closed form.
#[test]
fn pictures_are_those_of_the_reference() {
    let test = "pictures_are_those_of_the_reference";
    gpu_test(test, |context| {
        let both = Both::of(all_kinds(), 4);
        let air = Fog { extinction: 0.1, steps: 8 };
        // Difference of each color from the reference, without fog and with it.
        let off = |scene: &Scene, text: &str| {
            let camera = View::camera(&scene.camera, scene, SIZE);
            let casters = Casters::new(scene);
            let reference = picture(&casters, scene, &camera);
            let foggy = true_fog(&casters, &camera, &reference, &air, |light, at| casters.arriving_colors(light, at));
            let technique = built(context, scene, text);
            let renderer = renderer(context, scene);
            let clear = renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
            renderer.fog(&technique.answer(), &air).expect("fog");
            let drawn = [(clear, reference), (renderer.read().expect("read"), foggy)];
            drawn.map(|(found, reference)| [0, 1, 2].map(|color| apart(&found, &reference, color)))
        };
        for text in those_that_run(test, context, ["uncompressed:size=256"]) {
            // The maps' texels cause the same error as in the grey scene scaled by hand.
            let inks = off(&both.inks, text);
            for (color, grey) in both.grey.iter().enumerate() {
                for (found, expected) in inks.iter().zip(off(grey, text)) {
                    let (found, expected) = (found[color], expected[color]);
                    assert!(found < expected + HALF_A_STEP, "{text}, color {color}: {found}, in grey {expected}");
                    // As close as tests/pictures/color.rs requires for the closed form of a shadow.
                    assert!(expected < 4e-3, "{text}, color {color}: {expected}");
                }
            }
        }

        // Two balls, one behind the other.
        let mut scene = two_balls();
        scene.lights.iter_mut().for_each(|light| light.radiance = [0.0; 3]);
        scene.camera =
            Camera { position: DVec3::new(0.0, 0.0, 9.0), target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 12.0 };
        let camera = View::camera(&scene.camera, &scene, SIZE);
        let reference = picture(&Casters::new(&scene), &scene, &camera);
        let technique = built(context, &scene, "none");
        let renderer = renderer(context, &scene);
        let found = renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
        let mut seen = 0;
        for i in 0..found.pixels.len() {
            let at = DVec2::new((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
            let ray = camera.ray(at);
            let direction = ray.direction.normalize();
            let chord = |z: f64| {
                let offset = DVec3::new(0.0, 0.0, z) - ray.origin;
                2.0 * (0.25 - (offset - offset.dot(direction) * direction).length_squared()).max(0.0).sqrt()
            };
            let chords = [chord(0.6), chord(-0.6)];
            if chords.iter().any(|chord| *chord < 0.2) {
                continue; // a short chord magnifies rounding
            }
            seen += 1;
            for color in 0..3 {
                let [a, b] = [[1.0, 0.3, 0.0], [0.2, 1.0, 2.0]].map(|k: [f64; 3]| k[color]);
                let left = (-a * chords[0] - b * chords[1]).exp();
                let expected = ALBEDO[color] * AMBIENT[color] * (1.0 - left) + f64::from(SKY[color]) * left;
                let allowed = if context.features().float32_blend { 5e-5 } else { 3e-3 };
                for (found, allowed) in [(&found, allowed), (&reference, 1e-6)] {
                    let wrong = (f64::from(found.pixels[i][color]) - expected).abs();
                    assert!(wrong < allowed, "pixel {i}, color {color}: {:?}, not {expected}", found.pixels[i]);
                }
            }
        }
        assert!(seen > 30, "{seen} pixels");
    });
}
