//! Triangle meshes from PLY and glTF 2.0 files.

use super::{Mesh, input, ply};
use crate::{Error, Result};
use base64::Engine;
use glam::{DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// The albedo of a mesh whose file names none.
const DEFAULT_ALBEDO: [f32; 3] = [0.7; 3];

/// The most triangles that one file may unfold to. A small glTF file can place a large mesh many times.
const MAX_TRIANGLES: usize = 1 << 26;

/// Loads the triangle meshes of a file by its ending: `.ply` (one mesh; faces of more than three vertices become fans),
/// `.gltf` or `.glb` (a mesh for each primitive that a node of the scene places, in world space). Coordinates stay as
/// they stand in the file; no axis is swapped. Meshes without triangles are left out. Textures, skins and morph targets
/// are ignored.
///
/// # Errors
/// [`Error::Input`]: unreadable, truncated or malformed file; a vertex index out of range; a position that is not
/// finite; a glTF primitive that is no triangle list; a glTF feature that is not supported.
pub(super) fn load(path: &Path) -> Result<Vec<Mesh>> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let mut meshes = match ending.to_str() {
        Some("ply") => vec![load_ply(path)?],
        Some("gltf" | "glb") => load_gltf(path)?,
        _ => return Err(input::error(path, "unknown kind of mesh file", "give a .ply, .gltf or .glb file")),
    };
    meshes.retain(|mesh| !mesh.triangles.is_empty());
    Ok(meshes)
}

/// Checks what both formats must keep: finite positions, indices in range.
fn check(path: &Path, mesh: &Mesh) -> Result<()> {
    let number = mesh.positions.iter().position(|position| !position.iter().all(|value| value.is_finite()));
    if let Some(number) = number {
        let cause = format!("mesh {}: position of vertex {number} (the first is 0) is not finite", mesh.name);
        return Err(input::error(path, cause, "correct the file"));
    }
    let vertices = mesh.positions.len();
    let out_of_range = |triangle: &[u32; 3]| triangle.iter().any(|&index| index as usize >= vertices);
    if let Some(number) = mesh.triangles.iter().position(out_of_range) {
        let cause = format!(
            "mesh {}: triangle {number} (the first is 0) has a vertex index out of range, there are {vertices} vertices",
            mesh.name
        );
        return Err(input::error(path, cause, "correct the file"));
    }
    Ok(())
}

/// A row of a PLY mesh: a vertex or a face.
#[derive(Default)]
struct Row {
    position: [f64; 3],
    /// `None` where the file has an index that is negative or not an integer.
    indices: Option<Vec<u32>>,
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let [x, y, z] = &mut self.position;
        let coordinate = match name {
            "x" => x,
            "y" => y,
            "z" => z,
            "vertex_indices" | "vertex_index" => {
                self.indices = value.to_u32_list();
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        if let Some(value) = ply::scalar(&value) {
            *coordinate = value;
        }
        PropertyAccessResult::Set
    }
}

fn load_ply(path: &Path) -> Result<Mesh> {
    let file = ply::open(path)?;
    file.require_scalars("vertex", &["x", "y", "z"])?;
    let faces = &file.element("face")?.properties;
    if !faces.contains_key("vertex_indices") && !faces.contains_key("vertex_index") {
        return Err(file.error("element face lacks the property vertex_indices", "add the property to the file"));
    }
    let mut mesh =
        Mesh { name: input::stem(path), positions: Vec::new(), triangles: Vec::new(), albedo: DEFAULT_ALBEDO };
    file.read_rows(&["vertex", "face"], |element, number, row: Row| {
        match element {
            "vertex" => mesh.positions.push(row.position.map(|value| value as f32)),
            "face" => match row.indices.as_deref() {
                Some([first, rest @ ..]) if rest.len() >= 2 => {
                    let pairs = rest.iter().zip(rest.iter().skip(1));
                    mesh.triangles.extend(pairs.map(|(&second, &third)| [*first, second, third]));
                }
                _ => {
                    let cause = format!("face {number} (the first is 0) is not a list of three or more vertex indices");
                    return Err(input::error(path, cause, "correct the file"));
                }
            },
            _ => {}
        }
        Ok(())
    })?;
    check(path, &mesh)?;
    Ok(mesh)
}

fn load_gltf(path: &Path) -> Result<Vec<Mesh>> {
    let way_out = "check that the file is a glTF 2.0 file and was copied whole";
    let bytes = input::read(path)?;
    // A length below the header's own 12 bytes makes the glTF crate subtract with overflow.
    let length = bytes.get(8..12).and_then(|length| length.try_into().ok()).map_or(0, u32::from_le_bytes);
    if bytes.starts_with(b"glTF") && length < 12 {
        return Err(input::error(path, "truncated binary glTF header", way_out));
    }
    let unusable = |cause: gltf::Error| input::error(path, cause, way_out);
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice_without_validation(&bytes).map_err(unusable)?;
    // The glTF crate's validation looks up a POSITION accessor before it checks the index.
    let json = document.into_json();
    let accessors = json.accessors.len();
    let mut attributes = json.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|part| part.attributes.values());
    if let Some(missing) = attributes.find(|index| index.value() >= accessors) {
        return Err(input::error(path, format!("there is no accessor {}", missing.value()), way_out));
    }
    let gltf = gltf::Document::from_json(json).map_err(unusable)?;
    let scene = gltf
        .default_scene()
        .or_else(|| gltf.scenes().next())
        .ok_or_else(|| input::error(path, "has no scene", "give a glTF file with a scene"))?;
    let buffers =
        gltf.buffers().map(|buffer| read_buffer(path, &buffer, blob.as_deref())).collect::<Result<Vec<_>>>()?;

