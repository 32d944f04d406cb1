//! Voxel grid: rays from the point to the light through a grid of voxels that are occupied by meshes and filled with smoke and hair. The
//! grid belongs to the world and is shared by all lights. Sources: Pestana 2015 (even steps); Amanatides and Woo 1987 (every voxel along
//! the ray).
//!
//! One grid for all lights: rays through it end at meshes and lose light in smoke.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use gobo::query::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &solid())?;
//! let mut grid = open(context, &world, &parse("voxel-grid:size=64", &[])?[0])?;
//! grid.build(&world)?;
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&grid.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && below == 0.0);
//! # Ok(()) });
//! ```

use super::keys::{word_of, words};
use super::settings::{Keyed, Setting, settings};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Commands, Constants, Context, Features, Requirement};
use crate::grid::{Grid, GridBuffers, Placement, Refinement, Voxelizer, media_limit};
use crate::scene::{Casting, Resolution, View};
use crate::shaders::set;
use crate::shaders::{constant, folder};
use crate::world::{Parts, World};
use crate::{Error, Result};

words! {
    /// How meshes are voxelized.
    pub enum BuildPath {
        /// By compute passes.
        Compute = "compute",
        /// By drawing.
        Raster = "raster",
    }
}

words! {
    /// What casts shadows in place of a mesh.
    pub enum Cell {
        /// The voxels that the mesh touches.
        Solid = "solid",
        /// The cells that the mesh touches, 4 × 4 × 4 per voxel.
        Mask = "mask",
        /// Its triangles, listed by the voxels that they touch.
        Triangles = "triangles",
    }
}

words! {
    /// How a ray traverses the grid.
    pub enum March {
        /// Through every voxel along the ray.
        Exact = "exact",
        /// In even steps.
        Steps = "steps",
        /// As a cone, through cells as wide as the cone.
        Cone = "cone",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// How meshes are voxelized; both ways find the same voxels. `None`: by compute passes.
        path: Option<BuildPath> = Setting::auto(
            "how voxels that meshes meet are found: compute passes, or a draw, with the same result; auto: compute");
        /// Voxels per side of the grid: 64, 128, 256 or 512.
        size: u32 = Setting::one_of(
            "256", &["64", "128", "256", "512"], "voxels per side of the grid about all that casts");
        /// What casts shadows in place of a mesh: whole voxels in Pestana 2015. [`Cell::Mask`] and [`Cell::Triangles`] work only with
        /// [`March::Exact`].
        cell: Cell = Setting::word(
            "solid", "what casts for a mesh: voxels that it meets; 4 × 4 × 4 bits of each; or its triangles, exactly");
        /// How far a point is moved along its ray after it has been moved off its surface along the normal, in hundredths of a voxel, or of
        /// a cell if voxels have masks: 0 to 400. Ignored with [`March::Cone`] and with [`Cell::Triangles`].
        bias: u32 = Setting::number(
            "200", 0, 400, "how far a look-up moves off a surface along its ray, hundredths of a voxel, or of a mask's cell");
        /// How a ray traverses the grid: in even steps in Pestana 2015.
        march: March = Setting::word(
            "exact", "every voxel on the way to the light; even steps, which miss what is thin; a cone through cells as wide");
        /// Number of even steps from the point to the light, for [`March::Steps`]: 5, 10, 15, 25, 50 or 75, as in Pestana 2015.
        steps: u32 = Setting::one_of(
            "25", &["5", "10", "15", "25", "50", "75"], "even steps from the point to the light, with march=steps");
        /// Where in each step a ray samples the grid, in hundredths of the step: 0 to 100.
        offset: u32 = Setting::number("50", 0, 100, "where in each step, hundredths");
        /// Angle between the axis of a cone and its side in degrees, for [`March::Cone`]: 0 to 45.
        aperture: u32 =
            Setting::number("2", 0, 45, "degrees between the cone's axis and its side, with march=cone");
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "voxel-grid",
    about: "a ray from the point to the light through a grid of voxels, one grid for all lights (Pestana 2015)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: COMPUTE, requires: &[] }, Path { name: RASTER, requires: &[Requirement::FragmentStores] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![media_limit(spec.settings::<Settings>().size, 1)],
        promises: Promises::OF_OPAQUE,
    },
    runs: Runs {
        usual: &["march=exact", "cell=triangles"],
        usual_on_cpu: &["march=exact,size=64"],
        // Sizes and step counts of Pestana 2015.
        many_lights: &[
            "shading=tiled,march=exact,size=64|128|256",
            "shading=tiled,march=steps,steps=5|10|15|25|50|75,size=64|128|256",
            "shading=tiled,march=exact,dither=none|ordered|noise,blur=off|on,history=off|on",
            "shading=tiled,march=steps,steps=25,dither=none|ordered|noise,blur=off|on,history=off|on",
            "shading=tiled,cell=triangles",
        ],
        stress_smoke: &["size=64,march=exact,path=compute|raster"],
        stress_meshes: &["size=64,march=exact,path=compute|raster", "size=64,cell=triangles"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(VoxelGrid::new(context, world, &spec.settings())?)),
};

const COMPUTE: &str = "compute";
const RASTER: &str = "raster";

/// The settings, resolved for a device. For tests, a plan may also hold what settings cannot express: cones of any width, and
/// any number of steps.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Voxels per side: a power of two from 64 to 512.
    pub size: u32,
    /// Number of even steps; `None` if a ray visits every voxel along its path.
    pub steps: Option<u32>,
    /// Where in each step a ray samples the grid, as a fraction of the step.
    pub offset: f32,
    /// Growth of a cone's radius per unit of length; `None` for rays.
    pub cone: Option<f32>,
    /// How meshes are voxelized.
    pub voxelizer: Voxelizer,
    /// Whether voxels have masks: rays then hit the cells of masks instead of whole voxels.
    pub masks: bool,
    /// How far a point is moved along its ray after it has been moved off its surface, in voxels, or in cells if voxels have masks. Ignored
    /// with a cone or with listed triangles.
    pub bias: f32,
}

