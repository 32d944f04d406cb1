//! Fourier series, moments and wavelets of optical depth: stored numbers against the CPU twins' sums, texel by texel, and look-ups against
//! the twins' look-ups of the same numbers; the same bytes for any order of casters; error against the truth.

use super::{cases, each_texel};
use crate::support::{self, gpu_test_needing, scenes, some, spec};
use glam::DVec2;
use gobo::bench::point_error;
use gobo::gpu::{Context, Requirement};
use gobo::maps::{Sums, level_size};
use gobo::query::Query;
use gobo::reference::truth::{Casters, map_truths};
use gobo::reference::twin::moments::{Basis, bias};
use gobo::reference::twin::texel_sums::{Below, Curve, Range, binned, drawn, place};
use gobo::reference::twin::{fourier, moments, wavelet};
use gobo::scene::{Scene, View};
use gobo::technique::{Fourier, Moments, Opened, Technique, TexelMap, Wavelet, open};
use gobo::world::World;
use half::f16;

const NEEDS: [Requirement; 1] = [Requirement::FragmentStores];

/// Largest difference between two f32 computations of the same depth.
const DEPTH_ROUNDING: f32 = 2e-5;

/// A technique with its settings, and its twins.
struct Twin<const N: usize> {
    spec: &'static str,
    parts: fn([f32; 2], f32) -> [f32; N],
    optical_depth: fn(&[f32; N], f32) -> f32,
    /// Maximum derivative of sum k with respect to a caster's position in the range, for an optical depth of 1.
    steepness: fn(usize) -> f32,
    /// Error bound of a look-up from rounding. For moments, the condition number of the inverted matrix is about the reciprocal of the
    /// bias.
    answers: f32,
}

/// A built technique with its words.
struct Built {
    technique: Box<dyn Technique>,
    words: Vec<u32>,
    views: Vec<View>,
}

fn built(context: &Context, scene: &Scene, text: &str) -> Built {
    fn of<S: Clone + Send + 'static>(
        context: &Context,
        world: &World,
        opened: gobo::Result<TexelMap<S, Sums>>,
        text: &str,
    ) -> Built {
        let mut opened = Opened::new(context, Box::new(support::opened(opened, text)), true);
        opened.build(world).expect(text);
        let buffer = opened.technique.texels.words.clone();
        let read = || buffer.read::<u32>(buffer.bytes() as usize / 4).expect("read");
        let words = read();
        opened.rebuild(world).expect(text);
        assert!(words == read(), "{} {text}: the second build differs", world.name());
        let views = opened.technique.inspect().maps().iter().map(|m| m.caster_view).collect();
        Built { technique: opened.technique, words, views }
    }
    let (spec, world) = (spec(text), World::new(context, scene).expect("room for the scene"));
    match spec.entry.name {
        "fourier" => of(context, &world, Fourier::new(context, &world, &spec.settings()), text),
        "wavelet" => of(context, &world, Wavelet::new(context, &world, &spec.settings()), text),
        _ => of(context, &world, Moments::new(context, &world, &spec.settings()), text),
    }
}

impl<const N: usize> Twin<N> {
    fn range(&self) -> Range {
        if self.spec.contains("range=scene") { Range::Scene } else { Range::Texel }
    }

    fn halves(&self) -> bool {
        self.spec.contains("r16f")
    }

    /// Returns whether sums are stored as 16-bit fixed point relative to the first.
    fn fixed(&self) -> bool {
        self.spec.ends_with("r16")
    }

    fn with(&self, path: &str, size: u32) -> String {
        self.spec.replacen(':', &format!(":path={path},size={size},"), 1)
    }

    /// Returns the number of words of a texel's range, and of the whole texel.
    fn words(&self) -> [usize; 2] {
        let range = if self.range() == Range::Scene { 0 } else { 2 };
        [
            range,
            range
                + if self.halves() {
                    N.div_ceil(2)
                } else if self.fixed() {
                    1 + N / 2
                } else {
                    N
                },
        ]
    }

