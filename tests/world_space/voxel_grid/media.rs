//! Smoke and hair in the grid: numbers against their twin, the total, closed forms, and properties of every look-up.

use crate::support::{self, ask, gpu_test, scenes, scenes::Random};
use crate::voxel_grid::{PLAIN, built, place, shapes, twin, way};
use glam::DVec3;
use gobo::reference::truth::Casters;
use gobo::reference::twin::grid::Place;
use gobo::reference::twin::media::{Media, UNITS};
use gobo::scene::{Particle, Scene, Strand};
use gobo::technique::{VoxelGrid, voxel_grid::Plan as Settings};
use gobo::world::World;
use gobo::{Error, Need};
use std::f64::consts::PI;

/// Spheres from a thousandth of a voxel to most of the grid, also at its borders; strands from next to no length to the grid's; and in the
/// middle so many dense spheres that sums exceed 32 bits.
fn extremes() -> Scene {
    let mut random = Random::new(61);
    let mut scene = scenes::directional("extremes", [0.5, 0.3, -0.81], Vec::new());
    for i in 0..300 {
        let radius = 10f32.powf(random.between(-4.0, -0.2));
        let position = random.point(radius - 1.0, 1.0 - radius);
        let extinction = [0.3, 40.0, 1e6][i % 3];
        scene.particles.push(Particle { position, radius, extinction });
    }
    let dense = Particle { position: [0.1, 0.2, 0.3], radius: 0.06, extinction: 1e5 };
    scene.particles.extend([dense; 8]);
    for i in 0..120 {
        let (start, by) = (random.point(-0.9, 0.9), random.point(-1.0, 1.0));
        let length = 10f32.powf(random.between(-3.5, -0.05));
        let end = [0, 1, 2].map(|a| (start[a] + length * by[a]).clamp(-0.9, 0.9));
        scene.strands.push(Strand { start, end, radius: [0.001, 0.02][i % 2], opacity: [0.1, 0.9, 1.0][i % 3] });
    }
    scene
}

/// Returns the points that define the grid's placement around all casters.
fn corners(scene: &Scene) -> Vec<[f32; 3]> {
    let meshes = scene.meshes.iter().flat_map(|mesh| mesh.positions.clone());
    let spheres = scene.casters().into_iter().flat_map(|caster| {
        let end = [0, 1, 2].map(|i| caster.position[i] + caster.axis[i]);
        let by = |p: [f32; 3], r: f32| p.map(|v| v + r);
        [caster.position, end].into_iter().flat_map(move |p| [by(p, caster.radius), by(p, -caster.radius)])
    });
    meshes.chain(spheres).collect()
}

fn media(grid: &VoxelGrid) -> (Vec<u32>, Vec<u64>) {
    grid.grid().media().expect("read").expect("the world has smoke or hair")
}

#[test]
fn media_equal_their_twin() {
    if crate::support::is_long("media_equal_their_twin") {
        return;
    }
    gpu_test("media_equal_their_twin", |context| {
        let mut among = scenes::locks();
        among.meshes = shapes::houses().meshes;
        let scenes = [extremes(), among, scenes::strands(), scenes::opaque(), scenes::random(), scenes::dense()];
        for scene in scenes {
            for size in support::some([64, 128, 256], 2) {
                let (_, opened) = built(context, &scene, Settings { size, ..PLAIN });
                let at = place(&opened.technique);
                let expected = Place::about(corners(&scene).into_iter(), size);
                for (a, b) in [(at.voxel, expected.voxel), (at.per_unit, expected.per_unit)] {
                    assert!((a - b).abs() <= b.abs() * 1e-6, "{}: {at:?}, the twin {expected:?}", scene.name);
                }
                let twin = Media::deposit(&scene.casters(), &at);
                let (voxels, bits) = media(&opened.technique);
                let differ = voxels.iter().zip(&twin.voxels).filter(|(a, b)| a != b).count();
                let some = twin.voxels.iter().filter(|v| **v > 0).count();
                assert!(differ == 0 && some > 100, "{}, size {size}: {differ} differ of {some}", scene.name);
                assert!(bits == twin.bits.words, "{}, size {size}: bits", scene.name);
                if scene.name == "extremes" && size == 64 {
                    let full = bits[..4096].iter().map(|word| word.count_ones()).sum::<u32>();
                    assert!(full > 0 && (full as usize) < some / 10, "{full} voxels are full");
                }
            }
        }
    });
}

