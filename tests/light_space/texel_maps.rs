//! Techniques that store one texel per ray (translucency maps, Beer shadow maps and sums): each path against its CPU twin, texel by texel,
//! and what their few numbers can and cannot represent.

mod layers;

mod levels;

mod series;

use crate::support::{all, gpu_test, gpu_test_needing, scenes, spec};
use crate::twin;
use gobo::bench::{PointError, point_error};
use gobo::gpu::{Context, Requirement};
use gobo::maps::TILE_TEXELS;
use gobo::maps::TexelWay;
use gobo::query::Query;
use gobo::reference::truth::{Casters, map_truths};
use gobo::reference::twin::bins::tile_key;
use gobo::reference::twin::segment::texel_segment;
use gobo::reference::twin::sums::{DARK, bound};
use gobo::reference::twin::{beer_shadow_map as beer, translucency_map as translucency};
use gobo::scene::{Caster, Particle, Scene, View};
use gobo::technique::{BeerShadowMap, Opened, TexelMap, TranslucencyMap, beer_shadow_map, open};
use gobo::world::World;
use half::f16;
use twin::Twins;

/// Largest change of a transmittance by arithmetic alone: chords of nearly grazing rays lose digits to cancellation.
const ARITHMETIC: f32 = 5e-4;

/// Sizes with and without whole tiles; all kinds of casters and lights.
fn cases() -> Vec<(Scene, u32)> {
    let mut cases = vec![
        (scenes::random(), 28),
        (scenes::opaque(), 24),
        (scenes::locks(), 24),
        (scenes::splats(), 20),
        (scenes::inside(), 16),
        (scenes::nested(), 20),
        (scenes::crowd(), 16),
        (scenes::strands(), 24),
        (scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random()), 20),
    ];
    cases.truncate(if all() { cases.len() } else { 4 });
    cases
}

fn built(context: &Context, scene: &Scene, text: &str) -> Opened {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = crate::support::opened(open(context, &world, &spec(text)), text);
    opened.build(&world).expect(text);
    opened
}

fn ask(context: &Context, opened: &Opened, points: &[[f32; 3]]) -> Vec<f32> {
    Query::new(context, 0, points).expect("room").ask(&opened.technique.answer()).expect("asked")
}

/// Calls `check` with each texel of each map that no caster grazes: its place among all texels, the casters it meets in order, and its
/// tile's bound.
fn each_texel(scene: &Scene, views: &[View], mut check: impl FnMut(usize, &View, [u32; 2], &[Caster], u64)) {
    let casters = scene.casters();
    let (mut place, mut checked) = (0, 0);
    for view in views {
        let twins = Twins::new(scene, *view);
        for texel in 0..view.texels() as u32 {
            let at = [texel % view.width, texel / view.width];
            if twins.grazed(texel) == 0 {
                let met: Vec<_> = casters.iter().filter(|c| texel_segment(view, at, c).is_some()).copied().collect();
                let tile = at.map(|t| t / TILE_TEXELS);
                let near: Vec<_> = casters.iter().filter(|c| tile_key(view, c, tile).is_some()).copied().collect();
                check(place, view, at, &met, bound(&near, DARK));
                checked += 1;
            }
            place += 1;
        }
    }
    assert!(checked * 20 >= place * 19, "{}: {checked} of {place} texels are checked", scene.name);
}

/// Returns the stored texels of all maps, with a number per channel.
fn texels(context: &Context, scene: &Scene, text: &str) -> (Vec<Vec<f32>>, Vec<View>) {
    let spec = spec(text);
    let world = World::new(context, scene).expect("room for the scene");
    if spec.entry.name == "beer-shadow-map" {
        stored(context, &world, BeerShadowMap::new(context, &world, &spec.settings()), text)
    } else {
        stored(context, &world, TranslucencyMap::new(context, &world, &spec.settings()), text)
    }
}

