//! What a technique promises about its results in any scene. `gobo stress` checks the promises.
//!
//! One promise is not listed, since it holds for all techniques: results are finite and in [0, 1].

/// Error bound for the rounding of a few thousand float additions: one fortieth of an 8-bit step.
pub const ROUNDING: f64 = 1e-4;

/// Error bound for 8-bit values that are quantized once or twice.
pub const EIGHT_BITS: f64 = 1e-2;

/// Maximum rise of transmittance due to hardware filtering, which rounds the position within a texel to 8 bits along each axis, up or down.
pub const FILTERED: f64 = 2.0 / 256.0;

/// A bound for each measured quantity. `None`: the quantity depends on the method, and no bound is promised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Promises {
    /// Mean absolute error along the rays of a map's texels, compared with a bilinear look-up in exact curves.
    pub mean: Option<f64>,
    /// Maximum error of a result behind all smoke, compared with the product of all casters' transmittances.
    pub tail: Option<f64>,
    /// Maximum rise of a result along a texel's ray.
    pub rise: Option<f64>,
    /// Maximum difference between results for different orders of the casters.
    pub order: Option<f64>,
    /// Maximum root mean square of the change in results, beyond the change in the truth, when all casters move by a thousandth of the
    /// scene's size.
    pub step: Option<f64>,
    /// Maximum number of leaks and false shadows of opaque casters farther from a shadow's edge than the technique's resolution.
    pub wrong: Option<u64>,
    /// Whether the same world gives the same bytes.
    pub repeats: bool,
    /// Whether `skip=` changes no byte in a scene without opaque casters.
    pub skips_alike: bool,
    /// Maximum number of texels per side that the technique uses in place of one texel of its maps. If rounding moves a point off the ray
    /// of a map's texel, the resulting error may be larger by this factor.
    pub finer: f64,
}

impl Promises {
    /// No promises about the values of results.
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

    /// Promises of maps without depth. They give the same result in front of smoke as behind it, so nothing is promised about leaks or
    /// about changes when casters move.
    pub const OF_NO_DEPTH: Self = Self { rise: Some(ROUNDING), ..Self::NONE };

    /// Promises of techniques that test opaque casters along the ray to the light.
    pub const OF_OPAQUE: Self = Self { wrong: Some(0), order: Some(0.0), ..Self::NONE };

    /// Promises of techniques that sum the optical depth of all casters along the ray: exact except for rounding.
    pub const EXACT: Self = Self {
        mean: Some(1e-4),
        tail: Some(1e-3),
        rise: Some(ROUNDING),
        order: Some(ROUNDING),
        step: Some(ROUNDING),
        ..Self::OF_OPAQUE
    };
}
