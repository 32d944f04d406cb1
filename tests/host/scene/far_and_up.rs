//! Where files stand: far from the origin, where floats are coarse, and with other axes up.

use crate::scene::*;
use crate::support::shared_data;
use glam::DVec3;
use gobo::animate::AnimatedScene;
use gobo::scene::{Camera, LightKind};

/// A corner of the earth, and one that no float has.
const FAR: [[f64; 3]; 2] = [[6_378_137.0, 0.0, 6_378_137.0], [-35_000.25, 17.5, 35_000.0]];

/// Returns a scene of all kinds of casters, moved by `by`.
fn everything(by: [f64; 3]) -> gobo::Result<Scene> {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    write("tri.ply", TRIANGLE_PLY.as_bytes());
    write("smoke.ply", &ascii_ply(&FIELDS, &[[1.0, 2.0, 3.0, 0.5, 0.8], [0.1, 0.2, 0.3, 0.4, 0.5]]));
    write("head.hair", &hair_files::samples()[0]);
    write(
        "one.splat",
        &splat_files::splat([0.1, 0.2, 0.3], [0.5, 0.25, 0.125], [255, 128, 0, 191], [200, 128, 128, 150]),
    );
    write("grid.raw", &[0, 255, 0, 128, 0, 255, 0, 64]);
    write("grid.volume", b"file = \"grid.raw\"\nsize = [2, 2, 2]\ntype = \"u8\"\nspacing = [0.3, 0.2, 0.1]\n");
    let place = format!("translate = {by:?}\nrotate = [1, 2, 3, 40]\nscale = 1.5\n");
    let mut text = String::new();
    for (table, file) in [
        ("particles", "smoke.ply"),
        ("hair", "head.hair"),
        ("splats", "one.splat"),
        ("volumes", "grid.volume"),
        ("meshes", "tri.ply"),
    ] {
        text += &format!("[[{table}]]\nfile = \"{file}\"\n{place}");
    }
    let [eye, target, lamp] = [[4.0, 5.0, 6.0], [0.0, 1.0, 0.0], [2.0, 2.0, 9.0]]
        .map(|at: [f64; 3]| [0, 1, 2].map(|axis| at[axis] + by[axis]));
    text += &format!("[[light]]\nkind = \"spot\"\nposition = {lamp:?}\ntarget = {target:?}\ncone_degrees = 50\n");
    text += &format!("[camera]\nposition = {eye:?}\ntarget = {target:?}\nup = [0, 0, 1]\nfov_y_degrees = 40\n");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("written");
    load(&path)
}

/// All points of a scene, from its first light's position.
fn points(scene: &Scene) -> Vec<DVec3> {
    let from_lamp = |at: DVec3| at - scene.lights[0].position().expect("a lamp");
    let place = |at: [f32; 3]| from_lamp(DVec3::from_array(at.map(f64::from)));
    let mut all: Vec<_> = scene.particles.iter().map(|particle| place(particle.position)).collect();
    all.extend(scene.strands.iter().flat_map(|strand| [place(strand.start), place(strand.end)]));
    all.extend(scene.splats.iter().map(|splat| place(splat.position)));
    all.extend(scene.volumes.iter().flat_map(|volume| volume.cells().iter().map(|cell| place(cell.position))));
    all.extend(scene.volumes.iter().map(|volume| from_lamp(volume.placed().origin)));
    all.extend(scene.meshes.iter().flat_map(|mesh| mesh.positions.iter().map(|position| place(*position))));
    all.extend([from_lamp(scene.camera.position), from_lamp(scene.camera.target)]);
    all
}

/// A scene that is far away has every point where one at home has it, to the rounding of floats near the origin.
#[test]
fn a_far_scene_is_that_at_home() {
    let home = points(&everything([0.0; 3]).expect("a scene"));
    assert!(home.len() > 20);
    for by in FAR {
        let far = points(&everything(by).expect("a scene"));
        assert_eq!(far.len(), home.len());
        for (far, home) in far.iter().zip(&home) {
            assert!((*far - *home).length() < 2e-6, "{by:?}: {far} for {home}");
        }
    }
}

/// Data files of doubles, and nodes of glTF, are moved as a whole; a note says by how much. What is near stays.
#[test]
fn a_far_file_is_moved_home() {
    let folder = TempDir::new().expect("a folder");
    let read = |by: [f64; 3]| {
        let [x, y, z] = by;
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double z\n\
             property float radius\nproperty float extinction\nend_header\n{} {y} {z} 0.25 1\n{x} {y} {} 0.25 1\n",
            x + 0.375,
            z + 1.0
        );
        let path = folder.path().join("smoke.ply");
        std::fs::write(&path, text).expect("written");
        AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("a scene")
    };
    let home = read([0.0; 3]);
    assert!(home.notes.iter().all(|note| !note.contains("moved")), "{:?}", home.notes);
    for by in FAR {
        let far = read(by);
        let [a, b] = [0, 1].map(|i| far.scene.particles[i].position);
        assert_eq!([a[0] - b[0], b[2] - a[2]], [0.375, 1.0], "{by:?}");
        assert!(a.iter().all(|at| at.abs() < 2.0));
        let told = far.notes.iter().find(|note| note.contains("moved by")).expect("a note");
        let moved = (DVec3::from(a.map(f64::from)) - DVec3::from(by)).round();
        let DVec3 { x, y, z } = moved;
        assert!(told.contains(&format!("moved by {x}, {y}, {z},")), "{told}");
        let between = |scene: &Scene| scene.camera.position - scene.camera.target;
        assert!((between(&far.scene) - between(&home.scene)).length() < 1e-5);
    }
}

