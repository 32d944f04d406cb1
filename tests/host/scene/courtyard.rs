//! The lamps of `courtyard`: any number of them, in free air, on smooth paths that do not depend on their number.

use crate::scene::*;
use glam::{DVec2, DVec3};
use gobo::animate::AnimatedScene;
use gobo::reference::truth::Casters;
use gobo::scene::{Light, LightKind, Scene, View};

const MOST: usize = 1024;

fn courtyard(lights: usize, time_s: f64) -> AnimatedScene {
    let scene = AnimatedScene::load("courtyard", time_s).expect("in range");
    scene.with_lights(lights, time_s).expect("in range")
}

fn position(light: &Light) -> DVec3 {
    let LightKind::Point { position } = light.kind else { panic!("{light:?} is no lamp") };
    position
}

/// Returns the total emission of a scene's lamps, up to a factor.
fn sum(scene: &Scene) -> f64 {
    let of = |l: &Light| f64::from(l.radiance.iter().sum::<f32>()) * l.radius * l.radius;
    scene.lights.iter().map(of).sum()
}

#[test]
fn there_are_as_many_lamps_as_are_wanted() {
    let animated = AnimatedScene::load("courtyard", 7.5).expect("in range");
    let usual = &animated.scene;
    assert_eq!(usual.lights.len(), 32);
    assert_eq!(*usual, courtyard(32, 7.5).scene);
    let named = Scene::load("courtyard:lights=7", 7.5).expect("in range");
    assert_eq!((&*named.name, named.lights), ("courtyard-7", courtyard(7, 7.5).scene.lights));
    for count in [1, 2, 31, 33, 256, 1000, MOST] {
        let animated = courtyard(count, 7.5);
        let scene = &animated.scene;
        assert_eq!((scene.lights.len(), scene.map_count()), (count, 6 * count));
        // A lamp's path must not depend on the number of lamps.
        for (few, many) in scene.lights.iter().zip(&usual.lights) {
            assert_eq!(position(few), position(many));
        }
        let share = sum(scene) / sum(usual);
        assert!(
            (if count < 8 { 0.1 } else { 0.7 }..1.4).contains(&share),
            "{count} lamps are {share} times as bright as 32"
        );
        // At another time, the lamps must be those of a scene loaded at that time.
        assert_eq!(animated.at(30.0).expect("in range").lights, courtyard(count, 30.0).scene.lights);
    }
    for count in [0, MOST + 1, usize::MAX] {
        message(animated.clone().with_lights(count, 7.5), "courtyard", "1 to 1024");
    }
    for time_s in [-0.1, f64::NAN, 3600.1] {
        message(Scene::load("courtyard", time_s), "courtyard", "not in [0, 3600]");
        message(animated.clone().with_lights(4, time_s), "courtyard", "not in [0, 3600]");
        message(animated.at(time_s), "courtyard", "not in [0, 3600]");
    }
    let town = AnimatedScene::load("town", 0.0).expect("built in");
    message(town.with_lights(4, 0.0), "town", "lights are not a number to choose");
}

/// No lamp may be inside an object, or closer than a hand's width to one, at any tested time.
#[test]
fn lamps_keep_to_the_air() {
    if crate::support::is_costly("lamps_keep_to_the_air") {
        return;
    }
    let scene = courtyard(MOST, 0.0);
    let casters = Casters::new(&scene.scene);
    let directions = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let slanted = [DVec3::new(0.6, 0.0, -0.8), DVec3::new(-0.48, 0.6, 0.64), DVec3::new(0.1, -0.7, 0.7)];
    let directions: Vec<_> = directions.chain(slanted).collect();
    for step in 0..60 {
        let time_s = 3600.0 * (f64::from(step) * 0.618_034).fract();
        for (i, light) in scene.at(time_s).expect("in range").lights.iter().enumerate() {
            let at = position(light);
            for direction in &directions {
                assert!(
                    !casters.meshes.inside(at, *direction, f64::INFINITY),
                    "lamp {i} at {time_s} s: inside at {at}"
                );
                assert!(casters.meshes.free(at, *direction, 0.08), "lamp {i} at {time_s} s: {at}, towards {direction}");
            }
        }
    }
}

/// Lamps must neither jump nor turn abruptly: within a thousandth of a second, a lamp's speed may change only by a bounded acceleration.
#[test]
fn ways_are_smooth() {
    let scene = courtyard(MOST, 0.0);
    let at = |time_s: f64| scene.at(time_s).expect("in range").lights;
    const STEP_S: f64 = 1e-3;
    let mut fastest = 0.0f64;
    for step in 0..200 {
        let time_s = 1.0 + 40.0 * f64::from(step) / 200.0;
        let [before, now, after] = [-STEP_S, 0.0, STEP_S].map(|by| at(time_s + by));
        for (i, now) in now.iter().enumerate() {
            let [from, now, to] = [&before[i], now, &after[i]].map(position);
            fastest = fastest.max((to - now).length() / STEP_S);
            let acceleration = (to - 2.0 * now + from).length() / (STEP_S * STEP_S);
            assert!(acceleration < 60.0, "lamp {i} at {time_s} s: {acceleration} m/s²");
        }
    }
    assert!((1.0..12.0).contains(&fastest), "{fastest} m/s");
}

/// Visible points must be within the reach of some lamps, but not of too many.
#[test]
fn a_pixel_has_its_share_of_lamps() {
    for (count, range) in [(32, 5.0..10.0), (MOST, 8.0..30.0)] {
        let scene = courtyard(count, 20.0).scene;
        let camera = View::camera(&scene.camera, &scene, [64, 36]);
        let casters = Casters::new(&scene);
        let pixels = (0..64 * 36).map(|i| DVec2::new(f64::from(i % 64) + 0.5, f64::from(i / 64) + 0.5));
        let seen = pixels.filter_map(|pixel| {
            let ray = camera.ray(pixel);
            casters.meshes.hit(ray.origin, ray.direction).map(|hit| ray.at(hit.distance))
        });
        let lamps: Vec<_> = seen.map(|at| scene.lights.iter().filter(|l| l.shines_on(at)).count() as f64).collect();
        let mean = lamps.iter().sum::<f64>() / lamps.len() as f64;
        println!("{count} lamps: {mean} a pixel");
        assert!(lamps.len() > 1500, "the camera looks at the sky: {}", lamps.len());
        assert!(range.contains(&mean), "{count} lamps: {mean} a pixel");
    }
}
