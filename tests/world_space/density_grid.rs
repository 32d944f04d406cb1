//! Density grids: strand directions in voxels against their twin, word for word; marches through the grid against the twin's marches;
//! statistics of ratio tracking; and a closed form for fibres.

mod splats;
use crate::support::{ask, gpu_test, scenes, scenes::Random, some, spec};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::reference::truth::Casters;
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::media::{Media, UNITS};
use gobo::reference::twin::soft::{Directions, Soft, way};
use gobo::scene::{Alpha, AlphaMode, Light, LightKind, Mesh, Particle, Scene, Strand};
use gobo::technique::density_grid::{Direction, March, Settings};
use gobo::technique::{DensityGrid, Opened, open};
use gobo::world::World;

const PLAIN: Settings = Settings { size: 64, march: March::Exact, steps: 64, direction: Direction::None, opaque: None };

fn built(context: &Context, scene: &Scene, settings: Settings) -> (World, Opened<DensityGrid>, Place) {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = DensityGrid::new(context, &world, &settings).expect("opens");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    let data = opened.technique.grid().data().expect("read");
    let place = Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size };
    (world, opened, place)
}

/// Strands along the axes and oblique ones, shorter than a voxel or across the whole grid, so thick and dense that voxels are full, beside
/// smoke.
fn extremes() -> Scene {
    let mut scene = scenes::locks();
    let mut random = Random::new(81);
    for i in 0..200 {
        let (start, by) = (random.point(-0.9, 0.9), random.point(-1.0, 1.0));
        let by = if i % 4 == 0 { [by[0], 0.0, 0.0] } else { by };
        let length = 10f32.powf(random.between(-3.5, -0.05));
        let end = [0, 1, 2].map(|a| (start[a] + length * by[a]).clamp(-0.9, 0.9));
        scene.strands.push(Strand { start, end, radius: [0.001, 0.02][i % 2], opacity: [0.1, 0.9, 1.0][i % 3] });
    }
    let dense = Strand { start: [0.1, 0.2, 0.3], end: [0.12, 0.2, 0.3], radius: 0.05, opacity: 1.0 };
    scene.strands.extend([dense; 400]);
    scene.particles.push(Particle { position: [0.3, 0.0, 0.2], radius: 0.4, extinction: 2.0 });
    scene
}

#[test]
fn directions_equal_their_twin() {
    gpu_test("directions_equal_their_twin", |context| {
        for scene in some([extremes(), scenes::strands(), scenes::locks()], 2) {
            let settings = Settings { direction: Direction::Mean, ..PLAIN };
            let (world, mut opened, place) = built(context, &scene, settings);
            let media = Media::deposit(&scene.casters(), &place);
            let directions = Directions::deposit(&scene.casters(), &place, &media);
            for build in 0..2 {
                let (voxels, bits) = opened.technique.grid().media().expect("read").expect("there is hair");
                assert!(voxels == media.voxels && bits == media.bits.words, "{}, build {build}", scene.name);
                assert!(opened.technique.grid().directions().expect("read") == directions.words, "{}", scene.name);
                opened.rebuild(&world).expect("built");
            }
            // With hair alone, the traces of the strands' matrices sum to the voxels' sum, except that each addend is rounded down: a trace
            // has three numbers, each stored with two bits fewer.
            if scene.particles.is_empty() {
                let sum: f64 = media.voxels.iter().map(|v| f64::from(*v)).sum();
                let traces =
                    directions.words.chunks_exact(6).map(|m| m[..3].iter().map(|v| f64::from(*v)).sum::<f64>());
                let share = 4.0 * traces.sum::<f64>() / sum;
                assert!(sum > 0.0 && (0.97..=1.0001).contains(&share), "{}: {share}", scene.name);
            }
        }
    });
}

/// Sheets of constant alpha, larger and smaller than a voxel, one of which is opaque: media and normals equal their twin.
#[test]
fn sheets_equal_their_twin() {
    gpu_test("sheets_equal_their_twin", |context| {
        let mut scene = scenes::cards(5);
        for (i, mesh) in scene.meshes.iter_mut().enumerate().skip(1) {
            let alpha = mesh.alpha.as_mut().expect("a card");
            *alpha = Alpha::constant(AlphaMode::SeeThrough, [0.1, 0.5, 0.9, 1.0][i % 4], 4);
            if i % 3 == 0 {
                let [x, y, z] = mesh.positions[0];
                let nearer = |at: &[f32; 3]| [x + 0.02 * (at[0] - x), y + 0.02 * (at[1] - y), z + 0.02 * (at[2] - z)];
                mesh.positions = mesh.positions.iter().map(nearer).collect();
            }
        }
        let corner = |mesh: &Mesh, i: u32| mesh.positions[i as usize];
        let of_mesh = |mesh: &Mesh| mesh.triangles.iter().map(|t| t.map(|i| corner(mesh, i))).collect::<Vec<_>>();
        let triangles: Vec<_> = scene.meshes.iter().flat_map(of_mesh).collect();
        let settings = Settings { direction: Direction::Mean, ..PLAIN };
        let (_, opened, place) = built(context, &scene, settings);
        let media = Media::deposit_all(&scene.casters(), &triangles, &place);
        let normals = Directions::of_sheets(&scene.casters(), &triangles, &place, &media);
        let (voxels, bits) = opened.technique.grid().media().expect("read").expect("there is glass");
        assert!(voxels == media.voxels && bits == media.bits.words, "media");
        assert!(opened.technique.grid().directions().expect("read") == normals.words, "normals");
        assert!(voxels.iter().filter(|voxel| **voxel > 0).count() > 500);
    });
}

