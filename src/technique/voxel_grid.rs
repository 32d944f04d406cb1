//! Voxel grid: rays from the point to the light through a grid of voxels that meshes occupy and smoke and hair fill. The grid is
//! the world's: all lights ask the same one. Sources: Pestana 2015 (even steps); Amanatides and Woo 1987 (every voxel on the way).
//!
//! One grid for all lights: rays through it end at meshes and lose light in smoke.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use gobo::consume::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &solid())?;
//! let mut grid = open(context, &world, &parse("voxel-grid:size=64")?[0])?;
//! grid.build(&world)?;
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&grid.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && below == 0.0);
//! # Ok(()) });
//! ```

use super::keys::{Key, Values, Word, words};
use super::{Answer, Casts, Entry, Facts, Lifetime, Path, Promises, Runs, Spec, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Features, Requirement, Resource};
use crate::grid::{Grid, Voxelizer};
use crate::maps::Map;
use crate::scene::{Casting, Resolution, Scene, View};
use crate::shaders::{constant, folder};
use crate::world::{Parts, World};
use glam::DVec3;

words! {
    /// How the meshes become voxels.
    enum Way {
        /// By compute passes.
        Compute = "compute",
        /// Drawn.
        Raster = "raster",
    }
}

const PATH: Key = Key {
    name: "path",
    values: Values::OneOf(Way::WORDS),
    default: "auto",
    about: "who finds the voxels that meshes meet, the same ones: compute passes, or a draw; auto: compute",
};

/// Voxels a side.
const SIZE: Key = Key {
    name: "size",
    values: Values::OneOf(&["64", "128", "256", "512"]),
    default: "256",
    about: "voxels a side of the grid about all that casts",
};

words! {
    /// How a ray goes through the grid.
    pub enum March {
        /// Every voxel on its way.
        Exact = "exact",
        /// Even steps.
        Steps = "steps",
        /// A cone through cells as wide as it.
        Cone = "cone",
    }
}

const MARCH: Key = Key {
    name: "march",
    values: Values::OneOf(March::WORDS),
    default: "exact",
    about: "every voxel on the way to the light; even steps, which miss what is thin; a cone through cells as wide",
};

const STEPS: Key = Key {
    name: "steps",
    values: Values::OneOf(&["5", "10", "15", "25", "50", "75"]),
    default: "25",
    about: "even steps from the point to the light, with march=steps",
};

const OFFSET: Key =
    Key { name: "offset", values: Values::Number(0, 100), default: "50", about: "where in each step, hundredths" };

const APERTURE: Key = Key {
    name: "aperture",
    values: Values::Number(0, 45),
    default: "2",
    about: "degrees between the cone's axis and its side, with march=cone",
};

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "voxel-grid",
    about: "a ray from the point to the light through a grid of voxels, one grid for all lights (Pestana 2015)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: &[PATH, SIZE, MARCH, STEPS, OFFSET, APERTURE],
    paths: &[Path { name: COMPUTE, requires: &[] }, Path { name: RASTER, requires: &[Requirement::FragmentStores] }],
    promises: |_, _| Promises::OF_OPAQUE,
    runs: Runs {
        // The sizes and numbers of steps of Pestana 2015.
        many_lights: &[
            "shading=tiled,march=exact,size=64|128|256",
            "shading=tiled,march=steps,steps=5|10|15|25|50|75,size=64|128|256",
            "shading=tiled,march=exact,dither=none|ordered|noise,blur=off|on,history=off|on",
            "shading=tiled,march=steps,steps=25,dither=none|ordered|noise,blur=off|on,history=off|on",
        ],
        stress_smoke: &["size=64,march=exact,path=compute|raster"],
        stress_meshes: &["size=64,march=exact,path=compute|raster"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(VoxelGrid::new(context, world, &Settings::of(spec, context.features()))?)),
};

const COMPUTE: &str = "compute";
const RASTER: &str = "raster";

/// A spec, read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Voxels a side: a power of two from 64 to 512.
    pub size: u32,
    /// How many even steps; none where a ray meets every voxel on its way.
    pub steps: Option<u32>,
    /// Where in each step, as a share of it.
    pub offset: f32,
    /// How much a cone's radius grows along it; none where a ray asks.
    pub cone: Option<f32>,
    /// How the meshes become voxels.
    pub voxelizer: Voxelizer,
}

