//! glTF meshes that joints, morph targets and instances move, primitives of all modes, accessors of all kinds, and hidden nodes: vertices and
//! triangles must be where the file says.

use crate::scene::*;
use crate::support::shared_data;
use base64::Engine;
use gobo::animate::AnimatedScene;
use gobo::scene::LightKind;
use serde_json::{Value, json};

/// A glTF file under construction.
pub(super) struct File {
    pub root: Value,
    buffer: Vec<u8>,
}

pub(super) const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

impl File {
    /// Creates a file of one triangle at one node; accessor 0 has its positions.
    pub fn new() -> Self {
        let root = json!({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        let mut file = Self { root, buffer: Vec::new() };
        file.floats("VEC3", CORNERS.as_flattened());
        file
    }

    /// Adds bytes, and returns the number of their view.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let views = self.root["bufferViews"].as_array_mut().expect("an array");
        views.push(json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()}));
        let number = views.len() - 1;
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        number
    }

    /// Adds an accessor, and returns its number.
    fn accessor(&mut self, accessor: Value) -> usize {
        let all = self.root["accessors"].as_array_mut().expect("an array");
        all.push(accessor);
        all.len() - 1
    }

    /// Adds an accessor of floats.
    pub fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let each = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        let view = self.view(&numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        self.accessor(json!({"bufferView": view, "componentType": 5126, "count": numbers.len() / each, "type": kind}))
    }

    /// Adds an accessor of bytes.
    pub fn bytes(&mut self, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.accessor(json!({"bufferView": view, "componentType": 5121, "count": count, "type": kind}))
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.root["meshes"][0]["primitives"][0]
    }

    pub fn text(&self) -> String {
        let mut root = self.root.clone();
        let data = base64::engine::general_purpose::STANDARD.encode(&self.buffer);
        let uri = format!("data:application/octet-stream;base64,{data}");
        root["buffers"][0] = json!({"byteLength": self.buffer.len(), "uri": uri});
        root.to_string()
    }

    pub fn load(&self) -> gobo::Result<AnimatedScene> {
        let folder = TempDir::new().expect("a temporary folder");
        let path = folder.path().join("shape.gltf");
        std::fs::write(&path, self.text()).expect("written");
        AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0)
    }

    /// Returns the only mesh.
    fn mesh(&self) -> Mesh {
        let mut meshes = self.load().expect("a scene").scene.meshes;
        assert_eq!(meshes.len(), 1);
        meshes.remove(0)
    }
}

/// The corners of all triangles, in order.
fn corners(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    mesh.triangles.iter().map(|triangle| triangle.map(|index| mesh.positions[index as usize])).collect()
}

pub(super) fn near(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-5), "{found:?} for {expected:?}");
    }
}

/// Bounds of positions may be missing: nothing reads them.
#[test]
fn bounds_may_be_missing() {
    let mesh = File::new().mesh();
    assert_eq!((mesh.positions.as_slice(), mesh.triangles.as_slice()), (&CORNERS[..], &[[0, 1, 2]][..]));
}