    let mut meshes = Vec::new();
    let mut triangles = 0_usize;
    // Walked with a list instead of recursion, each node at most once: a hostile file may nest deep or in a circle.
    let mut visited = vec![false; gltf.nodes().len()];
    let mut open_nodes: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
    open_nodes.reverse();
    while let Some((node, parent_to_world)) = open_nodes.pop() {
        match visited.get_mut(node.index()) {
            Some(seen) if !*seen => *seen = true,
            _ => {
                let cause = format!("node {} has more than one parent", node.index());
                return Err(input::error(path, cause, "correct the file: glTF nodes form trees"));
            }
        }
        let to_parent = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        let to_world = parent_to_world * to_parent;
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives().map(move |part| (mesh, part))) {
            let mesh = read_primitive(path, &buffers, primitive, to_world)?;
            triangles = triangles.saturating_add(mesh.triangles.len());
            if triangles > MAX_TRIANGLES {
                return Err(input::error(path, format!("more than {MAX_TRIANGLES} triangles"), "give a smaller file"));
            }
            meshes.push(mesh);
        }
        let children_from = open_nodes.len();
        open_nodes.extend(node.children().map(|child| (child, to_world)));
        if let Some(children) = open_nodes.get_mut(children_from..) {
            children.reverse();
        }
    }
    Ok(meshes)
}

/// The bytes of a glTF buffer: the file's own binary chunk, a base64 data URI, or a file beside it. Done here because
/// the glTF crate's `import` feature brings image decoders along and panics on a URI that is not UTF-8.
fn read_buffer(path: &Path, buffer: &gltf::Buffer, blob: Option<&[u8]>) -> Result<Vec<u8>> {
    let fail = |cause: String| {
        input::error(path, format!("buffer {}: {cause}", buffer.index()), "embed the buffer or put its file beside")
    };
    let mut bytes = match buffer.source() {
        gltf::buffer::Source::Bin => blob.ok_or_else(|| fail("there is no binary chunk".into()))?.to_vec(),
        gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
            Some(data) => {
                let (_, text) = data.split_once(";base64,").ok_or_else(|| fail("data URI without base64".into()))?;
                base64::engine::general_purpose::STANDARD.decode(text).map_err(|cause| fail(cause.to_string()))?
            }
            None if uri.contains(':') => return Err(fail(format!("unsupported URI {uri}"))),
            None => {
                let relative = percent_decoded(uri).ok_or_else(|| fail(format!("malformed URI {uri}")))?;
                let beside = path.parent().unwrap_or(Path::new("")).join(relative);
                input::read(&beside).map_err(|cause| fail(cause.to_string()))?
            }
        },
    };
    if bytes.len() < buffer.length() {
        return Err(fail(format!("truncated: {} bytes of {}", bytes.len(), buffer.length())));
    }
    bytes.truncate(buffer.length());
    Ok(bytes)
}

/// Resolves `%20` and the like. `None` if the text or what it stands for is malformed.
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

