//! The shaded picture: first meshes, in one of five ways ([`Shading`]), then casters and volumes from far to near. Twin:
//! reference::truth::picture.

use super::blending::Blending;
use super::display::DisplayState;
use super::half::from_half;
use super::kernels::{Kernels, Meshes};
use super::many_lights::ManyLights;
use super::painter::{Canvas, Lists};
use super::volumes::Volumes;
use super::{Lighting, PainterKind, Shading, lock};
use crate::gpu::{Bindings, Buffer, Commands, Context, Format, Image, ImageUse, Memory, PassTime};
use crate::maps::SeenTriangles;
use crate::scene::{Picture, View};
use crate::shaders::set;
use crate::technique::{Answer, Technique};
use crate::world::World;
use crate::{Error, Result};
use std::cell::RefCell;
use std::sync::{Arc, Mutex};

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
    pub(super) lights: Buffer,
    pub(super) caster_buffer: Buffer,
    pub(super) light_count: u32,
    /// See [`crate::scene::Scene::extinction_ratio`].
    pub(super) extinction_ratio: [f32; 3],
    /// Where casters stand once per color ([`World::colors`]), how many there is room for in each; else 0.
    pub(super) caster_room: u32,
    /// Which kinds of casters there may be: strands, and splats or cells of volumes.
    pub(super) has_strands: bool,
    pub(super) has_packed: bool,
    pub(super) camera: View,
    pub(super) camera_data: Buffer,
    pub(super) splats: Buffer,
    /// What makes pictures: see [`Renderer::paint_by`].
    pub(super) painter: Option<PainterKind>,
    /// See [`Renderer::cut_lists`].
    pub(super) cut: Option<u32>,
    /// What compute passes paint into, made when kernels first need it.
    pub(super) canvas: RefCell<Option<Arc<Canvas>>>,
    /// The triangles that compute passes see, likewise.
    pub(super) seen: RefCell<Option<Arc<Mutex<SeenTriangles>>>>,
    triangle_buffer: Buffer,
    /// The lists of casters of compute passes, likewise.
    pub(super) lists: RefCell<Option<Arc<Mutex<Lists>>>>,
    /// Buffers and passes of `shading=tiled`, made when kernels first need them and kept from frame to frame.
    pub(super) tiles: RefCell<Option<Arc<ManyLights>>>,
    /// Sky, fading ground and smooth normals, for pictures that people look at. Measured pictures have none of these.
    pub(super) shown: Option<DisplayState>,
    pub(super) triangle_vertices: u32,
    /// All casters of the world, with the cells of volumes.
    pub(super) caster_count: u32,
    pub(super) blending: Blending,
    pub(super) volumes: Option<Volumes>,
}

/// Words of the buffer `Splats` of glsl/shading/picture_set.glsl: the index of the first splat or cell among the casters, then the color
/// of each splat and cell.
fn splat_colors(world: &World) -> Result<Vec<u32>> {
    if !world.has_packed() {
        return Ok(vec![0; 4]);
    }
    let needs = "a scene that the host knows, for the colors of splats and volumes in a picture: draw these otherwise";
    let scene = world.scene().map_err(|_| Error::Refused(needs.into()))?;
    let first = (scene.particles.len() + scene.strands.len()) as u32;
    let splats = scene.splats.iter().map(|g| g.color);
    let cells = scene.volumes.iter().flat_map(|v| std::iter::repeat_n(v.placed().color, v.cells().len()));
    Ok(std::iter::once(first).chain(splats.chain(cells).flat_map(|color| color.map(f32::to_bits))).collect())
}

