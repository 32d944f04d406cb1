//! A scene to compare, in each of its frames. Frames of a sequence of files are read when they are shown: only the first, the one being
//! shown and the next are in memory.

use crate::Result;
use crate::animate::{self, Animated, AnimatedScene};
use crate::bench::States;
use crate::scene::{Camera, Fountain, Scene};
use std::sync::Arc;

/// See the module documentation.
pub(super) struct Compared {
    /// Its states; only the first if the others are read on demand.
    pub states: Vec<Scene>,
    /// Times of these frames; empty if the scene is not to move.
    pub times_s: Vec<f64>,
    /// What moves the scene.
    animation: Option<Arc<dyn Animated>>,
    /// The camera of states read on demand; `None` if all are in memory.
    camera: Option<Turning>,
}

/// A camera that turns from frame to frame, if degrees are given.
#[derive(Clone, Copy)]
struct Turning {
    camera: Camera,
    step_degrees: Option<f64>,
}

impl Compared {
    /// Creates a scene with all states in memory, at least one.
    pub(super) fn held(states: Vec<Scene>, times_s: Vec<f64>, animation: Option<Arc<dyn Animated>>) -> Self {
        Self { states, times_s, animation, camera: None }
    }

    /// Creates a scene whose states are read from a sequence of files at these times.
    ///
    /// # Errors
    /// See [`Compared::at`].
    pub(super) fn read(scene: AnimatedScene, times_s: Vec<f64>, step_degrees: Option<f64>) -> Result<Self> {
        let AnimatedScene { scene, animation, .. } = scene;
        let camera = Some(Turning { camera: scene.camera, step_degrees });
        let mut compared = Self { states: vec![scene], times_s, animation, camera };
        compared.states = vec![compared.at(0)?];
        Ok(compared)
    }

    /// Returns the state in the first frame.
    pub(super) fn first(&self) -> &Scene {
        &self.states[0]
    }

    /// Returns the state in a frame of a sequence of files. The next one has also been read by the time this returns, so that no thread
    /// reads while something is timed.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a file cannot be read.
    pub(super) fn at(&self, frame: usize) -> Result<Scene> {
        let animation = self.animation.as_deref();
        let mut state = animate::moved(self.first(), animation, self.times_s[frame])?;
        if let Some(sequences) = animate::sequences(animation) {
            sequences.read_ahead();
        }
        if let Some(Turning { camera, step_degrees: Some(step) }) = self.camera {
            state.camera = camera.turned(step * frame as f64);
        }
        Ok(state)
    }

    /// Returns a checksum over the first state and its motion; see [`AnimatedScene::fingerprint`].
    pub(super) fn fingerprint(&self) -> u32 {
        animate::fingerprint(self.first(), self.animation.as_deref())
    }

    /// Returns the fountain, if the scene is one.
    pub(super) fn fountain(&self) -> Option<Fountain> {
        animate::fountain(self.animation.as_deref())
    }

    /// Returns all states; `read` calls [`Compared::at`] for states that are not in memory.
    pub(super) fn states<'a>(&'a self, read: &'a dyn Fn(usize) -> Result<Scene>) -> States<'a> {
        match self.camera {
            None => States::Held(&self.states),
            Some(_) => States::Read { first: self.first(), count: self.times_s.len(), read },
        }
    }
}

/// Numbers scenes with the same name, such as smoke.ply and smoke.toml, since their names are used for the files of pictures.
pub(super) fn name_apart(scenes: &mut [Compared]) {
    for i in 1..scenes.len() {
        let (before, rest) = scenes.split_at_mut(i);
        let named = |name: &str| before.iter().flat_map(|compared| &compared.states).any(|s| s.name == name);
        let name = rest[0].first().name.clone();
        let mut unique = name.clone();
        for number in 2.. {
            if !named(&unique) {
                break;
            }
            unique = format!("{name}-{number}");
        }
        rest[0].states.iter_mut().for_each(|s| s.name.clone_from(&unique));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Field;
    use std::sync::Weak;

    /// Reads a sequence of three files twice. Among the frames returned, only the first and the last may still be in memory, and the camera
    /// must turn.
    #[test]
    fn the_first_and_the_last_are_alive() {
        let files = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/vdb/ok-frame-#.vdb");
        let scene = AnimatedScene::load(files, 0.0).expect("a sequence");
        let (camera, times_s) = (scene.scene.camera, (0..6).map(|frame| (f64::from(frame) + 0.5) / 24.0).collect());
        let compared = Compared::read(scene, times_s, Some(30.0)).expect("read");
        let first = compared.first().volumes[0].held();
        let mut given: Vec<Weak<Field>> = Vec::new();
        for frame in 0..6 {
            let state = compared.at(frame).expect("read");
            assert_eq!(state.camera, camera.turned(30.0 * frame as f64), "frame {frame}");
            given.push(state.volumes[0].held());
            let alive = given.iter().filter(|field| field.strong_count() > 0 && !field.ptr_eq(&first)).count();
            assert_eq!(alive, usize::from(frame > 0), "frame {frame}");
        }
        assert!(first.strong_count() > 0);
        let read = |frame| compared.at(frame);
        let states = compared.states(&read);
        assert_eq!((states.count(), states.first()), (6, Some(compared.first())));
        assert_eq!(states.at(1).expect("read").volumes, compared.at(1).expect("read").volumes);
    }
}
