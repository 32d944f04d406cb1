//! Splats, which are anisotropic Gaussians of extinction, and how a splat is packed into the 32 bytes of a caster.
//!
//! Extinction at x is σ₀ exp(−½ (x − μ)ᵀ Σ⁻¹ (x − μ)). Along a ray through x in the unit direction d the optical depth is σ₀ √(2π) s
//! exp(−ρ²/2), where s = 1/√(dᵀ Σ⁻¹ d) is the deviation along the ray and ρ the smallest Mahalanobis distance on it. A file's opacity α is
//! the fraction of light that a splat removes from a ray through its centre. It is a single number, while s depends on the ray. α is taken as
//! the opacity along the shortest axis, since splats mostly lie flat on surfaces: σ₀ = −ln(1 − α) / (√(2π) s₂). Along slanting rays the
//! optical depth then grows by 1/cos, as in a slab, and it does not depend on how flat the splat is.

use crate::scene::{Caster, MAX_OPTICAL_DEPTH};
use glam::{DMat3, DQuat, DVec3};

/// Number of deviations at which a splat is cut off; its optical depth there is at most exp(−4.5) = 1.1 % of the maximum.
/// Twin: SPLAT_REACH.
pub(crate) const REACH: f64 = 3.0;

/// The largest ratio of the longest axis to any other, in octaves. Flatter splats are stored with this ratio. Twin: SPLAT_OCTAVES.
pub(super) const OCTAVES: f64 = 12.0;

/// The exponent bits of 2^100 in a caster's axis mark a splat; no strand is that long. Twin: SPLAT_MARK.
const MARK: u32 = 0x7180_0000;

/// Mask of a float's exponent bits.
pub(super) const EXPONENT: u32 = 0x7F80_0000;

/// A splat: an anisotropic Gaussian of extinction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Centre μ, in world units.
    pub position: [f32; 3],
    /// Standard deviations along the splat's own axes, in world units, > 0.
    pub deviations: [f32; 3],
    /// Rotation of the axes: a quaternion x, y, z, w of length 1.
    pub rotation: [f32; 4],
    /// The fraction of light that the splat removes from a ray through its centre along its shortest axis, in [0, 1]; the optical depth is
    /// −ln(1 − opacity), at most [`MAX_OPTICAL_DEPTH`].
    pub opacity: f32,
    /// Albedo, red, green, blue, in [0, 1].
    pub color: [f32; 3],
}

/// The shape of a splat unpacked from a caster. Packing rounds it by at most 5e-5 rad and 0.11 % of a deviation.
#[cfg(feature = "program")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Unit vectors, from the longest axis to the shortest.
    pub axes: [DVec3; 3],
    /// Standard deviations in world units, descending.
    pub deviations: [f64; 3],
}

impl From<&Splat> for Caster {
    fn from(splat: &Splat) -> Self {
        let [x, y, z, w] = splat.rotation.map(f64::from);
        let turn = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
        let mut axes = [0, 1, 2].map(|i| (f64::from(splat.deviations[i]), turn.col(i)));
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        let octaves = |i: usize| ((axes[0].0 / axes[i].0).log2() / OCTAVES * 4095.0).round().clamp(0.0, 4095.0) as u32;
        let octaves = [octaves(1), octaves(2)];
        let axis = packed(MARK, axes[2].1, axes[0].1, octaves);
        let radius = (REACH * axes[0].0) as f32;
        // ln_1p, because computing 1 − opacity would round a thin splat's opacity away.
        let depth = (-(-f64::from(splat.opacity)).ln_1p()).min(MAX_OPTICAL_DEPTH.into());
        let density = depth / ((2.0 * std::f64::consts::PI).sqrt() * deviation(radius, octaves[1]));
        Self { position: splat.position, radius, axis, density: density as f32 }
    }
}

/// Returns the deviation along an axis that is shorter than the longest by `octaves`, in units of [`OCTAVES`] / 4095; `radius` is the
/// caster's.
fn deviation(radius: f32, octaves: u32) -> f64 {
    f64::from(radius) / REACH * (-OCTAVES / 4095.0 * f64::from(octaves)).exp2()
}

