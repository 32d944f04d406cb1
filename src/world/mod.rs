//! The current state on the device: casters, triangles, lights, and generations that show which parts have changed. A world is filled from
//! a host [`Scene`] ([`World::new`]) or from the caller's buffers ([`World::of`]).

mod alpha;
mod bounds;
mod camera_push;
mod external;
mod gather;
mod gather_alpha;
mod gather_sheets;
mod generations;
mod light;
mod lights;
mod source;
mod staged;

pub(crate) use camera_push::CameraPush;
pub use external::Capacity;
pub use generations::Parts;
pub use source::{AlphaAt, Corners, Count, LightAt, LightType, Number, Source, SphereAt, SplatAt, StrandAt, TextureAt};

// Used by the program and the tests.
#[doc(hidden)]
pub use self::{
    gather::{GatherTotals, Gathered},
    generations::{BuildStamp, Generations},
    light::LightData,
    staged::Moved,
};

use self::bounds::Bounds;
use self::external::External;
use crate::gpu::{Buffer, Constants, Context};
use crate::scene::{Aim, Camera, Caster, Kinds, Light, Mesh, Scene};
use crate::shaders::constant::{ALPHA_FIRST, SHEETS, SPLATS_OR_CELLS, STRANDS};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Twin: Triangle in glsl/world/triangle.glsl.
#[doc(hidden)]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleData {
    /// Corner positions, in world units.
    pub corners: [[f32; 3]; 3],
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
}

/// Casters and lights on the device, shared by all techniques of a scene.
pub struct World {
    context: Context,
    name: String,
    generations: Generations,
    /// Array of [`Caster`]: spheres, then strands, splats, see-through triangles (sheets), and last volume cells, [`World::caster_count`] in total. The array is repeated
    /// once per color ([`World::colors`]), at intervals of [`World::caster_capacity`].
    pub(crate) casters: Buffer,
    caster_capacity: u32,
    /// Number of copies of casters and lights in the buffers: see [`World::colors`].
    colors: u32,
    /// Number of particles in [`World::casters`].
    particle_count: u32,
    strand_count: u32,
    splat_count: u32,
    sheet_count: u32,
    cell_count: u32,
    /// Array of [`TriangleData`], then alpha (glsl/world/alpha.glsl).
    pub(crate) triangles: Buffer,
    triangle_capacity: u32,
    triangle_count: u32,
    /// [`World::triangle_capacity`] if any triangle may have alpha, which is stored behind the triangles; otherwise 0.
    alpha_first: u32,
    /// Raised whenever the alpha of triangles may have changed.
    pub(crate) alpha_generation: u64,
    /// Per triangle, [`Side::sign`](crate::scene::Side::sign): 1 if a ray along its normal leaves a closed mesh, −1 if it enters one, 0 if
    /// the mesh is not closed or this is unknown.
    pub(crate) sides: Buffer,
    /// Whether there may be strands. If not, kernels are compiled without code for strands.
    strands: bool,
    /// Whether there may be splats or volume cells. If not, kernels are compiled without code for them.
    packed: bool,
    /// Whether there may be sheets.
    sheets: bool,
    /// Array of [`LightData`].
    pub(crate) lights: Buffer,
    /// The lights as known to the host.
    lit: Vec<Light>,
    /// Whether `lit` holds the real lights; otherwise it holds stand-ins of the same types.
    knows_lights: bool,
    camera: Option<Camera>,
    /// See [`Aim::anchors`].
    anchors: [DVec3; 2],
    /// The bounds of the meshes, then of smoke and hair, as far as the host knows them.
    bounds: Option<[Bounds; 2]>,
    filled: WorldSource,
}

/// Buffers of a world, for reading back their contents.
#[doc(hidden)]
pub struct WorldBuffers<'a> {
    /// Array of [`Caster`].
    pub casters: &'a Buffer,
    /// Array of [`TriangleData`].
    pub triangles: &'a Buffer,
    /// Array of [`LightData`].
    pub lights: &'a Buffer,
}

/// The source of a world's casters and lights.
enum WorldSource {
    Scene(Box<StagedWorld>),
    External(Box<External>),
}

/// A scene on the host.
struct StagedWorld {
    scene: Scene,
    /// Whether the casters on the device differ from those in the host's scene.
    written: bool,
    /// Whether a copy failed, which leaves the device with data from both the old and the new scene.
    mixed: bool,
}