/// Builds an opened technique, and returns its texels in the same form.
fn stored<S: Send>(
    context: &Context,
    world: &World,
    opened: gobo::Result<TexelMap<S>>,
    text: &str,
) -> (Vec<Vec<f32>>, Vec<View>) {
    use gobo::technique::Technique;
    let mut opened = Opened::new(context, Box::new(crate::support::opened(opened, text)), true);
    opened.build(world).expect(text);
    let image = opened.technique.texels.image.clone();
    let read = || -> Vec<Vec<f32>> {
        match image.bytes() / u64::from(image.size()[0] * image.size()[1]) {
            1 => image.read::<u8>().expect("read").into_iter().map(|t| vec![f32::from(t) / 255.0]).collect(),
            2 => image.read::<u16>().expect("read").into_iter().map(|t| vec![f16::from_bits(t).to_f32()]).collect(),
            _ => {
                let halves = image.read::<[u16; 4]>().expect("read");
                halves.into_iter().map(|t| t.map(|h| f16::from_bits(h).to_f32()).to_vec()).collect()
            }
        }
    };
    let all = read();
    opened.rebuild(world).expect(text);
    assert!(all == read(), "{} {text}: the second build differs", world.name());
    let views = opened.technique.inspect().maps().iter().map(|m| m.caster_view).collect();
    (all, views)
}

#[test]
fn translucency_maps_equal_their_twins() {
    let needs = [Requirement::ExtendedFormats];
    gpu_test_needing("translucency_maps_equal_their_twins", &needs, |context| {
        for (scene, size) in cases() {
            for (storage, step) in [("r8", 1.0 / 255.0), ("r16f", 1.0 / 2048.0)] {
                for path in ["raster", "binned"] {
                    let text = format!("translucency-map:path={path},storage={storage},size={size}");
                    let what = format!("{} {text}", scene.name);
                    let (stored, views) = texels(context, &scene, &text);
                    let mut covered = 0;
                    each_texel(&scene, &views, |place, view, at, met, bound| {
                        let (expected, roundings) = match path {
                            // Each blend rounds its input and its result, by up to a step each.
                            "raster" => (translucency::multiply(view, at, met), 2.0 * met.len() as f32),
                            _ => (translucency::sum(view, at, met, bound), 1.0),
                        };
                        let tolerance = if met.is_empty() { 0.0 } else { roundings * step + ARITHMETIC };
                        let found = stored[place][0];
                        assert!((found - expected).abs() <= tolerance, "{what} {at:?}: {found}, not {expected}");
                        covered += u32::from(expected < 0.99);
                    });
                    assert!(covered > 20, "{what}: {covered} texels are covered");
                }
            }
        }
    });
}

#[test]
fn beer_shadow_maps_equal_their_twins() {
    gpu_test("beer_shadow_maps_equal_their_twins", |context| {
        for (scene, size) in cases() {
            for path in ["raster", "binned", "binned,front=weighted"] {
                let text = format!("beer-shadow-map:path={path},size={size}");
                let what = format!("{} {text}", scene.name);
                let (stored, views) = texels(context, &scene, &text);
                let mut covered = 0;
                each_texel(&scene, &views, |place, view, at, met, bound| {
                    let (twin, roundings) = match path {
                        "raster" => (beer::blend(view, at, met), 1.0 + 2.0 * met.len() as f32),
                        "binned" => (beer::collect(view, at, met, bound), 1.0),
                        _ => (beer::weighted(view, at, met, bound), 1.0),
                    };
                    let [one_minus_front, back, _, optical_depth] = stored[place][..] else { panic!("four channels") };
                    // A half float has 11 bits up to 1; up to 2, where a weighted front shifts the back, its steps are twice as large. An
                    // end carries some roundings of a depth as well.
                    for (found, expected) in [(one_minus_front, twin.one_minus_front), (back, twin.back)] {
                        let step = if expected > 1.0 { 1.0 / 1024.0 } else { 1.0 / 2048.0 };
                        assert!((found - expected).abs() <= step + 1e-4, "{what} {at:?}: {found}, not {expected}");
                    }
                    let (found, expected) = ((-optical_depth).exp(), (-twin.optical_depth).exp());
                    // Steps are relative to the sum, and τ exp(−τ) is at most 1/e.
                    let tolerance =
                        if met.is_empty() { 0.0 } else { roundings / 1024.0 / std::f32::consts::E + ARITHMETIC };
                    assert!((found - expected).abs() <= tolerance, "{what} {at:?}: {found}, not {expected}");
                    covered += u32::from(expected < 0.99);
                });
                assert!(covered > 20, "{what}: {covered} texels are covered");
            }
        }
    });
}

