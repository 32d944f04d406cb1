//! Files that the window writes: pictures, the curve under the pointer, and animations of the whole window.

use super::host::{Frame, Host};
use super::rays::Rays;
use super::stage::Stage;
use super::state::State;
use crate::gpu::{Buffer, Memory, ReadBack};
use crate::report::{write_png, write_whole};
use crate::{Error, Result};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, RgbaImage};
use std::path::{Path, PathBuf};

/// Number of frames after a change until the panel's layout is stable.
const SETTLED: u32 = 4;

/// A picture to write to a file.
struct Shot {
    path: PathBuf,
    /// Source of the picture, once it has been drawn: the copy for the host, the frame that made the copy, the picture's size, and the
    /// number of pixels per row of the copy.
    read: Option<(ReadBack, u64, [u32; 2], u32)>,
}

/// Pictures of the window for an animation, each with its duration in milliseconds.
struct Film {
    path: PathBuf,
    frames: Vec<(RgbaImage, u32)>,
}

/// The files to write.
#[derive(Default)]
pub struct Files {
    shot: Option<Shot>,
    plot: Option<PathBuf>,
    films: Vec<Film>,
    /// The animation that waits for a picture of the window: its index, the picture's duration in milliseconds, and the number of frames
    /// for which the window has been complete.
    filmed: Option<(usize, u32, u32)>,
}

impl Files {
    /// Requests a PNG of the picture; without a path, it gets an unused name.
    pub fn shoot(&mut self, path: Option<PathBuf>) {
        let mut names = (0..).map(|i| PathBuf::from(format!("gobo-view-{i:02}.png")));
        let free = |path: &PathBuf| !path.exists();
        let path = path.or_else(|| names.find(free)).unwrap_or_default();
        self.shot = Some(Shot { path, read: None });
    }

    /// Requests an SVG of the curve under the pointer.
    pub fn plot(&mut self, path: PathBuf) {
        self.plot = Some(path);
    }

    /// Requests the window as the next picture of an animation, shown for `ms` milliseconds.
    pub fn film(&mut self, path: &Path, ms: u32) {
        let known = self.films.iter().position(|film| film.path == path);
        let film = known.unwrap_or_else(|| {
            self.films.push(Film { path: path.into(), frames: Vec::new() });
            self.films.len() - 1
        });
        self.filmed = Some((film, ms, 0));
    }

    /// Whether any file is still to be written.
    pub fn are_due(&self) -> bool {
        self.shot.is_some() || self.plot.is_some() || self.filmed.is_some()
    }

    /// Drops copies that are on the device, before the device closes. Requests remain, and restart on the next device.
    pub fn forget_copies(&mut self) {
        if let Some(shot) = &mut self.shot {
            shot.read = None;
        }
        if let Some((.., whole)) = &mut self.filmed {
            *whole = 0;
        }
    }

    /// Whether the requests need further frames. `is_whole` tells whether the window shows its final picture.
    pub fn need_frames(&self, is_whole: bool) -> bool {
        self.shot.as_ref().is_some_and(|shot| is_whole || shot.read.is_some()) || self.filmed.is_some()
    }

    /// Records a copy of the picture for the host, once the picture is complete.
    pub fn read(&mut self, state: &State, stage: &Stage, host: &Host, frame: &Frame) -> Result<()> {
        let (Some(shot), Some(bytes)) = (&mut self.shot, stage.bytes()) else { return Ok(()) };
        if shot.read.is_none() && stage.is_whole(state) {
            let read = ReadBack::new(host.context(), "view.screenshot", bytes.bytes())?;
            host.record(frame, |commands| {
                commands.read_back(bytes, &read);
                Ok(())
            })?;
            shot.read = Some((read, frame.number, stage.pictured(state), stage.area()[0]));
        }
        Ok(())
    }

