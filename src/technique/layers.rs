//! Optical depth in layers: each texel stores the optical depth up to the end of each layer on its ray, interpolated linearly in between.
//! Sources: Kim and Neumann 2001, Opacity Shadow Maps; Yuksel and Keyser 2008, Deep Opacity Maps; layers that span each texel's own range
//! are ours.
//!
//! Sums do not depend on the order of casters, so neither a list nor a sort is needed, and path=binned gives the same bytes for every
//! order.
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
//! let mut layers = open(context, &world, &parse("layers:size=64", &[])?[0])?;
//! layers.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&layers.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::settings::{Keyed, Setting};
use super::sums::{self, PATHS, promises, sum_kernels};
use super::texel_map::{TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, PathPlan, Runs};
use crate::Result;
use crate::gpu::{Constants, Context};
use crate::maps::Sums;
use crate::shaders::constant::{PLANES, SUM_RANGE, SUM_STORAGE};
use crate::shaders::folder;
use crate::world::World;

words! {
    /// Depth range of a texel's layers. Twins: RANGE_SCENE and so on.
    pub enum Range {
        /// The whole depth of the map, as in opacity shadow maps.
        Scene = "scene",
        /// From the texel's front, each layer thicker than the one before, as in deep opacity maps.
        Front = "front",
        /// From the texel's front to its back.
        Texel = "texel",
    }
}

words! {
    /// Storage format of an optical depth. Twins: STORAGE_F32 and so on.
    pub enum Storage {
        /// 32 bits.
        F32 = "r32f",
        /// A half float.
        F16 = "r16f",
        /// 16-bit fixed point.
        Fixed = "r16",
    }
}

texel_settings! {
    /// Number of layers per texel: 4, 8, 16 or 32.
    layers: u32 = Setting::one_of("16", &["4", "8", "16", "32"], "layers of a texel, with the optical depth at their ends");
    /// Depth range of the layers.
    range: Range = Setting::word(
        "texel",
        "layers over the map's whole depth (opacity shadow maps), from a texel's front on (deep opacity maps), or from its front to its back",
    );
    /// Storage format of an optical depth.
    storage: Storage = Setting::word("r32f", "4 bytes per optical depth, half floats, or fixed point up to 16 in 16 bits");
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "layers",
    about: "optical depth up to the ends of a ray's layers, linear between (opacity shadow maps 2001, deep opacity maps 2008)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: PATHS,
    plan: |spec, path| {
        let settings: Settings = spec.settings();
        let limits = sums::limits(path, [settings.layers, settings.words()], settings.size, settings.levels);
        PathPlan { path, limits, promises: promises(path) }
    },
    runs: Runs {
        usual: &["layers=16"],
        usual_on_cpu: &["size=128,layers=16"],
        compare: &["layers=16"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &[
            "size=32,path=binned|raster",
            "size=32,path=binned,range=scene|front,storage=r16f",
            "size=32,layers=4,storage=r16,levels=3",
        ],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Layers::new(context, world, &spec.settings())?)),
};

/// The technique, opened for one world.
pub type Layers = TexelMap<Settings, Sums>;

impl Settings {
    /// Returns the number of words per texel. Twin: texel_words.
    pub fn words(&self) -> u32 {
        self.range as u32 + if self.storage == Storage::F32 { self.layers } else { self.layers / 2 }
    }
}

impl Layers {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { layers, range, storage, .. } = settings;
        let constants =
            Constants::new().set(PLANES, *layers).set(SUM_RANGE, *range as u32).set(SUM_STORAGE, *storage as u32);
        let common = settings.common(constants);
        let kernels = sum_kernels!(layers, *layers, settings.words(), settings.levels, *layers);
        Self::open(context, world, &ENTRY, (settings, common), folder::LAYERS, |maps, way, skip, constants| {
            Sums::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
