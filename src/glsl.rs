//! GLSL for other programs: the look-up of each technique in one file, with its descriptors and constants.
//!
//! [`file()`] returns a technique's file. It includes no other file, every global name in it begins with `gobo_` and the technique's name,
//! and the numbers of its bindings and constants stay the same from version to version. The comment at the top lists everything that the
//! look-up needs. build.rs generates it from glsl/ (build/flat.rs).
//!
//! ```
//! let avsm = gobo::glsl::file("avsm")?;
//! let shader = format!(
//!     "#version 460\n#define GOBO_AVSM_SET 0\n#define GOBO_AVSM_BINDING 4\n{}\n{}",
//!     avsm.text, "void main() { float lit = gobo_avsm_visibility(0u, vec3(0.0)); }",
//! );
//! # assert!(shader.contains("float gobo_avsm_visibility("));
//! # Ok::<(), gobo::Error>(())
//! ```

use crate::error::did_you_mean;
use crate::shaders::{Folder, constant};
use crate::technique::Answer;
use crate::{Error, Result};
use ash::vk;

/// The look-up of a technique, in one file.
#[derive(Debug)]
pub struct File {
    /// The technique's name, such as `beer-shadow-map`; names in the file spell it `beer_shadow_map`.
    pub technique: &'static str,
    /// GLSL source, to be placed after `#version 460`.
    pub text: &'static str,
    /// Number of its first binding, unless GOBO_AVSM_BINDING is defined. No two files share one.
    pub first_binding: u32,
    /// Id of its first specialization constant, unless GOBO_AVSM_CONSTANT is defined. No two files share one.
    pub first_constant: u32,
    /// Its bindings, in order of their numbers.
    pub bindings: &'static [Binding],
    /// Its specialization constants, in the order of their ids: `constants[i]` has the first id plus i.
    pub constants: &'static [Constant],
}

/// A binding of a [`File`].
#[derive(Debug)]
pub struct Binding {
    /// Number relative to the file's first binding, which has 0.
    pub number: u32,
    /// Its name in the file.
    pub name: &'static str,
    /// Its descriptor type.
    pub descriptor: vk::DescriptorType,
    /// Its GLSL type: `gobo_avsm_Light[]`, `sampler2D`.
    pub glsl: &'static str,
    /// Size in bytes, in scalar layout: of one element if the buffer is an array, of the whole buffer otherwise; 0 for bindings that are
    /// not buffers.
    pub stride: u32,
    /// A description of its content.
    pub about: &'static str,
}

/// A specialization constant of a [`File`].
#[derive(Debug)]
pub struct Constant {
    /// Its name, without the file's prefix.
    pub name: &'static str,
    /// `uint`, `int`, `float` or `bool`.
    pub glsl: &'static str,
    /// The default value, as written in GLSL.
    pub default: &'static str,
    /// A description of its meaning.
    pub about: &'static str,
    /// Its id in the program's own shaders.
    inside: u32,
}

include!(concat!(env!("OUT_DIR"), "/glsl.rs"));

/// Returns the file of a technique, such as `avsm` or `beer-shadow-map`.
///
/// # Errors
/// [`Error::Usage`] if no technique has that name; the error lists the names that exist.
pub fn file(technique: &str) -> Result<&'static File> {
    let line = |text: &str| text.replace(char::is_control, "?");
    FILES.iter().find(|file| file.technique == technique).ok_or_else(|| {
        let known: Vec<_> = FILES.iter().map(|file| file.technique).collect();
        let (name, _) = technique.split_once(':').unwrap_or((technique, ""));
        if known.contains(&name) {
            let cause = "all settings of a technique share one file";
            return Error::usage(line(technique), cause, format!("write {name}"));
        }
        let cause = format!("no technique has such a look-up{}", did_you_mean(technique, known.iter().copied()));
        Error::usage(line(&format!("\"{technique}\"")), cause, format!("choose from: {}", known.join(", ")))
    })
}

impl File {
    /// Returns the file of the technique in `folder`.
    pub fn of(folder: Folder) -> &'static Self {
        &FILES[folder.place()]
    }
}

impl Answer<'_> {
    /// Returns the technique's file.
    pub fn file(&self) -> &'static File {
        File::of(self.folder)
    }

    /// Returns layout bindings for a descriptor set of the caller's: the bindings of the technique's file, numbered from `first_binding`,
    /// visible to all stages.
    pub fn layout(&self, first_binding: u32) -> Vec<vk::DescriptorSetLayoutBinding<'static>> {
        let slot = |binding: &Binding| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(first_binding + binding.number)
                .descriptor_type(binding.descriptor)
                .descriptor_count(1)
                .stage_flags(vk::ShaderStageFlags::ALL)
        };
        self.file().bindings.iter().map(slot).collect()
    }

    /// Returns ids and values of the specialization constants of the technique's file, whose first constant gets the id `first_id`.
    /// Constants that keep their defaults are left out. The values depend only on how the technique was opened, and never change.
    pub fn specialization(&self, first_id: u32) -> Vec<(u32, u32)> {
        let constants = (first_id..).zip(self.file().constants);
        constants.filter_map(|(id, constant)| Some((id, self.constants.word(constant.inside)?))).collect()
    }

    /// Writes the look-up's resources into a descriptor set of the caller's, starting at `first_binding`. Buffers of a look-up are replaced
    /// when they grow: write again after each build that grew ([`crate::technique::BuildStatus::Retry`]).
    ///
    /// # Safety
    /// `set` belongs to the device that the technique was opened on and has the bindings of [`Answer::layout`]; no pending command uses
    /// them, and the technique outlives the commands that do.
    #[allow(unsafe_code)]
    pub unsafe fn write_into(&self, set: vk::DescriptorSet, first_binding: u32) {
        // SAFETY: the caller upholds this function's own contract.
        unsafe { self.bindings.write_into(set, first_binding) }
    }
}
