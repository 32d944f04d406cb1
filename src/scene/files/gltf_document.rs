//! glTF documents, reduced to the parts that are used: nodes and triangles, base colors and alpha, lights and cameras.

use crate::Result;
use crate::scene::files::input;
use base64::Engine;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::Path;

const WAY_OUT: &str = "check that the file is a glTF 2.0 file and was copied whole";

/// Extensions that replace vertices with compressed data.
const COMPRESSION: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

const VISIBILITY: &str = "KHR_node_visibility";

/// Extensions that a file may require, because they are supported or do not affect geometry.
const HARMLESS: [&str; 13] = [
    "ADOBE_materials_clearcoat_specular",
    "ADOBE_materials_thin_transparency",
    "AGI_stk_metadata",
    "EXT_mesh_features",
    INSTANCING,
    "EXT_structural_metadata",
    "KHR_animation_pointer",
    "KHR_mesh_quantization",
    VISIBILITY,
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_texture_dds",
];

/// Prefixes of the names of further extensions that a file may require.
const HARMLESS_FAMILIES: [&str; 6] =
    ["EXT_lights_", "EXT_materials_", "EXT_texture_", "KHR_lights_", "KHR_materials_", "KHR_texture_"];

/// An open glTF file, validated and with its buffers read.
pub(in crate::scene) struct GltfDocument {
    pub document: gltf::Document,
    /// Buffers in the document's order, each at least as long as the document declares.
    pub buffers: Vec<Vec<u8>>,
    /// The accessors whose elements are not stored, but 0.
    pub unstored: Vec<usize>,
    /// Whether each node is hidden by KHR_node_visibility, with all below it.
    pub hidden: Vec<bool>,
    /// The attributes by which each node places copies of its mesh (EXT_mesh_gpu_instancing); null without.
    pub instances: Vec<Value>,
    /// The number of animations.
    pub animations: usize,
    /// The file's `materials`, `textures`, `images` and `samplers`, as they are in the file. Nothing in them is validated.
    pub appearance: Value,
}

/// Opens a glTF or GLB file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated or malformed, a buffer cannot be read, or an extension hides
/// geometry; the message names the extension.
pub(in crate::scene) fn open(path: &Path) -> Result<GltfDocument> {
    let bytes = input::read(path)?;
    // A length below the header's own 12 bytes causes a subtraction overflow in the glTF crate.
    let length = bytes.get(8..12).and_then(|length| length.try_into().ok()).map_or(0, u32::from_le_bytes);
    let is_binary = bytes.starts_with(b"glTF");
    if is_binary && length < 12 {
        return Err(input::error(path, "truncated binary glTF header", WAY_OUT));
    }
    let unusable = |cause: gltf::Error| input::error(path, cause, WAY_OUT);
    let glb = is_binary.then(|| gltf::Glb::from_slice(&bytes)).transpose().map_err(unusable)?;
    let text = glb.as_ref().map_or(bytes.as_slice(), |glb| &glb.json);
    let malformed = |cause: serde_json::Error| input::error(path, cause, WAY_OUT);
    let mut json: Value = serde_json::from_slice(text).map_err(malformed)?;
    if let Some((cause, way_out)) = hidden_geometry(&json) {
        return Err(input::error(path, cause, way_out));
    }
    let of_nodes = |of: fn(&Value) -> Value| items(&json, "nodes").map(of).collect::<Vec<_>>();
    let hidden = of_nodes(|node| node["extensions"][VISIBILITY]["visible"].clone());
    let hidden = hidden.iter().map(|visible| visible == false).collect();
    let instances = of_nodes(|node| match &node["extensions"][INSTANCING] {
        Value::Null => Value::Null,
        extension => extension.get("attributes").cloned().unwrap_or(json!({})),
    });
    let animations = items(&json, "animations").count();
    let appearance = take_appearance(&mut json);
    keep_what_is_read(&mut json);
    add_bounds(&mut json);
    let unstored = add_views(&mut json);
    let root: gltf::json::Root = serde_json::from_value(json).map_err(malformed)?;
    // The glTF crate's validation looks up a POSITION accessor before checking its index.
    let mut attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|part| part.attributes.values());
    if let Some(missing) = attributes.find(|index| index.value() >= root.accessors.len()) {
        return Err(input::error(path, format!("there is no accessor {}", missing.value()), WAY_OUT));
    }
    let document = gltf::Document::from_json(root).map_err(unusable)?;
    // Only one buffer may use the binary chunk (glTF 2.0, 4.4.3.3). Copying it for several buffers without a URI would multiply memory use.
    let mut blob = glb.and_then(|glb| glb.bin).map(Cow::into_owned);
    let buffers = document.buffers().map(|buffer| read_buffer(path, &buffer, &mut blob)).collect::<Result<Vec<_>>>()?;
    Ok(GltfDocument { document, buffers, unstored, hidden, instances, animations, appearance })
}