/// Encodes a direction as two numbers below 65536; the opposite direction gives the same numbers. The direction is projected onto the upper
/// half of an octahedron. The numbers are its coordinates there, in axes turned by 45°.
fn half_octahedron(direction: DVec3) -> [u32; 2] {
    let d = if direction.z < 0.0 { -direction } else { direction };
    let sum = d.x.abs() + d.y.abs() + d.z;
    let (x, y) = (d.x / sum, d.y / sum);
    [x + y, x - y].map(|at| ((at * 0.5 + 0.5) * 65535.0).round().clamp(0.0, 65535.0) as u32)
}

/// Twin: splat_axis.
fn of_half_octahedron([u, v]: [u32; 2]) -> DVec3 {
    let [u, v] = [u, v].map(|at| f64::from(at) / 65535.0 * 2.0 - 1.0);
    let (x, y) = (0.5 * (u + v), 0.5 * (u - v));
    DVec3::new(x, y, 1.0 - x.abs() - y.abs()).normalize()
}

/// Returns two unit vectors perpendicular to `n` and to each other; the z of `n` must not be negative. Twin: splat_across. Source: Duff et
/// al. 2017, *Building an Orthonormal Basis, Revisited*.
fn across(n: DVec3) -> [DVec3; 2] {
    let a = -1.0 / (1.0 + n.z);
    let b = n.x * n.y * a;
    [DVec3::new(1.0 + n.x * n.x * a, b, -n.x), DVec3::new(b, 1.0 + n.y * n.y * a, -n.y)]
}

/// Packs the shortest axis, the longest axis and the ratios of the axes' lengths into the bits of three floats. The floats are neither NaN
/// nor denormal, so that drivers preserve their bits. `mark` identifies the kind of caster.
pub(super) fn packed(mark: u32, shortest: DVec3, longest: DVec3, octaves: [u32; 2]) -> [f32; 3] {
    let [u, v] = half_octahedron(shortest);
    let [first, second] = across(of_half_octahedron([u, v])).map(|axis| axis.dot(longest));
    // An axis and its opposite are equivalent.
    let (first, second) = if second < 0.0 { (-first, -second) } else { (first, second) };
    let turn = ((first / (first.abs() + second) * 0.5 + 0.5) * 65535.0).round().clamp(0.0, 65535.0) as u32;
    let bits = octaves[0] | octaves[1] << 12;
    let word = |low: u32, high: u32| f32::from_bits((high & 128) << 24 | mark | (high & 127) << 16 | low);
    [word(u, bits & 255), word(v, bits >> 8 & 255), word(turn, bits >> 16)]
}

#[cfg(feature = "program")]
impl Shape {
    /// Unpacks the shape of a caster that is a splat. Twin: splat_shape.
    pub fn of(caster: &Caster) -> Self {
        let bits = caster.axis.map(f32::to_bits);
        let [u, v, turn] = bits.map(|bits| bits & 0xFFFF);
        let high = bits.map(|bits| bits >> 16 & 127 | bits >> 24 & 128);
        let octaves = high[0] | high[1] << 8 | high[2] << 16;
        let shortest = of_half_octahedron([u, v]);
        let along = f64::from(turn) / 65535.0 * 2.0 - 1.0;
        let [first, second] = across(shortest);
        let longest = (along * first + (1.0 - along.abs()) * second).normalize();
        Self {
            axes: [longest, shortest.cross(longest), shortest],
            deviations: [0, octaves & 4095, octaves >> 12].map(|octaves| deviation(caster.radius, octaves)),
        }
    }

    /// Unpacks the shape of a caster that is a cell: `deviations` are its half-extents. Twin: cell_shape.
    pub fn of_cell(caster: &Caster) -> Self {
        let shape = Self::of(caster);
        let by = f64::from(caster.radius) / DVec3::from(shape.deviations).length();
        Self { deviations: shape.deviations.map(|d| d * by), ..shape }
    }

    /// Returns a vector's coordinates along the axes, in deviations.
    pub fn whitened(&self, v: DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|i| self.axes[i].dot(v) / self.deviations[i]))
    }
}

