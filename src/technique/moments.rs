//! Moments of the optical depth along a texel's ray, which bound the optical depth in front of any given depth. Source: Münstermann,
//! Krumpen, Klein and Peters 2018, Moment-Based Order-Independent Transparency.
//!
//! Sums do not depend on the order of casters, so neither a list nor a sort is needed, and path=binned gives the same bytes for every
//! order. The moments give the sharpest lower and upper bounds of each result. The technique interpolates between them: `overestimation` is
//! the fraction from the lighter bound to the darker. Results are exact in front of and behind all smoke.
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
//! let mut moments = open(context, &world, &parse("moments:size=64", &[])?[0])?;
//! moments.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&moments.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::promises::ROUNDING;
use super::settings::{Keyed, Setting};
use super::sums::{self, PATHS, RANGE, Range, sum_kernels};
use super::texel_map::{TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, Path, PathPlan, Promises, Runs};
use crate::Result;
use crate::gpu::{Constants, Context};
use crate::maps::{EVEN_CELLS, Sums, TexelWay};
use crate::shaders::constant::{MOMENTS, OVERESTIMATION, SUM_RANGE, SUM_STORAGE, TRIGONOMETRIC};
use crate::shaders::folder;
use crate::world::World;

words! {
    /// Basis functions of the moments.
    pub enum Basis {
        /// Powers of the depth, summed as Chebyshev polynomials, which carry the same information and round better.
        Power = "power",
        /// Cosines and sines, half of each.
        Trigonometric = "trigonometric",
    }
}

words! {
    /// Storage format of a moment. Twins: STORAGE_F32 and so on.
    pub enum Storage {
        /// 32 bits.
        F32 = "r32f",
        /// 16-bit fixed point: the moment divided by the optical depth, which itself keeps 32 bits.
        Fixed = "r16",
    }
}

texel_settings! {
    /// Number of moments per texel besides the optical depth: 4, 6 or 8. With [`Basis::Trigonometric`], half are cosines and half are
    /// sines.
    moments: u32 = Setting::one_of("6", &["4", "6", "8"], "numbers besides the optical depth; half are cosines and half sines where the basis has both");
    /// Basis functions of the moments.
    basis: Basis = Setting::word("power", "moments of powers of the depth, or of its cosines and sines");
    /// Position of results between the sharpest bounds, in hundredths from the lighter bound to the darker: 0 to 100.
    overestimation: u32 =
        Setting::number("45", 0, 100, "hundredths of the way from the lighter to the darker of the sharpest bounds");
    /// Depth range that the moments cover.
    range: Range = RANGE;
    /// Storage format of a moment.
    storage: Storage = Setting::word("r32f", "4 bytes per moment, or 16 bits of fixed point over the optical depth");
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "moments",
    about: "moments of a ray's optical depth (Münstermann, Krumpen, Klein and Peters 2018)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: PATHS,
    plan: |spec, path| {
        let settings: Settings = spec.settings();
        let limits = sums::limits(path, [settings.moments + 1, settings.words()], settings.size, settings.levels);
        PathPlan { path, limits, promises: promises(&settings, path) }
    },
    runs: Runs {
        usual: &["moments=6"],
        usual_on_cpu: &["size=128,moments=6"],
        compare: &["moments=4|6|8", "basis=trigonometric"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &[
            "size=32,path=binned|raster",
            "size=32,path=binned,moments=8,range=scene|texel",
            "size=32,path=binned,moments=4,storage=r16,levels=3",
            "size=32,path=binned,basis=trigonometric",
        ],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Moments::new(context, world, &spec.settings())?)),
};

/// The first sum is the total optical depth, so the tail is right. Integer sums do not depend on the order of casters; drawn sums round at
/// each caster, and the bounds amplify the rounding. With range=texel, bounds from powers never let transmittance rise along a ray. Cosines
/// and sines treat the range as a circle, so casters at its end may affect results at its beginning. With range=scene, the bounds do not
/// know where the smoke of a texel ends: in front of and behind the smoke, their rounding error is multiplied by the total optical depth.
fn promises(settings: &Settings, path: &Path) -> Promises {
    let (own, binned) = (settings.range == Range::Texel, path.is(TexelWay::Binned));
    let rise = own && binned && settings.basis == Basis::Power;
    Promises {
        tail: Some(1e-3).filter(|_| own),
        order: Some(0.0).filter(|_| binned),
        rise: Some(ROUNDING).filter(|_| rise),
        ..Promises::OF_DEPTH
    }
}

/// The technique, opened for one world.
pub type Moments = TexelMap<Settings, Sums>;

impl Settings {
    /// Returns the number of words per texel.
    pub fn words(&self) -> u32 {
        self.range.constant() + 1 + if self.storage == Storage::F32 { self.moments } else { self.moments / 2 }
    }
}

impl Moments {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { moments, basis, overestimation, range, storage, .. } = *settings;
        let constants = Constants::new()
            .set(MOMENTS, moments)
            .set(TRIGONOMETRIC, basis == Basis::Trigonometric)
            .set(OVERESTIMATION, overestimation as f32 / 100.0)
            .set(SUM_RANGE, range.constant())
            .set(SUM_STORAGE, storage as u32);
        let common = settings.common(constants);
        let kernels = sum_kernels!(moments, moments + 1, settings.words(), settings.levels, EVEN_CELLS);
        Self::open(context, world, &ENTRY, (settings, common), folder::MOMENTS, |maps, way, skip, constants| {
            Sums::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