    /// Returns the range and the sums of a stored texel.
    fn stored(&self, words: &[u32]) -> ([f32; 2], [f32; N]) {
        let (range, sums) = words.split_at(self.words()[0]);
        let range = if let [front, back] = range { [*front, *back].map(f32::from_bits) } else { [0.0, 1.0] };
        let bits = |k: usize| (sums[k / 2] >> (16 * (k % 2))) as u16;
        let total = f32::from_bits(sums[0]);
        let sum = |k| {
            if self.halves() {
                f16::from_bits(bits(k)).to_f32()
            } else if self.fixed() && k > 0 {
                total * f32::from(bits(k + 1) as i16) / 32767.0
            } else {
                f32::from_bits(sums[k])
            }
        };
        (range, std::array::from_fn(sum))
    }

    fn stores_what_its_twin_sums(&self, context: &Context, scene: &Scene, path: &str, size: u32) {
        let text = self.with(path, size);
        let what = format!("{} {text}", scene.name);
        let Built { words, views, .. } = built(context, scene, &text);
        let (each, mut covered) = (self.words()[1], 0);
        each_texel(scene, &views, |at_word, view, at, met, bound| {
            let (range, sums) = match path {
                "binned" => binned((view, at, met, bound), self.range(), self.parts),
                _ => drawn((view, at, met), self.range(), self.parts),
            };
            let (found_range, found) = self.stored(&words[at_word * each..][..each]);
            for (found, expected) in found_range.into_iter().zip(range) {
                assert!((found - expected).abs() < DEPTH_ROUNDING, "{what} {at:?}: {found_range:?}, not {range:?}");
            }
            let total = sums.iter().fold(0f32, |most, sum| most.max(sum.abs()));
            let moved = 2.0 * DEPTH_ROUNDING / (range[1] - range[0]).max(DEPTH_ROUNDING);
            let stored = if self.halves() {
                1.0 / 1024.0
            } else if self.fixed() {
                1.0 / 32767.0
            } else {
                0.0
            };
            for (k, (found, expected)) in found.into_iter().zip(sums).enumerate() {
                // Chords of nearly grazing rays lose digits to cancellation, and the sums of opaque casters saturate.
                let rounding = 5e-4 * (1.0 + total) + stored * total;
                let tolerance = rounding + total * (moved * (self.steepness)(k)).min(2.0);
                assert!((found - expected).abs() < tolerance, "{what} {at:?} {k}: {found}, not {expected}");
            }
            covered += u32::from(total > 0.01);
        });
        assert!(covered > 20, "{what}: {covered} texels are covered");
    }

    fn answers_what_is_stored(&self, context: &Context, scene: &Scene, size: u32) {
        let what = format!("{} {}", scene.name, self.spec);
        let Built { technique, words, views } = built(context, scene, &self.with("binned", size));
        let (view, each) = (views[0], self.words()[1]);
        let texels: Vec<_> = (0..size).step_by(3).flat_map(|y| (0..size).map(move |x| [x, y])).collect();
        let depths: Vec<f64> = (0..40).map(|i| f64::from(i) / 38.0 - 0.01).collect();
        let at = |[x, y]: [u32; 2]| view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let point = |texel: &[u32; 2], depth: &f64| at(*texel).at(view.z(*depth)).as_vec3().to_array();
        let points: Vec<_> =
            texels.iter().flat_map(|t| depths.iter().map(|d| point(t, d)).collect::<Vec<_>>()).collect();
        let answers = Query::new(context, 0, &points).expect("room").ask(&technique.answer()).expect("asked");
        let (mut sum, mut most) = (0.0, 0f32);
        for (i, answer) in answers.iter().enumerate() {
            let [x, y] = texels[i / depths.len()];
            let (range, sums) = self.stored(&words[(y * size + x) as usize * each..][..each]);
            let depth = depths[i % depths.len()] as f32;
            let moved = [-DEPTH_ROUNDING, 0.0, DEPTH_ROUNDING]
                .map(|by| (-(self.optical_depth)(&sums, place(range, depth + by))).exp());
            let (low, high) = moved.iter().fold((1f32, 0f32), |(low, high), t| (low.min(*t), high.max(*t)));
            let off = (answer - high).max(low - answer).max(0.0);
            (sum, most) = (sum + off, most.max(off));
            assert!(off < self.answers, "{what} {x},{y} {depth}: {answer}, not {low} to {high}");
        }
        println!("{what}: off by {:.1e}, at most {most:.1e}", sum / answers.len() as f32);
    }

