//! The shaded picture: meshes forward or deferred, then casters from far to near. Twin: reference::truth::picture.

use super::Lighting;
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, Kernel, Pass, PassTime, Requirement,
    Resource, Shader, Target, Tessellated, push_struct,
};
use crate::scene::{Picture, SKY, View, far_to_near};
use crate::shaders::consume as shaders;
use crate::technique::Answer;
use crate::world::World;
use std::ops::Range;

/// How meshes are shaded; the picture is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// In the pass that draws them.
    Forward,
    /// Once a pixel, from a buffer of albedo, normal and distance.
    Deferred,
}

/// Images and bindings for one scene and size.
pub struct Renderer {
    pub(super) context: Context,
    pub(super) color: Image,
    pub(super) depth: Image,
    albedo: Image,
    normal: Image,
    pub(super) distance: Image,
    pub(super) scene: Bindings,
    buffers: Bindings,
    pub(super) distances: Bindings,
    pub(super) color_format: Format,
    far: f32,
    pub(super) triangle_vertices: u32,
    caster_count: u32,
}

push_struct! {
    /// Twin: SpacingPush in glsl/consume/vertex_lit.tesc.
    struct SpacingPush { spacing: f32 }
}

/// What draws a picture, lit by one technique.
pub struct Kernels {
    forward: Kernel,
    gbuffer: Kernel,
    deferred: Kernel,
    casters: Casters,
}

/// What draws the casters.
enum Casters {
    Fragment(Kernel),
    Vertex(Kernel<SpacingPush>, SpacingPush),
}

