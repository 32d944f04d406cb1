//! Beer shadow maps: where the medium on a texel's ray begins, its mean extinction and its greatest optical depth. Source:
//! Hillaire 2020 (Unreal Engine's clouds).
//!
//! Three numbers a texel: cheap, and right where the medium is one cloud.
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
//! let mut beer = open(context, &world, &parse("beer-shadow-map:size=64")?[0])?;
//! beer.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&beer.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

use super::keys::{FILTER, OPAQUE, RADIUS, SIZE};
use super::texel_map::{BINNED, PATH, RASTER, TexelMap};
use super::{Casts, Entry, Lifetime, Path, Promises, Runs, Spec};
use crate::Result;
use crate::gpu::{Blend, Context, Format};
use crate::maps::TexelKernels;
use crate::shaders::{beer_shadow_map as shaders, folder};
use crate::world::World;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "beer-shadow-map",
    about: "front depth, mean extinction and greatest optical depth a texel (Hillaire 2020, Unreal Engine's clouds)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: &[PATH, SIZE, FILTER, RADIUS, OPAQUE],
    paths: &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[] }],
    promises: |_, _| Promises::OF_DEPTH,
    runs: Runs {
        compare: &["path=raster|binned"],
        on_cpu: &[("size", "64")],
        stress_smoke: &["size=32,path=raster|binned"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(beer_shadow_map(context, world, spec)?)),
};

/// Opens the path that `spec` names.
///
/// # Errors
/// As [`TexelMap::new`].
pub fn beer_shadow_map(context: &Context, world: &World, spec: &Spec) -> Result<TexelMap> {
    let kernels = TexelKernels {
        labels: ["beer_shadow_map.blend", "beer_shadow_map.collect"],
        format: Format::R16G16B16A16_SFLOAT,
        fragment: &shaders::BLEND_FRAG,
        blend: Blend::MaxAndAdd,
        empty: [0.0; 4],
        binned: &shaders::COLLECT,
    };
    TexelMap::new(context, world, spec, folder::BEER_SHADOW_MAP, &kernels)
}
