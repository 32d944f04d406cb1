//! What a technique promises about its answers in any scene. `gobo stress` checks it.
//!
//! That answers are finite and in [0, 1] is not listed: it holds for all techniques.

/// Rounding of a few thousand sums of floats: a fortieth of a step of eight bits.
pub const ROUNDING: f64 = 1e-4;

/// Eight bits, rounded once or twice.
pub const EIGHT_BITS: f64 = 1e-2;

/// How much light may rise because of a filter in hardware: the filter rounds the place within a texel to 8 bits along either axis, up or
/// down.
pub const FILTERED: f64 = 2.0 / 256.0;

/// A threshold for each figure. None: the figure depends on the method, and nothing is promised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promises {
    /// Mean absolute error on the rays of a map's texels, against a bilinear look-up there in exact curves.
    pub mean: Option<f64>,
    /// By how much an answer behind all smoke may be off the product of all casters' transmittances.
    pub tail: Option<f64>,
    /// By how much an answer may rise along a texel's ray.
    pub rise: Option<f64>,
    /// By how much answers may differ with the casters' order.
    pub order: Option<f64>,
    /// Root mean square of the change of answers when all casters move by a thousandth of the scene, beyond the change of the truth.
    pub step: Option<f64>,
    /// The number of leaks and false shadows of opaque casters that are farther from a shadow's edge than the technique's resolution.
    pub wrong: Option<u64>,
    /// The same world gives the same bytes.
    pub repeats: bool,
    /// Without opaque casters `skip=` changes no byte.
    pub skips_alike: bool,
    /// The technique may have this many texels per side in place of one texel of its maps. An answer beside the ray of a map's texel may be
    /// wrong by that factor more.
    pub finer: f64,
}

impl Promises {
    /// Nothing about the answers' values.
    pub const NONE: Self = Self {
        mean: None,
        tail: None,
        rise: None,
        order: None,
        step: None,
        wrong: None,
        repeats: true,
        skips_alike: true,
        finer: 1.0,
    };

    /// Promises of maps with depth.
    pub const OF_DEPTH: Self = Self { rise: Some(ROUNDING), wrong: Some(0), step: Some(0.02), ..Self::NONE };

    /// Promises of maps without depth. In front of smoke they give the same answer as behind it, so that nothing is promised about leaks,
    /// or about changes when casters move.
    pub const OF_NO_DEPTH: Self = Self { rise: Some(ROUNDING), ..Self::NONE };

    /// Promises of techniques that test opaque casters on the way to the light.
    pub const OF_OPAQUE: Self = Self { wrong: Some(0), order: Some(0.0), ..Self::NONE };

    /// Promises of techniques that sum the optical depth of all casters on the way: exact but for rounding.
    pub const EXACT: Self = Self {
        mean: Some(1e-4),
        tail: Some(1e-3),
        rise: Some(ROUNDING),
        order: Some(ROUNDING),
        step: Some(ROUNDING),
        ..Self::OF_OPAQUE
    };
}
