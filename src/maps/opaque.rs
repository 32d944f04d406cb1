//! The depth maps of the opaque casters, shared by all techniques with maps.

use super::opaque_compute::OpaqueCompute;
use super::opaque_raster::OpaqueRaster;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Format, Image, ImageUse};
use crate::scene::{Moved, Projection, Resolution, View};
use crate::shaders::constant::{ALPHA_FIRST, ALPHA_TEST, OPAQUE_STEP};
use crate::world::World;
use crate::{Error, Result};
use std::ops::Range;

/// Texels per side of an opaque map, if there are meshes.
pub const OPAQUE_SIZE: u32 = 1024;

/// [`OpaqueMaps::normal_bias`] for bilinear weights, which span two texels. Twin: NORMAL_BIAS.
const NORMAL_BIAS: f32 = 0.3;

/// Step of the grid to which the coarsest rasterizer snaps vertices, in texels.
const COARSEST_SNAP: f64 = 0.0625;

/// Minimum error bound for the rounding of a stored depth and of the look-up's projection together, as a fraction of the light's range.
const DEPTH_ROUNDING: f64 = 1e-5;

/// Error bound for the rounding of a stored depth alone, as a fraction of the light's range.
const STORED_ROUNDING: f64 = 4e-6;

/// Returns the error bound for the rounding of a z, in world units, at the farthest point that the view sees. It exceeds `DEPTH_ROUNDING`
/// if a light is far from the origin, or if a light sees level ground from straight above, so that the range of its view is a thousandth of
/// its distance. Twin: stored_depth in glsl/maps/stored.glsl.
fn rounding(view: &View) -> f64 {
    let (across, far) = (1.0 / f64::from(view.scale_x.min(view.scale_y)), f64::from(view.far));
    let distance = match view.projection() {
        Projection::Parallel => (2.0 * across * across + far * far).sqrt(),
        Projection::Perspective => far * (1.0 + 2.0 * across * across).sqrt(),
    };
    let coordinates: f64 = view.origin.iter().map(|c| f64::from(c.abs())).sum();
    1.2e-7 * (coordinates + 3f64.sqrt() * distance) + 7.5e-7 * distance
}

/// How opaque maps are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpaqueWay {
    /// By the device's rasterizer, with one draw per map.
    Raster,
    /// By compute shaders with integer arithmetic, all maps at once: bit-identical on every device.
    Compute,
}

/// What alpha of triangles means to opaque maps. A map whose texels are larger than a texture's may read a smaller level of the texture, of
/// the shares that block light ([`crate::world`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlphaTest {
    /// Holes are cut out at full resolution: a texel holds no triangle whose alpha is below the cutoff at the texel's centre.
    Cut,
    /// By levels of the texture, each with the threshold at which it blocks as much light as at full resolution.
    Coverage,
    /// By levels of the texture, whose shares are the probabilities that a texel holds the triangle.
    Hash,
    /// Triangles are taken whole, as by a map that knows no alpha: holes are filled, and glass blocks all light.
    Whole,
}

/// Settings of opaque maps, and of look-ups in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpaqueMaps {
    /// Texels per side of a map, if there are meshes.
    pub size: u32,
    /// D32_SFLOAT or D16_UNORM.
    pub format: Format,
    /// Largest distance between a texel's centre and a point that is compared with the texel, in texels across and down.
    pub reach: f32,
    /// Distance that a surface point is moved along its normal, as a fraction of a texel's extent along the normal. Twin:
    /// NORMAL_BIAS in glsl/maps/opaque.glsl.
    pub normal_bias: f32,
    /// Number of maps per light, each half as wide as the previous one. More than 1 only for directional lights, in a
    /// world with a camera.
    pub cascades: u32,
    /// What alpha of triangles means.
    pub alpha: AlphaTest,
    /// How the maps are drawn; `None` chooses the best way on this device.
    pub way: Option<OpaqueWay>,
}

impl OpaqueMaps {
    /// The settings of the opaque maps shared by techniques that have their own maps. glsl/maps/opaque.glsl weights
    /// four texels of these bilinearly.
    pub const SHARED: Self = Self {
        size: OPAQUE_SIZE,
        format: Format::D32_SFLOAT,
        reach: 1.0,
        normal_bias: NORMAL_BIAS,
        cascades: 1,
        alpha: AlphaTest::Cut,
        way: None,
    };

    /// Returns the shared settings, drawn in the given way.
    pub fn shared(way: Option<OpaqueWay>) -> Self {
        Self { way, ..Self::SHARED }
    }

    /// Returns how the maps are drawn on this device, unless `way` decides: in compute on a GPU. The rasterizer draws
    /// maps with 16-bit depths, which compute cannot, and maps on software devices, where it was measured to be faster.
    fn way(self, context: &Context) -> OpaqueWay {
        let drawn = self.format == Format::D16_UNORM || context.features().is_software();
        let best = if drawn { OpaqueWay::Raster } else { OpaqueWay::Compute };
        self.way.unwrap_or(best)
    }

    /// Returns the step between two depths that the format can hold, as a fraction of the light's range; 0 for floats,
    /// whose step counts as rounding.
    fn step(self) -> f32 {
        if self.format == Format::D16_UNORM { 1.0 / 65535.0 } else { 0.0 }
    }

