//! Adaptive volumetric shadow maps: a compressed transmittance curve per texel. Sources: Salvi et al. 2010; Fife and Strugar
//! 2013.
//!
//! Each path has its own file: `two_pass`, `interlock`, `raster_order`, `binned`.
//!
//! The same input gives the same bytes on the same device, except for `path=two-pass,order=captured`, whose lists are in the order in which
//! the device happened to run the fragments.
//!
//! Each texel has a curve of 4, 8 or 16 nodes, which gives the transmittance at any depth in smoke and hair.
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
//! let mut avsm = open(context, &world, &parse("avsm:nodes=8,size=64", &[])?[0])?;
//! avsm.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&avsm.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

mod binned;
mod curves;
mod interlock;
mod plan;
mod promises;
mod raster_order;
mod settings;
mod two_pass;

pub use settings::{Batch, BuildPath, DetailMode, Fit, Interpolated, Order, Resolve, Settings, Storage, TexelSampling};

// Exported for the program and the tests.
#[doc(hidden)]
pub use self::curves::NodeData;

use self::binned::Binned;
use self::curves::Curves;
use self::interlock::Interlock;
use self::plan::{Cells, Plan};
use self::raster_order::RasterOrder;
use self::two_pass::TwoPass;
use super::settings::Keyed;
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, Technique};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Image, Kernel, Requirement, push_struct};
use crate::maps::{Bins, Levels, Map, Maps, OpaqueMaps, Use};
use crate::shaders::{curve, folder, set};
use crate::world::{Parts, World};
use std::ops::Range;

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "avsm",
    about: "adaptive volumetric shadow maps: a compressed transmittance curve per texel (Salvi et al. 2010)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[
        Path { name: "two-pass", requires: &[Requirement::FragmentStores] },
        Path { name: "binned", requires: &[] },
        Path { name: "interlock", requires: &[Requirement::FragmentStores, Requirement::PixelInterlock] },
        Path { name: "raster-order", requires: &[Requirement::RasterOrder] },
    ],
    plan: plan::of_path,
    runs: promises::RUNS,
    open: |context, world, spec| Ok(Box::new(Avsm::new(context, world, &spec.settings())?)),
};

push_struct! {
    /// Twin: GroupPush in glsl/technique/avsm/maps.glsl.
    struct GroupPush { first_map: u32 }
}

/// Arguments from which every path is created.
struct Site<'a> {
    context: &'a Context,
    world: &'a World,
    maps: &'a Maps,
    bins: Option<&'a Bins>,
    curves: &'a Curves,
    plan: &'a Plan,
}

/// Records a pass with one workgroup per tile of a group of maps.
fn per_tile(commands: &mut Commands, label: &str, kernel: &Kernel<GroupPush>, maps: &Maps, group: Range<u32>) {
    let [x, y] = maps.tiles();
    let push = GroupPush { first_map: group.start };
    commands.pass(label, |pass| pass.dispatch(kernel, &push, [x, y, group.len() as u32]));
}

/// The build state of the chosen path.
enum Build {
    TwoPass(TwoPass),
    Interlock(Interlock),
    RasterOrder(RasterOrder),
    Binned(Binned),
}

/// The technique, opened for one world.
pub struct Avsm {
    maps: Maps,
    /// Lists of the casters that touch each tile, for `path=binned` and `skip=on`.
    bins: Option<Bins>,
    curves: Curves,
    build: Build,
    levels: Option<Levels>,
    look_up: Bindings,
    plan: Plan,
}

