//! Splats in the voxels of a grid. Twin of glsl/grid/bell.glsl; not to the bit, since devices unpack a shape with different rounding.

use super::gaussian::{REACH, ROOT_TWO_PI, shape, share};
use super::media::{UNITS, voxels};
use super::segment::MAX_OPTICAL_DEPTH;
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

/// How it fills voxels.
enum Fills {
    /// By its density at middles from one to another.
    Box([u32; 3], [u32; 3]),
    /// By so many parts along its axes.
    Parts([u32; 3]),
}

/// Twin: bell_taken.
fn taken(x: f32) -> f32 {
    (1.0 + x * (1.0 + 0.57 * x) / (1.0 + 0.32 * x)).ln()
}

/// Twin: bell_units.
fn units(extinction: f32) -> u32 {
    (extinction.min(MAX_OPTICAL_DEPTH) * UNITS + 0.5) as u32
}

impl Bell {
    /// Twin: bell_of. `caster` has its place and radius in voxels.
    pub(super) fn new(caster: &Caster, extinction: f32, size: u32) -> Self {
        let (axes, deviations) = shape(caster);
        let centre = Vec3::from(caster.position);
        let thick = deviations.z >= THICK;
        let wide = (deviations * deviations + 1.0 / 12.0).map(f32::sqrt);
        let depth = (extinction * ROOT_TWO_PI * deviations.z).min(MAX_OPTICAL_DEPTH);
        let spread = deviations.x * deviations.y / (wide.x * wide.y);
        let share = if depth > 0.0 { taken(depth) * spread / taken(depth * spread) } else { 0.0 };
        let amount = share * depth * (ROOT_TWO_PI * ROOT_TWO_PI * deviations.x * deviations.y);
        if !thick {
            let count = |d: f32| if d < POINT { 1 } else { (18.0 * d).ceil().max(4.0) as u32 };
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

    /// How much it puts into which voxels.
    pub(super) fn shares(&self, size: u32, mut deposit: impl FnMut([u32; 3], u32)) {
        match self.fills {
            Fills::Box(first, last) => voxels(first, last).for_each(|voxel| deposit(voxel, self.amount(voxel))),
            Fills::Parts(count) => voxels([0; 3], count.map(|n| n - 1)).for_each(|part| {
                let (place, amount) = self.part(count, part);
                deposit(place.map(|v| v.clamp(0.0, (size - 1) as f32) as u32), amount);
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
    fn part(&self, count: [u32; 3], part: [u32; 3]) -> ([f32; 3], u32) {
        let (mut place, mut amount) = (self.centre, self.amount);
        for i in (0..3).filter(|i| count[*i] > 1) {
            let step = 2.0 * REACH / count[i] as f32;
            let low = part[i] as f32 * step - REACH;
            amount *= AXIS * (share(low + step) - share(low));
            place += (low + 0.5 * step) * self.deviations[i] * self.axes[i];
        }
        (place.to_array(), units(amount))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Gaussian;
    use glam::{DQuat, DVec3, EulerRot};

    /// Deviations in voxels: discs, needles, points, and balls that are thick.
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

    /// Along the grid's axes, along a diagonal of it, and askew.
    fn turns() -> [DQuat; 3] {
        let diagonal = DQuat::from_rotation_arc(DVec3::Z, DVec3::new(1.0, 1.0, 0.0).normalize());
        [DQuat::IDENTITY, diagonal, DQuat::from_euler(EulerRot::XYZ, 0.4, -0.7, 1.1)]
    }

    /// Each of them, in a grid of voxels of side 1.
    fn casters(opacity: f32) -> impl Iterator<Item = Caster> {
        let one = move |deviations, turn: DQuat| {
            let rotation = turn.as_quat().to_array();
            Caster::from(&Gaussian { position: [32.3, 31.8, 32.1], deviations, rotation, opacity, color: [0.5; 3] })
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

    /// Extinction over all of space of splats so thin that no part of them is in another's shadow, however it stands to the voxels.
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

    /// What lies alone takes as much light of all rays along its shortest axis as the one that it stands for, small or large: the axis is
    /// one of the grid's, so that a column of voxels is a ray.
    #[test]
    fn a_lone_one_takes_its_light() {
        for opacity in [0.5, 0.9, 0.99] {
            for deviations in [[0.02, 0.02, 0.01], [0.4, 0.3, 0.05], [1.0, 0.8, 0.7], [3.0, 2.0, 0.1]] {
                let rotation = [0.0, 0.0, 0.0, 1.0];
                let flat = Gaussian { position: [32.5; 3], deviations, rotation, opacity, color: [0.5; 3] };
                let voxels = filled(&Caster::from(&flat));
                let column = |at: usize| (0..64).map(|z| voxels[z * 64 * 64 + at]).sum::<f64>();
                let found: f64 = (0..64 * 64).map(|at| -(-column(at)).exp_m1()).sum();
                let [x, y] = [deviations[0], deviations[1]].map(f64::from);
                let depth = -(1.0 - f64::from(opacity)).ln();
                // ∫ 2π x y ρ (1 − exp(−τ exp(−ρ²/2))) dρ, by many even steps.
                let of = |k: i32| (f64::from(k) + 0.5) * 1e-3;
                let ring = |r: f64| -r * (-depth * (-0.5 * r * r).exp()).exp_m1() * 1e-3;
                let expected = 2.0 * std::f64::consts::PI * x * y * (0..8000).map(|k| ring(of(k))).sum::<f64>();
                // About as large as a voxel: parts a third of one apart put 16 % more of it into the middle voxel than is there.
                let bound = if deviations[0] == 0.4 { 0.18 } else { 0.1 };
                assert!((found / expected - 1.0).abs() < bound, "{opacity} {deviations:?}: {found}, not {expected}");
            }
        }
    }

    /// Against the mean over each voxel of thick ones, by sums over 8³ points of it.
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

    /// Against the integral that it stands for, by many even steps.
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
