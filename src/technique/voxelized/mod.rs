//! Voxelized shadows: an octree stores for each voxel of a cube around the meshes whether light reaches it. Merging equal parts of an
//! octree turns it into a graph. Each light has one octree or graph, or one per face if it shines in all directions. Sources: Sintorn,
//! Kämpe, Olsson and Assarsson 2014; Kämpe, Sintorn and Assarsson 2013 and 2016; Scandolo, Bauszat and Eisemann 2016.
//!
//! Baked once for static meshes and lights. If something moves, only the columns of voxels near it are recomputed, in blocks of 8 × 8
//! columns.
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
//! let mut tree = open(context, &world, &parse("voxelized:size=64", &[])?[0])?;
//! tree.build(&world)?;
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&tree.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && below == 0.0);
//! # Ok(()) });
//! ```

mod bake;
mod buffers;
mod check;
mod cube;
mod file;
mod loaded;
mod settings;
mod tree;

pub use file::Baked;
pub use settings::{Coverage, Free, Settings, Structure};

// Exported for the program and the tests.
#[doc(hidden)]
pub use self::{
    buffers::LevelCounts,
    loaded::Loaded,
    settings::Plan,
    tree::{MAX_LEVELS, TreeData},
};

use self::bake::{Bake, Job, tree_nodes};
use self::buffers::{Buffers, BuildState, Mode, Room, Shape, Shared};
use self::cube::{Cubes, resolution};
use self::file::{bytes_on_disk, scene_hash};
use super::settings::Keyed;
use super::{
    Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Spec, Technique,
};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, MAX_UPDATE_BYTES, Memory};
use crate::scene::Resolution;
use crate::shaders::folder;
use crate::shaders::set;
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};
use bytemuck::Zeroable;
use std::collections::BTreeMap;

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "voxelized",
    about: "every voxel lit or shadowed, in an octree or a graph of it (Sintorn et al. 2014, Kämpe et al. 2016)",
    casts: Casts::MESHES,
    lifetime: Lifetime::Baked,
    keys: Settings::KEYS,
    paths: &[Path { name: TILES, requires: &[] }],
    plan: |_, path| PathPlan { path, limits: Vec::new(), promises: Promises::OF_OPAQUE },
    runs: Runs { usual: &[""], usual_on_cpu: &[""], stress_meshes: &["size=64"], ..Runs::NONE },
    open,
};

fn open(context: &Context, world: &World, spec: &Spec) -> Result<Box<dyn Technique>> {
    let settings: Settings = spec.settings();
    if settings.file.is_none() {
        return Ok(Box::new(Voxelized::new(context, world, &settings)?));
    }
    Ok(Box::new(Loaded::new(context, world, &settings, |key| !spec.text(key).is_empty())?))
}

const TILES: &str = "tiles";

/// Maximum capacity for the nodes of a level, and for the triangle entries in bins. Tables have twice as many slots, which are numbered in
/// 32 bits.
const MOST_NODES: u32 = 1 << 28;

/// Maximum number of times that a bake may start over with larger buffers.
const MOST_RESTARTS: u32 = 64;

/// The parts of the world that a bake depends on.
const OF: Parts = Parts::MESHES.and(Parts::LIGHTS);

/// The step to record next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Tile {
        light: u32,
        tile: u32,
    },
    /// The nodes are built, but the buffer for the data of look-ups was too small.
    Pack,
}

/// The technique, opened for one world.
pub struct Voxelized {
    context: Context,
    plan: Plan,
    shape: Shape,
    room: Room,
    buffers: Buffers,
    shared: Shared,
    set: Bindings,
    bake: Bake,
    look_up: Bindings,
    constants: Constants,
    cubes: Cubes,
    /// The state of the world that `cubes` were fitted to.
    looked: BuildStamp,
    triangles: u32,
    /// The world's, at the last bake.
    alpha_generation: u64,
    step: Step,
    moves: Moves,
    /// Whether `step` is recorded and its results have not been read yet.
    recorded: bool,
    /// Whether the bake is complete, for the world that `cubes` were fitted to.
    baked: bool,
    restarts: u32,
    state: BuildState,
    /// Number of leaves and nodes of all tiles and lights, before merging in `tree` and after merging in `kept`.
    tree: [u64; 2],
    kept: [u64; 2],
}

/// State kept from one bake for the next.
#[derive(Default)]
struct Moves {
    /// Whether a bake has been completed. If so, another bake means that something moves.
    baked: bool,
    /// The trees whose columns are kept.
    kept: Option<Vec<TreeData>>,
    /// For each tree being baked, whether all of its columns are recomputed.
    whole: Vec<bool>,
    /// Whether meshes or lights have changed since this bake began.
    mixed: bool,
}

