//! The images of a picture: the color that is drawn into, and the surfaces of the meshes.

use crate::Result;
use crate::gpu::{Bindings, Context, Format, Image, ImageUse};
use crate::shaders::set;

/// Images of one size, and sets of the images that shaders read.
pub(super) struct PictureTargets {
    /// The picture.
    pub color: Image,
    /// The format of `color`: 32-bit or half floats.
    pub format: Format,
    pub depth: Image,
    pub albedo: Image,
    pub normal: Image,
    /// z along the camera's view.
    pub distance: Image,
    /// Albedo, normal and z, as textures.
    pub surfaces: Bindings,
    /// z alone.
    pub distances: Bindings,
}

impl PictureTargets {
    pub fn new(context: &Context, size: [u32; 2]) -> Result<Self> {
        // Devices need not support blending into 32-bit floats. All can blend into half floats, which are precise to
        // about a thousandth.
        let format =
            if context.features().float32_blend { Format::R32G32B32A32_SFLOAT } else { Format::R16G16B16A16_SFLOAT };
        let image = |name, format, usage| Image::new(context, name, format, size, usage);
        let color = image("picture.color", format, ImageUse::StoredColor)?;
        let depth = image("picture.depth", Format::D32_SFLOAT, ImageUse::Depth)?;
        let albedo = image("picture.albedo", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let normal = image("picture.normal", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let distance = image("picture.distance", Format::R32_SFLOAT, ImageUse::StoredColor)?;
        let surfaces = set::PictureSurfaces { albedos: &albedo, normals: &normal, distances: &distance };
        let distances = set::PictureDistances { distances: &distance };
        Ok(Self {
            surfaces: surfaces.bind(context, "picture.buffers")?,
            distances: distances.bind(context, "picture.distances")?,
            color,
            format,
            depth,
            albedo,
            normal,
            distance,
        })
    }
}
