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
    /// How its picture is shown; none where it is shown as it is measured.
    pub look: Option<Show>,
    /// The backdrop of a picture that is shown with a look.
    backdrop: Backdrop,
    /// Counts the steps of its look-ups; made when first asked for.
    pub steps: Option<StepsKernel>,
    kernels: Kernels,
    /// Draws the picture with its triangles; made when first asked for.
    outlined: Option<Kernels>,
    /// Whether its picture has the triangles.
    has_lines: bool,
    /// The state of the world that it was built for.
    built: Option<Generations>,
    /// The frame that recorded its last build; none once that frame is over.
    building: Option<u64>,
    /// The state of the world, and the camera, that its picture shows.
    seen: (u64, View),
    /// How many times its picture must still be drawn until it does not change any more.
    left: usize,
    /// How many times it was built.
    pub builds: u64,
}

/// What a side recorded in a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Recorded {
    /// Whether the build or the view has changed.
    pub changed: bool,
    /// Whether its picture was drawn again.
    pub drawn: bool,
}

impl Lit {
    /// Opens a technique for the world in state `seen.0`, seen by the camera `seen.1`.
    ///
    /// # Errors
    /// As [`open`], [`Pictures::new`] and [`Renderer::kernels_of`].
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

    /// The renderer that draws its picture.
    pub fn renderer(&self) -> &Renderer {
        &self.pictures.renderer
    }

    /// Its picture, in linear light.
    pub fn image(&self) -> &Image {
        self.pictures.tonemapped().map_or_else(|| self.renderer().image(), Tonemapped::image)
    }

    /// Reads the counts of frame `over`, which is over. Where buffers were too small and have grown, the build is made
    /// again.
    ///
    /// # Errors
    /// As [`Technique::settle`].
    pub fn settle(&mut self, over: u64) -> Result<()> {
        if self.technique.settle(over)? != BuildStatus::Done {
            self.built = None;
        }
        if self.building == Some(over) {
            self.building = None;
        }
        if !self.renderer().settle(&self.kernels, over)? {
            // The picture lacks casters for which there is room now.
            self.left = Shading::of(&self.spec.settings()).frames_to_settle();
        }
        Ok(())
    }

    /// Whether its build fits the present world, as far as that is known.
    pub fn is_current(&self, world: &World) -> bool {
        let parts = self.technique.made_of();
        self.building.is_none() && self.built.as_ref().is_some_and(|built| built.agree(world.generations(), parts))
    }

    /// Whether its picture does not change any more.
    pub fn is_drawn(&self) -> bool {
        self.left == 0
    }

    /// Makes the kernels that draw its triangles.
    ///
    /// # Errors
    /// [`Error::Input`] where the technique draws no triangles, else as [`Renderer::wireframe_kernels`].
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

    /// Records what has changed: the build and, where it is wanted, the picture, which shows the outlines of triangles
    /// where `lines` is true. `seen` is as in [`Lit::open`].
    ///
    /// # Errors
    /// As [`Technique::record`] and [`Renderer::record`].
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