impl Renderer {
    /// Prepares pictures of the world as it is now, as `camera` sees it.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out. [`Error::Refused`] where the caller's buffers fill the world and it has room for splats or
    /// volumes: only a scene has their colors.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let size = [camera.width, camera.height];
        // Devices need not blend into 32-bit floats. All blend into half floats, which are precise to about a thousandth.
        let color_format =
            if context.features().float32_blend { Format::R32G32B32A32_SFLOAT } else { Format::R16G16B16A16_SFLOAT };
        let image = |name, format, usage| Image::new(context, name, format, size, usage);
        let color = image("picture.color", color_format, ImageUse::StoredColor)?;
        let depth = image("picture.depth", Format::D32_SFLOAT, ImageUse::Depth)?;
        let albedo = image("picture.albedo", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let normal = image("picture.normal", Format::R32G32B32A32_SFLOAT, ImageUse::Storage)?;
        let distance = image("picture.distance", Format::R32_SFLOAT, ImageUse::StoredColor)?;
        let camera_data = Buffer::with_data(context, "picture.camera", &[*camera])?;
        let colors = splat_colors(world)?;
        let blending = Blending::new(context, world, camera)?;
        // A sequence of files may have more cells at other times; the buffer has room for the most.
        let most = match world.scene() {
            Ok(scene) if world.has_packed() => 1 + 3 * (scene.splats.len() + scene.most_cells()),
            _ => 0,
        };
        let words = colors.len().max(most) as u64;
        let splats = Buffer::new(context, "picture.splats", 4 * words, Memory::Device)?;
        splats.write(&colors)?;
        let scene = set::PictureScene {
            lights: &world.lights,
            camera: &camera_data,
            triangles: &world.triangles,
            casters: &world.casters,
            order: &blending.order,
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
            caster_buffer: world.casters.clone(),
            triangle_buffer: world.triangles.clone(),
            seen: RefCell::default(),
            painter: None,
            cut: None,
            canvas: RefCell::default(),
            lists: RefCell::default(),
            light_count: world.light_count(),
            extinction_ratio: world.extinction_ratio(),
            caster_room: if world.colors() > 1 { world.caster_capacity() } else { 0 },
            has_strands: world.has_strands(),
            has_packed: world.has_packed(),
            camera: *camera,
            camera_data,
            splats,
            tiles: RefCell::default(),
            shown: None,
            triangle_vertices: 3 * world.triangle_count(),
            caster_count: world.caster_count(),
            blending,
            volumes: Volumes::new(context, world)?,
        })
    }

    /// Readies the next frame: the world as it is now, seen by a camera with the same number of pixels.
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
            self.seen.borrow().as_ref().map_or(Ok(()), |seen| lock(seen).look(camera))?;
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
        if world.has_packed() {
            self.splats.write(&splat_colors(world)?)?;
        }
        (self.camera, self.caster_count) = (*camera, world.caster_count());
        (self.triangle_vertices, self.light_count) = (3 * world.triangle_count(), world.light_count());
        if let Some(shown) = &mut self.shown {
            shown.look(world)?;
        }
        Ok(())
    }

    /// Says what makes the pictures of kernels that are made from now on; none: what is faster on most devices of such a kind.
    pub fn paint_by(&mut self, painter: Option<PainterKind>) {
        self.painter = painter;
    }

    /// What makes pictures, where nothing else was said.
    pub(super) fn painter_kind(&self) -> PainterKind {
        self.painter.unwrap_or(PainterKind::usual(self.context.features()))
    }

    /// What finds the triangles that pixels see, which all kernels of this renderer share.
    pub(super) fn seen_triangles(&self) -> Result<Arc<Mutex<SeenTriangles>>> {
        let mut kept = self.seen.borrow_mut();
        if let Some(seen) = &*kept {
            return Ok(seen.clone());
        }
        let seen = SeenTriangles::new(&self.context, &self.caster_buffer, &self.triangle_buffer, &self.camera)?;
        let seen = Arc::new(Mutex::new(seen));
        *kept = Some(seen.clone());
        Ok(seen)
    }

    /// Sorts and lists all casters with the next picture, even where nothing has moved: for whoever measures a moving world's frame.
    pub fn forget_order(&self) {
        self.blending.forget();
    }

    /// When the frame `frame`, which [`Renderer::record`] was recorded in, is over: whether its picture is complete. Where the casters had
    /// no room in the lists of compute passes, the lists have grown, and the next frame has them. Lists of large triangles grow too; with too
    /// little room these only take longer.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn settle(&self, kernels: &Kernels, frame: u64) -> Result<bool> {
        self.seen.borrow().as_ref().map_or(Ok(false), |seen| lock(seen).settle(frame))?;
        kernels.casters.settle(frame).map(|grew| !grew)
    }

    /// Draws the picture, lit by `answer`, and reads it. A picture that is averaged with earlier frames is drawn until
    /// it settles.
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

    /// Draws and reads one frame per camera, in order.
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

    /// Records the passes of the next frame; `commands` may be the caller's own command buffer.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
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

    /// Keeps this frame's camera for shading that reuses the frame before.
    pub(super) fn drawn(&self, kernels: &Kernels) {
        if let Meshes::Tiled { tiles, .. } = &kernels.meshes {
            tiles.end(&self.camera);
        }
        if let Meshes::Reservoir { reservoirs, .. } = &kernels.meshes {
            reservoirs.end(&self.camera);
        }
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

    /// Reads an image of the format [`Renderer::color_format`].
    pub(super) fn read_colors(&self, image: &Image) -> Result<Vec<[f32; 3]>> {
        if self.color_format == Format::R32G32B32A32_SFLOAT {
            return Ok(image.read::<[f32; 4]>()?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect());
        }
        let rgb = |p: [u16; 4]| [p[0], p[1], p[2]].map(from_half);
        Ok(image.read::<[u16; 4]>()?.into_iter().map(rgb).collect())
    }

    /// The image that the picture is drawn into, for further use: 32-bit or half floats.
    pub fn image(&self) -> &Image {
        &self.color
    }

    /// Draws the picture as [`Renderer::picture`] does. A built technique lights it, or paints the casters itself.
    ///
    /// # Errors
    /// As [`Renderer::kernels_of`] and [`Renderer::draw`].
    pub fn picture_of(&self, technique: &dyn Technique, shading: Shading, lighting: Lighting) -> Result<Picture> {
        self.settled(&self.kernels_of(technique, shading, lighting)?, shading)
    }
}
