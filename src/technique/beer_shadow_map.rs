//! Beer shadow maps: each texel stores the depth at which the medium begins along its ray, the mean extinction, and the maximum optical
//! depth. Source: Hillaire 2020 (Unreal Engine's clouds).
//!
//! Three numbers per texel: cheap, and accurate if the medium is a single cloud.
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
//! let mut beer = open(context, &world, &parse("beer-shadow-map:size=64", &[])?[0])?;
//! beer.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&beer.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::settings::{Keyed, Setting};
use super::texel_map::{BINNED, RASTER, TexelMap, texel_settings};
use super::{Casts, Entry, Lifetime, Path, PathPlan, Promises, Runs};
use crate::gpu::{Blend, Constants, Context, Format, Limit};
use crate::maps::{TexelKernels, TexelWay, Texels};
use crate::shaders::constant::WEIGHTED_FRONT;
use crate::shaders::{beer_shadow_map as shaders, folder};
use crate::world::World;
use crate::{Error, Result};

words! {
    /// Where a texel's medium begins.
    pub enum Front {
        /// Where the first caster begins.
        First = "first",
        /// At the mean depth of the casters, weighted by the light that each absorbs, as in three-geospatial's clouds. Requires binned
        /// tiles.
        Weighted = "weighted",
    }
}

texel_settings! {
    /// Where a texel's medium begins.
    front: Front = Setting::word(
        "first",
        "the medium begins at the first caster, or at the casters' mean depth (needs path=binned)",
    );
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "beer-shadow-map",
    about: "front depth, mean extinction and greatest optical depth per texel (Hillaire 2020, Unreal Engine's clouds)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![Limit::image_2d(spec.settings::<Settings>().size.into())],
        promises: Promises::OF_DEPTH,
    },
    runs: Runs {
        usual: &["path=binned"],
        usual_on_cpu: &["size=128,path=binned"],
        compare: &["path=raster|binned"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=raster|binned", "size=32,path=binned,front=weighted,levels=3"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(BeerShadowMap::new(context, world, &spec.settings())?)),
};

/// The technique, opened for one world.
pub type BeerShadowMap = TexelMap<Settings>;

impl BeerShadowMap {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device lacks what the path needs, [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { path, front, .. } = *settings;
        if front == Front::Weighted && path == Some(TexelWay::Raster) {
            // A caster's weight depends on where all of the texel's casters end, which is not known while they are blended.
            return Err(Error::Refused("path=binned, for front=weighted".into()));
        }
        let constants = Constants::new().set(WEIGHTED_FRONT, front == Front::Weighted);
        let common = settings.common(constants);
        let kernels = TexelKernels {
            labels: ["beer_shadow_map.blend", "beer_shadow_map.collect", "beer_shadow_map.levels"],
            format: Format::R16G16B16A16_SFLOAT,
            fragment: &shaders::BLEND_FRAG,
            blend: Blend::MaxAndAdd,
            empty: [0.0; 4],
            binned: &shaders::COLLECT,
            levels: &shaders::LEVELS,
            level_count: settings.levels,
            level_words: 3,
        };
        Self::open(context, world, &ENTRY, (settings, common), folder::BEER_SHADOW_MAP, |maps, way, skip, constants| {
            Texels::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