impl Plan {
    fn of(settings: &Settings, features: &Features) -> Result<Self> {
        let Settings { path, size, cell, bias, march, steps, offset, aperture } = *settings;
        if cell != Cell::Solid && march != March::Exact {
            let name = format!("cell={},march={}", word_of(cell), word_of(march));
            let cause = "steps and cones ask for whole voxels, not for what is in them";
            return Err(Error::input(name, cause, "use march=exact, or cell=solid"));
        }
        let voxelizer = match path {
            Some(BuildPath::Raster) if cell == Cell::Triangles => {
                let needs = "path=compute for cell=triangles: draws list no triangles".into();
                return Err(Error::Refused(needs));
            }
            _ if cell == Cell::Triangles => Voxelizer::Listed,
            Some(BuildPath::Raster) => Voxelizer::Raster { conservative: features.conservative_rasterization },
            Some(BuildPath::Compute) | None => Voxelizer::Compute,
        };
        let cone = (march == March::Cone).then(|| (aperture as f32).to_radians().tan());
        let steps = (march == March::Steps).then_some(steps);
        Ok(Self {
            size,
            steps,
            offset: offset as f32 / 100.0,
            cone,
            voxelizer,
            masks: cell == Cell::Mask,
            bias: bias as f32 / 100.0,
        })
    }

    /// Returns how far a point is moved along its ray; 0 if `bias` is ignored.
    fn bias(&self) -> f32 {
        if self.cone.is_some() || self.voxelizer == Voxelizer::Listed { 0.0 } else { self.bias }
    }

    /// Twin: CELL in glsl/technique/voxel_grid/visibility.glsl.
    fn cell(&self) -> u32 {
        match (self.voxelizer, self.masks) {
            (Voxelizer::Listed, _) => 2,
            (_, masks) => u32::from(masks),
        }
    }

    fn path(&self) -> &'static str {
        if matches!(self.voxelizer, Voxelizer::Raster { .. }) { RASTER } else { COMPUTE }
    }
}

/// The technique, opened for one world.
pub struct VoxelGrid {
    plan: Plan,
    grid: Grid,
    resolution: Vec<Resolution>,
    look_up: Bindings,
    constants: Constants,
}

