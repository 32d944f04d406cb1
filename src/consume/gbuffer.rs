//! The mesh surface at each pixel of a picture. One pass draws the number of the nearest triangle; a second finds albedo, normal and depth
//! from that number, once per pixel however many triangles overlap. Source: Burns and Hunt 2013, The visibility buffer. Twin:
//! reference::twin::gbuffer.

use super::Renderer;
use super::shown::Smooth;
use crate::Result;
use crate::gpu::{Blend, Commands, Constants, Format, Graphics, Image, ImageUse, Kernel, Target};
use crate::shaders::{consume as shaders, set};
use crate::world::CameraPush;

/// Pixels per side of a workgroup.
const BLOCK: u32 = 8;

/// Finds the surface at each pixel, in two passes.
pub(super) struct GBuffer {
    /// The number of each pixel's triangle, counted from 1; 0 where there is sky.
    pub(super) numbers: Image,
    visible: Kernel<CameraPush>,
    gbuffer: Kernel<CameraPush>,
    /// Replaces flat normals by smooth ones, in pictures for people to look at only.
    smooth: Option<Smooth>,
}

impl GBuffer {
    pub(super) fn new(renderer: &Renderer) -> Result<Self> {
        let (context, scene, size) = (&renderer.context, &renderer.scene, renderer.color.size());
        let numbers = Image::new(context, "picture.numbers", Format::R32_UINT, size, ImageUse::Color)?;
        let seen = set::PictureSeen {
            numbers: &numbers,
            albedos: &renderer.albedo,
            normals: &renderer.normal,
            distances: &renderer.distance,
        };
        let seen = seen.bind(context, "picture.seen")?;
        let state = Graphics {
            vertex: &shaders::VISIBLE_VERT,
            fragment: &shaders::VISIBLE_FRAG,
            colors: &[(Format::R32_UINT, Blend::None)],
            depth: Some(Format::D32_SFLOAT),
        };
        let visible = Kernel::graphics(context, &state, &[scene], &Constants::new())?;
        let gbuffer = Kernel::compute(context, &shaders::GBUFFER, &[scene, &seen], &Constants::new())?;
        let corners = renderer.shown.as_ref().and_then(|shown| shown.normals.as_ref());
        let smooth = corners.map(|corners| Smooth::new(renderer, &numbers, corners)).transpose()?;
        Ok(Self { numbers, visible, gbuffer, smooth })
    }

    /// Records both passes.
    pub(super) fn record(&self, commands: &mut Commands, renderer: &Renderer) {
        let push = CameraPush::of(&renderer.camera);
        self.visible(commands, renderer, &push);
        self.gbuffer(commands, &push);
        if let Some(smooth) = &self.smooth {
            smooth.record(commands, &push);
        }
    }

    fn visible(&self, commands: &mut Commands, renderer: &Renderer, push: &CameraPush) {
        commands.pass("consume.visible", |pass| {
            let numbers = [Target { image: &self.numbers, clear: Some([0.0; 4]) }];
            let depth = Target { image: &renderer.depth, clear: Some([1.0; 4]) };
            pass.render(self.numbers.size(), &numbers, Some(depth), |draw| {
                draw.draw(&self.visible, push, renderer.triangle_vertices, 1);
            });
        });
    }

    fn gbuffer(&self, commands: &mut Commands, push: &CameraPush) {
        let [x, y] = self.numbers.size().map(|side| side.div_ceil(BLOCK));
        commands.pass("consume.gbuffer", |pass| pass.dispatch(&self.gbuffer, push, [x, y, 1]));
    }
}
