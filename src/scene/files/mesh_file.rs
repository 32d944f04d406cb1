//! Loads triangle meshes of any supported format; PLY meshes are read here.

use crate::Result;
use crate::scene::files::contents::Contents;
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{MAX_COORDINATE, in_range};
use crate::scene::{Mesh, files::gltf_file, files::input, files::ply};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// The albedo of a mesh whose file specifies none.
pub(in crate::scene) const DEFAULT_ALBEDO: [f32; 3] = [0.7; 3];

/// Loads and places the triangle meshes of a file, depending on its extension: `.ply` (one mesh; faces of more than three vertices become fans),
/// `.gltf` or `.glb` (as [`gltf_file::load`], with lights, camera and `animation`). No axes are swapped. Meshes without triangles are dropped.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated or malformed, a vertex index is out of range, or a position
/// is not finite; for glTF, the same as [`gltf_file::load`].
pub(in crate::scene) fn load(path: &Path, placement: &Placement, animation: Option<&str>) -> Result<Contents> {
    let mut contents = match input::ending(path).as_str() {
        "ply" if animation.is_some() => {
            return Err(input::error(path, "it has no animation", "leave `animation` out"));
        }
        "ply" => Contents { meshes: vec![load_ply(path, placement)?], ..Contents::default() },
        "gltf" | "glb" => gltf_file::load(path, placement, animation)?,
        _ => return Err(input::error(path, "unknown kind of mesh file", "give a .ply, .gltf or .glb file")),
    };
    contents.meshes.retain(|mesh| !mesh.triangles.is_empty());
    Ok(contents)
}

/// Checks that positions and indices of a mesh are in range.
pub(in crate::scene) fn check(path: &Path, mesh: &Mesh) -> Result<()> {
    let number = mesh.positions.iter().position(|position| !in_range(position));
    if let Some(number) = number {
        let cause = format!(
            "mesh {}: position of vertex {number} (the first is 0) is not finite or exceeds {MAX_COORDINATE:e}",
            mesh.name
        );
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
    /// `None` if the file has an index that is negative or not an integer.
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

fn load_ply(path: &Path, placement: &Placement) -> Result<Mesh> {
    let file = ply::open(path)?;
    file.require_scalars("vertex", &["x", "y", "z"])?;
    let faces = &file.element("face")?.properties;
    if !faces.contains_key("vertex_indices") && !faces.contains_key("vertex_index") {
        return Err(file.error("element face lacks the property vertex_indices", "add the property to the file"));
    }
    let mut mesh = Mesh {
        name: input::stem(path),
        positions: vec![],
        triangles: vec![],
        albedo: DEFAULT_ALBEDO,
        solid: false,
        alpha: None,
    };
    file.read_rows(&["vertex", "face"], |element, number, row: Row| {
        match element {
            "vertex" => mesh.positions.push(placement.position(row.position).map(|value| value as f32)),
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
