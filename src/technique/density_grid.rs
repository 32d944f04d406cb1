//! Density grid: voxels hold the extinction of smoke and hair, in one grid shared by all lights. A look-up marches through the grid from
//! the point to the light. Sources: Amanatides and Woo 1987 (every voxel); Novák et al. 2014 (ratio tracking). Ours: integer sums, which
//! make the result independent of the order of casters, and mean directions of strands.
//!
//! Building the grid costs the same for any number of lights. Meshes are drawn into one opaque map per light, as in techniques with maps.
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
//! let mut grid = open(context, &world, &parse("density-grid:size=64", &[])?[0])?;
//! grid.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&grid.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && (below - (-2f32).exp()).abs() < 0.01);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::promises::ROUNDING;
use super::settings::{Keyed, OPAQUE, Setting, settings};
use super::{
    Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Spec, Technique,
};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::grid::{Grid, MediaContent, faces, media_limit, voxels_per_side};
use crate::maps::{Maps, OpaqueWay};
use crate::scene::Resolution;
use crate::shaders::{constant, folder, set};
use crate::world::{Parts, World};

words! {
    /// How a look-up marches through the grid.
    pub enum March {
        /// Every voxel along the ray, weighted by the length of the ray inside the voxel.
        Exact = "exact",
        /// Even steps, with extinction interpolated linearly between voxel centres.
        Steps = "steps",
        /// Random positions: unbiased but noisy.
        Ratio = "ratio",
    }
}

words! {
    /// What a voxel stores about the directions of its strands.
    pub enum Direction {
        /// Nothing: strands absorb as much light along their length as across it.
        None = "none",
        /// The mean of the outer products of their directions, which gives the extinction along and across the strands.
        Mean = "mean",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Voxels along the longest side of the box around smoke and hair: 32, 48, 64, 96, 128, 192 or 256.
        size: u32 = Setting::one_of(
            "128",
            &["32", "48", "64", "96", "128", "192", "256"],
            "voxels along the longest side of the box about smoke and hair");
        /// How a look-up marches through the grid.
        march: March = Setting::word(
            "exact", "every voxel on the way to the light; even steps, linear between voxels; or random places, without bias");
        /// Number of even steps from the point to the light, for [`March::Steps`]: 1 to 1,024.
        steps: u32 = Setting::number("32", 1, 1024, "even steps from the point to the light, with march=steps");
        /// What a voxel stores about the directions of its strands.
        direction: Direction = Setting::word(
            "none", "whether voxels keep the direction of their strands, which take less light along it; 24 bytes per voxel");
        /// How the opaque maps are drawn. `None`: compute passes on GPUs, the rasterizer elsewhere.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "density-grid",
    about: "marches to the light through the extinction of smoke and hair in voxels, one grid for all lights",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: COMPUTE, requires: &[] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![media_limit(voxels_per_side(spec.settings::<Settings>().size), 1)],
        promises: promises(spec),
    },
    runs: Runs {
        usual: &["size=128"],
        usual_on_cpu: &["size=64"],
        compare: &["size=128"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=64,march=exact|steps|ratio", "size=64,direction=mean"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(DensityGrid::new(context, world, &spec.settings())?)),
};

const COMPUTE: &str = "compute";

/// Integer sums do not depend on the order of casters. With march=exact, transmittance never rises along a ray. The other marches do not
/// promise this, since their steps and random samples fall at different positions for each point.
fn promises(spec: &Spec) -> Promises {
    let exact = spec.settings::<Settings>().march == March::Exact;
    Promises { order: Some(0.0), rise: exact.then_some(ROUNDING), ..Promises::NONE }
}

/// The technique, opened for one world.
pub struct DensityGrid {
    grid: Grid,
    maps: Maps,
    look_up: Bindings,
    constants: Constants,
}

impl DensityGrid {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed; [`crate::Error::Refused`] if the device cannot bind a buffer with that
    /// many voxels, or has no room for the opaque maps of that many lights; [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { size, march, steps, direction, opaque } = *settings;
        let directions = direction == Direction::Mean && (world.has_strands() || world.has_sheets());
        let grid = Grid::of_media(context, world, size, MediaContent { directions, most: march == March::Ratio })?;
        let maps = Maps::opaque_alone(context, world, opaque)?;
        let (buffers, [run, most]) = (grid.buffers(), grid.direction_buffers());
        let (views, opaque) = maps.opaque_bindings();
        let look_up = set::DensityGridLookUp {
            lights: &world.lights,
            grid: buffers.data,
            media: buffers.media,
            media_bits: buffers.media_bits,
            directions: run,
            most,
            maps: views,
            opaque: &opaque,
        };
        let look_up = look_up.bind(context, "density_grid.look_up")?;
        let constants = Constants::new()
            .set(constant::GRID_SIZE, voxels_per_side(size))
            .set(constant::MARCH, march as u32)
            .set(constant::MARCH_STEPS, steps)
            .set(constant::DIRECTION, directions)
            .set(constant::FACING, faces(world));
        Ok(Self { grid, maps, look_up, constants })
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

impl Technique for DensityGrid {
    fn made_of(&self) -> Parts {
        Parts::CASTERS.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.grid.forget();
        self.maps.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.grid.record(commands, world);
        self.maps.record_opaque(commands, world)
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.maps.settle(frame, false)?;
        if grew {
            self.grid.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::DENSITY_GRID, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for DensityGrid {
    fn resolution(&self) -> Vec<Resolution> {
        self.maps.opaque_resolution()
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: COMPUTE,
            reason: "the only path".into(),
            bytes_resident: self.grid.resident_bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.grid.transient_bytes() + self.maps.opaque_bytes_transient(),
            ..Facts::default()
        })
    }
}
