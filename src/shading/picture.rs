//! The shaded picture: first meshes, in one of five ways ([`Shading`]), then casters and volumes from far to near. Twin:
//! reference::truth::picture.

use super::blending::Blending;
use super::display::DisplayState;
use super::half::from_half;
use super::kernels::{Kernels, Meshes};
use super::painter::usual_part;
use super::picture_scene::{CasterKinds, PictureScene, splat_colors};
use super::shared::SharedPasses;
use super::targets::PictureTargets;
use super::volumes::Volumes;
use super::{Lighting, PainterKind, Shading, lock};
use crate::gpu::{Commands, Context, Format, Image, PassTime};
use crate::scene::{Picture, View};
use crate::technique::{Answer, Technique};
use crate::world::World;
use crate::{Error, Result};

/// Draws pictures of one world at one size.
pub struct Renderer {
    pub(super) context: Context,
    pub(super) targets: PictureTargets,
    pub(super) scene: PictureScene,
    pub(super) kinds: CasterKinds,
    pub(super) camera: View,
    pub(super) blending: Blending,
    pub(super) volumes: Option<Volumes>,
    pub(super) shared: SharedPasses,
    /// Whether compute passes or the rasterizer make the pictures: see [`Renderer::paint_by`].
    pub(super) painter_kind: PainterKind,
    /// See [`Renderer::cut_lists`].
    pub(super) least_part: u32,
    /// Sky, fading ground and smooth normals, for pictures for display; `None` for measured pictures.
    pub(super) display: Option<DisplayState>,
}

