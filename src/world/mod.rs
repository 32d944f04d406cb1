//! Casters and lights on the device in their present state: casters, triangles, lights, and generations that say which
//! part has changed. A [`Scene`] of the host fills a world ([`World::new`]), or the caller's buffers do
//! ([`World::of`]).

mod bounds;
mod camera_push;
mod external;
mod gather;
mod generations;
mod light;
mod lights;
mod source;
mod staged;

pub(crate) use camera_push::CameraPush;
pub use external::Capacity;
pub use generations::Parts;
pub use source::{Corners, Count, LightAt, LightType, Number, Source, SphereAt, SplatAt, StrandAt};

// For the program and the tests.
#[doc(hidden)]
pub use self::{
    gather::{GatherTotals, Gathered},
    generations::{BuildStamp, Generations},
    light::LightData,
    staged::Moved,
};

use self::bounds::Bounds;
use self::external::External;
use crate::gpu::{Buffer, Context};
use crate::scene::{Aim, Camera, Caster, Kinds, Light, Mesh, Scene};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Twin: Triangle in glsl/world/triangle.glsl.
#[doc(hidden)]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleData {
    /// World units.
    pub corners: [[f32; 3]; 3],
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
}

/// Casters and lights on the device. All techniques of a scene share it.
pub struct World {
    context: Context,
    name: String,
    generations: Generations,
    /// [`Caster`]: spheres, then strands, then splats, then cells of volumes; [`World::caster_count`] of them, once per
    /// color ([`World::colors`]), each color behind the room for [`World::caster_capacity`] of the one before.
    pub(crate) casters: Buffer,
    caster_capacity: u32,
    /// How many times casters and lights stand in the buffers: see [`World::colors`].
    colors: u32,
    /// How many of [`World::casters`] are particles.
    particle_count: u32,
    strand_count: u32,
    splat_count: u32,
    cell_count: u32,
    /// [`TriangleData`].
    pub(crate) triangles: Buffer,
    triangle_capacity: u32,
    triangle_count: u32,
    /// Per triangle, [`Side::sign`](crate::scene::Side::sign): 1 where a ray along its normal leaves a closed mesh, −1
    /// where it enters one, 0 where the mesh is not closed or that is not known.
    pub(crate) sides: Buffer,
    /// Whether there may be strands. Without strands, kernels are compiled for spheres alone.
    strands: bool,
    /// Whether there may be splats or cells of volumes, likewise.
    packed: bool,
    /// [`LightData`].
    pub(crate) lights: Buffer,
    /// The lights as the host knows them.
    lit: Vec<Light>,
    /// Whether `lit` holds the real lights; else it holds stand-ins of the same types.
    knows_lights: bool,
    camera: Option<Camera>,
    /// See [`Aim::anchors`].
    anchors: [DVec3; 2],
    /// The bounds of the meshes, then of smoke and hair, as far as the host knows them.
    bounds: Option<[Bounds; 2]>,
    filled: WorldSource,
}

/// Buffers of a world, for whoever reads back what is in them.
#[doc(hidden)]
pub struct WorldBuffers<'a> {
    /// A [`Caster`] each.
    pub casters: &'a Buffer,
    /// A [`TriangleData`] each.
    pub triangles: &'a Buffer,
    /// A [`LightData`] each.
    pub lights: &'a Buffer,
}

/// Where a world's casters and lights come from.
enum WorldSource {
    Scene(Box<StagedWorld>),
    External(Box<External>),
}

/// A scene of the host's.
struct StagedWorld {
    scene: Scene,
    /// Whether the casters on the device differ from those in the host's scene.
    written: bool,
    /// Whether a copy failed. Then the device's data are partly of the old scene and partly of the new one.
    mixed: bool,
}

