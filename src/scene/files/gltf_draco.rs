//! Primitives that Draco has compressed (KHR_draco_mesh_compression), turned into plain ones.

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};
use serde_json::{Map, Value, json};
use std::collections::HashMap;

type Checked<T> = std::result::Result<T, String>;

const NAME: &str = "KHR_draco_mesh_compression";

/// The largest number of bytes that a file's compressed primitives may have together.
const MOST_BYTES: usize = 1 << 30;

const FLOAT: u64 = 5126;

const UNSIGNED_INT: u64 = 5125;

/// Decodes all compressed primitives into one more buffer, with views and accessors of their own, and leaves a document
/// without this extension. `buffers` has the bytes of each buffer in the document's order. `is_read`: whether an
/// attribute is of use; others are left as they are.
///
/// # Errors
/// If the data of a primitive are missing, damaged or too large, or lack one of its attributes; the message gives the
/// primitive.
pub(super) fn decompress(root: &mut Value, buffers: &mut Vec<Vec<u8>>, is_read: impl Fn(&str) -> bool) -> Checked<()> {
    let mut meshes = root.get_mut("meshes").map(Value::take).unwrap_or_default();
    let mut plain = Plain { buffer: buffers.len(), bytes: Vec::new(), views: Vec::new(), accessors: Vec::new() };
    // Primitives may share their data.
    let mut before: HashMap<String, Value> = HashMap::new();
    for (mesh, of_mesh) in meshes.as_array_mut().into_iter().flatten().enumerate() {
        let parts = of_mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten();
        for (number, part) in parts.enumerate() {
            let Some(extension) = part.get_mut("extensions").and_then(Value::as_object_mut) else { continue };
            let Some(extension) = extension.remove(NAME) else { continue };
            if is_whole(root, part, &is_read) {
                continue;
            }
            let key = json!([extension, part["attributes"], part["indices"]]).to_string();
            let decoded = match before.get(&key) {
                Some(decoded) => decoded.clone(),
                None => {
                    let decoded = of_part(root, buffers, part, &extension, &is_read, &mut plain)
                        .map_err(|cause| format!("mesh {mesh}: primitive {number} {cause}"))?;
                    before.entry(key).or_insert(decoded).clone()
                }
            };
            if let (Some(part), Value::Object(decoded)) = (part.as_object_mut(), decoded) {
                part.extend(decoded);
            }
        }
    }
    if let Some(root) = root.as_object_mut() {
        if !meshes.is_null() {
            root.insert("meshes".into(), meshes);
        }
        for list in ["extensionsUsed", "extensionsRequired"] {
            if let Some(list) = root.get_mut(list).and_then(Value::as_array_mut) {
                list.retain(|name| name != NAME);
            }
        }
        if !plain.bytes.is_empty() {
            let buffer = vec![json!({"byteLength": plain.bytes.len()})];
            let parts = [("buffers", buffer), ("bufferViews", plain.views), ("accessors", plain.accessors)];
            for (key, new) in parts {
                if let Some(all) = root.entry(key).or_insert_with(|| json!([])).as_array_mut() {
                    all.extend(new);
                }
            }
            buffers.push(plain.bytes);
        }
    }
    Ok(())
}

