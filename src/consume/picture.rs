//! The shaded picture: meshes forward, deferred, in tiles, by a part of the lights or by one per pixel, then casters from far to near. Twin:
//! reference::truth::picture.

use super::gbuffer::GBuffer;
use super::half::from_half;
use super::interleaved::{Interleaved, PartsSeen};
use super::many_lights::{Asking, ManyLights, Targets, TilesSeen};
use super::reservoir::Reservoirs;
use super::sliced::Sliced;
use super::{Lighting, Shading, Tiled};
use crate::gpu::{
    Bindings, Blend, Buffer, Commands, Context, Format, Graphics, Image, ImageUse, Kernel, Memory, Pass, PassTime,
    Requirement, Shader, Target, Tessellated, push_struct,
};
use crate::scene::{Picture, SKY, View, far_to_near};
use crate::shaders::consume as shaders;
use crate::shaders::set;
use crate::technique::{Answer, Technique};
use crate::world::World;
use crate::{Error, Result};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Images and bindings for one scene and size.
pub struct Renderer {
    pub(super) context: Context,
    pub(super) color: Image,
    pub(super) depth: Image,
    pub(super) albedo: Image,
    pub(super) normal: Image,
    pub(super) distance: Image,
    pub(super) scene: Bindings,
    /// Albedo, normal and z, as textures.
    pub(super) buffers: Bindings,
    pub(super) distances: Bindings,
    pub(super) color_format: Format,
    lights: Buffer,
    light_count: u32,
    pub(super) camera: View,
    camera_data: Buffer,
    order: Buffer,
    splats: Buffer,
    /// What `shading=tiled` keeps from frame to frame, once it was asked for.
    tiles: RefCell<Option<Rc<ManyLights>>>,
    pub(super) triangle_vertices: u32,
    pub(super) caster_count: u32,
}

push_struct! {
    /// Twin: SpacingPush in glsl/consume/vertex_lit.tesc.
    struct SpacingPush { spacing: f32 }
}

/// What draws a picture, lit by one technique.
pub struct Kernels {
    meshes: Meshes,
    casters: Casters,
}

/// What draws the meshes.
enum Meshes {
    Forward(Kernel),
    Deferred { gbuffer: GBuffer, deferred: Kernel },
    Tiled { gbuffer: GBuffer, tiles: Rc<ManyLights>, asking: Asking },
    Interleaved { gbuffer: GBuffer, interleaved: Interleaved },
    Reservoir { gbuffer: GBuffer, reservoirs: Reservoirs },
}

/// What draws the casters.
enum Casters {
    Fragment(Kernel),
    Vertex(Kernel<SpacingPush>, SpacingPush),
    Sliced(Sliced),
}

/// The casters in the order in which they are blended.
fn blended(world: &World, camera: &View) -> Result<Vec<u32>> {
    if world.caster_count() == 0 {
        return Ok(Vec::new());
    }
    let needs = "a scene that the host knows, for the order in which smoke and hair are blended: draw these otherwise";
    let scene = world.scene().map_err(|_| Error::Refused { needs: needs.into() })?;
    Ok(far_to_near(scene, camera))
}

/// The place of the first splat or cell among the casters, then the colours of all: words of the buffer `Splats` of glsl/consume/picture_set.glsl.
fn splat_colors(world: &World) -> Result<Vec<u32>> {
    if !world.has_packed() {
        return Ok(vec![0; 4]);
    }
    let scene = world.scene()?;
    let first = (scene.particles.len() + scene.strands.len()) as u32;
    let splats = scene.gaussians.iter().map(|g| g.color);
    let cells = scene.volumes.iter().flat_map(|v| std::iter::repeat_n(v.placed().color, v.cells().len()));
    Ok(std::iter::once(first).chain(splats.chain(cells).flat_map(|color| color.map(f32::to_bits))).collect())
}

impl Kernels {
    /// With `shading=reservoir`, frames are counted from `frame` on, each of which draws other lights, and what was kept is forgotten.
    pub fn begin_at(&self, frame: u32) {
        if let Meshes::Reservoir { reservoirs, .. } = &self.meshes {
            reservoirs.begin_at(frame);
        }
    }
}

