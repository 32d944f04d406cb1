//! Grid queries: lists of casters against their twin, word for word, and look-ups against the truth, up to rounding.

use crate::support::{ask, built, gpu_test, gpu_test_needing, scenes, some};
use glam::DVec3;
use gobo::gpu::{Context, Requirement};
use gobo::grid::caster_share;
use gobo::reference::truth::{Casters, space_points};
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::lists::caster_lists;
use gobo::reference::twin::ray_query::{boxed, hit_seed, hit_share};
use gobo::reference::twin::splat::cast_depth;
use gobo::scene::{Caster, Light, LightKind, Particle, Scene};
use gobo::technique::{GridQuery, Opened, RayQuery, grid_query, ray_query};
use gobo::world::World;
use std::f64::consts::PI;

/// Everything that may trip up a voxel's list: spheres that fill the grid and spheres as small as points, on voxel corners and twice in the
/// same place, dense and thin; lights along axes and inside the smoke.
fn adversarial() -> Scene {
    let at = |position: [f32; 3], radius, extinction| Particle { position, radius, extinction };
    let mut particles = vec![at([0.0; 3], 1.0, 0.3), at([0.0; 3], 1.0, 0.3), at([0.0; 3], 0.999, 0.1)];
    for i in 0..5u16 {
        let x = f32::from(i) * 0.25 - 0.5;
        particles.push(at([x, x, x], 1.0 / 64.0, 20.0));
        particles.push(at([x, -x, 0.5], 1e-4, 3000.0));
        particles.push(at([-x, x, x], 0.25, 2.0));
    }
    particles.push(at([0.3, 0.2, -0.8], 0.1, 1e4));
    let mut scene = scenes::directional("adversarial", [0.0, 0.0, -1.0], particles);
    let light = |kind| Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
    let directions = [[-1.0, 0.0, 0.0], [1.0, 1.0, -1.0], [1e-5, -1e-7, -1.0], [0.3, -0.8, -0.4]];
    let direction = |d| LightKind::Directional { direction: DVec3::from(d).normalize() };
    let places = [[0.3, 0.4, 0.2], [0.0, 0.0, 3.0], [-9.0, 4.0, 7.0]].map(DVec3::from);
    let kinds = directions.map(direction).into_iter().chain(places.map(|position| LightKind::Point { position }));
    scene.lights.extend(kinds.map(light));
    scene
}

fn cases() -> Vec<Scene> {
    let lamp = scenes::point([0.1, 0.2, 0.4], scenes::random());
    let cases = [
        adversarial(),
        large_and_small(),
        scenes::locks(),
        scenes::random(),
        lamp,
        scenes::four_lights(),
        scenes::strands(),
        scenes::opaque(),
        scenes::nested(),
        scenes::inside(),
    ];
    some(cases, 5)
}

/// Spheres, every thirtieth of which covers so many voxels that every device lists it for all voxels.
fn large_and_small() -> Scene {
    let mut random = scenes::Random::new(17);
    let one = |i: u32| Particle {
        position: random.point(-0.7, 0.7),
        radius: if i % 30 == 7 { 1.0 } else { 0.06 },
        extinction: if i % 30 == 7 { 0.005 } else { 0.5 },
    };
    scenes::directional("large and small", [0.5, 0.3, -0.81], (0..3000).map(one).collect())
}

fn opened(context: &Context, scene: &Scene, size: u32) -> (World, Opened<GridQuery>) {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = GridQuery::new(context, &world, &grid_query::Settings { size }).expect("opens");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    (world, opened)
}

