//! The kernels that draw a picture, chosen by how meshes are shaded and where casters are lit.

use super::gbuffer::GBuffer;
use super::half_angle_draw::HalfAngleDraw;
use super::interleaved::Interleaved;
use super::many_lights::{Asking, ManyLights};
use super::painter::{Painter, Shade, Slices};
use super::reservoir::Reservoirs;
use super::volumes::VolumeKernel;
use super::{Lighting, PainterKind, Renderer, Shading};
use crate::gpu::{Bindings, Blend, Constants, Format, Graphics, Kernel, Requirement, Shader, Tessellated, push_struct};
use crate::query::colored;
use crate::shaders::shading as shaders;
use crate::technique::{Answer, Technique};
use crate::{Error, Result};
use std::cell::Cell;
use std::sync::Arc;

push_struct! {
    /// Twin: SpacingPush in glsl/shading/vertex_lit.tesc.
    pub(super) struct SpacingPush { spacing: f32 }
}

/// Draws a picture, lit by one technique.
pub struct Kernels {
    pub(super) meshes: Meshes,
    pub(super) casters: Casters,
    pub(super) volumes: Option<VolumeKernel>,
    /// Whether these kernels have drawn a picture quickly, so that later ones need only one submission.
    pub(super) is_short: Cell<bool>,
    /// The state of casters and camera for which the lists are large enough: see [`super::blending::Blending::moves`].
    pub(super) has_room_for: Cell<u64>,
}

/// Draws the meshes.
pub(super) enum Meshes {
    Forward(Kernel),
    Shaded(Shade),
    Deferred { gbuffer: GBuffer, deferred: Kernel },
    Tiled { gbuffer: GBuffer, tiles: Arc<ManyLights>, asking: Asking },
    Interleaved { gbuffer: GBuffer, interleaved: Interleaved },
    Reservoir { gbuffer: GBuffer, reservoirs: Reservoirs },
}

/// Draws the casters.
pub(super) enum Casters {
    /// One kernel for all channels, or one per channel; the same holds for the variants below.
    Fragment(Vec<Kernel>),
    Vertex(Vec<Kernel<SpacingPush>>, SpacingPush),
    /// Patches, some of them overlaid with the outlines of their triangles.
    Outlined {
        filled: Vec<Kernel<SpacingPush>>,
        lines: Vec<Kernel<SpacingPush>>,
        push: SpacingPush,
    },
    HalfAngleDraw(HalfAngleDraw),
    Painted(Painter),
    PaintedSlices(Slices),
}

impl Casters {
    /// Returns whether the lists were too small for the casters of frame `frame`; if so, they have been enlarged.
    pub(super) fn settle(&self, frame: u64) -> Result<bool> {
        match self {
            Self::Painted(painter) => painter.settle(frame),
            Self::PaintedSlices(slices) => slices.settle(frame),
            _ => Ok(false),
        }
    }
}

impl Kernels {
    /// Returns whether the casters are rasterized or painted by compute passes.
    pub fn painter(&self) -> PainterKind {
        let paints = matches!(self.casters, Casters::Painted(_) | Casters::PaintedSlices(_));
        if paints { PainterKind::Compute } else { PainterKind::Raster }
    }

    /// With `shading=reservoir`, restarts at the frame number `frame` and forgets the kept lights. The frame number seeds the choice of
    /// lights. Other shading ignores this call.
    pub fn begin_at(&self, frame: u32) {
        if let Meshes::Reservoir { reservoirs, .. } = &self.meshes {
            reservoirs.begin_at(frame);
        }
    }
}

impl Renderer {
    /// Creates kernels that draw casters as patches lit at their vertices, or as lines: one kernel, or one per channel.
    pub(super) fn tessellated(
        &self,
        answer: &Answer,
        fragment: &Shader,
        lines: bool,
    ) -> Result<Vec<Kernel<SpacingPush>>> {
        let evaluation = shaders::VERTEX_LIT_TESE.of(answer.folder);
        let stages = Tessellated { control: &shaders::VERTEX_LIT_TESC, evaluation, lines };
        let sets = [&self.scene.set, answer.bindings, &self.targets.distances];
        let kernel = |(blend, constants): (Blend, Constants)| {
            let colors = [(self.targets.format, blend)];
            let state = Graphics { vertex: &shaders::VERTEX_LIT_VERT, fragment, colors: &colors, depth: None };
            Kernel::tessellated(&self.context, &state, &stages, &sets, &constants)
        };
        self.channels(answer.constants).into_iter().map(kernel).collect()
    }

    /// Creates the kernels that draw the picture, lit by `answer`.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device lacks a feature that `lighting` needs or cannot have buffers large enough for the shading, or if
    /// tiled shading is combined with smoke that has a color; [`Error::Input`] if there are more lights than a tile's list can hold;
    /// [`Error::Gpu`] if the driver rejects a shader.
    pub fn kernels(&self, answer: &Answer, shading: Shading, lighting: Lighting) -> Result<Kernels> {
        self.context.features().require(lighting.requires(self.painter_kind))?;
        self.check_colored(shading)?;
        let constants = colored(answer.constants, self.kinds.extinction_ratio);
        let answer = &Answer { constants: &constants, ..*answer };
        let casters = match (self.painter_kind, lighting) {
            (PainterKind::Compute, _) => Casters::Painted(Painter::new(self, answer, lighting)?),
            (PainterKind::Raster, Lighting::Fragment) => Casters::Fragment(self.fragment_kernels(answer)?),
            (PainterKind::Raster, Lighting::Vertex { spacing }) => {
                Casters::Vertex(self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?, SpacingPush { spacing })
            }
        };
        self.with_casters(answer, shading, casters)
    }

