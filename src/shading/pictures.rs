//! Pictures of a scene, either for display or for measurement. All commands that draw pictures use this module.

use super::{Renderer, Tonemapped};
use crate::gpu::Context;
use crate::scene::{Picture, Scene, Show, View};
use crate::world::World;
use crate::{Error, Result};

/// Draws a world with [`Pictures::renderer`] and reads back the finished picture.
pub struct Pictures {
    /// Draws one pixel per sample; a picture for display has several samples per final pixel.
    pub renderer: Renderer,
    size: [u32; 2],
    tonemapped: Option<(Show, Tonemapped)>,
}

impl Pictures {
    /// Prepares pictures of `size` pixels, of the scene from which `world` was filled. Without `show`, these are pictures for measurement.
    ///
    /// # Errors
    /// [`Error::Input`] if the device cannot have an image with that many samples; otherwise the same as [`Renderer::new`] and
    /// [`Renderer::show`].
    pub fn new(context: &Context, world: &World, scene: &Scene, size: [u32; 2], show: Option<Show>) -> Result<Self> {
        let sampled = show.map_or(size, |show| show.sampled(size));
        let most = context.features().max_image_dimension_2d;
        if show.is_some() && sampled.iter().any(|side| *side > most) && size.iter().all(|side| *side <= most) {
            let cause = format!("a picture of {} × {} samples, of at most {most} a side", sampled[0], sampled[1]);
            return Err(Error::input("samples", cause, "take fewer samples, or a smaller picture"));
        }
        let mut renderer = Renderer::new(context, world, &View::camera(&scene.camera, scene, sampled))?;
        let Some(show) = show else { return Ok(Self { renderer, size, tonemapped: None }) };
        renderer.show(world)?;
        let tonemapped = Some((show, Tonemapped::new(&renderer, &show)?));
        Ok(Self { renderer, size, tonemapped })
    }

    /// Updates to the current world, seen by the camera of `scene`.
    ///
    /// # Errors
    /// Same as [`Renderer::look`].
    pub fn look(&mut self, world: &World, scene: &Scene) -> Result<()> {
        let sampled = self.tonemapped.as_ref().map_or(self.size, |(show, _)| show.sampled(self.size));
        self.renderer.look(world, &View::camera(&scene.camera, scene, sampled))
    }

    /// Returns the pass that turns the drawn samples into the picture for display; `None` for measured pictures.
    pub fn tonemapped(&self) -> Option<&Tonemapped> {
        self.tonemapped.as_ref().map(|(_, tonemapped)| tonemapped)
    }

    /// Reads back the last picture drawn.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost.
    pub fn read(&self) -> Result<Picture> {
        self.tonemapped().map_or_else(|| self.renderer.read(), Tonemapped::picture)
    }
}