fn items<'a>(of: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    of[key].as_array().into_iter().flatten()
}

/// Returns the element that an index under `key` refers to, in the root's array `array`.
fn target<'a>(root: &'a Value, array: &str, of: &Value, key: &str) -> Option<&'a Value> {
    root[array].get(usize::try_from(of[key].as_u64()?).ok()?)
}

/// Returns a description of the content that an extension makes unreadable, if any, and advice for the user.
fn hidden_geometry(root: &Value) -> Option<(String, &'static str)> {
    let decompress = "export it without compression, or run gltf-transform cp IN.glb OUT.glb";
    let compressed = |name| Some((format!("its geometry is compressed by {name}"), decompress));
    for name in items(root, "extensionsRequired").filter_map(Value::as_str) {
        if COMPRESSION.contains(&name) {
            return compressed(name);
        }
        if !HARMLESS.contains(&name) && !HARMLESS_FAMILIES.iter().any(|family| name.starts_with(family)) {
            let cause = format!("requires {name}, which is not known here and may change its geometry");
            return Some((cause, "export it without that extension"));
        }
    }
    // If the extension is not required, the file stores compressed content a second time, uncompressed.
    for part in items(root, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        for (of, key) in [(&part["attributes"], "POSITION"), (part, "indices")] {
            let Some(accessor) = target(root, "accessors", of, key) else { continue };
            let view = target(root, "bufferViews", accessor, "bufferView");
            let buffer = view.and_then(|view| target(root, "buffers", view, "buffer"));
            for name in COMPRESSION {
                let part_alone = !part["extensions"][name].is_null() && view.is_none();
                let is_placeholder = |buffer: &Value| buffer["extensions"][name]["fallback"] == true;
                if part_alone || buffer.is_some_and(|buffer| is_placeholder(buffer) && buffer["uri"].is_null()) {
                    return compressed(name);
                }
            }
        }
    }
    None
}

/// Returns the parts of the root that alpha is read from, and removes those of no other use: images may be large.
fn take_appearance(root: &mut Value) -> Value {
    let materials = root["materials"].clone();
    let mut taken = serde_json::Map::from_iter([("materials".into(), materials)]);
    for key in ["textures", "images", "samplers"] {
        taken.insert(key.into(), root.get_mut(key).map(Value::take).unwrap_or_default());
    }
    Value::Object(taken)
}

/// Whether an attribute of vertices is read: their places, their colors, their places in textures, and the joints that move them.
fn is_read(attribute: &str) -> bool {
    let is_numbered = |family: &str| matches!(attribute.strip_prefix(family).map(str::parse::<u32>), Some(Ok(_)));
    ["POSITION", "COLOR_0"].contains(&attribute) || ["TEXCOORD_", "JOINTS_", "WEIGHTS_"].into_iter().any(is_numbered)
}

/// Gives accessors of positions the bounds that they must have, and that nothing reads. Some exporters leave them out.
fn add_bounds(root: &mut Value) {
    let parts = items(root, "meshes").flat_map(|mesh| items(mesh, "primitives"));
    let all = parts.flat_map(|part| [&part["attributes"]].into_iter().chain(items(part, "targets")));
    let used: Vec<usize> = all.filter_map(|of| usize::try_from(of["POSITION"].as_u64()?).ok()).collect();
    for index in used {
        let Some(accessor) = root["accessors"].get_mut(index).and_then(Value::as_object_mut) else { continue };
        for bound in ["min", "max"] {
            accessor.entry(bound).or_insert_with(|| json!([0.0, 0.0, 0.0]));
        }
    }
}

