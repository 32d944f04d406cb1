//! CPU twin of glsl/world/splat.glsl: optical depth of an anisotropic Gaussian along a ray, in f32.

use crate::scene::{Caster, View};
use glam::{Vec2, Vec3};

/// Twin: SPLAT_REACH.
pub(super) const REACH: f32 = 3.0;

/// Twin: SPLAT_CHORD.
pub const CHORD: f32 = 1.5;

/// Twin: SPLAT_OCTAVES.
pub(super) const OCTAVES: f32 = 12.0;

/// Twin: ROOT_TWO_PI.
pub(super) const ROOT_TWO_PI: f32 = 2.506_628_3;

/// Twin: SPLAT_WHOLE.
const WHOLE: f32 = 1.011_234_5;

/// Returns the vector from a strand's start to its end; 0 for all other casters. Twin: caster_axis.
pub(super) fn strand_axis(caster: &Caster) -> Vec3 {
    if caster.is_strand() { caster.axis.into() } else { Vec3::ZERO }
}

/// Returns a splat's axes as unit vectors, longest first and shortest last, and the deviations along them. Twin: splat_shape.
pub fn shape(caster: &Caster) -> ([Vec3; 3], Vec3) {
    let bits = caster.axis.map(f32::to_bits);
    let n = axis(bits[0] & 0xFFFF, bits[1] & 0xFFFF);
    let [first, second] = across(n);
    let along = (bits[2] & 0xFFFF) as f32 * (2.0 / 65535.0) - 1.0;
    let longest = (along * first + (1.0 - along.abs()) * second).normalize();
    let high = bits.map(|bits| bits >> 16 & 127 | bits >> 24 & 128);
    let both = high[0] | high[1] << 8 | high[2] << 16;
    let less = |octaves: u32| (octaves as f32 * (-OCTAVES / 4095.0)).exp2();
    let deviations = caster.radius * (1.0 / REACH) * Vec3::new(1.0, less(both & 4095), less(both >> 12));
    ([longest, n.cross(longest), n], deviations)
}

/// Returns two unit vectors perpendicular to `n` and to each other; the z of `n` is not negative. Twin: splat_across.
fn across(n: Vec3) -> [Vec3; 2] {
    let a = -1.0 / (1.0 + n.z);
    let b = n.x * n.y * a;
    [Vec3::new(1.0 + n.x * n.x * a, b, -n.x), Vec3::new(b, 1.0 + n.y * n.y * a, -n.y)]
}

/// Twin: splat_axis.
fn axis(u: u32, v: u32) -> Vec3 {
    let at = Vec2::new(u as f32, v as f32) * (2.0 / 65535.0) - 1.0;
    let place = 0.5 * Vec2::new(at.x + at.y, at.x - at.y);
    Vec3::new(place.x, place.y, 1.0 - place.x.abs() - place.y.abs()).normalize()
}

/// Packs the shortest and the longest axis into three 16-bit numbers: two for the shortest axis, one for the angle of the longest around
/// it. Twin: splat_packed.
pub(super) fn axes_packed(shortest: Vec3, longest: Vec3) -> [u32; 3] {
    let shortest = if shortest.z < 0.0 { -shortest } else { shortest };
    let place = Vec2::new(shortest.x, shortest.y) / (shortest.x.abs() + shortest.y.abs() + shortest.z);
    let word = |share: f32| (share.clamp(0.0, 1.0) * 65535.0 + 0.5) as u32;
    let both = Vec2::new(place.x + place.y, place.x - place.y) * 0.5 + 0.5;
    let [u, v] = [word(both.x), word(both.y)];
    let [first, second] = across(axis(u, v)).map(|axis| axis.dot(longest));
    let (first, second) = if second < 0.0 { (-first, -second) } else { (first, second) };
    [u, v, word(first / (first.abs() + second) * 0.5 + 0.5)]
}

/// Returns a caster whose packed axes are rotated into a view's axes, in the same position. Twin: splat_turned.
pub fn turned(view: &View, caster: &Caster) -> Caster {
    let ([longest, _, shortest], _) = shape(caster);
    let view_axes = [view.right, view.up, view.forward].map(Vec3::from);
    let to_view = |v: Vec3| Vec3::from_array(view_axes.map(|axis| axis.dot(v)));
    let low = axes_packed(to_view(shortest), to_view(longest));
    let axis = std::array::from_fn(|i| f32::from_bits(caster.axis[i].to_bits() & 0xFFFF_0000 | low[i]));
    Caster { axis, ..*caster }
}