    /// Creates kernels that draw casters lit at each pixel: one kernel, or one per channel.
    fn fragment_kernels(&self, answer: &Answer) -> Result<Vec<Kernel>> {
        let sets = [&self.scene.set, answer.bindings, &self.targets.distances];
        let fragment = shaders::CASTER_FRAG.of(answer.folder);
        let kernel = |(blend, constants): (Blend, Constants)| {
            let colors = [(self.targets.format, blend)];
            let state = Graphics { vertex: &shaders::CASTER_VERT, fragment, colors: &colors, depth: None };
            Kernel::graphics(&self.context, &state, &sets, &constants)
        };
        self.channels(answer.constants).into_iter().map(kernel).collect()
    }

    fn with_casters(&self, answer: &Answer, shading: Shading, casters: Casters) -> Result<Kernels> {
        let is_round = self.display.as_ref().is_some_and(|shown| shown.normals.is_some());
        // Smooth normals and holes exist only in the G-buffer, so forward becomes deferred. Apart from these, both draw the same picture.
        let needs_gbuffer = is_round || self.scene.has_alpha;
        let shading = if needs_gbuffer && shading == Shading::Forward { Shading::Deferred } else { shading };
        let meshes = self.mesh_kernels(answer, shading)?;
        let (is_short, has_room_for) = (Cell::new(false), Cell::new(0));
        Ok(Kernels { meshes, casters, volumes: self.volume_kernel(answer)?, is_short, has_room_for })
    }

    fn mesh_kernels(&self, answer: &Answer, shading: Shading) -> Result<Meshes> {
        let make = |vertex, fragment, colors: &[(Format, Blend)], depth, sets: &[&Bindings]| {
            let state = Graphics { vertex, fragment, colors, depth };
            Kernel::graphics(&self.context, &state, sets, answer.constants)
        };
        let (scene, asked) = (&self.scene.set, answer.bindings);
        let color = (self.targets.format, Blend::None);
        let distance = (Format::R32_SFLOAT, Blend::None);
        let depth = Some(Format::D32_SFLOAT);
        let forward = shaders::FORWARD_FRAG.of(answer.folder);
        let deferred = shaders::DEFERRED_FRAG.of(answer.folder);
        let lit = [scene, asked, &self.targets.surfaces];
        let gbuffer = || GBuffer::new(self);
        Ok(match shading {
            Shading::Forward | Shading::Deferred if self.painter_kind == PainterKind::Compute => {
                Meshes::Shaded(Shade::new(self, answer)?)
            }
            Shading::Forward => {
                Meshes::Forward(make(&shaders::SURFACE_VERT, forward, &[color, distance], depth, &[scene, asked])?)
            }
            Shading::Deferred => Meshes::Deferred {
                gbuffer: gbuffer()?,
                deferred: make(&shaders::FULLSCREEN_VERT, deferred, &[color], None, &lit)?,
            },
            Shading::Tiled(tiled) => {
                let tiles = self.tiles(tiled)?;
                Meshes::Tiled { gbuffer: gbuffer()?, asking: tiles.asking(answer)?, tiles }
            }
            Shading::Interleaved => {
                Meshes::Interleaved { gbuffer: gbuffer()?, interleaved: Interleaved::new(self, answer)? }
            }
            Shading::Reservoir => Meshes::Reservoir { gbuffer: gbuffer()?, reservoirs: Reservoirs::new(self, answer)? },
        })
    }

    /// Creates the kernels that draw the picture and, on top of some casters, the outlines of their triangles.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device lacks tessellation or lines, otherwise the same as [`Renderer::kernels`].
    pub fn wireframe_kernels(&self, answer: &Answer, shading: Shading, spacing: f32) -> Result<Kernels> {
        self.context.features().require(&[Requirement::Tessellation, Requirement::Lines])?;
        self.check_colored(shading)?;
        let constants = colored(answer.constants, self.kinds.extinction_ratio);
        let answer = &Answer { constants: &constants, ..*answer };
        let filled = self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?;
        let lines = self.tessellated(answer, &shaders::WIREFRAME_FRAG, true)?;
        self.with_casters(answer, shading, Casters::Outlined { filled, lines, push: SpacingPush { spacing } })
    }

    /// Creates the kernels that draw the picture. A built technique lights it, or paints the casters itself ([`Answer::painter`]).
    ///
    /// # Errors
    /// Same as [`Renderer::kernels`]; [`Error::Refused`] if a technique paints the casters itself, but `lighting` requests light at
    /// vertices or casters have a color.
    pub fn kernels_of(&self, technique: &dyn Technique, shading: Shading, lighting: Lighting) -> Result<Kernels> {
        let answer = &technique.answer();
        let Some(painter) = answer.painter else { return self.kernels(answer, shading, lighting) };
        if lighting != Lighting::Fragment {
            return Err(Error::Refused("lighting=fragment: it paints casters itself".into()));
        }
        if !self.is_grey() {
            return Err(Error::Refused("a scene without [color]: it paints all colors with one opacity".into()));
        }
        self.check_colored(shading)?;
        let casters = match self.painter_kind {
            PainterKind::Compute => Casters::PaintedSlices(Slices::new(self, answer, painter)?),
            PainterKind::Raster => Casters::HalfAngleDraw(HalfAngleDraw::new(self, answer, painter)?),
        };
        self.with_casters(answer, shading, casters)
    }
}