impl World {
    /// The world's name in errors: the name of its scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The buffers on the device.
    #[doc(hidden)]
    pub fn buffers(&self) -> WorldBuffers<'_> {
        WorldBuffers { casters: &self.casters, triangles: &self.triangles, lights: &self.lights }
    }

    /// The present scene that fills the world. Where the device simulates its particles, these are as they were last
    /// read back.
    ///
    /// # Errors
    /// [`Error::Refused`] where the caller's buffers fill the world, and the host knows no scene.
    pub fn scene(&self) -> Result<&Scene> {
        match &self.filled {
            WorldSource::Scene(staged) => Ok(&staged.scene),
            WorldSource::External(_) => Err(Error::Refused("a scene that the host knows".into())),
        }
    }

    /// The scene's [`Scene::extinction_ratio`]; [`Scene::GREY`] where the caller's buffers fill the world.
    pub fn extinction_ratio(&self) -> [f32; 3] {
        self.scene().map_or(Scene::GREY, |scene| scene.extinction_ratio)
    }

    /// 3 where casters take red, green and blue light in different ratios ([`Scene::with_inks`]), else 1. Lights then stand
    /// once per color, and so do casters, with the extinctions of that color.
    pub fn colors(&self) -> u32 {
        self.colors
    }

    /// Checks that all casters have one extinction ratio, for what keeps one number for all lights.
    ///
    /// # Errors
    /// [`Error::Refused`] where they do not. `keeper` is what keeps one.
    pub fn one_color(&self, keeper: &str) -> Result<()> {
        if self.colors == 1 {
            return Ok(());
        }
        let needs = format!("casters of one extinction ratio: {keeper} one number for all colors of light");
        Err(Error::Refused(needs.into()))
    }

    /// Counters, one per part of the world, that rise whenever the part has changed.
    pub fn generations(&self) -> &Generations {
        &self.generations
    }

    /// Casters that kernels go through: all present ones. Where only the device knows their count, casters that cast
    /// nothing are behind these.
    pub fn caster_count(&self) -> u32 {
        self.particle_count + self.strand_count + self.splat_count + self.cell_count
    }

    /// Those of them that are cells of volumes. They come last.
    pub(crate) fn cell_count(&self) -> u32 {
        self.cell_count
    }

    /// Whether there are strands: casters whose radius may reach into a view although both ends lie outside it.
    pub fn shows_strands(&self) -> bool {
        self.strand_count > 0
    }

    /// Whether there may be strands, which is so where the scene began with some.
    pub fn has_strands(&self) -> bool {
        self.strands
    }

    /// Whether there may be splats or cells of volumes, which is so where the scene began with some.
    pub fn has_splats_or_cells(&self) -> bool {
        self.packed
    }

    /// Casters that there is room for: as many as the scene ever has, or began with.
    pub fn caster_capacity(&self) -> u32 {
        self.caster_capacity
    }

    /// Triangles of all meshes.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Triangles that there is room for.
    pub fn triangle_capacity(&self) -> u32 {
        self.triangle_capacity
    }

    /// How many casters there are, by kind; in a world of the caller's buffers, how many there may be.
    pub fn kinds(&self) -> Kinds {
        match &self.filled {
            WorldSource::Scene(staged) => staged.scene.kinds(),
            WorldSource::External(theirs) => theirs.capacity.kinds(),
        }
    }

    /// The lights as the host knows them. Where only the device knows them ([`World::update_lights_from_buffer`]), these are
    /// dark lights of the same types.
    pub fn all_lights(&self) -> &[Light] {
        &self.lit
    }

    /// Whether the host knows where the lights are.
    pub fn knows_lights(&self) -> bool {
        self.knows_lights
    }

    /// How many lights there are.
    pub fn light_count(&self) -> u32 {
        self.lit.len() as u32
    }

    /// Maps of all lights: those of the first light first.
    pub fn map_count(&self) -> usize {
        self.lit.iter().map(Light::map_count).sum()
    }

    /// Checks that the lights have `count` maps, as something that was opened for them expects.
    ///
    /// # Errors
    /// [`Error::Input`] where the lights have another number of maps.
    pub fn has_maps(&self, count: usize) -> Result<()> {
        if self.map_count() == count {
            return Ok(());
        }
        let cause = format!("its lights have {} maps, and a technique was opened for {count}", self.map_count());
        Err(Error::input(
            self.name.clone(),
            cause,
            "open the technique anew, or begin with all lights that there will be",
        ))
    }

    /// Whether any light has the six maps of a cube's faces.
    pub fn has_faces(&self) -> bool {
        self.lit.iter().any(|light| light.map_count() > 1)
    }

    /// What the views of the lights are aimed by, where the host knows the lights.
    pub fn aim(&self) -> Aim<'_> {
        Aim { lights: &self.lit, anchors: self.anchors, has_triangles: self.triangle_capacity > 0 }
    }

    /// The camera, if one was set.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// The meshes, where the host knows them.
    pub fn meshes(&self) -> Option<&[Mesh]> {
        self.scene().ok().map(|scene| scene.meshes.as_slice())
    }

    /// Points whose convex hull holds all meshes: the vertices of the meshes, or the corners of the box that the caller
    /// gave.
    ///
    /// # Errors
    /// [`Error::Refused`] where the host knows neither the vertices nor a box.
    pub fn mesh_hull(&self) -> Result<Box<dyn Iterator<Item = [f32; 3]> + '_>> {
        match (&self.filled, self.bounds) {
            (WorldSource::Scene(staged), _) => {
                Ok(Box::new(staged.scene.meshes.iter().flat_map(|m| m.positions.iter().copied())))
            }
            (_, Some([meshes, _])) => Ok(Box::new(meshes.corners().into_iter())),
            _ => Err(Error::Refused("a box about all triangles (World::set_box)".into())),
        }
    }

    /// A box about all casters, low and high corner, as far as the host knows one. It may be larger than needed.
    pub fn known_box(&self) -> Option<[DVec3; 2]> {
        self.bounds.map(|[meshes, casters]| meshes.with(casters).ends())
    }
}

// Casters have the same layout on the device and on the host.
const _: () = assert!(size_of::<Caster>() == 32);
