//! PLY and glTF meshes: valid ones must load, others must be refused.

use crate::scene::*;
use gobo::scene::Mesh;
use tempfile::TempDir;

#[test]
fn ply_meshes_load_with_fans() {
    let loaded = meshes("tri.ply", TRIANGLE_PLY.as_bytes()).expect("a mesh");
    assert_eq!(loaded.len(), 1);
    assert_eq!(loaded[0].name, "tri");
    assert_eq!(loaded[0].triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
    assert_eq!(loaded[0].positions[4], [0.5, 0.5, 1.0]);
    assert_eq!(loaded[0].albedo, [0.7; 3]);
    let no_faces = TRIANGLE_PLY.replace("face 2", "face 0");
    assert!(meshes("tri.ply", no_faces.as_bytes()).expect("no faces, no mesh").is_empty());
}

#[test]
fn broken_ply_meshes_are_refused() {
    for (from, to, words) in [
        ("3 0 1 4", "3 0 1 5", "out of range"),
        ("3 0 1 4", "3 0 1 -1", "face 1"),
        ("3 0 1 4", "2 0 1", "face 1"),
        ("3 0 1 4", "0", "face 1"),
        ("3 0 1 4", "4000000000 0 1 4", "face 1"),
        ("3 0 1 4\n", "", "face 1"),
        ("0.5 0.5 1\n", "0.5 0.5 1e39\n", "finite"),
        ("property float y", "property float why", "property y"),
        ("element face", "element strip", "no element face"),
        ("vertex_indices", "indices", "vertex_indices"),
        ("int vertex_indices", "float vertex_indices", "face 0"),
    ] {
        let text = TRIANGLE_PLY.replace(from, to);
        assert_ne!(text, TRIANGLE_PLY);
        message(meshes("tri.ply", text.as_bytes()), "tri.ply", words);
    }
    message(meshes("tri.obj", b""), "tri.obj", ".gltf");
}

#[test]
fn gltf_meshes_load_in_world_space() {
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("a b.bin"), gltf_buffer()).expect("write the buffer");
    std::fs::write(folder.path().join("beside.gltf"), gltf(r#","uri":"a%20b.bin""#)).expect("write the mesh");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, format!("[[meshes]]\nfile = \"beside.gltf\"\n{LIGHT}{CAMERA}")).expect("write the scene");
    let beside = load(&path).expect("a buffer in a file of its own").meshes;
    let embedded = meshes("leaf.gltf", gltf(&data_uri()).as_bytes()).expect("an embedded buffer");
    let binary = meshes("leaf.GLB", &glb()).expect("binary glTF");
    assert_eq!(embedded, beside);
    assert_eq!(embedded, binary);
    let expected = Mesh {
        name: "leaf".into(),
        positions: vec![[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [0.0, 2.0, 5.0]],
        triangles: vec![[0, 1, 2]],
        albedo: [0.1, 0.2, 0.3],
        solid: false,
        alpha: None,
    };
    assert_eq!(embedded, [expected]);
    let bare = gltf(&data_uri()).replace(r#","material":0"#, "").replace(r#""name":"leaf","#, "");
    let bare = meshes("leaf.gltf", bare.as_bytes()).expect("no material, no name");
    assert_eq!((bare[0].albedo, bare[0].name.as_str()), ([0.7; 3], "leaf#0"));
    let mirrored = gltf_with(&data_uri(), 4, r#""scale":[-1,1,1]"#, "36");
    assert_eq!(meshes("leaf.gltf", mirrored.as_bytes()).expect("mirrored")[0].triangles, [[0, 2, 1]]);
}

#[test]
fn broken_gltf_is_refused() {
    let uri = data_uri();
    let scale = r#""scale":[1,1,1]"#;
    let mut short_length = glb();
    short_length[8..12].copy_from_slice(&3_u32.to_le_bytes());
    let cases: [(&str, Vec<u8>); 17] = [
        ("no accessor 2", gltf(&uri).replace("POSITION\":0", "POSITION\":2").into()),
        ("indices", gltf(&uri).replace("\"indices\":1", "\"indices\":2").into()),
        ("beyond its buffer", gltf_with(&uri, 4, scale, "35").into()),
        (
            "more than 67108864 vertices",
            gltf(&uri).replace(r#""count":3,"type":"VEC3""#, r#""count":4000000000,"type":"VEC3""#).into(),
        ),
        ("beyond its buffer", gltf(&uri).replace(r#""byteOffset":36"#, r#""byteOffset":18446744073709551615"#).into()),
        ("whole triangles", gltf(&uri).replace(r#""count":3,"type":"SCALAR""#, r#""count":2,"type":"SCALAR""#).into()),
        ("more than one parent", gltf(&uri).replace(r#""mesh":0}"#, r#""mesh":0,"children":[0]}"#).into()),
        ("finite", gltf(&uri).replace("[2,2,2]", "[1e39,2,2]").into()),
        ("finite", gltf(&uri).replace("[2,2,2]", "[3e38,2,2]").replace("[0,0,5]", "[3e38,0,5]").into()),
        ("truncated", gltf(&uri).replace(r#""byteLength":44"#, r#""byteLength":45"#).into()),
        ("base64", gltf(r#","uri":"data:,abc""#).into()),
        ("buffer 0", gltf(r#","uri":"data:;base64,=""#).into()),
        ("malformed URI", gltf(r#","uri":"%ff.bin""#).into()),
        ("malformed URI", gltf(r#","uri":"%+1.bin""#).into()),
        ("absent.bin", gltf(r#","uri":"absent.bin""#).into()),
        ("unsupported URI", gltf(r#","uri":"https://example.com/a.bin""#).into()),
        ("truncated", short_length),
    ];
    for (words, bytes) in cases {
        message(meshes("leaf.gltf", &bytes), "leaf.gltf", words);
    }
    for end in 0..glb().len() {
        message(meshes("leaf.glb", &glb()[..end]), "leaf.glb", "");
    }
}

/// Many primitives may share vertices, but each gets its own copy: the total must be limited.
#[test]
fn gltf_does_not_unfold_without_end() {
    if crate::support::is_left_out("gltf_does_not_unfold_without_end") {
        return;
    }
    let (vertices, primitives) = (1 << 20, 65);
    let primitive = r#"{"attributes":{"POSITION":0},"indices":1}"#;
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{}]}}],"extensionsRequired":["KHR_mesh_quantization"],
        "accessors":[{{"bufferView":0,"componentType":5121,"count":{vertices},"type":"VEC3","min":[0,0,0],"max":[0,0,0]}},
                     {{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{bytes},"byteStride":4}}],
        "buffers":[{{"byteLength":{bytes},"uri":"leaf.bin"}}]}}"#,
        vec![primitive; primitives].join(","),
        bytes = 4 * vertices,
    );
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("leaf.bin"), vec![0; 4 * vertices]).expect("write the buffer");
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, text).expect("write the file");
    message(load(&path), "leaf.gltf", "more than 67108864 vertices");
}
