//! Meshes that an animation of a glTF file moves.

use crate::Result;
use crate::scene::Mesh;
use crate::scene::files::gltf_animation::GltfAnimation;
use crate::scene::files::gltf_document::GltfDocument;
use crate::scene::files::gltf_file::MOST;
use crate::scene::files::gltf_nodes::Nodes;
use crate::scene::files::placement::Placement;
use crate::scene::files::{gltf_vertices, input};
use glam::DMat4;
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of times at which the extent of a motion is seen.
const TIMES: usize = 8;

/// The node and the primitive of its mesh that a mesh of the scene is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Source {
    pub node: usize,
    pub primitive: usize,
}

/// The motion of a file's meshes.
#[derive(Clone)]
pub(in crate::scene) struct Motion {
    path: PathBuf,
    file: Arc<GltfDocument>,
    placement: Placement,
    animation: Arc<GltfAnimation>,
    /// The meshes that move, by their index in the scene.
    moved: Vec<(usize, Source)>,
    /// Nodes of lights, cameras and splats that the animation moves, and which stay.
    staying: usize,
}

impl Motion {
    /// Creates the motion of meshes that come from `sources`.
    pub fn new(
        path: &Path,
        file: Arc<GltfDocument>,
        placement: Placement,
        animation: GltfAnimation,
        sources: Vec<Source>,
    ) -> Result<Self> {
        let at = |time_s: f64| {
            let poses = animation.poses(file.document.nodes().len(), time_s);
            Nodes::new(path, &file, &poses).map(|nodes| (poses, nodes))
        };
        // A node moves if it is not at rest at some time. Skins and weights count as moving whenever the animation has a channel at all.
        let (_, rest) = at(0.0)?;
        let mut moves = vec![false; file.document.nodes().len()];
        let still = Nodes::new(path, &file, &[])?;
        let times = (0..TIMES).map(|i| animation.duration_s * (i as f64 + 0.5) / TIMES as f64);
        for time_s in times {
            let (poses, now) = at(time_s)?;
            for placed in &still.all {
                let index = placed.node.index();
                let differs = |nodes: &Nodes| !is_like(now.to_world(index), nodes.to_world(index));
                let is_posed = poses[index].weights.is_some() || placed.node.skin().is_some();
                moves[index] |= is_posed || differs(&rest) || differs(&still);
            }
        }
        let is_moved = |node: usize| moves.get(node).is_some_and(|moves| *moves);
        let moved = sources.iter().copied().enumerate().filter(|(_, source)| is_moved(source.node)).collect();
        let has_splats =
            |node: &gltf::Node| node.mesh().is_some_and(|mesh| file.splats.iter().any(|of| of.mesh == mesh.index()));
        let is_staying = |node: &gltf::Node| node.light().is_some() || node.camera().is_some() || has_splats(node);
        let staying =
            still.all.iter().filter(|placed| is_moved(placed.node.index()) && is_staying(&placed.node)).count();
        Ok(Self { path: path.into(), placement, animation: Arc::new(animation), moved, staying, file: file.clone() })
    }

    /// Returns whether any mesh moves.
    pub fn moves(&self) -> bool {
        !self.moved.is_empty()
    }

    /// Returns what a user should know, one line per kind.
    pub fn notes(&self) -> Vec<String> {
        let GltfAnimation { name, duration_s, others, damaged, .. } = &*self.animation;
        let count = self.file.animations.as_array().map_or(0, Vec::len);
        let rest = match count {
            0 | 1 => String::new(),
            2 => ", another is not".into(),
            _ => format!(", {} others are not", count - 1),
        };
        let name = input::one_line(name);
        let does = if self.moves() { format!("is played, {duration_s:.3} s") } else { "moves no mesh".into() };
        let played = format!("{}: animation {name} {does}{rest}", input::file_name(&self.path));
        let line = |count: usize, one: &str, many: &str| input::note(&self.path, count, one, many);
        let others = line(*others, "channel of it moves no node", "channels of it move no node");
        let staying = line(
            self.staying,
            "light, camera or mesh of splats that it moves stays at rest",
            "lights, cameras and meshes of splats that it moves stay at rest",
        );
        let (one, many) = ("channel of it is damaged and left out", "channels of it are damaged and left out");
        let damaged = line(damaged.0, one, many).map(|told| format!("{told}; {}", damaged.1));
        [Some(played), others, damaged, staying].into_iter().flatten().collect()
    }

    /// Shifts the indices of its meshes, because others stand before them.
    pub fn follow(&mut self, meshes: usize) {
        self.moved.iter_mut().for_each(|(index, _)| *index += meshes);
    }

    /// Moves meshes of the scene to where they are at a time, in seconds.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a position is not finite.
    pub fn show(&self, meshes: &mut [Mesh], time_s: f64) -> Result<()> {
        let poses = self.animation.poses(self.file.document.nodes().len(), time_s);
        let nodes = Nodes::new(&self.path, &self.file, &poses)?;
        let mut by_node: HashMap<usize, Vec<&(usize, Source)>> = HashMap::new();
        self.moved.iter().for_each(|moved| by_node.entry(moved.1.node).or_default().push(moved));
        for placed in &nodes.all {
            for (index, source) in by_node.get(&placed.node.index()).into_iter().flatten() {
                let primitive = placed.node.mesh().and_then(|mesh| mesh.primitives().nth(source.primitive));
                let (Some(primitive), Some(mesh)) = (primitive, meshes.get_mut(*index)) else { continue };
                let wrong = |cause: String| {
                    let at = format!("mesh {} at {time_s} s: {cause}", mesh.name);
                    input::error(&self.path, at, "correct the animation")
                };
                let vertices = gltf_vertices::read(&self.file, &nodes, placed, &primitive, &self.placement, MOST);
                let positions = vertices.map_err(wrong)?.positions;
                if !positions.as_flattened().iter().all(|value| value.is_finite()) {
                    return Err(wrong("a position is not finite".into()));
                }
                mesh.positions = positions;
            }
        }
        Ok(())
    }

    /// Returns the moving meshes of the scene at several times, to which a camera can be fitted.
    ///
    /// # Errors
    /// See [`Self::show`].
    pub fn some(&self, meshes: &[Mesh]) -> Result<Vec<Mesh>> {
        let mut all = Vec::new();
        for i in 0..TIMES {
            let mut now = meshes.to_vec();
            // Just before the end: there the loop begins again.
            let share = i as f64 / (TIMES - 1) as f64 * (1.0 - 1e-9);
            self.show(&mut now, self.animation.duration_s * share)?;
            all.extend(self.moved.iter().filter_map(|(index, _)| now.get(*index).cloned()));
        }
        Ok(all)
    }
}

fn is_like(a: DMat4, b: DMat4) -> bool {
    a.abs_diff_eq(b, 1e-9 * (1.0 + a.w_axis.length()))
}

/// The debug text goes into a scene's fingerprint, so it must stay the same while files do not change.
impl fmt::Debug for Motion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { path, placement, animation, moved, .. } = self;
        write!(f, "Motion({path:?} {placement:?} {animation:?} {moved:?})")
    }
}

impl PartialEq for Motion {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.file, &other.file) && self.placement == other.placement && self.moved == other.moved
    }
}