impl Caster {
    /// Returns whether the caster is a splat.
    pub fn is_splat(&self) -> bool {
        self.axis[0].to_bits() & EXPONENT == MARK
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn splat() -> impl Strategy<Value = Splat> {
        let deviation = || (-3.0f32..1.0).prop_map(|log| 10f32.powf(log));
        let rotation = prop::array::uniform4(-1.0f64..1.0)
            .prop_filter("has a length", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01);
        (prop::array::uniform3(-10.0f32..10.0), [deviation(), deviation(), deviation()], rotation, 0.0f32..=1.0)
            .prop_map(|(position, deviations, rotation, opacity)| {
                let rotation = DQuat::from_array(rotation).normalize().as_quat().to_array();
                Splat { position, deviations, rotation, opacity, color: [0.5; 3] }
            })
    }

    proptest! {
        /// Packing and unpacking gives the same ellipsoid up to rounding. Ellipsoids are compared rather than axes, since an axis may point
        /// either way, and axes of equal length may point anywhere in their plane.
        #[test]
        fn packing_rounds_little(splat in splat()) {
            let caster = Caster::from(&splat);
            prop_assert!(caster.is_splat() && !caster.is_strand() && caster.end() == caster.start());
            let shape = Shape::of(&caster);
            let turn = DMat3::from_quat(DQuat::from_array(splat.rotation.map(f64::from)));
            let given = |v: DVec3| {
                DVec3::from_array([0, 1, 2].map(|i| turn.col(i).dot(v) * f64::from(splat.deviations[i]))).length()
            };
            let found = |v: DVec3| {
                DVec3::from_array([0, 1, 2].map(|i| shape.axes[i].dot(v) * shape.deviations[i])).length()
            };
            let longest = shape.deviations[0];
            for i in 0..40 {
                // Compares half the ellipsoid's width along v.
                let v = DVec3::new((f64::from(i) * 1.7).sin(), (f64::from(i) * 2.9).cos(), (f64::from(i) * 0.7).sin()).normalize();
                let (given, found) = (given(v), found(v));
                prop_assert!((given - found).abs() <= 1.2e-3 * given + 1e-4 * longest, "{given} {found}");
            }
            for axis in 0..3 {
                prop_assert!((shape.axes[axis].length() - 1.0).abs() < 1e-12);
                prop_assert!(shape.axes[axis].dot(shape.axes[(axis + 1) % 3]).abs() < 1e-12);
            }
        }

        /// A ray through the centre along the shortest axis loses the splat's opacity, according to a numerical integral.
        #[test]
        fn opacity_is_taken_along_the_shortest_axis(splat in splat()) {
            let caster = Caster::from(&splat);
            let shape = Shape::of(&caster);
            let step = 0.01 * shape.deviations[2];
            let extinction = |t: f64| {
                let square = shape.whitened(t * shape.axes[2]).length_squared();
                f64::from(caster.density) * (-0.5 * square).exp()
            };
            let depth: f64 = (-800..=800).map(|i| extinction(f64::from(i) * step) * step).sum();
            let expected = -(1.0 - f64::from(splat.opacity)).ln();
            prop_assert!((depth - expected.min(80.0)).abs() < 1e-5 * expected.max(1e-3), "{depth}, not {expected}");
        }
    }

    /// A splat that is too flat to store is stored with the largest ratio of axes, and with a finite density.
    #[test]
    fn the_flattest() {
        let flat = Splat {
            position: [0.0; 3],
            deviations: [1.0, 1e-9, 1.0],
            rotation: [0.0, 0.0, 0.0, 1.0],
            opacity: 0.5,
            color: [1.0; 3],
        };
        let shape = Shape::of(&Caster::from(&flat));
        assert_eq!(shape.deviations, [1.0, 1.0, 1.0 / 4096.0]);
        assert!(shape.axes[2].y.abs() > 1.0 - 1e-9, "{:?}", shape.axes);
        let opaque = Caster::from(&Splat { opacity: 1.0, ..flat });
        assert!(opaque.density.is_finite() && opaque.density > 80.0);
    }
}
