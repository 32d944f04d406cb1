//! The mesh surface at each pixel of a picture. One pass draws the number of the nearest triangle; a second one derives albedo, normal and
//! depth from that number, once per pixel, no matter how many triangles overlap. Source: Burns and Hunt 2013, The visibility buffer. Twin:
//! reference::twin::gbuffer.

use super::display::Smooth;
use super::{PainterKind, Renderer, lock};
use crate::Result;
use crate::gpu::{Blend, Commands, Constants, Format, Graphics, Image, ImageUse, Kernel, Target};
use crate::maps::SeenTriangles;
use crate::shaders::constant::SEEN_BY_COMPUTE;
use crate::shaders::{set, shading as shaders};
use crate::world::CameraPush;
use std::sync::{Arc, Mutex};

/// Pixels per side of a workgroup.
const BLOCK: u32 = 8;

/// The number of the triangle that each pixel sees.
enum Visible {
    /// In an image, counted from 1; 0 for sky.
    Drawn(Image, Kernel<CameraPush>),
    Computed(Arc<Mutex<SeenTriangles>>),
}

/// Finds the surface at each pixel, in two passes.
pub(super) struct GBuffer {
    size: [u32; 2],
    visible: Visible,
    gbuffer: Kernel<CameraPush>,
    /// Replaces flat normals with smooth ones, only in pictures for display.
    smooth: Option<Smooth>,
}

impl GBuffer {
    pub(super) fn new(renderer: &Renderer) -> Result<Self> {
        let (context, scene, size) = (&renderer.context, &renderer.scene.set, renderer.targets.color.size());
        let is_computed = renderer.painter_kind == PainterKind::Compute;
        // Unused bindings still need an image.
        let sides = if is_computed { [1, 1] } else { size };
        let numbers = Image::new(context, "picture.numbers", Format::R32_UINT, sides, ImageUse::Color)?;
        let (visible, pixels) = if is_computed {
            let seen = renderer.seen_triangles()?;
            let pixels = lock(&seen).pixels.clone();
            (Visible::Computed(seen), pixels)
        } else {
            let state = Graphics {
                vertex: &shaders::VISIBLE_VERT,
                fragment: &shaders::VISIBLE_FRAG,
                colors: &[(Format::R32_UINT, Blend::None)],
                depth: Some(Format::D32_SFLOAT),
            };
            let kernel = Kernel::graphics(context, &state, &[scene], &renderer.scene.constants)?;
            (Visible::Drawn(numbers.clone(), kernel), renderer.scene.lights.clone())
        };
        let seen = set::PictureSeen {
            numbers: &numbers,
            albedos: &renderer.targets.albedo,
            normals: &renderer.targets.normal,
            distances: &renderer.targets.distance,
            seen: &pixels,
        };
        let seen = seen.bind(context, "picture.seen")?;
        let constants = Constants::new().set(SEEN_BY_COMPUTE, is_computed);
        let gbuffer = Kernel::compute(context, &shaders::GBUFFER, &[scene, &seen], &constants)?;
        let corners = renderer.display.as_ref().and_then(|shown| shown.normals.as_ref());
        let smooth = corners.map(|corners| Smooth::new(renderer, (&numbers, corners), &pixels, &constants));
        Ok(Self { size, visible, gbuffer, smooth: smooth.transpose()? })
    }

    /// Returns the number of each pixel's triangle, counted from 1, row by row; 0 for sky.
    pub(super) fn numbers(&self) -> Result<Vec<u32>> {
        match &self.visible {
            Visible::Drawn(numbers, _) => numbers.read(),
            Visible::Computed(seen) => lock(seen).numbers(),
        }
    }

    /// Records both passes.
    pub(super) fn record(&self, commands: &mut Commands, renderer: &Renderer) {
        let push = CameraPush::of(&renderer.camera);
        match &self.visible {
            Visible::Drawn(numbers, kernel) => Self::visible(commands, renderer, (numbers, kernel), &push),
            Visible::Computed(seen) => lock(seen).record(commands, renderer.scene.triangle_vertices / 3),
        }
        self.gbuffer(commands, &push);
        if let Some(smooth) = &self.smooth {
            smooth.record(commands, &push);
        }
    }

    fn visible(
        commands: &mut Commands,
        renderer: &Renderer,
        (numbers, kernel): (&Image, &Kernel<CameraPush>),
        push: &CameraPush,
    ) {
        commands.pass("shading.visible", |pass| {
            let targets = [Target { image: numbers, clear: Some([0.0; 4]) }];
            let depth = Target { image: &renderer.targets.depth, clear: Some([1.0; 4]) };
            pass.render(numbers.size(), &targets, Some(depth), |draw| {
                draw.draw(kernel, push, renderer.scene.triangle_vertices, 1);
            });
        });
    }

    fn gbuffer(&self, commands: &mut Commands, push: &CameraPush) {
        let [x, y] = self.size.map(|side| side.div_ceil(BLOCK));
        commands.pass("shading.gbuffer", |pass| pass.dispatch(&self.gbuffer, push, [x, y, 1]));
    }
}
