//! What `gobo render` adds for display: samples, sky, ground, tone curve, panels, scales; none of it may be in the measured picture.

use super::rgb8;
use crate::support::{gpu_test_needing, log, opened, spec};
use crate::{folder, ok, runs, small_scene, text};
use glam::{DVec2, DVec3};
use gobo::reference::truth::{Casters, shown_picture, tonemapped};
use gobo::scene::{Backdrop, SKY, Scene, Show, View};
use gobo::shading::{Lighting, Renderer, Shading, Tonemapped};
use gobo::technique::open;
use gobo::world::World;

const SIZE: [u32; 2] = [64, 36];

/// Applies the tone curve written out here and the encoding of IEC 61966-2-1, in eight bits.
fn shown8(linear: f64) -> u8 {
    let curve = (linear * (2.51 * linear + 0.03) / (linear * (2.43 * linear + 0.59) + 0.14)).clamp(0.0, 1.0);
    let encoded = if curve <= 0.003_130_8 { 12.92 * curve } else { 1.055 * curve.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

/// The device's picture must equal its twin's: the mean of the drawn samples up to rounding, and the truth's picture as far as the
/// technique is exact. The measured picture must be the same before and after.
#[test]
fn shown_pictures_are_their_twins() {
    gpu_test_needing("shown_pictures_are_their_twins", &[], |context| {
        for (name, samples, text_of) in [("sparse", 4, "uncompressed:size=256"), ("hair", 1, "shadow-map:size=512")] {
            let mut scene = Scene::load(name, 20.0).expect("built in");
            // Moves the horizon into the picture.
            let far = (scene.camera.position - scene.camera.target).length();
            scene.camera.target.z = scene.camera.position.z + 0.1 * far;
            scene.strands.clear();
            let show = Show::new(samples, 0.5).expect("samples");
            let world = World::new(context, &scene).expect("room for the scene");
            let Ok(mut lit) = open(context, &world, &spec(text_of)) else { continue };
            lit.build(&world).expect("built");
            let plain_camera = View::camera(&scene.camera, &scene, SIZE);
            let measured = || {
                let renderer = Renderer::new(context, &world, &plain_camera).expect("a renderer");
                renderer.picture(&lit.technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn")
            };
            let before = measured();
            let camera = View::camera(&scene.camera, &scene, show.sampled(SIZE));
            let mut renderer = Renderer::new(context, &world, &camera).expect("a renderer");
            renderer.show(&world).expect("shown");
            let drawn = renderer.picture(&lit.technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
            let shown = Tonemapped::new(&renderer, &show).expect("tonemapped").picture().expect("read");
            let twin = tonemapped(&drawn, &show);
            let off = |a: &[[f32; 3]], b: &[[f32; 3]]| -> Vec<f64> {
                let apart =
                    |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|i| f64::from((a[i] - b[i]).abs())).fold(0.0, f64::max);
                a.iter().zip(b).map(apart).collect()
            };
            let most = off(&shown.pixels, &twin.pixels).into_iter().fold(0.0, f64::max);
            assert!(most < 1e-4, "{name}: {most} from the mean of its samples");

            let casters = Casters::new(&scene);
            let truth = shown_picture(&casters, &scene, &camera);
            let apart = off(&drawn.pixels, &truth.pixels);
            let far = apart.iter().filter(|a| **a > 0.03).count() as f64 / apart.len() as f64;
            println!("{name}: {:.2} % of samples differ from the truth by more than 0.03", 100.0 * far);
            assert!(far < 0.05, "{name}: {far} of all samples are far from the truth");
            // Pixels whose rays pass above all meshes show the sky; at least half of them must match the truth.
            let sees_sky = |i: usize| {
                let at = DVec2::new((i as u32 % camera.width).into(), (i as u32 / camera.width).into()) + 0.5;
                let ray = camera.ray(at);
                let height = ray.direction.normalize().dot(DVec3::from(Backdrop::of(&scene).up.map(f64::from)));
                height > 0.05 && casters.meshes.hit(ray.origin, ray.direction).is_none()
            };
            let sky: Vec<f64> = (0..apart.len()).filter(|i| sees_sky(*i)).map(|i| apart[i]).collect();
            let same = sky.iter().filter(|a| **a < 1e-3).count();
            assert!(sky.len() > 20 && same > sky.len() / 2, "{name}: {same} of {} samples of the sky", sky.len());
            assert!(before == measured(), "{name}: what is measured has changed");
            // The sky's color, up to the device's rounding.
            let is_sky = |pixel: &&[f32; 3]| (0..3).all(|i| (pixel[i] - SKY[i]).abs() < 1e-3);
            let measured_sky = before.pixels.iter().find(is_sky);
            let measured_sky = measured_sky.unwrap_or_else(|| panic!("{name}: no sky in {:?}", before.pixels[0]));
            assert!(drawn.pixels.iter().all(|p| p != measured_sky), "{name}: the measured sky is left");
        }
    });
}

/// `--plain` must write the measured picture, to the bit.
#[test]
fn plain_is_what_is_measured() {
    gpu_test_needing("plain_is_what_is_measured", &[], |context| {
        let folder = folder();
        let file = small_scene(folder.path());
        let scene = Scene::load(text(&file), 20.0).expect("written");
        let text_of = "avsm:size=32";
        let world = World::new(context, &scene).expect("room for the scene");
        let mut lit = opened(open(context, &world, &spec(text_of)), text_of);
        lit.build(&world).expect("built");
        let renderer = Renderer::new(context, &world, &View::camera(&scene.camera, &scene, SIZE)).expect("a renderer");
        let measured = renderer.picture(&lit.technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
        let out = folder.path().join("plain.png");
        let picture = SIZE.map(|side| side.to_string()).join("x");
        let size = ["--picture", &picture, "--technique", text_of, "--plain", "--out", text(&out)];
        ok(&[&["render", text(&file)][..], &size].concat());
        assert!(rgb8(&out).1.concat() == measured.to_srgb8());
    });
}

/// Each panel must be the picture of its technique alone; the reference's caption must show no error.
#[test]
fn panels_are_their_pictures() {
    log("exercised", "panels_are_their_pictures", &runs("avsm", "binned").0);
    let folder = folder();
    let scene = small_scene(folder.path());
    let render = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let picture = SIZE.map(|side| side.to_string()).join("x");
        ok(&[&["render", text(&scene), "--picture", &picture, "--out", text(&out)][..], more].concat());
        rgb8(&out)
    };
    let techniques = ["avsm:size=32", "none", "reference"];
    let words: Vec<&str> = techniques.iter().flat_map(|technique| ["--technique", technique]).collect();
    let (size, all) = render("all.png", &words);
    let ([across, down], gap) = ([size[0], size[1]], 6);
    assert_eq!(across, 2 * SIZE[0] + gap);
    for (i, technique) in techniques.into_iter().enumerate() {
        let (_, alone) = render("one.png", &["--technique", technique]);
        let corner = [i as u32 % 2 * (SIZE[0] + gap), i as u32 / 2 * ((down + gap) / 2)];
        for (at, pixel) in (0..).zip(&alone) {
            let place = (corner[1] + at / SIZE[0]) * across + corner[0] + at % SIZE[0];
            assert_eq!(all[place as usize], *pixel, "{technique}, pixel {at}");
        }
    }
}

/// More exposure must be brighter, and the scale of speeds must begin and end with its colors.
#[test]
fn exposure_and_scales() {
    if crate::support::is_costly("exposure_and_scales") {
        return;
    }
    log("exercised", "exposure_and_scales", &runs("avsm", "binned").0);
    let folder = folder();
    let render = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let base = ["render", "fountain:particles=900", "--picture", "96x54", "--samples", "1"];
        ok(&[&base[..], &["--technique", "avsm:path=binned,size=32", "--out", text(&out)], more].concat());
        rgb8(&out)
    };
    let sum = |(_, pixels): &([u32; 2], Vec<[u8; 3]>)| pixels.iter().flatten().map(|c| u64::from(*c)).sum::<u64>();
    let [dark, bright] = ["-1", "1"].map(|stops| render("exposed.png", &["--exposure", stops]));
    assert!(sum(&dark) < sum(&bright));
    let ([width, height], pixels) = render("speed.png", &["--particles", "speed"]);
    assert!(width == 96 && height > 54, "{width} × {height}");
    let row = &pixels[(54 + 12) * 96..][..96];
    assert_eq!(row[6], [0.02, 0.10, 0.45].map(shown8), "the slowest");
    assert_eq!(row[89], [1.0, 0.22, 0.06].map(shown8), "the fastest");
    let (size, _) = render("plain.png", &["--particles", "color"]);
    assert_eq!(size, [96, 54], "white says nothing that needs a scale");
}
