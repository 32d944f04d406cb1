//! GLSL for other programs: the look-up of each technique as one file, with its descriptors and constants.
//!
//! [`file()`] is a technique's file: it includes nothing, every global name in it begins with `gobo_` and the
//! technique's name, and the numbers of its bindings and constants stay the same from version to version. The comment
//! at its top lists everything that it must be given. Build.rs makes it from glsl/ (build/flat.rs).
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
    /// The technique's name, as `beer-shadow-map`; the file writes it `beer_shadow_map` in its own names.
    pub technique: &'static str,
    /// GLSL, to be put behind `#version 460`.
    pub text: &'static str,
    /// The number of its first binding, where GOBO_AVSM_BINDING is not defined. No two files share one.
    pub first_binding: u32,
    /// The id of its first specialization constant, where GOBO_AVSM_CONSTANT is not defined. No two files share one.
    pub first_constant: u32,
    /// Its bindings, by number.
    pub bindings: &'static [Binding],
    /// Its specialization constants, in the order of their ids: `constants[i]` has the first id plus i.
    pub constants: &'static [Constant],
}

/// A binding of a [`File`].
#[derive(Debug)]
pub struct Binding {
    /// Counted from the file's first binding, which has 0.
    pub number: u32,
    /// Its name in the file.
    pub name: &'static str,
    /// Its descriptor type.
    pub descriptor: vk::DescriptorType,
    /// Its GLSL type: `gobo_avsm_Light[]`, `sampler2D`.
    pub glsl: &'static str,
    /// In scalar layout, the bytes of one element of a buffer that is an array, or of all of any other buffer; 0 for
    /// bindings that are not buffers.
    pub stride: u32,
    /// Its content.
    pub about: &'static str,
}

/// A specialization constant of a [`File`].
#[derive(Debug)]
pub struct Constant {
    /// Without the file's prefix.
    pub name: &'static str,
    /// `uint`, `int`, `float` or `bool`.
    pub glsl: &'static str,
    /// The value where it is not set, as GLSL writes it.
    pub default: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// Its id in the program's own shaders.
    inside: u32,
}

include!(concat!(env!("OUT_DIR"), "/glsl.rs"));

/// The file of a technique: `avsm`, `beer-shadow-map`.
///
/// # Errors
/// [`Error::Usage`] where no technique has that name, with the names that there are.
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
    /// The file of the technique in `folder`.
    pub fn of(folder: Folder) -> &'static Self {
        &FILES[folder.place()]
    }
}

impl Answer<'_> {
    /// The technique's file.
    pub fn file(&self) -> &'static File {
        File::of(self.folder)
    }

    /// Layout bindings for a descriptor set of the caller's: those of the technique's file, numbered from
    /// `first_binding` on, for all stages.
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

    /// Ids and values of the specialization constants of the technique's file, whose first constant has the id
    /// `first_id`. Constants that keep their defaults are left out. The values follow from how the technique was
    /// opened, and never change.
    pub fn specialization(&self, first_id: u32) -> Vec<(u32, u32)> {
        let constants = (first_id..).zip(self.file().constants);
        constants.filter_map(|(id, constant)| Some((id, self.constants.word(constant.inside)?))).collect()
    }

    /// Writes the look-up's resources into a descriptor set of the caller's, from `first_binding` on. Buffers of a look-up are replaced as
    /// they grow: write again after each build that grew ([`crate::technique::BuildStatus::Retry`]).
    ///
    /// # Safety
    /// `set` is of the device that the technique was opened on and has the bindings of [`Answer::layout`]; no command that is
    /// pending uses them, and the technique outlives the commands that do.
    #[allow(unsafe_code)]
    pub unsafe fn write_into(&self, set: vk::DescriptorSet, first_binding: u32) {
        // SAFETY: the caller promises it.
        unsafe { self.bindings.write_into(set, first_binding) }
    }
}