/// Bits and lists equal the twin's word for word, in every build, in whatever order the threads run.
#[test]
fn caster_lists_equal_their_twin() {
    gpu_test("caster_lists_equal_their_twin", |context| {
        for scene in cases() {
            for size in some([64, 128], 1) {
                let (world, mut opened) = opened(context, &scene, size);
                let data = opened.technique.grid().data().expect("read");
                let place = Place { origin: data.origin, voxel: data.voxel, per_unit: data.per_unit, size: data.size };
                let share = caster_share(context, scene.casters().len() as u32);
                let (bits, words) = caster_lists(&scene.casters(), &place, share);
                if scene.name == "large and small" {
                    let start = words[(size / 4).pow(3) as usize] as usize;
                    // Two words per caster, and a box after each start.
                    assert_eq!(words[start + 2] - words[start], 2 * 100, "of 3,000 are listed for all");
                }
                for build in 0..2 {
                    let found = opened.technique.grid().listed_casters().expect("read");
                    assert!(found.0 == bits.words, "{}, size {size}, build {build}: bits", scene.name);
                    assert!(found.1 == words, "{}, size {size}: {} words", scene.name, words.len());
                    opened.rebuild(&world).expect("built");
                }
            }
        }
    });
}

/// Compares look-ups with the truth, with an error bound of 1e-6 on the mean. A ray that grazes a sphere has larger errors, because the
/// chord's square is a small difference of numbers of the scene's size, each rounded. A ray that grazes a strand may hit or miss it.
fn holds(context: &Context, scene: &Scene, text: &str) {
    holds_to(context, scene, text, 1e-6);
}

/// Same as [`holds`], with another error bound: rounding errors accumulate in sums of many equal numbers, all rounded in the same
/// direction.
fn holds_to(context: &Context, scene: &Scene, text: &str, most: f64) {
    let truth = Casters::new(scene);
    let technique = built(context, scene, text);
    for light in 0..scene.lights.len() {
        let what = format!("{} {text}, light {light}", scene.name);
        let points = space_points(scene, light, 2000);
        let answers = ask(context, technique.as_ref(), light, &points);
        let (mut sum, mut off) = (0.0, 0);
        for (point, answer) in points.iter().zip(answers) {
            let expected = truth.visibility(light, DVec3::from(point.map(f64::from)));
            let error = (f64::from(answer) - expected).abs();
            sum += error.min(1e-3);
            off += usize::from(error > 1e-4);
        }
        let mean = sum / points.len() as f64;
        println!("{what}: {mean:.1e}, {off} off");
        assert!(off * 200 <= points.len(), "{what}: {off} of {} are off", points.len());
        assert!(mean < most, "{what}: {mean:e}");
    }
}

/// Rays that start at voxel corners and run along faces and edges, and through corner after corner, with casters on both sides: no ray
/// slips between two voxels. Oblique rays that graze a sphere may have rounding errors.
#[test]
fn rays_along_faces_miss_nothing() {
    gpu_test("grid_query::rays_along_faces_miss_nothing", |context| {
        let mut random = scenes::Random::new(41);
        // The diagonal extent is 62, in 64 voxels: a voxel is one world unit, with faces at integers.
        let mut particles: Vec<_> =
            [-30.5, 30.5].map(|c| Particle { position: [c; 3], radius: 0.5, extinction: 0.1 }).into();
        // Spheres at centres of voxels, faces and edges, and at corners, with radii such that no ray comes close to their outlines.
        for i in 0..400u16 {
            let half = |axis: u16| if i >> axis & 1 == 1 { 0.5 } else { 0.0 };
            let at = random.point(-29.0, 29.0).map(f32::round);
            let position = [at[0] + half(0), at[1] + half(1), at[2] + half(2)];
            particles.push(Particle {
                position,
                radius: [0.62, 0.83, 1.3, 0.39][usize::from(i / 8 % 4)],
                extinction: 0.4,
            });
        }
        let mut scene = scenes::directional("faces", [0.0, 0.0, -1.0], particles);
        // Quads across the faces where voxels meet, none in the plane of a ray.
        for i in 0..60u16 {
            let [x, y, z] = random.point(-28.0, 28.0).map(f32::round);
            let (half, off) = (if i % 2 == 0 { 0.3 } else { 2.3 }, if i % 4 < 2 { -0.37 } else { 0.37 });
            let corners = [[-half, -1.1 * half], [half, -1.2 * half], [half, 1.3 * half], [-half, 1.1 * half]];
            scene.meshes.push(scenes::quad(
                corners.map(|[a, b]| match i / 3 % 3 {
                    0 => [x + a, y + b, z + off],
                    1 => [x + off, y + a, z + b],
                    _ => [x + b, y + off, z + a],
                }),
                0.5,
            ));
        }
        let sun = scene.lights[0];
        let from = |kind| Light { kind, ..sun };
        let ways = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, -1, 1], [-1, 0, -1]];
        let along = |way: [i8; 3]| LightKind::Directional { direction: DVec3::from(way.map(f64::from)).normalize() };
        let places = [[0, 0, 40], [3, -5, 8], [-40, 40, 40]].map(|at: [i8; 3]| DVec3::from(at.map(f64::from)));
        let lamps = places.into_iter().map(|position| LightKind::Point { position });
        scene.lights = std::iter::once(sun).chain(ways.map(along).into_iter().chain(lamps).map(from)).collect();
        let (_, opened) = opened(context, &scene, 64);
        let data = opened.technique.grid().data().expect("read");
        assert_eq!((data.origin, data.voxel, data.per_unit), ([-32.0; 3], 1.0, 1.0));
        let truth = Casters::new(&scene);
        for light in 0..scene.lights.len() {
            let points: Vec<_> = (0..2000).map(|_| random.point(-31.0, 31.0).map(f32::round)).collect();
            let answers = ask(context, opened.technique.as_ref(), light, &points);
            let (mut dark, mut dim) = (0, 0);
            for (point, answer) in points.iter().zip(answers) {
                let expected = truth.visibility(light, DVec3::from(point.map(f64::from)));
                let kind = scene.lights[light].kind;
                assert!((f64::from(answer) - expected).abs() < 3e-3, "{kind:?} at {point:?}: {answer}, not {expected}");
                dark += usize::from(expected == 0.0);
                dim += usize::from((0.01..0.99).contains(&expected));
            }
            assert!(dark > 20 && dim > 100, "light {light}: {dark} dark, {dim} dim");
        }
    });
}