    /// Returns the resolution of a map with the view `view`. A look-up reads texels whose centres are at most `reach` texels away. The
    /// depth in a texel may belong to a point off the texel's centre, by up to one step of the rasterizer's grid.
    pub fn resolution(self, view: View) -> Resolution {
        let (off, range) = (rounding(&view), f64::from(view.far - view.near));
        // The stored depth is raised by the error bound on rounding, and the actual rounding error may add as much again. Likewise, the
        // format's step counts twice.
        let depth = DEPTH_ROUNDING.max(STORED_ROUNDING + 2.0 * off / range) + 2.0 * f64::from(self.step());
        let moved = Moved { across: self.normal_bias.into(), least_world: 2.0 * off, ..Moved::default() };
        let reach_texels = f64::from(self.reach) + COARSEST_SNAP;
        Resolution { reach_texels, snap_texels: COARSEST_SNAP, moved, depth, ..Resolution::exact(view) }
    }
}

/// The passes that draw the maps.
enum DepthPass {
    Raster(OpaqueRaster),
    Compute(OpaqueCompute),
}

/// The maps of all lights and the passes that draw them.
pub(super) struct Opaque {
    image: Image,
    drawn: DepthPass,
    /// Width and height of one map, in texels.
    size: [u32; 2],
}

/// Creates the image of the opaque maps: depths in the range of each map's `opaque` view, 1 where there is nothing. In a scene without
/// meshes, each map is one texel. The maps are stacked. If the device has no image with that many rows, the remaining maps go into further
/// columns.
///
/// # Errors
/// [`Error::Refused`] if the device has no such image, or too little memory in total, or if compute is asked to draw
/// 16-bit depths.
pub(super) fn image(context: &Context, maps: OpaqueMaps, size: [u32; 2], count: u32) -> Result<Image> {
    let (way, narrow) = (maps.way(context), maps.format == Format::D16_UNORM);
    if way == OpaqueWay::Compute && narrow {
        return Err(Error::Refused("depths of 32 bits (opaque=raster draws those of 16)".into()));
    }
    let limit = context.features().max_image_dimension_2d;
    let rows = (limit / size[1]).clamp(1, count);
    let columns = count.div_ceil(rows);
    let what = format!("for {count} opaque maps of {} × {} texels", size[0], size[1]);
    if columns.saturating_mul(size[0]) > limit {
        let area = u64::from(count) * u64::from(size[0]) * u64::from(size[1]);
        let side = area.isqrt();
        return Err(Error::Refused(
            format!("maxImageDimension2D of more than {side} {what} (this device has {limit})").into(),
        ));
    }
    let all = [columns * size[0], rows * size[1]];
    let texel_bytes = if narrow { 2 } else { 4 };
    let (bytes, memory) = (texel_bytes * all.map(u64::from).iter().product::<u64>(), context.features().memory_bytes);
    if bytes > memory {
        return Err(Error::Refused(format!("{bytes} bytes of memory {what} (this device has {memory})").into()));
    }
    match way {
        OpaqueWay::Raster => Image::new(context, "maps.opaque", maps.format, all, ImageUse::Depth),
        OpaqueWay::Compute => Image::new(context, "maps.opaque", Format::R32_UINT, all, ImageUse::FloatBits),
    }
}

impl Opaque {
    /// `constants` are the world's. `size` is the size of one map, and `count` the number of maps. With `culls`, some maps may not see all
    /// meshes.
    pub(super) fn new(
        context: &Context,
        image: Image,
        scene: &Bindings,
        (maps, constants): (OpaqueMaps, &Constants),
        size: [u32; 2],
        (count, culls): (u32, bool),
    ) -> Result<Self> {
        let constants = constants.clone().set(OPAQUE_STEP, maps.step());
        let constants = match maps.alpha {
            AlphaTest::Cut => constants,
            AlphaTest::Coverage => constants.set(ALPHA_TEST, 1),
            AlphaTest::Hash => constants.set(ALPHA_TEST, 2),
            AlphaTest::Whole => constants.set(ALPHA_FIRST, 0),
        };
        let drawn = match maps.way(context) {
            OpaqueWay::Raster => {
                DepthPass::Raster(OpaqueRaster::new(context, scene, maps.format, &constants, (count, culls))?)
            }
            OpaqueWay::Compute => {
                DepthPass::Compute(OpaqueCompute::new(context, &image, scene, &constants, [size[0], size[1], count])?)
            }
        };
        Ok(Self { image, drawn, size })
    }

    pub(super) fn image(&self) -> &Image {
        &self.image
    }

    pub(super) fn way(&self) -> OpaqueWay {
        match self.drawn {
            DepthPass::Raster(_) => OpaqueWay::Raster,
            DepthPass::Compute(_) => OpaqueWay::Compute,
        }
    }

    /// Draws the meshes into `maps`, as their lights see them; other maps are unchanged. Records no pass in a world
    /// without room for meshes.
    pub(super) fn record(&mut self, commands: &mut Commands, world: &World, maps: &[Range<u32>]) {
        if world.triangle_capacity() == 0 {
            return;
        }
        let triangles = world.triangle_count();
        match &mut self.drawn {
            DepthPass::Compute(compute) => compute.record(commands, self.size, triangles, maps),
            DepthPass::Raster(raster) => raster.record(commands, &self.image, self.size, triangles, maps),
        }
    }

    /// Ends frame `frame`: returns whether a buffer grew, so that the build must run again.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        match &mut self.drawn {
            DepthPass::Raster(_) => Ok(false),
            DepthPass::Compute(compute) => compute.settle(frame),
        }
    }

    pub(super) fn bytes_transient(&self) -> u64 {
        match &self.drawn {
            DepthPass::Raster(raster) => raster.draws().map_or(0, Buffer::bytes),
            DepthPass::Compute(compute) => compute.bytes_transient(),
        }
    }

    pub(super) fn draws(&self) -> Option<&Buffer> {
        match &self.drawn {
            DepthPass::Raster(raster) => raster.draws(),
            DepthPass::Compute(_) => None,
        }
    }
}
