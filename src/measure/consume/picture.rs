//! The shaded picture: meshes forward or deferred, then casters from far to near. Twin: reference::picture.

use super::built_for;
use crate::Result;
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, PassTime, Pipeline, Resource,
    Target, shader,
};
use crate::reference::{SKY, far_to_near};
use crate::scene::{Picture, Scene, View};
use crate::technique::{LightData, SceneData, Visibility};

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
    caster_vertices: u32,
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
            caster_vertices: 6 * data.caster_count,
        })
    }

    /// Draws the picture, lit by `visibility`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects a shader or the device is lost.
    pub fn picture(&self, visibility: &Visibility, shading: Shading) -> Result<(Picture, Vec<PassTime>)> {
        let pipelines = Pipelines::new(self, visibility)?;
        let times = self.context.submit(|commands| {
            match shading {
                Shading::Forward => self.forward(commands, &pipelines, visibility),
                Shading::Deferred => {
                    self.gbuffer(commands, &pipelines);
                    self.deferred(commands, &pipelines, visibility);
                }
            }
            self.casters(commands, &pipelines, visibility);
        })?;
        let pixels = if self.color_format == Format::R32G32B32A32_SFLOAT {
            self.color.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
        } else {
            let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(|c| half::f16::from_bits(c).to_f32());
            self.color.read::<[u16; 4]>()?.into_iter().map(rgb).collect()
        };
        let [width, height] = self.color.size();
        Ok((Picture { width, height, pixels }, times))
    }

    fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
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

    fn casters(&self, commands: &mut Commands, pipelines: &Pipelines, visibility: &Visibility) {
        commands.pass("consume.caster", |pass| {
            let colors = [Target { image: &self.color, clear: None }];
            pass.render(self.color.size(), &colors, None, |draw| {
                let sets = [&self.scene, visibility.bindings, &self.distances];
                draw.draw(&pipelines.caster, &sets, &[], self.caster_vertices);
            });
        });
    }
}

struct Pipelines {
    forward: Pipeline,
    gbuffer: Pipeline,
    deferred: Pipeline,
    caster: Pipeline,
}

impl Pipelines {
    fn new(renderer: &Renderer, visibility: &Visibility) -> Result<Self> {
        let make = |vertex, fragment, colors: &[(Format, Blend)], depth, sets: &[&Bindings]| {
            let state = Graphics { vertex, fragment, colors, depth };
            Pipeline::graphics(&renderer.context, &state, sets, visibility.constants)
        };
        let surface = shader("consume/surface.vert")?;
        let (scene, asked) = (&renderer.scene, visibility.bindings);
        let color = (renderer.color_format, Blend::None);
        let float4 = (Format::R32G32B32A32_SFLOAT, Blend::None);
        let distance = (Format::R32_SFLOAT, Blend::None);
        Ok(Self {
            forward: make(surface, built_for(visibility, "forward.frag")?, &[color, distance], true, &[scene, asked])?,
            gbuffer: make(surface, shader("consume/gbuffer.frag")?, &[float4, float4, distance], true, &[scene])?,
            deferred: make(
                shader("consume/fullscreen.vert")?,
                built_for(visibility, "deferred.frag")?,
                &[color],
                false,
                &[scene, asked, &renderer.buffers],
            )?,
            caster: make(
                shader("consume/caster.vert")?,
                built_for(visibility, "caster.frag")?,
                &[(renderer.color_format, Blend::Over)],
                false,
                &[scene, asked, &renderer.distances],
            )?,
        })
    }
}