impl Renderer {
    /// Prepares pictures of the world as it is now, as `camera` sees it.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let size = [camera.width, camera.height];
        // Blending into 32-bit floats is optional; half floats are everywhere, at a thousandth of precision.
        let color_format =
            if context.features().float32_blend { Format::R32G32B32A32_SFLOAT } else { Format::R16G16B16A16_SFLOAT };
        let image = |name, format, usage| Image::new(context, name, format, size, usage);
        let color = image("picture.color", color_format, ImageUse::Color)?;
        let depth = image("picture.depth", Format::D32_SFLOAT, ImageUse::Depth)?;
        let albedo = image("picture.albedo", Format::R32G32B32A32_SFLOAT, ImageUse::Color)?;
        let normal = image("picture.normal", Format::R32G32B32A32_SFLOAT, ImageUse::Color)?;
        let distance = image("picture.distance", Format::R32_SFLOAT, ImageUse::Color)?;
        let resources = [
            Resource::Buffer(world.lights.clone()),
            Resource::Buffer(Buffer::with_data(context, "picture.camera", &[*camera])?),
            Resource::Buffer(world.triangles.clone()),
            Resource::Buffer(world.casters.clone()),
            Resource::Buffer(Buffer::with_data(context, "picture.order", &far_to_near(world.scene(), camera))?),
            Resource::Buffer(world.sides.clone()),
        ];
        let textures = [albedo.clone(), normal.clone(), distance.clone()].map(Resource::Texture);
        Ok(Self {
            context: context.clone(),
            scene: Bindings::new(context, "picture.scene", &resources)?,
            buffers: Bindings::new(context, "picture.buffers", &textures)?,
            distances: Bindings::new(context, "picture.distances", &[Resource::Texture(distance.clone())])?,
            color,
            depth,
            albedo,
            normal,
            distance,
            color_format,
            far: camera.far,
            triangle_vertices: 3 * world.triangle_count(),
            caster_count: world.caster_count(),
        })
    }

    /// Draws the picture, lit by `answer`, and reads it.
    ///
    /// # Errors
    /// As [`Renderer::kernels`] and [`Renderer::draw`].
    pub fn picture(&self, answer: &Answer, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.draw(&self.kernels(answer, lighting)?, shading)?;
        self.read()
    }

    /// Draws the picture; it stays on the device. Returns the time of each pass, the casters' last.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn draw(&self, kernels: &Kernels, shading: Shading) -> Result<Vec<PassTime>> {
        self.context.submit(|commands| {
            self.meshes(commands, kernels, shading);
            match &kernels.casters {
                Casters::Fragment(kernel) => self.caster(commands, kernel),
                Casters::Vertex(kernel, push) => self.vertex_lit(commands, kernel, push),
            }
        })
    }

    /// Draws the picture and, over each caster, the sides of the triangles that it is made of; what is nearer hides them.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks tessellation or lines, else as [`Renderer::picture`].
    pub fn wireframe(&self, answer: &Answer, shading: Shading, spacing: f32) -> Result<Picture> {
        self.context.features().require(&[Requirement::Tessellation, Requirement::Lines])?;
        let kernels = self.kernels(answer, Lighting::Vertex { spacing })?;
        let filled = self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?;
        let lines = self.tessellated(answer, &shaders::WIREFRAME_FRAG, true)?;
        self.context.submit(|commands| {
            self.meshes(commands, &kernels, shading);
            commands.pass("consume.wireframe", |pass| {
                let both = (0..self.caster_count).flat_map(|i| [(&filled, i..i + 1), (&lines, i..i + 1)]);
                self.patches(pass, &SpacingPush { spacing }, both);
            });
        })?;
        self.read()
    }

    /// The picture that was drawn last.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn read(&self) -> Result<Picture> {
        let pixels = self.read_colors(&self.color)?;
        let [width, height] = self.color.size();
        Ok(Picture { width, height, pixels })
    }

    /// Of an image of the colours' format.
    pub(super) fn read_colors(&self, image: &Image) -> Result<Vec<[f32; 3]>> {
        if self.color_format == Format::R32G32B32A32_SFLOAT {
            return Ok(image.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        }
        let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(|c| half::f16::from_bits(c).to_f32());
        Ok(image.read::<[u16; 4]>()?.into_iter().map(rgb).collect())
    }

    fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
    }

    pub(super) fn meshes(&self, commands: &mut Commands, kernels: &Kernels, shading: Shading) {
        match shading {
            Shading::Forward => self.forward(commands, kernels),
            Shading::Deferred => {
                self.gbuffer(commands, kernels);
                self.deferred(commands, kernels);
            }
        }
    }

    fn forward(&self, commands: &mut Commands, kernels: &Kernels) {
        commands.pass("consume.forward", |pass| {
            let colors = [
                Target { image: &self.color, clear: self.sky() },
                Target { image: &self.distance, clear: Some([self.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(&kernels.forward, &(), self.triangle_vertices, 1);
            });
        });
    }

    fn gbuffer(&self, commands: &mut Commands, kernels: &Kernels) {
        commands.pass("consume.gbuffer", |pass| {
            let colors = [
                Target { image: &self.albedo, clear: Some([0.0; 4]) },
                Target { image: &self.normal, clear: Some([0.0; 4]) },
                Target { image: &self.distance, clear: Some([self.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(&kernels.gbuffer, &(), self.triangle_vertices, 1);
            });
        });
    }

    fn deferred(&self, commands: &mut Commands, kernels: &Kernels) {
        commands.pass("consume.deferred", |pass| {
            let colors = [Target { image: &self.color, clear: self.sky() }];
            pass.render(self.color.size(), &colors, None, |draw| draw.draw(&kernels.deferred, &(), 3, 1));
        });
    }

    fn caster(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.caster", |pass| {
            let colors = [Target { image: &self.color, clear: None }];
            pass.render(self.color.size(), &colors, None, |draw| draw.draw(kernel, &(), 6 * self.caster_count, 1));
        });
    }

    fn vertex_lit(&self, commands: &mut Commands, kernel: &Kernel<SpacingPush>, push: &SpacingPush) {
        commands.pass("consume.vertex_lit", |pass| self.patches(pass, push, [(kernel, 0..self.caster_count)]));
    }

    /// Draws casters as patches, with each kernel those of a range from far to near.
    fn patches<'k>(
        &self,
        pass: &mut Pass,
        push: &SpacingPush,
        draws: impl IntoIterator<Item = (&'k Kernel<SpacingPush>, Range<u32>)>,
    ) {
        let colors = [Target { image: &self.color, clear: None }];
        pass.render(self.color.size(), &colors, None, |draw| {
            for (kernel, casters) in draws {
                draw.draw_patches(kernel, push, casters);
            }
        });
    }

    /// What draws casters as patches, lit at the vertices, or as lines.
    fn tessellated(&self, answer: &Answer, fragment: &Shader, lines: bool) -> Result<Kernel<SpacingPush>> {
        let colors = [(self.color_format, Blend::Over)];
        let state = Graphics { vertex: &shaders::VERTEX_LIT_VERT, fragment, colors: &colors, depth: None };
        let evaluation = shaders::VERTEX_LIT_TESE.of(answer.folder);
        let stages = Tessellated { control: &shaders::VERTEX_LIT_TESC, evaluation, lines };
        let sets = [&self.scene, answer.bindings, &self.distances];
        Kernel::tessellated(&self.context, &state, &stages, &sets, answer.constants)
    }

    /// What draws the picture, lit by `answer`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what `lighting` needs, [`crate::Error::Gpu`] where the driver
    /// rejects a shader.
    pub fn kernels(&self, answer: &Answer, lighting: Lighting) -> Result<Kernels> {
        self.context.features().require(lighting.requires())?;
        let make = |vertex, fragment, colors: &[(Format, Blend)], depth, sets: &[&Bindings]| {
            let state = Graphics { vertex, fragment, colors, depth };
            Kernel::graphics(&self.context, &state, sets, answer.constants)
        };
        let (scene, asked) = (&self.scene, answer.bindings);
        let color = (self.color_format, Blend::None);
        let float4 = (Format::R32G32B32A32_SFLOAT, Blend::None);
        let distance = (Format::R32_SFLOAT, Blend::None);
        let depth = Some(Format::D32_SFLOAT);
        let surface = &shaders::SURFACE_VERT;
        let forward = shaders::FORWARD_FRAG.of(answer.folder);
        let deferred = shaders::DEFERRED_FRAG.of(answer.folder);
        let lit = [scene, asked, &self.buffers];
        Ok(Kernels {
            forward: make(surface, forward, &[color, distance], depth, &[scene, asked])?,
            gbuffer: make(surface, &shaders::GBUFFER_FRAG, &[float4, float4, distance], depth, &[scene])?,
            deferred: make(&shaders::FULLSCREEN_VERT, deferred, &[color], None, &lit)?,
            casters: match lighting {
                Lighting::Fragment => {
                    let sets = [scene, asked, &self.distances];
                    let fragment = shaders::CASTER_FRAG.of(answer.folder);
                    let over = [(self.color_format, Blend::Over)];
                    Casters::Fragment(make(&shaders::CASTER_VERT, fragment, &over, None, &sets)?)
                }
                Lighting::Vertex { spacing } => Casters::Vertex(
                    self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?,
                    SpacingPush { spacing },
                ),
            },
        })
    }
}
