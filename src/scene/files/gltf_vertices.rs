//! Positions of a glTF primitive's vertices in world space: moved by morph targets and joints as the file has them at rest, and repeated
//! for each instance.

use crate::scene::files::gltf_accessor::{self, NUMBERS};
use crate::scene::files::gltf_document::GltfDocument;
use crate::scene::files::gltf_nodes::{Nodes, PlacedNode, places};
use crate::scene::files::placement::Placement;
use glam::{DMat4, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Primitive, Semantic};

type Checked<T> = std::result::Result<T, String>;

/// The vertices of a primitive, once per place.
pub(in crate::scene) struct Vertices {
    /// Positions in the scene, place by place.
    pub positions: Vec<[f32; 3]>,
    /// Whether each place mirrors the primitive.
    pub mirrored: Vec<bool>,
}

/// Reads and places the vertices of a node's primitive. `most`: the largest number of them.
pub(in crate::scene) fn read(
    file: &GltfDocument,
    nodes: &Nodes,
    placed: &PlacedNode,
    primitive: &Primitive,
    placement: &Placement,
    most: usize,
) -> Checked<Vertices> {
    let local = morphed(file, placed, primitive)?;
    let rounded = |position: DVec3| placement.point(position).as_vec3().to_array();
    // Joints alone place a skinned mesh (glTF 2.0, 3.7.3.3).
    if let Some(skin) = placed.node.skin() {
        let joints = joints(file, nodes, &skin)?;
        let positions = skinned(file, placed, primitive, &local, &joints)?;
        let mirrored = joints.first().is_some_and(|joint| joint.determinant() < 0.0);
        return Ok(Vertices { positions: positions.into_iter().map(rounded).collect(), mirrored: vec![mirrored] });
    }
    let places = places(file, placed)?;
    if local.len().checked_mul(places.len()).is_none_or(|count| count > most) {
        return Err(format!("its {} instances have more than {most} vertices", places.len()));
    }
    let in_world = |place: &DMat4| {
        let place = *place;
        local.iter().map(move |position| rounded(place.transform_point3(*position)))
    };
    let positions = places.iter().flat_map(in_world).collect();
    Ok(Vertices { positions, mirrored: places.iter().map(|place| place.determinant() < 0.0).collect() })
}

fn vectors(file: &GltfDocument, accessor: &Accessor, name: &str) -> Checked<Vec<DVec3>> {
    let elements = gltf_accessor::elements(file, accessor, Dimensions::Vec3, &NUMBERS)
        .map_err(|cause| format!("{name} {cause}"))?;
    Ok(elements.iter().map(|element| DVec3::from_array(gltf_accessor::numbers(accessor, element))).collect())
}

/// Returns a primitive's positions with its morph targets by the weights of the node or, without, of the mesh.
fn morphed(file: &GltfDocument, placed: &PlacedNode, primitive: &Primitive) -> Checked<Vec<DVec3>> {
    let accessor = primitive.get(&Semantic::Positions).ok_or("has no POSITION")?;
    let mut positions = vectors(file, &accessor, "POSITION")?;
    let of_mesh = || placed.node.mesh().and_then(|mesh| mesh.weights());
    let at_rest = || placed.node.weights().or_else(of_mesh).unwrap_or_default().iter().map(|w| f64::from(*w)).collect();
    let weights: Vec<f64> = placed.weights.clone().unwrap_or_else(at_rest);
    for (number, (target, weight)) in primitive.morph_targets().zip(weights).enumerate() {
        let Some(accessor) = target.positions().filter(|_| weight != 0.0) else { continue };
        let moves = vectors(file, &accessor, &format!("POSITION of morph target {number}"))?;
        if moves.len() != positions.len() {
            return Err(format!("morph target {number} has {} of {} vertices", moves.len(), positions.len()));
        }
        positions.iter_mut().zip(moves).for_each(|(position, by)| *position += weight * by);
    }
    Ok(positions)
}

/// Returns the matrix of each joint, from the mesh's space to the world.
fn joints(file: &GltfDocument, nodes: &Nodes, skin: &gltf::Skin) -> Checked<Vec<DMat4>> {
    let all: Vec<DMat4> = skin.joints().map(|joint| nodes.to_world(joint.index())).collect();
    let Some(accessor) = skin.inverse_bind_matrices() else { return Ok(all) };
    let elements = gltf_accessor::elements(file, &accessor, Dimensions::Mat4, &[DataType::F32])
        .map_err(|cause| format!("the inverse bind matrices of skin {} {cause}", skin.index()))?;
    let binds: Vec<DMat4> =
        elements.iter().map(|m| DMat4::from_cols_array(&gltf_accessor::numbers(&accessor, m))).collect();
    if binds.len() < all.len() {
        return Err(format!(
            "skin {} has {} inverse bind matrices for {} joints",
            skin.index(),
            binds.len(),
            all.len()
        ));
    }
    Ok(all.iter().zip(binds).map(|(joint, bind)| *joint * bind).collect())
}

/// Returns the positions that the joints give. A vertex that no joint moves stays with its node.
fn skinned(
    file: &GltfDocument,
    placed: &PlacedNode,
    primitive: &Primitive,
    local: &[DVec3],
    matrices: &[DMat4],
) -> Checked<Vec<DVec3>> {
    let mut sums = vec![(DVec3::ZERO, 0.0); local.len()];
    for set in 0.. {
        let (Some(joints), Some(weights)) =
            (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set)))
        else {
            break;
        };
        let elements = |accessor: &Accessor, name: &str, types: &[DataType]| {
            let found = gltf_accessor::elements(file, accessor, Dimensions::Vec4, types);
            let all = found.map_err(|cause| format!("{name}_{set} {cause}"))?;
            let all: Vec<[f64; 4]> = all.iter().map(|element| gltf_accessor::numbers(accessor, element)).collect();
            let wrong = format!("{name}_{set} has {} elements for {} vertices", all.len(), local.len());
            if all.len() == local.len() { Ok(all) } else { Err(wrong) }
        };
        let joints = elements(&joints, "JOINTS", &[DataType::U8, DataType::U16])?;
        let weights = elements(&weights, "WEIGHTS", &[DataType::F32, DataType::U8, DataType::U16])?;
        for ((position, (sum, whole)), (joints, weights)) in
            local.iter().zip(&mut sums).zip(joints.iter().zip(&weights))
        {
            for (joint, weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let matrix = matrices.get(*joint as usize);
                let matrix = matrix.ok_or_else(|| format!("JOINTS_{set} has joint {joint} of {}", matrices.len()))?;
                *sum += *weight * matrix.transform_point3(*position);
                *whole += weight;
            }
        }
    }
    let place = |(position, (sum, whole)): (&DVec3, (DVec3, f64))| {
        if whole == 0.0 { placed.to_world.transform_point3(*position) } else { sum / whole }
    };
    Ok(local.iter().zip(sums).map(place).collect())
}
