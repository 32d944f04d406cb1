//! The depth maps of the opaque casters, shared by all techniques with maps.

use super::stacked;
use crate::Result;
use crate::gpu::{
    Bindings, Commands, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Target, push_struct,
};
use crate::shaders;
use crate::world::World;

/// Texels a side of an opaque map where there are meshes.
pub const OPAQUE_SIZE: u32 = 1024;

push_struct! {
    /// Twin: MapPush.
    pub(super) struct MapPush { map: u32 }
}

/// The maps of all lights and the pass that draws them.
pub(super) struct Opaque {
    image: Image,
    kernel: Kernel<MapPush>,
    /// Of one map.
    size: [u32; 2],
}

/// D32: depth in the range of a map's `opaque` view, 1 where there is nothing; 1×1 a map without meshes.
pub(super) fn image(context: &Context, size: [u32; 2], count: u32) -> Result<Image> {
    let stacked = stacked(context, "maps.opaque", size, count)?;
    Image::new(context, "maps.opaque", Format::D32_SFLOAT, stacked, ImageUse::Depth)
}

impl Opaque {
    pub(super) fn new(context: &Context, image: Image, scene: &Bindings, size: [u32; 2]) -> Result<Self> {
        let state = Graphics {
            vertex: &shaders::maps::OPAQUE_VERT,
            fragment: &shaders::maps::OPAQUE_FRAG,
            colors: &[],
            depth: true,
        };
        let kernel = Kernel::graphics(context, &state, &[scene], &Constants::new())?;
        Ok(Self { image, kernel, size })
    }

    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    /// Draws the meshes as the lights see them. No pass where there are none.
    pub(super) fn record(&self, commands: &mut Commands, world: &World, count: u32) {
        let vertices = 3 * world.triangle_count();
        if vertices == 0 {
            return;
        }
        commands.pass("maps.opaque", |pass| {
            let target = Target { image: &self.image, clear: Some([1.0; 4]) };
            pass.render(self.image.size(), &[], Some(target), |draw| {
                for map in 0..count {
                    draw.rows(map * self.size[1], self.size);
                    draw.draw(&self.kernel, &MapPush { map }, vertices, 1);
                }
            });
        });
    }
}