impl Renderer {
    /// Prepares pictures of the world as it is now, as `camera` sees it.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out; [`Error::Refused`] where buffers of the caller's fill the world and there is smoke or hair
    /// in it, whose order the host does not know.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let size = [camera.width, camera.height];
        // Blending into 32-bit floats is optional; half floats are everywhere, at a thousandth of precision.
        let color_format =
            if context.features().float32_blend { Format::R32G32B32A32_SFLOAT } else { Format::R16G16B16A16_SFLOAT };
        let image = |name, format, usage| Image::new(context, name, format, size, usage);
        let color = image("picture.color", color_format, ImageUse::StoredColor)?;
        let depth = image("picture.depth", Format::D32_SFLOAT, ImageUse::Depth)?;
        let albedo = image("picture.albedo", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let normal = image("picture.normal", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let distance = image("picture.distance", Format::R32_SFLOAT, ImageUse::StoredColor)?;
        let camera_data = Buffer::with_data(context, "picture.camera", &[*camera])?;
        let order = Buffer::new(context, "picture.order", 4 * u64::from(world.caster_capacity()), Memory::Device)?;
        order.write(&blended(world, camera)?)?;
        let colors = splat_colors(world)?;
        let splats = Buffer::new(context, "picture.splats", 4 * colors.len() as u64, Memory::Device)?;
        splats.write(&colors)?;
        let scene = set::PictureScene {
            lights: &world.lights,
            camera: &camera_data,
            triangles: &world.triangles,
            casters: &world.casters,
            order: &order,
            sides: &world.sides,
            splats: &splats,
        };
        let surfaces = set::PictureSurfaces { albedos: &albedo, normals: &normal, distances: &distance };
        let distances = set::PictureDistances { distances: &distance };
        Ok(Self {
            context: context.clone(),
            scene: scene.bind(context, "picture.scene")?,
            buffers: surfaces.bind(context, "picture.buffers")?,
            distances: distances.bind(context, "picture.distances")?,
            color,
            depth,
            albedo,
            normal,
            distance,
            color_format,
            lights: world.lights.clone(),
            light_count: world.light_count(),
            camera: *camera,
            camera_data,
            order,
            splats,
            tiles: RefCell::default(),
            triangle_vertices: 3 * world.triangle_count(),
            caster_count: world.caster_count(),
        })
    }

    /// Sees the world as it is now through another camera of as many pixels: the next frame.
    ///
    /// # Errors
    /// [`Error::Input`] where the camera's picture is of another size, [`Error::Gpu`] where the device is lost.
    pub fn look(&mut self, world: &World, camera: &View) -> Result<()> {
        let size = [camera.width, camera.height];
        if size != self.color.size() {
            let cause = format!("a picture of {size:?} pixels, and the frames before have {:?}", self.color.size());
            return Err(Error::input("the camera", cause, "make a renderer of that size"));
        }
        if *camera != self.camera {
            self.camera_data.write(&[*camera])?;
        }
        self.order.write(&blended(world, camera)?)?;
        self.splats.write(&splat_colors(world)?)?;
        (self.camera, self.caster_count) = (*camera, world.caster_count());
        Ok(())
    }

    /// Draws the picture, lit by `answer`, and reads it. What is averaged with the frame before is drawn as often as it
    /// takes to come to rest.
    ///
    /// # Errors
    /// As [`Renderer::kernels`] and [`Renderer::draw`].
    pub fn picture(&self, answer: &Answer, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.settled(&self.kernels(answer, shading, lighting)?, shading)
    }

    fn settled(&self, kernels: &Kernels, shading: Shading) -> Result<Picture> {
        for _ in 0..shading.frames_to_settle() {
            self.draw(kernels)?;
        }
        self.read()
    }

    /// Draws a frame for each of these cameras, one after the other, and reads them.
    ///
    /// # Errors
    /// As [`Renderer::kernels`], [`Renderer::look`] and [`Renderer::draw`].
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

    /// Draws the next frame; it stays on the device. Returns the time of each pass, the casters' last.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost.
    pub fn draw(&self, kernels: &Kernels) -> Result<Vec<PassTime>> {
        self.frame(kernels, |commands| self.casters(commands, kernels))
    }

    /// Records the passes of the next frame, into a command buffer of the caller's too.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn record(&self, commands: &mut Commands, kernels: &Kernels) -> Result<()> {
        self.meshes(commands, kernels)?;
        self.casters(commands, kernels);
        self.drawn(kernels);
        Ok(())
    }

    /// Draws the meshes, and what `record` adds.
    pub(super) fn frame(&self, kernels: &Kernels, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        let times = self.context.try_submit(|commands| {
            self.meshes(commands, kernels)?;
            record(commands);
            Ok(())
        })?;
        self.drawn(kernels);
        Ok(times)
    }

    /// The next frame is another.
    fn drawn(&self, kernels: &Kernels) {
        if let Meshes::Tiled { tiles, .. } = &kernels.meshes {
            tiles.end(&self.camera);
        }
        if let Meshes::Reservoir { reservoirs, .. } = &kernels.meshes {
            reservoirs.end(&self.camera);
        }
    }

