//! Splats in the voxels of a grid. Twin of glsl/grid/bell.glsl, but not bit-exact, since devices unpack a shape with different rounding.

use super::media::{UNITS, voxels};
use super::segment::MAX_OPTICAL_DEPTH;
use super::splat::{REACH, ROOT_TWO_PI, shape, share};
use crate::scene::Caster;
use glam::Vec3;

/// Twin: BELL_THICK.
const THICK: f32 = 0.6;

/// Twin: BELL_POINT.
const POINT: f32 = 0.125;

/// Twin: BELL_WITHIN.
const WITHIN: f32 = 1.030_174_7;

/// Twin: BELL_AXIS.
const AXIS: f32 = 1.002_707_1;

/// Twin: Bell.
pub(super) struct Bell {
    centre: Vec3,
    axes: [Vec3; 3],
    deviations: Vec3,
    amount: f32,
    fills: Fills,
}

/// How a splat fills voxels.
enum Fills {
    /// By its density at the voxel centres, in the box between these two corner voxels.
    Box([u32; 3], [u32; 3]),
    /// By splitting it into this many parts along each of the splat's axes.
    Parts([u32; 3]),
}

/// Twin: BELL_ALL.
const ALL: f32 = 1.732_050_8;

/// Twin: bell_taken.
fn taken(x: f32) -> f32 {
    let q = x * (1.0 + 0.57 * x) / (1.0 + 0.32 * x);
    if q < 0.01 { q * (1.0 - q * (0.5 - q / 3.0)) } else { (1.0 + q).ln() }
}

/// Twin: bell_depth.
fn depth(taken: f32) -> f32 {
    let q = if taken < 0.01 { taken * (1.0 + taken * (0.5 + taken / 6.0)) } else { taken.exp() - 1.0 };
    let b = 1.0 - 0.32 * q;
    let root = (b * b + 2.28 * q).sqrt();
    if b > 0.0 { 2.0 * q / (root + b) } else { (root - b) / 1.14 }
}

/// Twin: bell_density.
fn density(x: f32) -> f32 {
    (-0.5 * x * x).exp() / ROOT_TWO_PI
}

/// Twin: bell_units.
fn units(extinction: f32) -> u32 {
    (extinction.min(MAX_OPTICAL_DEPTH) * UNITS + 0.5) as u32
}

impl Bell {
    /// `caster` has its position and radius in voxels. Twin: bell_of.
    pub(super) fn new(caster: &Caster, extinction: f32, size: u32) -> Self {
        let (axes, deviations) = shape(caster);
        let centre = Vec3::from(caster.position);
        let thick = deviations.z >= THICK;
        let wide = (deviations * deviations + 1.0 / 12.0).map(f32::sqrt);
        let in_middle = (extinction * ROOT_TWO_PI * deviations.z).min(MAX_OPTICAL_DEPTH);
        let spread = deviations.x * deviations.y / (wide.x * wide.y);
        let amount = depth(spread * taken(in_middle)) * ROOT_TWO_PI * ROOT_TWO_PI * wide.x * wide.y;
        if !thick {
            let count = |d: f32| if d < POINT { 1 } else { (12.0 * d).ceil().max(4.0) as u32 };
            let fills = Fills::Parts(deviations.to_array().map(count));
            return Self { centre, axes, deviations, amount, fills };
        }
        let square: Vec3 = (0..3).map(|i| (axes[i] * wide[i]) * (axes[i] * wide[i])).sum();
        let reach = REACH * square.map(f32::sqrt);
        let whole = |v: Vec3| v.to_array().map(|v| v.floor().clamp(0.0, (size - 1) as f32) as u32);
        let fills = Fills::Box(whole(centre - reach - 0.5), whole(centre + reach));
        let amount = amount * (WITHIN / (ROOT_TWO_PI * ROOT_TWO_PI * ROOT_TWO_PI * wide.x * wide.y * wide.z));
        Self { centre, axes, deviations: wide, amount, fills }
    }

    /// Passes to `deposit` each voxel that the splat fills, with the amount deposited there.
    pub(super) fn shares(&self, size: u32, mut deposit: impl FnMut([u32; 3], u32)) {
        match self.fills {
            Fills::Box(first, last) => voxels(first, last).for_each(|voxel| deposit(voxel, self.amount(voxel))),
            Fills::Parts(count) => voxels([0; 3], count.map(|n| n - 1)).for_each(|part| {
                let (place, half_sides, amount) = self.part(count, part);
                // Twin: bell_voxels, bell_in.
                let whole = |v: Vec3| v.to_array().map(|v| v.clamp(0.0, (size - 1) as f32) as u32);
                let (low, high) = (whole(place - half_sides), whole(place + half_sides));
                let share = |i: usize, voxel: u32| {
                    let in_low = (high[i] as f32 - (place[i] - half_sides[i])) / (2.0 * half_sides[i]).max(1e-9);
                    match voxel == low[i] {
                        _ if low[i] == high[i] => 1.0,
                        true => in_low.clamp(0.0, 1.0),
                        false => 1.0 - in_low.clamp(0.0, 1.0),
                    }
                };
                voxels(low, high).for_each(|voxel| {
                    let share: f32 = (0..3).map(|i| share(i, voxel[i])).product();
                    deposit(voxel, units(amount * share));
                });
            }),
        }
    }

