//! Optical depth grid: each cell of a light's grid holds the optical depth from the cell to the light, baked by marching through the voxels
//! of a [`super::density_grid`]. A look-up is a single fetch. Source: Schneider 2023 (Nubis³), where each frame bakes a part of the grid.
//!
//! A look-up costs the same however much smoke lies between the point and the light. Meshes are drawn into one opaque map per light, as in
//! techniques with maps.
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
//! let mut grid = open(context, &world, &parse("optical-depth-grid", &[])?[0])?;
//! grid.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&grid.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::settings::{Keyed, OPAQUE, Setting, settings};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Limit, Memory, groups, push_struct};
use crate::grid::{Grid, GridData, MediaContent};
use crate::maps::{Maps, OpaqueWay};
use crate::scene::Resolution;
use crate::shaders::{self, constant, folder, set};
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};

words! {
    /// How much of the grid a build bakes.
    pub enum Bake {
        /// All of it.
        Whole = "whole",
        /// One of several parts in turn, so the whole grid takes as many builds as it has parts.
        RoundRobin = "round-robin",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Voxels per side of the density grid that is marched: 64, 128 or 256.
        size: u32 = Setting::one_of("128", &["64", "128", "256"], "voxels per side of the density grid that is marched");
        /// Cells per side of each light's grid: 32, 64 or 128.
        cells: u32 = Setting::one_of("64", &["32", "64", "128"], "cells per side of each light's grid of optical depths");
        /// How much of the grid a build bakes.
        bake: Bake = Setting::word("whole", "all of it in each build, or a part in turn: look-ups read the last whole one");
        /// Number of builds that the whole grid takes, for [`Bake::RoundRobin`]: 2, 4, 8 or 16.
        frames: u32 = Setting::one_of("8", &["2", "4", "8", "16"], "builds that all of it takes, with bake=round-robin");
        /// How the opaque maps are drawn. `None`: compute passes on GPUs, the rasterizer elsewhere.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
}

impl Settings {
    /// Returns the number of builds that the whole grid takes.
    pub fn turns(&self) -> u32 {
        if self.bake == Bake::RoundRobin { self.frames } else { 1 }
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "optical-depth-grid",
    about: "the optical depth to each light in a grid of cells, one fetch per look-up, baked whole or in turn (Nubis³ 2023)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: COMPUTE, requires: &[] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![room(&spec.settings(), 1)],
        promises: Promises { order: Some(0.0), ..Promises::NONE },
    },
    runs: Runs {
        usual: &["cells=64"],
        usual_on_cpu: &["cells=64"],
        compare: &["cells=64"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["cells=32,bake=whole|round-robin"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(OpticalDepthGrid::new(context, world, &spec.settings())?)),
};

const COMPUTE: &str = "compute";

/// Number of threads that keep a GPU busy. If fewer cells are baked at once, several threads share the march of each cell, since a build
/// takes as long as its longest march. The number is the same on all devices, so that the bytes do not depend on the device.
const BUSY: u64 = 1 << 18;

/// Returns the number of threads that share the march of a cell, 1 to 8, when `cells` cells are baked at once. Twin: WAY_PARTS.
#[doc(hidden)]
pub fn way_parts(cells: u64) -> u32 {
    1 << (BUSY / cells.max(1)).clamp(1, 8).ilog2()
}

push_struct! {
    /// Twin: BakePush in glsl/technique/optical_depth_grid/bake.comp.
    struct BakePush {
        first: u32,
        layers: u32,
        lights: u32,
    }
}

/// Returns the buffer size limit that the optical depths of `lights` lights require.
fn room(settings: &Settings, lights: u32) -> Limit {
    Limit::buffer_range(4 * u64::from(settings.cells).pow(3) * u64::from(lights.max(1)))
}

/// Optical depths of all lights, and the placement of their cells.
struct Baked {
    place: Buffer,
    depths: Buffer,
    bake: Kernel<BakePush>,
    /// Number of threads per cell.
    parts: u32,
}

impl Baked {
    fn new(context: &Context, world: &World, settings: &Settings, grid: &Grid, constants: &Constants) -> Result<Self> {
        let all = u64::from(settings.cells).pow(3) * u64::from(world.light_count().max(1));
        let bytes = room(settings, world.light_count()).least;
        let parts = way_parts(all / u64::from(settings.turns()));
        let what = format!(" for {} lights of {}³ cells", world.light_count(), settings.cells);
        if let Some(needs) = room(settings, world.light_count()).lacks(context.features(), &what) {
            return Err(Error::Refused(needs));
        }
        let place = Buffer::new(context, "optical_depth_grid.place", size_of::<GridData>() as u64, Memory::Device)?;
        let depths = Buffer::new(context, "optical_depth_grid.depths", bytes, Memory::Device)?;
        let buffers = grid.buffers();
        let set = set::OpticalDepthGrid {
            lights_of: &world.lights,
            grid: buffers.data,
            media: buffers.media,
            media_bits: buffers.media_bits,
            place: &place,
            depths: &depths,
        };
        let set = set.bind(context, "optical_depth_grid")?;
        let constants = &constants.clone().set(constant::WAY_PARTS, parts);
        let bake = Kernel::compute(context, &shaders::optical_depth_grid::BAKE, &[&set], constants)?;
        Ok(Self { place, depths, bake, parts })
    }

    /// Copies the placement of the density grid, which the cells share.
    fn stand(&self, commands: &mut Commands, grid: &Grid) {
        commands.pass("optical_depth_grid.place", |pass| {
            pass.copy(grid.buffers().data, &self.place, self.place.bytes());
        });
    }

    fn bake(&self, commands: &mut Commands, cells: u32, push: &BakePush) {
        let threads = u64::from(cells * cells * push.layers) * u64::from(push.lights) * u64::from(self.parts);
        let [x, y] = groups(threads.div_ceil(64));
        commands.pass("optical_depth_grid.bake", |pass| pass.dispatch(&self.bake, push, [x, y, 1]));
    }
}

/// The technique, opened for one world.
pub struct OpticalDepthGrid {
    settings: Settings,
    lights: u32,
    grid: Grid,
    maps: Maps,
    /// The depths that look-ups read.
    front: Baked,
    /// Depths that are being baked part by part, with bake=round-robin.
    back: Option<Baked>,
    /// Part to bake next; `None` if the next build bakes the whole grid, so that look-ups have depths to read.
    turn: Option<u32>,
    made: BuildStamp,
    look_up: Bindings,
    constants: Constants,
}

impl OpticalDepthGrid {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed; [`Error::Refused`] if the device cannot bind a buffer with that many voxels or
    /// cells, or has no room for the opaque maps of that many lights; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let grid = Grid::of_media(context, world, settings.size, MediaContent::default())?;
        let constants = Constants::new().set(constant::GRID_SIZE, settings.size).set(constant::CELLS, settings.cells);
        let baked = || Baked::new(context, world, settings, &grid, &constants);
        let front = baked()?;
        let back = if settings.bake == Bake::RoundRobin { Some(baked()?) } else { None };
        let maps = Maps::opaque_alone(context, world, settings.opaque)?;
        let (views, opaque) = maps.opaque_bindings();
        let look_up = set::OpticalDepthGridLookUp {
            lights: &world.lights,
            place: &front.place,
            depths: &front.depths,
            maps: views,
            opaque: &opaque,
        };
        let look_up = look_up.bind(context, "optical_depth_grid.look_up")?;
        let (lights, made) = (world.light_count(), BuildStamp::of(Parts::CASTERS.and(Parts::LIGHTS)));
        Ok(Self { settings: *settings, lights, grid, maps, front, back, turn: None, made, look_up, constants })
    }

    /// After a build, returns the placement of the cells and the optical depths of each light's cells.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn baked(&self) -> Result<(GridData, Vec<f32>)> {
        let depths = self.front.depths.read((self.front.depths.bytes() / 4) as usize)?;
        Ok((self.front.place.read(1)?[0], depths))
    }
}

impl Technique for OpticalDepthGrid {
    fn made_of(&self) -> Parts {
        Parts::CASTERS.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.grid.forget();
        self.maps.forget();
        self.made.forget();
        self.turn = None;
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        if world.light_count() != self.lights {
            let cause =
                format!("it has {} lights, and a technique was opened for {}", world.light_count(), self.lights);
            return Err(Error::input(world.name(), cause, "open the technique anew"));
        }
        self.maps.record_opaque(commands, world)?;
        // All parts of a round use the smoke from the beginning of the round, since the density grid is filled only then.
        let begins = self.turn.is_none_or(|turn| turn == 0);
        if begins && !self.made.make(world) {
            return Ok(());
        }
        if begins {
            self.grid.record(commands, world);
        }
        let Settings { cells, frames, .. } = self.settings;
        let lights = self.lights;
        let (Some(back), Some(turn)) = (&self.back, self.turn) else {
            self.front.stand(commands, &self.grid);
            self.front.bake(commands, cells, &BakePush { first: 0, layers: cells, lights });
            self.turn = Some(0);
            return Ok(());
        };
        if turn == 0 {
            back.stand(commands, &self.grid);
        }
        let layers = cells / frames;
        back.bake(commands, cells, &BakePush { first: turn * layers, layers, lights });
        self.turn = Some((turn + 1) % frames);
        if turn + 1 == frames {
            commands.pass("optical_depth_grid.swap", |pass| {
                pass.copy(&back.place, &self.front.place, back.place.bytes());
                pass.copy(&back.depths, &self.front.depths, back.depths.bytes());
            });
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.maps.settle(frame, false)?;
        if grew && self.back.is_none() {
            self.grid.forget();
            self.made.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::OPTICAL_DEPTH_GRID, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for OpticalDepthGrid {
    fn resolution(&self) -> Vec<Resolution> {
        self.maps.opaque_resolution()
    }

    fn facts(&self) -> Result<Facts> {
        let back = self.back.as_ref().map_or(0, |back| back.depths.bytes() + back.place.bytes());
        Ok(Facts {
            path: COMPUTE,
            reason: "the only path".into(),
            bytes_resident: self.front.depths.bytes() + self.front.place.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.grid.resident_bytes()
                + self.grid.transient_bytes()
                + back
                + self.maps.opaque_bytes_transient(),
            ..Facts::default()
        })
    }
}
