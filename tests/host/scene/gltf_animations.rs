//! Meshes that a glTF file's animation moves: at every time they must be where the keys say, by closed forms.

use super::gltf_shapes::{CORNERS, File, near};
use crate::scene::*;
use glam::DVec3;
use gobo::animate::AnimatedScene;
use serde_json::{Value, json};

/// Adds an animation of one channel of node 0.
fn animate(file: &mut File, path: &str, interpolation: &str, times: &[f32], kind: &str, numbers: &[f32]) {
    let (input, output) = (file.floats("SCALAR", times), file.floats(kind, numbers));
    let animation = json!({
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
    });
    match file.root["animations"].as_array_mut() {
        Some(all) => all.push(animation),
        None => file.root["animations"] = json!([animation]),
    }
}

/// Returns the corners of the file's triangle at a time.
fn at(scene: &AnimatedScene, time_s: f64) -> Vec<[f32; 3]> {
    scene.at(time_s).expect("a state").meshes.remove(0).positions
}

fn moved(by: [f32; 3]) -> [[f32; 3]; 3] {
    CORNERS.map(|corner| [0, 1, 2].map(|axis| corner[axis] + by[axis]))
}

/// Keys at 0, 1 and 3 s: places between them are linear, the last key's end is the loop's, and a scene loaded at a time shows that time.
#[test]
fn a_node_moves_linearly() {
    let mut file = File::new();
    let keys = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 8.0];
    animate(&mut file, "translation", "LINEAR", &[0.0, 1.0, 3.0], "VEC3", &keys);
    let scene = file.load().expect("a scene");
    assert!(scene.moves() && scene.notes[0].ends_with("animation 0 is played, 3.000 s"), "{:?}", scene.notes);
    for (time_s, place) in [
        (0.0, [0.0; 3]),
        (0.5, [1.0, 0.0, 0.0]),
        (2.0, [2.0, 0.0, 4.0]),
        (3.25, [0.5, 0.0, 0.0]),
        (30.5, [1.0, 0.0, 0.0]),
    ] {
        near(&at(&scene, time_s), &moved(place));
    }
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("moving.gltf");
    std::fs::write(&path, file.text()).expect("written");
    let scene = Scene::load(path.to_str().expect("UTF-8"), 2.0).expect("a scene");
    near(&scene.meshes[0].positions, &moved([2.0, 0.0, 4.0]));
    // The camera is fitted to all of the way.
    let camera = scene.camera;
    let seen = |point: [f64; 3]| {
        let (to, ahead) = (DVec3::from(point) - camera.position, camera.target - camera.position);
        to.angle_between(ahead).to_degrees()
    };
    let edge = 36.1; // Half of the diagonal of 38 degrees in 16:9.
    assert!(seen([0.0; 3]) < edge && seen([2.0, 0.0, 8.0]) < edge, "{} {}", seen([0.0; 3]), seen([2.0, 0.0, 8.0]));
}

/// Half of a quarter turn is an eighth; a step keeps the earlier key; a cubic spline is the cubic that its tangents say.
#[test]
fn turns_steps_and_splines() {
    let mut file = File::new();
    let half = 0.5f32.sqrt();
    animate(&mut file, "rotation", "LINEAR", &[0.0, 2.0], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let scene = file.load().expect("a scene");
    near(&at(&scene, 1.0), &[[0.0; 3], [half, half, 0.0], [-half, half, 0.0]]);

    let mut file = File::new();
    animate(&mut file, "scale", "STEP", &[0.5, 1.0, 2.0], "VEC3", &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0, 5.0, 1.0, 1.0]);
    let scene = file.load().expect("a scene");
    for (time_s, size) in [(0.2, 1.0), (0.9, 1.0), (1.0, 3.0), (1.99, 3.0)] {
        near(&at(&scene, time_s), &[CORNERS[0], [size, 0.0, 0.0], CORNERS[2]]);
    }

    // x = t³ and y = t² from 0 to 2, by their values and derivatives at the ends.
    let mut file = File::new();
    let first = [[0.0; 3], [0.0; 3], [0.0, 0.0, 0.0]];
    let last = [[12.0, 4.0, 0.0], [8.0, 4.0, 0.0], [0.0; 3]];
    let keys: Vec<f32> = [first, last].into_iter().flatten().flatten().collect();
    animate(&mut file, "translation", "CUBICSPLINE", &[0.0, 2.0], "VEC3", &keys);
    let scene = file.load().expect("a scene");
    for time_s in [0.25, 1.0, 1.75f32] {
        near(&at(&scene, time_s.into()), &moved([time_s.powi(3), time_s.powi(2), 0.0]));
    }
}

