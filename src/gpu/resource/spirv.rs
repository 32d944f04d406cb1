//! A compiled shader. The program's own shaders are in [`crate::shaders`].

/// SPIR-V, aligned to words as Vulkan requires.
#[repr(C, align(4))]
pub struct Spirv<T: ?Sized = [u8]>(pub T);

/// A compiled shader.
pub struct Shader {
    /// Path in glsl/. A shader that is compiled once per technique has the technique as a prefix, and one that is
    /// compiled for several values has the value as a suffix: `technique/avsm/resolve.comp`, `avsm/query/points.comp`,
    /// `technique/avsm/unpack.comp/4`.
    pub name: &'static str,
    /// The block of its push constants, `Name { type member; … }`; empty if it has none.
    pub push: &'static str,
    /// The compiled code.
    pub spirv: &'static Spirv,
}

impl Shader {
    /// Returns the SPIR-V as words.
    pub fn words(&self) -> &'static [u32] {
        bytemuck::cast_slice(&self.spirv.0)
    }
}

impl std::fmt::Debug for Shader {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name)
    }
}