    /// Each texel of a level of detail has the sums of the twin's curve, which is built from the device's own map and, for further levels,
    /// from the twin's curves; and it transmits as much at the far end as the device's four texels below.
    fn levels_are_means(&self, context: &Context, scene: &Scene, size: u32) {
        const LEVELS: u32 = 6;
        let text = format!("{},levels={LEVELS}", self.with("binned", size));
        let Built { words, views, .. } = built(context, scene, &text);
        let (each, maps) = (self.words()[1], views.len() as u32);
        let all: Vec<_> = words.chunks_exact(each).map(|words| self.stored(words)).collect();
        let total = |sums: &[f32; N]| (self.optical_depth)(sums, 1.0);
        let (mut first, mut covered, mut astray) = (0, 0, 0);
        let mut curves: Vec<Curve> = Vec::new();
        for level in 1..LEVELS {
            let [[w, h], [width, height]] =
                [level - 1, level].map(|l| level_size([views[0].width, views[0].height], l));
            let next = first + (w * h * maps) as usize;
            let mut made = Vec::new();
            for i in 0..width * height * maps {
                let [map, y, x] = [i / (width * height), i / width % height, i % width];
                let what = format!("{} {text}, level {level}, map {map}, texel {x}, {y}", scene.name);
                let below = [0, 1, 2, 3].map(|i| {
                    let [x, y] = [2 * x + i % 2, 2 * y + i / 2];
                    (x < w && y < h).then(|| ((map * h + y) * w + x) as usize)
                });
                let depths = below.map(|texel| {
                    let (sums, curve) = (texel.map(|i| all[first + i].1), texel.and_then(|i| curves.get(i)));
                    move |place| match curve {
                        Some(curve) => curve.optical_depth(place),
                        None => sums.map_or(0.0, |sums| (self.optical_depth)(&sums, place)),
                    }
                });
                let ranges = below.map(|texel| texel.map(|i| all[first + i].0));
                let texel = |i: usize| ranges[i].map(|range| -> Below { (range, &depths[i]) });
                let curve = Curve::merged([0, 1, 2, 3].map(texel), self.range());
                let (range, sums) = (curve.range, curve.sums(self.parts));
                made.push(curve);
                let (found_range, found) = all[next + i as usize];
                assert_eq!(found_range, range, "{what}");
                let through = |texel: &Option<usize>| texel.map_or(1.0, |i| (-total(&all[first + i].1)).exp());
                let mean = below.iter().map(through).sum::<f32>() / 4.0;
                let left = (-total(&found)).exp();
                let stored = if self.halves() { 1e-3 } else { 1e-5 };
                assert!((left - mean).abs() < stored, "{what}: {left}, not {mean} behind all");
                let most = sums.iter().fold(0f32, |most, sum| most.max(sum.abs()));
                let tolerance = (1.0 + most) * (5e-4 + 8.0 * self.answers + if self.fixed() { 1e-4 } else { stored });
                // A step in a texel below may fall before or behind a cell's end.
                let is_astray = found.iter().zip(sums).any(|(found, sum)| (found - sum).abs() > tolerance);
                astray += u32::from(is_astray);
                covered += u32::from(mean < 0.99);
            }
            (first, curves) = (next, made);
        }
        println!("{} {text}: {astray} of {covered} astray", scene.name);
        assert!(covered > 20 && 50 * astray <= covered, "{} {text}: {astray} of {covered} astray", scene.name);
    }

