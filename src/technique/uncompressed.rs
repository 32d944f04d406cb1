//! The full list of segments, searched at each look-up: exact at texel centres, and the yardstick of Intel's 2010 demonstration of AVSM.
//!
//! A yardstick for other techniques: it discards nothing, and is slow.
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
//! let mut list = open(context, &world, &parse("uncompressed:size=64", &[])?[0])?;
//! list.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&list.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::Name;
use super::promises::ROUNDING;
use super::settings::Keyed;
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Requirement};
use crate::maps::{CasterQuads, DrawingOrder, Keep, List, Map, Maps, OpaqueMaps};
use crate::shaders::folder;
use crate::shaders::set;
use crate::world::{BuildStamp, Parts, World};

pub use super::settings::MapSettings as Settings;

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "uncompressed",
    about: "per-texel lists of all segments, exact at texel centres (the yardstick of Intel's 2010 demonstration)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: LIST, requires: &[Requirement::FragmentStores] }],
    plan: |_, path| PathPlan { path, limits: Vec::new(), promises: PROMISES },
    runs: Runs {
        usual: &[""],
        compare: &[""],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32"],
        stress_meshes: &["size=32"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Uncompressed::new(context, world, &spec.settings())?)),
};

/// Lists lose nothing. Their segments are added up in the order in which fragments arrive, which differs from run to run.
const PROMISES: Promises =
    Promises { mean: Some(1e-4), tail: Some(1e-3), order: Some(ROUNDING), repeats: false, ..Promises::OF_DEPTH };

const LIST: &str = "list";

/// The technique, opened for one world.
pub struct Uncompressed {
    maps: Maps,
    /// Segment lists of all maps.
    pub list: List,
    listed: BuildStamp,
    look_up: Bindings,
    constants: Constants,
}

impl Uncompressed {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device lacks what it needs, [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        ENTRY.require(context, LIST)?;
        let filter = settings.filter(world)?;
        let maps = Maps::new(context, world, settings.size, OpaqueMaps::shared(settings.opaque))?;
        let quads = CasterQuads::new(context, world, &maps, DrawingOrder::Index, None)?;
        let list = List::new(context, &maps, Some(quads), Keep::All, None)?;
        let more = set::UncompressedLookUp { heads: &list.heads, segments: &list.segments };
        let look_up = maps.look_up(context, "uncompressed.look_up", &more.resources())?;
        let listed = BuildStamp::of(Maps::VOLUME);
        Ok(Self { maps, list, listed, look_up, constants: filter.constants(Constants::new()) })
    }
}

impl Technique for Uncompressed {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.listed.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        if self.listed.make(world) {
            self.list.begin(commands, world, &self.maps, None);
            self.list.capture(commands, 0..self.maps.count(), 0);
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.list.settle(frame)?;
        if grew {
            self.list.bind_segments(&self.look_up, set::UncompressedLookUp::SEGMENTS)?;
        }
        let grew = self.maps.settle(frame, grew)?;
        if grew {
            self.listed.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::UNCOMPRESSED, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Uncompressed {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        let counters = [("fragments", self.list.fragments()), ("overflowed", self.list.overflowed())];
        Ok(Facts {
            path: LIST,
            reason: "the only path".into(),
            bytes_resident: self.list.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.maps.opaque_bytes_transient(),
            counters: counters.map(|(k, v)| (k.to_owned(), v)).into(),
            ..Facts::default()
        })
    }
}
