//! Long pictures in parts: some rows per submission, so that none takes long. A driver that shows a screen, too, ends a submission that
//! takes seconds (2 on Windows by default), and the device is lost to the program. An H200 was seen to be lost in one of 8.9 s.

use super::Renderer;
use super::kernels::{Casters, Kernels, Meshes};
use crate::Result;
use crate::gpu::{Commands, PassTime, follow};
use std::ops::Range;
use std::time::{Duration, Instant};

/// How long a part is to take.
const PART: Duration = Duration::from_millis(250);

/// A picture that takes no longer is drawn in one submission from then on.
const SHORT: Duration = Duration::from_secs(1);

/// The first part is this share of the picture's rows, and no part has more than four times the rows of the one before.
const FIRST: u32 = 16;
const MORE: f64 = 4.0;

impl Renderer {
    /// Draws the next frame; it stays on the device. Returns the time of each pass, the casters' last. The first frame, and all where it
    /// takes a second or more, are drawn in several submissions, in which passes of the same name draw some rows each; not on a software
    /// device, where nothing waits for a picture.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn draw(&self, kernels: &Kernels) -> Result<Vec<PassTime>> {
        if kernels.is_short.get() || self.context.features().is_software() {
            return self.frame(kernels, |commands| self.casters(commands, kernels));
        }
        let began = Instant::now();
        let times = self.draw_in_parts(kernels, self.color.size()[1].div_ceil(FIRST))?;
        kernels.is_short.set(began.elapsed() < SHORT);
        Ok(times)
    }

    /// Draws the next frame in several submissions, the first of `rows` rows and the others of as many as should take a quarter of a
    /// second: the passes in which each fragment of a mesh or a caster asks for all light. The picture is the same, to the bit.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn draw_in_parts(&self, kernels: &Kernels, rows: u32) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let mut run = |record: &mut dyn FnMut(&mut Commands) -> Result<()>| {
            follow(&mut times, self.context.try_submit(record)?);
            Ok(())
        };
        let height = self.color.size()[1];
        if !matches!(kernels.meshes, Meshes::Forward(_)) {
            run(&mut |commands| self.surfaces(commands, kernels))?;
        }
        if kernels.asks_by_rows() {
            in_parts(height, rows, |part| {
                run(&mut |commands| {
                    self.lit(commands, kernels, &part);
                    Ok(())
                })
            })?;
        }
        run(&mut |commands| {
            self.backdrop(commands);
            self.sort(commands, kernels);
            Ok(())
        })?;
        match &kernels.casters {
            Casters::Fragment(channels) => in_parts(height, rows, |part| {
                run(&mut |commands| {
                    self.caster(commands, channels, kernels, &part);
                    Ok(())
                })
            })?,
            _ => run(&mut |commands| {
                self.paint(commands, kernels);
                Ok(())
            })?,
        }
        self.drawn(kernels);
        Ok(times)
    }
}

/// Calls `draw` with rows that follow each other, until there are `height`; `rows` of them first.
fn in_parts(height: u32, rows: u32, mut draw: impl FnMut(Range<u32>) -> Result<()>) -> Result<()> {
    let (mut rows, mut first) = (rows.max(1), 0);
    while first < height {
        let behind = height.min(first.saturating_add(rows));
        let began = Instant::now();
        draw(first..behind)?;
        rows = rows_next(behind - first, began.elapsed());
        first = behind;
    }
    Ok(())
}

/// How many rows should take a quarter of a second, where `rows` took so long.
fn rows_next(rows: u32, took: Duration) -> u32 {
    let more = (PART.as_secs_f64() / took.as_secs_f64().max(1e-9)).min(MORE);
    ((f64::from(rows) * more) as u32).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_rows_once() {
        for (height, rows) in [(1, 1), (360, 23), (7, 100), (5, 0), (3, u32::MAX)] {
            let mut parts = Vec::new();
            in_parts(height, rows, |part| {
                parts.push(part);
                Ok(())
            })
            .expect("drawn");
            assert_eq!((parts[0].start, parts[parts.len() - 1].end), (0, height));
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start), "{parts:?}");
        }
    }

    #[test]
    fn a_part_takes_a_quarter_of_a_second() {
        let of = |rows, ms| rows_next(rows, Duration::from_millis(ms));
        assert_eq!([of(20, 1), of(20, 125), of(20, 250), of(20, 2500), of(1, 9000)], [80, 40, 20, 2, 1]);
        assert_eq!(rows_next(20, Duration::ZERO), 80);
    }
}
