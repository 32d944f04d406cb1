//! Pictures with captions and scales below them, and grids of such pictures.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of letters, in pixels.
const LETTERS: RasterHeight = RasterHeight::Size16;

/// Distance between lines of text, in pixels.
const LINE: u32 = 20;

/// Margin around text and between pictures, in pixels.
const GAP: u32 = 6;

/// Background and text colors, sRGB.
const PAPER: [u8; 3] = [250, 250, 248];
const INK: [u8; 3] = [28, 30, 36];

/// A picture to compose on: three bytes per pixel, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// sRGB.
    pub rgb8: Vec<u8>,
}

/// A picture and the lines of text below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// sRGB, three bytes per pixel, rows from the top.
    pub rgb8: Vec<u8>,
    /// Lines of text, from the top.
    pub lines: Vec<String>,
}

impl Paper {
    /// Creates an empty paper of that size.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, rgb8: PAPER.repeat(size[0] as usize * size[1] as usize) }
    }

    fn set(&mut self, [x, y]: [u32; 2], color: [u8; 3]) {
        if x < self.size[0] && y < self.size[1] {
            let at = 3 * (y as usize * self.size[0] as usize + x as usize);
            self.rgb8[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Copies a picture to the paper, with its upper left corner at `[x, y]`.
    pub fn paste(&mut self, [x, y]: [u32; 2], width: u32, rgb8: &[u8]) {
        for (i, pixel) in (0..).zip(rgb8.chunks_exact(3)) {
            self.set([x + i % width, y + i / width], [pixel[0], pixel[1], pixel[2]]);
        }
    }

    /// Draws a line of text, with its upper left corner at `[x, y]`, cut off to fit into `room` pixels.
    pub fn write(&mut self, [x, y]: [u32; 2], room: u32, text: &str) {
        let wide = get_raster_width(FontWeight::Regular, LETTERS) as u32;
        let fits = (room / wide) as usize;
        let count = text.chars().count();
        let cut = text.chars().take(if count > fits { fits.saturating_sub(2) } else { count });
        let dots = if count > fits { ".." } else { "" };
        for (i, letter) in (0..).zip(cut.chain(dots.chars())) {
            let Some(raster) = get_raster(letter, FontWeight::Regular, LETTERS)
                .or_else(|| get_raster('?', FontWeight::Regular, LETTERS))
            else {
                continue;
            };
            for (row, line) in (0..).zip(raster.rows()) {
                for (column, share) in (0..).zip(line.iter()).filter(|(_, share)| **share > 0) {
                    let mixed = |i: usize| {
                        let share = u32::from(*share);
                        ((u32::from(INK[i]) * share + u32::from(PAPER[i]) * (255 - share)) / 255) as u8
                    };
                    self.set([x + i * wide + column, y + row], [0, 1, 2].map(mixed));
                }
            }
        }
    }
}

/// Returns the width of a line of text, in pixels.
fn written(text: &str) -> u32 {
    get_raster_width(FontWeight::Regular, LETTERS) as u32 * text.chars().count() as u32
}

/// Arranges pictures of one size in rows of `columns` pictures, each with its text below.
pub fn panels(panels: &[Panel], [width, height]: [u32; 2], columns: u32) -> Paper {
    let lines = panels.iter().map(|panel| panel.lines.len()).max().unwrap_or(0) as u32;
    let columns = columns.clamp(1, panels.len().max(1) as u32);
    let rows = (panels.len() as u32).div_ceil(columns);
    let below = if lines == 0 { 0 } else { lines * LINE + GAP };
    let place = |i: u32| [i % columns * (width + GAP), i / columns * (height + below + GAP)];
    let [across, down] = [columns * (width + GAP) - GAP, rows * (height + below + GAP) - GAP];
    let mut paper = Paper::new([across, down]);
    for (i, panel) in (0..).zip(panels) {
        let [x, y] = place(i);
        paper.paste([x, y], width, &panel.rgb8);
        for (row, line) in (0..).zip(&panel.lines) {
            paper.write([x + GAP, y + height + GAP / 2 + row * LINE], width - GAP.min(width), line);
        }
    }
    paper
}

/// Adds lines of text below a picture.
pub fn captioned(above: &Paper, lines: &[String]) -> Paper {
    let [width, height] = above.size;
    let mut paper = Paper::new([width, height + lines.len() as u32 * LINE + GAP]);
    paper.paste([0, 0], width, &above.rgb8);
    for (row, line) in (0..).zip(lines) {
        paper.write([GAP, height + row * LINE], width - GAP.min(width), line);
    }
    paper
}

/// Puts a color scale under a picture: colors from left to right for shares from 0 to 1, with labels below both ends and the middle.
pub fn with_scale(
    rgb8: &[u8],
    [width, height]: [u32; 2],
    color: impl Fn(f64) -> [u8; 3],
    [left, middle, right]: [&str; 3],
) -> Paper {
    const BAR: u32 = 12;
    let mut paper = Paper::new([width, height + 2 * GAP + BAR + LINE]);
    paper.paste([0, 0], width, rgb8);
    let long = width.saturating_sub(2 * GAP);
    for (x, y) in (0..long).flat_map(|x| (0..BAR).map(move |y| (x, y))) {
        paper.set([GAP + x, height + GAP + y], color(f64::from(x) / f64::from(long.max(2) - 1)));
    }
    let y = height + GAP + BAR + 2;
    let room = long.saturating_sub(written(left) + written(right) + 4 * GAP);
    paper.write([GAP, y], long, left);
    paper.write([(width - GAP).saturating_sub(written(right)), y], written(right), right);
    if written(middle) <= room {
        paper.write([(width - written(middle)) / 2, y], room, middle);
    }
    paper
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each picture must be unchanged in its place, with text below it and none above.
    #[test]
    fn pictures_stay_as_they_are() {
        let size = [60, 10];
        let panel = |grey: u8| Panel {
            rgb8: vec![grey; 3 * 600],
            lines: vec!["avsm".into(), "a line that is too long".into()],
        };
        let paper = panels(&[panel(10), panel(20), panel(30)], size, 2);
        let below = 2 * LINE + GAP;
        assert_eq!(paper.size, [2 * 60 + GAP, 2 * (10 + below) + GAP]);
        let pixel = |x: u32, y: u32| paper.rgb8[3 * (y * paper.size[0] + x) as usize];
        for (i, grey) in [10, 20, 30].into_iter().enumerate() {
            let (left, top) = (i as u32 % 2 * (60 + GAP), i as u32 / 2 * (10 + below + GAP));
            assert!((0..60).all(|x| (0..10).all(|y| pixel(left + x, top + y) == grey)));
            for line in 0..2 {
                let rows = top + 10 + GAP / 2 + line * LINE..top + 10 + GAP / 2 + (line + 1) * LINE;
                assert!(rows.clone().any(|y| (0..60).any(|x| pixel(left + x, y) < 128)), "words");
                assert!(rows.clone().all(|y| (60..60 + GAP).all(|x| i % 2 == 1 || pixel(x, y) == PAPER[0])), "within");
            }
        }
        // There is no fourth picture.
        assert_eq!(pixel(60 + GAP + 1, 10 + below + GAP + 1), PAPER[0]);
    }

    #[test]
    fn a_scale_has_its_colors_at_its_ends() {
        let color = |share: f64| [(255.0 * share).round() as u8, 0, 7];
        let paper = with_scale(&[9; 3 * 50 * 4], [50, 4], color, ["0", "", "9"]);
        let pixel = |x: u32, y: u32| &paper.rgb8[3 * (y * 50 + x) as usize..][..3];
        assert_eq!(pixel(GAP, 4 + GAP), [0, 0, 7]);
        assert_eq!(pixel(49 - GAP, 4 + GAP), [255, 0, 7]);
        assert_eq!(pixel(0, 0), [9; 3]);
        assert!((0..50).any(|x| (0..LINE).any(|y| pixel(x, 4 + GAP + 14 + y)[0] < 128)), "words");
    }
}
