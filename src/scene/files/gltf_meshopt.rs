//! Buffer views that meshoptimizer has compressed (EXT_meshopt_compression, KHR_meshopt_compression), turned into plain
//! ones.

use super::meshopt::{self, Filter, Mode};
use serde_json::{Value, json};

type Checked<T> = std::result::Result<T, String>;

const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The largest number of bytes that a file's compressed views may have together.
const MOST_BYTES: usize = 1 << 30;

/// Returns whether each buffer only keeps a place for what is decoded, so that its own bytes, if it has any, are not
/// needed.
pub(super) fn placeholders(root: &Value) -> Vec<bool> {
    let mut plain = Vec::new();
    let mut compressed = Vec::new();
    for view in items(root, "bufferViews") {
        match extension(view) {
            Some((_, extension)) => {
                plain.extend(index(&extension["buffer"]));
                compressed.extend(index(&view["buffer"]));
            }
            None => plain.extend(index(&view["buffer"])),
        }
    }
    let is_fallback = |buffer| extension(buffer).is_some_and(|(_, extension)| extension["fallback"] == true);
    let of_buffer =
        |(number, buffer)| (is_fallback(buffer) || compressed.contains(&number)) && !plain.contains(&number);
    items(root, "buffers").enumerate().map(of_buffer).collect()
}

/// Decodes all compressed views into one more buffer, and leaves a document without these extensions. `buffers` has the
/// bytes of each buffer in the document's order; those of [`placeholders`] may be empty.
///
/// # Errors
/// If a view's data are missing, damaged or too large; the message gives the view.
pub(super) fn decompress(root: &mut Value, buffers: &mut Vec<Vec<u8>>) -> Checked<()> {
    let placeholders = placeholders(root);
    let all = root.get_mut("buffers").and_then(Value::as_array_mut);
    for (buffer, _) in all.into_iter().flatten().zip(placeholders).filter(|(_, is_placeholder)| *is_placeholder) {
        *buffer = json!({"byteLength": 0});
    }
    let new = buffers.len();
    let mut decoded = None;
    for (number, view) in root.get_mut("bufferViews").and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
        let Some((name, extension)) = extension(view) else { continue };
        let decoded = decoded.get_or_insert_with(Vec::new);
        let most = MOST_BYTES.saturating_sub(decoded.len());
        let bytes = of_view(view, extension, buffers, most).map_err(|cause| format!("buffer view {number} {cause}"))?;
        // Accessors ask for multiples of 4.
        decoded.resize(decoded.len().next_multiple_of(4), 0);
        view["buffer"] = json!(new);
        view["byteOffset"] = json!(decoded.len());
        decoded.extend(bytes);
        remove(view, name);
    }
    if let Some(decoded) = decoded {
        if let Some(all) = root.get_mut("buffers").and_then(Value::as_array_mut) {
            all.push(json!({"byteLength": decoded.len()}));
        }
        buffers.push(decoded);
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(list) = root.get_mut(list).and_then(Value::as_array_mut) {
            list.retain(|name| !NAMES.iter().any(|known| name == known));
        }
    }
    Ok(())
}

fn items<'a>(of: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    of[key].as_array().into_iter().flatten()
}

fn index(of: &Value) -> Option<usize> {
    usize::try_from(of.as_u64()?).ok()
}

/// Returns the extension of a view or a buffer, and its name.
fn extension(of: &Value) -> Option<(&'static str, &Value)> {
    NAMES.iter().find_map(|name| of["extensions"].get(name).map(|extension| (*name, extension)))
}

fn remove(view: &mut Value, name: &str) {
    if let Some(extensions) = view.get_mut("extensions").and_then(Value::as_object_mut) {
        extensions.remove(name);
    }
}

