//! Marched: the curves of [`super::avsm`], built not from the casters but by marching each texel's ray through the voxels of a
//! [`super::density_grid`]. Sources: Unreal Engine 5, Heterogeneous Volumes (which samples along a ray are kept); Salvi et al. 2010 (the
//! curves).
//!
//! The grid is built once for all lights. Each light then costs one march per texel, however many casters there are.
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
//! let mut marched = open(context, &world, &parse("marched:size=64,grid=64", &[])?[0])?;
//! marched.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&marched.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::Name;
use super::map_settings::map_settings;
use super::settings::{Keyed, LEVELS, SIZE, Setting};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Limit, Memory};
use crate::grid::{Grid, MediaContent, media_limit};
use crate::maps::{FilterKind, Levels, Map, Maps, OpaqueMaps, TILE_TEXELS, level_texels, leveled_texels};
use crate::scene::FARTHEST;
use crate::shaders::{self, constant, curve, folder, set};
use crate::world::{BuildStamp, Parts, World};

map_settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Number of nodes per curve: 4, 8 or 16. Each takes 8 bytes.
        nodes: u32 = Setting::one_of("8", &["4", "8", "16"], "nodes of a texel's curve");
        /// Number of samples that a ray keeps while it is marched: 4, 8, 16 or 32, but no fewer than `nodes`. When there are more, the
        /// sample whose removal changes the curve least is removed.
        samples: u32 = Setting::one_of(
            "8", &["4", "8", "16", "32"], "samples that a ray keeps while it is marched, no fewer than nodes; the cheapest is removed");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// Voxels per side of the density grid that is marched: 64, 128 or 256.
        grid: u32 = Setting::one_of("128", &["64", "128", "256"], "voxels per side of the density grid that is marched");
        /// A sample is kept once it differs from the last one by this many ten-thousandths of the remaining light, 0 to 10,000.
        relative: u32 = Setting::number(
            "500", 0, 10000, "a sample is kept once it is off by so many ten-thousandths of the light that is left");
        /// The sample must also differ by this many ten-thousandths of the full light, 0 to 10,000.
        absolute: u32 = Setting::number(
            "0", 0, 10000, "and by so many ten-thousandths of all the light");
        /// Number of levels of detail, 1 to 12, including the map itself; each has half as many texels per side as the one before. Look-ups
        /// for pixels wider than a texel read the coarser levels.
        levels: u32 = LEVELS;
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "marched",
    about: "AVSM's curves from a march through one density grid of smoke and hair for all lights (Unreal Engine 5)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: COMPUTE, requires: &[] }],
    plan: |spec, path| PathPlan { path, limits: vec![limit(&spec.settings())], promises: PROMISES },
    runs: Runs {
        usual: &["nodes=8"],
        usual_on_cpu: &["size=128,grid=64,nodes=8"],
        compare: &["nodes=8"],
        on_cpu: &[(Name::SIZE, "64"), (Name::GRID, "64")],
        stress_smoke: &["size=32,grid=64", "size=32,grid=64,nodes=16,samples=32,levels=3"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Marched::new(context, world, &spec.settings())?)),
};

/// Returns the limit that the larger of two buffers requires: the curves or the grid.
fn limit(settings: &Settings) -> Limit {
    let Settings { nodes, size, grid, levels, .. } = *settings;
    let curves = Limit::buffer_range(8 * u64::from(nodes) * leveled_texels(size, levels));
    if curves.least > media_limit(grid, 1).least { curves } else { media_limit(grid, 1) }
}

/// The grid's integer sums do not depend on the order of casters. No mean error is promised, since the grid is only as fine as its voxels.
/// No bound on changes from frame to frame is promised, since curves change when a caster moves from one voxel into the next.
const PROMISES: Promises = Promises { order: Some(0.0), step: None, ..Promises::OF_DEPTH };

const COMPUTE: &str = "compute";

/// The technique, opened for one world.
pub struct Marched {
    settings: Settings,
    maps: Maps,
    grid: Grid,
    /// Nodes of each texel, map by map and row by row; then the nodes of coarser levels.
    nodes: Buffer,
    /// Number of rays per tile that hit anything.
    counts: Buffer,
    march: Kernel,
    levels: Option<Levels>,
    made: BuildStamp,
    look_up: Bindings,
    constants: Constants,
}

