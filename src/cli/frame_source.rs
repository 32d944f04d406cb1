//! The scene in each frame, created on demand. A sequence of files has only two frames in memory: the one being drawn and the next, which a
//! thread reads.

use crate::Result;
use crate::animate::AnimatedScene;
use crate::cli::{MovingArgument, VplArgument};
use crate::gpu::Context;
use crate::scene::{Scene, SceneChange};

/// All frames of a scene.
pub(super) struct States<'a> {
    scene: AnimatedScene,
    /// Times of the frames; empty for the scene as it is.
    times_s: Vec<f64>,
    change: SceneChange,
    /// Replaces the scene's lights with virtual lights, once the device is open.
    pub lit: Option<(&'a VplArgument, &'a Context)>,
}

impl States<'_> {
    /// Creates `frames` frames of a moving scene, or a single frame of a static one.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if the scene does not move, or does not have one of the times.
    pub(super) fn new(scene: AnimatedScene, moving: &MovingArgument, frames: u32, change: SceneChange) -> Result<Self> {
        let times_s = moving.times(&scene, frames)?;
        Ok(Self { scene, times_s, change, lit: None })
    }

    /// Returns the number of frames, at least one.
    pub(super) fn len(&self) -> usize {
        self.times_s.len().max(1)
    }

    /// Returns one frame. The next one is read ahead, so frames are expected to be requested in order.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if its file cannot be read, or the changes do not fit it.
    pub(super) fn at(&self, frame: usize) -> Result<Scene> {
        let moved = self.times_s.get(frame).map(|time_s| self.scene.at(*time_s)).transpose()?;
        let mut state = self.change.of(moved.as_ref().unwrap_or(&self.scene.scene))?;
        if let Some((vpls, context)) = self.lit {
            vpls.light(context, std::slice::from_mut(&mut state))?;
        }
        Ok(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Span;
    use crate::scene::Field;
    use std::sync::Weak;

    /// Reads a sequence of three files more than twice, starting in the middle. Among the frames returned, only the last may still be in
    /// memory.
    #[test]
    fn one_frame_is_alive() {
        let files = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/vdb/ok-frame-#.vdb");
        let scene = AnimatedScene::load(files, 0.5 / 24.0).expect("a sequence");
        let before = scene.scene.volumes[0].held();
        let span = Span { from: 1.5 / 24.0, to: Some(7.5 / 24.0) };
        let change = SceneChange { eye: None, target: None, direction: None, extinction: 1.0 };
        let states = States::new(scene, &MovingArgument { moving: Some(span) }, 7, change).expect("it moves");
        let mut given: Vec<Weak<Field>> = Vec::new();
        for frame in 0..states.len() {
            let state = states.at(frame).expect("read");
            given.push(state.volumes[0].held());
            let alive = given.iter().filter(|field| field.strong_count() > 0).count();
            assert_eq!(alive, 1, "frame {frame}");
            // Frames differ: none of them is a retained copy of another.
            assert!(!given.iter().rev().skip(1).any(|other| other.ptr_eq(&given[frame])), "frame {frame}");
        }
        assert!(states.len() == 7 && before.strong_count() > 0, "the scene keeps the frame that it was loaded in");
    }
}