/// The weight of a morph target, and a joint that a skinned vertex follows.
#[test]
fn weights_and_joints_move_vertices() {
    let mut file = File::new();
    let target = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    file.primitive()["targets"] = json!([{"POSITION": target}]);
    animate(&mut file, "weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 4.0]);
    near(&at(&file.load().expect("a scene"), 0.25), &[[0.0, 0.0, 1.0], CORNERS[1], CORNERS[2]]);

    let mut file = File::new();
    let joints = file.bytes("VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
    file.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    file.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    file.root["nodes"] = json!([{}, {"mesh": 0, "skin": 0}, {}]);
    file.root["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    file.root["skins"] = json!([{"joints": [2, 0]}]);
    animate(&mut file, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
    // Joint 1 is node 0, which rises; the last vertex follows it by half.
    near(&at(&file.load().expect("a scene"), 0.5), &[CORNERS[0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.5]]);
}

/// A scene file names an animation, and places what it moves. What an animation moves and is not shown is told.
#[test]
fn animations_are_named_and_placed() {
    let mut file = File::new();
    animate(&mut file, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    animate(&mut file, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    file.root["animations"][1]["name"] = json!("up");
    file.root["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    file.root["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    let load = |keys: &str| {
        let folder = TempDir::new().expect("a folder");
        std::fs::write(folder.path().join("moving.gltf"), file.text()).expect("written");
        let text =
            format!("[[meshes]]\nfile = \"moving.gltf\"\nscale = 2.0\ntranslate = [0, 0, 5]\n{keys}\n{LIGHT}{CAMERA}");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, text).expect("written");
        AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0)
    };
    let placed = |by: [f32; 3]| moved(by).map(|corner| [2.0 * corner[0], 2.0 * corner[1], 2.0 * corner[2] + 5.0]);
    let scene = load("").expect("a scene");
    near(&at(&scene, 0.5), &placed([0.5, 0.0, 0.0]));
    let told = scene.notes.join("\n");
    assert!(told.contains("animation 0 is played, 1.000 s, another is not"), "{told}");
    assert!(told.contains("1 light, camera or mesh of splats that it moves stays at rest"), "{told}");
    near(&at(&load("animation = \"up\"").expect("a scene"), 0.5), &placed([0.0, 0.5, 0.0]));
    let error = load("animation = \"down\"").expect_err("no such").to_string();
    assert!(error.contains("no animation down: it has 0, up"), "{error}");
}

/// A node that is nothing at rest, or mirrored, moves by its own parts: a matrix would not give them back.
#[test]
fn nodes_keep_the_parts_that_no_channel_moves() {
    let mut file = File::new();
    file.root["nodes"][0]["scale"] = json!([0, 0, 0]);
    animate(&mut file, "scale", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0]);
    near(&at(&file.load().expect("a scene"), 0.5), &CORNERS);

    let mut file = File::new();
    file.root["nodes"][0]["scale"] = json!([1, -1, 1]);
    file.root["nodes"][0]["translation"] = json!([5, 0, 0]);
    let half = 0.5f32.sqrt();
    animate(&mut file, "rotation", "LINEAR", &[0.0, 1.0], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let scene = file.load().expect("a scene");
    near(&at(&scene, 0.0), &[[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, -1.0, 0.0]]);
    near(&at(&scene, 0.5), &[[5.0, 0.0, 0.0], [5.0 + half, half, 0.0], [5.0 + half, -half, 0.0]]);
}

/// A damaged channel is left out; a note says what is wrong with it. The mesh stays.
#[test]
fn what_is_wrong_is_named() {
    let with = |change: &dyn Fn(&mut File)| {
        let mut file = File::new();
        animate(&mut file, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[0.0; 6]);
        change(&mut file);
        let scene = file.load().expect("a scene");
        near(&scene.scene.meshes[0].positions, &CORNERS);
        let note =
            scene.notes.into_iter().find(|note| note.contains("1 channel of it is damaged and left out; node 0: "));
        note.expect("a note")
    };
    let sampler = |file: &mut File, key: &str, value: Value| file.root["animations"][0]["samplers"][0][key] = value;
    for (error, words) in [
        (with(&|file| sampler(file, "interpolation", json!("QUINTIC"))), "interpolation QUINTIC is not known"),
        (with(&|file| sampler(file, "input", json!(99))), "input has no accessor"),
        (with(&|file| sampler(file, "output", json!(1))), "output is Scalar"),
        (
            with(&|file| {
                let times = file.floats("SCALAR", &[1.0, 0.0]);
                sampler(file, "input", json!(times));
            }),
            "its times do not increase",
        ),
        (
            with(&|file| {
                let times = file.floats("SCALAR", &[1.0, 2.0, 3.0]);
                sampler(file, "input", json!(times));
            }),
            "2 numbers for each key",
        ),
        (
            with(&|file| {
                let numbers = file.floats("VEC3", &[0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0]);
                sampler(file, "output", json!(numbers));
            }),
            "a number is not finite",
        ),
    ] {
        assert!(error.contains(words) && !error.contains('\n'), "{error}, not {words}");
    }
}