/// Largest share of a splat's peak optical depth in its tails, which a ray may wrongly omit or include: exp(−4.5) for a ray that just
/// passes at three deviations, less for one that hits.
const TAILS: f64 = 0.0113;

/// Splats match the truth except for their tails beyond three deviations, whose mass is redistributed within: no look-up is off by more
/// than the tails of the splats near its ray.
#[test]
fn splats_are_the_truth_but_for_their_tails() {
    if crate::support::is_costly("splats_are_the_truth_but_for_their_tails") {
        return;
    }
    gpu_test("splats_are_the_truth_but_for_their_tails", |context| {
        for scene in [scenes::splats(), scenes::point([0.1, 2.0, 0.4], scenes::splats())] {
            let truth = Casters::new(&scene);
            let technique = built(context, &scene, "grid-query:size=64");
            let points = space_points(&scene, 0, 2000);
            let answers = ask(context, technique.as_ref(), 0, &points);
            let casters = scene.casters();
            let (mut sum, mut twin_off, mut most) = (0.0, 0, 0.0f64);
            for (point, answer) in points.iter().zip(answers) {
                let point = DVec3::from(point.map(f64::from));
                let expected = truth.visibility(0, point);
                let error = (f64::from(answer) - expected).abs();
                sum += error;
                // The twin has the same cut-off. If a ray barely touches a splat, either may count it.
                let light = &scene.lights[0];
                let (towards, end) =
                    light.position().map_or_else(|| (light.towards(point), 1e9), |at| (at - point, 1.0));
                let near = |caster: &&Caster| {
                    let reach = f64::from(caster.radius) * 5.0 / 3.0;
                    let to = DVec3::from(caster.position.map(f64::from)) - point;
                    let along = (to.dot(towards) / towards.length_squared()).clamp(0.0, f64::from(end));
                    caster.is_splat() && to.distance(along * towards) < 1.001 * reach
                };
                // A ray along the longest axis has the largest optical depth; the radius is three deviations of that axis.
                let peak = |caster: &Caster| f64::from(caster.density * caster.radius) / 3.0 * (2.0 * PI).sqrt();
                let tails = TAILS * casters.iter().filter(near).map(peak).sum::<f64>();
                let bound = expected.max(f64::from(answer)) * (1.0 - (-tails).exp()) + 1e-4;
                most = most.max(error / bound);
                assert!(error <= bound, "{point}: {answer} for {expected}, tails {tails}");
                let ray = (point.as_vec3(), towards.as_vec3());
                let splats: f32 = casters.iter().filter(|c| c.is_splat()).map(|c| cast_depth(ray, c, end)).sum();
                let smoke = Scene { splats: Vec::new(), ..scene.clone() };
                let twin = (-f64::from(splats)).exp() * Casters::new(&smoke).visibility(0, point);
                twin_off += usize::from((f64::from(answer) - twin).abs() > 1e-4);
            }
            let mean = sum / points.len() as f64;
            println!("{}: mean error {mean:.1e}, at most {most:.2} of its bound, {twin_off} off the twin", scene.name);
            assert!(mean > 1e-6, "{mean}");
            assert!(twin_off * 200 <= points.len(), "{twin_off} of {}", points.len());
        }
    });
}