const SPECS: [&str; 13] = [
    "translucency-map:path=raster",
    "translucency-map:path=binned",
    "translucency-map:path=binned,storage=r16f",
    "beer-shadow-map:path=raster",
    "beer-shadow-map:path=binned",
    "beer-shadow-map",
    "layers:path=raster",
    "layers:path=binned,layers=4,storage=r16",
    "layers:path=binned,layers=8,storage=r16f",
    "fourier:path=raster,coefficients=7",
    "fourier:path=binned,storage=r16f",
    "wavelet:path=raster",
    "wavelet:path=binned,rank=2,storage=r16f",
];

/// One sphere: behind it all techniques have its transmittance, and in front of the light's range full light. Inside it the Beer shadow
/// map, and sums between a texel's ends, are exact; the translucency map already has the full shadow, because it does not know where the
/// sphere is.
#[test]
fn one_sphere_has_a_closed_form() {
    gpu_test_needing("one_sphere_has_a_closed_form", &[Requirement::ExtendedFormats], |context| {
        let sphere = Particle { position: [0.0; 3], radius: 0.75, extinction: 1.2 };
        // A sphere without extinction, nearer to the light, extends the range towards it.
        let held = Particle { position: [0.0, 0.0, 3.0], radius: 0.75, extinction: 0.0 };
        let scene = scenes::directional("sphere", [0.0, 0.0, -1.0], vec![sphere, held]);
        let shares = [(4.0, 0.0), (2.0, 0.0), (0.375, 0.25), (0.0, 0.5), (-0.375, 0.75), (-0.9, 1.0), (-3.0, 1.0)];
        let points = shares.map(|(z, _)| [0.0, 0.0, z]);
        for text in SPECS {
            let separator = if text.contains(':') { ',' } else { ':' };
            let answers = ask(context, &built(context, &scene, &format!("{text}{separator}size=9")), &points);
            for (answer, (z, share)) in answers.into_iter().zip(shares) {
                let share = if !text.starts_with("translucency") || z > 3.8 { share } else { 1.0 };
                let expected = (-1.2f32 * 1.5 * share).exp();
                assert!((answer - expected).abs() < 2.5e-3, "{text} at {z}: {answer}, not {expected}");
            }
        }
    });
}

/// Missing information shows: on smoke a translucency map, which has no depth, is far too dark and worse than a Beer shadow map, which
/// assumes a uniform medium, and that is worse than a curve of eight nodes.
#[test]
fn what_is_left_out_shows() {
    gpu_test_needing("what_is_left_out_shows", &[Requirement::ExtendedFormats], |context| {
        let scene = scenes::random();
        let error = |text: &str| -> PointError {
            let truth = map_truths(&Casters::new(&scene), &scene, &View::volumes(&scene, 32)).remove(0);
            let answers = ask(context, &built(context, &scene, text), &truth.points);
            let error = point_error(&answers, &truth.visibility).expect("numbers").expect("points");
            println!("{text}: {error:?}");
            error
        };
        for path in ["raster", "binned"] {
            let translucency = error(&format!("translucency-map:path={path},size=32"));
            let beer = error(&format!("beer-shadow-map:path={path},size=32"));
            let curve = error("avsm:nodes=8,path=binned,size=32");
            let bias = translucency.bias.expect("measured");
            assert!(bias < -0.9 * translucency.mean_abs, "it can only be too dark: {translucency:?}");
            assert!(translucency.mean_abs > 3.0 * beer.mean_abs, "{translucency:?}, {beer:?}");
            assert!(beer.mean_abs > 3.0 * curve.mean_abs, "{beer:?}, {curve:?}");
        }
    });
}

