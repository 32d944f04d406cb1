//! The image that compute passes paint into, in 32-bit floats: the picture itself, if the device can blend into 32-bit floats. Otherwise
//! the picture's format is half floats, so the drawn picture is copied to a 32-bit float image, and the painted one is copied back.

use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Format, Image, ImageUse, Kernel};
use crate::shaders::{painter as shaders, set};
use crate::shading::Renderer;

/// Pixels per side of a workgroup.
const BLOCK: u32 = 8;

/// The image, and the z of the meshes in front of which casters are painted.
pub(in crate::shading) struct Canvas {
    pub(in crate::shading) bindings: Bindings,
    /// The image to paint into.
    pub(super) colors: Image,
    copies: Option<Copies>,
    size: [u32; 2],
}

/// Copies between a half-float image and a 32-bit float image.
struct Copies {
    floats: Image,
    widen: Kernel,
    narrow: Kernel,
}

impl Copies {
    fn new(context: &Context, color: &Image) -> Result<Self> {
        let format = Format::R32G32B32A32_SFLOAT;
        let floats = Image::new(context, "picture.floats", format, color.size(), ImageUse::Storage)?;
        let widening = set::PainterWidened { halves: color, floats: &floats }.bind(context, "painter.widened")?;
        let narrowing = set::PainterNarrowed { floats: &floats, halves: color }.bind(context, "painter.narrowed")?;
        let kernel = |shader, set| Kernel::compute(context, shader, &[set], &Constants::new());
        Ok(Self { widen: kernel(&shaders::WIDEN, &widening)?, narrow: kernel(&shaders::NARROW, &narrowing)?, floats })
    }
}

impl Canvas {
    pub(in crate::shading) fn new(renderer: &Renderer) -> Result<Self> {
        let (context, color) = (&renderer.context, &renderer.targets.color);
        let has_halves = renderer.targets.format != Format::R32G32B32A32_SFLOAT;
        let copies = if has_halves { Some(Copies::new(context, color)?) } else { None };
        let colors = copies.as_ref().map_or(color, |copies| &copies.floats);
        let bindings =
            set::PainterPicture { distances: &renderer.targets.distance, colors }.bind(context, "painter.picture")?;
        Ok(Self { bindings, colors: colors.clone(), copies, size: color.size() })
    }

    /// Returns a dispatch with one thread per pixel, 8 × 8 per workgroup.
    pub(in crate::shading) fn groups(&self) -> [u32; 3] {
        let [x, y] = self.size.map(|side| side.div_ceil(BLOCK));
        [x, y, 1]
    }

    /// Copies the drawn picture into the canvas, if they are separate images.
    pub(in crate::shading) fn begin(&self, commands: &mut Commands) {
        let Some(copies) = &self.copies else { return };
        commands.pass("painter.widen", |pass| pass.dispatch(&copies.widen, &(), self.groups()));
    }

    /// Copies the painted picture back, if they are separate images.
    pub(in crate::shading) fn end(&self, commands: &mut Commands) {
        let Some(copies) = &self.copies else { return };
        commands.pass("painter.narrow", |pass| pass.dispatch(&copies.narrow, &(), self.groups()));
    }
}
