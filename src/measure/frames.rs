//! The state of a scene in each frame, and how simulated particles are drawn.

use crate::Result;
use crate::consume::{Colours, Kernels, Lighting, Points, Renderer, Shading};
use crate::gpu::{Context, PassTime};
use crate::scene::{Scene, View};
use crate::simulate::Simulation;
use crate::technique::{Opened, answers_in_space};
use crate::world::World;

/// A scene in each frame.
#[derive(Clone, Copy)]
pub struct Frames<'a> {
    /// Its state in each frame; one for a still scene. A simulated scene needs only one if no truth is wanted.
    pub states: &'a [Scene],
    /// The times of a scene that moves. Where the device can simulate the scene, it goes through these times, and not
    /// through the states.
    pub times_s: &'a [f64],
    /// A bounce of light, with which pictures under virtual lights are also compared.
    pub bounce: Option<Traced<'a>>,
}

/// One bounce of light, path traced.
#[derive(Clone, Copy)]
pub struct Traced<'a> {
    /// The scene in the last frame, under the lights that virtual lights represent.
    pub scene: &'a Scene,
    /// Directions per pixel, on each side of the surface that it sees.
    pub samples: u32,
}

impl<'a> From<&'a [Scene]> for Frames<'a> {
    fn from(states: &'a [Scene]) -> Self {
        Self { states, times_s: &[], bounce: None }
    }
}

impl Frames<'_> {
    /// How many frames there are.
    pub(super) fn count(&self) -> usize {
        self.states.len().max(self.times_s.len())
    }
}

/// Draws simulated particles in each frame as their simulation left them, so that all of a frame stays on the device.
pub(super) struct Drawing {
    renderer: Renderer,
    kernels: Kernels,
    points: Points,
}

impl Drawing {
    /// Frames of a simulated scene, lit by a technique.
    pub(super) fn new(
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
        let points = renderer.points(&answer, simulation.bodies(), fountain.particles, Colours::speed(&fountain))?;
        Ok(Self { renderer, kernels, points })
    }

    /// Draws the present world; returns the time of each pass.
    pub(super) fn draw(&self) -> Result<Vec<PassTime>> {
        self.renderer.draw_points(&self.kernels, &self.points)
    }
}
