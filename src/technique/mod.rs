//! Shadow techniques. Each is passes that build a representation, and one GLSL function that answers from it.
//!
//! To add one: a folder in glsl/ with its passes and a visibility.glsl, a module here, its line in [`REGISTRY`] and its
//! folder in build.rs's list.

mod avsm;
mod bins;
mod drawn;
mod filter;
mod light;
mod list;
mod opaque;
mod psm;
mod spec;
mod uncompressed;

pub use avsm::{Avsm, NodeData};
pub use bins::{BinTotals, TilePart};
pub use light::{LightData, MapData, SceneData, TriangleData};
pub use list::SegmentData;
pub use psm::Psm;
pub use spec::{Key, Spec, Values, parse};

use crate::Result;
use crate::gpu::{Bindings, Context, PassTime, Requirement};
use crate::scene::Scene;
use std::collections::BTreeMap;

/// A technique, opened for one scene on one device.
pub trait Technique {
    /// Builds the representation and returns the time of each pass; none where neither scene nor light has changed since
    /// the last build, unless the spec says `skip=off`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out or the device is lost.
    fn build(&mut self) -> Result<Vec<PassTime>>;

    /// Says that the casters' or the lights' buffers have changed: the next build starts anew.
    fn changed(&mut self);

    /// What a shader with `#include "visibility.glsl"` needs to ask this technique.
    fn visibility(&self) -> Visibility<'_>;

    /// The nodes of a texel's curve after a build, (depth, transmittance); none for a technique without nodes. `map`
    /// counts the maps of all lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where they cannot be read back.
    fn nodes(&self, _map: usize, _texel: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        Ok(Vec::new())
    }

    /// The path that runs.
    fn path(&self) -> &'static str;

    /// Why this path.
    fn reason(&self) -> String;

    /// Bytes that the look-up needs.
    fn bytes_resident(&self) -> u64;

    /// Bytes needed only while building.
    fn bytes_transient(&self) -> u64;

    /// Counts of the last build.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where they cannot be read back.
    fn counters(&self) -> Result<BTreeMap<String, u64>>;
}

/// How to ask a technique.
pub struct Visibility<'a> {
    /// Folder in glsl/, prefix of the names of the shaders built with it.
    pub folder: &'static str,
    /// Descriptor set 1.
    pub bindings: &'a Bindings,
    /// Specialization constants 0, 1, …
    pub constants: &'a [u32],
}

/// A path of a technique, for `gobo devices`.
pub struct Path {
    /// Its name in specs.
    pub name: &'static str,
    /// What the device must have.
    pub requires: &'static [Requirement],
}

/// Opens a technique.
pub type Open = fn(&Context, &Scene, &SceneData, &Spec) -> Result<Box<dyn Technique>>;

/// A line of the registry.
pub struct Entry {
    /// Its name in specs.
    pub name: &'static str,
    /// One line.
    pub about: &'static str,
    /// The keys of its specs.
    pub keys: &'static [Key],
    /// Its paths.
    pub paths: &'static [Path],
    /// Opens it for the scene whose data is on the device.
    pub open: Open,
}

/// A key that several techniques have.
const SKIP: Key = Key {
    name: "skip",
    values: Values::OneOf(&["on", "off"]),
    default: "on",
    about: "leave out casters and tiles that no look-up misses, and builds where nothing has changed",
};

/// A key that every technique has and none reads: whoever draws the picture does.
const LIGHTING: Key = Key {
    name: "lighting",
    values: Values::OneOf(&["fragment", "vertex"]),
    default: "fragment",
    about: "the picture's casters ask for light at each pixel, or at the vertices of tessellated quads",
};

/// Every technique.
pub const REGISTRY: &[&Entry] = &[&avsm::ENTRY, &psm::ENTRY, &uncompressed::ENTRY];

/// Texels a side of a light's map, for a spec of any technique.
pub fn map_size(spec: &Spec) -> u32 {
    spec.number("size")
}

/// An error where the device lacks one of `requirements`.
fn require(context: &Context, requirements: &[Requirement]) -> Result<()> {
    context.features().require(requirements)
}