/// Decodes a view, to at most `most` bytes.
fn of_view(view: &Value, extension: &Value, buffers: &[Vec<u8>], most: usize) -> Checked<Vec<u8>> {
    let number = |key: &str| index(&extension[key]).ok_or_else(|| format!("has no {key} of its compressed data"));
    let (stride, count) = (number("byteStride")?, number("count")?);
    let bytes = stride.checked_mul(count);
    if bytes.is_none() || bytes != index(&view["byteLength"]) {
        return Err(format!("has {} bytes, not {count} elements of {stride}", view["byteLength"]));
    }
    if bytes.is_none_or(|bytes| bytes > most) {
        return Err(format!("and those before have more than {MOST_BYTES} bytes"));
    }
    let mode = match extension["mode"].as_str() {
        Some("ATTRIBUTES") => Mode::Attributes,
        Some("TRIANGLES") => Mode::Triangles,
        Some("INDICES") => Mode::Indices,
        _ => return Err(format!("has an unknown mode {}", extension["mode"])),
    };
    let filter = match extension.get("filter").map_or(Some("NONE"), Value::as_str) {
        Some("NONE") => Filter::None,
        Some("OCTAHEDRAL") => Filter::Octahedral,
        Some("QUATERNION") => Filter::Quaternion,
        Some("EXPONENTIAL") => Filter::Exponential,
        Some("COLOR") => Filter::Color,
        _ => return Err(format!("has an unknown filter {}", extension["filter"])),
    };
    let buffer = number("buffer")?;
    let (from, length) = (index(&extension["byteOffset"]).unwrap_or(0), number("byteLength")?);
    let there = buffers.get(buffer).ok_or_else(|| format!("is compressed in buffer {buffer}, which is not there"))?;
    let stream = from.checked_add(length).and_then(|to| there.get(from..to));
    let stream = stream.ok_or_else(|| {
        format!("is compressed in {length} bytes from {from} on; buffer {buffer} has {}", there.len())
    })?;
    meshopt::decode(stream, mode, filter, count, stride).map_err(|cause| format!("is damaged: {cause}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each mode, filter and version, against what meshoptimizer itself makes of the bytes, or the formula that they were
    /// made by.
    #[test]
    fn codecs_decode_as_meshoptimizer_does() {
        let bytes = include_bytes!("../../../tests/host/scene/gltf_compressed/codec.glb");
        let file = gltf::Glb::from_slice(bytes).unwrap();
        let root: Value = serde_json::from_slice(&file.json).unwrap();
        let (mut plain, mut decoded) = (root.clone(), vec![file.bin.unwrap().into_owned(), Vec::new()]);
        decompress(&mut plain, &mut decoded).unwrap();
        let views = root["bufferViews"].as_array().unwrap();
        let bytes = |number: usize| {
            let view = &plain["bufferViews"][number];
            let [buffer, from, length] =
                ["buffer", "byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
            &decoded[buffer][from..from + length]
        };
        let mut modes = Vec::new();
        for (number, view) in views.iter().enumerate() {
            let extension = &view["extensions"]["KHR_meshopt_compression"];
            let Some(count) = extension["count"].as_u64() else { continue };
            let stride = extension["byteStride"].as_u64().unwrap();
            let name = format!("view {number}: {extension}");
            let expected: Vec<u8> = match (extension["mode"].as_str().unwrap(), extension["filter"].as_str()) {
                ("ATTRIBUTES", None) => {
                    let byte = |at: u64| {
                        let (i, k) = (at / stride, at % stride);
                        ((i * i * (k % 5) + 7 * k) >> (k % 4)) as u8
                    };
                    (0..count * stride).map(byte).collect()
                }
                ("ATTRIBUTES", Some(filter)) => {
                    let expected = bytes(number + 1);
                    // All but the exponential filter may round otherwise by one unit.
                    let unit = |of: &[u8]| match (filter, stride) {
                        ("EXPONENTIAL", _) => Vec::new(),
                        (_, 4) => of.iter().map(|x| i32::from(*x)).collect(),
                        _ => of.chunks(2).map(|x| i32::from(u16::from_le_bytes([x[0], x[1]]))).collect::<Vec<_>>(),
                    };
                    let all = unit(bytes(number)).into_iter().zip(unit(expected));
                    for (a, b) in all {
                        // Signed numbers around 0 differ by 1 too.
                        let apart = (a - b).rem_euclid(if stride == 4 { 256 } else { 65536 });
                        assert!([0, 1, if stride == 4 { 255 } else { 65535 }].contains(&apart), "{name}: {a} {b}");
                    }
                    if filter != "EXPONENTIAL" {
                        modes.push(filter.to_string());
                        continue;
                    }
                    expected.to_vec()
                }
                _ => {
                    let quad = |row: u32, column: u32| {
                        let a = row * 9 + column;
                        [a, a + 1, a + 9, a + 1, a + 10, a + 9]
                    };
                    let indices = (0..8).flat_map(|row| (0..8).flat_map(move |column| quad(row, column)));
                    let mut indices: Vec<u32> = indices.collect();
                    if extension["mode"] == "TRIANGLES" {
                        // The codec turns triangles to begin with another corner.
                        let chunk = |i: usize| bytes(number)[i * stride as usize..][..stride as usize].to_vec();
                        for (i, triangle) in indices.chunks_mut(3).enumerate() {
                            let first = u32::from(u16::from_le_bytes(chunk(3 * i)[..2].try_into().unwrap()));
                            while triangle[0] != first {
                                triangle.rotate_left(1);
                            }
                        }
                    }
                    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride as usize)).collect()
                }
            };
            assert_eq!(bytes(number), expected, "{name}");
            modes.push(extension["mode"].as_str().unwrap().to_string());
        }
        assert_eq!(modes.len(), 8 + 4 + 6, "{modes:?}");
    }

    /// What promises more bytes than a file may have, or lies outside its buffer, is refused before it is decoded.
    #[test]
    fn impossible_views_are_refused() {
        let cause = |change: &dyn Fn(&mut Value)| {
            let mut root = json!({"buffers": [{"byteLength": 40}, {"byteLength": 12}], "bufferViews": [
            {"buffer": 1, "byteLength": 12, "extensions": {"EXT_meshopt_compression":
                {"buffer": 0, "byteLength": 40, "byteStride": 4, "count": 3, "mode": "ATTRIBUTES"}}}]});
            change(&mut root["bufferViews"][0]);
            decompress(&mut root, &mut vec![vec![0; 40], Vec::new()]).unwrap_err()
        };
        let name = "EXT_meshopt_compression";
        assert_eq!(cause(&|_| {}), "buffer view 0 is damaged: its vertices are of an unknown version");
        let huge = |view: &mut Value| {
            view["byteLength"] = (1_u64 << 32).into();
            view["extensions"][name]["count"] = (1_u64 << 30).into();
        };
        assert_eq!(cause(&huge), "buffer view 0 and those before have more than 1073741824 bytes");
        let other = |view: &mut Value| view["byteLength"] = 13.into();
        assert_eq!(cause(&other), "buffer view 0 has 13 bytes, not 3 elements of 4");
        let outside = |view: &mut Value| view["extensions"][name]["byteOffset"] = 1.into();
        assert_eq!(cause(&outside), "buffer view 0 is compressed in 40 bytes from 1 on; buffer 0 has 40");
        let nowhere = |view: &mut Value| view["extensions"][name]["buffer"] = 2.into();
        assert_eq!(cause(&nowhere), "buffer view 0 is compressed in buffer 2, which is not there");
        let unknown = |view: &mut Value| view["extensions"][name]["filter"] = "SHARP".into();
        assert_eq!(cause(&unknown), "buffer view 0 has an unknown filter \"SHARP\"");
        let indices = |view: &mut Value| view["extensions"][name]["mode"] = "TRIANGLES".into();
        assert_eq!(cause(&indices), "buffer view 0 is damaged: its triangles are of an unknown version");
    }
}