    fn check(&self, context: &Context) {
        // Rasterized half floats round at each caster.
        let drawn = context.features().float32_blend && !self.spec.contains("rank=4");
        for (scene, size) in some(cases(), 3) {
            self.stores_what_its_twin_sums(context, &scene, "binned", size);
            if drawn {
                self.stores_what_its_twin_sums(context, &scene, "raster", size);
            }
        }
        for scene in some([scenes::random(), scenes::locks(), scenes::nested()], 2) {
            self.answers_what_is_stored(context, &scene, 20);
            self.levels_are_means(context, &scene, 21);
        }
    }
}

fn circles(k: usize) -> f32 {
    std::f32::consts::TAU * k.div_ceil(2) as f32
}

#[test]
fn fourier_equals_its_twin() {
    if crate::support::is_costly("fourier_equals_its_twin") {
        return;
    }
    gpu_test_needing("fourier_equals_its_twin", &NEEDS, |context| {
        let (parts, optical_depth) = (fourier::parts::<7>, |sums: &[f32; 7], at| fourier::optical_depth(sums, at));
        let twin = Twin { spec: "fourier:coefficients=7", parts, optical_depth, steepness: circles, answers: 1e-4 };
        twin.check(context);
        let (parts, optical_depth) = (fourier::parts::<31>, |sums: &[f32; 31], at| fourier::optical_depth(sums, at));
        let spec = "fourier:coefficients=31,range=scene,storage=r16f";
        Twin { spec, parts, optical_depth, steepness: circles, answers: 1e-4 }.check(context);
    });
}

#[test]
fn wavelet_equals_its_twin() {
    gpu_test_needing("wavelet_equals_its_twin", &NEEDS, |context| {
        let (parts, optical_depth) = (wavelet::parts::<17>, |sums: &[f32; 17], at| wavelet::optical_depth(sums, at));
        Twin { spec: "wavelet:rank=3", parts, optical_depth, steepness: |_| 17.0, answers: 1e-4 }.check(context);
        let (parts, optical_depth) = (wavelet::parts::<33>, |sums: &[f32; 33], at| wavelet::optical_depth(sums, at));
        let spec = "wavelet:rank=4,range=scene,storage=r16f";
        Twin { spec, parts, optical_depth, steepness: |_| 33.0, answers: 1e-4 }.check(context);
    });
}

#[test]
fn moments_equal_their_twins() {
    if crate::support::is_long("moments_equal_their_twins") {
        return;
    }
    gpu_test_needing("moments_equal_their_twins", &NEEDS, |context| {
        fn power<const N: usize>(place: [f32; 2], optical_depth: f32) -> [f32; N] {
            moments::parts(Basis::Power, place, optical_depth)
        }
        fn on_circle<const N: usize>(place: [f32; 2], optical_depth: f32) -> [f32; N] {
            moments::parts(Basis::Trigonometric, place, optical_depth)
        }
        // A Chebyshev polynomial's slope is at most twice the square of its order.
        let steepness: fn(usize) -> f32 = |k| 2.0 * (k * k) as f32;
        let answers = f32::EPSILON / bias(4, false);
        let optical_depth = |s: &[f32; 5], at| moments::optical_depth(s, Basis::Power, 0.45, bias(4, false), at);
        Twin { spec: "moments:moments=4", parts: power, optical_depth, steepness, answers }.check(context);
        let optical_depth = |s: &[f32; 7], at| moments::optical_depth(s, Basis::Power, 0.25, bias(6, true), at);
        let spec = "moments:moments=6,overestimation=25,storage=r16";
        Twin { spec, parts: power, optical_depth, steepness, answers }.check(context);
        let optical_depth = |s: &[f32; 9], at| moments::optical_depth(s, Basis::Power, 0.45, bias(8, false), at);
        Twin { spec: "moments:moments=8,range=scene", parts: power, optical_depth, steepness, answers }.check(context);
        let optical_depth =
            |s: &[f32; 7], at| moments::optical_depth(s, Basis::Trigonometric, 0.45, bias(6, false), at);
        let spec = "moments:moments=6,basis=trigonometric";
        Twin { spec, parts: on_circle, optical_depth, steepness: circles, answers }.check(context);
    });
}

