//! A scene on the device, at one of its frames.

use crate::Result;
use crate::animate::Simulation;
use crate::bench::case::frames::{Drawing, Frames};
use crate::bench::case::picture_settings::PictureSettings;
use crate::gpu::{Context, Features, PassTime};
use crate::scene::{Picture, View};
use crate::shading::{Renderer, Shading};
use crate::technique::Opened;
use crate::world::World;

/// See the module documentation.
pub(in crate::bench) struct DeviceScene<'a> {
    pub context: &'a Context,
    pub frames: Frames<'a>,
    pub world: World,
    /// Moves the world, if the device simulates it.
    simulation: Option<Simulation>,
}

impl<'a> DeviceScene<'a> {
    /// Creates the scene from a world that holds the first frame, with a simulation if the device runs one.
    pub fn new(context: &'a Context, frames: Frames<'a>, world: World) -> Result<Self> {
        let fountain = frames.fountain.filter(|_| !frames.times_s.is_empty());
        let simulation = fountain.map(|fountain| Simulation::new(context, &world, fountain)).transpose()?;
        Ok(Self { context, frames, world, simulation })
    }

    pub fn features(&self) -> &'a Features {
        self.context.features()
    }

    /// Whether the world differs from frame to frame.
    pub fn has_frames(&self) -> bool {
        self.frames.count() > 1
    }

    /// Whether the world is static.
    pub fn is_still(&self) -> bool {
        !self.has_frames() && self.simulation.is_none()
    }

    /// Moves the world to a frame. Returns the times of the passes that moved it.
    pub fn show(&mut self, frame: usize) -> Result<Vec<PassTime>> {
        match &mut self.simulation {
            _ if self.frames.count() == 1 => Ok(Vec::new()),
            Some(simulation) => simulation.move_to(&mut self.world, self.frames.times_s[frame]),
            None => Ok(self.world.replace(self.frames.states.at(frame)?.as_ref())?.pass.into_iter().collect()),
        }
    }

    /// Returns the camera of the current world.
    pub fn camera(&self, size: [u32; 2]) -> Result<View> {
        let scene = self.world.scene()?;
        Ok(View::camera(&scene.camera, scene, size))
    }

    /// Creates a renderer of the current world.
    pub fn renderer(&self, camera: &View, settings: PictureSettings) -> Result<Renderer> {
        let mut renderer = Renderer::new(self.context, &self.world, camera)?;
        renderer.paint_by(settings.painter);
        Ok(renderer)
    }

    /// Draws one picture of the current world, lit by a technique.
    pub fn picture(&self, camera: &View, opened: &Opened, settings: PictureSettings) -> Result<Picture> {
        let renderer = self.renderer(camera, settings)?;
        renderer.picture_of(opened.technique.as_ref(), settings.shading, settings.lighting)
    }

    /// Creates the [`Drawing`] that draws the simulated particles in each frame; `None` if nothing is simulated.
    pub fn drawing(&self, camera: &View, lit: &Opened, shading: Shading) -> Result<Option<Drawing>> {
        let of = |simulation| Drawing::new(self.context, &self.world, simulation, camera, lit, shading);
        self.simulation.as_ref().map(of).transpose()
    }
}
