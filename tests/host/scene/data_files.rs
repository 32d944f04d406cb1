//! Data files that are scenes by themselves.

use crate::scene::hair_files::samples as hair_samples;
use crate::scene::tressfx_files::samples as tressfx_samples;
use crate::scene::*;
use crate::support::shared_data;
use glam::DVec3;
use gobo::scene::LightKind;
use tempfile::TempDir;

fn data_file(name: &str, bytes: &[u8]) -> gobo::Result<Scene> {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("write the file");
    load(&path)
}

/// Returns points on the surfaces of all casters, and the vertices of all meshes.
fn surface(scene: &Scene) -> Vec<DVec3> {
    let vec = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let mut spheres: Vec<_> = scene.particles.iter().map(|p| (vec(p.position), f64::from(p.radius))).collect();
    spheres.extend(scene.strands.iter().flat_map(|s| [s.start, s.end].map(|end| (vec(end), f64::from(s.radius)))));
    spheres.extend(scene.meshes.iter().flat_map(|m| &m.positions).map(|p| (vec(*p), 0.0)));
    let around = [-1.0, 0.0, 1.0];
    let directions = around.iter().flat_map(|x| around.iter().flat_map(move |y| around.map(|z| DVec3::new(*x, *y, z))));
    let directions: Vec<_> = directions.map(DVec3::normalize_or_zero).collect();
    spheres.iter().flat_map(|(centre, radius)| directions.iter().map(move |d| centre + *radius * d)).collect()
}

/// Asserts that everything is in a 16:9 picture and fills it in at least one direction, and that the light comes from above.
#[track_caller]
fn check_fitted(scene: &Scene, up: DVec3) {
    let camera = &scene.camera;
    assert_eq!(camera.up, up);
    let forward = (camera.target - camera.position).normalize();
    let right = forward.cross(up).normalize();
    let above = right.cross(forward);
    let tangent = (camera.fov_y_degrees.to_radians() / 2.0).tan();
    let mut widest: f64 = 0.0;
    for point in surface(scene) {
        let offset = point - camera.position;
        let z = offset.dot(forward);
        assert!(z > 0.0, "{point} is behind the camera");
        let across = offset.dot(right).abs() / (z * tangent * 16.0 / 9.0);
        widest = widest.max(across).max(offset.dot(above).abs() / (z * tangent));
    }
    assert!((0.85..0.95).contains(&widest), "reaches to {widest} of the half picture");
    assert!(forward.dot(up) < -0.1, "seen from above");
    let [light] = &scene.lights[..] else { panic!("one light: {:?}", scene.lights) };
    let LightKind::Directional { direction } = light.kind else { panic!("a directional light: {light:?}") };
    assert!((direction.length() - 1.0).abs() < 1e-12 && (-0.95..-0.7).contains(&direction.dot(up)), "{direction}");
    // The light must come from the side and not from behind the camera, or no shadow would be visible.
    assert!(direction.dot(forward) < 0.8, "{direction}");
    assert_eq!(light.radiance, [1.0; 3]);
}

#[test]
fn each_kind_is_a_scene_by_itself() {
    let rows = [[1.0, 2.0, 3.0, 0.5, 0.8], [-10.0, 2.0, 30.0, 2.5, 0.1]];
    let smoke = ascii_ply(&FIELDS, &rows);
    let (y_up, z_up) = (DVec3::Y, DVec3::Z);
    for (name, bytes, up) in [
        ("smoke.ply", smoke.clone(), z_up),
        ("SMOKE.PLY", smoke.clone(), z_up),
        ("one.ply", ascii_ply(&FIELDS, &rows[..1]), z_up),
        ("tri.ply", TRIANGLE_PLY.into(), z_up),
        ("head.hair", hair_samples()[0].clone(), z_up),
        ("head.tfx", tressfx_samples()[0].clone(), y_up),
        ("head.Tfx", tressfx_samples()[3].clone(), y_up),
        ("leaf.gltf", gltf(&data_uri()).into(), y_up),
        ("leaf.glb", glb(), y_up),
    ] {
        let scene = data_file(name, &bytes).expect(name);
        assert_eq!(scene.name, name.split('.').next().expect("a name"));
        check_fitted(&scene, up);
    }
    // Some programs write point clouds with an element face without rows.
    let text = String::from_utf8(smoke).expect("ASCII");
    let cloud = text.replace("end_header", "element face 0\nproperty list uchar int vertex_indices\nend_header");
    assert_eq!(data_file("cloud.ply", cloud.as_bytes()).expect("particles").particles.len(), 2);
    assert_eq!(data_file("tri.ply", TRIANGLE_PLY.as_bytes()).expect("a mesh").meshes[0].triangles.len(), 3);
}

#[test]
fn what_shows_nothing_is_refused() {
    let mesh = |vertices: &str| TRIANGLE_PLY.replace("0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n", &vertices.repeat(5));
    for (name, bytes, words) in [
        ("smoke.ply", ascii_ply(&FIELDS, &[]), "nothing casts a shadow"),
        ("head.hair", crate::scene::hair_files::hair(0, 0, 2, 0, &[]), "nothing casts a shadow"),
        ("tri.ply", TRIANGLE_PLY.replace("face 2", "face 0").into(), "radius"),
        ("leaf.gltf", gltf(&data_uri()).replace(r#""mesh":0}"#, r#""name":"none"}"#).into(), "nothing casts a shadow"),
        ("tri.ply", mesh("1 2 3\n").into(), "all of it is in one point"),
        ("smoke.ply", ascii_ply(&FIELDS, &[[3e37, 0.0, 0.0, 1.0, 1.0], [1.0; 5]]), "exceeds 1e18"),
        ("smoke.ply", ascii_ply(&FIELDS, &[[0.0, 0.0, 0.0, 3e38, 1.0]]), "exceeds 1e18"),
        ("smoke.ply", b"ply".to_vec(), "PLY"),
        ("head.tfx", b"".to_vec(), "truncated"),
    ] {
        message(data_file(name, &bytes), name, words);
    }
    message(Scene::load("/nowhere/absent.ply", 0.0), "/nowhere/absent.ply", "No such file");
    message(
        Scene::load("smoke.xyz", 0.0),
        "smoke.xyz",
        "*.toml), a data file (*.ply, *.hair, *.tfx, *.gltf, *.glb, *.splat, *.spz, *.sog, *.ksplat, *.json, *.volume, *.nrrd, *.vdb, *.nvdb) or",
    );
    message(data_file("house.obj", b"v 0 0 0"), "house.obj", ".obj is not read");
    message(data_file("smoke.vdb", b"NRRD0004"), "smoke.vdb", "no OpenVDB file");
    message(Scene::load("ply", 0.0), "ply", "no such scene");
}

#[test]
fn shared_data_files_are_scenes() {
    let Some(folder) = shared_data("shared_data_files_are_scenes") else { return };
    for (file, up) in [
        ("plume_8k.ply", DVec3::Z),
        ("bunny.ply", DVec3::Z),
        ("houses.ply", DVec3::Z),
        ("terrain.gltf", DVec3::Y),
        ("mohawk.tfx", DVec3::Y),
    ] {
        check_fitted(&load(&folder.join(file)).expect(file), up);
    }
}
