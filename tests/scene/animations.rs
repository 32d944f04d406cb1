//! Sequences of particle files: each time is the scene of that frame's file.

use crate::*;
use gobo::scene::{Motion, Scene};

/// A particle file of so many spheres.
fn smoke(spheres: usize) -> String {
    let properties = FIELDS.map(|name| format!("property float {name}\n")).concat();
    let rows: String = (0..spheres).map(|i| format!("{i} {spheres} 1 0.5 {}\n", i + 1)).collect();
    format!("ply\nformat ascii 1.0\nelement vertex {spheres}\n{properties}end_header\n{rows}")
}

/// `of` names the particles of the moving entry, of three frames a second.
fn scene_of(of: &str, rate: &str) -> String {
    format!(
        "[[particles]]\nfile = \"still.ply\"\n[[particles]]\nfile = \"{of}\"\nscale = 2.0\ntranslate = [0, 0, 1]\n{rate}\n{LIGHT}{CAMERA}"
    )
}

#[test]
fn a_time_is_the_scene_of_its_frame() {
    let folder = TempDir::new().expect("a temporary folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("write");
    write("still.ply", &smoke(3));
    let path = folder.path().join("scene.toml");
    // More and fewer again.
    for (number, spheres) in [(5, 2), (6, 7), (7, 4)] {
        write(&format!("smoke.{number:04}.ply"), &smoke(spheres));
    }
    let load = |text: &str, time_s: f64| {
        std::fs::write(&path, text).expect("write the scene");
        Scene::load(path.to_str().expect("UTF-8"), time_s)
    };
    let moving = scene_of("smoke.####.ply", "frames_per_second = 3");
    let began = load(&moving, 0.0).expect("three frames");
    assert_eq!(began.most_casters(), 10);
    for (time_s, number) in [(0.0, 5), (0.4, 6), (0.9, 7), (1.0, 5), (0.34, 6), (3600.0, 5)] {
        let of_its_file = load(&scene_of(&format!("smoke.{number:04}.ply"), ""), 0.0).expect("a file");
        assert!(of_its_file.particles.len() > 3 && of_its_file.motion == Motion::Still);
        for then in [began.at(time_s), load(&moving, time_s)] {
            let then = then.expect("its frame");
            assert_eq!(then, Scene { motion: then.motion.clone(), ..of_its_file.clone() }, "{time_s} s");
            assert_ne!(then.motion, Motion::Still);
        }
    }
    message(began.at(-0.1), "time -0.1 s", "give a time");
    let before = began.fingerprint();
    write("smoke.0007.ply", &smoke(5));
    assert_ne!(load(&moving, 0.0).expect("three frames").fingerprint(), before);
    message(load(&scene_of("smoke.0005.ply", "frames_per_second = 3"), 0.0), "scene.toml", "has a #");
    for rate in ["0", "-1", "1001", "nan"] {
        message(
            load(&scene_of("smoke.####.ply", &format!("frames_per_second = {rate}")), 0.0),
            "scene.toml",
            "frames_per_second",
        );
    }
    message(load(&scene_of("fog.####.ply", ""), 0.0), "fog.####.ply", "no file has such a name");
    write("smoke.0006.ply", "ply\n");
    message(load(&moving, 0.0), "smoke.0006.ply", "PLY");
}

/// A sequence by itself is a scene, in which the camera sees its first, middle and last frames.
#[test]
fn a_sequence_is_a_scene() {
    let folder = TempDir::new().expect("a temporary folder");
    for number in 1..=3 {
        std::fs::write(folder.path().join(format!("puff_{number}.ply")), smoke(4 * number)).expect("write");
    }
    let scene = load(&folder.path().join("puff_#.ply")).expect("three frames");
    let last = load(&folder.path().join("puff_3.ply")).expect("a file");
    assert_eq!((&*scene.name, scene.particles.len(), scene.most_casters()), ("puff", 4, 12));
    let distance = |scene: &Scene| scene.camera.position.distance(scene.camera.target);
    assert!(distance(&scene) >= distance(&last));
    assert_eq!(scene.at(2.0 / 24.0).expect("the last").particles, last.particles);
}
