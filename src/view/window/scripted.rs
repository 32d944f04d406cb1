//! Effects of a script's lines on the window.

use super::input::event_of;
use super::{Open, View};
use crate::Result;
use crate::bench::host_bytes;
use crate::view::host::heap_bytes;
use crate::view::script::{Script, Step};
use crate::view::truth::Counts;
use crate::view::{camera, panel};
use std::time::{Duration, Instant};
use winit::dpi::PhysicalSize;

/// How long a script waits for the window to get its size.
const GRACE: Duration = Duration::from_secs(3);

impl View {
    /// Runs the script's next lines, until one has to wait.
    pub(super) fn script(&mut self) -> Result<()> {
        let Some(mut open) = self.open.take() else { return Ok(()) };
        let outcome = self.script_on(&mut open);
        self.open = Some(open);
        outcome
    }

    fn script_on(&mut self, open: &mut Open) -> Result<()> {
        loop {
            let wants = self.options.size;
            let fits =
                self.forced.is_some() || panel::picture(&self.state, open.size, open.window.scale_factor()) == wants;
            if !fits && self.began.elapsed() < GRACE
                || self.frames_left > 0
                || self.files.are_due()
                || self.frames == 0
                || self.until.is_some_and(|until| Instant::now() < until)
            {
                return Ok(());
            }
            let Some(step) = self.script.as_mut().and_then(Script::next) else { return Ok(()) };
            self.until = None;
            // A line that only waits needs no frame.
            self.wants |= !matches!(step, Step::Wait(_));
            // The panel shows neither the camera nor a count of frames.
            self.touched |= !matches!(step, Step::Wait(_) | Step::Frames(_) | Step::Orbit(..) | Step::Report);
            match step {
                Step::Set(key, value) => self.state.set(&key, &value)?,
                Step::Key(key) => self.key(&key, open),
                Step::Orbit(right, up) => {
                    if let Some(stage) = &open.stage {
                        camera::orbit(&mut self.state, &stage.base().camera, right, up);
                    }
                }
                Step::Wait(time) => self.until = Some(Instant::now() + time),
                Step::Frames(count) => self.frames_left = count,
                Step::Screenshot(path) => self.files.shoot(Some(path)),
                Step::Gif(path, ms) => self.files.film(&path, ms),
                Step::Curve(path) => {
                    self.state.curve = true;
                    self.files.plot(path);
                }
                Step::Resize([0, _] | [_, 0]) => (self.forced, self.frames_left) = (Some([0; 2]), 2),
                Step::Resize(size) => {
                    (self.forced, self.options.size, self.began) = (None, size, Instant::now());
                    let panel = panel::pixels(&self.state, open.window.scale_factor());
                    // If the size applies at once, no event reports it.
                    let is = open.window.request_inner_size(PhysicalSize::new(size[0] + panel, size[1]));
                    open.size = is.map_or(open.size, Into::into);
                }
                Step::Drop(file) => self.state.choose(&file),
                Step::Input(input) => self.event(&event_of(input), open),
                Step::Report => {
                    let (frames, bytes) = (self.frames, open.host.allocated_bytes());
                    let known = [(host_bytes(), "resident"), (heap_bytes(), "of the heap in use")];
                    let known =
                        known.into_iter().filter_map(|(bytes, what)| Some(format!(", {} bytes {what}", bytes?)));
                    let host: String = known.collect();
                    let stage = open.stage.as_ref();
                    let (builds, truth) = stage.map(|stage| (stage.builds(), stage.truth_counts())).unwrap_or_default();
                    let Counts { begun, finished, dropped } = truth;
                    let truth = format!("reference: {begun} begun, {finished} finished, {dropped} dropped");
                    let pace = std::mem::take(&mut self.pace).text();
                    let seen = open.rays.seen();
                    let seen: String = seen.iter().map(|(name, seen)| format!(", {name}: {}", seen.words())).collect();
                    println!(
                        "{frames} frames, {bytes} bytes of device memory{host}, {builds} builds, {truth}{seen}{pace}"
                    );
                }
                Step::Quit => {
                    self.is_over = true;
                    self.files.finish()?;
                }
            }
            if self.is_over {
                return Ok(());
            }
        }
    }
}