/// Returns the sum over the grid of extinction times volume, in voxel units; bits past the 32nd are dropped.
fn total(voxels: &[u32]) -> f64 {
    voxels.iter().map(|v| f64::from(*v)).sum::<f64>() / f64::from(UNITS)
}

/// Nothing is lost: a sphere keeps σ times its volume, and one smaller than a voxel keeps its absorbed light, π r² (1 − exp(−σ 4/3 r)); a
/// strand keeps π/2 r l (1 − exp(−τ)). Things smaller than a voxel are exact up to rounding, and spheres of a voxel or more up to the error
/// of samples half a voxel apart.
#[test]
fn nothing_is_lost() {
    if crate::support::is_long("nothing_is_lost") {
        return;
    }
    gpu_test("nothing_is_lost", |context| {
        let mut random = Random::new(62);
        // Spheres that fix the cube at 62 voxels for a width of 2, and absorb nothing.
        let frame = [-1.0, 1.0].map(|v: f32| Particle { position: [0.999 * v; 3], radius: 1e-3, extinction: 0.0 });
        let voxel = 2.0 / 62.0;
        let mut most = 0.0f64;
        for i in 0..support::some(0..60, 40).len() {
            let mut scene = scenes::directional("one", [0.5, 0.3, -0.81], frame.to_vec());
            let position = random.point(-0.3, 0.3);
            let (expected, tolerance) = if i % 3 == 2 {
                let by = random.point(-0.5, 0.5);
                let end = [0, 1, 2].map(|a| position[a] + by[a] * (i as f32 / 60.0));
                let (radius, opacity) = (random.between(0.001, 0.02), random.between(0.001, 0.999));
                let length = (DVec3::from(end.map(f64::from)) - DVec3::from(position.map(f64::from))).length();
                scene.strands.push(Strand { start: position, end, radius, opacity });
                (PI / 2.0 * f64::from(radius) * length * f64::from(opacity) / (voxel * voxel), 1e-4)
            } else {
                let radius = 10f32.powf(random.between(-2.5, -0.25));
                let extinction = 10f32.powf(random.between(-1.0, 2.0));
                scene.particles.push(Particle { position, radius, extinction });
                let (r, s) = (f64::from(radius) / voxel, f64::from(extinction) * voxel);
                let small = PI * r * r * -(-s * 4.0 / 3.0 * r).exp_m1();
                if r < 1.0 { (small, 1e-4) } else { (s * 4.0 / 3.0 * PI * r.powi(3), 0.01) }
            };
            let (_, opened) = built(context, &scene, PLAIN);
            let (voxels, bits) = media(&opened.technique);
            assert!(bits[..4096].iter().all(|word| *word == 0), "nothing is full");
            let relative = total(&voxels) / expected - 1.0;
            // Each mote's amount is rounded down.
            let rounding = 1200.0 / f64::from(UNITS) / expected;
            assert!(relative.abs() < tolerance + rounding, "{scene:?}: {relative}");
            most = most.max(if tolerance > 1e-3 { relative.abs() } else { 0.0 });
        }
        println!("spheres of a voxel and more: {most:.5} at most");
    });
}

/// One sphere has a closed form: a voxel whose points are all nearer to the sphere's centre than its radius absorbs as much as the sphere,
/// and one whose points are all farther absorbs nothing. A voxel's diagonal is √3, and its samples extend a quarter beyond it on each side.
/// So a look-up lies between those of spheres smaller and larger by that amount.
#[test]
fn one_sphere_has_its_closed_form() {
    gpu_test("one_sphere_has_its_closed_form", |context| {
        let (radius, extinction, centre) = (0.8f64, 1.5f64, DVec3::new(0.1, -0.05, 0.2));
        let sphere = |position: DVec3, radius: f64| Particle {
            position: position.as_vec3().to_array(),
            radius: radius as f32,
            extinction: extinction as f32,
        };
        for base in [scenes::random(), scenes::beside()] {
            let mut scene = base;
            scene.particles = vec![sphere(centre, radius)];
            let (_, opened) = built(context, &scene, PLAIN);
            let reach = (3f64.sqrt() + 0.25 + 0.01) * f64::from(place(&opened.technique).voxel);
            let truths = [-reach, reach].map(|by| {
                let mut other = scene.clone();
                other.particles = vec![sphere(centre, radius + by)];
                other
            });
            let truths = truths.each_ref().map(Casters::new);
            let mut random = Random::new(63);
            let points: Vec<_> = (0..3000).map(|_| random.point(-1.5, 1.5)).collect();
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            let mut shadowed = 0;
            for (point, answer) in points.iter().zip(answers) {
                let at = DVec3::from(point.map(f64::from));
                let [most, least] = truths.each_ref().map(|casters| casters.visibility(0, at));
                let answer = f64::from(answer);
                assert!((least - 1e-4..=most + 1e-4).contains(&answer), "{at}: {answer}, not {least} to {most}");
                shadowed += usize::from(most < 0.8);
            }
            assert!(shadowed > 300, "{shadowed}");
        }
    });
}

