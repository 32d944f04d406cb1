//! Consecutive pictures, as files and as an animation.

use crate::report::{write_png, write_whole};
use crate::{Error, Result};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, Rgba, RgbaImage};
use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A frame of an animation, milliseconds.
const FRAME_MS: u32 = 80;

/// One picture, FILE.png; or FILE-00.png, FILE-01.png, … and FILE.gif.
pub struct Sequence {
    out: PathBuf,
    frames: u32,
    done: u32,
    animation: Option<GifEncoder<Bytes>>,
    /// The frames encoded so far; a file once the last is there.
    gif: Bytes,
}

/// Bytes that grow in one place while another looks on.
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
    /// A sequence of so many pictures.
    pub fn new(out: &Path, frames: u32) -> Self {
        Self { out: out.to_path_buf(), frames, done: 0, animation: None, gif: Bytes::default() }
    }

    /// All files that are written, for people to read: one file, or the first, the last and the animation.
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

    /// The next picture, of as many pixels as those before: rows of three bytes per pixel. It is on the disk when this returns.
    ///
    /// # Errors
    /// [`Error::Output`] names the file.
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
        // Its end is written as it goes.
        self.animation = None;
        write_whole(&path, &self.gif.0.borrow())
    }
}

/// FILE-07.png, with as many digits as the last needs.
fn numbered(path: &Path, frame: u32, frames: u32) -> PathBuf {
    let digits = (frames - 1).to_string().len();
    let stem = path.file_stem().map_or_else(|| "gobo".into(), |s| s.to_string_lossy());
    path.with_file_name(format!("{stem}-{frame:0digits$}.png"))
}