/// The data project's case: a box on a ground, at home and on the equator.
#[test]
fn shared_far_cases_are_right() {
    let Some(folder) = shared_data("shared_far_cases_are_right") else { return };
    let read = |name: &str| load(&folder.join("cases").join(name)).expect("a scene");
    let (home, far) = (read("d10-at-home.gltf"), read("d10-six-million-away.gltf"));
    let corners = |scene: &Scene| {
        let first = DVec3::from(scene.meshes[0].positions[0].map(f64::from));
        let all = scene.meshes.iter().flat_map(|mesh| &mesh.positions);
        all.map(|at| DVec3::from(at.map(f64::from)) - first).collect::<Vec<_>>()
    };
    assert_eq!(corners(&home), corners(&far));
    let direction = |scene: &Scene| match scene.lights[0].kind {
        LightKind::Directional { direction } => direction,
        other => panic!("{other:?}"),
    };
    assert_eq!(direction(&home), direction(&far));
}

fn up_of(camera: &Camera) -> DVec3 {
    camera.up.normalize()
}

/// Which axis points up is as the format's main writers have it; without a definition in the format, a note tells.
#[test]
fn formats_have_their_up() {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    write("smoke.ply", &ascii_ply(&FIELDS, &[[1.0, 2.0, 3.0, 0.5, 0.8]]));
    write(
        "one.splat",
        &splat_files::splat([0.1, 0.2, 0.3], [0.5, 0.25, 0.125], [255, 128, 0, 191], [200, 128, 128, 150]),
    );
    write("head.hair", &hair_files::samples()[0]);
    std::fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb/ok-blosc.vdb"),
        folder.path().join("ball.vdb"),
    )
    .expect("copied");
    for (name, up, told) in [
        ("smoke.ply", DVec3::Z, "z is taken for up"),
        ("one.splat", DVec3::NEG_Y, "-y is taken for up"),
        ("head.hair", DVec3::Z, "z is taken for up"),
        ("ball.vdb", DVec3::Y, "y is taken for up"),
    ] {
        let path = folder.path().join(name);
        let scene = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect(name);
        assert_eq!(up_of(&scene.scene.camera), up, "{name}");
        assert!(scene.notes.iter().any(|note| note.contains(told)), "{name}: {:?}", scene.notes);
        let LightKind::Directional { direction } = scene.scene.lights[0].kind else { panic!("{name}") };
        assert!(direction.dot(up) < -0.7, "{name}: light comes from above");
    }
}

/// `up` turns a file: its axis becomes the scene's up, which is the camera's, or else that of the other files.
#[test]
fn a_file_is_stood_up() {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(
        folder.path().join("one.splat"),
        splat_files::splat([1.0, 2.0, 3.0], [0.5, 0.25, 0.125], [255, 128, 0, 191], [200, 128, 128, 150]),
    )
    .expect("written");
    std::fs::write(folder.path().join("tri.gltf"), gltf_shapes::File::new().text()).expect("written");
    let read = |up: &str, more: &str| {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, format!("[[splats]]\nfile = \"one.splat\"\n{up}\n{more}\n{LIGHT}")).expect("written");
        load(&path)
    };
    let y_up = "[camera]\nposition = [9, 9, 9]\ntarget = [0, 0, 0]\nup = [0.1, 2, 0]\nfov_y_degrees = 40\n";
    for (up, more, place, camera_up) in [
        ("up = \"-y\"", "", [1.0, 3.0, -2.0], DVec3::Z),
        ("up = \"y\"", "", [1.0, -3.0, 2.0], DVec3::Z),
        ("up = \"-y\"", y_up, [1.0, -2.0, -3.0], DVec3::new(0.1, 2.0, 0.0).normalize()),
        ("up = \"-z\"", "[[meshes]]\nfile = \"tri.gltf\"", [1.0, -3.0, 2.0], DVec3::Y),
        ("up = \"x\"", "", [-3.0, 2.0, 1.0], DVec3::Z),
        ("", "", [1.0, 2.0, 3.0], DVec3::NEG_Y),
        ("rotate = [1, 0, 0, 180]", "", [1.0, -2.0, -3.0], DVec3::Y),
        ("rotate = [1, 0, 0, 90]", "", [1.0, -3.0, 2.0], DVec3::Z),
    ] {
        let scene = read(up, more).expect("a scene");
        let found = scene.splats[0].position;
        assert!((0..3).all(|i| (found[i] - place[i]).abs() < 1e-5), "{up} {more}: {found:?} for {place:?}");
        assert!((up_of(&scene.camera) - camera_up).length() < 1e-9, "{up} {more}: {}", scene.camera.up);
    }
    let error = read("up = \"north\"", "").expect_err("no axis").to_string();
    assert!(error.contains("up \"north\" is none of x, y, z, -x, -y and -z"), "{error}");
}