    /// Twin: bell_amount.
    fn amount(&self, voxel: [u32; 3]) -> u32 {
        let from = Vec3::from_array(voxel.map(|v| v as f32 + 0.5)) - self.centre;
        let square: f32 = (0..3).map(|i| (self.axes[i].dot(from) / self.deviations[i]).powi(2)).sum();
        if square > REACH * REACH { 0 } else { units(self.amount * (-0.5 * square).exp()) }
    }

    /// Twin: bell_part.
    fn part(&self, count: [u32; 3], part: [u32; 3]) -> (Vec3, Vec3, f32) {
        let (mut place, mut square, mut amount) = (self.centre, Vec3::ZERO, self.amount);
        for i in 0..3 {
            let mut half_side = ALL * self.deviations[i];
            if count[i] > 1 {
                let step = 2.0 * REACH / count[i] as f32;
                let low = part[i] as f32 * step - REACH;
                let share = share(low + step) - share(low);
                let mean = (density(low) - density(low + step)) / share;
                amount *= AXIS * share;
                place += mean * self.deviations[i] * self.axes[i];
                half_side = 0.5 * step * self.deviations[i];
            }
            let along = half_side * self.axes[i];
            square += along * along;
        }
        (place, square.map(f32::sqrt), amount)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::truth::splat::share as below;
    use crate::scene::Splat;
    use glam::{DQuat, DVec3, EulerRot};

    /// Deviations in voxels, of discs, needles, points and thick balls.
    const SHAPES: [[f32; 3]; 8] = [
        [0.02, 0.02, 0.02],
        [0.3, 0.2, 0.05],
        [3.0, 2.0, 0.01],
        [4.0, 0.05, 0.02],
        [0.59, 0.59, 0.59],
        [0.6, 0.6, 0.6],
        [1.5, 1.0, 0.7],
        [3.0, 2.5, 2.0],
    ];

    /// Returns rotations along the grid's axes, along one of its diagonals, and askew.
    fn turns() -> [DQuat; 3] {
        let diagonal = DQuat::from_rotation_arc(DVec3::Z, DVec3::new(1.0, 1.0, 0.0).normalize());
        [DQuat::IDENTITY, diagonal, DQuat::from_euler(EulerRot::XYZ, 0.4, -0.7, 1.1)]
    }

    /// Returns each shape in each rotation, in a grid of voxels of side 1.
    fn casters(opacity: f32) -> impl Iterator<Item = Caster> {
        let one = move |deviations, turn: DQuat| {
            let rotation = turn.as_quat().to_array();
            Caster::from(&Splat { position: [32.3, 31.8, 32.1], deviations, rotation, opacity, color: [0.5; 3] })
        };
        SHAPES.into_iter().flat_map(move |shape| turns().map(|turn| one(shape, turn)))
    }

    fn filled(caster: &Caster) -> Vec<f64> {
        let mut all = vec![0.0; 64 * 64 * 64];
        Bell::new(caster, caster.density, 64).shares(64, |[x, y, z], amount| {
            all[(z as usize * 64 + y as usize) * 64 + x as usize] += f64::from(amount) / f64::from(UNITS);
        });
        all
    }

    /// The total extinction of splats too thin to shadow themselves is preserved, at any alignment with the voxels.
    #[test]
    fn mass_is_kept() {
        for caster in casters(1e-3) {
            let (_, deviations) = shape(&caster);
            let volume = (2.0 * std::f64::consts::PI).powf(1.5) * f64::from(deviations.x * deviations.y * deviations.z);
            let expected = f64::from(caster.density) * volume;
            let found: f64 = filled(&caster).into_iter().sum();
            assert!((found / expected - 1.0).abs() < 6e-3, "{deviations}: {found}, not {expected}");
        }
    }

    /// Returns the light absorbed along z by columns with these optical depths.
    fn light(columns: impl Iterator<Item = f64>) -> f64 {
        columns.map(|depth| -(-depth).exp_m1()).sum()
    }

    /// Summed over all rays along its shortest axis, a lone splat, small or large, absorbs as much light as the Gaussian that it
    /// represents; the axis is a grid axis, so that a column of voxels is a ray. Voxel faces cut the splat differently at each position, so
    /// this holds on average over positions. At each position the splat absorbs as much as the voxel means of a Gaussian of the same
    /// extinction, which are error functions.
    #[test]
    fn a_lone_one_takes_its_light() {
        let sizes =
            [[0.02, 0.02, 0.01], [0.12, 0.1, 0.02], [0.2, 0.2, 0.1], [0.3, 0.3, 0.2], [0.4, 0.3, 0.05], [0.59; 3]];
        for opacity in [0.5, 0.9, 0.99] {
            for deviations in sizes.into_iter().chain([[1.0, 0.8, 0.7], [3.0, 2.0, 0.1]]) {
                let [x, y] = [deviations[0], deviations[1]].map(f64::from);
                let depth = -(1.0 - f64::from(opacity)).ln();
                // ∫ 2π x y ρ (1 − exp(−τ exp(−ρ²/2))) dρ, in many equal steps.
                let of = |k: i32| (f64::from(k) + 0.5) * 1e-3;
                let ring = |r: f64| -r * (-depth * (-0.5 * r * r).exp()).exp_m1() * 1e-3;
                let expected = 2.0 * std::f64::consts::PI * x * y * (0..8000).map(|k| ring(of(k))).sum::<f64>();
                let (mut sum, mut off) = (0.0, 0.0f64);
                for place in 0..16 {
                    let at = [place % 4, place / 4].map(|i| 32.125 + 0.25 * i as f32);
                    let rotation = [0.0, 0.0, 0.0, 1.0];
                    let position = [at[0], at[1], 32.3];
                    let flat = Splat { position, deviations, rotation, opacity, color: [0.5; 3] };
                    let voxels = filled(&Caster::from(&flat));
                    let column = |at: usize| (0..64).map(|z| voxels[z * 64 * 64 + at]).sum::<f64>();
                    let found = light((0..64 * 64).map(column));
                    let whole: f64 = voxels.iter().sum();
                    let share = |axis: usize, voxel: usize| {
                        let to = |side: usize| (side as f64 - f64::from(at[axis])) / f64::from(deviations[axis]);
                        below(to(voxel + 1)) - below(to(voxel))
                    };
                    let means = (0..64 * 64).map(|at| whole * share(0, at % 64) * share(1, at / 64));
                    off = off.max((found / light(means) - 1.0).abs());
                    sum += found / expected / 16.0;
                }
                println!("{opacity} {deviations:?}: {sum} of it, off by {off} from error functions");
                // `taken` has an error of up to 3 %.
                assert!((sum - 1.0).abs() < 0.035, "{opacity} {deviations:?}: {sum} of the light");
                // The 3 % of a thick splat that lie beyond three deviations are moved inside, so that its centre is darker.
                let bound = if deviations[2] < THICK { 0.02 } else { 0.04 };
                assert!(off < bound, "{opacity} {deviations:?}: off by {off} from error functions");
            }
        }
    }

    /// `depth` recovers the argument of `taken` over ten orders of magnitude.
    #[test]
    fn depth_is_the_inverse_of_taken() {
        for i in 0..80 {
            let x = 80.0 * 0.75f32.powi(i);
            assert!((depth(taken(x)) / x - 1.0).abs() < 2e-5, "{x}: {}", depth(taken(x)));
        }
    }

    /// Compares the voxels of thick splats with the mean of the Gaussian over each voxel, sampled at 8³ points.
    #[test]
    fn thick_ones_are_the_mean_over_a_voxel() {
        for caster in casters(1e-3).filter(|caster| shape(caster).1.z >= THICK) {
            let (axes, deviations) = shape(&caster);
            let voxels = filled(&caster);
            let density = |at: Vec3| {
                let from = at - Vec3::from(caster.position);
                let square: f32 = (0..3).map(|i| (axes[i].dot(from) / deviations[i]).powi(2)).sum();
                f64::from(caster.density * (-0.5 * square).exp())
            };
            let points = (0..512).map(|i| Vec3::from_array([i % 8, i / 8 % 8, i / 64].map(|i| (i as f32 + 0.5) / 8.0)));
            let mean = |voxel: Vec3| points.clone().map(|at| density(voxel + at)).sum::<f64>() / 512.0;
            let (mut off, mut most) = (0.0f64, 0.0f64);
            for i in (0..voxels.len()).filter(|i| voxels[*i] > 0.0) {
                let expected = mean(Vec3::from_array([i % 64, i / 64 % 64, i / 4096].map(|at| at as f32)));
                (off, most) = (off.max((voxels[i] - expected).abs()), most.max(expected));
            }
            println!("{deviations}: off by {} of the greatest", off / most);
            assert!(off < 0.04 * most, "{deviations}: off by {off} of {most}");
        }
    }

    /// Compares `taken` with the integral that it approximates, summed in many equal steps.
    #[test]
    fn light_taken_is_the_integral() {
        for i in 0..40 {
            let x = 80.0 * 0.75f64.powi(i);
            let steps = 20_000;
            let of = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let integral: f64 = (0..steps).map(|k| -(-x * of(k)).exp_m1() / of(k) / f64::from(steps)).sum();
            let found = f64::from(taken(x as f32));
            assert!((found / integral - 1.0).abs() < 0.03, "{x}: {found}, not {integral}");
        }
    }
}