/// A grid whose size is not a power of two occupies the middle of one whose size is. It is placed by the casters' bounding box; its voxels
/// and marches equal the twin's.
#[test]
fn sizes_between_powers_of_two_are_fitted() {
    gpu_test("sizes_between_powers_of_two_are_fitted", |context| {
        for scene in some([scenes::locks(), scenes::random()], 1) {
            let ends = |c: &gobo::scene::Caster| [c.start(), c.end()].map(|end| (end, f64::from(c.radius)));
            let all: Vec<_> = scene.casters().iter().flat_map(ends).collect();
            let side = |axis: usize| {
                let most = all.iter().map(|(end, radius)| end[axis] + radius).fold(f64::NEG_INFINITY, f64::max);
                most - all.iter().map(|(end, radius)| end[axis] - radius).fold(f64::INFINITY, f64::min)
            };
            let widest = (0..3).map(side).fold(0.0, f64::max);
            for (size, voxels) in some([(48, 64), (32, 64), (96, 128), (192, 256)], 2) {
                let (_, opened, place) = built(context, &scene, Settings { size, ..PLAIN });
                let what = format!("{}, size {size}", scene.name);
                assert_eq!(place.size, voxels, "{what}");
                let times = f64::from(place.voxel) * f64::from(size - 2) / widest;
                assert!((times - 1.0).abs() < 1e-5, "{what}: {times} of the widest side");
                let media = Media::deposit(&scene.casters(), &place);
                let (found, bits) = opened.technique.grid().media().expect("read").expect("there are casters");
                assert!(found == media.voxels && bits == media.bits.words, "{what}");
                let soft = Soft { media: &media, directions: None, size: voxels };
                let mut random = Random::new(85);
                let points: Vec<_> = (0..600).map(|_| random.point(-1.3, 1.3)).collect();
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let off = points.iter().zip(&answers).filter(|(point, answer)| {
                    let (from, way) = way(&place, &scene.lights[0], **point);
                    (**answer - (-soft.march_exact(from, way)).exp()).abs() > 5e-4
                });
                let off = off.count();
                let dark = answers.iter().filter(|answer| **answer < 0.9).count();
                // A ray along the side of a full voxel may hit or miss it.
                assert!(off < 9 && dark > 20, "{what}: {off} unsure, {dark} dark");
            }
        }
    });
}

/// Look-ups equal the twin's for all lights and ways to march, in full voxels, in mixed scenes and in smoke alone.
#[test]
fn ways_equal_their_twin() {
    gpu_test("ways_equal_their_twin", |context| {
        let mut lamps = scenes::four_lights();
        lamps.strands = scenes::locks().strands;
        for scene in some([extremes(), lamps, scenes::random()], 2) {
            for (march, direction) in
                [(March::Exact, Direction::None), (March::Exact, Direction::Mean), (March::Steps, Direction::Mean)]
            {
                let (_, opened, place) = built(context, &scene, Settings { march, direction, ..PLAIN });
                let media = Media::deposit(&scene.casters(), &place);
                let directions = Directions::deposit(&scene.casters(), &place, &media);
                let directions = (direction == Direction::Mean).then_some(&directions);
                let soft = Soft { media: &media, directions, size: 64 };
                let mut random = Random::new(82);
                for (light, of) in scene.lights.iter().enumerate() {
                    let points: Vec<_> = (0..600).map(|_| random.point(-1.3, 1.3)).collect();
                    let answers = ask(context, opened.technique.as_ref(), light, &points);
                    let mut unsure = 0;
                    for (point, answer) in points.iter().zip(answers) {
                        let (from, way) = way(&place, of, *point);
                        let taken = match march {
                            March::Steps => soft.march_steps(from, way, 64),
                            _ => soft.march_exact(from, way),
                        };
                        unsure += usize::from((answer - (-taken).exp()).abs() > 5e-4);
                    }
                    // A ray along the side of a full voxel may hit or miss it.
                    assert!(unsure < 9, "{}, light {light}, {march:?}, {direction:?}: {unsure} unsure", scene.name);
                }
            }
        }
    });
}

