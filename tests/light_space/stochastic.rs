//! Stochastic shadow maps: each path against its CPU twin, sample by sample, and the samples' errors against theory.

use crate::support::{ask, built, gpu_test, gpu_test_needing, scenes, some, spec};
use crate::twin;
use gobo::gpu::{Context, Requirement};
use gobo::maps::TILE_TEXELS;
use gobo::reference::truth::{Casters, MAP_DEPTHS, map_truths};
use gobo::reference::twin::bins::tile_key;
use gobo::reference::twin::stochastic::{HALVINGS, NO_END, Units, draw, quantiles};
use gobo::reference::twin::sums::{DARK, bound};
use gobo::scene::{Caster, Scene, View};
use gobo::technique::{Opened, Stochastic, Technique};
use gobo::world::World;
use twin::Twins;

/// Largest difference between two f32 computations of a depth if no caster is grazed: chords lose digits to cancellation.
const ARITHMETIC: f32 = 2e-4;

/// Sizes with and without whole tiles; all kinds of casters and lights.
fn cases() -> Vec<(Scene, u32)> {
    let cases = [
        (scenes::random(), 28),
        (scenes::locks(), 24),
        (scenes::four_lights(), 16),
        (scenes::opaque(), 24),
        (scenes::inside(), 16),
        (scenes::nested(), 20),
        (scenes::crowd(), 16),
        (scenes::strands(), 24),
        (scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random()), 20),
    ];
    some(cases, 3)
}

/// Returns the samples of all texels of all maps, which two builds must agree on, and the maps' views.
fn samples(context: &Context, scene: &Scene, text: &str) -> (Vec<u32>, Vec<View>) {
    let spec = spec(text);
    let world = World::new(context, scene).expect("room for the scene");
    let technique = Stochastic::new(context, &world, &spec.settings()).expect(text);
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect(text);
    let buffer = opened.technique.samples.clone();
    let read = || buffer.read::<u32>((buffer.bytes() / 4) as usize).expect("read");
    let all = read();
    opened.rebuild(&world).expect(text);
    assert!(all == read(), "{} {text}: the second build differs", scene.name);
    let views = opened.technique.inspect().maps().iter().map(|m| m.caster_view).collect();
    (all, views)
}

/// Calls `check` with each texel of each map that no caster grazes: the map's view, the texel, the casters of its tile with their numbers,
/// and the texel's place among all texels. `check` returns whether the texel could be compared.
fn each_texel(scene: &Scene, views: &[View], mut check: impl FnMut(&View, [u32; 2], &[(u32, Caster)], usize) -> bool) {
    let casters: Vec<_> = (0..).zip(scene.casters()).collect();
    let (mut place, mut checked) = (0, 0);
    for view in views {
        let twins = Twins::new(scene, *view);
        for texel in 0..view.texels() as u32 {
            let at = [texel % view.width, texel / view.width];
            if twins.grazed(texel) == 0 {
                let tile = at.map(|t| t / TILE_TEXELS);
                let near: Vec<_> = casters.iter().filter(|(_, c)| tile_key(view, c, tile).is_some()).copied().collect();
                checked += usize::from(check(view, at, &near, place));
            }
            place += 1;
        }
    }
    assert!(checked * 10 >= place * 9, "{}: {checked} of {place} texels are checked", scene.name);
}

/// Returns whether two samples end at the same depth, or neither ends.
fn is_near(a: u32, b: u32, by: f32) -> bool {
    a == b || a != NO_END && b != NO_END && (f32::from_bits(a) - f32::from_bits(b)).abs() <= by
}

#[test]
fn draws_equal_their_twin() {
    if crate::support::is_costly("draws_equal_their_twin") {
        return;
    }
    gpu_test_needing("draws_equal_their_twin", &[Requirement::FragmentStores], |context| {
        for (scene, size) in cases() {
            for (sampling, count) in [("plain", 16), ("hash", 4)] {
                let mut drawn = Vec::new();
                for path in ["binned", "raster"] {
                    let text = format!("stochastic:path={path},sampling={sampling},samples={count},size={size}");
                    let (samples, views) = samples(context, &scene, &text);
                    let mut ends = 0;
                    each_texel(&scene, &views, |view, at, near, place| {
                        let twin = draw(view, at, near, count, sampling == "hash");
                        let found = &samples[place * count as usize..][..count as usize];
                        let same = found.iter().zip(&twin.samples).all(|(a, b)| is_near(*a, *b, ARITHMETIC));
                        assert!(same || twin.close, "{} {text} {at:?}: {found:?}, not {:?}", scene.name, twin.samples);
                        ends += twin.samples.iter().filter(|s| **s != NO_END).count();
                        same
                    });
                    assert!(ends > 10, "{} {text}: {ends} samples end", scene.name);
                    drawn.push(samples);
                }
                // Every path draws the same numbers; compilers may round a few depths differently.
                let differ = drawn[0].iter().zip(&drawn[1]).filter(|(a, b)| !is_near(**a, **b, ARITHMETIC)).count();
                assert!(differ * 200 <= drawn[0].len(), "{}: {differ} of {}", scene.name, drawn[0].len());
            }
        }
    });
}

