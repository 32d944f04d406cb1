//! A compiled shader. The program's own shaders are in [`crate::shaders`].

/// SPIR-V, aligned for Vulkan, which reads it in words.
#[repr(C, align(4))]
pub struct Spirv<T: ?Sized = [u8]>(pub T);

/// A compiled shader.
pub struct Shader {
    /// Its path in glsl/. A shader that is compiled once per technique has the technique in front, and one that is
    /// compiled for several values has the value behind: `technique/avsm/resolve.comp`, `avsm/query/points.comp`,
    /// `technique/avsm/unpack.comp/4`.
    pub name: &'static str,
    /// The block of its push constants, `Name { type member; … }`; empty where it has none.
    pub push: &'static str,
    /// The words that Vulkan gets.
    pub spirv: &'static Spirv,
}

impl Shader {
    /// SPIR-V.
    pub fn words(&self) -> &'static [u32] {
        bytemuck::cast_slice(&self.spirv.0)
    }
}

impl std::fmt::Debug for Shader {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name)
    }
}
