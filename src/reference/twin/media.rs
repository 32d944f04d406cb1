//! Smoke and hair in the voxels of a grid, and their optical depth along rays through it. Twin of glsl/grid/blob.glsl, deposit.comp,
//! media.glsl and march.glsl. Deposits are bit-exact: neither the twin nor the device fuses or reorders operations, and both divide only
//! integers.

use super::bell::Bell;
use super::cell;
use super::grid::{Bits, Place};
use super::segment::MAX_OPTICAL_DEPTH;
use super::sheet::points;
use crate::scene::Caster;
use glam::Vec3;
use std::array::from_fn;
use std::f32::consts::PI;

/// Units per optical depth of 1. Twin: MEDIA_UNITS in glsl/grid/media.glsl.
pub const UNITS: f32 = 16_777_216.0;

/// Twin: MEDIA_FULL.
const FULL: f32 = 256.0;

/// Twin: MEDIA_DARK in glsl/grid/march_media.glsl.
pub(super) const DARK: f32 = 80.0;

/// Twin: media_units.
pub(super) fn units(optical_depth: f32) -> u32 {
    (optical_depth.min(MAX_OPTICAL_DEPTH) * UNITS) as u32
}

/// Twin: light_taken.
pub fn light_taken(optical_depth: f32) -> f32 {
    let x = optical_depth.min(16.0) * (1.0 / 256.0);
    let taken = x * (1.0 - x * (0.5 - x * (0.166_666_67 - x * 0.041_666_668)));
    (0..8).fold(taken, |taken, _| taken * (2.0 - taken))
}

/// Twin: inverse_root.
pub(super) fn inverse_root(square: f32) -> f32 {
    if square < 1e-30 {
        return 0.0;
    }
    let first = f32::from_bits(0x5F37_59DF - (square.to_bits() >> 1));
    (0..4).fold(first, |inverse, _| inverse * (1.5 - 0.5 * square * inverse * inverse))
}

/// Twin: root.
pub fn root(square: f32) -> f32 {
    square * inverse_root(square)
}

/// Twin: Motes.
pub(super) struct Motes {
    first: [f32; 3],
    axis: [f32; 3],
    step: f32,
    count: u32,
    amount: u32,
}

impl Motes {
    /// Twin: sphere_motes.
    fn of_sphere(centre: [f32; 3], radius: f32, extinction: f32) -> Self {
        let silhouette = PI * radius * radius;
        let taken = light_taken(extinction * (1.333_333_4 * radius));
        Self { first: centre, axis: [0.0; 3], step: 1.0, count: 1, amount: units(silhouette * taken) }
    }

    /// Twin: strand_motes.
    pub(super) fn of_strand(start: [f32; 3], axis: [f32; 3], radius: f32, optical_depth: f32) -> Self {
        let widest = axis[0].abs().max(axis[1].abs()).max(axis[2].abs());
        let (mut step, mut count) = (1.0f32, 1u32);
        while (count as f32) < 2.0 * widest && count < 4096 {
            (step, count) = (0.5 * step, 2 * count);
        }
        let silhouette = 0.5 * PI * radius * root(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        let amount = silhouette * light_taken(optical_depth) * step;
        let first = from_fn(|i| start[i] + axis[i] * (0.5 * step));
        Self { first, axis, step, count, amount: units(amount) }
    }

    /// Calls `deposit` with each voxel that a mote adds to, and the amount.
    pub(super) fn shares(&self, size: u32, mut deposit: impl FnMut([u32; 3], u32)) {
        (0..self.count).for_each(|i| mote(self.place(i), self.amount, size, &mut deposit));
    }

    /// Twin: mote_place.
    fn place(&self, i: u32) -> [f32; 3] {
        let along = self.step * i as f32;
        from_fn(|axis| self.first[axis] + self.axis[axis] * along)
    }
}

/// Twin: part_of.
fn part_of(amount: u32, share: u32) -> u32 {
    (amount >> 8) * share + (((amount & 255) * share) >> 8)
}

/// Twin: deposit_mote in glsl/grid/mote.glsl.
pub(super) fn mote(place: [f32; 3], amount: u32, size: u32, mut deposit: impl FnMut([u32; 3], u32)) {
    let at = place.map(|v| (v - 0.5).clamp(0.0, (size - 1) as f32));
    let voxel = at.map(|v| v as u32);
    let share: [u32; 3] = from_fn(|i| ((at[i] - at[i].floor()) * 256.0) as u32);
    let high_z = part_of(amount, share[2]);
    for (z, amount) in [(0, amount - high_z), (1, high_z)] {
        let high_y = part_of(amount, share[1]);
        for (y, amount) in [(0, amount - high_y), (1, high_y)] {
            let high_x = part_of(amount, share[0]);
            deposit([voxel[0], voxel[1] + y, voxel[2] + z], amount - high_x);
            deposit([voxel[0] + 1, voxel[1] + y, voxel[2] + z], high_x);
        }
    }
}

/// Twin: Ball.
struct Ball {
    centre: [f32; 3],
    core: f32,
    sharp: f32,
    amount: u32,
    first: [u32; 3],
    last: [u32; 3],
}

impl Ball {
    /// Twin: ball_of.
    fn new(centre: [f32; 3], radius: f32, extinction: f32, size: u32) -> Self {
        let whole = |v: f32| v.floor().clamp(0.0, (size - 1) as f32) as u32;
        Self {
            centre,
            core: radius * radius - 1.0 / 48.0,
            sharp: (16_777_216 / (radius * 64.0) as u32) as f32 * (1.0 / 262_144.0),
            amount: units(extinction),
            first: centre.map(|c| whole(c - (radius + 0.25))),
            last: centre.map(|c| whole(c + (radius + 0.25))),
        }
    }

