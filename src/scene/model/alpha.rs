//! Alpha of meshes: where a surface has holes, or lets a share of the light through.

use crate::scene::Scene;
use std::sync::Arc;

/// Alpha of a mesh. At a point of the mesh it is the texture's alpha, interpolated bilinearly at full resolution, times the factor,
/// interpolated between the triangle's corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Alpha {
    /// What a surface of this alpha does to light.
    pub mode: AlphaMode,
    /// A factor per vertex, in [0, 1]. In glTF it is the alpha of the base color's factor times that of the vertex color.
    pub factors: Vec<f32>,
    /// A place in the texture per vertex: (0, 0) is the upper left corner of the texture, (1, 1) its lower right corner. Finite; empty
    /// without a texture.
    pub uvs: Vec<[f32; 2]>,
    /// The texture; without one, its alpha counts as 1.
    pub texture: Option<Arc<AlphaTexture>>,
    /// Factors of a see-through surface's optical depth, −ln(1 − alpha), for red, green and blue light: in [0, 1], not all 0. Surfaces of
    /// a color need lights that are listed once per color ([`Scene::with_inks`]).
    pub extinction_ratio: [f32; 3],
}

impl Alpha {
    /// Returns the same alpha everywhere, for all colors, on a mesh of `vertices` vertices.
    pub fn constant(mode: AlphaMode, alpha: f32, vertices: usize) -> Self {
        Self { mode, factors: vec![alpha; vertices], uvs: Vec::new(), texture: None, extinction_ratio: Scene::GREY }
    }
}

/// What a surface with alpha does to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// A point of the surface blocks all light if its alpha is at least this cutoff, in (0, 1]. Elsewhere the surface has a hole. glTF:
    /// `MASK`.
    Cut(f32),
    /// A ray that crosses the surface keeps 1 − alpha of its light. glTF: `BLEND`, and `KHR_materials_transmission`.
    SeeThrough,
}

/// The alpha channel of a texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaTexture {
    /// Width and height in texels, each from 1 to [`AlphaTexture::MOST_SIDE`].
    pub size: [u32; 2],
    /// How the texture continues beyond its borders, across and down.
    pub wrap: [Wrap; 2],
    /// Alpha of each texel, 255 for 1, row by row from the top.
    pub texels: Vec<u8>,
}

/// How a texture continues beyond its borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// Every other repetition is mirrored.
    Mirror,
    /// The texels at the border continue.
    Clamp,
}

impl AlphaTexture {
    /// The largest width and height, in texels.
    pub const MOST_SIDE: u32 = 1 << 14;
}
