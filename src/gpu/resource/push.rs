//! Push constants as structs that are checked against the shaders: a kernel is not created if they differ.

use bytemuck::Pod;

/// A struct of push constants, declared with [`push_struct!`](crate::gpu::push_struct).
pub trait Push: Pod {
    /// Returns the block as GLSL declares it, `Name { type member; … }`.
    fn block() -> String;
}

/// No push constants.
impl Push for () {
    fn block() -> String {
        String::new()
    }
}

/// A type that can be a member of a push constant block.
pub trait PushMember {
    /// The type's name in GLSL.
    const GLSL: &'static str;
}

impl PushMember for u32 {
    const GLSL: &'static str = "uint";
}

impl PushMember for f32 {
    const GLSL: &'static str = "float";
}

impl PushMember for [u32; 2] {
    const GLSL: &'static str = "uvec2";
}

impl PushMember for [f32; 3] {
    const GLSL: &'static str = "vec3";
}

/// Declares a struct of push constants: the twin of a GLSL block with the same name and members.
#[macro_export]
#[doc(hidden)]
macro_rules! __push_struct {
    ($(#[$meta:meta])* $visibility:vis struct $name:ident { $($(#[$member_meta:meta])* $member:ident: $type:ty),+ $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
        $visibility struct $name { $($(#[$member_meta])* pub $member: $type),+ }

        impl $crate::gpu::Push for $name {
            fn block() -> String {
                let members = [$(format!("{} {};", <$type as $crate::gpu::PushMember>::GLSL, stringify!($member))),+];
                format!("{} {{ {} }}", stringify!($name), members.join(" "))
            }
        }
    };
}

pub use crate::__push_struct as push_struct;