impl Settings {
    fn of(spec: &Spec, features: &Features) -> Self {
        let voxelizer = match spec.word(PATH.name) {
            Some(Way::Raster) => Voxelizer::Raster { conservative: features.conservative_rasterization },
            Some(Way::Compute) | None => Voxelizer::Compute,
        };
        let march = spec.word(MARCH.name);
        let cone = (march == Some(March::Cone)).then(|| (spec.number(APERTURE.name) as f32).to_radians().tan());
        let steps = (march == Some(March::Steps)).then(|| spec.number(STEPS.name));
        let (size, offset) = (spec.number(SIZE.name), spec.number(OFFSET.name) as f32 / 100.0);
        Self { size, steps, offset, cone, voxelizer }
    }

    fn path(&self) -> &'static str {
        if self.voxelizer == Voxelizer::Compute { COMPUTE } else { RASTER }
    }
}

/// The technique, opened for one world.
pub struct VoxelGrid {
    settings: Settings,
    grid: Grid,
    resolution: Vec<Resolution>,
    look_up: Bindings,
    constants: Constants,
}

impl VoxelGrid {
    /// Opens it.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what the path needs, [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        ENTRY.require(context, settings.path())?;
        let grid = Grid::new(context, world, settings.size, settings.voxelizer, settings.cone.is_some())?;
        let [data, bits, media, media_bits, cells] = grid.buffers();
        let resources =
            [&world.lights, data, bits, media, media_bits, cells].map(|buffer| Resource::Buffer(buffer.clone()));
        let look_up = Bindings::new(context, "voxel_grid.look_up", &resources)?;
        let constants = Constants::new()
            .set(constant::GRID_SIZE, settings.size)
            .set(constant::MARCH_STEPS, settings.steps.unwrap_or(0))
            .set(constant::MARCH_OFFSET, settings.offset)
            .set(constant::MEDIA, grid.has_media())
            .set(constant::CONE, settings.cone.is_some())
            .set(constant::CONE_SLOPE, settings.cone.unwrap_or(0.0));
        Ok(Self { settings: *settings, grid, resolution: Vec::new(), look_up, constants })
    }

    /// Why the path, and which way of drawing.
    fn reason(&self) -> &'static str {
        match self.settings.voxelizer {
            Voxelizer::Compute => "needs nothing that is optional",
            Voxelizer::Raster { conservative: true } => "asked for; conservative rasterization",
            Voxelizer::Raster { conservative: false } => "asked for; wider triangles",
        }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

/// How finely the grid knows the meshes, one for each map of all lights.
fn resolution(scene: &Scene, size: u32) -> Vec<Resolution> {
    let corners = scene.meshes.iter().flat_map(|mesh| &mesh.positions).map(|p| [DVec3::from(p.map(f64::from)); 2]);
    let spheres = scene.casters().into_iter().flat_map(|caster| {
        let radius = f64::from(caster.radius);
        [caster.start(), caster.end()].map(|centre| [centre - radius, centre + radius])
    });
    let both = (DVec3::MAX, DVec3::MIN);
    let (low, high) = corners.chain(spheres).fold(both, |(low, high), [l, h]| (low.min(l), high.max(h)));
    let widest = (high - low).max_element().max(1e-3 * low.abs().max(high.abs()).max_element().max(1.0));
    // A float's rounding more than the device has.
    let voxel = widest / f64::from(size - 2) * (1.0 + 1e-5);
    View::aimed(scene, 1, Casting::Opaque).into_iter().map(|view| Resolution::of_grid(view, voxel)).collect()
}

impl Technique for VoxelGrid {
    /// Nothing is built of the lights, but where they see edges from is said of it.
    fn made_of(&self) -> Parts {
        Parts::MESHES.and(Parts::CASTERS).and(Parts::LIGHTS)
    }

    fn forget(&mut self) {
        self.grid.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.resolution =
            if world.scene().has_triangles() { resolution(world.scene(), self.settings.size) } else { Vec::new() };
        self.grid.record(commands, world);
        Ok(())
    }

    fn answer(&self) -> Answer<'_> {
        Answer { folder: folder::VOXEL_GRID, bindings: &self.look_up, constants: &self.constants }
    }

    fn maps(&self) -> &[Map] {
        &[]
    }

    fn resolution(&self) -> Vec<Resolution> {
        self.resolution.clone()
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: self.settings.path(),
            reason: self.reason().into(),
            bytes_resident: self.grid.resident_bytes(),
            bytes_transient: self.grid.transient_bytes(),
            ..Facts::default()
        })
    }
}
