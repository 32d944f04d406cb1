//! The scene loaders on good, broken and hostile files, and the built-in scenes. Everything goes through [`Scene::load`], as in the
//! program.

mod animations;
mod built_in;
mod courtyard;
mod data_files;
mod far_and_up;
mod gltf_alpha;
mod gltf_animations;
mod gltf_compressed;
mod gltf_extensions;
mod gltf_lights;
mod gltf_shapes;
mod hair_files;
mod loading;
mod mesh_files;
mod particle_files;
mod scene_files;
mod shared_data;
mod splat_files;
mod splat_formats;
mod tressfx_files;

use gobo::scene::{Mesh, Particle, Scene, Strand};
use std::path::Path;
use tempfile::TempDir;

const LIGHT: &str = "[light]\nkind = \"directional\"\ndirection = [0.0, 0.0, -2.0]\n";
const CAMERA: &str =
    "[camera]\nposition = [3, 0, 0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\nfov_y_degrees = 40.0\n";
const FIELDS: [&str; 5] = ["x", "y", "z", "radius", "extinction"];

fn load(path: &Path) -> gobo::Result<Scene> {
    Scene::load(path.to_str().expect("temporary paths are UTF-8"), 0.0)
}

/// Loads `bytes` as a file `name` through a scene file that refers to it.
fn load_caster(table: &str, name: &str, bytes: &[u8], keys: &str) -> gobo::Result<Scene> {
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join(name), bytes).expect("write the caster");
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, format!("[[{table}]]\nfile = {name:?}\n{keys}\n{LIGHT}{CAMERA}")).expect("write the scene");
    load(&scene)
}

fn particles(bytes: &[u8]) -> gobo::Result<Vec<Particle>> {
    Ok(load_caster("particles", "smoke.ply", bytes, "")?.particles)
}

fn strands(bytes: &[u8], keys: &str) -> gobo::Result<Vec<Strand>> {
    Ok(load_caster("hair", "head.hair", bytes, keys)?.strands)
}

fn meshes(name: &str, bytes: &[u8]) -> gobo::Result<Vec<Mesh>> {
    Ok(load_caster("meshes", name, bytes, "")?.meshes)
}

fn scene_file(text: &str) -> gobo::Result<Scene> {
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("tri.ply"), TRIANGLE_PLY).expect("write the mesh");
    std::fs::write(folder.path().join("smoke.ply"), ascii_ply(&FIELDS, &[[1.0, 2.0, 3.0, 0.5, 0.8]])).expect("write");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("write the scene");
    load(&path)
}

/// Returns the message of an error, after asserting what every message must satisfy.
#[track_caller]
fn message<T: std::fmt::Debug>(result: gobo::Result<T>, file: &str, words: &str) -> String {
    let message = result.expect_err("must be refused").to_string();
    assert!(message.contains(file), "{message:?} does not name {file}");
    assert!(message.contains(words), "{message:?} does not say {words:?}");
    assert!(!message.contains(['\n', '\r']), "{message:?} is not one line");
    message
}

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Little,
    Big,
}

fn header(format: &str, number: &str, fields: &[&str], count: usize) -> String {
    let properties: String = fields.iter().map(|field| format!("property {number} {field}\n")).collect();
    format!("ply\nformat {format} 1.0\ncomment test\nelement vertex {count}\n{properties}end_header\n")
}

fn binary_ply<const N: usize>(order: Order, number: &str, fields: &[&str; N], rows: &[[f64; N]]) -> Vec<u8> {
    let format = if order == Order::Little { "binary_little_endian" } else { "binary_big_endian" };
    let mut bytes = header(format, number, fields, rows.len()).into_bytes();
    for value in rows.iter().flatten() {
        let mut number =
            if number == "float" { (*value as f32).to_le_bytes().to_vec() } else { value.to_le_bytes().to_vec() };
        if order == Order::Big {
            number.reverse();
        }
        bytes.extend(number);
    }
    bytes
}

fn ascii_ply<const N: usize>(fields: &[&str; N], rows: &[[f64; N]]) -> Vec<u8> {
    let mut text = header("ascii", "float", fields, rows.len());
    for row in rows {
        text += &(row.map(|value| value.to_string()).join(" ") + "\n");
    }
    text.into_bytes()
}

const TRIANGLE_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n\
    4 0 1 2 3\n3 0 1 4\n";

/// Returns a triangle under a node that doubles it and moves it by (0, 0, 5).
fn gltf(buffer: &str) -> String {
    gltf_with(buffer, 4, r#""scale":[2,2,2],"translation":[0,0,5]"#, "36")
}

fn gltf_with(buffer: &str, mode: u32, node: &str, view_bytes: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1],{node}}},{{"mesh":0}}],
        "meshes":[{{"name":"leaf","primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":{mode},"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.1,0.2,0.3,1]}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
                     {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{view_bytes}}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
        "buffers":[{{"byteLength":44{buffer}}}]}}"#
    )
}

fn gltf_buffer() -> Vec<u8> {
    let positions = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

fn data_uri() -> String {
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(gltf_buffer());
    format!(r#","uri":"data:application/octet-stream;base64,{text}""#)
}

fn glb() -> Vec<u8> {
    let mut json = gltf("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let buffer = gltf_buffer();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}
