//! levels= of techniques that store one texel per ray: each level against the twin of the one below, and look-ups over squares of a lattice
//! of strands, whose mean has a closed form.

use super::cases;
use crate::support::{self, gpu_test_needing, scenes, some, spec};
use glam::{DVec2, DVec3};
use gobo::gpu::{Context, Requirement};
use gobo::maps::level_size;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::Casters;
use gobo::reference::twin::beer_shadow_map::{self as beer, Texel};
use gobo::reference::twin::translucency_map as translucency;
use gobo::scene::{Scene, Strand};
use gobo::technique::{BeerShadowMap, Opened, Technique, TexelMap, TranslucencyMap, open};
use gobo::world::World;
use half::f16;

/// Largest difference due to 32-bit storage and two ways to compute an exponential.
const ARITHMETIC: f32 = 1e-5;

/// Number of levels in all cases.
const LEVELS: u32 = 4;

/// The image's texels as floats, the texels of coarser levels, the size in texels, and the number of maps.
struct Kept {
    image: Vec<[f32; 4]>,
    coarser: Vec<f32>,
    size: [u32; 2],
    maps: u32,
}

fn kept<S: Send>(
    context: &Context,
    scene: &Scene,
    open: impl Fn(&World) -> gobo::Result<TexelMap<S>>,
    text: &str,
) -> Kept {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = Opened::new(context, Box::new(support::opened(open(&world), text)), true);
    opened.build(&world).expect(text);
    let texels = &opened.technique.texels;
    let [width, height] = texels.image.size();
    let image = match texels.image.bytes() / u64::from(width * height) {
        1 => texels.image.read::<u8>().expect("read").into_iter().map(|t| [f32::from(t) / 255.0; 4]).collect(),
        2 => texels.image.read::<u16>().expect("read").into_iter().map(|t| [f16::from_bits(t).to_f32(); 4]).collect(),
        _ => {
            let halves = texels.image.read::<[u16; 4]>().expect("read");
            halves.into_iter().map(|t| t.map(|h| f16::from_bits(h).to_f32())).collect()
        }
    };
    let coarser = texels.coarser.read(texels.coarser.bytes() as usize / 4).expect("read");
    let view = opened.technique.inspect().maps()[0].caster_view;
    Kept { image, coarser, size: [view.width, view.height], maps: height / view.height }
}

impl Kept {
    /// Calls `check` with each texel of each coarser level, `words` floats long, and the four texels below it, which have four floats if
    /// they are the map's own.
    fn each(&self, words: usize, mut check: impl FnMut(&str, &[f32], [Option<Vec<f32>>; 4])) {
        let mut first = 0;
        let mut below: Vec<Vec<f32>> = self.image.iter().map(|t| t.to_vec()).collect();
        for level in 1..LEVELS {
            let ([w, h], [width, height]) = (level_size(self.size, level - 1), level_size(self.size, level));
            let count = (width * height * self.maps) as usize;
            let its: Vec<_> =
                self.coarser[first..first + count * words].chunks_exact(words).map(<[f32]>::to_vec).collect();
            for (i, found) in its.iter().enumerate() {
                let [map, y, x] = [i as u32 / (width * height), i as u32 / width % height, i as u32 % width];
                let four = [0, 1, 2, 3].map(|i| {
                    let [x, y] = [2 * x + i % 2, 2 * y + i / 2];
                    (x < w && y < h).then(|| below[((map * h + y) * w + x) as usize].clone())
                });
                check(&format!("level {level}, map {map}, texel {x}, {y}"), found, four);
            }
            first += count * words;
            below = its;
        }
        assert_eq!(first, self.coarser.len());
    }
}

/// A texel is the mean of the four below it.
#[test]
fn levels_of_translucency_maps_equal_their_twins() {
    gpu_test_needing("levels_of_translucency_maps_equal_their_twins", &[Requirement::ExtendedFormats], |context| {
        for (scene, size) in some(cases(), 2) {
            for way in ["raster,storage=r8", "binned,storage=r16f"] {
                let text = format!("translucency-map:path={way},size={size},levels={LEVELS}");
                let settings = spec(&text).settings();
                let kept = kept(context, &scene, |world| TranslucencyMap::new(context, world, &settings), &text);
                let mut covered = 0;
                kept.each(1, |what, found, four| {
                    let expected = translucency::merged(four.map(|texel| texel.map(|t| t[0])));
                    let what = format!("{} {text}, {what}", scene.name);
                    assert!((found[0] - expected).abs() < ARITHMETIC, "{what}: {found:?}, not {expected}");
                    covered += u32::from(expected < 0.99);
                });
                assert!(covered > 20, "{} {text}: {covered} texels are covered", scene.name);
            }
        }
    });
}