impl World {
    /// Returns the world's name in errors, which is its scene's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the buffers on the device.
    #[doc(hidden)]
    pub fn buffers(&self) -> WorldBuffers<'_> {
        WorldBuffers { casters: &self.casters, triangles: &self.triangles, lights: &self.lights }
    }

    /// Returns the current scene that fills the world. If the device simulates its particles, they are as last read back.
    ///
    /// # Errors
    /// [`Error::Refused`] if the world is filled from the caller's buffers, so that the host has no scene.
    pub fn scene(&self) -> Result<&Scene> {
        match &self.filled {
            WorldSource::Scene(staged) => Ok(&staged.scene),
            WorldSource::External(_) => Err(Error::Refused("a scene that the host knows".into())),
        }
    }

    /// Returns the scene's [`Scene::extinction_ratio`], or [`Scene::GREY`] if the world is filled from the caller's buffers.
    pub fn extinction_ratio(&self) -> [f32; 3] {
        self.scene().map_or(Scene::GREY, |scene| scene.extinction_ratio)
    }

    /// Returns 3 if casters attenuate red, green and blue light in different ratios ([`Scene::with_inks`]), otherwise 1. In the first case
    /// lights are listed once per color, and so are casters, with that color's extinctions.
    pub fn colors(&self) -> u32 {
        self.colors
    }

    /// Checks that all casters have the same extinction ratio, for code that stores a single number for all lights.
    ///
    /// # Errors
    /// [`Error::Refused`] if they do not. `keeper` describes that code in the message.
    pub fn one_color(&self, keeper: &str) -> Result<()> {
        if self.colors == 1 {
            return Ok(());
        }
        let needs = format!("casters of one extinction ratio: {keeper} one number for all colors of light");
        Err(Error::Refused(needs.into()))
    }

    /// Returns the counters of the world's parts, each incremented whenever its part changes.
    pub fn generations(&self) -> &Generations {
        &self.generations
    }

    /// Returns the number of casters that kernels iterate over, which includes all current ones. If only the device knows the number of
    /// current casters, the rest cast nothing.
    pub fn caster_count(&self) -> u32 {
        self.particle_count + self.strand_count + self.splat_count + self.sheet_count + self.cell_count
    }

    /// Returns the number of these casters that are volume cells. They come last.
    pub(crate) fn cell_count(&self) -> u32 {
        self.cell_count
    }

    /// Returns whether there are strands, whose radius may extend into a view even if both ends are outside it.
    pub fn shows_strands(&self) -> bool {
        self.strand_count > 0
    }

    /// Returns whether there may be strands, which is the case if the scene started with some.
    pub fn has_strands(&self) -> bool {
        self.strands
    }

    /// Returns whether there may be splats or volume cells, which is the case if the scene started with some.
    pub fn has_splats_or_cells(&self) -> bool {
        self.packed
    }

    /// Returns whether there may be sheets: see-through triangles, which are among the casters.
    pub fn has_sheets(&self) -> bool {
        self.sheets
    }

    /// Returns where alpha begins behind the triangles, in triangles; 0 if no triangle may have alpha.
    pub(crate) fn alpha_first(&self) -> u32 {
        self.alpha_first
    }

    /// Returns whether any triangle may have alpha.
    pub(crate) fn has_alpha(&self) -> bool {
        self.alpha_first > 0
    }

    /// Returns the specialization constants of kernels that read casters or triangles.
    pub(crate) fn constants(&self) -> Constants {
        Constants::new()
            .set(STRANDS, self.strands)
            .set(SPLATS_OR_CELLS, self.packed)
            .set(SHEETS, self.sheets)
            .set(ALPHA_FIRST, self.alpha_first)
    }

    /// Returns the capacity, in casters: the largest number that the scene has at any time, or its number at the start.
    pub fn caster_capacity(&self) -> u32 {
        self.caster_capacity
    }

    /// Returns the number of triangles of all meshes.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Returns the capacity, in triangles.
    pub fn triangle_capacity(&self) -> u32 {
        self.triangle_capacity
    }

    /// Returns the kinds of casters present; in a world filled from the caller's buffers, the kinds whose capacity is above 0.
    pub fn kinds(&self) -> Kinds {
        match &self.filled {
            WorldSource::Scene(staged) => staged.scene.kinds(),
            WorldSource::External(theirs) => theirs.capacity.kinds(),
        }
    }

    /// Returns the lights as known to the host. If only the device knows them ([`World::update_lights_from_buffer`]), these are dark lights
    /// of the same types.
    pub fn all_lights(&self) -> &[Light] {
        &self.lit
    }

    /// Returns whether the host knows where the lights are.
    pub fn knows_lights(&self) -> bool {
        self.knows_lights
    }

    /// Returns the number of lights.
    pub fn light_count(&self) -> u32 {
        self.lit.len() as u32
    }

    /// Returns the number of maps of all lights.
    pub fn map_count(&self) -> usize {
        self.lit.iter().map(Light::map_count).sum()
    }

    /// Checks that the lights have `count` maps, as expected by something created for them.
    ///
    /// # Errors
    /// [`Error::Input`] if the lights have a different number of maps.
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

    /// Returns whether any light has the six maps of a cube's faces.
    pub fn has_faces(&self) -> bool {
        self.lit.iter().any(|light| light.map_count() > 1)
    }

    /// Returns the data for aiming the lights' views, if the host knows the lights.
    pub fn aim(&self) -> Aim<'_> {
        Aim { lights: &self.lit, anchors: self.anchors, has_triangles: self.triangle_capacity > 0 }
    }

    /// Returns the camera, if one has been set.
    pub fn camera(&self) -> Option<&Camera> {
        self.camera.as_ref()
    }

    /// Returns the meshes, if the host knows them.
    pub fn meshes(&self) -> Option<&[Mesh]> {
        self.scene().ok().map(|scene| scene.meshes.as_slice())
    }

    /// Returns points whose convex hull contains all meshes: the meshes' vertices, or the corners of the box set by the caller.
    ///
    /// # Errors
    /// [`Error::Refused`] if the host knows neither the vertices nor a box.
    pub fn mesh_hull(&self) -> Result<Box<dyn Iterator<Item = [f32; 3]> + '_>> {
        match (&self.filled, self.bounds) {
            (WorldSource::Scene(staged), _) => {
                Ok(Box::new(staged.scene.meshes.iter().flat_map(|m| m.positions.iter().copied())))
            }
            (_, Some([meshes, _])) => Ok(Box::new(meshes.corners().into_iter())),
            _ => Err(Error::Refused("a box about all triangles (World::set_box)".into())),
        }
    }

    /// Returns a box around all casters, as low and high corners, if the host knows one. It may be larger than necessary.
    pub fn known_box(&self) -> Option<[DVec3; 2]> {
        self.bounds.map(|[meshes, casters]| meshes.with(casters).ends())
    }
}

// Casters have the same layout on the device and on the host.
const _: () = assert!(size_of::<Caster>() == 32);
