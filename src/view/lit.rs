//! An open technique in the window, and the picture that it lights.

use crate::gpu::{Commands, Context, Image};
use crate::scene::{Backdrop, Show, View};
use crate::shading::{Kernels, Lighting, Pictures, Renderer, Shading, StepsKernel, Tonemapped};
use crate::technique::{BuildStatus, Spec, Technique, open};
use crate::world::{Generations, World};
use crate::{Error, Result};

pub struct Lit {
    pub spec: Spec,
    pub technique: Box<dyn Technique>,
    pictures: Pictures,
    /// How to show the picture; `None` to show it as measured.
    pub look: Option<Show>,
    /// Backdrop of the picture if it is shown with a look.
    backdrop: Backdrop,
    /// Counts the steps of the technique's look-ups; created on first use.
    pub steps: Option<StepsKernel>,
    kernels: Kernels,
    /// Kernels that draw the picture with the outlines of its triangles; created on first use.
    outlined: Option<Kernels>,
    /// Whether the picture shows the outlines.
    has_lines: bool,
    /// State of the world at the technique's last build.
    built: Option<Generations>,
    /// Frame that recorded the technique's last build; `None` once that frame is complete.
    building: Option<u64>,
    /// State of the world, and camera, shown by the picture.
    seen: (u64, View),
    /// Number of times that the picture must still be drawn until it no longer changes.
    left: usize,
    /// Number of times that the technique was built.
    pub builds: u64,
}

/// What [`Lit::record`] has recorded in a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Recorded {
    /// Whether the build or the view has changed.
    pub changed: bool,
    /// Whether the picture was drawn again.
    pub drawn: bool,
}

impl Lit {
    /// Opens a technique for the world in state `seen.0`, seen by the camera `seen.1`.
    ///
    /// # Errors
    /// See [`open`], [`Pictures::new`] and [`Renderer::kernels_of`].
    pub fn open(context: &Context, world: &World, spec: &Spec, seen: (u64, View), look: Option<Show>) -> Result<Self> {
        let settings = spec.settings();
        let lighting = Lighting::of(&settings);
        settings.check(context.features())?;
        let technique = open(context, world, spec)?.technique;
        let size = [seen.1.width, seen.1.height];
        let mut pictures = Pictures::new(context, world, world.scene()?, size, look)?;
        pictures.renderer.paint_by(settings.painter);
        let shading = Shading::of(&settings);
        Ok(Self {
            kernels: pictures.renderer.kernels_of(technique.as_ref(), shading, lighting)?,
            spec: spec.clone(),
            technique,
            pictures,
            look,
            backdrop: Backdrop::of(world.scene()?),
            outlined: None,
            has_lines: false,
            steps: None,
            built: None,
            building: None,
            seen,
            left: shading.frames_to_settle(),
            builds: 0,
        })
    }

    /// Returns the renderer that draws the picture.
    pub fn renderer(&self) -> &Renderer {
        &self.pictures.renderer
    }

    /// Returns the picture, in linear light.
    pub fn image(&self) -> &Image {
        self.pictures.tonemapped().map_or_else(|| self.renderer().image(), Tonemapped::image)
    }

    /// Reads the counts of the completed frame `over`. If buffers were too small and have grown, the technique is built again.
    ///
    /// # Errors
    /// See [`Technique::settle`].
    pub fn settle(&mut self, over: u64) -> Result<()> {
        if self.technique.settle(over)? != BuildStatus::Done {
            self.built = None;
        }
        if self.building == Some(over) {
            self.building = None;
        }
        if !self.renderer().settle(&self.kernels, over)? {
            // The picture lacks casters that now have room.
            self.left = Shading::of(&self.spec.settings()).frames_to_settle();
        }
        Ok(())
    }

    /// Whether the technique's build is complete and matches the present world.
    pub fn is_current(&self, world: &World) -> bool {
        let parts = self.technique.made_of();
        self.building.is_none() && self.built.as_ref().is_some_and(|built| built.agree(world.generations(), parts))
    }

    /// Whether the picture no longer changes.
    pub fn is_drawn(&self) -> bool {
        self.left == 0
    }

    /// Creates the kernels that draw the outlines of triangles.
    ///
    /// # Errors
    /// [`Error::Input`] if the technique draws no triangles; otherwise like [`Renderer::wireframe_kernels`].
    pub fn outline(&mut self) -> Result<()> {
        let settings = self.spec.settings();
        let Lighting::Vertex { spacing } = Lighting::of(&settings) else {
            let way_out = "set lighting=vertex";
            return Err(Error::input(self.spec.entry.name, "it tessellates nothing", way_out));
        };
        if self.outlined.is_none() {
            let answer = self.technique.answer();
            self.outlined = Some(self.renderer().wireframe_kernels(&answer, Shading::of(&settings), spacing)?);
        }
        Ok(())
    }

    /// Records what has changed: the build and, if `pictured`, the picture, with the outlines of triangles if `lines`. `seen` is as in
    /// [`Lit::open`].
    ///
    /// # Errors
    /// See [`Technique::record`] and [`Renderer::record`].
    pub fn record(
        &mut self,
        commands: &mut Commands,
        world: &World,
        seen: (u64, View),
        pictured: bool,
        lines: bool,
    ) -> Result<Recorded> {
        let parts = self.technique.made_of();
        let builds = !self.built.as_ref().is_some_and(|built| built.agree(world.generations(), parts));
        if builds {
            self.technique.record(commands, world)?;
            self.builds += 1;
            (self.built, self.building) = (Some(world.generations().clone()), Some(commands.frame()));
        }
        let changed = builds || seen != self.seen;
        if seen != self.seen {
            let scene = world.scene()?;
            let backdrop = Backdrop::of(scene);
            if self.look.is_some() && backdrop != self.backdrop {
                self.pictures.renderer.show(world)?;
                self.backdrop = backdrop;
            }
            self.pictures.look(world, scene)?;
            self.seen = seen;
        }
        let lines = lines && self.outlined.is_some();
        if changed || lines != self.has_lines && pictured {
            self.left = Shading::of(&self.spec.settings()).frames_to_settle();
        }
        let drawn = pictured && self.left > 0;
        if drawn {
            let kernels = self.outlined.as_ref().filter(|_| lines).unwrap_or(&self.kernels);
            self.renderer().record(commands, kernels)?;
            if let Some(tonemapped) = self.pictures.tonemapped() {
                tonemapped.record(commands);
            }
            self.has_lines = lines;
            self.left -= 1;
        }
        Ok(Recorded { changed, drawn })
    }
}