/// Removes unused content. Extensions may give such content a form that the glTF crate rejects: textures with unknown image types,
/// animations of other properties, attributes with arbitrary names.
fn keep_what_is_read(root: &mut Value) {
    const READ: [&str; 12] = [
        "accessors",
        "asset",
        "bufferViews",
        "buffers",
        "cameras",
        "extensions",
        "materials",
        "meshes",
        "nodes",
        "scene",
        "scenes",
        "skins",
    ];
    let Some(root) = root.as_object_mut() else { return };
    root.retain(|key, _| READ.contains(&key.as_str()));
    let accessors = root.get("accessors").and_then(Value::as_array).map_or(0, |accessors| accessors.len() as u64);
    // The accessors of colors and texture coordinates must exist only if they are needed.
    let exists = |index: &Value| index.as_u64().is_some_and(|index| index < accessors);
    let mut each = |array: &str, reduce: &dyn Fn(&mut Value)| {
        root.get_mut(array).and_then(Value::as_array_mut).into_iter().flatten().for_each(reduce);
    };
    each("materials", &|material| {
        let color = material["pbrMetallicRoughness"].get("baseColorFactor").cloned();
        *material = color.map_or(json!({}), |color| json!({"pbrMetallicRoughness": {"baseColorFactor": color}}));
    });
    each("meshes", &|mesh| {
        for part in mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten() {
            let Some(part) = part.as_object_mut() else { continue };
            for target in part.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten() {
                if let Some(target) = target.as_object_mut() {
                    target.retain(|name, index| name == "POSITION" && exists(index));
                }
            }
            if let Some(attributes) = part.get_mut("attributes").and_then(Value::as_object_mut) {
                attributes.retain(|name, index| name == "POSITION" || is_read(name) && exists(index));
            }
        }
    });
}

/// Gives accessors without elements a view, which the glTF crate asks for, and returns these accessors.
fn add_views(root: &mut Value) -> Vec<usize> {
    if items(root, "bufferViews").next().is_none() {
        return Vec::new();
    }
    let all = root.get_mut("accessors").and_then(Value::as_array_mut);
    let mut unstored = Vec::new();
    for (index, accessor) in all.into_iter().flatten().enumerate() {
        let Some(accessor) = accessor.as_object_mut() else { continue };
        if !accessor.contains_key("bufferView") && !accessor.contains_key("sparse") {
            accessor.insert("bufferView".into(), json!(0));
            unstored.push(index);
        }
    }
    unstored
}

/// Reads the bytes of a glTF buffer: the file's own binary chunk, a base64 data URI, or a file beside it. Done here because the glTF
/// crate's `import` feature pulls in image decoders and panics on a URI that is not UTF-8.
fn read_buffer(path: &Path, buffer: &gltf::Buffer, blob: &mut Option<Vec<u8>>) -> Result<Vec<u8>> {
    let fail = |cause: String| {
        input::error(path, format!("buffer {}: {cause}", buffer.index()), "embed the buffer or put its file beside")
    };
    let mut bytes = match buffer.source() {
        gltf::buffer::Source::Bin => blob.take().ok_or_else(|| fail("there is no binary chunk for it".into()))?,
        gltf::buffer::Source::Uri(uri) => read_uri(path, uri).map_err(fail)?,
    };
    if bytes.len() < buffer.length() {
        return Err(fail(format!("truncated: {} bytes of {}", bytes.len(), buffer.length())));
    }
    bytes.truncate(buffer.length());
    Ok(bytes)
}

/// Reads a base64 data URI, or a file beside the glTF file. The error describes what is wrong.
pub(in crate::scene) fn read_uri(path: &Path, uri: &str) -> std::result::Result<Vec<u8>, String> {
    match uri.strip_prefix("data:") {
        Some(data) => {
            let (_, text) = data.split_once(";base64,").ok_or("data URI without base64")?;
            base64::engine::general_purpose::STANDARD.decode(text).map_err(|cause| cause.to_string())
        }
        None if uri.contains(':') => Err(format!("unsupported URI {uri}")),
        None => {
            let relative = percent_decoded(uri).ok_or_else(|| format!("malformed URI {uri}"))?;
            let beside = path.parent().unwrap_or(Path::new("")).join(relative);
            input::read(&beside).map_err(|cause| cause.to_string())
        }
    }
}

/// Resolves `%20` and similar escapes. `None` if the text is malformed or does not decode to UTF-8.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend_from_slice(part.get(2..)?.as_bytes());
    }
    String::from_utf8(bytes).ok()
}