/// Rounding an optical depth may move a sample across a gap between two casters. So each sample is checked by the optical depth that the
/// twin finds in front of the sample's depth, and in almost all texels also by the twin's depth.
#[test]
fn quantiles_equal_their_twin() {
    if crate::support::is_costly("quantiles_equal_their_twin") {
        return;
    }
    gpu_test("quantiles_equal_their_twin", |context| {
        for (scene, size) in cases() {
            for count in [4, 64] {
                let text = format!("stochastic:sampling=stratified,samples={count},size={size}");
                let what = format!("{} {text}", scene.name);
                let (samples, views) = samples(context, &scene, &text);
                let mut ends = 0;
                each_texel(&scene, &views, |view, at, near, place| {
                    let casters: Vec<_> = near.iter().map(|(_, c)| *c).collect();
                    let units = Units::new(view, at, &casters, bound(&casters, DARK));
                    let [low, high] = units.range().unwrap_or_default();
                    let step = (high - low) / (1u32 << HALVINGS) as f32 + ARITHMETIC;
                    let found = &samples[place * count as usize..][..count as usize];
                    for (i, end) in (0..).zip(found) {
                        let wanted = units.wanted(at, i, count);
                        let slack = units.rounding() + wanted / 50_000;
                        if *end == NO_END {
                            assert!(units.all <= wanted + slack, "{what} {at:?} {i}: it never ends");
                            continue;
                        }
                        let [before, after] = [-step, step].map(|by| units.before(f32::from_bits(*end) + by));
                        let lies = before <= wanted + slack && after + slack >= wanted;
                        assert!(lies, "{what} {at:?} {i}: {before} to {after}, not {wanted}");
                        ends += 1;
                    }
                    quantiles(&units, at, count).iter().zip(found).all(|(a, b)| is_near(*a, *b, step))
                });
                assert!(ends > 100, "{what}: {ends} samples end");
            }
        }
    });
}

/// Returns the sum of errors in standard deviations, and the sum of their squares relative to the expected variance.
fn errors(context: &Context, scene: &Scene, text: &str, variance: impl Fn(f64) -> f64) -> [f64; 2] {
    let views = View::volumes(scene, 64);
    let truth = map_truths(&Casters::new(scene), scene, &views).remove(0);
    let answers = ask(context, &*built(context, scene, text), 0, &truth.points);
    // One point per texel: points of the same texel are correlated.
    let [mut sum, mut squares, mut expected] = [0.0; 3];
    for (i, texel) in truth.points.chunks_exact(MAP_DEPTHS as usize).enumerate() {
        let at = i * MAP_DEPTHS as usize + (i * 7) % texel.len();
        let error = f64::from(answers[at]) - truth.visibility[at];
        sum += error;
        squares += error * error;
        expected += variance(truth.visibility[at]);
    }
    [sum / expected.sqrt(), squares / expected]
}

/// Plain samples are binomial, with variance T(1 − T)/N; quantiles have f(1 − f)/N² about the truth, where f is the fractional part of N T.
/// Hashed alpha is neither: casters that share each other's noise absorb too little.
#[test]
fn errors_are_what_theory_says() {
    gpu_test("errors_are_what_theory_says", |context| {
        let scene = scenes::random();
        for n in [4.0, 16.0, 64.0] {
            let text = format!("stochastic:samples={n},size=64,sampling=");
            let plain = errors(context, &scene, &format!("{text}plain"), |t| t * (1.0 - t) / n);
            let even = errors(context, &scene, &format!("{text}stratified"), |t| {
                let f = (t * n).fract();
                f * (1.0 - f) / (n * n)
            });
            let hash = errors(context, &scene, &format!("{text}hash"), |t| t * (1.0 - t) / n);
            println!("{n}: plain {plain:?}, stratified {even:?}, hash {hash:?}");
            for [mean, squares] in [plain, even] {
                assert!(mean.abs() < 4.0, "{n}: {mean} standard deviations");
                assert!((squares - 1.0).abs() < 0.15, "{n}: {squares} of the variance");
            }
            assert!(hash[0] > 10.0, "{n}: {hash:?}");
        }
    });
}

/// Identical spheres are drawn independently: together they absorb as much as they should.
#[test]
fn copies_are_drawn_apart() {
    gpu_test("copies_are_drawn_apart", |context| {
        let sphere = gobo::scene::Particle { position: [0.0; 3], radius: 0.75, extinction: 0.3 };
        let scene = scenes::directional("copies", [0.0, 0.0, -1.0], vec![sphere; 4]);
        let [mean, squares] = errors(context, &scene, "stochastic:samples=16,size=64", |t| t * (1.0 - t) / 16.0);
        assert!(mean.abs() < 4.0 && (squares - 1.0).abs() < 0.15, "{mean}, {squares}");
    });
}
