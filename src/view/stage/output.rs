//! What the window shows of a stage: the combined pictures of A and B, slices, steps and the reference.

use super::super::lit::Lit;
use super::super::present::{Present, Shown, Source};
use super::super::state::{Show, Side, State};
use super::{Pane, Stage, has_reference, is_lost};
use crate::gpu::{Buffer, Commands, Format, Image, ImageUse, Memory, ReadBack};
use crate::query::Slice;
use crate::report::StepRange;
use crate::scene::Light;
use crate::shading::StepsKernel;
use crate::{Error, Result};

/// Step counts of look-ups, on their way to the host.
pub(super) struct Counting {
    read: ReadBack,
    pixels: usize,
    frame: u64,
}

/// Contents of the values in [`Present`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Values {
    Nothing,
    Reference,
    /// Visibility of this light at this depth.
    Slice(usize, f32),
    Steps,
}

/// Data derived from the pictures of A and B.
pub(super) struct Output {
    pub present: Option<Present>,
    pub values: Values,
    pub counting: Option<Counting>,
    /// What the window's bytes show; `None` if they are out of date.
    pub shown: Option<Shown>,
}

impl Output {
    pub const NOTHING: Self = Self { present: None, values: Values::Nothing, counting: None, shown: None };

    /// Sets the kind of values, which makes the window's bytes out of date.
    pub fn set_values(&mut self, values: Values) {
        (self.values, self.shown) = (values, None);
    }
}

impl Stage {
    /// Records the pass that computes the window's bytes, if they have changed.
    pub(super) fn show(&mut self, commands: &mut Commands, state: &State, blue_first: bool) -> Result<()> {
        if self.output.present.is_none() {
            let none = Image::new(&self.context, "view.none", Format::R8G8B8A8_UNORM, [1; 2], ImageUse::Storage)?;
            let image = |i: usize| self.panes[i].lit().map_or(&none, Lit::image);
            self.output.present = Some(Present::new(&self.context, image(0), image(1), self.area)?);
        }
        let is_answered = match state.show {
            Show::Slice | Show::Steps if self.unanswered.is_some() => false,
            Show::Slice => self.slice(commands, state.light, state.depth)?,
            Show::Steps => self.count_steps(commands)?,
            Show::Wireframe => self.unanswered.is_none(),
            Show::A | Show::B | Show::Wipe | Show::Difference | Show::Beside => self.fill_in(state)?,
        };
        let truth = if self.output.values == Values::Reference { Source::Values } else { Source::Nobody };
        let source = |i: usize| match (&state.sides[i], &self.panes[i]) {
            (Side::Reference, _) => truth,
            (Side::Technique(_), Pane::Open(_)) => Source::Image,
            _ => Source::Nobody,
        };
        let is = Shown {
            // A side without a result is shown as an empty picture.
            show: if is_answered { state.show } else { Show::A },
            wipe: (state.wipe * f64::from(self.size[0])).round() as u32,
            gain: state.gain,
            sources: if is_answered { [source(0), source(1), truth] } else { [Source::Nobody; 3] },
            blue_first,
        };
        let Output { present, shown, .. } = &mut self.output;
        if let Some(present) = present.as_ref().filter(|_| *shown != Some(is)) {
            present.record(commands, is);
            *shown = Some(is);
        }
        Ok(())
    }

    /// Copies new rows of the reference into the values.
    fn fill_in(&mut self, state: &State) -> Result<bool> {
        self.output.counting = None;
        let Some(present) = self.output.present.as_ref().filter(|_| has_reference(state)) else { return Ok(true) };
        if let Some(picture) = self.truth.news(self.output.values != Values::Reference) {
            present.values().write(&picture.pixels)?;
            self.output.set_values(Values::Reference);
        }
        Ok(true)
    }

    /// Queries A for a slice, once A's maps are built. Returns whether the values hold the slice.
    fn slice(&mut self, commands: &mut Commands, light: usize, depth: f32) -> Result<bool> {
        if self.output.values == Values::Slice(light, depth) {
            return Ok(true);
        }
        let (Some(lit), Some(present)) = (self.panes[0].lit(), &self.output.present) else { return Ok(false) };
        if !lit.is_current(&self.world) {
            return Ok(false);
        }
        let lights = self.world.all_lights();
        let first = lights.iter().take(light).map(Light::map_count).sum::<usize>();
        let Some(view) =
            lit.technique.inspect().maps().get(first).filter(|_| light < lights.len()).map(|map| map.caster_view)
        else {
            let name = lit.spec.entry.name;
            let error = match lit.technique.inspect().maps().is_empty() {
                true => Error::input(name, "it has no maps to slice", "choose one that has"),
                false => Error::input(format!("light {light}"), "there is no such light", "choose another"),
            };
            self.refuse(Show::Slice, &error);
            return Ok(false);
        };
        let size = [self.size[0].min(self.size[1]); 2];
        let slice = Slice::new(&self.context, light, &view, &lit.technique.answer(), depth, size)?;
        slice.record(commands);
        let bytes = slice.buffer().bytes();
        commands.pass("view.copy", |pass| pass.copy(slice.buffer(), present.values(), bytes));
        self.output.set_values(Values::Slice(light, depth));
        Ok(true)
    }

    /// Makes A count its steps, once A is built. Returns whether the values hold the steps.
    fn count_steps(&mut self, commands: &mut Commands) -> Result<bool> {
        if self.output.values == Values::Steps || self.output.counting.is_some() {
            return Ok(self.output.values == Values::Steps);
        }
        let Some(lit) = self.panes[0].lit_mut().filter(|lit| lit.is_current(&self.world)) else { return Ok(false) };
        if lit.steps.is_none() {
            match lit.renderer().steps_kernel(&lit.technique.answer()) {
                Ok(kernel) => lit.steps = Some(kernel),
                Err(error) if is_lost(&error) => return Err(error),
                Err(error) => {
                    self.refuse(Show::Steps, &error);
                    return Ok(false);
                }
            }
        }
        let Some(kernel) = &lit.steps else { return Ok(false) };
        lit.renderer().record_steps(commands, kernel);
        let pixels = self.size[0] as usize * self.size[1] as usize;
        let copy = Buffer::new(&self.context, "view.steps", 4 * pixels as u64, Memory::Device)?;
        let read = ReadBack::new(&self.context, "view.steps", 4 * pixels as u64)?;
        commands.pass("view.copy", |pass| pass.copy_image(kernel.image(), &copy));
        commands.read_back(&copy, &read);
        self.output.counting = Some(Counting { read, pixels, frame: commands.frame() });
        Ok(false)
    }

    /// Colors the steps that a frame counted, once that frame is complete.
    pub(super) fn paint_steps(&mut self, over: u64) -> Result<()> {
        let Some(counting) = self.output.counting.take_if(|counting| counting.frame <= over) else { return Ok(()) };
        let (Some(present), Some(counts)) =
            (&self.output.present, counting.read.read::<f32>(counting.frame, counting.pixels)?)
        else {
            return Ok(());
        };
        let counts: Vec<_> = counts.into_iter().map(StepsKernel::count).collect();
        self.steps = StepRange::of(std::slice::from_ref(&counts));
        let painted = StepRange::paint(self.steps, &counts);
        let packed = |rgb: &[u8]| u32::from_le_bytes([rgb[0], rgb[1], rgb[2], 0]);
        present.values().write(&painted.chunks_exact(3).map(packed).collect::<Vec<_>>())?;
        self.output.set_values(Values::Steps);
        Ok(())
    }
}
