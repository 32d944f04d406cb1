//! Tests every caster and triangle between the point and the light: exact on any device. A grid over the world lists the candidates.
//! Sources: Amanatides and Woo 1987 (every voxel along the ray), Woop et al. 2013 (triangles); the lists are ours.
//!
//! No maps and no texels: the only error is rounding.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, smoke};
//! # on_a_device(|context| {
//! use gobo::query::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &smoke())?;
//! let mut query = open(context, &world, &parse("grid-query", &[])?[0])?;
//! query.build(&world)?;
//! // Above the smoke and below it.
//! let points = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = points.ask(&query.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && (below - (-2f32).exp()).abs() < 1e-5);
//! # Ok(()) });
//! ```

use super::settings::{Keyed, Setting, settings};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::grid::{Grid, Placement};
use crate::scene::{Casting, Resolution, View};
use crate::shaders::{constant, folder, set};
use crate::world::{Parts, World};

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Voxels per side of the grid: 64, 128, 256 or 512. Results do not depend on it.
        size: u32 = Setting::one_of(
            "64", &["64", "128", "256", "512"], "voxels per side of the grid that lists what casts; answers are the same");
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "grid-query",
    about: "every caster and triangle on the way to the light, found by a grid that lists them: exact on any device",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: COMPUTE, requires: &[] }],
    plan: |_, path| PathPlan { path, limits: Vec::new(), promises: Promises::EXACT },
    runs: Runs { usual: &[""], compare: &[""], stress_smoke: &[""], stress_meshes: &[""], ..Runs::NONE },
    open: |context, world, spec| Ok(Box::new(GridQuery::new(context, world, &spec.settings())?)),
};

const COMPUTE: &str = "compute";

/// The technique, opened for one world.
pub struct GridQuery {
    size: u32,
    grid: Grid,
    resolution: Vec<Resolution>,
    look_up: Bindings,
    constants: Constants,
}

impl GridQuery {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let size = settings.size;
        let grid = Grid::listing(context, world, size)?;
        let (buffers, [cast_bits, cast_lists]) = (grid.buffers(), grid.cast_buffers());
        let look_up = set::GridQueryLookUp {
            lights: &world.lights,
            grid: buffers.data,
            bits: buffers.bits,
            cells: buffers.cells,
            triangles: &world.triangles,
            cast_bits,
            cast_lists,
            casters: &world.casters,
        };
        let look_up = look_up.bind(context, "grid_query.look_up")?;
        let constants = world.constants().set(constant::GRID_SIZE, size);
        Ok(Self { size, grid, resolution: Vec::new(), look_up, constants })
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

impl Technique for GridQuery {
    /// Nothing is built from the lights, but the resolution depends on their positions.
    fn made_of(&self) -> Parts {
        Parts::MESHES.and(Parts::CASTERS).and(Parts::LIGHTS)
    }

    fn forget(&mut self) {
        self.grid.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        let is_known = world.aim().has_triangles && world.knows_lights();
        let stood = Placement::known(world, self.size).filter(|_| is_known);
        self.resolution = stood.map_or(Vec::new(), |stood| {
            let views = View::aimed(&world.aim(), 1, Casting::Opaque).into_iter();
            views.map(|view| Resolution::of_triangles(view, stood.rounding())).collect()
        });
        self.grid.record(commands, world);
        Ok(())
    }

    /// Grows the lists if the device has counted more entries than they hold.
    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.grid.settle(frame)?;
        if grew {
            self.look_up.replace(set::GridQueryLookUp::CELLS, self.grid.buffers().cells)?;
            self.look_up.replace(set::GridQueryLookUp::CAST_LISTS, self.grid.cast_buffers()[1])?;
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::GRID_QUERY, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for GridQuery {
    fn resolution(&self) -> Vec<Resolution> {
        self.resolution.clone()
    }

    fn facts(&self) -> Result<Facts> {
        let [triangles, casters] = [self.grid.list_totals(), self.grid.cast_totals()];
        let of = |totals: Option<crate::grid::ListTotals>| totals.map_or(0, |totals| totals.pairs.into());
        Ok(Facts {
            path: COMPUTE,
            reason: "the only path".into(),
            bytes_resident: self.grid.resident_bytes(),
            bytes_transient: self.grid.transient_bytes(),
            counters: [("listed_triangles".into(), of(triangles)), ("listed_casters".into(), of(casters))].into(),
            ..Facts::default()
        })
    }
}