impl Renderer {
    /// Prepares pictures of the current world, as `camera` sees it.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out. [`Error::Refused`] if the caller's buffers fill the world and its capacity includes splats or
    /// volumes: only a scene has their colors.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let colors = splat_colors(world)?;
        let blending = Blending::new(context, world, camera)?;
        Ok(Self {
            context: context.clone(),
            targets: PictureTargets::new(context, [camera.width, camera.height])?,
            scene: PictureScene::new(context, world, camera, &blending.order, &colors)?,
            kinds: CasterKinds::of(world),
            camera: *camera,
            blending,
            volumes: Volumes::new(context, world)?,
            shared: SharedPasses::default(),
            painter_kind: PainterKind::usual(context.features()),
            least_part: usual_part(context),
            display: None,
        })
    }

    /// Prepares the next frame: the current world, seen by a camera with the same number of pixels.
    ///
    /// # Errors
    /// [`Error::Input`] if the camera's picture has another size, [`Error::Gpu`] if the device is lost.
    pub fn look(&mut self, world: &World, camera: &View) -> Result<()> {
        let size = [camera.width, camera.height];
        if size != self.targets.color.size() {
            let cause =
                format!("a picture of {size:?} pixels, and the frames before have {:?}", self.targets.color.size());
            return Err(Error::input("the camera", cause, "make a renderer of that size"));
        }
        if *camera != self.camera {
            self.scene.camera.write(&[*camera])?;
            self.shared.seen.get().map_or(Ok(()), |seen| lock(seen).look(camera))?;
        }
        match &mut self.volumes {
            Some(volumes) => volumes.look(world)?,
            None if world.kinds().volumes => {
                let cause = "it has volumes, and had none when this renderer was made";
                return Err(Error::input(world.name(), cause, "make a new one"));
            }
            None => {}
        }
        self.blending.look(world, camera, *camera != self.camera)?;
        self.scene.look(world)?;
        self.camera = *camera;
        if let Some(display) = &mut self.display {
            display.look(world)?;
        }
        Ok(())
    }

    /// Sets how kernels created from now on make pictures; `None` chooses the way that is faster on most devices of this kind.
    pub fn paint_by(&mut self, painter: Option<PainterKind>) {
        self.painter_kind = painter.unwrap_or(PainterKind::usual(self.context.features()));
    }

    /// Sorts and lists all casters with the next picture, even if nothing has moved, to measure a frame of a moving world.
    pub fn forget_order(&self) {
        self.blending.forget();
    }

    /// Returns whether the picture that [`Renderer::record`] recorded in frame `frame`, which must have finished, is complete. If the
    /// casters did not fit into the lists of compute passes, the lists have grown for the next frame. The list of large triangles grows
    /// too; large triangles that did not fit only took longer.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub fn settle(&self, kernels: &Kernels, frame: u64) -> Result<bool> {
        self.shared.seen.get().map_or(Ok(false), |seen| lock(seen).settle(frame))?;
        kernels.casters.settle(frame).map(|grew| !grew)
    }

    /// Draws the picture, lit by `answer`, and reads it back. A picture that is averaged with earlier frames is drawn
    /// until it settles.
    ///
    /// # Errors
    /// Any error of [`Renderer::kernels`] or [`Renderer::draw`].
    pub fn picture(&self, answer: &Answer, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.settled(&self.kernels(answer, shading, lighting)?, shading)
    }

    fn settled(&self, kernels: &Kernels, shading: Shading) -> Result<Picture> {
        for _ in 0..shading.frames_to_settle() {
            self.draw(kernels)?;
        }
        self.read()
    }

    /// Draws and reads one frame per camera, in order.
    ///
    /// # Errors
    /// Any error of [`Renderer::kernels`], [`Renderer::look`] or [`Renderer::draw`].
    pub fn sequence(
        &mut self,
        world: &World,
        answer: &Answer,
        shading: Shading,
        lighting: Lighting,
        cameras: &[View],
    ) -> Result<Vec<Picture>> {
        let kernels = self.kernels(answer, shading, lighting)?;
        let mut frame = |camera: &View| {
            self.look(world, camera)?;
            self.draw(&kernels)?;
            self.read()
        };
        cameras.iter().map(&mut frame).collect()
    }

    /// Records the passes of the next frame; `commands` may be the caller's own command buffer.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub fn record(&self, commands: &mut Commands, kernels: &Kernels) -> Result<()> {
        self.meshes(commands, kernels)?;
        self.casters(commands, kernels);
        self.drawn(kernels);
        Ok(())
    }

    /// Draws the meshes, and then calls `record`.
    pub(super) fn frame(&self, kernels: &Kernels, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        let mut frame = 0;
        let times = self.context.try_submit(|commands| {
            frame = commands.frame();
            self.meshes(commands, kernels)?;
            record(commands);
            Ok(())
        })?;
        self.settle(kernels, frame)?;
        self.drawn(kernels);
        Ok(times)
    }

    /// Keeps this frame's camera for shading that reuses the previous frame.
    pub(super) fn drawn(&self, kernels: &Kernels) {
        if let Meshes::Tiled { tiles, .. } = &kernels.meshes {
            tiles.end(&self.camera);
        }
        if let Meshes::Reservoir { reservoirs, .. } = &kernels.meshes {
            reservoirs.end(&self.camera);
        }
    }

    /// Reads back the last picture drawn.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost.
    pub fn read(&self) -> Result<Picture> {
        let pixels = self.read_colors(&self.targets.color)?;
        let [width, height] = self.targets.color.size();
        Ok(Picture { width, height, pixels })
    }

    /// Reads an image that has the picture's format.
    pub(super) fn read_colors(&self, image: &Image) -> Result<Vec<[f32; 3]>> {
        if self.targets.format == Format::R32G32B32A32_SFLOAT {
            return Ok(image.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        }
        let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(from_half);
        Ok(image.read::<[u16; 4]>()?.into_iter().map(rgb).collect())
    }

    /// Returns the image that the picture is drawn into, for further use: 32-bit or half floats.
    pub fn image(&self) -> &Image {
        &self.targets.color
    }

    /// Draws the picture like [`Renderer::picture`], but lit by a built technique, which may also paint the casters itself.
    ///
    /// # Errors
    /// Any error of [`Renderer::kernels_of`] or [`Renderer::draw`].
    pub fn picture_of(&self, technique: &dyn Technique, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.settled(&self.kernels_of(technique, shading, lighting)?, shading)
    }
}
