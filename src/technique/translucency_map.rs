//! Translucency maps: each texel stores the light left by all casters on its ray, and no depth. Sources: Crytek 2011; Bavoil and Jansen
//! 2013, External Shadows.
//!
//! One number per texel: correct behind all the smoke, unknown within it.
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
//! let mut translucency = open(context, &world, &parse("translucency-map:size=64", &[])?[0])?;
//! translucency.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&translucency.technique.answer())?[..] else { panic!("two answers") };
//! assert!((below - (-2f32).exp()).abs() < 0.02);
//! # let _ = above;
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::promises::EIGHT_BITS;
use super::settings::{Keyed, Setting};
use super::texel_map::{BINNED, RASTER, TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, Path, PathPlan, Promises, Runs};
use crate::Result;
use crate::gpu::{Blend, Constants, Context, Format, Limit, Requirement};
use crate::maps::{TexelKernels, TexelWay, Texels};
use crate::shaders::{folder, translucency_map as shaders};
use crate::world::World;

words! {
    /// Storage format of a texel.
    pub enum Storage {
        /// 8 bits.
        R8 = "r8",
        /// A half float.
        R16f = "r16f",
    }
}

texel_settings! {
    /// Storage format of a texel; 8 bits in Crytek 2011.
    storage: Storage = Setting::word("r8", "8 bits per texel (as published), or a half float");
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "translucency-map",
    about: "one product of transmittances per texel, no self-shadow (Crytek 2011)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: BINNED, requires: &[Requirement::ExtendedFormats] }, Path { name: RASTER, requires: &[] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![Limit::image_2d(spec.settings::<Settings>().size.into())],
        promises: promises(path),
    },
    runs: Runs {
        usual: &["path=binned"],
        usual_on_cpu: &["size=128,path=binned"],
        compare: &["path=raster|binned"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=raster|binned,levels=3", "size=32,path=binned,storage=r16f"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(TranslucencyMap::new(context, world, &spec.settings())?)),
};

/// Blending quantizes the texel again at each sphere, so a tail is promised only for sums, which are quantized once.
fn promises(path: &Path) -> Promises {
    Promises { tail: Some(EIGHT_BITS).filter(|_| path.is(TexelWay::Binned)), ..Promises::OF_NO_DEPTH }
}

/// The technique, opened for one world.
pub type TranslucencyMap = TexelMap<Settings>;

impl TranslucencyMap {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device lacks what the path needs, [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let common = settings.common(Constants::new());
        let (format, binned) = match settings.storage {
            Storage::R16f => (Format::R16_SFLOAT, &shaders::SUM_BITS_16),
            Storage::R8 => (Format::R8_UNORM, &shaders::SUM_BITS_8),
        };
        let kernels = TexelKernels {
            labels: ["translucency_map.multiply", "translucency_map.sum", "translucency_map.levels"],
            format,
            fragment: &shaders::MULTIPLY_FRAG,
            blend: Blend::Multiply,
            empty: [1.0; 4],
            binned,
            levels: &shaders::LEVELS,
            level_count: settings.levels,
            level_words: 1,
        };
        Self::open(
            context,
            world,
            &ENTRY,
            (settings, common),
            folder::TRANSLUCENCY_MAP,
            |maps, way, skip, constants| Texels::new(context, world, maps, way, skip, &kernels, constants),
        )
    }
}