/// Names of the counts.
const COUNTS: [&str; 4] = ["leaves", "nodes", "tree_leaves", "tree_nodes"];

fn counters(counts: [u64; COUNTS.len()]) -> BTreeMap<String, u64> {
    COUNTS.into_iter().map(str::to_owned).zip(counts).collect()
}

impl Voxelized {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed, `file` is given, which [`Loaded::new`] opens, or there are too many lights;
    /// [`Error::Refused`] if the host does not know a bounding box of the triangles; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        if let Some(file) = &settings.file {
            return Err(Error::input(file, "a bake is not read from a file", "open what is loaded, or name none"));
        }
        Self::planned(context, world, &Plan::of(settings))
    }

    /// Creates the technique from a plan.
    ///
    /// # Errors
    /// [`Error::Input`] if there are too many lights, [`Error::Refused`] if the host does not know a bounding box of the triangles,
    /// [`Error::Gpu`] if memory runs out.
    pub fn planned(context: &Context, world: &World, plan: &Plan) -> Result<Self> {
        let cubes = Cubes::new(world, plan.size)?;
        let count = cubes.views.len();
        if count * size_of::<TreeData>() > MAX_UPDATE_BYTES {
            let most = MAX_UPDATE_BYTES / size_of::<TreeData>();
            let cause = format!("{count} lights and faces of lights, and {most} have trees");
            return Err(Error::input(world.name(), cause, "use fewer lights"));
        }
        let shape = Shape { size: plan.size, tile: plan.tile.min(plan.size) };
        let triangles = world.triangle_capacity();
        let device = |name: &str, words: u64| Buffer::new(context, name, 4 * words, Memory::Device);
        let shared = Shared {
            trees: device("voxelized.trees", (count.max(1) * size_of::<TreeData>() / 4) as u64)?,
            triangles: world.triangles.clone(),
            sides: world.sides.clone(),
            triangle_count: triangles,
            tree_count: count as u64,
        };
        let room = Room::new(shape, triangles, cubes.has_perspective());
        let buffers = Buffers::new(context, shape, &room, plan.merges(), plan.keep_columns, &shared)?;
        let set = buffers.bindings(context)?;
        let bake = Bake::new(context, &set, plan, world.constants())?;
        let look_up = set::VoxelizedLookUp { trees: &shared.trees, nodes: &buffers.data };
        let look_up = look_up.bind(context, "voxelized.look_up")?;
        Ok(Self {
            context: context.clone(),
            plan: *plan,
            shape,
            room,
            buffers,
            shared,
            set,
            bake,
            look_up,
            constants: plan.constants(Constants::new()),
            cubes,
            looked: BuildStamp::of(OF),
            triangles,
            alpha_generation: world.alpha_generation,
            step: Step::Tile { light: 0, tile: 0 },
            moves: Moves::default(),
            recorded: false,
            baked: false,
            restarts: 0,
            state: BuildState::zeroed(),
            tree: [0; 2],
            kept: [0; 2],
        })
    }

    /// Returns the trees of all lights.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn trees(&self) -> Result<Vec<TreeData>> {
        self.shared.trees.read(self.cubes.views.len())
    }

    /// Returns the nodes of all trees, as words.
    ///
    /// # Errors
    /// Same as [`Voxelized::trees`].
    pub fn nodes(&self) -> Result<Vec<u32>> {
        self.buffers.data.read(self.state.words as usize)
    }

    /// Returns the number of blocks of 8 × 8 columns that the last bake recomputed: all blocks, or the ones in which something moved.
    pub fn found_blocks(&self) -> u32 {
        self.state.found
    }

    /// Returns the entry and exit of each column of the last tile, in voxels, row by row; empty without [`Plan::keep_columns`].
    ///
    /// # Errors
    /// Same as [`Voxelized::trees`].
    pub fn columns(&self) -> Result<Vec<[u32; 2]>> {
        let count = if self.plan.keep_columns { self.shape.tile.pow(2) as usize } else { 0 };
        self.buffers.columns.read(count)
    }

    /// Returns the counts that [`COUNTS`] names, in the same order.
    fn counts(&self) -> [u64; COUNTS.len()] {
        [self.kept[0], self.kept[1], self.tree[0], self.tree[1]]
    }

    /// Prepares the first tile: fits cubes to the current meshes, and finds the trees whose columns are kept.
    fn look_at(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        (self.tree, self.kept) = ([0; 2], [0; 2]);
        if !self.looked.is_current(world) {
            self.cubes = Cubes::new(world, self.plan.size)?;
            self.looked.make(world);
        }
        let trees = TreeData::all(&self.cubes);
        // Moves are found by the corners of triangles, whose alpha may change alone.
        let same_alpha = self.alpha_generation == world.alpha_generation;
        self.alpha_generation = world.alpha_generation;
        let kept = self.moves.kept.take().filter(|_| same_alpha);
        let is_kept = |i: usize| kept.as_ref().is_some_and(|kept| kept.get(i) == trees.get(i));
        self.moves.whole = (0..trees.len()).map(|i| !is_kept(i)).collect();
        self.moves.mixed = false;
        commands.pass("voxelized.begin", |pass| pass.update(&self.shared.trees, &trees));
        Ok(())
    }

    /// Enlarges the buffers if the tile of the last submission did not fit, and starts the bake over. Returns whether it did so.
    fn grow(&mut self, tile: u32) -> Result<bool> {
        let state = &self.state;
        // Later tiles may need as much capacity again as all tiles so far.
        let to_come = (f64::from(self.shape.tiles().pow(2)) / f64::from(tile + 1)).clamp(1.0, 2.0);
        let more = |needs: u32| ((f64::from(needs) * to_come * 1.1) as u32).min(MOST_NODES.max(needs));
        let mut room = self.room.clone();
        let enlarge = |has: &mut u32, needs: u32| *has = if needs > *has { more(needs) } else { *has };
        enlarge(&mut room.entries, state.entries);
        enlarge(&mut room.large, state.large);
        enlarge(&mut room.pieces, state.pieces);
        for (level, counts) in state.levels.iter().enumerate().take(self.shape.root_level() as usize + 1) {
            let candidates = if level == 0 { &mut room.leaf_candidates } else { &mut room.node_candidates };
            enlarge(candidates, counts.demanded);
            // A full table cannot tell how many nodes it would have stored, so its capacity doubles.
            let unique = if counts.lost > 0 { room.unique[level].saturating_mul(2) } else { 0 };
            enlarge(&mut room.unique[level], unique.max(counts.unique));
        }
        if room == self.room {
            return Ok(false);
        }
        if room.most() > MOST_NODES {
            let cause = format!("{} nodes of one size, and at most {MOST_NODES} can be baked", room.most());
            return Err(self.error(cause, "use a smaller size, or structure=dag with closed=on"));
        }
        self.restart(room)?;
        Ok(true)
    }

    /// Enlarges the buffer to hold the words that look-ups read and one more, which a look-up may read as the second half of a pointer. A
    /// single tree keeps its nodes and only packs them again. With several trees, the bake starts over.
    fn grow_data(&mut self) -> Result<BuildStatus> {
        let room = Room { data: self.state.words.saturating_add(1), ..self.room.clone() };
        if self.cubes.views.len() > 1 {
            self.restart(room)?;
            return Ok(BuildStatus::Retry);
        }
        self.room = room;
        let bytes = 4 * u64::from(self.room.data);
        self.buffers.data = Buffer::new(&self.context, "voxelized.data", bytes, Memory::Device)?;
        self.set.replace(set::VoxelizedBuild::DATA, &self.buffers.data)?;
        self.look_up.replace(set::VoxelizedLookUp::NODES, &self.buffers.data)?;
        self.step = Step::Pack;
        Ok(BuildStatus::Continue)
    }

    fn error(&self, cause: String, way_out: &str) -> Error {
        let name = format!("voxelized:size={}", self.plan.size);
        Error::Gpu { operation: "bake", name, cause: cause.into(), way_out: way_out.into() }
    }

    fn restart(&mut self, room: Room) -> Result<()> {
        self.restarts += 1;
        if self.restarts > MOST_RESTARTS {
            return Err(self.error(format!("{MOST_RESTARTS} times it had too little room"), "report this as a bug"));
        }
        let plan = &self.plan;
        let buffers = Buffers::new(&self.context, self.shape, &room, plan.merges(), plan.keep_columns, &self.shared)?;
        buffers.rebind(&self.set)?;
        self.look_up.replace(set::VoxelizedLookUp::NODES, &buffers.data)?;
        (self.room, self.buffers) = (room, buffers);
        self.step = Step::Tile { light: 0, tile: 0 };
        self.moves.kept = None;
        Ok(())
    }

    /// Returns the bits of [`Mode`] for a tree.
    fn mode(&self, tree: usize) -> u32 {
        let bit = |is: bool, bit: u32| if is { bit } else { 0 };
        bit(self.moves.whole.get(tree) != Some(&false), Mode::WHOLE)
            | bit(self.room.stays, Mode::SEEN)
            | bit(tree + 1 == self.cubes.views.len(), Mode::LAST)
    }
}