/// Integer sums do not depend on the order of addition.
#[test]
fn series_have_no_order() {
    gpu_test_needing("series_have_no_order", &NEEDS, |context| {
        const SPECS: [&str; 4] =
            ["fourier", "wavelet:range=scene", "moments", "moments:basis=trigonometric,storage=r16"];
        for mut scene in some(vec![scenes::crowd(), scenes::locks(), scenes::random(), scenes::nested()], 2) {
            let text = |spec: &str| {
                let separator = if spec.contains(':') { ',' } else { ':' };
                format!("{spec}{separator}path=binned,size=20")
            };
            let each = SPECS.map(|spec| built(context, &scene, &text(spec)).words);
            let mut random = scenes::Random::new(9);
            for i in (1..scene.particles.len()).rev() {
                scene.particles.swap(i, random.bits() as usize % (i + 1));
            }
            scene.strands.reverse();
            for (expected, spec) in each.into_iter().zip(SPECS) {
                assert!(built(context, &scene, &text(spec)).words == expected, "{}: {spec}", scene.name);
            }
        }
    });
}

/// More numbers come nearer to the truth, and numbers between each texel's ends are nearer than those over the whole depth range. The lower
/// and upper bounds that moments give are far off, a value between the two is near.
#[test]
fn more_numbers_are_nearer_to_the_truth() {
    if crate::support::is_costly("more_numbers_are_nearer_to_the_truth") {
        return;
    }
    gpu_test_needing("more_numbers_are_nearer_to_the_truth", &NEEDS, |context| {
        let scene = scenes::random();
        let truth = map_truths(&Casters::new(&scene), &scene, &View::volumes(&scene, 32)).remove(0);
        let world = World::new(context, &scene).expect("room for the scene");
        let query = Query::new(context, 0, &truth.points).expect("room for the points");
        let error = |text: &str| {
            let text = format!("{text},size=32");
            let mut opened = support::opened(open(context, &world, &spec(&text)), &text);
            opened.build(&world).expect(&text);
            let answers = query.ask(&opened.technique.answer()).expect("asked");
            let error = point_error(&answers, &truth.visibility).expect("numbers").expect("points");
            println!("{text}: {error:?}");
            error
        };
        let falls = |each: [f64; 3], by: f64| assert!(each.windows(2).all(|pair| pair[1] < by * pair[0]), "{each:?}");
        let fourier = [7, 15, 31].map(|n| error(&format!("fourier:coefficients={n}")).mean_abs);
        let wavelet = [2, 3, 4].map(|n| error(&format!("wavelet:rank={n}")).mean_abs);
        falls(fourier, 0.6);
        falls(wavelet, 0.6);
        falls([4, 6, 8].map(|n| error(&format!("moments:moments={n}")).mean_abs), 0.95);
        assert!(fourier[1] < 0.7 * error("fourier:coefficients=15,range=scene").mean_abs);
        assert!(wavelet[1] < 0.7 * error("wavelet:rank=3,range=scene").mean_abs);
        let [light, middle, dark] = [0, 45, 100].map(|o| error(&format!("moments:overestimation={o}")));
        assert!(middle.mean_abs < 0.5 * light.mean_abs && middle.mean_abs < 0.5 * dark.mean_abs);
        assert!(light.bias > Some(0.0) && dark.bias < Some(0.0), "{light:?}, {dark:?}");
    });
}
