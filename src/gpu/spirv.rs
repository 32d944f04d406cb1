//! The shaders that the build compiled.

use crate::{Error, Result};

/// A compiled shader.
pub struct Shader {
    /// Its place in glsl/, with the technique in front for shaders built once a technique, and ATTACHMENTS behind for
    /// those built once for each: `avsm/resolve.comp`, `avsm/consume/query.comp`, `avsm/unpack.comp/4`.
    pub name: &'static str,
    /// SPIR-V.
    pub words: &'static [u32],
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The shader of that name.
///
/// # Errors
/// [`Error::Gpu`] where build.rs lists none.
pub fn shader(name: &str) -> Result<&'static Shader> {
    SHADERS.iter().find(|s| s.name == name).ok_or_else(|| Error::Gpu {
        operation: "find shader",
        name: name.into(),
        cause: "build.rs lists no such variant".into(),
        way_out: "report this as a bug".into(),
    })
}
