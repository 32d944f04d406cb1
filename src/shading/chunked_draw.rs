//! Slow pictures drawn in parts: each submission draws some of the casters, so that none takes long. A driver that also serves a display
//! kills a submission that takes seconds (2 on Windows by default), and the program loses the device. An H200 was seen to be lost in a
//! submission of 8.9 s. Parts of a few rows each would take nearly as long as all rows: few pixels leave a GPU idle.

use super::Renderer;
use super::kernels::{Casters, Kernels};
use crate::Result;
use crate::gpu::{Commands, PassTime, follow};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Target duration of a part.
const PART: Duration = Duration::from_millis(250);

/// A picture that takes no longer than this is drawn in one submission from then on.
const SHORT: Duration = Duration::from_secs(1);

/// Number of casters in the first part, and the largest growth from one part to the next.
const FIRST: u32 = 64;
const MORE: f64 = 4.0;

/// Number of runs of casters that one submission paints, if the lists are too small for all casters at once.
const RUNS: u32 = 8;

/// Up to this many casters are drawn in one submission.
const FEW: u32 = 1024;

impl Renderer {
    /// Draws the next frame, which stays on the device. Returns the time of each pass, with the casters' passes last. On a GPU, the first
    /// frame that `kernels` draw with more than 1,024 casters is drawn in several submissions, and so are later frames, until one takes
    /// less than a second: each pass `shading.caster` then draws some of the casters.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn draw(&self, kernels: &Kernels) -> Result<Vec<PassTime>> {
        self.make_room(kernels)?;
        let casters = self.blending.casters;
        let is_quick = kernels.is_short.get() || casters <= FEW || self.context.features().is_software();
        if is_quick && longest(kernels, casters) >= casters {
            return self.frame(kernels, |commands| self.casters(commands, kernels));
        }
        let began = Instant::now();
        let times = self.draw_in_parts(kernels, FIRST)?;
        kernels.is_short.set(began.elapsed() < SHORT);
        Ok(times)
    }

    /// Sorts the casters, then grows the lists of compute passes to the capacity that they need. Does nothing unless casters or the camera
    /// have moved since `kernels` last drew.
    fn make_room(&self, kernels: &Kernels) -> Result<()> {
        let moves = self.blending.moves();
        if kernels.has_room_for.get() == moves {
            return Ok(());
        }
        match &kernels.casters {
            Casters::Painted(painter) if self.blending.casters > 0 => {
                self.context.submit(|commands| self.sort(commands, kernels))?;
                painter.make_room(self)?;
                self.blending.forget();
            }
            Casters::PaintedSlices(slices) if self.scene.caster_count > 0 => slices.make_room(self)?,
            _ => {}
        }
        kernels.has_room_for.set(moves);
        Ok(())
    }

    /// Draws the next frame in several submissions, if casters look up light at each pixel: the first draws `casters` of them, and each
    /// later one as many as should take a quarter of a second. The picture is the same as with one submission.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn draw_in_parts(&self, kernels: &Kernels, casters: u32) -> Result<Vec<PassTime>> {
        let record = |commands: &mut Commands, part: &Range<u32>| match &kernels.casters {
            Casters::Fragment(channels) => self.caster(commands, channels, kernels, part),
            Casters::Painted(painter) => painter.record(commands, self, part),
            _ => {}
        };
        if !matches!(kernels.casters, Casters::Fragment(_) | Casters::Painted(_)) {
            return self.frame(kernels, |commands| self.casters(commands, kernels));
        }
        let mut times = self.frame(kernels, |commands| self.sort(commands, kernels))?;
        let all = self.blending.casters;
        in_parts([all, casters, longest(kernels, all)], |part| {
            follow(&mut times, self.context.submit(|commands| record(commands, &part))?);
            Ok(())
        })?;
        Ok(times)
    }
}

/// Returns the maximum number of casters per submission, limited by the maximum number of passes per submission.
fn longest(kernels: &Kernels, casters: u32) -> u32 {
    match &kernels.casters {
        Casters::Painted(painter) if painter.run_count() > RUNS => (casters / painter.run_count() * RUNS).max(1),
        _ => u32::MAX,
    }
}

/// Calls `draw` with consecutive ranges from 0 to `count`, the first of length `first`, and none longer than `most`. If `count` is 0,
/// `draw` is called once, with an empty range.
fn in_parts([count, first, most]: [u32; 3], mut draw: impl FnMut(Range<u32>) -> Result<()>) -> Result<()> {
    let (mut length, mut start) = (first.clamp(1, most), 0u32);
    loop {
        let end = count.min(start.saturating_add(length));
        let began = Instant::now();
        draw(start..end)?;
        if end == count {
            return Ok(());
        }
        length = next_length(end - start, began.elapsed()).min(most);
        start = end;
    }
}

/// Returns how many casters should take a quarter of a second, given that `length` casters took `took`.
fn next_length(length: u32, took: Duration) -> u32 {
    let more = (PART.as_secs_f64() / took.as_secs_f64().max(1e-9)).min(MORE);
    ((f64::from(length) * more) as u32).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_casters_once() {
        for (count, first) in [(0, 1), (1, 1), (360, 23), (7, 100), (5, 0), (3, u32::MAX)] {
            let mut parts = Vec::new();
            in_parts([count, first, 200], |part| {
                parts.push(part);
                Ok(())
            })
            .expect("drawn");
            assert_eq!((parts[0].start, parts[parts.len() - 1].end), (0, count));
            assert!(parts.iter().all(|part| part.len() <= 200));
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start && !pair[0].is_empty()), "{parts:?}");
        }
    }

    #[test]
    fn a_part_takes_a_quarter_of_a_second() {
        let of = |length, ms| next_length(length, Duration::from_millis(ms));
        assert_eq!([of(20, 1), of(20, 125), of(20, 250), of(20, 2500), of(1, 9000)], [80, 40, 20, 2, 1]);
        assert_eq!(next_length(20, Duration::ZERO), 80);
    }
}
