//! The built-in scenes: deterministic, complete, inside their bounds.

use crate::scene::*;
use glam::DVec3;
use gobo::animate::AnimatedScene;
use gobo::reference::truth::Casters;
use gobo::scene::{BUILT_IN, LightKind, Particle, Scene};

#[test]
fn built_in_scenes_are_deterministic_and_sane() {
    for name in BUILT_IN {
        let moves = AnimatedScene::load(name, 0.0).expect("built in").moves();
        for time_s in [3.0, 0.0, 0.01, 20.0, 3600.0].into_iter().take(if moves { 5 } else { 1 }) {
            let scene = Scene::load(name, time_s).expect("built in");
            assert!(scene == Scene::load(name, time_s).expect("built in"), "{name} at {time_s}");
            assert_eq!(scene.name, name);
            let meshes = ["town", "houses", "leaves", "shafts", "terrain", "courtyard", "cornell", "grove"];
            assert_eq!(scene.has_only_meshes(), meshes.contains(&name));
            for particle in scene.particles.iter().filter(|_| !name.starts_with("plume_")) {
                assert!(particle.position.iter().all(|value| (-8.0..=14.0).contains(value)), "{particle:?}");
                assert!(particle.position[2] >= particle.radius, "{particle:?} is below the ground");
                assert!(particle.radius > 0.0 && particle.radius < 1.0, "{particle:?}");
                assert!((0.0..10.0).contains(&particle.extinction), "{particle:?}");
            }
        }
    }
}

#[test]
fn three_emitters_fills_up_and_flows() {
    let count = |time_s| Scene::load("three-emitters", time_s).expect("in range").particles.len();
    // Each emitter starts with one particle; the jet saturates at 6 s, the plumes at 15 s and 18 s.
    assert_eq!(count(0.0), 3);
    assert!((2_500..3_500).contains(&count(6.0)), "{}", count(6.0));
    for time_s in [18.0, 20.0, 1000.1] {
        assert_eq!(count(time_s), 5_000);
    }
    let scene = Scene::load("three-emitters", 20.0).expect("in range");
    assert_eq!((scene.meshes.len(), scene.meshes[0].albedo), (1, [0.6; 3]));

    // Nothing may jump within a thousandth of a second: the same particles, moved by at most 6 units / s.
    let later = Scene::load("three-emitters", 20.001).expect("in range");
    let moved = scene.particles.iter().zip(&later.particles);
    let furthest = moved.flat_map(|(a, b)| (0..3).map(|axis| (a.position[axis] - b.position[axis]).abs()));
    assert!(furthest.fold(0.0, f32::max) < 0.006);

    for time_s in [-0.1, f64::NAN, f64::INFINITY, 3600.1] {
        message(Scene::load("three-emitters", time_s), "three-emitters", "not in [0, 3600]");
    }
}

#[test]
fn big_8k_fills_its_cube() {
    let scene = Scene::load("big-8k", f64::NAN).expect("stands still, so ignores the time");
    assert_eq!(scene.particles.len(), 8_192);
    assert!(scene.particles.iter().all(|particle| particle.radius == 0.5));
    let edge = |particle: &Particle| particle.position.iter().all(|value| (0.5..=7.5).contains(value));
    assert!(scene.particles.iter().all(edge), "a sphere sticks out of the cube");
    // Straight through the middle, averaged over a few rays, the optical depth must be 4, as the scene promises.
    let mut sum = 0.0;
    for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (2.25 + 0.5 * x as f32, 2.25 + 0.5 * y as f32))) {
        for particle in &scene.particles {
            let [px, py, _] = particle.position;
            let quarter = particle.radius.powi(2) - (px - x).powi(2) - (py - y).powi(2);
            sum += 2.0 * quarter.max(0.0).sqrt() * particle.extinction;
        }
    }
    assert!((sum / 64.0 - 4.0).abs() < 0.4, "optical depth {}", sum / 64.0);
}