/// Things smaller than a voxel transmit, on average, as much light as in truth: a block of motes and one of randomly oriented strands, some
/// so thin that all of them count, some opaque.
#[test]
fn small_things_take_what_they_should_on_average() {
    gpu_test("small_things_take_what_they_should_on_average", |context| {
        let mut random = Random::new(64);
        let frame = [-1.0, 1.0].map(|v: f32| Particle { position: [0.999 * v; 3], radius: 1e-3, extinction: 0.0 });
        for (opacity, radius, count) in [(0.2f32, 0.012, [28_000, 14_000]), (1.0, 0.005, [24_000, 6_000])] {
            let mut motes = scenes::directional("motes", [0.5, 0.3, -0.81], frame.to_vec());
            let mut hair = motes.clone();
            hair.name = "hair".into();
            for _ in 0..count[0] {
                let extinction = -(-opacity.min(0.9999)).ln_1p() / (4.0 / 3.0 * radius);
                motes.particles.push(Particle { position: random.point(-0.7, 0.7), radius, extinction });
            }
            for _ in 0..count[1] {
                // Uniform directions: a random point in a ball.
                let by = std::iter::repeat_with(|| random.point(-1.0, 1.0));
                let by = by.map(DVec3::from_array_f32).find(|v| v.length() < 1.0 && v.length() > 0.1).expect("endless");
                let by = (by.normalize() * 0.06).as_vec3().to_array();
                let start = random.point(-0.7, 0.7);
                let end = [0, 1, 2].map(|a| start[a] + by[a]);
                hair.strands.push(Strand { start, end, radius, opacity });
            }
            for scene in [motes, hair] {
                let (_, opened) = built(context, &scene, PLAIN);
                let casters = Casters::new(&scene);
                let points: Vec<_> = (0..4000).map(|_| random.point(-0.6, 0.6)).collect();
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let mean = |sum: f64| sum / points.len() as f64;
                let answer = mean(answers.iter().map(|a| f64::from(*a)).sum());
                let truth = mean(points.iter().map(|p| casters.visibility(0, DVec3::from(p.map(f64::from)))).sum());
                println!("{}, opacity {opacity}: mean {answer:.4}, truth {truth:.4}", scene.name);
                assert!((0.3..0.9).contains(&truth) && (answer - truth).abs() < 0.03, "{}", scene.name);
            }
        }
    });
}

trait FromF32 {
    fn from_array_f32(of: [f32; 3]) -> Self;
}

impl FromF32 for DVec3 {
    fn from_array_f32(of: [f32; 3]) -> Self {
        Self::from(of.map(f64::from))
    }
}