/// A Gaussian along a ray. Twin: SplatRay.
#[derive(Clone, Copy, Debug)]
pub struct AlongRay {
    /// z of the point on the ray that is nearest to the centre, measured in deviations.
    pub middle: f32,
    /// Deviation along the ray, in multiples of the ray's direction.
    pub deviation: f32,
    /// Squared distance of that point from the centre, in squared deviations.
    pub square: f32,
}

impl AlongRay {
    /// Twin: splat_ray.
    pub fn of((origin, direction): (Vec3, Vec3), caster: &Caster) -> Self {
        let (axes, deviations) = shape(caster);
        let offset = Vec3::from(caster.position) - origin;
        let nearest = offset.dot(direction) / direction.dot(direction);
        let across = offset - nearest * direction;
        let whitened = |w: Vec3| Vec3::new(axes[0].dot(w), axes[1].dot(w), axes[2].dot(w)) / deviations;
        let (v, q) = (whitened(direction), whitened(across));
        let (square, apart) = (v.dot(v), q.cross(v));
        Self { middle: nearest + q.dot(v) / square, deviation: 1.0 / square.sqrt(), square: apart.dot(apart) / square }
    }

    /// Twin: splat_length.
    pub fn length(&self) -> f32 {
        WHOLE * ROOT_TWO_PI * self.deviation * (-0.5 * self.square).exp()
    }

    /// Twin: splat_half.
    pub fn half(&self) -> f32 {
        (REACH * REACH - self.square).max(0.0).sqrt() * self.deviation
    }
}