impl Marched {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device cannot bind a buffer of that many voxels; [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { nodes, samples, size, grid: voxels, relative, absolute, .. } = *settings;
        let filter = settings.filter();
        filter.check(world, size)?;
        let maps = Maps::new(context, world, size, OpaqueMaps::shared(settings.opaque))?;
        let grid = Grid::of_media(context, world, voxels, MediaContent::default())?;
        let texels = maps.texels() + (1..settings.levels).map(|level| level_texels(&maps, level)).sum::<u64>();
        let full = Buffer::new(context, "marched.nodes", 8 * texels * u64::from(nodes), Memory::Device)?;
        let [x, y] = maps.tiles().map(u64::from);
        let counts = Buffer::new(context, "marched.counts", 4 * x * y * u64::from(maps.count()), Memory::Device)?;
        let constants = Constants::new()
            .set(constant::NODES, nodes)
            .set(constant::WORK, samples.max(nodes))
            .set(constant::GRID_SIZE, voxels)
            .set(constant::RELATIVE_ERROR, relative as f32 / 10_000.0)
            .set(constant::ABSOLUTE_ERROR, absolute as f32 / 10_000.0)
            .set(constant::TILED, settings.skip)
            .set(constant::LEVELS, settings.levels);
        let constants = filter.constants(constants);
        let buffers = grid.buffers();
        let of_grid = set::Marched { grid: buffers.data, media: buffers.media, media_bits: buffers.media_bits };
        let of_grid = of_grid.bind(context, "marched.grid")?;
        let curves =
            set::Curves { nodes: &full, counts: &counts, full_nodes: &full }.bind(context, "marched.curves")?;
        let sets = [maps.scene(), &of_grid, &curves];
        let march = Kernel::compute(context, &shaders::marched::MARCH, &sets, &constants)?;
        let below = set::CurveLevels { nodes: &full, counts: &counts }.bind(context, "marched.levels")?;
        let sets = [maps.scene(), &below];
        let levels = Levels::new(context, "marched.levels", &maps, settings.levels, &curve::LEVELS, &sets, &constants)?;
        let more = set::CurveLookUp { nodes: &full, tiles: &counts };
        let look_up = maps.look_up(context, "marched.look_up", &more.resources())?;
        let made = BuildStamp::of(Maps::VOLUME);
        Ok(Self { settings: *settings, maps, grid, nodes: full, counts, march, levels, made, look_up, constants })
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the nodes of each texel, map by map and row by row, as [`super::NodeData`] in order of depth. With `skip`, tiles that no
    /// caster touches are not written.
    pub fn curves(&self) -> &Buffer {
        &self.nodes
    }

    /// After a build, returns how many rays hit anything in each tile of each map.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn counts(&self) -> Result<Vec<u32>> {
        self.counts.read((self.counts.bytes() / 4) as usize)
    }

    fn march(&self, commands: &mut Commands) {
        let [x, y] = self.maps.tiles();
        commands.pass("marched.march", |pass| pass.dispatch(&self.march, &(), [x, y, self.maps.count()]));
    }
}

impl Technique for Marched {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.grid.forget();
        self.made.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        self.grid.record(commands, world);
        if self.made.make(world) {
            self.march(commands);
            if let Some(levels) = &self.levels {
                levels.record(commands);
            }
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.maps.settle(frame, false)?;
        if grew {
            self.made.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::MARCHED, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Marched {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn nodes(&self, map: usize, [x, y]: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        let ([width, height], [across, down]) = (self.maps.size(), self.maps.tiles());
        let tile = (map as u32 * down + y / TILE_TEXELS) * across + x / TILE_TEXELS;
        let met: Vec<u32> = self.counts.read_from(tile as usize, 1)?;
        if self.settings.filter != FilterKind::Bilinear || met == [0] {
            return Ok(Vec::new());
        }
        let (nodes, texel) = (self.settings.nodes as usize, (map as u32 * height + y) * width + x);
        let curve: Vec<[f32; 2]> = self.nodes.read_from(texel as usize * nodes, nodes)?;
        let used = curve.into_iter().filter(|[depth, _]| *depth < FARTHEST);
        Ok(used.map(|[depth, value]| (depth.into(), (-f64::from(value)).exp())).collect())
    }

    fn facts(&self) -> Result<Facts> {
        let met: u64 = self.counts()?.into_iter().map(u64::from).sum();
        Ok(Facts {
            path: COMPUTE,
            reason: "the only path".into(),
            bytes_resident: self.nodes.bytes() + self.counts.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.grid.resident_bytes()
                + self.grid.transient_bytes()
                + self.maps.opaque_bytes_transient(),
            nodes: Some(self.settings.nodes),
            counters: [("covered_texels".into(), met)].into(),
            ..Facts::default()
        })
    }
}