    /// Twin: ball_sample.
    fn sample(&self, squares: [f32; 3]) -> u32 {
        let inside = (self.core - (squares[0] + squares[1] + squares[2])) * self.sharp + 0.5;
        (inside.clamp(0.0, 1.0) * 256.0 + 0.5) as u32
    }

    /// Twin: ball_amount.
    fn amount(&self, voxel: [u32; 3]) -> u32 {
        let square = |i: usize, at: f32| (voxel[i] as f32 + at - self.centre[i]).powi(2);
        let squares: [[f32; 2]; 3] = from_fn(|i| [square(i, 0.25), square(i, 0.75)]);
        let inside: u32 = (0..8).map(|i| self.sample(from_fn(|axis| squares[axis][i >> axis & 1]))).sum();
        (self.amount >> 11) * inside + (((self.amount & 2047) * inside) >> 11)
    }
}

/// Not bit-exact. Twin: Slab in glsl/grid/cell.glsl.
struct Slab {
    centre: Vec3,
    axes: [Vec3; 3],
    halves: Vec3,
    extinction: f32,
    first: [u32; 3],
    last: [u32; 3],
}

impl Slab {
    /// `caster` has its position and radius in voxels. Twin: slab_of.
    fn new(caster: &Caster, extinction: f32, size: u32) -> Self {
        let (axes, halves) = cell::shape(caster);
        let centre = Vec3::from(caster.position);
        let reach: Vec3 = (0..3).map(|i| axes[i].abs() * (halves[i] + 0.5)).sum();
        let whole = |v: Vec3| v.to_array().map(|v| v.floor().clamp(0.0, (size - 1) as f32) as u32);
        let (first, last) = (whole(centre - reach - 0.5), whole(centre + reach));
        Self { centre, axes, halves, extinction, first, last }
    }

    /// Twin: slab_amount.
    fn amount(&self, voxel: [u32; 3]) -> u32 {
        let from = Vec3::from_array(voxel.map(|v| v as f32 + 0.5)) - self.centre;
        let share = |at: f32, half: f32| (at + half).clamp(-0.5, 0.5) - (at - half).clamp(-0.5, 0.5);
        let share: f32 = (0..3).map(|i| share(self.axes[i].dot(from), self.halves[i])).product();
        units(self.extinction * share)
    }
}

/// Returns all voxels in the box from `first` to `last`.
pub(super) fn voxels(first: [u32; 3], last: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [x, y, z] = [0, 1, 2].map(|i| first[i]..=last[i]);
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| [x, y, z]))
    })
}

/// Extinction in a grid's voxels.
#[derive(Clone, Debug, PartialEq)]
pub struct Media {
    /// Units of optical depth over the length of one voxel, brick by brick, modulo 2³².
    pub voxels: Vec<u32>,
    /// On level 0, voxels whose sum overflowed 32 bits; on higher levels, bricks and blocks that are not empty.
    pub bits: Bits,
}

impl Media {
    /// Deposits casters into the grid `place`. Twin: glsl/grid/deposit.comp.
    pub fn deposit(casters: &[Caster], place: &Place) -> Self {
        Self::deposit_all(casters, &[], place)
    }