/// Ratio tracking is unbiased and has its theoretical variance. Points in a small square have almost the same ray, but sample it
/// independently.
#[test]
fn ratio_tracking_has_its_mean_and_variance() {
    gpu_test("ratio_tracking_has_its_mean_and_variance", |context| {
        let scene = scenes::random();
        let (_, opened, place) = built(context, &scene, Settings { march: March::Ratio, ..PLAIN });
        let media = Media::deposit(&scene.casters(), &place);
        let soft = Soft { media: &media, directions: None, size: 64 };
        let most = media.voxels.iter().max().map_or(0.0, |most| *most as f32 / UNITS);
        assert!(most > 0.0 && most < 8.0, "{most}");
        let mut random = Random::new(83);
        let mut shadowed = 0;
        for place_of in 0..12 {
            let centre = random.point(-0.6, 0.6);
            let points: Vec<_> =
                (0..4000).map(|_| [0, 1, 2].map(|i| centre[i] + random.between(-1e-3, 1e-3))).collect();
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let (from, way) = way(&place, &scene.lights[0], centre);
            let [mean, square] = soft.ratio(from, way, most);
            let variance = square - mean * mean;
            let n = points.len() as f64;
            let found = answers.iter().map(|a| f64::from(*a)).sum::<f64>() / n;
            let moment = |power| answers.iter().map(|a| (f64::from(*a) - mean).powi(power)).sum::<f64>() / n;
            let (spread, fourth) = (moment(2), moment(4));
            // Neighbouring rays differ in proportion to the square's width.
            let error = 4.0 * (variance / n).sqrt() + 2e-3;
            assert!((found - mean).abs() < error, "place {place_of}: {found}, not {mean} ± {error}");
            let error = 4.0 * ((fourth - spread * spread) / n).sqrt() + 1e-3;
            assert!((spread - variance).abs() < error, "place {place_of}: {spread}, not {variance} ± {error}");
            shadowed += usize::from(variance > 1e-3);
        }
        assert!(shadowed > 3, "{shadowed}");
    });
}

/// A block of thin strands, all along x. Seen along y each covers, on average, 2 r times its length; seen along x, nothing. So the block's
/// optical depth follows from the number of strands. Without directions it is π/4 of that along both axes.
#[test]
fn fibres_take_light_across_and_not_along() {
    gpu_test("fibres_take_light_across_and_not_along", |context| {
        let mut random = Random::new(84);
        let mut scene = scenes::directional("combed", [0.0, 1.0, 0.0], Vec::new());
        let along = LightKind::Directional { direction: DVec3::X };
        scene.lights.push(Light { kind: along, radiance: [1.0; 3], radius: f64::INFINITY });
        let (radius, opacity, count) = (0.002f32, 0.5f32, 3000);
        for i in 0..count {
            // As evenly spread as possible.
            let (y, z) = ((i as f32 * 0.618_034).fract() - 0.5, (i as f32 + 0.5) / count as f32 - 0.5);
            scene.strands.push(Strand { start: [-1.0, y, z], end: [1.0, y, z], radius, opacity });
        }
        let across = f64::from(count) * 2.0 * f64::from(radius) * f64::from(opacity);
        let points: Vec<_> = (0..400).map(|_| random.point(-0.3, 0.3)).map(|[x, _, z]| [x, 0.8, z]).collect();
        for (direction, expected) in
            [(Direction::None, across * 0.25 * std::f64::consts::PI), (Direction::Mean, across)]
        {
            let (_, opened, _) = built(context, &scene, Settings { direction, ..PLAIN });
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let found = answers.iter().map(|a| -f64::from(*a).ln()).sum::<f64>() / points.len() as f64;
            assert!((found / expected - 1.0).abs() < 0.05, "{direction:?}: {found}, not {expected}");
            // Looks along the strands, from one end to the other.
            let ends: Vec<_> = points.iter().map(|[x, _, z]| [1.5, *x, *z]).collect();
            let answers = ask(context, opened.technique.as_ref(), 1, &ends);
            let least = answers.iter().fold(1.0f32, |least, a| least.min(*a));
            assert!((least > 0.95) == (direction == Direction::Mean), "{direction:?}: {least}");
        }
    });
}

