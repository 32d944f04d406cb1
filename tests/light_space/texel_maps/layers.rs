//! Optical depth in layers: each path, range and storage against its CPU twin, texel by texel; the same bytes for any order of casters;
//! error against the truth.

use super::{ARITHMETIC, cases, each_texel};
use crate::support::{self, gpu_test_needing, scenes, some, spec};
use gobo::bench::point_error;
use gobo::gpu::{Context, Requirement};
use gobo::maps::TexelWay::{self, Binned, Raster};
use gobo::maps::level_size;
use gobo::query::Query;
use gobo::reference::truth::{Casters, map_truths};
use gobo::reference::twin::layers::Texel;
use gobo::reference::twin::sums::DARK;
use gobo::reference::twin::texel_sums::Range;
use gobo::scene::{Scene, View};
use gobo::technique::layers::{self, Settings, Storage};
use gobo::technique::{Layers, Opened, Technique, open};
use gobo::world::World;
use half::f16;

const NEEDS: [Requirement; 1] = [Requirement::FragmentStores];

/// Largest difference between two f32 computations of the same depth.
const DEPTH_ROUNDING: f32 = 2e-5;

/// Depths at which texels are compared.
const DEPTHS: u32 = 33;

/// Returns the words after a build, and the maps' views.
fn words(context: &Context, scene: &Scene, settings: &Settings) -> (Vec<u32>, Vec<View>) {
    let text = &format!("{settings:?}");
    let world = World::new(context, scene).expect("room for the scene");
    let layers = support::opened(Layers::new(context, &world, settings), text);
    let mut opened = Opened::new(context, Box::new(layers), true);
    opened.build(&world).expect(text);
    let buffer = opened.technique.texels.words.clone();
    let read = || buffer.read::<u32>(buffer.bytes() as usize / 4).expect("read");
    let all = read();
    opened.rebuild(&world).expect(text);
    assert!(all == read(), "{} {text}: the second build differs", world.name());
    let views = opened.technique.inspect().maps().iter().map(|m| m.caster_view).collect();
    (all, views)
}

fn range(settings: &Settings) -> Range {
    match settings.range {
        layers::Range::Scene => Range::Scene,
        layers::Range::Front => Range::Front,
        layers::Range::Texel => Range::Texel,
    }
}

/// Decodes a stored texel.
fn stored<const N: usize>(words: &[u32], settings: &Settings) -> Texel<N> {
    let (kept, sums) = words.split_at(settings.range as usize);
    let half = |k: usize| (sums[k / 2] >> (16 * (k % 2))) as u16;
    let optical_depth = |k| match settings.storage {
        Storage::F32 => f32::from_bits(sums[k]),
        Storage::F16 => f16::from_bits(half(k)).to_f32(),
        Storage::Fixed => f32::from(half(k)) / 65535.0 * DARK,
    };
    let range = match kept {
        [] => [0.0, 1.0],
        [front] => [f32::from_bits(*front), 1.0],
        [front, back, ..] => [*front, *back].map(f32::from_bits),
    };
    Texel { of: self::range(settings), range, optical_depths: std::array::from_fn(optical_depth) }
}

/// Returns the largest rounding of a transmittance by a storage: τ exp(−τ) is at most 1/e.
fn step(storage: Storage) -> f32 {
    match storage {
        Storage::F32 => 0.0,
        // Rounding up or down is allowed.
        Storage::F16 => 1.0 / 1024.0 / std::f32::consts::E,
        Storage::Fixed => DARK / 65535.0,
    }
}

fn equal_their_twins<const N: usize>(context: &Context, scene: &Scene, settings: &Settings) {
    let what = format!("{} {settings:?}", scene.name);
    let (words, views) = words(context, scene, settings);
    let (each, mut covered) = (settings.words() as usize, 0);
    each_texel(scene, &views, |place, view, at, met, bound| {
        let of = range(settings);
        let (twin, blends) = match settings.path {
            Some(TexelWay::Binned) => (Texel::<N>::binned(of, (view, at, met, bound)), 0),
            _ => (Texel::<N>::drawn(of, (view, at, met)), met.len()),
        };
        // Fixed point saturates where no light is left, which matters for interpolation between two ends.
        let twin = twin.kept(|sum| if settings.storage == Storage::Fixed { sum.min(DARK) } else { sum });
        let found = stored::<N>(&words[place * each..][..each], settings);
        for i in 0..DEPTHS {
            let depth = i as f32 / (DEPTHS - 1) as f32;
            let [far, near] = [DEPTH_ROUNDING, -DEPTH_ROUNDING].map(|off| twin.transmittance(depth + off));
            let tolerance = step(settings.storage) + ARITHMETIC + blends as f32 * f32::EPSILON;
            let found = found.transmittance(depth);
            assert!(
                (far - tolerance..=near + tolerance).contains(&found),
                "{what} {at:?} {depth}: {found}, not {far} to {near}\n{twin:?}"
            );
        }
        covered += u32::from(twin.transmittance(1.0) < 0.99);
    });
    assert!(covered > 20, "{what}: {covered} texels are covered");
}

#[test]
fn layers_equal_their_twins() {
    if crate::support::is_costly("layers_equal_their_twins") {
        return;
    }
    gpu_test_needing("layers_equal_their_twins", &NEEDS, |context| {
        // Rasterized half floats round at each caster.
        let ways = if context.features().float32_blend { vec![Binned, Raster] } else { vec![Binned] };
        for (scene, size) in cases() {
            for path in ways.iter().copied().map(Some) {
                let of = |layers, range, storage| Settings { path, layers, range, storage, size, ..Default::default() };
                equal_their_twins::<8>(context, &scene, &of(8, layers::Range::Texel, Storage::F32));
                equal_their_twins::<16>(context, &scene, &of(16, layers::Range::Texel, Storage::Fixed));
                equal_their_twins::<4>(context, &scene, &of(4, layers::Range::Front, Storage::F16));
                equal_their_twins::<32>(context, &scene, &of(32, layers::Range::Scene, Storage::F16));
            }
        }
    });
}

