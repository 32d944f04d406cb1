//! Meshes, lights and cameras of glTF 2.0 files.

use crate::scene::files::contents::Contents;
use crate::scene::files::gltf_accessor::{self, NUMBERS};
use crate::scene::files::gltf_alpha::{AlphaReader, Surface};
use crate::scene::files::gltf_document;
use crate::scene::{Mesh, files::gltf_stage, files::input, files::mesh_file};
use crate::{Error, Result};
use glam::{DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use std::path::Path;

/// The largest number of triangles, and of vertices, that one file may expand to. A small glTF file can place a large mesh many times, and
/// use the same vertices in many primitives.
const MOST: usize = 1 << 26;

/// Loads the scene of a `.gltf` or `.glb` file in world space: a mesh for each primitive placed by a node, the lights
/// (KHR_lights_punctual), and the first perspective camera. Skins and morph targets are ignored, and so are textures but for their alpha.
///
/// # Errors
/// [`Error::Input`] as for [`gltf_document::open`], and if a primitive is not a triangle list, a position is not finite, a vertex index is
/// out of range, a light or a camera fails the checks of [`crate::scene::files::stage`], or an accessor is sparse; if the alpha of a
/// material or a vertex is not in [0, 1], or a texture that alpha needs cannot be read.
pub(in crate::scene) fn load(path: &Path) -> Result<Contents> {
    let file = gltf_document::open(path)?;
    let document = &file.document;
    let mut alphas = AlphaReader::new(path, &file);
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next())
        .ok_or_else(|| input::error(path, "has no scene", "give a glTF file with a scene"))?;
    let mut contents = Contents::default();
    let [mut triangles, mut vertices] = [0_usize; 2];
    // Nodes are traversed with a list instead of recursion, each at most once: a malicious file may nest them deeply or in a cycle.
    let mut visited = vec![false; document.nodes().len()];
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
            let Some(mesh) = read_primitive(path, &file.buffers, &mut alphas, primitive, to_world)? else { continue };
            triangles = triangles.saturating_add(mesh.triangles.len());
            vertices = vertices.saturating_add(mesh.positions.len());
            for (count, what) in [(triangles, "triangles"), (vertices, "vertices")] {
                if count > MOST {
                    return Err(input::error(path, format!("more than {MOST} {what}"), "give a smaller file"));
                }
            }
            contents.meshes.push(mesh);
        }
        let wrong = |cause| input::error(path, format!("node {}: {cause}", node.index()), "correct the file");
        if let Some(light) = node.light() {
            contents.lights.push(gltf_stage::light(&light, to_world).map_err(wrong)?);
        }
        if contents.camera.is_none() {
            contents.camera = gltf_stage::camera(document, &node, to_world).map_err(wrong)?;
        }
        let children_from = open_nodes.len();
        open_nodes.extend(node.children().map(|child| (child, to_world)));
        if let Some(children) = open_nodes.get_mut(children_from..) {
            children.reverse();
        }
    }
    gltf_stage::balance(&mut contents);
    contents.notes = alphas.notes(path);
    Ok(contents)
}

/// Reads one primitive, in world space; `None` if it is invisible.
fn read_primitive(
    path: &Path,
    buffers: &[Vec<u8>],
    alphas: &mut AlphaReader,
    (mesh, primitive): (&gltf::Mesh, gltf::Primitive),
    to_world: DMat4,
) -> Result<Option<Mesh>> {
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
    let elements = gltf_accessor::elements(buffers, &accessor, Dimensions::Vec3, &NUMBERS)
        .map_err(|cause| fail(format!("POSITION {cause}"), way_out))?;
    let in_world = |bytes: &[u8]| {
        let position = DVec3::from_array(gltf_accessor::numbers(&accessor, bytes));
        to_world.transform_point3(position).as_vec3().to_array()
    };
    let positions: Vec<[f32; 3]> = elements.map(in_world).collect();

    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => {
            let types = [DataType::U8, DataType::U16, DataType::U32];
            let elements = gltf_accessor::elements(buffers, &accessor, Dimensions::Scalar, &types)
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
    // A mirroring transform flips the winding of triangles (glTF 2.0, 3.5.3).
    if to_world.determinant() < 0.0 {
        triangles.iter_mut().for_each(|[_, second, third]| std::mem::swap(second, third));
    }
    let albedo = match primitive.material() {
        material if material.index().is_none() => mesh_file::DEFAULT_ALBEDO,
        material => {
            let [red, green, blue, _] = material.pbr_metallic_roughness().base_color_factor();
            [red, green, blue]
        }
    };
    if !albedo.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Err(fail(format!("baseColorFactor {albedo:?} is not in [0, 1]"), "correct the material"));
    }
    let alpha = match alphas.read(&primitive, positions.len()).map_err(|wrong| fail(wrong.cause, wrong.way_out))? {
        Surface::Invisible => return Ok(None),
        Surface::Opaque => None,
        Surface::Alpha(alpha) => Some(alpha),
    };
    let mesh = Mesh { name: name.clone(), positions, triangles, albedo, solid: false, alpha };
    mesh_file::check(path, &mesh)?;
    Ok(Some(mesh))
}