/// Returns the share of a Gaussian of deviation 1 below x. Twin: splat_share.
pub fn share(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let series = 0.710_706_9 + t * (-0.726_576 + t * 0.530_702_7);
    let tail = (-0.5 * x * x).exp() * t * (0.127_414_8 + t * (-0.142_248_37 + t * series));
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// Returns the optical depth of a Gaussian between a ray's origin and `end`, in multiples of the ray's direction. Twin: splat_cast_depth.
pub fn cast_depth(ray: (Vec3, Vec3), caster: &Caster, end: f32) -> f32 {
    let along = AlongRay::of(ray, caster);
    let half = along.half();
    let (low, high) = (along.middle - half, along.middle + half);
    if half.is_nan() || half <= 0.0 || low.max(0.0) > high.min(end) {
        return 0.0;
    }
    let before = if low >= 0.0 { 0.0 } else { share(-along.middle / along.deviation) };
    let upto = if high <= end { 1.0 } else { share((end - along.middle) / along.deviation) };
    (caster.density * along.length() * ray.1.length() * (upto - before).max(0.0)).min(super::segment::MAX_OPTICAL_DEPTH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::truth::splat;
    use crate::scene::{Ray, Splat};
    use glam::DVec3;
    use proptest::prelude::*;

    /// Compares with the truth's `share`. The tolerance is the error bound stated by Abramowitz and Stegun, plus eight times the rounding
    /// error of 0.5.
    #[test]
    fn shares_are_as_stated() {
        for i in -1200..=1200 {
            let x = i as f32 / 100.0;
            assert!((f64::from(share(x)) - splat::share(x.into())).abs() < 7.5e-8 + 2.4e-7, "{x}");
        }
    }

    proptest! {
        /// f32 agrees with f64 for rays that start within a few hundred deviations. Rays near the edge of the reach are left out, since the
        /// cut-off there is a step.
        #[test]
        fn depths_are_the_truth(
            origin in prop::array::uniform3(-5.0f32..5.0),
            towards in prop::array::uniform3(-1.0f32..1.0),
            logs in prop::array::uniform3(-1.5f32..0.5),
            turn in prop::array::uniform4(-1.0f32..1.0),
            opacity in 0.01f32..0.99,
            end in 0.0f32..3.0,
        ) {
            prop_assume!(turn.iter().map(|x| x * x).sum::<f32>() > 0.01);
            let length = turn.iter().map(|x| x * x).sum::<f32>().sqrt();
            let position = [0.1, -0.2, 0.3];
            let splat = Splat {
                position,
                deviations: logs.map(|log| 10f32.powf(log)),
                rotation: turn.map(|x| x / length),
                opacity,
                color: [1.0; 3],
            };
            let caster = Caster::from(&splat);
            let (origin, towards) = (Vec3::from(origin), Vec3::from(position) + 0.3 * Vec3::from(towards));
            let ray = (origin, towards - origin);
            prop_assume!(ray.1.length() > 0.01);
            let as_f64 = Ray { origin: origin.as_dvec3(), direction: ray.1.as_dvec3() };
            let along = splat::along(&as_f64, &caster);
            let whole = along.optical_depth(&as_f64, &caster, f64::NEG_INFINITY, f64::INFINITY);
            let found = AlongRay::of(ray, &caster);
            prop_assert!((f64::from(found.square) - along.square).abs() < 2e-3 * (1.0 + along.square));
            prop_assert!((f64::from(found.deviation) / along.deviation - 1.0).abs() < 1e-4);
            let segment = f64::from(caster.density * found.length() * ray.1.length()) / (1.0 - (-4.5f64).exp()).recip();
            prop_assert!((segment - whole).abs() < 3e-3 * whole + 1e-6, "{segment} {whole}");
            prop_assume!((along.square - 9.0).abs() > 0.05);
            let truth = along.optical_depth(&as_f64, &caster, 0.0, end.into());
            // Outside the reach, up to exp(−4.5) of the Gaussian is cut off, and the inside is scaled up to compensate.
            let greatest = f64::from(caster.density) * along.deviation * as_f64.direction.length() * 2.5067;
            let most = 0.0112 * greatest + 0.0145 * truth + 1e-6;
            let found = f64::from(cast_depth(ray, &caster, end));
            prop_assert!((found - truth.min(80.0)).abs() <= most, "{found} {truth} {greatest}");
        }
    }

    /// The optical depth of the uniform segment that replaces a Gaussian has an error of at most 6.7 % of the total optical depth τ at any
    /// point, and of 0.12 deviations times τ if integrated along the ray. The error of transmittance is therefore at most 1 − exp(−0.067
    /// τ), reached at the start of the segment, where the truth has already absorbed 6.7 %.
    #[test]
    fn the_even_segment_is_off_by_as_much_as_is_said() {
        let places = (-8000..=8000).map(|i| f64::from(i) / 1000.0);
        let chord = f64::from(CHORD);
        let even = |x: f64| ((x + chord) / (2.0 * chord)).clamp(0.0, 1.0);
        let apart = places.clone().map(|x| (splat::share(x) - even(x)).abs());
        let (most, whole) = (apart.clone().fold(0.0, f64::max), apart.sum::<f64>() * 1e-3);
        assert!((most - 0.0668).abs() < 1e-4 && (whole - 0.12).abs() < 5e-3, "{most} {whole}");
        for depth in [0.1, 1.0, 4.6, 10.0, 80.0] {
            let off = |x: f64| ((-depth * splat::share(x)).exp() - (-depth * even(x)).exp()).abs();
            let (found, bound) = (places.clone().map(off).fold(0.0, f64::max), 1.0 - (-depth * most).exp());
            assert!(found <= bound + 1e-9 && found > 0.9 * bound, "{depth}: {found} of {bound}");
        }
    }

    /// A ray that ends farther away never has a smaller optical depth.
    #[test]
    fn depth_never_falls() {
        let splat = Splat {
            position: [0.0; 3],
            deviations: [0.5, 0.2, 0.1],
            rotation: [0.5, 0.5, 0.5, 0.5],
            opacity: 0.9,
            color: [1.0; 3],
        };
        let caster = Caster::from(&splat);
        // The rotation makes the Gaussian 0.1 wide along x; the ray drifts by 0.08 in x.
        for aside in [0.0, 0.1, 0.2] {
            let ray = (Vec3::new(aside, 0.1 * aside, -4.0), DVec3::new(0.02, 0.05, 1.0).as_vec3());
            let depths: Vec<f32> = (0..800).map(|i| cast_depth(ray, &caster, i as f32 / 100.0)).collect();
            assert!(depths.windows(2).all(|pair| pair[1] >= pair[0]), "{aside}");
            assert!(depths[0] == 0.0 && depths[799] > 0.0, "{aside}");
        }
    }
}