/// Skipping empty space changes no look-up.
#[test]
fn ways_through_media_equal_their_twin() {
    gpu_test("ways_through_media_equal_their_twin", |context| {
        let mut among = scenes::locks();
        among.meshes = shapes::houses().meshes;
        for scene in [among, scenes::random(), scenes::beside()] {
            for steps in [None, Some(25)] {
                let (_, opened) = built(context, &scene, Settings { steps, ..PLAIN });
                let at = place(&opened.technique);
                let (bits, media) = (twin(&scene, &at), Media::deposit(&scene.casters(), &at));
                let mut random = Random::new(65);
                let points: Vec<_> = (0..3000).map(|_| random.point(-1.5, 1.5)).collect();
                let answers = ask(context, opened.technique.as_ref(), 0, &points);
                let (mut unsure, mut between) = (0, 0);
                for (point, answer) in points.iter().zip(answers) {
                    let (from, way) = way(&at, &scene, *point);
                    let (met, taken) = match steps {
                        None => (bits.march_exact(from, way), media.march_exact(from, way)),
                        Some(steps) => (
                            bits.march_steps(from, way, steps, PLAIN.offset),
                            media.march_steps(from, way, steps, PLAIN.offset),
                        ),
                    };
                    let expected = if met { 0.0 } else { (-taken).exp() };
                    unsure += usize::from((answer - expected).abs() > 2e-4);
                    between += usize::from((0.05..0.95).contains(&expected));
                }
                // Rays that just touch an occupied voxel, and steps that round into another voxel, are unsure.
                assert!(unsure < 30 && between > 300, "{}, {steps:?}: {unsure} unsure, {between}", scene.name);
            }
        }
    });
}

/// Light never rises with distance from the light, and always lies in [0, 1].
#[test]
fn light_never_rises_along_a_way() {
    gpu_test("light_never_rises_along_a_way", |context| {
        for scene in [extremes(), scenes::beside(), scenes::strands()] {
            let (_, opened) = built(context, &scene, PLAIN);
            let mut random = Random::new(66);
            let mut points = Vec::new();
            for _ in 0..200 {
                let towards = DVec3::from_array_f32(random.point(-1.2, 1.2));
                let away = -scene.lights[0].towards(towards);
                points.extend((0..30).map(|i| (towards + away * (0.06 * f64::from(i))).as_vec3().to_array()));
            }
            let answers = ask(context, opened.technique.as_ref(), 0, &points);
            assert!(answers.iter().all(|a| (0.0..=1.0).contains(a)), "{}", scene.name);
            for (way, points) in answers.chunks_exact(30).zip(points.chunks_exact(30)) {
                // Each look-up sums from its own point, so neighbours may differ by rounding.
                let rises = way.windows(2).position(|pair| pair[1] > pair[0] + 1e-3);
                assert!(rises.is_none(), "{}: {way:?} at {:?}", scene.name, rises.map(|i| points[i]));
            }
            assert!(answers.iter().filter(|a| **a < 0.5).count() > 300, "{}", scene.name);
        }
    });
}

/// Media that moved away leave nothing behind, nor do media that are removed, and the first scene gives the same grid again.
#[test]
fn media_are_cleared() {
    gpu_test("media_are_cleared", |context| {
        let scene = extremes();
        let (mut world, mut opened) = built(context, &scene, PLAIN);
        let first = media(&opened.technique);
        let mut moved = scene.clone();
        moved.particles.iter_mut().for_each(|p| p.position = p.position.map(|v| 0.4 * v));
        moved.strands.truncate(10);
        world.replace(&moved).expect("fewer");
        opened.build(&world).expect("built");
        let twin = Media::deposit(&moved.casters(), &place(&opened.technique));
        assert!(media(&opened.technique) == (twin.voxels, twin.bits.words));
        let mut none = scene.clone();
        none.particles.clear();
        none.strands.clear();
        world.replace(&none).expect("none");
        opened.build(&world).expect("built");
        let (voxels, bits) = media(&opened.technique);
        assert!(voxels.iter().all(|v| *v == 0) && bits.iter().all(|v| *v == 0));
        world.replace(&scene).expect("as many of all");
        opened.build(&world).expect("built");
        assert!(media(&opened.technique) == first);
    });
}

/// Meshes alone get no grid of media; if a device's buffers are too small for one, the refusal names the limit.
#[test]
fn media_are_there_where_they_are_needed() {
    gpu_test("media_are_there_where_they_are_needed", |context| {
        let (_, opened) = built(context, &shapes::houses(), PLAIN);
        assert!(opened.technique.grid().media().expect("read").is_none());
        let world = World::new(context, &scenes::nested()).expect("room for the scene");
        let size = 512;
        let result = VoxelGrid::planned(context, &world, &Settings { size, ..PLAIN });
        if context.features().max_storage_buffer_range < 4 << 27 {
            let error = result.err().expect("refused");
            assert!(
                matches!(&error, Error::Refused(Need::Limit { limit, .. }) if limit.name == "maxStorageBufferRange"),
                "{error}"
            );
        }
    });
}