#[test]
fn hair_grows_outside_its_head() {
    let scene = Scene::load("hair", 20.0).expect("built in");
    assert_eq!(scene.strands.len(), 48_000);
    // The head is an ellipsoid: its extreme vertices give its semi-axes.
    let half = |axis: usize| scene.meshes[0].positions.iter().map(|p| p[axis]).fold(0.0, f32::max);
    let half = [half(0), half(1), half(2)];
    let outside = |p: &[f32; 3]| (0..3).map(|i| (p[i] / half[i]).powi(2)).sum::<f32>();
    for strand in &scene.strands {
        assert!(outside(&strand.start) > 0.999 && outside(&strand.end) > 0.999, "{strand:?}");
        assert!([strand.start, strand.end].iter().flatten().all(|value| value.abs() < 2.5), "{strand:?}");
        assert!(strand.start != strand.end && strand.radius > 0.0 && (0.3..=0.6).contains(&strand.opacity));
    }
    // Hairs must be connected: each segment but the last of a hair ends where the next begins.
    let joints = scene.strands.windows(2).filter(|pair| pair[0].end == pair[1].start).count();
    assert_eq!(joints, 3_000 * 15);
    // Half a texel to one texel wide on a 256² map.
    let view = gobo::scene::View::volumes(&scene, 256)[0];
    let texel = 2.0 / (256.0 * view.scale_x.max(view.scale_y));
    let width = 2.0 * scene.strands[0].radius / texel;
    assert!((0.5..=1.0).contains(&width), "{width} texels wide");
}

#[test]
fn lantern_has_three_kinds_of_light() {
    use gobo::scene::LightKind;
    let scene = Scene::load("lantern", 20.0).expect("in range");
    assert_eq!(scene.particles.len(), 1_500);
    assert_eq!(scene, Scene::load("lantern", 20.0).expect("in range"), "the same bytes on every call");
    let kinds = scene.lights.iter().map(|l| l.kind);
    assert_eq!(kinds.clone().filter(|k| matches!(k, LightKind::Point { .. })).count(), 1);
    assert_eq!(kinds.clone().filter(|k| matches!(k, LightKind::Spot { .. })).count(), 1);
    assert_eq!(kinds.filter(|k| matches!(k, LightKind::Directional { .. })).count(), 1);
    assert_eq!(scene.map_count(), 8);
    message(Scene::load("lantern", -1.0), "lantern", "not in [0, 3600]");
}

/// No light may leave through a corner of the room, nor through the lamp's top; and the room between must be free.
#[test]
fn cornell_is_tight() {
    let scene = Scene::load("cornell", f64::NAN).expect("stands still, so ignores the time");
    let meshes = &Casters::new(&scene).meshes;
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 });
    for [x, y, z] in (0..8).map(corner) {
        let inside = DVec3::new(0.99 * x, 0.99 * y, 1.0 + 0.99 * z);
        assert!(!meshes.inside(inside, DVec3::new(0.1, 0.2, 0.97), f64::INFINITY), "{inside}");
        // The front, towards −y, is open by design: no ray goes there.
        assert!(!meshes.free(inside, DVec3::new(x, y.max(0.0), z), 1.0), "{inside} is open");
    }
    let lamp = scene.lights[0].position().expect("a spot light");
    assert!(meshes.free(lamp, DVec3::NEG_Z, 1.5) && !meshes.free(lamp, DVec3::Z, 0.1));
}

/// The lamp of `cornell` must reach the floor and the lower parts of the walls, and nothing above.
#[test]
fn indirect_light_matters_in_cornell() {
    let scene = Scene::load("cornell", 0.0).expect("built in");
    let lit = |x: f64, y: f64, z: f64| scene.lights[0].shines_on(DVec3::new(x, y, z));
    assert!(lit(0.9, -0.9, 0.0) && lit(1.0, 0.0, 0.6));
    assert!(!lit(1.0, 0.0, 1.4) && !lit(0.9, 0.9, 2.0));
}

