//! glTF files that use or require extensions.

use crate::scene::*;

fn with_root(json: &str) -> String {
    gltf(&data_uri()).replacen('{', &format!("{{{json},"), 1)
}

fn requiring(name: &str) -> String {
    with_root(&format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"]"#))
}

#[test]
fn extensions_that_hide_no_geometry_are_passed_over() {
    let plain = meshes("leaf.gltf", gltf(&data_uri()).as_bytes()).expect("without extensions");
    for name in [
        "KHR_lights_punctual",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "KHR_materials_unlit",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_of_next_year",
        "KHR_mesh_quantization",
        "KHR_xmp_json_ld",
        "KHR_animation_pointer",
        "KHR_node_visibility",
        "EXT_mesh_gpu_instancing",
        "EXT_texture_webp",
        "EXT_texture_avif",
        "MSFT_texture_dds",
    ] {
        assert_eq!(meshes("leaf.gltf", requiring(name).as_bytes()).expect(name), plain);
    }
    // An extension that is used but not required may be anything.
    let used = with_root(r#""extensionsUsed":["ACME_anything"],"extensions":{"ACME_anything":[1]}"#);
    assert_eq!(meshes("leaf.gltf", used.as_bytes()).expect("used"), plain);
}

/// Extensions may change textures, animations and attributes to a form that is invalid without them.
#[test]
fn what_is_not_read_may_have_any_form() {
    let plain = meshes("leaf.gltf", gltf(&data_uri()).as_bytes()).expect("without extensions");
    let text = with_root(
        r#""extensionsRequired":["EXT_texture_webp","KHR_animation_pointer"],
        "textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[{"uri":"absent.webp"}],
        "animations":[{"samplers":[],"channels":[{"sampler":0,"target":{"path":"pointer",
            "extensions":{"KHR_animation_pointer":{"pointer":"/nodes/0/scale"}}}}]}]"#,
    )
    .replace(r#""POSITION":0"#, r#""POSITION":0,"_FEATURE_ID_0":77,"TEXCOORD_0":78"#)
    .replace(r#""mode":4"#, r#""mode":4,"targets":[{"POSITION":79}]"#)
    .replace("\"baseColorFactor\"", r#""baseColorTexture":{"index":0},"baseColorFactor""#);
    assert_eq!(meshes("leaf.gltf", text.as_bytes()).expect("read past"), plain);
}

#[test]
fn extensions_that_hide_geometry_are_refused_by_name() {
    for (name, words) in [
        ("ACME_subdivision", "requires ACME_subdivision, which is not known here"),
        ("KHR_lights", "requires KHR_lights,"),
    ] {
        message(meshes("leaf.gltf", requiring(name).as_bytes()), "leaf.gltf", words);
    }

    // An extension that is used but not required must be refused if there is no fallback.
    let plain = gltf(&data_uri());
    let instanced = plain.replace(r#""mesh":0}"#, r#""mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}}"#);
    message(meshes("leaf.gltf", instanced.as_bytes()), "leaf.gltf", "EXT_mesh_gpu_instancing");
    let draco = r#""mode":4,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}"#;
    let draco = plain.replace(r#""mode":4"#, draco);
    assert!(meshes("leaf.gltf", draco.as_bytes()).is_ok(), "it has the vertices uncompressed too");
    for view in [r#""bufferView":0,"componentType""#, r#""bufferView":1,"componentType""#] {
        let alone = draco.replace(view, r#""componentType""#);
        assert_ne!(alone, draco);
        message(meshes("leaf.gltf", alone.as_bytes()), "leaf.gltf", "mesh 0: primitive 0 has damaged Draco data");
    }
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let extension = format!(r#""byteLength":44,"extensions":{{"{name}":{{"fallback":true}}}}"#);
        let placeholder = plain.replace(r#""byteLength":44"#, &extension);
        assert!(meshes("leaf.gltf", placeholder.as_bytes()).is_ok(), "the fallback is there");
        let empty = gltf("").replace(r#""byteLength":44"#, &extension);
        message(meshes("leaf.gltf", empty.as_bytes()), "leaf.gltf", "buffer 0: there is no binary chunk for it");
    }
}

/// Quantized positions must be read: the triangle of [`gltf`] in integers, aligned to 4 bytes as the extension requires.
#[test]
fn quantized_positions_are_read() {
    use base64::Engine;
    let expected = |corner: [f32; 3]| corner.map(|c| 2.0 * c).map(f32::to_bits);
    for (component_type, normalized, bytes, corner) in [
        (5120, false, &[&[-3_i8 as u8, 2, 1, 0][..]; 3], [-3.0, 2.0, 1.0]),
        (5120, true, &[&[-128_i8 as u8, 127, 0, 0][..]; 3], [-1.0, 1.0, 0.0]),
        (5121, false, &[&[200, 2, 1, 0][..]; 3], [200.0, 2.0, 1.0]),
        (5121, true, &[&[255, 51, 0, 0][..]; 3], [1.0, 0.2, 0.0]),
        (5122, false, &[&[0xFF, 0xFF, 0, 1, 2, 0, 0, 0][..]; 3], [-1.0, 256.0, 2.0]),
        (5122, true, &[&[0, 0x80, 0xFF, 0x7F, 0, 0, 0, 0][..]; 3], [-1.0, 1.0, 0.0]),
        (5123, false, &[&[0xFF, 0xFF, 0, 1, 2, 0, 0, 0][..]; 3], [65_535.0, 256.0, 2.0]),
        (5123, true, &[&[0xFF, 0xFF, 0x33, 0x33, 0, 0, 0, 0][..]; 3], [1.0, 0.2, 0.0]),
    ] {
        let stride = bytes[0].len();
        let mut buffer = bytes.concat();
        buffer.resize(36, 0);
        buffer.extend([0, 0, 1, 0, 2, 0, 0, 0]);
        let uri = base64::engine::general_purpose::STANDARD.encode(buffer);
        let text = gltf_with(&format!(r#","uri":"data:;base64,{uri}""#), 4, r#""scale":[2,2,2]"#, "36")
            .replace(
                r#""componentType":5126"#,
                &format!(r#""componentType":{component_type},"normalized":{normalized}"#),
            )
            .replace(
                r#"{"buffer":0,"byteLength":36}"#,
                &format!(r#"{{"buffer":0,"byteLength":36,"byteStride":{stride}}}"#),
            )
            .replacen('{', r#"{"extensionsRequired":["KHR_mesh_quantization"],"#, 1);
        let loaded = meshes("leaf.gltf", text.as_bytes()).expect("quantized");
        assert_eq!(loaded[0].positions.len(), 3);
        for position in &loaded[0].positions {
            assert_eq!(position.map(f32::to_bits), expected(corner), "{component_type} {normalized}: {position:?}");
        }
    }
    let wide = gltf(&data_uri()).replace(r#""componentType":5126"#, r#""componentType":5125"#);
    message(meshes("leaf.gltf", wide.as_bytes()), "leaf.gltf", "POSITION is Vec3 of U32");
}
