//! The shaders of the program, compiled and named by build.rs: `shaders::avsm::RESOLVE` is glsl/technique/avsm/resolve.comp,
//! `shaders::list::CAPTURE_FRAG` glsl/maps/list/capture.frag, `shaders::avsm::CELLS_LANES_1` a variant of glsl/technique/avsm/cells.comp.

use crate::gpu::{Shader, Spirv};

/// A folder of glsl/ with a visibility.glsl, which shaders that ask for light are compiled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folder {
    place: usize,
    /// Its name in glsl/.
    pub name: &'static str,
    /// Whether its look-up, compiled with LOOK_UP_STEPS, counts its steps in look_up_steps.
    pub counts_steps: bool,
}

impl Folder {
    /// Its index among all folders with a visibility.glsl.
    pub(crate) fn place(self) -> usize {
        self.place
    }
}

/// A shader that asks for light, compiled once per technique.
pub struct PerTechnique(&'static [Shader]);

impl PerTechnique {
    /// The shader that asks the technique in `folder`.
    pub fn of(&self, folder: Folder) -> &'static Shader {
        &self.0[folder.place]
    }
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