/// More opaque casters on a ray than a half float can count: dark behind them, and lit, not NaN, in front.
#[test]
fn many_opaque_casters_are_a_number() {
    gpu_test_needing("many_opaque_casters_are_a_number", &[Requirement::ExtendedFormats], |context| {
        let sphere = Particle { position: [0.0; 3], radius: 0.75, extinction: 200.0 };
        let held = Particle { position: [0.0, 0.0, 3.0], radius: 0.75, extinction: 0.0 };
        let mut scene = scenes::directional("opaque", [0.0, 0.0, -1.0], vec![sphere; 5000]);
        scene.particles.push(held);
        for path in ["raster", "binned"] {
            let text = format!("beer-shadow-map:path={path},size=9");
            let answers = ask(context, &built(context, &scene, &text), &[[0.0, 0.0, 2.0], [0.0, 0.0, -1.0]]);
            assert_eq!(answers, [1.0, 0.0], "{text}");
        }
    });
}

/// Half floats that overflow become infinite on some drivers and the largest finite half float on others. Here they are made infinite: in
/// front of such a texel there must be light, where infinity times zero would be NaN, and behind it none.
#[test]
fn an_infinite_texel_is_a_number() {
    use gobo::gpu::Target;
    use gobo::technique::Technique;
    gpu_test("an_infinite_texel_is_a_number", |context| {
        let world = World::new(context, &scenes::random()).expect("room for the scene");
        let settings = beer_shadow_map::Settings { path: Some(TexelWay::Raster), size: 8, ..Default::default() };
        let technique = BeerShadowMap::new(context, &world, &settings).expect("opens");
        let mut opened = Opened::new(context, Box::new(technique), true);
        opened.build(&world).expect("built");
        let image = &opened.technique.texels.image;
        // Clears the map to a medium from depth 0.25 to 0.75 with infinite optical depth.
        let target = Target { image, clear: Some([0.75, 0.75, 0.0, f32::INFINITY]) };
        context.submit(|c| c.pass("fill", |pass| pass.render([8, 8], &[target], None, |_| ()))).expect("submitted");
        let texels = image.read::<[u16; 4]>().expect("read");
        // SwiftShader stores a NaN.
        assert!(texels.iter().all(|t| !f16::from_bits(t[3]).is_finite()), "{:?}", texels[0]);
        let view = opened.technique.inspect().maps()[0].caster_view;
        let ray = view.ray(glam::DVec2::splat(4.0));
        let at = [0.1, 0.25, 0.5, 0.75, 0.9].map(|depth| ray.at(view.z(depth)).as_vec3().to_array());
        let query = Query::new(context, 0, &at).expect("room for the points");
        let answers = query.ask(&opened.technique.answer()).expect("numbers");
        assert_eq!([answers[0], answers[2], answers[3], answers[4]], [1.0, 0.0, 0.0, 0.0], "{answers:?}");
        assert!((0.0..=1.0).contains(&answers[1]), "{answers:?}");
    });
}

/// Particles and meshes multiply, and a scene with only a mesh is lit in front of it and dark behind.
#[test]
fn meshes_and_nothing() {
    if crate::support::is_costly("meshes_and_nothing") {
        return;
    }
    gpu_test_needing("meshes_and_nothing", &[Requirement::ExtendedFormats], |context| {
        let sphere = Particle { position: [0.0, 0.0, 3.0], radius: 0.5, extinction: 1.0 };
        let mut both = scenes::directional("both", [0.0, 0.0, -1.0], vec![sphere]);
        both.meshes.push(scenes::level(0.0, 2.0, [0.0, 0.0]));
        let mut nothing = scenes::directional("nothing", [0.0, 0.0, -1.0], Vec::new());
        nothing.meshes.push(scenes::level(0.0, 2.0, [0.0, 0.0]));
        let points = [[0.0, 0.0, 1.0], [0.0, 0.0, -0.2]];
        for text in SPECS {
            let separator = if text.contains(':') { ',' } else { ':' };
            let text = format!("{text}{separator}size=9");
            for (scene, expected) in [(&both, [(-1.0f32).exp(), 0.0]), (&nothing, [1.0, 0.0])] {
                for (answer, expected) in ask(context, &built(context, scene, &text), &points).into_iter().zip(expected)
                {
                    assert!((answer - expected).abs() < 2.5e-3, "{} {text}: {answer}, not {expected}", scene.name);
                }
            }
        }
    });
}