/// What is decoded: the new buffer with its views and accessors.
struct Plain {
    buffer: usize,
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Plain {
    /// Adds an accessor of the type of `like` and returns its index. It has no bounds. `old`: the number of the file's
    /// own (views, accessors).
    fn add(&mut self, like: &Value, count: usize, bytes: &[u8], old: (usize, usize)) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({"buffer": self.buffer, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        let mut accessor = like.clone();
        if let Some(accessor) = accessor.as_object_mut() {
            accessor.retain(|key, _| ["componentType", "normalized", "type"].contains(&key.as_str()));
        }
        accessor["bufferView"] = json!(old.0 + self.views.len() - 1);
        accessor["byteOffset"] = json!(0);
        accessor["count"] = json!(count);
        self.accessors.push(accessor);
        old.1 + self.accessors.len() - 1
    }
}

fn index(of: &Value) -> Option<usize> {
    usize::try_from(of.as_u64()?).ok()
}

/// Returns whether a primitive has its data uncompressed too.
fn is_whole(root: &Value, part: &Value, is_read: &impl Fn(&str) -> bool) -> bool {
    let attributes = part["attributes"].as_object().into_iter().flatten().filter(|(name, _)| is_read(name));
    let mut all = attributes.map(|(_, accessor)| accessor).chain(part.get("indices"));
    let is_stored =
        |accessor: &Value| index(accessor).is_some_and(|at| root["accessors"][at].get("bufferView").is_some());
    all.all(is_stored)
}

/// Decodes a primitive, and returns what replaces its `attributes`, `indices` and `mode`.
fn of_part(
    root: &Value,
    buffers: &[Vec<u8>],
    part: &Value,
    extension: &Value,
    is_read: &impl Fn(&str) -> bool,
    plain: &mut Plain,
) -> Checked<Value> {
    let stream = stream(root, buffers, extension)?;
    let most = MOST_BYTES.saturating_sub(plain.bytes.len());
    let limits = DecodeLimits::default().with_max_decoded_bytes(most as u64).with_max_faces(most as u64 / 12);
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh)
        .map_err(|cause| format!("has damaged Draco data: {cause}"))?;
    let length = |key: &str| root[key].as_array().map_or(0, Vec::len);
    let old = (length("bufferViews"), length("accessors"));
    let mut attributes = part["attributes"].as_object().cloned().unwrap_or_default();
    let none = Map::new();
    for (name, id) in extension["attributes"].as_object().unwrap_or(&none).iter().filter(|(name, _)| is_read(name)) {
        let accessor = index(&part["attributes"][name]).and_then(|index| root["accessors"].get(index));
        let accessor = accessor.ok_or_else(|| format!("has no accessor of {name}"))?;
        let id = id.as_u64().and_then(|id| u32::try_from(id).ok());
        let attribute = id.and_then(|id| mesh.attribute_by_unique_id(id));
        let attribute = attribute.ok_or_else(|| format!("has no {name} in its Draco data"))?;
        let most = MOST_BYTES.saturating_sub(plain.bytes.len());
        let bytes = values(attribute, accessor, mesh.num_points(), most).map_err(|cause| format!("{name} {cause}"))?;
        attributes.insert(name.clone(), json!(plain.add(accessor, mesh.num_points(), &bytes, old)));
    }
    // Draco gives triangles, whatever the primitive's mode is.
    let corners = mesh.faces().as_flattened();
    if corners.len().checked_mul(4).is_none_or(|bytes| bytes > MOST_BYTES.saturating_sub(plain.bytes.len())) {
        return Err(format!("and those before have more than {MOST_BYTES} bytes"));
    }
    let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.0.to_le_bytes()).collect();
    let like = json!({"componentType": UNSIGNED_INT, "type": "SCALAR"});
    let indices = plain.add(&like, corners.len(), &bytes, old);
    Ok(json!({"attributes": attributes, "indices": indices, "mode": 4}))
}

/// Returns the compressed bytes of a primitive.
fn stream<'a>(root: &Value, buffers: &'a [Vec<u8>], extension: &Value) -> Checked<&'a [u8]> {
    let view = index(&extension["bufferView"]).and_then(|index| root["bufferViews"].get(index));
    let view = view.ok_or("has no buffer view with its Draco data")?;
    let buffer =
        index(&view["buffer"]).and_then(|index| buffers.get(index)).ok_or("has no buffer with its Draco data")?;
    let from = index(&view["byteOffset"]).unwrap_or(0);
    let to = index(&view["byteLength"]).and_then(|length| from.checked_add(length));
    let bytes = to.and_then(|to| buffer.get(from..to));
    bytes.ok_or_else(|| format!("has Draco data beyond the {} bytes of its buffer", buffer.len()))
}

/// Returns the values of each vertex as bytes that the accessor describes.
fn values(attribute: &PointAttribute, accessor: &Value, count: usize, most: usize) -> Checked<Vec<u8>> {
    let size = match accessor["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        Some("VEC4") => 4,
        _ => return Err(format!("is of type {}, which no vertex has", accessor["type"])),
    };
    if usize::from(attribute.num_components()) != size {
        return Err(format!("has {} numbers per vertex in its Draco data, not {size}", attribute.num_components()));
    }
    let kind = accessor["componentType"].as_u64().unwrap_or(0);
    if attribute.data_type().is_integral() == (kind == FLOAT) {
        return Err(format!("is of type {:?} in its Draco data, not {kind}", attribute.data_type()));
    }
    if count.checked_mul(4 * size).is_none_or(|bytes| bytes > most) {
        return Err(format!("and what is before have more than {MOST_BYTES} bytes"));
    }
    // Floats hold all 16-bit integers, and joints beyond those are none.
    let numbers = attribute.read_f32s(count, size);
    let numbers = numbers.iter();
    Ok(match kind {
        FLOAT => numbers.flat_map(|number| number.to_le_bytes()).collect(),
        5120 => numbers.flat_map(|number| (*number as i8).to_le_bytes()).collect(),
        5121 => numbers.map(|number| *number as u8).collect(),
        5122 => numbers.flat_map(|number| (*number as i16).to_le_bytes()).collect(),
        5123 => numbers.flat_map(|number| (*number as u16).to_le_bytes()).collect(),
        UNSIGNED_INT => numbers.flat_map(|number| (*number as u32).to_le_bytes()).collect(),
        _ => return Err(format!("has the unknown component type {kind}")),
    })
}