    /// Writes the picture that a frame copied, once that frame is complete.
    ///
    /// # Errors
    /// [`Error::Output`] names the file.
    pub fn save(&mut self, over: u64, blue_first: bool) -> Result<()> {
        let is_over = |shot: &mut Shot| shot.read.as_ref().is_some_and(|(_, frame, ..)| *frame <= over);
        let Some(Shot { path, read: Some((read, frame, [width, height], row)) }) = self.shot.take_if(is_over) else {
            return Ok(());
        };
        let pixels = read.read::<[u8; 4]>(frame, (row * height) as usize)?.unwrap_or_default();
        let rows = pixels.chunks_exact(row.max(1) as usize).flat_map(|pixels| &pixels[..width as usize]);
        let bytes: Vec<u8> = rows.flat_map(|pixel| rgb(*pixel, blue_first)).collect();
        write_png(&path, [width, height], &bytes)?;
        println!("{}", path.display());
        Ok(())
    }

    /// Writes the curve, once it is computed.
    ///
    /// # Errors
    /// [`Error::Input`] if there can be no curve; [`Error::Output`] names the file.
    pub fn save_plot(&mut self, rays: &Rays) -> Result<()> {
        let Some((answer, path)) = rays.answer().zip(self.plot.as_ref()) else { return Ok(()) };
        let found = answer
            .map_err(|cause| Error::input("the curve", cause, "point at another place, or choose another technique"))?;
        write_whole(path, found.svg()?.as_bytes())?;
        println!("{}", path.display());
        self.plot = None;
        Ok(())
    }

    /// Returns a buffer to copy the window to, if a picture of the window was requested and the window no longer changes.
    pub fn wanted(&mut self, host: &Host, is_whole: bool) -> Result<Option<Buffer>> {
        let Some((_, _, whole)) = &mut self.filmed else { return Ok(None) };
        *whole = if is_whole { *whole + 1 } else { 0 };
        if *whole < SETTLED {
            return Ok(None);
        }
        let bytes = host.window_bytes();
        if bytes == 0 {
            return Err(Error::Refused("a window whose images can be copied from, for a GIF".into()));
        }
        Buffer::new(host.context(), "view.film", bytes, Memory::Readback).map(Some)
    }

    /// Adds the window's `size` pixels, read from the buffer `window`, to the animation.
    pub fn add(&mut self, window: &Buffer, size: [u32; 2], blue_first: bool) -> Result<()> {
        let Some((film, ms, _)) = self.filmed.take() else { return Ok(()) };
        let pixels: Vec<[u8; 4]> = window.read((size[0] * size[1]) as usize)?;
        let bytes = pixels.into_iter().flat_map(|pixel| {
            let [r, g, b] = rgb(pixel, blue_first);
            [r, g, b, 255]
        });
        if let Some(image) = RgbaImage::from_raw(size[0], size[1], bytes.collect()) {
            self.films[film].frames.push((image, ms));
        }
        Ok(())
    }

    /// Writes the animations.
    ///
    /// # Errors
    /// [`Error::Output`] names the file.
    pub fn finish(&mut self) -> Result<()> {
        for Film { path, frames } in std::mem::take(&mut self.films) {
            let fail = |cause: image::ImageError| Error::output(&path, cause);
            let mut gif = Vec::new();
            let mut encoder = GifEncoder::new_with_speed(&mut gif, 10);
            encoder.set_repeat(Repeat::Infinite).map_err(fail)?;
            for (image, ms) in frames {
                let delay = Delay::from_numer_denom_ms(ms, 1);
                encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay)).map_err(fail)?;
            }
            // Dropping the encoder writes the end of the animation.
            drop(encoder);
            write_whole(&path, &gif)?;
            println!("{}", path.display());
        }
        Ok(())
    }
}

fn rgb([r, g, b, _]: [u8; 4], blue_first: bool) -> [u8; 3] {
    if blue_first { [b, g, r] } else { [r, g, b] }
}