/// Both grids hold only smoke and hair: below a plate there is no light, and beside and above it the light is as in the same scene without
/// the plate.
#[test]
fn meshes_end_the_light_of_both_grids() {
    if crate::support::is_costly("meshes_end_the_light_of_both_grids") {
        return;
    }
    gpu_test("meshes_end_the_light_of_both_grids", |context| {
        let bare = scenes::directional("bare", [0.0, 0.0, -1.0], scenes::random().particles);
        let mut walled = bare.clone();
        let (height, half, [x, y]) = (0.3, 0.4, [0.1, -0.2]);
        walled.meshes.push(scenes::level(height, half, [x, y]));
        let mut random = Random::new(86);
        let points: Vec<_> = (0..4000).map(|_| random.point(-1.2, 1.2)).collect();
        for (text, opaque) in [("density-grid:size=64", "raster"), ("density-grid:size=64,march=ratio", "compute")]
            .into_iter()
            .chain([("optical-depth-grid:cells=32", "raster"), ("optical-depth-grid:cells=32", "compute")])
        {
            let text = format!("{text},opaque={opaque}");
            let [before, after] = [&bare, &walled].map(|scene| {
                let world = World::new(context, scene).expect("room for the scene");
                let mut opened = crate::support::opened(open(context, &world, &spec(&text)), &text);
                opened.build(&world).expect("built");
                ask(context, opened.technique.as_ref(), 0, &points)
            });
            let (mut dark, mut shadowed) = (0, 0);
            for ((point, before), after) in points.iter().zip(before).zip(after) {
                let out = (point[0] - x).abs().max((point[1] - y).abs()) - half;
                // Excludes points within two map texels of the plate's outline, where either light is right.
                if out.abs() < 0.02 || (point[2] - height).abs() < 0.02 {
                    continue;
                }
                let below = out < 0.0 && point[2] < height;
                assert!(after == if below { 0.0 } else { before }, "{text}: {after}, not {before}, at {point:?}");
                dark += usize::from(below);
                shadowed += usize::from(!below && before < 0.9);
            }
            assert!(dark > 100 && shadowed > 100, "{text}: {dark}, {shadowed}");
        }
    });
}

/// A coarse comparison with the truth: finer grids are nearer to it.
#[test]
fn finer_grids_are_nearer_to_the_truth() {
    gpu_test("finer_grids_are_nearer_to_the_truth", |context| {
        let scene = scenes::random();
        let truth = Casters::new(&scene);
        let mut random = Random::new(85);
        let points: Vec<_> = (0..2000).map(|_| random.point(-1.0, 1.0)).collect();
        let errors = [64, 128].map(|size| {
            let (_, opened, _) = built(context, &scene, Settings { size, ..PLAIN });
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let off = |(point, answer): (&[f32; 3], f32)| {
                (f64::from(answer) - truth.visibility(0, DVec3::from(point.map(f64::from)))).abs()
            };
            points.iter().zip(answers).map(off).sum::<f64>() / points.len() as f64
        });
        println!("mean error at 64 and 128: {errors:?}");
        assert!(errors[1] < 0.7 * errors[0] && errors[0] < 0.02, "{errors:?}");
    });
}

/// The mean distance from the midpoint of a strand of `hair` to the nearest axis of another hair: the unit of voxel widths in the sweep of
/// docs/notebook/density-grid.md, whose table must have exactly these ratios.
#[test]
fn voxels_are_so_many_spacings_wide() {
    const SPACING: f64 = 0.0129;
    const OF_A_HAIR: usize = 16;
    let scene = Scene::load("hair", 20.0).expect("built in");
    let ends: Vec<[DVec3; 2]> =
        scene.strands.iter().map(|s| [s.start, s.end].map(|p| DVec3::from(p.map(f64::from)))).collect();
    let nearest = |i: usize| {
        let middle = 0.5 * (ends[i][0] + ends[i][1]);
        let others = ends.iter().enumerate().filter(|(other, _)| other / OF_A_HAIR != i / OF_A_HAIR);
        let square = |[start, end]: &[DVec3; 2]| {
            let (axis, to) = (*end - *start, middle - *start);
            (to - axis * (to.dot(axis) / axis.length_squared()).clamp(0.0, 1.0)).length_squared()
        };
        others.map(|(_, ends)| square(ends)).fold(f64::INFINITY, f64::min).sqrt()
    };
    // A prime step, so that all positions along a hair are sampled.
    let all: Vec<f64> = (0..ends.len()).step_by(if crate::support::all() { 11 } else { 61 }).map(nearest).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let wide = |axis: usize| {
        let along = || ends.iter().flatten().map(|end| end[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let widest = (0..3).map(wide).fold(0.0, f64::max) + 2.0 * f64::from(scene.strands[0].radius);
    println!("{} strands: {mean:.5} from the nearest; {widest:.4} wide", all.len());
    // The usual loop measures only a sample of the strands.
    assert!((mean / SPACING - 1.0).abs() < if crate::support::all() { 0.01 } else { 0.06 }, "{mean}");
    let page = std::fs::read_to_string("docs/notebook/density-grid.md").expect("the page");
    for size in [32, 48, 64, 96, 128, 192, 256] {
        let row = format!("| {size} | {:.1} |", widest / f64::from(size - 2) / SPACING);
        println!("{row}");
        assert!(page.contains(&row), "{row}");
    }
}
