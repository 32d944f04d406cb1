//! Nodes of a glTF file's scene: where they stand, which are hidden, and where a node repeats its mesh (EXT_mesh_gpu_instancing).

use crate::Result;
use crate::scene::files::gltf_accessor;
use crate::scene::files::gltf_animation::NodePose;
use crate::scene::files::gltf_document::GltfDocument;
use crate::scene::files::input;
use glam::{DMat4, DQuat, DVec3};
use gltf::accessor::{DataType, Dimensions};
use serde_json::Value;
use std::path::Path;

/// The nodes of a scene.
pub(in crate::scene) struct Nodes<'a> {
    /// Nodes in the scene's order, parents before their children.
    pub all: Vec<PlacedNode<'a>>,
    /// The transform of each node of the file; the identity for nodes outside the scene.
    to_world: Vec<DMat4>,
}

/// A node in the world.
pub(in crate::scene) struct PlacedNode<'a> {
    pub node: gltf::Node<'a>,
    pub to_world: DMat4,
    /// Whether the node, or one above it, is hidden by KHR_node_visibility.
    pub hidden: bool,
    /// The weights of its mesh's morph targets, if an animation gives them.
    pub weights: Option<Vec<f64>>,
}

impl<'a> Nodes<'a> {
    /// Walks the nodes of the file's scene. `poses`: the state of each node; none if all are at rest.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if there is no scene, or a node has more than one parent.
    pub(in crate::scene) fn new(path: &Path, file: &'a GltfDocument, poses: &[NodePose]) -> Result<Self> {
        let document = &file.document;
        let scene = document
            .default_scene()
            .or_else(|| document.scenes().next())
            .ok_or_else(|| input::error(path, "has no scene", "give a glTF file with a scene"))?;
        let mut all = Vec::new();
        let mut to_world = vec![DMat4::IDENTITY; document.nodes().len()];
        // A list instead of recursion, and each node at most once: a malicious file may nest them deeply or in a cycle.
        let mut visited = vec![false; to_world.len()];
        let mut open: Vec<_> = scene.nodes().map(|node| (node, DMat4::IDENTITY, false)).collect();
        open.reverse();
        while let Some((node, parent_to_world, hidden)) = open.pop() {
            let index = node.index();
            match (visited.get_mut(index), to_world.get_mut(index)) {
                (Some(seen), Some(place)) if !*seen => {
                    *seen = true;
                    let place_in_f64 = file.translations.get(index).copied().flatten();
                    let at_rest = NodePose::default();
                    let pose = poses.get(index);
                    let to_parent = pose.unwrap_or(&at_rest).to_parent(&node.transform(), place_in_f64);
                    *place = parent_to_world * to_parent;
                    let hidden = hidden || file.hidden.get(index).is_some_and(|hidden| *hidden);
                    let children_from = open.len();
                    open.extend(node.children().map(|child| (child, *place, hidden)));
                    if let Some(children) = open.get_mut(children_from..) {
                        children.reverse();
                    }
                    let weights = pose.and_then(|pose| pose.weights.clone());
                    all.push(PlacedNode { node, to_world: *place, hidden, weights });
                }
                _ => {
                    let cause = format!("node {index} has more than one parent");
                    return Err(input::error(path, cause, "correct the file: glTF nodes form trees"));
                }
            }
        }
        Ok(Self { all, to_world })
    }

    /// Returns the transform of the node with this index.
    pub(in crate::scene) fn to_world(&self, index: usize) -> DMat4 {
        self.to_world.get(index).copied().unwrap_or_default()
    }
}

/// Returns the places of a node's mesh: one, or one per instance.
pub(in crate::scene) fn places(file: &GltfDocument, placed: &PlacedNode) -> std::result::Result<Vec<DMat4>, String> {
    let attributes = file.instances.get(placed.node.index()).unwrap_or(&Value::Null);
    if attributes.is_null() {
        return Ok(vec![placed.to_world]);
    }
    const TURNS: [DataType; 3] = [DataType::F32, DataType::I8, DataType::I16];
    let moves = numbers::<3>(file, &attributes["TRANSLATION"], "TRANSLATION", &TURNS[..1])?;
    let turns = numbers::<4>(file, &attributes["ROTATION"], "ROTATION", &TURNS)?;
    let scales = numbers::<3>(file, &attributes["SCALE"], "SCALE", &TURNS[..1])?;
    let counts = [moves.as_ref().map(Vec::len), turns.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count =
        counts.into_iter().flatten().next().ok_or("EXT_mesh_gpu_instancing without a place for its instances")?;
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(format!("EXT_mesh_gpu_instancing with attributes of {counts:?} instances"));
    }
    let place = |i: usize| {
        let at = moves.as_ref().map_or(DVec3::ZERO, |all| DVec3::from_array(all[i]));
        let scale = scales.as_ref().map_or(DVec3::ONE, |all| DVec3::from_array(all[i]));
        let turn = turns.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all[i]));
        // A rotation of length 0 turns nothing.
        let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
        placed.to_world * DMat4::from_scale_rotation_translation(scale, turn, at)
    };
    Ok((0..count).map(place).collect())
}

/// Returns the numbers of the accessor with this index; `None` if the index is null.
fn numbers<const N: usize>(
    file: &GltfDocument,
    index: &Value,
    name: &str,
    types: &[DataType],
) -> std::result::Result<Option<Vec<[f64; N]>>, String> {
    if index.is_null() {
        return Ok(None);
    }
    let index = index.as_u64().and_then(|index| usize::try_from(index).ok());
    let accessor = index.and_then(|index| file.document.accessors().nth(index));
    let accessor = accessor.ok_or_else(|| format!("{name} of EXT_mesh_gpu_instancing has no accessor"))?;
    let dimensions = if N == 3 { Dimensions::Vec3 } else { Dimensions::Vec4 };
    let elements = gltf_accessor::elements(file, &accessor, dimensions, types)
        .map_err(|cause| format!("{name} of EXT_mesh_gpu_instancing {cause}"))?;
    Ok(Some(elements.iter().map(|element| gltf_accessor::numbers(&accessor, element)).collect()))
}
