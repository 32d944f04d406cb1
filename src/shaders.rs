//! The shaders of the program, compiled and named by build.rs: `shaders::avsm::RESOLVE` is glsl/technique/avsm/resolve.comp,
//! `shaders::list::CAPTURE_FRAG` glsl/maps/list/capture.frag, `shaders::avsm::CELLS_LANES_1` a variant of glsl/technique/avsm/cells.comp.

use crate::gpu::{Shader, Spirv};

/// A folder of glsl/ with a visibility.glsl: what consumers are built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folder {
    place: usize,
    /// Its name in glsl/.
    pub name: &'static str,
    /// Whether its look-up counts its steps, in look_up_steps, where LOOK_UP_STEPS is defined.
    pub counts_steps: bool,
}

impl Folder {
    /// Its place among all folders that answer.
    pub(crate) fn place(self) -> usize {
        self.place
    }
}

/// A shader that asks for light, once for each technique.
pub struct PerTechnique(&'static [Shader]);

impl PerTechnique {
    /// The one that asks the technique of that folder.
    pub fn of(&self, folder: Folder) -> &'static Shader {
        &self.0[folder.place]
    }
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
