//! Turns pictures in linear light into the bytes that the window shows, which equal those that `gobo render` writes.

use super::state::Show;
use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Image, Kernel, Memory, push_struct};
use crate::scene::Picture;
use crate::shaders::{set, view as shaders};

push_struct! {
    /// Twin: PresentPush in glsl/view/present.comp.
    pub struct PresentPush {
        width: u32,
        height: u32,
        show: u32,
        wipe: u32,
        gain: u32,
        sources: u32,
        blue_first: u32,
    }
}

/// The source of a picture. Twins: the bits of glsl/view/present.comp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The image of the picture.
    Image = 0,
    /// Values written by the host.
    Values = 1,
    /// No picture.
    Nobody = 2,
}

/// Number of columns and rows of pictures in the view of A and B next to the truth. Twins: COLUMNS and ROWS.
pub const PANELS: [u32; 2] = [3, 2];

/// Which picture is shown, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    pub show: Show,
    /// First column that shows B.
    pub wipe: u32,
    pub gain: u32,
    /// Sources of A, B and the truth.
    pub sources: [Source; 3],
    pub blue_first: bool,
}

/// Computes the window's bytes from a pair of pictures.
pub struct Present {
    kernel: Kernel<PresentPush>,
    size: [u32; 2],
    /// Values of the reference (three floats per pixel) or of a slice (one float per pixel), or bytes that the host painted.
    values: Buffer,
    shown: Buffer,
}

impl Present {
    /// Creates the pass for pictures A and B, with `size` pixels of output: the size of a picture, or of all panels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, a: &Image, b: &Image, size: [u32; 2]) -> Result<Self> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let values = Buffer::zeroed(context, "view.values", 12 * pixels)?;
        let shown = Buffer::new(context, "view.shown", 4 * pixels, Memory::Device)?;
        let levels = Buffer::with_data(context, "view.levels", &levels())?;
        let bindings =
            set::ViewPresent { first_picture: a, second_picture: b, levels: &levels, values: &values, shown: &shown }
                .bind(context, "view.present")?;
        let constants = crate::gpu::Constants::new();
        let kernel = Kernel::compute(context, &shaders::PRESENT, &[&bindings], &constants)?;
        Ok(Self { kernel, size, values, shown })
    }

    /// Returns the values of the host or of a slice.
    pub fn values(&self) -> &Buffer {
        &self.values
    }

    /// Returns the window's bytes: four per pixel, rows from the top.
    pub fn shown(&self) -> &Buffer {
        &self.shown
    }

    /// Records the pass.
    pub fn record(&self, commands: &mut Commands, is: Shown) {
        let [width, height] = self.size;
        let push = PresentPush {
            width,
            height,
            show: is.show as u32,
            wipe: is.wipe,
            gain: is.gain,
            sources: (0..).zip(is.sources).map(|(i, source)| (source as u32) << (2 * i)).sum(),
            blue_first: is.blue_first.into(),
        };
        let groups = [width.div_ceil(8), height.div_ceil(8), 1];
        commands.pass("view.present", |pass| pass.dispatch(&self.kernel, &push, groups));
    }
}

/// Returns the byte that `gobo render` writes for a value.
fn byte(value: f32) -> u8 {
    Picture { width: 1, height: 1, pixels: vec![[value; 3]] }.to_srgb8()[0]
}

/// Returns, for each byte, the smallest value that is shown as this byte. Each is found by bisection over float bits, since non-negative
/// floats sort like their bits.
fn levels() -> [f32; 256] {
    let least = |byte_wanted: usize| {
        let (mut below, mut reached) = (0, 1f32.to_bits());
        while reached - below > 1 {
            let middle = below + (reached - below) / 2;
            let has = usize::from(byte(f32::from_bits(middle))) >= byte_wanted;
            *(if has { &mut reached } else { &mut below }) = middle;
        }
        f32::from_bits(reached)
    };
    std::array::from_fn(|i| if i == 0 { f32::NEG_INFINITY } else { least(i) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Twin: level in glsl/view/present.comp.
    fn level(levels: &[f32; 256], value: f32) -> u8 {
        let mut at = 0;
        for step in [128, 64, 32, 16, 8, 4, 2, 1] {
            at += if value >= levels[at + step] { step } else { 0 };
        }
        at as u8
    }

    /// Tests numbers near each level, where rounding could make a difference, and other numbers.
    #[test]
    fn levels_are_the_bytes_of_files() {
        let levels = levels();
        for least in &levels[1..] {
            let bits = least.to_bits();
            for value in (bits.saturating_sub(300)..bits + 300).map(f32::from_bits) {
                assert_eq!(level(&levels, value), byte(value), "{value}");
            }
        }
        for value in [0.0, -0.0, -1.0, 1.0, 2.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, 1e-45] {
            assert_eq!(level(&levels, value), byte(value), "{value}");
        }
        proptest!(|(value in -0.1f32..1.2)| prop_assert_eq!(level(&levels, value), byte(value)));
    }
}