#[test]
fn answers_are_the_truth() {
    gpu_test("answers_are_the_truth", |context| {
        for scene in cases() {
            for size in some([64, 128], 1) {
                holds(context, &scene, &format!("grid-query:size={size}"));
            }
        }
    });
}

/// Thousands of spheres in one place, each as large as the scene: listing them in every voxel would take gigabytes, while one list for all
/// voxels is short.
#[test]
fn large_casters_are_listed_once() {
    if crate::support::is_costly("large_casters_are_listed_once") {
        return;
    }
    gpu_test("large_casters_are_listed_once", |context| {
        let count = 8192;
        let sphere = Particle { position: [0.1, -0.2, 0.3], radius: 1.0, extinction: 1.0 / count as f32 };
        let mut scene = scenes::directional("one place", [0.5, 0.3, -0.81], vec![sphere; count]);
        for (size, text) in [(64, "grid-query:size=64"), (128, "grid-query:size=128")] {
            let (_, opened) = opened(context, &scene, size);
            let totals = opened.technique.grid().cast_totals().expect("lists");
            assert_eq!((totals.pairs, totals.voxels), (count as u32, 0), "size {size}");
            // A quarter of the worst case, in which 8,192 additions each round by half an ulp.
            holds_to(context, &scene, text, 6e-5);
        }
        // One more small sphere is listed in its own voxels.
        scene.particles.push(Particle { position: [0.1, -0.2, 0.3], radius: 0.1, extinction: 3.0 });
        let (_, opened) = opened(context, &scene, 64);
        let totals = opened.technique.grid().cast_totals().expect("lists");
        assert_eq!(totals.pairs - count as u32, totals.voxels);
        assert!(totals.voxels > 20, "{totals:?}");
        holds_to(context, &scene, "grid-query", 6e-5);
    });
}

/// Ray queries against boxes around the casters lose none of them.
#[test]
fn rays_meet_casters_too() {
    gpu_test_needing("rays_meet_casters_too", &[Requirement::RayQuery], |context| {
        for scene in cases() {
            let world = World::new(context, &scene).expect("room for the scene");
            let technique = RayQuery::new(context, &world, &ray_query::Settings::default()).expect("opens");
            let mut opened = Opened::new(context, Box::new(technique), true);
            opened.build(&world).expect("built");
            for (caster, found) in scene.casters().iter().zip(opened.technique.boxes().expect("read")) {
                let expected = boxed(caster);
                assert_eq!(expected, Some(found).filter(|[low, _]| !low[0].is_nan()), "{}: {caster:?}", scene.name);
            }
            holds(context, &scene, "ray-query");
        }
    });
}

