//! glTF documents, reduced to the parts that are used: nodes and triangles, base colors and alpha, lights and cameras.

use crate::Result;
use crate::scene::files::gltf_splats::{self, Splats};
use crate::scene::files::{gltf_draco, gltf_meshopt, input};
use base64::Engine;
use glam::DVec3;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::path::Path;

const WAY_OUT: &str = "check that the file is a glTF 2.0 file and was copied whole";

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
    /// Buffers in the document's order, each at least as long as the document declares; compressed data are decoded.
    pub buffers: Vec<Vec<u8>>,
    /// The accessors whose elements are not stored, but 0.
    pub unstored: Vec<usize>,
    /// Whether each node is hidden by KHR_node_visibility, with all below it.
    pub hidden: Vec<bool>,
    /// The attributes by which each node places copies of its mesh (EXT_mesh_gpu_instancing); null without.
    pub instances: Vec<Value>,
    /// The translation of each node in f64: places on a globe are too coarse in f32.
    pub translations: Vec<Option<DVec3>>,
    /// Splats of its meshes (KHR_gaussian_splatting), which the document no longer has.
    pub splats: Vec<Splats>,
    /// The file's `animations`. Nothing in them is validated.
    pub animations: Value,
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
    let damaged = |cause: String| input::error(path, cause, WAY_OUT);
    // Only one buffer may use the binary chunk (glTF 2.0, 4.4.3.3). Copying it for several buffers without a URI would multiply memory use.
    let mut blob = glb.and_then(|glb| glb.bin).map(Cow::into_owned);
    let placeholders = gltf_meshopt::placeholders(&json);
    let described = items(&json, "buffers").zip(placeholders).enumerate();
    let buffers = described.map(|(number, (buffer, is_placeholder))| match is_placeholder {
        true => Ok(Vec::new()),
        false => read_buffer(path, number, buffer, &mut blob),
    });
    let mut buffers = buffers.collect::<Result<Vec<_>>>()?;
    let splats = gltf_splats::take(&mut json).map_err(damaged)?;
    gltf_meshopt::decompress(&mut json, &mut buffers).map_err(damaged)?;
    gltf_draco::decompress(&mut json, &mut buffers, is_read).map_err(damaged)?;
    if let Some(cause) = hidden_geometry(&json) {
        return Err(input::error(path, cause, "export it without that extension"));
    }
    let of_nodes = |of: fn(&Value) -> Value| items(&json, "nodes").map(of).collect::<Vec<_>>();
    let hidden = of_nodes(|node| node["extensions"][VISIBILITY]["visible"].clone());
    let hidden = hidden.iter().map(|visible| visible == false).collect();
    let instances = of_nodes(|node| match &node["extensions"][INSTANCING] {
        Value::Null => Value::Null,
        extension => extension.get("attributes").cloned().unwrap_or(json!({})),
    });
    let translations = items(&json, "nodes").map(translation).collect();
    let animations = json["animations"].clone();
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
    Ok(GltfDocument { document, buffers, unstored, hidden, instances, translations, splats, animations, appearance })
}

fn items<'a>(of: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    of[key].as_array().into_iter().flatten()
}

/// Returns a node's translation, its own or that of its matrix; `None` if it has none.
fn translation(node: &Value) -> Option<DVec3> {
    let (from, first) = if node["matrix"].is_null() { (&node["translation"], 0) } else { (&node["matrix"], 12) };
    let number = |axis: usize| from[first + axis].as_f64();
    Some(DVec3::new(number(0)?, number(1)?, number(2)?))
}

/// Returns a description of the required extension that makes content unreadable, if any.
fn hidden_geometry(root: &Value) -> Option<String> {
    let is_harmless =
        |name: &&str| HARMLESS.contains(name) || HARMLESS_FAMILIES.iter().any(|family| name.starts_with(family));
    let name = items(root, "extensionsRequired").filter_map(Value::as_str).find(|name| !is_harmless(name))?;
    Some(format!("requires {name}, which is not known here and may change its geometry"))
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
fn read_buffer(path: &Path, number: usize, buffer: &Value, blob: &mut Option<Vec<u8>>) -> Result<Vec<u8>> {
    let fail = |cause: String| {
        input::error(path, format!("buffer {number}: {cause}"), "embed the buffer or put its file beside")
    };
    let length = buffer["byteLength"].as_u64().and_then(|length| usize::try_from(length).ok());
    let length = length.ok_or_else(|| fail("it has no byteLength".into()))?;
    let mut bytes = match buffer["uri"].as_str() {
        None => blob.take().ok_or_else(|| fail("there is no binary chunk for it".into()))?,
        Some(uri) => read_uri(path, uri).map_err(fail)?,
    };
    if bytes.len() < length {
        return Err(fail(format!("truncated: {} bytes of {length}", bytes.len())));
    }
    bytes.truncate(length);
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
