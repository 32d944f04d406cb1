//! Lights and cameras of glTF files, in scene files and by themselves.

use crate::scene::*;
use glam::DVec3;
use gobo::scene::{Camera, Light, LightKind};

/// Returns the triangle of [`gltf`], from (0, 0, 5) to (2, 0, 5) and (0, 2, 5), with further nodes, and with lights and cameras that they
/// name by index.
fn staged(nodes: &str, lights: &str, cameras: &str) -> String {
    let numbers: String = (2..2 + nodes.matches("\"n\"").count()).map(|n| format!(",{n}")).collect();
    let top = format!(
        r#"{{"extensionsRequired":["KHR_lights_punctual"],"cameras":[{cameras}],
        "extensions":{{"KHR_lights_punctual":{{"lights":[{lights}]}}}},"#
    );
    gltf(&data_uri())
        .replace(r#""scenes":[{"nodes":[0]}]"#, &format!(r#""scenes":[{{"nodes":[0{numbers}]}}]"#))
        .replace(r#"{"mesh":0}]"#, &format!(r#"{{"mesh":0}},{nodes}]"#))
        .replacen('{', &top, 1)
}

fn light_node(light: u32, placed: &str) -> String {
    format!(r#"{{"name":"n","extensions":{{"KHR_lights_punctual":{{"light":{light}}}}}{placed}}}"#)
}

/// Rotates −z to −y: by −90° about x.
const DOWN: &str = r#","rotation":[-0.7071067811865476,0,0,0.7071067811865476]"#;
const PERSPECTIVE: &str = r#"{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}}"#;
const CAMERA_NODE: &str = r#"{"name":"n","camera":0,"translation":[1,2,9],"scale":[3,3,3]}"#;

fn written(folder: &TempDir, scene: &str, text: &str) -> gobo::Result<Scene> {
    std::fs::write(folder.path().join("leaf.gltf"), text).expect("write the mesh");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene).expect("write the scene");
    load(&path)
}

fn alone(text: &str) -> gobo::Result<Scene> {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, text).expect("write the mesh");
    load(&path)
}

fn near(a: DVec3, b: [f64; 3]) -> bool {
    a.distance(DVec3::from(b)) < 1e-6
}

#[test]
fn lights_stand_where_their_nodes_are() {
    // The centre of the triangle's box is (1, 1, 5), its half diagonal √2. At a distance of 10, 100 cd give 1 lux.
    let lights = r#"{"type":"directional","intensity":4,"color":[1,0.5,0]},
        {"type":"point","intensity":100},
        {"type":"spot","intensity":200,"spot":{"outerConeAngle":0.5}},
        {"type":"point","intensity":1,"color":[0,0,1]}"#;
    let nodes = [
        light_node(0, DOWN),
        light_node(1, r#","translation":[1,1,15]"#),
        light_node(2, r#","translation":[1,11,5],"rotation":[0,0,0,1],"scale":[5,5,5]"#),
        light_node(3, ""),
        light_node(3, r#","translation":[1,1,5]"#),
    ];
    let scene = alone(&staged(&nodes.join(","), lights, "")).expect("five lights");
    let [directional, point, spot, far, among] = &scene.lights[..] else { panic!("five lights: {:?}", scene.lights) };
    let LightKind::Directional { direction } = directional.kind else { panic!("{directional:?}") };
    assert!(near(direction, [0.0, -1.0, 0.0]), "{direction}");
    // The brightest light is scaled to 1: here 4 lux.
    assert_eq!(directional.radiance, [1.0, 0.5, 0.0]);
    assert_eq!(
        *point,
        Light {
            kind: LightKind::Point { position: DVec3::new(1.0, 1.0, 15.0) },
            radiance: [0.25; 3],
            radius: f64::INFINITY
        }
    );
    let LightKind::Spot { position, direction, cone_degrees } = spot.kind else { panic!("{spot:?}") };
    assert!(near(position, [1.0, 11.0, 5.0]) && near(direction, [0.0, 0.0, -1.0]));
    assert!((cone_degrees - 1.0_f64.to_degrees()).abs() < 1e-5);
    assert_eq!(spot.radiance, [0.5; 3]);
    // 1 cd at a distance of √27, and 1 cd at the centre, which counts as √2 away.
    assert!((f64::from(far.radiance[2]) - 1.0 / 27.0 / 4.0).abs() < 1e-6 && far.radiance[0] == 0.0);
    assert!((f64::from(among.radiance[2]) - 1.0 / 2.0 / 4.0).abs() < 1e-6);

    let off = staged(&light_node(0, ""), r#"{"type":"point","intensity":0}"#, "");
    let lights = alone(&off).expect("its only light is off").lights;
    assert!(matches!(lights[..], [Light { kind: LightKind::Directional { .. }, .. }]), "fitted: {lights:?}");
    let wide = staged(&light_node(0, ""), r#"{"type":"spot","spot":{"outerConeAngle":1.5707963267948966}}"#, "");
    let lights = alone(&wide).expect("half a sphere").lights;
    assert!(matches!(lights[..], [Light { kind: LightKind::Spot { cone_degrees: 170.0, .. }, .. }]), "{lights:?}");
}

#[test]
fn cameras_look_along_their_nodes() {
    let orthographic = r#"{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"zfar":9,"znear":0.1}}"#;
    let nodes = [CAMERA_NODE.replace(r#""camera":0"#, r#""camera":1"#), CAMERA_NODE.replace(r#"[1,2,9]"#, "[4,5,6]")];
    let Camera { position, target, up, fov_y_degrees } =
        alone(&staged(CAMERA_NODE, "", PERSPECTIVE)).expect("a camera").camera;
    assert!(near(position, [1.0, 2.0, 9.0]) && near((target - position).normalize(), [0.0, 0.0, -1.0]));
    assert!(near(up, [0.0, 1.0, 0.0]) && (fov_y_degrees - 0.5_f64.to_degrees()).abs() < 1e-5);
    // The second node has the first perspective camera.
    let camera =
        alone(&staged(&nodes.join(","), "", &format!("{PERSPECTIVE},{orthographic}"))).expect("two cameras").camera;
    assert!(near(camera.position, [4.0, 5.0, 6.0]));
    let turned = CAMERA_NODE.replace(r#","translation":[1,2,9]"#, DOWN);
    let camera = alone(&staged(&turned, "", PERSPECTIVE)).expect("a camera").camera;
    assert!(near((camera.target - camera.position).normalize(), [0.0, -1.0, 0.0]) && near(camera.up, [0.0, 0.0, -1.0]));
    // With an orthographic camera only, the camera is fitted.
    let fitted = alone(&gltf(&data_uri())).expect("no camera").camera;
    assert_eq!(alone(&staged(CAMERA_NODE, "", orthographic)).expect("orthographic").camera, fitted);
}

#[test]
fn scene_files_take_what_they_do_not_name() {
    let folder = TempDir::new().expect("a temporary folder");
    let mesh = "[[meshes]]\nfile = \"leaf.gltf\"\nscale = 2.0\ntranslate = [0.0, 0.0, 1.0]\n";
    let lights = r#"{"type":"point"}"#;
    let nodes = format!("{},{CAMERA_NODE}", light_node(0, r#","translation":[1,1,15]"#));
    let text = staged(&nodes, lights, PERSPECTIVE);
    let scene = written(&folder, mesh, &text).expect("light and camera of the glTF file");
    assert_eq!(
        scene.lights,
        [Light {
            kind: LightKind::Point { position: DVec3::new(2.0, 2.0, 31.0) },
            radiance: [1.0; 3],
            radius: f64::INFINITY
        }]
    );
    assert!(near(scene.camera.position, [2.0, 4.0, 19.0]));
    assert!(near((scene.camera.target - scene.camera.position).normalize(), [0.0, 0.0, -1.0]));

    // Half a turn about x flips the signs of y and z, before the translation.
    let turned = written(&folder, &format!("{mesh}rotate = [1, 0, 0, 180]\n"), &text).expect("turned");
    let LightKind::Point { position } = turned.lights[0].kind else { panic!("a point light") };
    assert!(near(position, [2.0, -2.0, -29.0]));
    assert!(near(turned.camera.position, [2.0, -4.0, -17.0]) && near(turned.camera.up, [0.0, -1.0, 0.0]));
    assert!(near((turned.camera.target - turned.camera.position).normalize(), [0.0, 0.0, 1.0]));
    let sun = staged(&nodes, r#"{"type":"directional"}"#, PERSPECTIVE);
    for (more, direction) in [("", [0.0, 0.0, -1.0]), ("rotate = [1, 0, 0, 90]\n", [0.0, 1.0, 0.0])] {
        let scene = written(&folder, &format!("{mesh}{more}"), &sun).expect("a sun");
        let LightKind::Directional { direction: found } = scene.lights[0].kind else { panic!("a directional light") };
        assert!(near(found, direction), "{found}");
    }

    let named = written(&folder, &format!("{mesh}{LIGHT}{CAMERA}"), &text).expect("its own");
    assert_eq!(named.camera.position, DVec3::new(3.0, 0.0, 0.0));
    assert!(matches!(named.lights[..], [Light { kind: LightKind::Directional { .. }, .. }]));
    let twice = written(&folder, &format!("{mesh}{mesh}{CAMERA}"), &text).expect("the lights of both");
    assert_eq!(twice.lights.len(), 2);

    // Without a camera, one is fitted: upright by glTF's convention, with every corner inside its picture.
    let scene = written(&folder, &format!("{mesh}{LIGHT}"), &staged(&light_node(0, ""), lights, "")).expect("fitted");
    let camera = scene.camera;
    assert_eq!(camera.up, DVec3::Y);
    let forward = (camera.target - camera.position).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let tangent = (0.5 * camera.fov_y_degrees.to_radians()).tan();
    for corner in &scene.meshes[0].positions {
        let at = DVec3::from(corner.map(f64::from)) - camera.position;
        let [x, y] = [at.dot(right), at.dot(up)].map(|offset| (offset / at.dot(forward) / tangent).abs());
        assert!(at.dot(forward) > 0.0 && y <= 1.0 && x <= 16.0 / 9.0, "{corner:?}: {x}, {y}");
    }

    for (scene, text, words) in [
        (format!("{mesh}{CAMERA}"), staged(CAMERA_NODE, "", PERSPECTIVE), "missing field `light`"),
        (mesh.replace("2.0", "1.5e17"), text.clone(), "node 2: placed light position"),
        (format!("{}{LIGHT}", mesh.replace("2.0", "1.5e17")), text, "node 2: placed light position"),
    ] {
        message(written(&folder, &scene, &text), "scene.toml", words);
    }
}

#[test]
fn broken_lights_and_cameras_are_refused() {
    let at = |placed: &str| light_node(0, placed);
    let spot = |angle: &str| format!(r#"{{"type":"spot","spot":{{"outerConeAngle":{angle}}}}}"#);
    for (text, words) in [
        (staged(&at(""), r#"{"type":"area"}"#, ""), "Invalid value"),
        (staged(&at(""), r#"{"type":"spot"}"#, ""), "Missing data"),
        (staged(&light_node(1, ""), r#"{"type":"point"}"#, ""), "Index out of bounds"),
        (staged(&at(""), r#"{"type":"point","intensity":-1}"#, ""), "node 2: light radiance"),
        (staged(&at(""), r#"{"type":"point","intensity":1e39}"#, ""), "node 2: light radiance"),
        (staged(&at(""), &spot("0"), ""), "node 2: light outerConeAngle 0"),
        (staged(&at(""), &spot("1.6"), ""), "node 2: light outerConeAngle 1.6"),
        (staged(&at(r#","scale":[0,0,0]"#), r#"{"type":"directional"}"#, ""), "node 2: light has no direction"),
        (staged(&at(r#","translation":[1e19,0,0]"#), r#"{"type":"point"}"#, ""), "node 2: light position"),
        (staged(CAMERA_NODE, "", r#"{"type":"perspective"}"#), "Missing data"),
        (staged(CAMERA_NODE, "", &PERSPECTIVE.replace("0.5", "0")), "node 2: camera fov_y_degrees 0"),
        (staged(CAMERA_NODE, "", &PERSPECTIVE.replace("0.5", "3.2")), "node 2: camera fov_y_degrees"),
        (staged(&CAMERA_NODE.replace("[3,3,3]", "[3,3,0]"), "", PERSPECTIVE), "node 2: camera has no direction"),
        (staged(&CAMERA_NODE.replace("[1,2,9]", "[1,2,1e38]"), "", PERSPECTIVE), "node 2: camera position"),
    ] {
        message(alone(&text), "leaf.gltf", words);
    }
}