/// A stochastic hit depends only on each caster's random number: the look-up equals the twin's, whatever the ray hits first.
#[test]
fn random_hits_equal_their_twin() {
    gpu_test_needing("random_hits_equal_their_twin", &[Requirement::RayQuery], |context| {
        let scene = scenes::random();
        let one = |particle: &Particle| Scene { particles: vec![*particle], ..scene.clone() };
        let each: Vec<_> = scene.particles.iter().map(one).collect();
        let each: Vec<_> = each.iter().map(Casters::new).collect();
        let points = space_points(&scene, 0, 1000);
        let answers = ask(context, built(context, &scene, "ray-query:hits=random").as_ref(), 0, &points);
        let (mut close, mut lit) = (0, 0);
        for (point, answer) in points.iter().zip(answers) {
            let (seed, at) = (hit_seed(0, *point), DVec3::from(point.map(f64::from)));
            // The margin by which each caster lets the ray pass: below 0 the ray ends there.
            let passed = (0..).zip(&each).map(|(i, caster)| {
                let left = caster.visibility(0, at);
                if left == 1.0 { 1.0 } else { left - f64::from(hit_share(seed, i)) }
            });
            let least = passed.fold(1.0, f64::min);
            if least.abs() < 1e-4 {
                close += 1;
                continue;
            }
            assert_eq!(answer, if least > 0.0 { 1.0 } else { 0.0 }, "{point:?}: {least}");
            lit += u32::from(answer == 1.0);
        }
        assert!(close < 20 && (100..900).contains(&lit), "{close} are close, {lit} of {} lit", points.len());
    });
}

/// Each look-up by itself is 0 or 1, and 1 as often as light passes: sums have the truth's mean and the variance of as many independent
/// draws, and neighbours are uncorrelated. Meshes shadow as before.
#[test]
fn random_hits_have_their_mean_and_variance() {
    gpu_test_needing("random_hits_have_their_mean_and_variance", &[Requirement::RayQuery], |context| {
        const COUNT: usize = 2000;
        let mut random = scenes::Random::new(91);
        for scene in some([scenes::opaque(), scenes::strands(), scenes::four_lights()], 2) {
            let (truth, technique) = (Casters::new(&scene), built(context, &scene, "ray-query:hits=random"));
            let (mut places, mut sum, mut squares) = (0, 0.0, 0.0);
            for _ in 0..16 {
                let centre = random.point(-0.6, 0.6);
                let points: Vec<_> =
                    (0..COUNT).map(|_| [0, 1, 2].map(|i| centre[i] + random.between(-1e-2, 1e-2))).collect();
                let answers = ask(context, technique.as_ref(), 0, &points);
                assert!(answers.iter().all(|a| *a == 0.0 || *a == 1.0), "{}: {answers:?}", scene.name);
                let light = |p: &[f32; 3]| truth.visibility(0, DVec3::from(p.map(f64::from)));
                let expected: Vec<_> = points.iter().map(light).collect();
                let off: Vec<_> = answers.iter().zip(&expected).map(|(a, t)| f64::from(*a) - t).collect();
                let variance = expected.iter().map(|t| t * (1.0 - t)).sum::<f64>();
                if variance < 20.0 {
                    assert!(off.iter().sum::<f64>().abs() < 20.0, "{}: {centre:?}", scene.name);
                    continue;
                }
                let deviations = off.iter().sum::<f64>() / variance.sqrt();
                assert!(deviations.abs() < 4.0, "{}: {deviations} standard deviations at {centre:?}", scene.name);
                // Products of independent neighbours have mean 0, and the product of the variances as their variance.
                let product = |i: usize| expected[i] * (1.0 - expected[i]) * expected[i + 1] * (1.0 - expected[i + 1]);
                let together = (0..COUNT - 1).map(|i| off[i] * off[i + 1]).sum::<f64>();
                let together = together / (0..COUNT - 1).map(product).sum::<f64>().sqrt();
                assert!(together.abs() < 4.0, "{}: neighbours are {together} deviations alike", scene.name);
                (places, sum, squares) = (places + 1, sum + deviations, squares + deviations * deviations);
            }
            println!("{}: {places} places, {sum} and {squares} of squared deviations", scene.name);
            let count = f64::from(places);
            assert!(places > 4 && sum.abs() < 4.0 * count.sqrt(), "{}: {sum}", scene.name);
            assert!((squares - count).abs() < 4.0 * (2.0 * count).sqrt(), "{}: {squares} of {places}", scene.name);
        }
    });
}