/// Each texel of a level of detail equals the twin's for the device's four texels below, and transmits as much as their mean.
fn levels_equal_their_twins<const N: usize>(context: &Context, scene: &Scene, settings: &Settings) {
    let (words, views) = words(context, scene, settings);
    let (each, of) = (settings.words() as usize, range(settings));
    let size = |level| level_size([views[0].width, views[0].height], level);
    let texels = |level| size(level).iter().product::<u32>() as usize * views.len();
    let (mut first, mut covered) = (0, 0);
    for level in 1..settings.levels {
        let ([w, h], [width, height]) = (size(level - 1), size(level));
        let next = first + texels(level - 1);
        let at = |place: usize| stored::<N>(&words[place * each..][..each], settings);
        for i in 0..texels(level) {
            let [map, y, x] = [i as u32 / (width * height), i as u32 / width % height, i as u32 % width];
            let below = [0, 1, 2, 3].map(|i| {
                let [x, y] = [2 * x + i % 2, 2 * y + i / 2];
                (x < w && y < h).then(|| at(first + ((map * h + y) * w + x) as usize))
            });
            let (found, twin) = (at(next + i), Texel::merged(of, below));
            let what = format!("{} {settings:?}, level {level}, map {map}, texel {x}, {y}", scene.name);
            let mean = below.iter().map(|t| t.as_ref().map_or(1.0, |t| t.transmittance(1.0))).sum::<f32>() / 4.0;
            let tolerance = step(settings.storage) + 1e-5;
            assert!((found.transmittance(1.0) - mean).abs() <= tolerance, "{what}: {found:?}, {mean} of all light");
            for i in 0..DEPTHS {
                let depth = i as f32 / (DEPTHS - 1) as f32;
                let [far, near] = [DEPTH_ROUNDING, -DEPTH_ROUNDING].map(|off| twin.transmittance(depth + off));
                let found = found.transmittance(depth);
                let expected = far - tolerance..=near + tolerance;
                assert!(expected.contains(&found), "{what} {depth}: {found}, not {far} to {near}\n{twin:?}");
            }
            covered += u32::from(mean < 0.99);
        }
        first = next;
    }
    assert!(covered > 20, "{} {settings:?}: {covered} texels are covered", scene.name);
}

#[test]
fn levels_of_layers_equal_their_twins() {
    gpu_test_needing("levels_of_layers_equal_their_twins", &NEEDS, |context| {
        let path = Some(Binned);
        for (scene, size) in some(cases(), 2) {
            let of = |layers, range, storage| Settings {
                path,
                layers,
                range,
                storage,
                size,
                levels: 3,
                ..Default::default()
            };
            levels_equal_their_twins::<8>(context, &scene, &of(8, layers::Range::Texel, Storage::F32));
            levels_equal_their_twins::<4>(context, &scene, &of(4, layers::Range::Front, Storage::F16));
            levels_equal_their_twins::<8>(context, &scene, &of(8, layers::Range::Scene, Storage::Fixed));
        }
    });
}

/// Integer sums do not depend on the order of addition.
#[test]
fn order_is_no_matter() {
    gpu_test_needing("order_is_no_matter", &NEEDS, |context| {
        for mut scene in some(vec![scenes::random(), scenes::crowd(), scenes::locks(), scenes::nested()], 2) {
            let each = ["scene", "front", "texel"].map(|range| {
                let settings = spec(&format!("layers:path=binned,layers=8,size=20,range={range}")).settings();
                (words(context, &scene, &settings).0, settings)
            });
            let mut random = scenes::Random::new(8);
            for i in (1..scene.particles.len()).rev() {
                scene.particles.swap(i, random.bits() as usize % (i + 1));
            }
            scene.strands.reverse();
            for (expected, settings) in each {
                assert!(words(context, &scene, &settings).0 == expected, "{}: {settings:?}", scene.name);
            }
        }
    });
}

/// More layers come nearer to the truth; layers between each texel's ends are nearer than those from its front on, and these nearer than
/// those over the whole depth range.
#[test]
fn more_layers_are_nearer_to_the_truth() {
    gpu_test_needing("more_layers_are_nearer_to_the_truth", &NEEDS, |context| {
        let scene = scenes::random();
        let truth = map_truths(&Casters::new(&scene), &scene, &View::volumes(&scene, 32)).remove(0);
        let world = World::new(context, &scene).expect("room for the scene");
        let query = Query::new(context, 0, &truth.points).expect("room for the points");
        let error = |text: &str| {
            let mut opened = support::opened(open(context, &world, &spec(text)), text);
            opened.build(&world).expect(text);
            let answers = query.ask(&opened.technique.answer()).expect("asked");
            let error = point_error(&answers, &truth.visibility).expect("numbers").expect("points");
            println!("{text}: {error:?}");
            error.mean_abs
        };
        for path in ["binned", "raster"] {
            let of =
                |layers: u32, range: &str| error(&format!("layers:path={path},layers={layers},range={range},size=32"));
            let each = [4, 8, 16, 32].map(|layers| of(layers, "texel"));
            assert!(each.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{path}: {each:?}");
            assert!(each[3] < 1e-3, "{path}: {each:?}");
            let [scene, front] = ["scene", "front"].map(|range| of(8, range));
            assert!(each[1] < front && front < scene, "{path}: {} against {front} and {scene}", each[1]);
        }
    });
}