#[test]
fn plume_1m_is_a_million_thin_particles() {
    let scene = Scene::load("plume-1m", f64::NAN).expect("stands still, so ignores the time");
    assert_eq!(scene.particles.len(), 1_000_000);
    // Behind the plume, some light must be left on average over rays, but less than half.
    let light = |x: f32| {
        let ray = |p: &&Particle| (p.position[0] - x).hypot(p.position[1]) < p.radius;
        let chord =
            |p: &Particle| 2.0 * (p.radius.powi(2) - (p.position[0] - x).powi(2) - p.position[1].powi(2)).sqrt();
        (-scene.particles.iter().filter(ray).map(|p| p.extinction * chord(p)).sum::<f32>()).exp()
    };
    let mean = (0..16).map(|i| light(-1.5 + 0.2 * i as f32)).sum::<f32>() / 16.0;
    assert!((0.001..0.5).contains(&mean), "{mean} of the light");
}

/// Rows of `failures` from the top: height of the lower edge above the ground, and optical depth straight through.
const ROWS: [(f64, f64); 5] = [(3.75, 3.0), (2.9, 1.4), (2.05, 0.9), (1.2, 1.7), (0.35, HAIRS)];

/// 1,300 hairs, 0.016 wide, that absorb 0.3 each, scattered over 4.8.
const HAIRS: f64 = 0.016 * 1300.0 / 4.8 * 0.356_675;

/// The mean optical depth over the middle of each row must be the specified one.
#[test]
fn rows_are_as_dark_as_they_say() {
    const RAYS: u32 = 400;
    let mut scene = Scene::load("failures", 0.0).expect("built in");
    scene.lights[0].kind = LightKind::Directional { direction: DVec3::X };
    let casters = Casters::new(&scene);
    for (bottom, optical_depth) in ROWS {
        let behind = |i: u32| {
            let [y, z] = [0.2 + 1.8 * (f64::from(i) + 0.5) / f64::from(RAYS), f64::from(i % 7) / 30.0 - 0.1];
            DVec3::new(9.0, y, bottom + 0.3 + z)
        };
        let sum: f64 = (0..RAYS).map(|i| casters.optical_depth(0, behind(i))).sum();
        let mean = sum / f64::from(RAYS);
        assert!((mean - optical_depth).abs() < 0.2 * optical_depth, "{bottom}: {mean}, not {optical_depth}");
    }
}

/// Two inks must alternate from drop to drop, with everything else as with one.
#[test]
fn every_other_drop_is_of_the_second_ink() {
    let [one, also_one, two] = ["ink", "ink:inks=1", "ink:inks=2"].map(|name| Scene::load(name, 0.0).expect(name));
    assert!(one.inks.is_empty() && also_one.inks.is_empty());
    assert_eq!([one.extinction_ratio, also_one.extinction_ratio], [[1.0, 0.55, 0.2]; 2]);
    assert_eq!((two.extinction_ratio, two.lights.len(), &*two.name), (Scene::GREY, 3, "ink-2"));
    assert_eq!(two.particles, one.particles);
    assert_eq!(two.inks.iter().map(|ink| ink.casters).sum::<usize>(), one.particles.len());
    // The first ink absorbs more red than blue, the second more blue.
    let drops = one.particles.len() / 4;
    for (i, ink) in two.inks.iter().enumerate() {
        let [red, _, blue] = ink.ratio;
        assert_eq!((ink.casters, blue < red), (drops, i % 2 == 0), "drop {i}: {:?}", ink.ratio);
    }
    let wrong = Scene::load("ink:inks=3", 0.0).expect_err("two at most").to_string();
    assert!(wrong.contains("inks=3") && wrong.contains("inks=1..2"), "{wrong}");
}