impl Avsm {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if settings cannot be combined, or the device lacks what the path needs; [`crate::Error::Gpu`] if memory
    /// runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let plan = Plan::new(context, world, *settings)?;
        let even = settings.storage.unwrap_or(Storage::Full);
        let settings = plan.settings;
        let maps = Maps::new(context, world, settings.base_size(), OpaqueMaps::shared(settings.opaque))?;
        let bins = if settings.skip || plan.way == BuildPath::Binned {
            let parts = if matches!(plan.cells, Some(Cells::Lanes | Cells::Half)) { 2 } else { 1 };
            let what = Use {
                entries: plan.entries(),
                skip: settings.skip,
                reach: settings.filter().reach(),
                parts: [parts, if settings.skip { 0 } else { parts }],
                area: settings.is_of_areas(),
                blocks: curves::blocks(&maps, &settings, even)?,
            };
            Some(Bins::new(context, world, &maps, what)?)
        } else {
            None
        };
        let curves = Curves::new(context, &maps, bins.as_ref(), settings)?;
        let site = Site { context, world, maps: &maps, bins: bins.as_ref(), curves: &curves, plan: &plan };
        let build = match (plan.way, &bins) {
            (BuildPath::Binned, Some(bins)) => Build::Binned(Binned::new(&site, bins)?),
            (BuildPath::Interlock, _) => Build::Interlock(Interlock::new(&site)?),
            (BuildPath::RasterOrder, _) => Build::RasterOrder(RasterOrder::new(&site)?),
            // The binned path always has bins.
            (BuildPath::TwoPass | BuildPath::Binned, _) => Build::TwoPass(TwoPass::new(&site)?),
        };
        let below = set::CurveLevels { nodes: &curves.nodes, counts: &curves.tiles }.bind(context, "avsm.levels")?;
        let sets = [maps.scene(), &below];
        let levels =
            Levels::new(context, "avsm.levels", &maps, settings.levels, &curve::LEVELS, &sets, &plan.constants)?;
        let more = set::CurveLookUp { nodes: &curves.nodes, tiles: &curves.tiles };
        let look_up = maps.look_up(context, "avsm.look_up", &more.resources())?;
        Ok(Self { maps, bins, curves, build, levels, look_up, plan })
    }

    /// Returns one curve per texel, map by map and row by row. A curve is [`NodeData`] in order of depth, or its packed form;
    /// glsl/maps/curve/node.glsl defines the layout.
    pub fn curves(&self) -> &Buffer {
        &self.curves.nodes
    }

    /// Returns the bins, if there are any.
    pub fn bins(&self) -> Option<&Bins> {
        self.bins.as_ref()
    }

    /// Returns the opaque maps.
    pub fn opaque_image(&self) -> &Image {
        self.maps.opaque_image()
    }
}

impl Technique for Avsm {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        if let Some(bins) = &mut self.bins {
            bins.record(commands, world);
        }
        let (maps, bins) = (&self.maps, self.bins.as_ref());
        match (&mut self.build, bins) {
            (Build::TwoPass(path), bins) => path.record(commands, world, maps, bins)?,
            (Build::Interlock(path), bins) => path.record(commands, world, maps, bins)?,
            (Build::RasterOrder(path), bins) => path.record(commands, world, maps, bins)?,
            (Build::Binned(path), Some(bins)) => path.record(commands, bins),
            (Build::Binned(_), None) => {}
        }
        if let Some(levels) = &self.levels {
            levels.record(commands);
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let lists = if let Build::TwoPass(path) = &mut self.build { path.list.settle(frame)? } else { false };
        let bins = self.bins.as_mut().map_or(Ok(false), |bins| bins.settle(frame))?;
        let grew = self.maps.settle(frame, lists || bins)?;
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::AVSM, &self.look_up, &self.plan.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Avsm {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn nodes(&self, map: usize, texel: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        self.curves.texel(self.bins.as_ref(), map, texel)
    }

    fn facts(&self) -> Result<Facts> {
        let bins = self.bins.as_ref();
        let mut facts = Facts {
            path: self.plan.way.name(),
            reason: self.plan.reason.clone(),
            bytes_resident: self.curves.nodes.bytes()
                + bins.map_or(0, |_| self.curves.tiles.bytes())
                + self.maps.opaque_image().bytes(),
            bytes_transient: bins.map_or(0, Bins::bytes_transient) + self.maps.opaque_bytes_transient(),
            nodes: Some(self.plan.settings.nodes),
            ..Facts::default()
        };
        if let Some(covered) = self.curves.covered_texels(bins)? {
            facts.counters.insert("covered_texels".into(), covered);
        }
        if let Some(bins) = bins {
            facts.counters.extend(bins.counters()?);
        }
        match &self.build {
            Build::TwoPass(TwoPass { list, .. }) => {
                facts.bytes_transient += list.bytes();
                facts.counters.insert("fragments".into(), list.fragments());
                facts.counters.insert("overflowed".into(), list.overflowed());
                if list.overflowed() > 0 {
                    facts.reason = format!("{}; overflowed: {}", facts.reason, list.overflowed());
                }
            }
            Build::Interlock(path) => facts.bytes_transient += path.bytes(),
            Build::RasterOrder(path) => facts.bytes_transient += path.bytes(),
            Build::Binned(_) => {}
        }
        Ok(facts)
    }
}
