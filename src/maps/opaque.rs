//! The depth maps of the opaque casters, shared by all techniques with maps.

use crate::gpu::{
    Bindings, Commands, Constants, Context, Format, Graphics, Image, ImageUse, Kernel, Target, push_struct,
};
use crate::scene::{Resolution, View};
use crate::shaders;
use crate::shaders::constant::SNAP;
use crate::world::World;
use crate::{Error, Result};

/// Texels a side of an opaque map where there are meshes.
pub const OPAQUE_SIZE: u32 = 1024;

push_struct! {
    /// Twin: MapPush in glsl/maps/opaque.vert and glsl/maps/opaque.frag.
    pub(super) struct MapPush {
        map: u32,
        /// Where it stands.
        corner: [u32; 2],
    }
}

/// How far a look-up of glsl/maps/opaque.glsl feels a surface, texels: it weighs texels whose centres are up to one texel
/// away, and each of them has its depth moved by what its surface's changes over one texel and a step of the coarsest
/// rasterizer, a 16th.
const REACH_TEXELS: f64 = 2.0625;

/// What the rounding of a stored depth and of the look-up's projection is, of the light's range.
const DEPTH_ROUNDING: f64 = 1e-5;

/// Of an opaque map of that view.
pub fn opaque_resolution(view: View) -> Resolution {
    Resolution { view, reach_texels: REACH_TEXELS, depth: DEPTH_ROUNDING }
}

/// The maps of all lights and the pass that draws them.
pub(super) struct Opaque {
    image: Image,
    kernel: Kernel<MapPush>,
    /// Of one map.
    size: [u32; 2],
}

/// D32: depth in the range of a map's `opaque` view, 1 where there is nothing; 1×1 a map without meshes. Maps stand one
/// above the other, and where the device has no images of so many rows, in further columns beside them.
pub(super) fn image(context: &Context, size: [u32; 2], count: u32) -> Result<Image> {
    let limit = context.features().max_image_dimension_2d;
    let rows = (limit / size[1]).clamp(1, count);
    let columns = count.div_ceil(rows);
    if columns.saturating_mul(size[0]) > limit {
        return Err(Error::Gpu {
            operation: "create image",
            name: "maps.opaque".into(),
            cause: format!("{count} maps of {} × {} texels, and this device takes {limit} a side", size[0], size[1]),
            way_out: "use fewer lights".into(),
        });
    }
    let all = [columns * size[0], rows * size[1]];
    Image::new(context, "maps.opaque", Format::D32_SFLOAT, all, ImageUse::Depth)
}

/// The upper left texel of a map of `size` among all. Twin: opaque_corner in glsl/maps/opaque.glsl.
pub fn opaque_corner(image: &Image, size: [u32; 2], map: u32) -> [u32; 2] {
    let rows = (image.size()[1] / size[1]).max(1);
    [map / rows * size[0], map % rows * size[1]]
}

impl Opaque {
    pub(super) fn new(context: &Context, image: Image, scene: &Bindings, size: [u32; 2]) -> Result<Self> {
        let state = Graphics {
            vertex: &shaders::maps::OPAQUE_VERT,
            fragment: &shaders::maps::OPAQUE_FRAG,
            colors: &[],
            depth: true,
        };
        let snap = (-(context.features().sub_pixel_precision_bits as f32)).exp2();
        let kernel = Kernel::graphics(context, &state, &[scene], &Constants::new().set(SNAP, snap))?;
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
                    let corner = opaque_corner(&self.image, self.size, map);
                    draw.area(corner, self.size);
                    draw.draw(&self.kernel, &MapPush { map, corner }, vertices, 1);
                }
            });
        });
    }
}
