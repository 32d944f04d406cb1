//! The shaders of the program, compiled and named by build.rs: `shaders::avsm::RESOLVE` is glsl/technique/avsm/resolve.comp,
//! `shaders::list::CAPTURE_FRAG` glsl/maps/list/capture.frag, `shaders::avsm::CELLS_LANES_1` a variant of glsl/technique/avsm/cells.comp.

use crate::gpu::{Shader, Spirv};

/// A folder in glsl/ whose visibility.glsl is compiled into the shaders that look up light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folder {
    place: usize,
    /// Its name in glsl/.
    pub name: &'static str,
    /// Whether its look-up counts its steps in look_up_steps when compiled with LOOK_UP_STEPS.
    pub counts_steps: bool,
}

impl Folder {
    /// Returns its index among all folders with a visibility.glsl.
    pub(crate) fn place(self) -> usize {
        self.place
    }
}

/// A shader that looks up light, compiled once per technique.
pub struct PerTechnique(&'static [Shader]);

impl PerTechnique {
    /// Returns the shader that queries the technique in `folder`.
    pub fn of(&self, folder: Folder) -> &'static Shader {
        &self.0[folder.place]
    }
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
