//! Wavelet opacity maps: the optical depth along a texel's ray in Haar wavelets. Source: Aizenshtein, Smal and McGuire 2022, Wavelet
//! Transparency.
//!
//! Haar wavelets of rank R represent the means of the optical depth over 2^(R + 1) even intervals of the range, and these means are stored.
//! Each mean is placed at the centre of its interval; a look-up reads two.
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
//! let mut wavelet = open(context, &world, &parse("wavelet:size=64", &[])?[0])?;
//! wavelet.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&wavelet.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::Name;
use super::settings::{Keyed, Setting};
use super::sums::{self, PATHS, RANGE, Range, STORAGE, Storage, promises, sum_kernels};
use super::texel_map::{TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, PathPlan, Runs};
use crate::gpu::{Constants, Context};
use crate::maps::{EVEN_CELLS, Sums, TexelWay};
use crate::shaders::constant::{MEANS, SUM_RANGE, SUM_STORAGE};
use crate::shaders::folder;
use crate::world::World;
use crate::{Error, Result};

texel_settings! {
    /// Rank of the wavelets: 2, 3 or 4.
    rank: u32 = Setting::one_of("3", &["2", "3", "4"], "rank of the wavelets: 2 to the rank + 1 numbers per texel");
    /// Depth range that the wavelets cover.
    range: Range = RANGE;
    /// Storage format of a sum.
    storage: Storage = STORAGE;
}

/// Highest rank whose sums fit into the render targets.
const MOST_DRAWN: u32 = 3;

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "wavelet",
    about: "the optical depth of a ray in Haar wavelets (Aizenshtein, Smal and McGuire 2022)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: PATHS,
    plan: |spec, path| {
        let settings: Settings = spec.settings();
        let limits = sums::limits(path, [settings.means() + 1, settings.words()], settings.size, settings.levels);
        PathPlan { path, limits, promises: promises(path) }
    },
    runs: Runs {
        usual: &["rank=3"],
        usual_on_cpu: &["size=128,rank=3"],
        compare: &["rank=3"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=binned|raster", "size=32,path=binned,range=scene,storage=r16f,levels=3"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Wavelet::new(context, world, &spec.settings())?)),
};

/// The technique, opened for one world.
pub type Wavelet = TexelMap<Settings, Sums>;

impl Settings {
    /// Returns the number of intervals in a texel's range.
    pub fn means(&self) -> u32 {
        2 << self.rank
    }

    /// Returns the number of words per texel.
    pub fn words(&self) -> u32 {
        self.range.constant() + self.storage.words(self.means() + 1)
    }
}

impl Wavelet {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light; [`Error::Refused`]
    /// if the raster path cannot draw so high a rank, [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { path, range, storage, .. } = *settings;
        let constants = Constants::new()
            .set(MEANS, settings.means())
            .set(SUM_RANGE, range.constant())
            .set(SUM_STORAGE, storage as u32);
        if path == Some(TexelWay::Raster) && settings.rank > MOST_DRAWN {
            let needs =
                format!("a rank of at most {MOST_DRAWN} with path=raster, which draws to eight targets of four sums");
            return Err(Error::Refused(needs.into()));
        }
        let common = settings.common(constants);
        let kernels = sum_kernels!(wavelet, settings.means() + 1, settings.words(), settings.levels, EVEN_CELLS);
        Self::open(context, world, &ENTRY, (settings, common), folder::WAVELET, |maps, way, skip, constants| {
            Sums::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