    /// What `shading=tiled` left on the device with the last frame; none where no such kernels were made.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it cannot be read back.
    pub fn tiles_seen(&self) -> Result<Option<TilesSeen>> {
        self.tiles.borrow().as_ref().map(|tiles| tiles.seen()).transpose()
    }

    /// Bytes that `shading=tiled` has between G-buffer and picture; none where no such kernels were made.
    pub fn tiles_bytes(&self) -> Option<u64> {
        self.tiles.borrow().as_ref().map(|tiles| tiles.bytes())
    }

    /// Bytes that `shading=interleaved` or `shading=reservoir` has between G-buffer and picture; none where the kernels are others.
    pub fn estimates_bytes(&self, kernels: &Kernels) -> Option<u64> {
        match &kernels.meshes {
            Meshes::Interleaved { interleaved, .. } => Some(interleaved.gather.estimates.bytes()),
            Meshes::Reservoir { reservoirs, .. } => Some(reservoirs.bytes()),
            _ => None,
        }
    }

    /// What `shading=interleaved` or `shading=reservoir` left on the device with the last frame of these kernels; none where they are
    /// others.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it cannot be read back.
    pub fn parts_seen(&self, kernels: &Kernels) -> Result<Option<PartsSeen>> {
        let (gbuffer, estimates, reservoirs) = match &kernels.meshes {
            Meshes::Interleaved { gbuffer, interleaved } => (gbuffer, &interleaved.gather.estimates, Vec::new()),
            Meshes::Reservoir { gbuffer, reservoirs } => (gbuffer, &reservoirs.gather.estimates, reservoirs.kept()?),
            _ => return Ok(None),
        };
        Ok(Some(PartsSeen {
            reservoirs,
            numbers: gbuffer.numbers.read()?,
            estimates: estimates.read(estimates.bytes() as usize / 12)?,
            albedo: self.albedo.read()?,
            normal: self.normal.read()?,
            z: self.distance.read()?,
        }))
    }

