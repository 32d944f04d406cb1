//! Translucency maps: what all casters on a texel's ray leave of the light, and nothing of where they stand. Sources: Crytek
//! 2011; Bavoil and Jansen 2013, External Shadows.
//!
//! One number a texel: what falls behind all the smoke, and nothing of where in it.
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
//! let mut translucency = open(context, &world, &parse("translucency-map:size=64")?[0])?;
//! translucency.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&translucency.technique.answer())?[..] else { panic!("two answers") };
//! assert!((below - (-2f32).exp()).abs() < 0.02);
//! # let _ = above;
//! # Ok(()) });
//! ```

use super::keys::{FILTER, OPAQUE, RADIUS, SIZE, Values, Word, words};
use super::promises::EIGHT_BITS;
use super::texel_map::{BINNED, PATH, RASTER, TexelMap};
use super::{Casts, Entry, Key, Lifetime, Path, Promises, Runs, Spec};
use crate::Result;
use crate::gpu::{Blend, Context, Format, Requirement};
use crate::maps::TexelKernels;
use crate::shaders::{folder, translucency_map as shaders};
use crate::world::World;

words! {
    /// What a texel is kept in.
    enum Storage {
        /// 8 bits.
        R8 = "r8",
        /// A half float.
        R16f = "r16f",
    }
}

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "translucency-map",
    about: "one product of transmittances a texel, no self-shadow (Crytek 2011)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: &[
        PATH,
        SIZE,
        Key {
            name: "storage",
            values: Values::OneOf(Storage::WORDS),
            default: "r8",
            about: "8 bits a texel (as published), or a half float",
        },
        FILTER,
        RADIUS,
        OPAQUE,
    ],
    paths: &[Path { name: BINNED, requires: &[Requirement::ExtendedFormats] }, Path { name: RASTER, requires: &[] }],
    promises,
    runs: Runs {
        compare: &["path=raster|binned"],
        on_cpu: &[("size", "64")],
        stress_smoke: &["size=32,path=raster|binned"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(translucency_map(context, world, spec)?)),
};

/// Blending rounds at each sphere; sums are rounded once.
fn promises(_: &Spec, path: &str) -> Promises {
    Promises { tail: Some(EIGHT_BITS).filter(|_| path == BINNED), ..Promises::OF_NO_DEPTH }
}

/// Opens the path that `spec` names.
///
/// # Errors
/// As [`TexelMap::new`].
pub fn translucency_map(context: &Context, world: &World, spec: &Spec) -> Result<TexelMap> {
    let (format, binned) = match spec.word("storage") {
        Some(Storage::R16f) => (Format::R16_SFLOAT, &shaders::SUM_BITS_16),
        _ => (Format::R8_UNORM, &shaders::SUM_BITS_8),
    };
    let kernels = TexelKernels {
        labels: ["translucency_map.multiply", "translucency_map.sum"],
        format,
        fragment: &shaders::MULTIPLY_FRAG,
        blend: Blend::Multiply,
        empty: [1.0; 4],
        binned,
    };
    TexelMap::new(context, world, spec, folder::TRANSLUCENCY_MAP, &kernels)
}