impl VoxelGrid {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed, [`Error::Refused`] if the device lacks what the path needs or two settings
    /// cannot be combined, [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        Self::planned(context, world, &Plan::of(settings, context.features())?)
    }

    /// Creates the technique from a plan.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device lacks what the path needs, [`Error::Gpu`] if memory runs out.
    pub fn planned(context: &Context, world: &World, plan: &Plan) -> Result<Self> {
        ENTRY.require(context, plan.path())?;
        let finer = match (plan.masks, plan.cone) {
            (true, _) => Refinement::Masks,
            (false, Some(_)) => Refinement::Counts,
            (false, None) => Refinement::Nothing,
        };
        let grid = Grid::new(context, world, plan.size, plan.voxelizer, finer)?;
        let GridBuffers { data, bits, media, media_bits, cells, masks } = grid.buffers();
        let look_up = set::VoxelGridLookUp {
            lights: &world.lights,
            grid: data,
            bits,
            media,
            media_bits,
            cells,
            triangles: &world.triangles,
            masks,
        };
        let look_up = look_up.bind(context, "voxel_grid.look_up")?;
        let constants = world
            .constants()
            .set(constant::GRID_SIZE, plan.size)
            .set(constant::MARCH_STEPS, plan.steps.unwrap_or(0))
            .set(constant::MARCH_OFFSET, plan.offset)
            .set(constant::MEDIA, grid.has_media())
            .set(constant::CONE, plan.cone.is_some())
            .set(constant::CONE_SLOPE, plan.cone.unwrap_or(0.0))
            .set(constant::CELL, plan.cell())
            .set(constant::BIAS, plan.bias());
        Ok(Self { plan: *plan, grid, resolution: Vec::new(), look_up, constants })
    }

    /// Returns the reason for the path and for the way of drawing.
    fn reason(&self) -> &'static str {
        match self.plan.voxelizer {
            Voxelizer::Compute | Voxelizer::Listed => "needs nothing that is optional",
            Voxelizer::Raster { conservative: true } => "asked for; conservative rasterization",
            Voxelizer::Raster { conservative: false } => "asked for; wider triangles",
        }
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

/// Width by which voxels and cells are enlarged on each side, as a fraction of a voxel's side. Twin: GRID_SLACK in glsl/grid/overlap.glsl.
const SLACK: f64 = 1e-4;

/// Returns how finely the grid resolves the meshes, one entry per map of all lights. Empty if the host does not know the lights or a
/// bounding box of the casters.
fn resolution(world: &World, plan: &Plan) -> Vec<Resolution> {
    let is_known = world.aim().has_triangles && world.knows_lights();
    let Some(stood) = Placement::known(world, plan.size).filter(|_| is_known) else { return Vec::new() };
    let voxel = stood.voxel;
    let cell = if plan.masks { voxel * (0.25 + SLACK) } else { voxel };
    let of = |view| match plan.voxelizer {
        Voxelizer::Listed => Resolution::of_triangles(view, stood.rounding()),
        _ => Resolution::of_grid(view, cell, f64::from(plan.bias())),
    };
    View::aimed(&world.aim(), 1, Casting::Opaque).into_iter().map(of).collect()
}

impl Technique for VoxelGrid {
    /// Nothing is built from the lights, but the resolution depends on their positions.
    fn made_of(&self) -> Parts {
        Parts::MESHES.and(Parts::CASTERS).and(Parts::LIGHTS)
    }

    fn forget(&mut self) {
        self.grid.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.resolution = resolution(world, &self.plan);
        self.grid.record(commands, world);
        Ok(())
    }

    /// Grows masks and lists. Each occupied voxel has a mask or a list of the triangles that touch it; only the device knows how many such
    /// voxels and triangles there are.
    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.grid.settle(frame)?;
        if grew {
            let GridBuffers { cells, masks, .. } = self.grid.buffers();
            self.look_up.replace(set::VoxelGridLookUp::CELLS, cells)?;
            self.look_up.replace(set::VoxelGridLookUp::MASKS, masks)?;
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::VOXEL_GRID, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for VoxelGrid {
    fn resolution(&self) -> Vec<Resolution> {
        self.resolution.clone()
    }

    fn facts(&self) -> Result<Facts> {
        let counters = self.grid.list_totals().into_iter().flat_map(|totals| {
            [("listed_triangles", totals.pairs), ("used_voxels", totals.voxels)]
                .map(|(name, n)| (name.into(), n.into()))
        });
        Ok(Facts {
            counters: counters.collect(),
            path: self.plan.path(),
            reason: self.reason().into(),
            bytes_resident: self.grid.resident_bytes(),
            bytes_transient: self.grid.transient_bytes(),
            ..Facts::default()
        })
    }
}