    /// Draws the picture and, over each caster, the sides of the triangles that it is made of; what is nearer hides them.
    ///
    /// # Errors
    /// [`Error::Refused`] where the device lacks tessellation or lines, else as [`Renderer::picture`].
    pub fn wireframe(&self, answer: &Answer, shading: Shading, spacing: f32) -> Result<Picture> {
        self.context.features().require(&[Requirement::Tessellation, Requirement::Lines])?;
        let kernels = self.kernels(answer, shading, Lighting::Vertex { spacing })?;
        let filled = self.tessellated(answer, &shaders::VERTEX_LIT_FRAG, false)?;
        let lines = self.tessellated(answer, &shaders::WIREFRAME_FRAG, true)?;
        self.frame(&kernels, |commands| {
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
    /// [`Error::Gpu`] where the device is lost.
    pub fn read(&self) -> Result<Picture> {
        let pixels = self.read_colors(&self.color)?;
        let [width, height] = self.color.size();
        Ok(Picture { width, height, pixels })
    }

    /// Reads an image that has the format of the colours.
    pub(super) fn read_colors(&self, image: &Image) -> Result<Vec<[f32; 3]>> {
        if self.color_format == Format::R32G32B32A32_SFLOAT {
            return Ok(image.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        }
        let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(from_half);
        Ok(image.read::<[u16; 4]>()?.into_iter().map(rgb).collect())
    }

    /// What the picture is drawn into, to be used further: 32-bit or half floats.
    pub fn image(&self) -> &Image {
        &self.color
    }

    fn sky(&self) -> Option<[f32; 4]> {
        Some([SKY[0], SKY[1], SKY[2], 1.0])
    }

    fn meshes(&self, commands: &mut Commands, kernels: &Kernels) -> Result<()> {
        match &kernels.meshes {
            Meshes::Forward(forward) => self.forward(commands, forward),
            Meshes::Deferred { gbuffer, deferred } => {
                gbuffer.record(commands, self);
                self.deferred(commands, deferred);
            }
            Meshes::Tiled { gbuffer, tiles, asking } => {
                let push = tiles.begin(&self.camera)?;
                gbuffer.record(commands, self);
                tiles.record(commands, asking, &push);
            }
            Meshes::Interleaved { gbuffer, interleaved } => {
                gbuffer.record(commands, self);
                interleaved.record(commands, &self.camera);
            }
            Meshes::Reservoir { gbuffer, reservoirs } => {
                reservoirs.begin()?;
                gbuffer.record(commands, self);
                reservoirs.record(commands, &self.camera);
            }
        }
        Ok(())
    }

    fn casters(&self, commands: &mut Commands, kernels: &Kernels) {
        match &kernels.casters {
            Casters::Fragment(kernel) => self.caster(commands, kernel),
            Casters::Vertex(kernel, push) => self.vertex_lit(commands, kernel, push),
            Casters::Sliced(sliced) => sliced.record(commands, self),
        }
    }

    fn forward(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.forward", |pass| {
            let colors = [
                Target { image: &self.color, clear: self.sky() },
                Target { image: &self.distance, clear: Some([self.camera.far; 4]) },
            ];
            let depth = Target { image: &self.depth, clear: Some([1.0; 4]) };
            pass.render(self.color.size(), &colors, Some(depth), |draw| {
                draw.draw(kernel, &(), self.triangle_vertices, 1);
            });
        });
    }

    fn deferred(&self, commands: &mut Commands, kernel: &Kernel) {
        commands.pass("consume.deferred", |pass| {
            let colors = [Target { image: &self.color, clear: self.sky() }];
            pass.render(self.color.size(), &colors, None, |draw| draw.draw(kernel, &(), 3, 1));
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
    /// [`Error::Refused`] where the device lacks what `lighting` needs or room for tiles, [`Error::Input`] where there are
    /// more lights than a tile has room for, [`Error::Gpu`] where the driver rejects a shader.
    pub fn kernels(&self, answer: &Answer, shading: Shading, lighting: Lighting) -> Result<Kernels> {
        self.context.features().require(lighting.requires())?;
        let make = |vertex, fragment, colors: &[(Format, Blend)], depth, sets: &[&Bindings]| {
            let state = Graphics { vertex, fragment, colors, depth };
            Kernel::graphics(&self.context, &state, sets, answer.constants)
        };
        let (scene, asked) = (&self.scene, answer.bindings);
        let color = (self.color_format, Blend::None);
        let distance = (Format::R32_SFLOAT, Blend::None);
        let depth = Some(Format::D32_SFLOAT);
        let surface = &shaders::SURFACE_VERT;
        let forward = shaders::FORWARD_FRAG.of(answer.folder);
        let deferred = shaders::DEFERRED_FRAG.of(answer.folder);
        let lit = [scene, asked, &self.buffers];
        let gbuffer = || GBuffer::new(self);
        Ok(Kernels {
            meshes: match shading {
                Shading::Forward => {
                    Meshes::Forward(make(surface, forward, &[color, distance], depth, &[scene, asked])?)
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
                Shading::Reservoir => {
                    Meshes::Reservoir { gbuffer: gbuffer()?, reservoirs: Reservoirs::new(self, answer)? }
                }
            },
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

    /// What draws the picture, lit by a technique after a build, or painted by it.
    ///
    /// # Errors
    /// As [`Renderer::kernels`]; [`Error::Refused`] where a technique paints casters that are to be lit at their vertices.
    pub fn kernels_of(&self, technique: &dyn Technique, shading: Shading, lighting: Lighting) -> Result<Kernels> {
        let Some(painter) = technique.painter() else { return self.kernels(&technique.answer(), shading, lighting) };
        if lighting != Lighting::Fragment {
            return Err(Error::Refused { needs: "lighting=fragment: it paints casters itself".into() });
        }
        let kernels = self.kernels(&technique.answer(), shading, lighting)?;
        Ok(Kernels { casters: Casters::Sliced(Sliced::new(self, &technique.answer(), painter)?), ..kernels })
    }

    /// Draws the picture as [`Renderer::picture`] does, lit by a technique after a build, or painted by it.
    ///
    /// # Errors
    /// As [`Renderer::kernels_of`] and [`Renderer::draw`].
    pub fn picture_of(&self, technique: &dyn Technique, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.settled(&self.kernels_of(technique, shading, lighting)?, shading)
    }

    /// Those of the last kernels, or new ones where they were of another kind.
    fn tiles(&self, tiled: Tiled) -> Result<Rc<ManyLights>> {
        let mut kept = self.tiles.borrow_mut();
        if let Some(tiles) = kept.as_ref().filter(|tiles| tiles.tiled == tiled) {
            return Ok(tiles.clone());
        }
        let targets = Targets {
            context: &self.context,
            lights: &self.lights,
            light_count: self.light_count,
            gbuffer: &self.buffers,
            color: &self.color,
            color_format: self.color_format,
        };
        let tiles = Rc::new(ManyLights::new(&targets, tiled)?);
        *kept = Some(tiles.clone());
        Ok(tiles)
    }
}