/// One primitive in world space.
fn read_primitive(
    path: &Path,
    buffers: &[Vec<u8>],
    (mesh, primitive): (&gltf::Mesh, gltf::Primitive),
    to_world: DMat4,
) -> Result<Mesh> {
    let unnamed = || format!("{}#{}", input::stem(path), mesh.index());
    let name = mesh.name().map_or_else(unnamed, input::one_line);
    let fail = |cause: String, way_out: &str| -> Error {
        input::error(path, format!("mesh {name} primitive {}: {cause}", primitive.index()), way_out)
    };
    let way_out = "export the mesh again as plain triangles";
    if primitive.mode() != gltf::mesh::Mode::Triangles {
        return Err(fail(format!("is {:?}, not Triangles", primitive.mode()), way_out));
    }
    let accessor = primitive.get(&gltf::Semantic::Positions).ok_or_else(|| fail("has no POSITION".into(), way_out))?;
    let elements = accessor_elements(buffers, &accessor, &[(DataType::F32, Dimensions::Vec3)])
        .map_err(|cause| fail(format!("POSITION {cause}"), way_out))?;
    let coordinate = |bytes: &[u8], at: usize| {
        let bytes = bytes.get(at..at + 4).and_then(|bytes| bytes.try_into().ok());
        bytes.map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(bytes)))
    };
    let in_world = |bytes: &[u8]| {
        let position = DVec3::new(coordinate(bytes, 0), coordinate(bytes, 4), coordinate(bytes, 8));
        to_world.transform_point3(position).as_vec3().to_array()
    };
    let positions: Vec<[f32; 3]> = elements.map(in_world).collect();

    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => {
            let types = [DataType::U8, DataType::U16, DataType::U32].map(|data_type| (data_type, Dimensions::Scalar));
            let elements = accessor_elements(buffers, &accessor, &types)
                .map_err(|cause| fail(format!("its index accessor {cause}"), way_out))?;
            elements.map(|bytes| bytes.iter().rev().fold(0, |index, &byte| index << 8 | u32::from(byte))).collect()
        }
        None => {
            let count = u32::try_from(positions.len()).map_err(|_| fail("too many vertices".into(), way_out))?;
            (0..count).collect()
        }
    };
    let (triangles, []) = indices.as_chunks::<3>() else {
        return Err(fail(format!("{} indices are not whole triangles", indices.len()), way_out));
    };
    let mut triangles = triangles.to_vec();
    // A mirroring transform turns triangles inside out (glTF 2.0, 3.5.3).
    if to_world.determinant() < 0.0 {
        triangles.iter_mut().for_each(|[_, second, third]| std::mem::swap(second, third));
    }
    let albedo = match primitive.material() {
        material if material.index().is_none() => DEFAULT_ALBEDO,
        material => {
            let [red, green, blue, _] = material.pbr_metallic_roughness().base_color_factor();
            [red, green, blue]
        }
    };
    if !albedo.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Err(fail(format!("baseColorFactor {albedo:?} is not in [0, 1]"), "correct the material"));
    }
    let mesh = Mesh { name: name.clone(), positions, triangles, albedo };
    check(path, &mesh)?;
    Ok(mesh)
}

/// The bytes of each element of an accessor, every range checked. Done here because the glTF crate's own reader counts
/// on accessors that lie inside their buffers.
fn accessor_elements<'a>(
    buffers: &'a [Vec<u8>],
    accessor: &gltf::Accessor,
    types: &[(DataType, Dimensions)],
) -> std::result::Result<impl Iterator<Item = &'a [u8]>, String> {
    let found = (accessor.data_type(), accessor.dimensions());
    if !types.contains(&found) {
        return Err(format!("is {:?} {:?}, not one of {types:?}", found.1, found.0));
    }
    if accessor.sparse().is_some() {
        return Err("is sparse, which is not supported".into());
    }
    let view = accessor.view().ok_or("has no buffer view")?;
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(format!("has a stride of {stride} bytes for elements of {size}"));
    }
    let within = || {
        let view_bytes = buffers.get(view.buffer().index())?.get(view.offset()..)?.get(..view.length())?;
        let bytes = view_bytes.get(accessor.offset()..)?;
        let last_end = accessor.count().checked_sub(1)?.checked_mul(stride)?.checked_add(size)?;
        bytes.get(..last_end)
    };
    let bytes = match within() {
        Some(bytes) => bytes,
        None if accessor.count() == 0 => &[],
        None => return Err("reaches beyond its buffer".into()),
    };
    Ok(bytes.chunks(stride).filter_map(move |chunk| chunk.get(..size)))
}
