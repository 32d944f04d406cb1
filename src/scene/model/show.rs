//! Settings of presentation pictures: samples per pixel and exposure. Measured pictures have neither.

use crate::{Error, Result};

/// The allowed numbers of samples per pixel, each with its grid of columns and rows.
const SAMPLES: [(u32, [u32; 2]); 4] = [(1, [1, 1]), (4, [2, 2]), (8, [4, 2]), (16, [4, 4])];

/// How samples are turned into a presentation picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Show {
    /// Columns and rows of a pixel's samples, all with the same weight.
    pub grid: [u32; 2],
    /// Exposure in stops: brightness is multiplied by 2^`stops`.
    pub stops: f32,
}

impl Show {
    /// Creates settings with 1, 4, 8 or 16 samples per pixel.
    ///
    /// # Errors
    /// [`Error::Input`] for any other number of samples, or stops outside −20 to 20.
    pub fn new(samples: u32, stops: f32) -> Result<Self> {
        let Some((_, grid)) = SAMPLES.into_iter().find(|(count, _)| *count == samples) else {
            return Err(Error::input(
                format!("{samples} samples"),
                "pixels are not divided so",
                "choose 1, 4, 8 or 16",
            ));
        };
        if !(-20.0..=20.0).contains(&stops) {
            let way_out = "choose a number from -20 to 20";
            return Err(Error::input(format!("an exposure of {stops} stops"), "nothing would be seen", way_out));
        }
        Ok(Self { grid, stops })
    }

    /// Returns the size of the picture that has one pixel per sample.
    pub fn sampled(&self, size: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|i| size[i] * self.grid[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_as_many_as_asked_for() {
        for samples in [1, 4, 8, 16] {
            let grid = Show::new(samples, 0.0).expect("a grid").grid;
            assert_eq!(grid[0] * grid[1], samples);
        }
        for samples in [0, 2, 3, 32] {
            assert!(Show::new(samples, 0.0).is_err());
        }
        assert!(Show::new(4, f32::NAN).is_err() && Show::new(4, 21.0).is_err() && Show::new(4, -1.5).is_ok());
    }
}