impl Technique for Voxelized {
    fn made_of(&self) -> Parts {
        OF
    }

    fn forget(&mut self) {
        self.baked = false;
        (self.moves.kept, self.moves.baked) = (None, false);
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        world.has_maps(self.cubes.views.len())?;
        cube::lights_are_known(world)?;
        // The next step depends on the results of the recorded one, which have not been read yet.
        if self.recorded || (self.baked && self.looked.is_current(world)) {
            return Ok(());
        }
        self.baked = false;
        let tiles = self.shape.tiles();
        let first = self.step == Step::Tile { light: 0, tile: 0 };
        if first {
            self.look_at(commands, world)?;
        }
        self.moves.mixed |= !self.looked.is_current(world);
        let job = |light: u32| Job {
            buffers: &self.buffers,
            room: &self.room,
            shape: self.shape,
            light,
            perspective: self.cubes.is_perspective(light as usize),
            mode: self.mode(light as usize),
        };
        match self.step {
            Step::Tile { light, tile } => {
                let job = job(light);
                if tile == 0 {
                    self.bake.begin(commands, &job, self.triangles);
                }
                self.bake.tile(commands, &job, [tile % tiles, tile / tiles], self.triangles);
                if tile + 1 == tiles * tiles {
                    self.bake.above(commands, &job);
                    self.bake.pack(commands, &job);
                }
            }
            Step::Pack => self.bake.pack(commands, &job(0)),
        }
        commands.read_back(&self.buffers.state, &self.buffers.state_read);
        self.recorded = true;
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        if !self.recorded {
            return Ok(BuildStatus::Done);
        }
        // The step was recorded in another frame, whose results are not available yet.
        let Some(state) = self.buffers.state_read.read::<BuildState>(frame, 1)? else {
            return Ok(BuildStatus::Continue);
        };
        self.state = state.first().copied().unwrap_or_default();
        self.recorded = false;
        if let Step::Tile { light, tile } = self.step {
            if self.grow(tile)? {
                return Ok(BuildStatus::Retry);
            }
            // Something moves: from now on, bakes store what the next one needs to recompute only what moved.
            if self.moves.baked && !self.room.stays && self.shape.may_stay(self.cubes.views.len()) {
                self.restart(Room { stays: true, ..self.room.clone() })?;
                return Ok(BuildStatus::Retry);
            }
            let levels = &self.state.levels;
            let top = self.shape.root_level();
            let last = tile + 1 == self.shape.tiles().pow(2);
            self.tree[0] += tree_nodes(levels, 0..=0);
            self.tree[1] += tree_nodes(levels, 1..=if last { top } else { self.shape.tile_level() });
            if !last {
                self.step = Step::Tile { light, tile: tile + 1 };
                return Ok(BuildStatus::Continue);
            }
            self.kept[0] += u64::from(levels[0].unique);
            self.kept[1] += levels[1..=top as usize].iter().map(|level| u64::from(level.unique)).sum::<u64>();
            if light as usize + 1 < self.cubes.views.len() {
                // The trees of the remaining lights are likely to need as much capacity each.
                if self.state.words >= self.room.data {
                    let all = f64::from(self.state.words) * 1.1 * self.cubes.views.len() as f64 / f64::from(light + 1);
                    self.restart(Room { data: all as u32, ..self.room.clone() })?;
                    return Ok(BuildStatus::Retry);
                }
                self.step = Step::Tile { light: light + 1, tile: 0 };
                return Ok(BuildStatus::Continue);
            }
        }
        if self.state.words >= self.room.data {
            return self.grow_data();
        }
        self.step = Step::Tile { light: 0, tile: 0 };
        (self.restarts, self.baked) = (0, true);
        self.moves.baked = true;
        self.moves.kept = (self.room.stays && !self.moves.mixed).then(|| TreeData::all(&self.cubes));
        Ok(BuildStatus::Done)
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::VOXELIZED, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Voxelized {
    fn resolution(&self) -> Vec<Resolution> {
        resolution(&self.cubes, &self.plan)
    }

    fn facts(&self) -> Result<Facts> {
        let words = u64::from(self.state.words);
        Ok(Facts {
            path: TILES,
            reason: "the only path".into(),
            bytes_resident: 4 * words + self.shared.trees.bytes(),
            bytes_transient: self.buffers.transient_bytes(),
            bytes_on_disk: u64::try_from(bytes_on_disk(self.cubes.views.len() as u32, words)).ok(),
            counters: counters(self.counts()),
            ..Facts::default()
        })
    }

    fn file(&self, world: &World) -> Result<Option<Vec<u8>>> {
        let Some(meshes) = world.meshes().filter(|_| self.looked.is_current(world)) else { return Ok(None) };
        let words = self.nodes()?;
        let baked = Baked {
            plan: self.plan,
            scene: scene_hash(meshes, world.all_lights()),
            counts: self.counts(),
            trees: self.trees()?,
            words: bytemuck::cast_slice(&words),
        };
        Ok(Some(baked.bytes()))
    }
}