    /// Like [`Media::deposit`], with the corners of all triangles, for sheets of constant alpha.
    pub fn deposit_all(casters: &[Caster], triangles: &[[[f32; 3]; 3]], place: &Place) -> Self {
        let size = place.size;
        let mut media = Self { voxels: vec![0; size.pow(3) as usize], bits: Bits::none(size) };
        for caster in casters {
            let (at, radius) = (place.voxels(caster.position), caster.radius * place.per_unit);
            let extinction = caster.density * place.voxel;
            if caster.is_splat() {
                let bell = Bell::new(&Caster { position: at, radius, ..*caster }, extinction, size);
                bell.shares(size, |voxel, amount| media.add(voxel, amount));
                continue;
            }
            if caster.is_cell() {
                let slab = Slab::new(&Caster { position: at, radius, ..*caster }, extinction, size);
                voxels(slab.first, slab.last).for_each(|voxel| media.add(voxel, slab.amount(voxel)));
                continue;
            }
            if caster.is_sheet() {
                let corners = triangles[caster.sheet_triangle() as usize];
                points(caster, corners, place, |at, amount| {
                    mote(at, amount, size, |voxel, part| media.add(voxel, part))
                });
                continue;
            }
            if !caster.is_strand() && radius >= 1.0 {
                let ball = Ball::new(at, radius, extinction, size);
                voxels(ball.first, ball.last).for_each(|voxel| media.add(voxel, ball.amount(voxel)));
                continue;
            }
            let motes = if caster.is_strand() {
                Motes::of_strand(at, caster.axis.map(|a| a * place.per_unit), radius, caster.density)
            } else {
                Motes::of_sphere(at, radius, extinction)
            };
            motes.shares(size, |voxel, amount| media.add(voxel, amount));
        }
        media
    }

    /// Twin: deposit in glsl/grid/deposit.comp.
    fn add(&mut self, voxel: [u32; 3], amount: u32) {
        if amount > 0 {
            let (word, bit) = self.bits.place(0, voxel);
            let sum = &mut self.voxels[64 * word + bit as usize];
            let (after, full) = sum.overflowing_add(amount);
            *sum = after;
            (0..3).filter(|level| *level > 0 || full).for_each(|level| self.bits.set(level, voxel));
        }
    }

    /// Returns the index of a voxel in [`Media::voxels`]. Twin: media_at.
    pub fn index(&self, voxel: [u32; 3]) -> usize {
        let (word, bit) = self.bits.place(0, voxel);
        64 * word + bit as usize
    }

    /// Returns whether a voxel's sum overflowed 32 bits.
    pub fn is_full(&self, voxel: [u32; 3]) -> bool {
        self.bits.has(0, voxel)
    }

    /// Returns the optical depth of a voxel over the length of one voxel. Twin: media_of.
    pub fn of(&self, voxel: [u32; 3]) -> f32 {
        let (word, bit) = self.bits.place(0, voxel);
        if self.bits.has(0, voxel) { FULL } else { self.voxels[64 * word + bit as usize] as f32 * (1.0 / UNITS) }
    }

    /// Returns the optical depth along the ray, visiting every voxel on it. Twin: media_exact.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> f32 {
        self.march_by(from, way, |voxel| self.of(voxel))
    }

    /// Like [`Media::march_exact`], but `of` returns each voxel's optical depth.
    pub(super) fn march_by(&self, from: [f32; 3], way: [f32; 3], of: impl Fn([u32; 3]) -> f32) -> f32 {
        let voxels = length(way);
        let mut sum = 0.0;
        self.bits.walk(from, way, |voxel, range| {
            sum += of(voxel) * ((range[1] - range[0]).max(0.0) * voxels);
            sum < DARK
        });
        sum.min(DARK)
    }

    /// Twin: media_steps.
    pub fn march_steps(&self, from: [f32; 3], way: [f32; 3], steps: u32, offset: f32) -> f32 {
        let Some([near, far]) = self.bits.clipped(from, way) else { return 0.0 };
        let each = (far - near) * length(way) / steps as f32;
        let sum =
            (0..steps).map(|i| self.of(self.bits.stepped(from, way, [near, far], (i as f32 + offset) / steps as f32)));
        sum.map(|optical_depth| optical_depth * each).sum::<f32>().min(DARK)
    }
}

pub(super) fn length(way: [f32; 3]) -> f32 {
    way.iter().map(|w| w * w).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series and iterations agree with the standard library over the range of values that casters have.
    #[test]
    fn arithmetic_without_functions() {
        for i in 0..4000 {
            let x = 10f32.powf(i as f32 / 250.0 - 12.0);
            let (taken, expected) = (f64::from(light_taken(x)), -(-f64::from(x)).exp_m1());
            assert!((taken - expected).abs() <= 2e-6 * expected, "{x}: {taken}, not {expected}");
            let (root, expected) = (f64::from(root(x)), f64::from(x).sqrt());
            assert!((root - expected).abs() <= 1e-6 * expected, "{x}: {root}, not {expected}");
        }
        assert_eq!((light_taken(0.0), root(0.0)), (0.0, 0.0));
    }
}
