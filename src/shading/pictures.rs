//! Pictures of a scene, in a form for people to look at or in the form that is measured. All commands that draw use this.

use super::{Renderer, Tonemapped};
use crate::gpu::Context;
use crate::scene::{Picture, Scene, Show, View};
use crate::world::World;
use crate::{Error, Result};

/// Draws a world by [`Pictures::renderer`] and reads the finished picture.
pub struct Pictures {
    /// Draws one pixel per sample; a picture for people has several samples per final pixel.
    pub renderer: Renderer,
    size: [u32; 2],
    tonemapped: Option<(Show, Tonemapped)>,
}

impl Pictures {
    /// For pictures of `size` pixels, of the scene from which `world` was filled. Without `show`, pictures are those that are measured.
    ///
    /// # Errors
    /// [`Error::Input`] where the device cannot have an image with that many samples; else as [`Renderer::new`] and [`Renderer::show`].
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

    /// Sees the world as it is now, by the camera of `scene`.
    ///
    /// # Errors
    /// As [`Renderer::look`].
    pub fn look(&mut self, world: &World, scene: &Scene) -> Result<()> {
        let sampled = self.tonemapped.as_ref().map_or(self.size, |(show, _)| show.sampled(self.size));
        self.renderer.look(world, &View::camera(&scene.camera, scene, sampled))
    }

    /// The pass that turns the drawn samples into the picture for people; none where pictures are measured.
    pub fn tonemapped(&self) -> Option<&Tonemapped> {
        self.tonemapped.as_ref().map(|(_, tonemapped)| tonemapped)
    }

    /// The picture that was drawn last.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost.
    pub fn read(&self) -> Result<Picture> {
        self.tonemapped().map_or_else(|| self.renderer.read(), Tonemapped::picture)
    }
}
