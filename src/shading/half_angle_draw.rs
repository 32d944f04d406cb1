//! Casters that a technique paints slice by slice, each lit by the light that earlier slices let through ([`Painter`]).
//! Twin: reference::twin::half_angle.

use super::Renderer;
use crate::Result;
use crate::gpu::{Blend, Commands, Constants, Graphics, Image, ImageUse, Kernel, Target};
use crate::shaders::{set, shading as shaders};
use crate::technique::{Answer, Painter};
use std::sync::Arc;

/// Draws the casters slice by slice.
pub(super) struct HalfAngleDraw {
    painter: Arc<Painter>,
    /// Draws slices from far to near, over the picture.
    over: Kernel,
    /// Draws slices from near to far, blended behind the picture in `seen`.
    under: Kernel,
    /// The camera's picture of the casters alone.
    seen: Image,
    behind: Kernel,
}

impl HalfAngleDraw {
    /// `answer` and `painter` must belong to the same technique.
    pub(super) fn new(renderer: &Renderer, answer: &Answer, painter: &Arc<Painter>) -> Result<Self> {
        let (context, format) = (&renderer.context, renderer.targets.format);
        let seen = Image::new(context, "picture.seen", format, renderer.targets.color.size(), ImageUse::Color)?;
        let sets = [&renderer.scene.set, &painter.look_up, &renderer.targets.distances, &painter.sorted];
        let constants = renderer.with_kinds(answer.constants.clone());
        let casters = |blend| {
            let fragment = shaders::CASTER_FRAG.of(answer.folder);
            let state = Graphics { vertex: &shaders::SLICED_VERT, fragment, colors: &[(format, blend)], depth: None };
            Kernel::graphics(context, &state, &sets, &constants)
        };
        let all = set::SlicedSeen { seen: &seen }.bind(context, "picture.seen")?;
        let colors = [(format, Blend::Over)];
        let (vertex, fragment) = (&shaders::FULLSCREEN_VERT, &shaders::BEHIND_FRAG);
        let behind = Graphics { vertex, fragment, colors: &colors, depth: None };
        Ok(Self {
            painter: painter.clone(),
            over: casters(Blend::Over)?,
            under: casters(Blend::Under)?,
            behind: Kernel::graphics(context, &behind, &[&all], &Constants::new())?,
            seen,
        })
    }

    pub(super) fn record(&self, commands: &mut Commands, renderer: &Renderer) {
        let count = renderer.scene.caster_count;
        if count == 0 {
            return;
        }
        self.painter.sort(commands, &renderer.camera, count);
        let near_to_far = self.painter.near_to_far(&renderer.camera);
        self.sliced(commands, renderer, near_to_far);
        if near_to_far {
            self.behind(commands, renderer);
        }
    }

    fn sliced(&self, commands: &mut Commands, renderer: &Renderer, near_to_far: bool) {
        let (image, kernel) =
            if near_to_far { (&self.seen, &self.under) } else { (&renderer.targets.color, &self.over) };
        let size = image.size();
        let mut clear = near_to_far.then_some([0.0; 4]);
        commands.pass("shading.sliced", |pass| {
            self.painter.light(pass, 0..0);
            for places in self.painter.slices(renderer.scene.caster_count) {
                pass.barrier();
                pass.render(size, &[Target { image, clear: clear.take() }], None, |draw| {
                    draw.draw_part(kernel, &(), 6 * places.start..6 * places.end);
                });
                pass.barrier();
                self.painter.light(pass, places);
            }
        });
    }

    fn behind(&self, commands: &mut Commands, renderer: &Renderer) {
        commands.pass("shading.behind", |pass| {
            let colors = [Target { image: &renderer.targets.color, clear: None }];
            pass.render(renderer.targets.color.size(), &colors, None, |draw| draw.draw(&self.behind, &(), 3, 1));
        });
    }
}
