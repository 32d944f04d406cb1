//! File sequences of particles and of volumes: at each time, the scene must be that of the frame's file.

use crate::scene::*;
use gobo::animate::AnimatedScene;
use gobo::scene::{Reserve, Scene};

/// Returns a particle file with that many spheres.
fn smoke(spheres: usize) -> String {
    let properties = FIELDS.map(|name| format!("property float {name}\n")).concat();
    let rows: String = (0..spheres).map(|i| format!("{i} {spheres} 1 0.5 {}\n", i + 1)).collect();
    format!("ply\nformat ascii 1.0\nelement vertex {spheres}\n{properties}end_header\n{rows}")
}

/// Returns a scene file with static particles, and with animated ones from the file or sequence `of`; `rate` is a line with their frame
/// rate.
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
    // More particles, then fewer again.
    for (number, spheres) in [(5, 2), (6, 7), (7, 4)] {
        write(&format!("smoke.{number:04}.ply"), &smoke(spheres));
    }
    let load = |text: &str, time_s: f64| {
        std::fs::write(&path, text).expect("write the scene");
        AnimatedScene::load(path.to_str().expect("UTF-8"), time_s)
    };
    let moving = scene_of("smoke.####.ply", "frames_per_second = 3");
    let began = load(&moving, 0.0).expect("three frames");
    assert_eq!(began.scene.most_casters(), 10);
    for (time_s, number) in [(0.0, 5), (0.4, 6), (0.9, 7), (1.0, 5), (0.34, 6), (3600.0, 5)] {
        let of_its_file = load(&scene_of(&format!("smoke.{number:04}.ply"), ""), 0.0).expect("a file");
        assert!(of_its_file.scene.particles.len() > 3 && !of_its_file.moves());
        assert!(began.moves());
        for then in [began.at(time_s), load(&moving, time_s).map(|then| then.scene)] {
            let then = then.expect("its frame");
            assert_eq!(then, Scene { reserve: then.reserve.clone(), ..of_its_file.scene.clone() }, "{time_s} s");
            assert_ne!(then.reserve, Reserve::default());
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

fn load_animated(path: &Path) -> AnimatedScene {
    AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("three frames")
}

/// A sequence by itself must be a scene whose camera sees its first, middle and last frames.
#[test]
fn a_sequence_is_a_scene() {
    let folder = TempDir::new().expect("a temporary folder");
    for number in 1..=3 {
        std::fs::write(folder.path().join(format!("puff_{number}.ply")), smoke(4 * number)).expect("write");
    }
    let animated = load_animated(&folder.path().join("puff_#.ply"));
    let scene = &animated.scene;
    let last = load(&folder.path().join("puff_3.ply")).expect("a file");
    assert_eq!((&*scene.name, scene.particles.len(), scene.most_casters()), ("puff", 4, 12));
    let distance = |scene: &Scene| scene.camera.position.distance(scene.camera.target);
    assert!(distance(scene) >= distance(&last));
    assert_eq!(animated.at(2.0 / 24.0).expect("the last").particles, last.particles);
}

/// Writes samples of a frame of `size`, as a raw file and a `.volume` that places it.
fn fog(folder: &Path, number: usize, size: [usize; 3], density: impl Fn(usize) -> f32) {
    let raw: Vec<u8> = (0..size.iter().product()).flat_map(|i| density(i).to_le_bytes()).collect();
    let sidecar = format!(
        "file = \"fog.{number}.raw\"\nsize = {size:?}\ntype = \"f32\"\nspacing = [0.5, 0.5, 1.0]\norigin = [{number}, 0, {number}]\n"
    );
    std::fs::write(folder.join(format!("fog.{number}.raw")), raw).expect("write");
    std::fs::write(folder.join(format!("fog.{number}.volume")), sidecar).expect("write");
}

/// Frames differ in size and place, and the first is empty: at each time, the scene must be that of the frame's file, next to static
/// casters.
#[test]
fn a_time_is_the_volume_of_its_frame() {
    let folder = TempDir::new().expect("a temporary folder");
    fog(folder.path(), 1, [3, 3, 3], |_| 0.0);
    fog(folder.path(), 2, [4, 3, 2], |i| i as f32 * 0.125);
    fog(folder.path(), 3, [9, 10, 11], |i| (i % 7) as f32);
    fog(folder.path(), 9, [2, 2, 2], |_| 1.0);
    std::fs::write(folder.path().join("smoke.ply"), smoke(2)).expect("write");
    let path = folder.path().join("scene.toml");
    let load = |of: &str, more: &str, time_s: f64| {
        let text = format!(
            "[[volumes]]\nfile = \"fog.9.volume\"\n[[particles]]\nfile = \"smoke.ply\"\n[[volumes]]\nfile = \"{of}\"\n\
             extinction = 3.0\nscale = 2.0\nrotate = [0, 0, 1, 90]\ntranslate = [1, 0, 0]\ncells = 1\n{more}\n{LIGHT}{CAMERA}"
        );
        std::fs::write(&path, text).expect("write the scene");
        AnimatedScene::load(path.to_str().expect("UTF-8"), time_s)
    };
    std::fs::create_dir(folder.path().join("frames")).expect("a folder");
    for number in 1..=3 {
        for ending in ["volume", "raw"] {
            let name = format!("fog.{number}.{ending}");
            std::fs::copy(folder.path().join(&name), folder.path().join("frames").join(name)).expect("copied");
        }
    }
    let began = load("frames/fog.#.volume", "frames_per_second = 2", 0.0).expect("three frames");
    let cells = |scene: &Scene| scene.volumes.iter().map(|volume| volume.cells().len()).collect::<Vec<_>>();
    // Each sample contributes to cells on both of its sides: about 9 × 10 × 11 in the third frame, minus cells whose samples are all 0.
    assert_eq!((cells(&began.scene)[1], began.scene.particles.len(), began.scene.kinds().volumes), (0, 2, true));
    let frames = [2, 3].map(|number| load(&format!("fog.{number}.volume"), "", 0.0).expect("a file").scene);
    let most = frames.iter().map(|scene| cells(scene)[1]).max().expect("two");
    assert_eq!(began.scene.most_casters(), 2 + cells(&began.scene)[0] + most);
    assert!(most > 700 && cells(&frames[0])[1] < 100, "{:?}", frames.each_ref().map(cells));
    for (time_s, frame) in [(0.5, 0), (1.2, 1), (2.1, 0), (0.9, 0), (3600.0 - 0.5, 1)] {
        let then = began.at(time_s).expect("its frame");
        assert_eq!(then, Scene { reserve: then.reserve.clone(), ..frames[frame].clone() }, "{time_s} s");
    }
    assert!(began.at(1.5).expect("the first").volumes[1].cells().is_empty());
    // A repeated frame must share its field, so that fields need not be compared.
    let again = began.at(0.6).expect("its frame");
    assert!(std::ptr::eq(began.at(0.7).expect("the same").volumes[1].field(), again.volumes[1].field()));
    message(load("fog.2.volume", "frames_per_second = 3", 0.0), "scene.toml", "has a #");
    message(load("frames/fog.#.volume", "frames_per_second = 0", 0.0), "scene.toml", "frames_per_second");
    message(
        load("fog.#.volume", "", 0.0),
        "fog.#.volume",
        "frame 4 is missing: fog.3.volume is followed by fog.9.volume",
    );
    // Files that become bad, or larger, during playback.
    let bad = |number: usize| folder.path().join(format!("frames/fog.{number}.raw"));
    let playing = load("frames/fog.#.volume", "frames_per_second = 2", 1.0).expect("the last");
    std::fs::write(bad(2), [0; 7]).expect("write");
    message(playing.at(0.5), "fog.2.raw", "7 bytes");
    message(load("frames/fog.#.volume", "", 0.0), "fog.2.raw", "7 bytes");
    std::fs::remove_file(folder.path().join("frames/fog.2.volume")).expect("there");
    message(playing.at(0.5), "fog.2.volume", "");
    fog(&folder.path().join("frames"), 2, [20, 20, 20], |_| 1.0);
    message(playing.at(0.5), "fog.2.volume", "more cells than when it was opened");
}

/// Files written by results/files/vdb.py, by themselves: the camera must see all of them.
#[test]
fn a_sequence_of_volumes_is_a_scene() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb");
    let animated = load_animated(&seeds.join("ok-frame-#.vdb"));
    let scene = &animated.scene;
    let frames = [1, 2, 3].map(|i| load(&seeds.join(format!("ok-frame-{i}.vdb"))).expect("a file"));
    assert_eq!((&*scene.name, &scene.volumes), ("ok-frame", &frames[0].volumes));
    let cells = frames.each_ref().map(|frame| frame.cell_count());
    assert_eq!(scene.most_casters(), cells[1]);
    assert!(cells[0] < cells[2] && cells[2] < cells[1], "{cells:?}");
    let distance = |scene: &Scene| scene.camera.position.distance(scene.camera.target);
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(animated.at((i as f64 + 0.5) / 24.0).expect("a frame").volumes, frame.volumes);
        assert!(distance(scene) >= distance(frame));
    }
    let folder = TempDir::new().expect("a temporary folder");
    for number in 1..=2 {
        fog(folder.path(), number, [2, 2, 2], |_| 0.0);
    }
    message(load(&folder.path().join("fog.#.volume")), "fog.#.volume", "all of its frames are empty");
    std::fs::write(folder.path().join("hair.1.hair"), "HAIR").expect("write");
    message(load(&folder.path().join("hair.#.hair")), "hair.#.hair", "sequences are of particles (.ply) or of volumes");
}
