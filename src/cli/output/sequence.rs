//! Consecutive pictures, as files and as an animation.

use crate::report::{write_png, write_whole};
use crate::{Error, Result};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, Rgba, RgbaImage};
use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Duration of a frame of the animation, in milliseconds.
const FRAME_MS: u32 = 80;

/// Writes one picture, FILE.png, or several, FILE-00.png, FILE-01.png, …, with an animation, FILE.gif.
pub struct Sequence {
    out: PathBuf,
    frames: u32,
    done: u32,
    animation: Option<GifEncoder<Bytes>>,
    /// The animation's bytes so far; written to a file after the last frame.
    gif: Bytes,
}

/// Bytes that an encoder writes and that can be read in the meantime.
#[derive(Clone, Default)]
struct Bytes(Rc<RefCell<Vec<u8>>>);

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Sequence {
    /// Creates a sequence of `frames` pictures.
    pub fn new(out: &Path, frames: u32) -> Self {
        Self { out: out.to_path_buf(), frames, done: 0, animation: None, gif: Bytes::default() }
    }

    /// Returns the names of all files written, for display: one file, or the first, the last and the animation.
    pub fn names(&self) -> String {
        if self.frames == 1 {
            return self.out.display().to_string();
        }
        let [first, last] = [0, self.frames - 1].map(|frame| numbered(&self.out, frame, self.frames));
        format!("{} … {}, {}", first.display(), last.display(), self.animation_path().display())
    }

    fn animation_path(&self) -> PathBuf {
        self.out.with_extension("gif")
    }

    /// Adds the next picture, which has the same size as the previous ones. `rgb8` holds its rows, three bytes per
    /// pixel. The picture is on disk when this returns.
    ///
    /// # Errors
    /// [`Error::Output`], naming the file.
    pub fn add(&mut self, size: [u32; 2], rgb8: Vec<u8>) -> Result<()> {
        if self.frames == 1 {
            return write_png(&self.out, size, &rgb8);
        }
        write_png(&numbered(&self.out, self.done, self.frames), size, &rgb8)?;
        self.done += 1;
        let path = self.animation_path();
        let fail = |e: &dyn std::fmt::Display| Error::output(&path, e);
        if self.animation.is_none() {
            let mut encoder = GifEncoder::new_with_speed(self.gif.clone(), 10);
            encoder.set_repeat(Repeat::Infinite).map_err(|e| fail(&e))?;
            self.animation = Some(encoder);
        }
        let mut image = RgbaImage::new(size[0], size[1]);
        for (pixel, rgb) in image.pixels_mut().zip(rgb8.chunks_exact(3)) {
            *pixel = Rgba([rgb[0], rgb[1], rgb[2], 255]);
        }
        let frame = Frame::from_parts(image, 0, 0, Delay::from_numer_denom_ms(FRAME_MS, 1));
        self.animation.as_mut().map_or(Ok(()), |gif| gif.encode_frame(frame)).map_err(|e| fail(&e))?;
        if self.done < self.frames {
            return Ok(());
        }
        // Dropping the encoder writes the end of the animation.
        self.animation = None;
        write_whole(&path, &self.gif.0.borrow())
    }
}

/// Returns FILE-07.png, with as many digits as the last number needs.
fn numbered(path: &Path, frame: u32, frames: u32) -> PathBuf {
    let digits = (frames - 1).to_string().len();
    let stem = path.file_stem().map_or_else(|| "gobo".into(), |s| s.to_string_lossy());
    path.with_file_name(format!("{stem}-{frame:0digits$}.png"))
}