/// A texel transmits as much as the mean of the four below it, at the far end and integrated over depth.
#[test]
fn levels_of_beer_shadow_maps_equal_their_twins() {
    gpu_test_needing("levels_of_beer_shadow_maps_equal_their_twins", &[], |context| {
        for (scene, size) in some(cases(), 2) {
            for way in ["raster", "binned", "binned,front=weighted"] {
                let text = format!("beer-shadow-map:path={way},size={size},levels={LEVELS}");
                let settings = spec(&text).settings();
                let kept = kept(context, &scene, |world| BeerShadowMap::new(context, world, &settings), &text);
                let mut covered = 0;
                kept.each(3, |what, found, four| {
                    let texel = |t: &[f32]| Texel { one_minus_front: t[0], back: t[1], optical_depth: t[t.len() - 1] };
                    let expected = beer::merged(four.map(|t| t.map_or(Texel::default(), |t| texel(&t))));
                    let (what, found) = (format!("{} {text}, {what}", scene.name), texel(found));
                    for i in 0..=20 {
                        let depth = i as f32 / 20.0;
                        let [far, near] = [2e-4, -2e-4].map(|off| expected.transmittance(depth + off));
                        let within = far - ARITHMETIC..=near + ARITHMETIC;
                        let found = found.transmittance(depth);
                        assert!(within.contains(&found), "{what} {depth}: {found}, not {within:?}, {expected:?}");
                    }
                    covered += u32::from(expected.transmittance(2.0) < 0.99);
                });
                assert!(covered > 20, "{} {text}: {covered} texels are covered", scene.name);
            }
        }
    });
}

/// The lattice's pitch, and each strand's opacity.
const PITCH: f32 = 0.07;
const OPACITY: f32 = 0.9;

/// Two lattices of strands under a light from above, one across the other, each covering half of the ground.
fn lattices() -> Scene {
    let mut scene = scenes::directional("lattices", [0.0, 0.0, -1.0], Vec::new());
    let strand = |i: i32, across: bool| {
        let along = |end: f32| if across { [end, PITCH * i as f32, 1.0] } else { [PITCH * i as f32, end, 3.0] };
        Strand { start: along(-2.0), end: along(2.0), radius: PITCH / 4.0, opacity: OPACITY }
    };
    scene.strands = (-28..=28).flat_map(|i| [strand(i, true), strand(i, false)]).collect();
    scene
}

/// Squares far wider than the pitch see each lattice's mean transmittance, whatever a texel stores, not the transmittance of the mean
/// optical depth. Points see a whole strand or none.
#[test]
fn squares_see_what_lattices_leave() {
    if crate::support::is_costly("squares_see_what_lattices_leave") {
        return;
    }
    gpu_test_needing("squares_see_what_lattices_leave", &[Requirement::ExtendedFormats], |context| {
        let scene = lattices();
        let world = World::new(context, &scene).expect("room for the scene");
        let one = 1.0 - 0.5 * OPACITY;
        // Beer shadow maps and series cannot represent the step between the lattices.
        let each = [
            ("translucency-map:storage=r16f", None, None),
            ("beer-shadow-map", Some(1.0), None),
            ("avsm", Some(1.0), Some(0.02)),
            ("layers", Some(1.0), Some(0.02)),
            ("wavelet", Some(1.0), Some(0.02)),
            ("fourier:coefficients=31", Some(1.0), Some(0.06)),
            ("moments", Some(1.0), Some(0.06)),
        ];
        for (name, front, between) in each {
            let separator = if name.contains(':') { ',' } else { ':' };
            let text = format!("{name}{separator}path=binned,size=128,levels=6");
            let mut opened = support::opened(open(context, &world, &spec(&text)), &text);
            opened.build(&world).expect(&text);
            let answers = |z: f32, side: f32| {
                let points: Vec<_> =
                    (0..15).flat_map(|i| (0..15).map(move |k| [i, k].map(|i| 0.13 * (i - 7) as f32))).collect();
                let points: Vec<[f32; 3]> = points.into_iter().map(|[x, y]| [x, y, z]).collect();
                let asked = [PointBatch { light: 0, points: &points, normals: &[] }];
                let query = Query::of_areas(context, &asked, &vec![side; points.len()]).expect("room");
                query.ask(&opened.technique.answer()).expect("answered")
            };
            let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
            let farthest = |all: &[f32], from: f32| all.iter().map(|a| (a - from).abs()).fold(0.0, f32::max);
            // Texels sample strands at their centres: over a square some 28 texels wide, the covered share is slightly off.
            let behind = answers(0.0, 28.0 / 32.0);
            println!("{text}: {} behind, {} between", mean(&behind), mean(&answers(2.0, 28.0 / 32.0)));
            let off = farthest(&behind, one * one);
            assert!(off < 0.05, "{text}: {off} from {} behind both", one * one);
            let points = answers(0.0, 0.0);
            assert!(farthest(&points, one * one) > 0.1, "{text}: points see means");
            if let Some(front) = front {
                assert_eq!(farthest(&answers(3.5, 28.0 / 32.0), front), 0.0, "{text}: in front");
            }
            if let Some(most) = between {
                let between = answers(2.0, 28.0 / 32.0);
                let off = farthest(&between, one);
                assert!(off < 0.05 + most, "{text}: {off} from {one} between them");
            }
        }
    });
}

