//! Fourier opacity maps: the optical depth along a texel's ray as a series of sines and cosines. Source: Jansen and Bavoil 2010, Fourier
//! Opacity Mapping.
//!
//! Sums do not depend on the order of casters, so neither a list nor a sort is needed, and path=binned gives the same bytes for every
//! order. A series of few terms rings around a step. Results stay in [0, 1], and are exact in front of and behind all smoke.
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
//! let mut fourier = open(context, &world, &parse("fourier:size=64", &[])?[0])?;
//! fourier.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&fourier.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::Name;
use super::settings::{Keyed, Setting};
use super::sums::{self, PATHS, RANGE, Range, STORAGE, Storage, sum_kernels};
use super::texel_map::{TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, Path, PathPlan, Promises, Runs};
use crate::Result;
use crate::gpu::{Constants, Context};
use crate::maps::{EVEN_CELLS, Sums};
use crate::shaders::constant::{COEFFICIENTS, SUM_RANGE, SUM_STORAGE};
use crate::shaders::folder;
use crate::world::World;

texel_settings! {
    /// Number of coefficients in a texel's series: 7, 15 or 31.
    coefficients: u32 = Setting::one_of("15", &["7", "15", "31"], "coefficients of a texel's series: one, and two per harmonic");
    /// Depth range that the series covers.
    range: Range = RANGE;
    /// Storage format of a sum.
    storage: Storage = STORAGE;
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "fourier",
    about: "the optical depth of a ray as a Fourier series (Jansen and Bavoil 2010)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: PATHS,
    plan: |spec, path| {
        let settings: Settings = spec.settings();
        let limits = sums::limits(path, [settings.coefficients, settings.words()], settings.size, settings.levels);
        PathPlan { path, limits, promises: promises(path) }
    },
    runs: Runs {
        usual: &["coefficients=15"],
        usual_on_cpu: &["size=128,coefficients=15"],
        compare: &["coefficients=7|15"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=binned|raster", "size=32,path=binned,range=scene,storage=r16f,levels=3"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Fourier::new(context, world, &spec.settings())?)),
};

/// A series rings, so transmittance may rise along a ray: nothing is promised about that.
fn promises(path: &Path) -> Promises {
    Promises { rise: None, ..sums::promises(path) }
}

/// The technique, opened for one world.
pub type Fourier = TexelMap<Settings, Sums>;

impl Settings {
    /// Returns the number of words per texel.
    pub fn words(&self) -> u32 {
        self.range.constant() + self.storage.words(self.coefficients)
    }
}

impl Fourier {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { coefficients, range, storage, .. } = settings;
        let constants = Constants::new()
            .set(COEFFICIENTS, *coefficients)
            .set(SUM_RANGE, range.constant())
            .set(SUM_STORAGE, *storage as u32);
        let common = settings.common(constants);
        let kernels = sum_kernels!(fourier, *coefficients, settings.words(), settings.levels, EVEN_CELLS);
        Self::open(context, world, &ENTRY, (settings, common), folder::FOURIER, |maps, way, skip, constants| {
            Sums::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
