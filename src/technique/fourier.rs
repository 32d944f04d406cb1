//! Fourier opacity maps: the optical depth of a texel's ray as a series of sines and cosines. Source: Jansen and Bavoil 2010, Fourier
//! Opacity Mapping.
//!
//! Sums have no order: no list, no sort, and the same bytes whatever order casters come in. A series of few terms rings about a step;
//! answers stay in [0, 1], and are exact before and behind all smoke.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, smoke};
//! # on_a_device(|context| {
//! use gobo::consume::Query;
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
use super::settings::{FILTER, Keyed, OPAQUE, RADIUS, SIZE, SKIP, Setting, settings};
use super::sums::{RANGE, Range, STORAGE, Storage};
use super::texel_map::{BINNED, Common, PATH, RASTER, TexelMap};
use super::{Casts, Entry, Lifetime, Path, Promises, Runs};
use crate::Result;
use crate::gpu::{Constants, Context, Requirement};
use crate::maps::{Filter, FilterKind, OpaqueWay, SumKernels, Sums, TexelWay};
use crate::shaders::constant::{COEFFICIENTS, SUM_RANGE, SUM_STORAGE};
use crate::shaders::{folder, fourier as shaders};
use crate::world::World;

settings! {
    /// What there is to set.
    #[derive(Copy)]
    pub struct Settings {
        /// How it is built: casters drawn and blended, or each texel written once by a workgroup a tile; none: the second where the device
        /// can.
        path: Option<TexelWay> = PATH;
        /// Numbers of a texel's series: 7, 15 or 31.
        coefficients: u32 = Setting::one_of("15", &["7", "15", "31"], "numbers of a texel's series, one and two a harmonic");
        /// The depths that they are of.
        range: Range = RANGE;
        /// Texels a side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// What a sum is kept in.
        storage: Storage = STORAGE;
        /// How a look-up weighs the texels about a point.
        filter: FilterKind = FILTER;
        /// Texels that the box and the Gaussian reach, 1 to 8; the Gaussian's deviation is half of it.
        radius: u32 = RADIUS;
        /// What draws the meshes as a light sees them; none: compute passes on GPUs, the rasterizer elsewhere.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
    every {
        /// Casters and tiles that no look-up misses are left out.
        skip: bool = SKIP;
    }
}

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "fourier",
    about: "the optical depth of a ray as a Fourier series (Jansen and Bavoil 2010)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[Requirement::FragmentStores] }],
    promises: |_, path| promises(path),
    runs: Runs {
        compare: &["coefficients=7|15"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=binned|raster", "size=32,path=binned,range=scene,storage=r16f"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Fourier::new(context, world, &spec.settings())?)),
};

/// One sum has all, as its storage rounds it, or whole numbers do where thousands of casters are on a ray. Those have no order; what is
/// drawn rounds at each caster. A series rings: light may rise along a ray, as far as
/// its terms say.
fn promises(path: &str) -> Promises {
    let order = if path == BINNED { 0.0 } else { 1e-3 };
    Promises { tail: Some(1e-3), order: Some(order), rise: None, ..Promises::OF_DEPTH }
}

/// The technique, opened for one world.
pub type Fourier = TexelMap<Settings, Sums>;

impl Settings {
    /// Words of a texel.
    pub fn words(&self) -> u32 {
        self.range.constant() + self.storage.words(self.coefficients)
    }
}

impl Fourier {
    /// Opens it.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where a setting is not what it may be, or the filter does not fit into the faces of a point light;
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { path, coefficients, range, size, storage, filter: kind, radius, opaque, skip } = *settings;
        let constants = Constants::new()
            .set(COEFFICIENTS, coefficients)
            .set(SUM_RANGE, range.constant())
            .set(SUM_STORAGE, storage as u32);
        let common = Common { path, size, filter: Filter { kind, radius }, opaque, skip, constants };
        let kernels = SumKernels {
            labels: ["fourier.binned", "fourier.raster", "fourier.pack"],
            sums: coefficients,
            words: settings.words(),
            binned: &shaders::BINNED,
            raster: [
                &shaders::RASTER_FRAG_TARGETS_1,
                &shaders::RASTER_FRAG_TARGETS_2,
                &shaders::RASTER_FRAG_TARGETS_4,
                &shaders::RASTER_FRAG_TARGETS_8,
            ],
            pack: &shaders::PACK,
        };
        Self::open(context, world, &ENTRY, (settings, common), folder::FOURIER, |maps, way, skip, constants| {
            Sums::new(context, world, maps, way, skip, &kernels, constants)
        })
    }
}