/// Bundles of dark strands with nothing between them, each strand one or two texels wide.
fn bundles() -> Scene {
    let mut scene = scenes::directional("bundles", [0.0, 0.0, -1.0], Vec::new());
    let mut random = scenes::Random::new(34);
    for _ in 0..24 {
        let [x, y, _] = random.point(-1.8, 1.8);
        for _ in 0..24 {
            let [dx, dy, z] = random.point(-0.1, 0.1);
            let [x, y, z] = [x + dx, y + dy, 2.0 + 20.0 * z];
            let [ex, ey, _] = random.point(-0.2, 0.2);
            let end = [x + ex, y + ey, z];
            scene.strands.push(Strand { start: [x, y, z], end, radius: 0.08, opacity: 0.8 });
        }
    }
    scene
}

/// At a texel's centre, each level is compared with the f64 truth averaged over the rays of all map texels below it. The error falls from
/// level to level, so errors do not accumulate.
#[test]
fn levels_do_not_drift() {
    if crate::support::is_costly("levels_do_not_drift") {
        return;
    }
    gpu_test_needing("levels_do_not_drift", &[], |context| {
        const SIZE: u32 = 32;
        const DEPTHS: u32 = 24;
        let scene = bundles();
        let (world, casters) = (World::new(context, &scene).expect("room for the scene"), Casters::new(&scene));
        for name in
            ["moments", "moments:moments=4", "moments:basis=trigonometric", "fourier", "wavelet", "layers", "avsm"]
        {
            let text = format!("{name}{}path=binned,size={SIZE},levels=6", if name.contains(':') { ',' } else { ':' });
            let mut opened = support::opened(open(context, &world, &spec(&text)), &text);
            opened.build(&world).expect(&text);
            let view = opened.technique.inspect().maps()[0].caster_view;
            let point = |x: f64, y: f64, k: u32| {
                view.ray(DVec2::new(x, y)).at(view.z((f64::from(k) + 0.5) / f64::from(DEPTHS)))
            };
            let ray = |i: u32| {
                let [x, y] = [i / DEPTHS % SIZE, i / DEPTHS / SIZE].map(|i| f64::from(i) + 0.5);
                casters.visibility(0, point(x, y, i % DEPTHS))
            };
            let truths: Vec<f64> = (0..SIZE * SIZE * DEPTHS).map(ray).collect();
            let texel = view.texel_at(DVec3::ZERO).map(DVec3::length);
            let rms = |level: u32| {
                let (wide, per_side) = (1 << level, SIZE >> level);
                let middle = |i: u32| (f64::from(i) + 0.5) * f64::from(wide);
                let places: Vec<_> = (0..per_side * per_side * DEPTHS)
                    .map(|i| [i / DEPTHS % per_side, i / DEPTHS / per_side, i % DEPTHS])
                    .collect();
                let points: Vec<_> =
                    places.iter().map(|[x, y, k]| point(middle(*x), middle(*y), *k).as_vec3().to_array()).collect();
                let asked = [PointBatch { light: 0, points: &points, normals: &[] }];
                // A look-up picks a level that is finer by half a level.
                let side = (texel[0] * texel[1]).sqrt() * f64::from(wide) * 2f64.sqrt();
                let query = Query::of_areas(context, &asked, &vec![side as f32; points.len()]).expect("room");
                let answers = query.ask(&opened.technique.answer()).expect("answered");
                let square = |([x, y, k], answer): (&[u32; 3], &f32)| {
                    let below = |i: u32| [x * wide + i % wide, y * wide + i / wide];
                    let truth = |[x, y]: [u32; 2]| truths[((y * SIZE + x) * DEPTHS + k) as usize];
                    let mean = (0..wide * wide).map(|i| truth(below(i))).sum::<f64>() / f64::from(wide * wide);
                    (f64::from(*answer) - mean).powi(2)
                };
                let squares: f64 = places.iter().zip(&answers).map(square).sum();
                (squares / places.len() as f64).sqrt()
            };
            let each = [1, 2, 3, 4, 5].map(rms);
            println!("{text}: {each:.4?}");
            assert!(each.windows(2).all(|pair| pair[1] < pair[0]), "{text}: {each:?}");
        }
    });
}
