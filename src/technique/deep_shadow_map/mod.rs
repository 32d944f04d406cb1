//! Deep shadow maps: each texel keeps only the nodes it needs to stay within a given error of its exact curve. Source: Lokovic and Veach
//! 2000.
//!
//! The passes list segments, sort the segments' ends, count the nodes, add up the counts, and write the nodes texel by texel.
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
//! let mut deep = open(context, &world, &parse("deep-shadow-map:error=50,size=64", &[])?[0])?;
//! deep.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&deep.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

mod curves;
mod lists;
mod settings;

pub use settings::{BuildPath, Removal, Settings, Storage};

use self::curves::Curves;
use self::lists::Lists;
use super::keys::Name;
use super::settings::Keyed;
use super::{
    Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Spec, Technique,
};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Requirement, push_struct};
use crate::maps::{Map, Maps, OpaqueMaps};
use crate::shaders::constant::PACKED;
use crate::shaders::folder;
use crate::shaders::set;
use crate::world::{Parts, World};
use bytemuck::{Pod, Zeroable};

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "deep-shadow-map",
    about: "as many nodes per texel as its curve needs for an error, and no more (Lokovic and Veach 2000)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[
        Path { name: "two-pass", requires: &[Requirement::FragmentStores] },
        Path { name: "binned", requires: &[] },
    ],
    plan: |spec, path| PathPlan { path, limits: Vec::new(), promises: promises(spec) },
    runs: Runs {
        usual: &["error=100"],
        usual_on_cpu: &["size=128,error=100"],
        compare: &["error=100", "error=100,removal=area"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=two-pass|binned,removal=bound|area", "size=32,path=binned,storage=packed"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(DeepShadowMap::new(context, world, &spec.settings())?)),
};

/// With removal=bound, `error=` bounds the error of a curve at any depth; with removal=area, only the mean error. The tail is exact.
/// Optical depths are summed as integers, so the order of casters does not matter. With `bytes=`, the error bound is the smallest at which
/// the curves fit into the bytes, so no mean error is promised.
fn promises(spec: &Spec) -> Promises {
    let settings: Settings = spec.settings();
    let error = f64::from(settings.error());
    Promises {
        // Packed depths have 18 bits: if small casters are far apart, the quantization step exceeds the size of a caster.
        mean: Some(error).filter(|_| settings.bytes.is_none() && !settings.is_packed()),
        tail: Some(1e-3),
        order: Some(0.0),
        step: Promises::OF_DEPTH.step.map(|step| step.max(error)),
        ..Promises::OF_DEPTH
    }
}

push_struct! {
    /// Twin: DeepPush in glsl/technique/deep_shadow_map/maps.glsl.
    struct DeepPush {
        /// First map of the group. A group holds the maps whose lists exist at the same time.
        first_map: u32,
        /// Number of maps in the group.
        map_count: u32,
        /// Index of the group.
        group: u32,
        /// Capacity of the lists, in segments.
        segment_room: u32,
        /// Capacity of the node buffer, in nodes.
        node_room: u32,
        /// Round of the search for an error bound.
        round: u32,
        /// Error bound of the curves, or 0 if the search determines it.
        node_error: f32,
        /// Words per node.
        stored_words: u32,
        /// 1 if nodes are written, 0 if they are counted.
        is_written: u32,
    }
}

/// The node count of all maps, and the state of the search for an error bound. Twin: DeepState in glsl/technique/deep_shadow_map/maps.glsl.
#[doc(hidden)]
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DeepState {
    /// Number of nodes in the groups of maps so far.
    pub nodes: u32,
    /// Number of texels that have nodes.
    pub covered: u32,
    /// Error bound being tried, or the one that was found.
    pub error: f32,
    /// Largest error bound known to be too small for all nodes to fit.
    pub low: f32,
    /// Smallest error bound at which all nodes are known to fit.
    pub high: f32,
}

/// The technique, opened for one world.
pub struct DeepShadowMap {
    maps: Maps,
    lists: Lists,
    curves: Curves,
    node_error: f32,
    look_up: Bindings,
    constants: Constants,
    way: BuildPath,
    reason: String,
}

impl DeepShadowMap {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device lacks what the path needs, or `bytes` is too small for a single node; [`crate::Error::Gpu`]
    /// if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        settings.filter().check(world, settings.size)?;
        let (way, reason) = choose(context, settings);
        ENTRY.require(context, way.name())?;
        let maps = Maps::new(context, world, settings.size, OpaqueMaps::shared(settings.opaque))?;
        let lists = Lists::new(context, world, &maps, settings, way)?;
        let curves = Curves::new(context, &maps, &lists, settings)?;
        let more = set::DeepShadowMapLookUp { nodes: &curves.nodes, starts: &curves.starts };
        let look_up = maps.look_up(context, "deep_shadow_map.look_up", &more.resources())?;
        let constants = settings.filter().constants(Constants::new().set(PACKED, settings.is_packed()));
        let node_error = if settings.bytes.is_some() { 0.0 } else { settings.error() };
        Ok(Self { maps, lists, curves, node_error, look_up, constants, way, reason })
    }
}

/// Chooses the path and gives the reason.
fn choose(context: &Context, settings: &Settings) -> (BuildPath, String) {
    let features = context.features();
    if let Some(asked) = settings.path {
        return (asked, "asked for".into());
    }
    match features.lacks(Requirement::FragmentStores) {
        None if features.is_software() => (BuildPath::TwoPass, "auto: a software device".into()),
        _ => (BuildPath::Binned, format!("auto: {} device", features.kind)),
    }
}

impl Technique for DeepShadowMap {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        self.lists.begin(commands, world, &self.maps);
        for (group, of) in (0..).zip(self.maps.groups(self.lists.list.at_once())) {
            let push = DeepPush {
                first_map: of.start,
                map_count: of.len() as u32,
                group,
                segment_room: self.lists.list.capacity(),
                node_room: self.curves.room(),
                round: 0,
                node_error: self.node_error,
                stored_words: self.curves.node_words(),
                is_written: 0,
            };
            self.lists.capture(commands, of, &push);
            self.curves.record(commands, &self.maps, &push);
        }
        self.curves.end(commands);
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let lists = self.lists.settle(frame)?;
        if lists {
            self.curves.bind_events(&self.lists)?;
        }
        let curves = self.curves.settle(frame, lists)?;
        if curves {
            self.look_up.replace(set::DeepShadowMapLookUp::NODES, &self.curves.nodes)?;
        }
        Ok(BuildStatus::of(self.maps.settle(frame, lists || curves)?))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::DEEP_SHADOW_MAP, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for DeepShadowMap {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn nodes(&self, map: usize, texel: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        let nodes = self.curves.texel(map, texel)?;
        let node = |n: super::NodeData| (f64::from(n.depth), (-f64::from(n.value)).exp());
        Ok(nodes.into_iter().map(node).collect())
    }

    fn facts(&self) -> Result<Facts> {
        let mut facts = Facts {
            path: self.way.name(),
            reason: self.reason.clone(),
            bytes_resident: self.curves.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.lists.bytes() + self.curves.bytes_transient() + self.maps.opaque_bytes_transient(),
            counters: self.lists.counters()?,
            ..Facts::default()
        };
        facts.counters.extend(self.curves.counters());
        Ok(facts)
    }
}
