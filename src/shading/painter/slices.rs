//! Half-angle slicing painted by compute passes: all casters are listed once per frame, by tile and in the order of the slices, and each
//! slice paints its part of every list. The technique draws the light's buffer between slices. Twin: reference::twin::half_angle.

use super::Canvas;
use super::lists::{ListSource, Lists, WHOLE};
use crate::Result;
use crate::gpu::{Bindings, Commands, Format, Image, ImageUse, Kernel, push_struct};
use crate::shaders::constant::UNDER;
use crate::shaders::{painter as shaders, set};
use crate::shading::Renderer;
use crate::technique::{Answer, Painter};
use std::cell::RefCell;
use std::sync::Arc;

push_struct! {
    /// Twin: SlicedPush in glsl/shading/painter/slice.comp.
    struct SlicedPush {
        first: u32,
        last: u32,
    }
}

/// Paints casters slice by slice.
pub(in crate::shading) struct Slices {
    painter: Arc<Painter>,
    canvas: Arc<Canvas>,
    lists: RefCell<Lists>,
    /// Draws slices from far to near, over the picture.
    over: Kernel<SlicedPush>,
    /// Draws slices from near to far, behind the earlier ones in `seen`.
    under: Kernel<SlicedPush>,
    seen: Image,
    behind: Kernel,
}

impl Slices {
    /// `answer` and `painter` must belong to the same technique.
    pub(in crate::shading) fn new(renderer: &Renderer, answer: &Answer, painter: &Arc<Painter>) -> Result<Self> {
        let (context, canvas) = (&renderer.context, renderer.canvas()?);
        let seen = Image::new(
            context,
            "picture.seen",
            Format::R32G32B32A32_SFLOAT,
            renderer.targets.color.size(),
            ImageUse::Storage,
        )?;
        let listed = ListSource {
            order: painter.order(),
            room: (painter.order().bytes() / 4) as u32,
            least: WHOLE,
            by_place: true,
        };
        let lists = Lists::new(renderer, &listed)?;
        let alone = set::PainterPicture { distances: &renderer.targets.distance, colors: &seen };
        let alone = alone.bind(context, "painter.alone")?;
        let constants = renderer.with_kinds(answer.constants.clone());
        let kernel = |picture: &Bindings, under| {
            let sets = [&renderer.scene.set, &painter.look_up, picture, &lists.slices];
            Kernel::compute(context, &shaders::SLICE, &sets, &constants.clone().set(UNDER, under))
        };
        let all = set::PainterBehind { seen: &seen, colors: &canvas.colors }.bind(context, "painter.behind")?;
        Ok(Self {
            over: kernel(&canvas.bindings, false)?,
            under: kernel(&alone, true)?,
            behind: Kernel::compute(context, &shaders::BEHIND, &[&all], &crate::gpu::Constants::new())?,
            painter: painter.clone(),
            lists: RefCell::new(lists),
            canvas,
            seen,
        })
    }

    pub(in crate::shading) fn record(&self, commands: &mut Commands, renderer: &Renderer) {
        let count = renderer.scene.caster_count;
        if count == 0 {
            return;
        }
        self.painter.sort(commands, &renderer.camera, count);
        let near_to_far = self.painter.near_to_far(&renderer.camera);
        self.canvas.begin(commands);
        commands.pass("painter.slices", |pass| {
            if near_to_far {
                pass.clear_volume(&self.seen, 0.0);
            }
            self.painter.light(pass, 0..0);
        });
        let kernel = if near_to_far { &self.under } else { &self.over };
        let lists = self.lists.borrow();
        for run in lists.runs(&(0..count), count) {
            lists.record(commands, &run, run.start == 0);
            commands.pass("painter.slices", |pass| {
                for slice in self.painter.slices(count) {
                    let (first, last) = (slice.start.max(run.start), slice.end.min(run.end));
                    if first >= last {
                        continue;
                    }
                    lists.per_part(pass, kernel, &SlicedPush { first, last });
                    // A slice that spans two runs is drawn for the light once it is complete.
                    if last == slice.end {
                        pass.barrier();
                        self.painter.light(pass, slice);
                    }
                    pass.barrier();
                }
            });
        }
        if near_to_far {
            let groups = self.canvas.groups();
            commands.pass("painter.behind", |pass| pass.dispatch(&self.behind, &(), groups));
        }
        self.canvas.end(commands);
    }

    /// Same as [`super::Painter::make_room`].
    pub(in crate::shading) fn make_room(&self, renderer: &Renderer) -> Result<()> {
        let count = renderer.scene.caster_count;
        loop {
            let mut frame = 0;
            renderer.context.submit(|commands| {
                frame = commands.frame();
                self.painter.sort(commands, &renderer.camera, count);
                let lists = self.lists.borrow();
                for run in lists.runs(&(0..count), count) {
                    lists.measure(commands, &run, run.start == 0);
                }
            })?;
            if !self.settle(frame)? {
                return Ok(());
            }
        }
    }

    /// See [`Renderer::settle`].
    pub(in crate::shading) fn settle(&self, frame: u64) -> Result<bool> {
        self.lists.borrow_mut().settle(frame)
    }

    /// Returns the size of the lists, in bytes.
    pub(in crate::shading) fn bytes(&self) -> u64 {
        self.lists.borrow().bytes()
    }
}
