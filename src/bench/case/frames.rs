//! The state of a scene in each frame, and the drawing of simulated particles.

use crate::Result;
use crate::animate::Simulation;
use crate::gpu::{Context, PassTime};
use crate::scene::{Fountain, Scene, View};
use crate::shading::{Colors, Kernels, Lighting, Points, Renderer, Shading};
use crate::technique::{Opened, answers_in_space};
use crate::world::World;
use std::borrow::Cow;

/// A scene, frame by frame.
#[derive(Clone, Copy)]
pub struct Frames<'a> {
    /// Its state in each frame; a single one for a static scene. A simulated scene needs only one if no truth is wanted.
    pub states: States<'a>,
    /// Times of the frames of a moving scene. If the device can simulate the scene, it steps through these times instead of the states.
    pub times_s: &'a [f64],
    /// The fountain that the device can simulate, if the scene is one.
    pub fountain: Option<Fountain>,
    /// One bounce of light, as a second reference for pictures under virtual lights.
    pub bounce: Option<Traced<'a>>,
}

/// The states of a scene, frame by frame.
#[derive(Clone, Copy)]
pub enum States<'a> {
    /// All states are in memory.
    Held(&'a [Scene]),
    /// States are read on demand and then freed. Those in memory are the first, the one being shown, the one being read and, if errors over
    /// areas are measured, the last.
    Read {
        /// The first state.
        first: &'a Scene,
        /// Number of states.
        count: usize,
        /// Reads one state.
        read: &'a dyn Fn(usize) -> Result<Scene>,
    },
}

impl<'a> States<'a> {
    /// Returns the number of states.
    pub fn count(&self) -> usize {
        match self {
            Self::Held(states) => states.len(),
            Self::Read { count, .. } => *count,
        }
    }

    /// Returns the first state, if there is one.
    pub fn first(&self) -> Option<&'a Scene> {
        match self {
            Self::Held(states) => states.first(),
            Self::Read { first, .. } => Some(*first),
        }
    }

    /// Returns the state in an existing frame.
    ///
    /// # Errors
    /// Fails if the state cannot be read.
    pub fn at(&self, frame: usize) -> Result<Cow<'a, Scene>> {
        match self {
            Self::Held(states) => Ok(Cow::Borrowed(&states[frame])),
            Self::Read { read, .. } => read(frame).map(Cow::Owned),
        }
    }
}

/// One bounce of light, path traced.
#[derive(Clone, Copy)]
pub struct Traced<'a> {
    /// The scene in the last frame, under the lights that virtual lights represent.
    pub scene: &'a Scene,
    /// Number of directions per pixel, on each side of the visible surface.
    pub samples: u32,
}

impl<'a> From<&'a [Scene]> for Frames<'a> {
    fn from(states: &'a [Scene]) -> Self {
        Self { states: States::Held(states), times_s: &[], fountain: None, bounce: None }
    }
}

impl Frames<'_> {
    /// Returns the number of frames.
    pub(in crate::bench) fn count(&self) -> usize {
        self.states.count().max(self.times_s.len())
    }
}

/// Draws simulated particles in each frame as their simulation left them, so that a whole frame stays on the device.
pub(in crate::bench) struct Drawing {
    renderer: Renderer,
    kernels: Kernels,
    points: Points,
}

impl Drawing {
    /// Prepares to draw the frames of a simulated scene, lit by a technique.
    pub(in crate::bench) fn new(
        context: &Context,
        world: &World,
        simulation: &Simulation,
        camera: &View,
        lit: &Opened,
        shading: Shading,
    ) -> Result<Self> {
        answers_in_space(lit.technique.as_ref())?;
        let renderer = Renderer::new(context, world, camera)?;
        let answer = lit.technique.answer();
        let kernels = renderer.kernels(&answer, shading, Lighting::Fragment)?;
        let fountain = simulation.fountain();
        let colors = Colors::Speed { fastest: fountain.law().fastest };
        let points = renderer.points(&answer, simulation.bodies(), fountain.particles, colors)?;
        Ok(Self { renderer, kernels, points })
    }

    /// Draws the current world. Returns the time of each pass.
    pub(in crate::bench) fn draw(&self) -> Result<Vec<PassTime>> {
        self.renderer.draw_points(&self.kernels, &self.points)
    }
}