/// Strips turn every other triangle; fans share their first corner; what uses a corner twice only joins others.
#[test]
fn strips_and_fans_are_triangles() {
    let with = |mode: u32, indices: &[u8]| {
        let mut file = File::new();
        file.root["accessors"][0]["count"] = json!(6);
        let more: Vec<f32> = (0..18).map(|i| (i * i % 7) as f32).collect();
        let view = file.view(&more.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        file.root["accessors"][0]["bufferView"] = json!(view);
        let indices = file.bytes("SCALAR", indices.len(), indices);
        file.primitive()["indices"] = json!(indices);
        file.primitive()["mode"] = json!(mode);
        file.load().map(|scene| scene.scene.meshes.into_iter().flat_map(|mesh| mesh.triangles).collect::<Vec<_>>())
    };
    assert_eq!(with(4, &[0, 1, 2, 3, 4, 5]).expect("a list"), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(with(5, &[0, 1, 2, 3, 4]).expect("a strip"), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(with(5, &[0, 1, 2, 2, 3, 3, 4, 5]).expect("joined strips"), [[0, 1, 2], [4, 3, 5]]);
    assert_eq!(with(6, &[5, 1, 2, 3]).expect("a fan"), [[5, 1, 2], [5, 2, 3]]);
    message(with(4, &[0, 1, 2, 3]).map(|_| ()), "shape.gltf", "4 indices are not whole triangles");
    message(with(5, &[0, 1, 9]).map(|_| ()), "shape.gltf", "vertex index 9 of 6 vertices");
    for mode in [0, 1, 2, 3] {
        message(with(mode, &[0, 1, 2]).map(|_| ()), "shape.gltf", "1 primitive of points or lines casts nothing");
    }
}

/// An accessor without a view has zeros, and sparse elements replace those of either.
#[test]
fn accessors_may_be_sparse_or_absent() {
    let sparse = |file: &mut File, index: &[u8], values: &[f32]| {
        let indices = file.view(index);
        let values = file.view(&values.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        json!({"count": index.len(), "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}})
    };
    let mut file = File::new();
    file.root["accessors"][0]["sparse"] = sparse(&mut file, &[1], &[5.0, 6.0, 7.0]);
    assert_eq!(file.mesh().positions, [CORNERS[0], [5.0, 6.0, 7.0], CORNERS[2]]);
    let mut file = File::new();
    let replaced = sparse(&mut file, &[0, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    file.root["accessors"][0] = json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": replaced});
    assert_eq!(file.mesh().positions, [[1.0, 2.0, 3.0], [0.0; 3], [4.0, 5.0, 6.0]]);
    file.root["accessors"][0]["sparse"] = sparse(&mut file, &[3], &[1.0, 2.0, 3.0]);
    message(file.load().map(|_| ()), "shape.gltf", "POSITION has a sparse element 3 of 3");
    for (count, words) in
        [(3_u64 << 20, "3145728 elements without a buffer view, more than"), (1 << 40, "more than 67108864 vertices")]
    {
        file.root["accessors"][0]["count"] = json!(count);
        message(file.load().map(|_| ()), "shape.gltf", words);
    }
}

/// A vertex goes where its joints take it, by their weights; the node of its mesh does not move it.
#[test]
fn joints_place_vertices() {
    let mut file = File::new();
    let joints = file.bytes("VEC4", 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0]);
    file.primitive()["attributes"] = json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let mut binds = [[0.0_f32; 16]; 2];
    binds.iter_mut().for_each(|bind| (0..4).for_each(|i| bind[5 * i] = 1.0));
    // The second joint was bound at (1, 0, 0).
    binds[1][12] = -1.0;
    let binds = file.floats("MAT4", binds.as_flattened());
    file.root["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    file.root["nodes"] = json!([
        {"mesh": 0, "skin": 0, "scale": [0.01, 0.01, 0.01], "translation": [3, 2, 0]},
        {"translation": [0, 0, 10], "children": [2]},
        {"translation": [1, 0, 0], "scale": [2, 2, 2]},
    ]);
    file.root["scenes"] = json!([{"nodes": [0, 1]}]);
    // The second joint doubles about (1, 0, 10) what is bound about (1, 0, 0).
    let blended = [0.25 * 0.0 + 0.75 * (1.0 - 2.0), 0.25 + 0.75 * 2.0, 10.0];
    near(&file.mesh().positions, &[[0.0, 0.0, 10.0], [1.0, 0.0, 10.0], blended]);
    // Weights need not add up to 1, and a vertex without stays with its node.
    let weights = file.floats("VEC4", &[0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    file.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    near(&file.mesh().positions, &[[0.0, 0.0, 10.0], [1.0, 0.0, 10.0], [3.0, 2.01, 0.0]]);
    let joints = file.bytes("VEC4", 3, &[7, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    file.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    message(file.load().map(|_| ()), "shape.gltf", "JOINTS_0 has joint 7 of 2");
}

/// Morph targets move vertices by the weights of the node or of the mesh.
#[test]
fn morph_targets_are_at_rest() {
    let mut file = File::new();
    let up = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 4.0]);
    let zeros = file.accessor(json!({"componentType": 5126, "count": 3, "type": "VEC3"}));
    file.primitive()["targets"] = json!([{"POSITION": up}, {"POSITION": zeros}]);
    assert_eq!(file.mesh().positions, CORNERS);
    let heights = |file: &File| file.mesh().positions.iter().map(|[_, _, z]| *z).collect::<Vec<_>>();
    file.root["meshes"][0]["weights"] = json!([0.5, 1.0]);
    assert_eq!(heights(&file), [0.5, 1.0, 2.0]);
    file.root["nodes"][0]["weights"] = json!([-1.0, 0.0]);
    assert_eq!(heights(&file), [-1.0, -2.0, -4.0]);
    let few = file.floats("VEC3", &[0.0, 0.0, 1.0]);
    file.primitive()["targets"][0] = json!({"POSITION": few});
    message(file.load().map(|_| ()), "shape.gltf", "morph target 0 has 1 of 3 vertices");
}

/// Instances are copies of the mesh, each in its place; a mirrored one is wound the other way.
#[test]
fn instances_are_copies() {
    let mut file = File::new();
    let places = file.floats("VEC3", &[10.0, 0.0, 0.0, 0.0, 20.0, 0.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let sizes = file.floats("VEC3", &[1.0, 1.0, 1.0, 3.0, 3.0, -3.0]);
    let attributes = json!({"TRANSLATION": places, "ROTATION": turns, "SCALE": sizes});
    file.root["nodes"] = json!([{"mesh": 0, "translation": [0, 0, 1], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]);
    file.root["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    file.root["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let mesh = file.mesh();
    let found = corners(&mesh);
    near(&found[0], &[[10.0, 0.0, 1.0], [11.0, 0.0, 1.0], [10.0, 1.0, 1.0]]);
    near(&found[1], &[[0.0, 20.0, 1.0], [-3.0, 20.0, 1.0], [0.0, 23.0, 1.0]]);
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (6, 2));
    let few = file.floats("VEC3", &[1.0; 3]);
    file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(few);
    message(file.load().map(|_| ()), "shape.gltf", "EXT_mesh_gpu_instancing with attributes of");
}

/// Hidden nodes, with all below them, cast and shine nothing, and a note counts them. So does one for what is not played.
#[test]
fn hidden_nodes_cast_nothing() {
    let mut file = File::new();
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    file.root["nodes"] = json!([
        {"mesh": 0},
        {"extensions": hidden, "children": [2]},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
    ]);
    file.root["scenes"] = json!([{"nodes": [0, 1]}]);
    for required in [json!([]), json!(["KHR_node_visibility"])] {
        file.root["extensionsRequired"] = required;
        let loaded = file.load().expect("a scene");
        assert_eq!(loaded.scene.meshes.len(), 1);
        let notes: Vec<_> = loaded.notes.iter().map(|note| note.split_once(": ").expect("a name").1).collect();
        assert_eq!(notes, ["1 hidden node casts nothing"]);
    }
}

/// The data project's cases, as far as they are of glTF.
#[test]
fn shared_cases_are_right() {
    let Some(folder) = shared_data("shared_cases_are_right") else { return };
    let folder = folder.join("cases");
    let scene = |name: &str| {
        let path = folder.join(name);
        AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let bounds = |mesh: &Mesh| {
        let of = |pick: fn(f32, f32) -> f32, start: f32| {
            mesh.positions.iter().fold([start; 3], |all, at| [0, 1, 2].map(|i| pick(all[i], at[i])))
        };
        [of(f32::min, f32::INFINITY), of(f32::max, f32::NEG_INFINITY)]
    };
    let box_of_1 = [[-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]];
    assert_eq!(bounds(&scene("d01-skin-under-a-small-node.gltf").scene.meshes[1]), box_of_1);
    for name in ["d03-zero-morph-target-without-view.gltf", "d04-position-without-bounds.gltf"] {
        assert_eq!(bounds(&scene(name).scene.meshes[1]), box_of_1, "{name}");
    }
    let lines = scene("d06-lines-beside-triangles.gltf");
    assert!(lines.notes[0].ends_with("1 primitive of points or lines casts nothing"), "{:?}", lines.notes);
    let strip = scene("d06-triangle-strip.gltf").scene;
    assert!(strip.meshes.iter().all(|mesh| !mesh.triangles.is_empty()));
    for name in ["d07-hidden-node.gltf", "d07-hidden-node-required.gltf"] {
        assert_eq!(scene(name).scene.meshes.len(), 2, "{name}");
    }
    let lamps = scene("d09-forty-lamps-with-a-range.gltf").scene.lights;
    let ranges = lamps.iter().filter(|lamp| lamp.radius == 3.0).count();
    let spots = lamps.iter().filter(|lamp| matches!(lamp.kind, LightKind::Spot { .. })).count();
    assert_eq!((lamps.len(), ranges, spots), (41, 40, 1));
    let bright = scene("d14-unlit-colour-1.2.gltf");
    assert!(bright.scene.meshes.iter().all(|mesh| mesh.albedo.iter().all(|channel| *channel <= 1.0)));
    assert!(bright.notes.iter().any(|note| note.contains("color beyond [0, 1]")), "{:?}", bright.notes);
}
