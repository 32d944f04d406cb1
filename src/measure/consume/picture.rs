//! The shaded picture: meshes forward or deferred, then casters from far to near. Twin: reference::picture.

use super::{Lighting, built_for};
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, Pass, PassTime, Pipeline,
    Requirement, Resource, Shader, Target, Tessellated, shader,
};
use crate::scene::{Picture, SKY, Scene, View, far_to_near};
use crate::technique::{LightData, SceneData, Visibility};
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
    context: Context,
    color: Image,
    depth: Image,
    albedo: Image,
    normal: Image,
    distance: Image,
    scene: Bindings,
    buffers: Bindings,
    distances: Bindings,
    color_format: Format,
    far: f32,
    triangle_vertices: u32,
    caster_count: u32,
}

/// What draws a picture, lit by one technique.
pub struct Pipelines {
    forward: Pipeline,
    gbuffer: Pipeline,
    deferred: Pipeline,
    casters: Pipeline,
    lighting: Lighting,
}

impl Renderer {
    /// Prepares pictures of `scene` as `camera` sees it.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene, data: &SceneData, camera: &View) -> Result<Self> {
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
            Resource::Buffer(Buffer::with_data(context, "picture.lights", &LightData::all(scene))?),
            Resource::Buffer(Buffer::with_data(context, "picture.camera", &[*camera])?),
            Resource::Buffer(data.triangles.clone()),
            Resource::Buffer(data.casters.clone()),
            Resource::Buffer(Buffer::with_data(context, "picture.order", &far_to_near(scene, camera))?),
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
            triangle_vertices: 3 * data.triangle_count,
            caster_count: data.caster_count,
        })
    }

    /// Draws the picture, lit by `visibility`, and reads it.
    ///
    /// # Errors
    /// As [`Renderer::pipelines`] and [`Renderer::draw`].
    pub fn picture(&self, visibility: &Visibility, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.draw(&self.pipelines(visibility, lighting)?, visibility, shading)?;
        self.read()
    }

    /// Draws the picture, lit by `visibility`; it stays on the device. Returns the time of each pass, the casters' last.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn draw(&self, pipelines: &Pipelines, visibility: &Visibility, shading: Shading) -> Result<Vec<PassTime>> {
        self.context.submit(|commands| {
            self.meshes(commands, pipelines, visibility, shading);
            match pipelines.lighting {
                Lighting::Fragment => self.caster(commands, pipelines, visibility),
                Lighting::Vertex { spacing } => self.vertex_lit(commands, pipelines, visibility, spacing),
            }
        })
    }

    /// Draws the picture and, over each caster, the sides of the triangles that it is made of; what is nearer hides them.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks tessellation or lines, else as [`Renderer::picture`].
    pub fn wireframe(&self, visibility: &Visibility, shading: Shading, spacing: f32) -> Result<Picture> {
        self.context.features().require(&[Requirement::Tessellation, Requirement::Lines])?;
        let pipelines = self.pipelines(visibility, Lighting::Vertex { spacing })?;
        let lines = self.tessellated(visibility, shader("consume/wireframe.frag")?, true)?;
        self.context.submit(|commands| {
            self.meshes(commands, &pipelines, visibility, shading);
            commands.pass("consume.wireframe", |pass| {
                let both = (0..self.caster_count).flat_map(|i| [(&pipelines.casters, i..i + 1), (&lines, i..i + 1)]);
                self.patches(pass, visibility, spacing, both);
            });
        })?;
        self.read()
    }

    /// The picture that was drawn last.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn read(&self) -> Result<Picture> {
        let pixels = if self.color_format == Format::R32G32B32A32_SFLOAT {
            self.color.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        } else {
            let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(|c| half::f16::from_bits(c).to_f32());
            self.color.read::<[u16; 4]>()?.into_iter().map(rgb).collect()
        };
        let [width, height] = self.color.size();
        Ok(Picture { width, height, pixels })
    }

    fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
    }

    fn meshes(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility, shading: Shading) {
        match shading {
            Shading::Forward => self.forward(commands, pipelines, visibility),
            Shading::Deferred => {
                self.gbuffer(commands, pipelines);
                self.deferred(commands, pipelines, visibility);
            }
        }
    }

    fn forward(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility) {
        commands.pass("consume.forward", |pass| {
            let colors = [
                Target { image: &self.color, clear: self.sky() },
                Target { image: &self.distance, clear: Some([self.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(&pipelines.forward, &[&self.scene, visibility.bindings], &[], self.triangle_vertices);
            });
        });
    }

    fn gbuffer(&self, commands: &mut Commands, pipelines: &Pipelines) {
        commands.pass("consume.gbuffer", |pass| {
            let colors = [
                Target { image: &self.albedo, clear: Some([0.0; 4]) },
                Target { image: &self.normal, clear: Some([0.0; 4]) },
                Target { image: &self.distance, clear: Some([self.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(&pipelines.gbuffer, &[&self.scene], &[], self.triangle_vertices);
            });
        });
    }

    fn deferred(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility) {
        commands.pass("consume.deferred", |pass| {
            let colors = [Target { image: &self.color, clear: self.sky() }];
            pass.render(self.color.size(), &colors, None, |draw| {
                draw.draw(&pipelines.deferred, &[&self.scene, visibility.bindings, &self.buffers], &[], 3);
            });
        });
    }

    fn caster(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility) {
        commands.pass("consume.caster", |pass| {
            let colors = [Target { image: &self.color, clear: None }];
            pass.render(self.color.size(), &colors, None, |draw| {
                let sets = [&self.scene, visibility.bindings, &self.distances];
                draw.draw(&pipelines.casters, &sets, &[], 6 * self.caster_count);
            });
        });
    }

    fn vertex_lit(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility, spacing: f32) {
        let all = [(&pipelines.casters, 0..self.caster_count)];
        commands.pass("consume.vertex_lit", |pass| self.patches(pass, visibility, spacing, all));
    }

    /// Draws casters as patches, with each pipeline those of a range from far to near.
    fn patches<'p>(
        &self,
        pass: &mut Pass,
        visibility: &Visibility,
        spacing: f32,
        draws: impl IntoIterator<Item = (&'p Pipeline, Range<u32>)>,
    ) {
        let colors = [Target { image: &self.color, clear: None }];
        pass.render(self.color.size(), &colors, None, |draw| {
            let sets = [&self.scene, visibility.bindings, &self.distances];
            for (pipeline, casters) in draws {
                draw.draw_patches(pipeline, &sets, bytemuck::bytes_of(&spacing), casters);
            }
        });
    }

    /// What draws casters as patches, lit at the vertices, or as lines.
    fn tessellated(&self, visibility: &Visibility, fragment: &Shader, lines: bool) -> Result<Pipeline> {
        let colors = [(self.color_format, Blend::Over)];
        let state = Graphics { vertex: shader("consume/vertex_lit.vert")?, fragment, colors: &colors, depth: false };
        let control = shader("consume/vertex_lit.tesc")?;
        let evaluation = built_for(visibility, "vertex_lit.tese")?;
        let stages = Tessellated { control, evaluation, lines };
        let sets = [&self.scene, visibility.bindings, &self.distances];
        Pipeline::tessellated(&self.context, &state, &stages, &sets, visibility.constants)
    }

    /// What draws the picture, lit by `visibility`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what `lighting` needs, [`crate::Error::Gpu`] where the driver
    /// rejects a shader.
    pub fn pipelines(&self, visibility: &Visibility, lighting: Lighting) -> Result<Pipelines> {
        self.context.features().require(lighting.requires())?;
        let make = |vertex, fragment, colors: &[(Format, Blend)], depth, sets: &[&Bindings]| {
            let state = Graphics { vertex, fragment, colors, depth };
            Pipeline::graphics(&self.context, &state, sets, visibility.constants)
        };
        let surface = shader("consume/surface.vert")?;
        let (scene, asked) = (&self.scene, visibility.bindings);
        let color = (self.color_format, Blend::None);
        let float4 = (Format::R32G32B32A32_SFLOAT, Blend::None);
        let distance = (Format::R32_SFLOAT, Blend::None);
        Ok(Pipelines {
            forward: make(surface, built_for(visibility, "forward.frag")?, &[color, distance], true, &[scene, asked])?,
            gbuffer: make(surface, shader("consume/gbuffer.frag")?, &[float4, float4, distance], true, &[scene])?,
            deferred: make(
                shader("consume/fullscreen.vert")?,
                built_for(visibility, "deferred.frag")?,
                &[color],
                false,
                &[scene, asked, &self.buffers],
            )?,
            casters: match lighting {
                Lighting::Fragment => make(
                    shader("consume/caster.vert")?,
                    built_for(visibility, "caster.frag")?,
                    &[(self.color_format, Blend::Over)],
                    false,
                    &[scene, asked, &self.distances],
                )?,
                Lighting::Vertex { .. } => self.tessellated(visibility, shader("consume/vertex_lit.frag")?, false)?,
            },
            lighting,
        })
    }
}
