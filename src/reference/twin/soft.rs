//! How strands run in the voxels of a grid, and ways through one that is linear between voxels' middles. Twin of
//! glsl/grid/directions.comp and directions.glsl, to the bit, and of soft.glsl.

use super::grid::Place;
use super::media::{DARK, Media, Motes, UNITS, inverse_root, length};
use crate::scene::{Caster, Light, LightKind};
use std::array::from_fn;
use std::f32::consts::PI;

/// Twin: DIRECTION_UNITS.
const DIRECTION_UNITS: f32 = 4_194_304.0;

/// A matrix a voxel: xx, yy, zz, xy, yz, zx.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directions {
    /// In the order of [`Media::voxels`], six a voxel.
    pub words: Vec<i32>,
}

impl Directions {
    /// Of the strands among casters in a grid that stands there. Twin: glsl/grid/directions.comp.
    pub fn deposit(casters: &[Caster], place: &Place, media: &Media) -> Self {
        let mut words = vec![0i32; 6 * place.size.pow(3) as usize];
        for caster in casters.iter().filter(|caster| caster.is_strand()) {
            let axis = caster.axis.map(|a| a * place.per_unit);
            let inverse = inverse_root(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
            let run = axis.map(|a| a * inverse);
            let products: [f32; 6] = from_fn(|i| run[i % 3] * run[if i < 3 { i } else { (i + 1) % 3 }]);
            let radius = caster.radius * place.per_unit;
            let motes = Motes::of_strand(place.voxels(caster.position), axis, radius, caster.density);
            motes.shares(place.size, |voxel, amount| {
                let exact = if amount < 1 << 24 { amount as f32 } else { (amount >> 8) as f32 * 256.0 };
                let units = exact * (DIRECTION_UNITS / UNITS);
                let at = 6 * media.index(voxel);
                for (word, product) in words[at..at + 6].iter_mut().zip(products) {
                    *word = word.wrapping_add((units * product) as i32);
                }
            });
        }
        Self { words }
    }
}

/// The way from a point to a light, voxels. Twin: grid_way in glsl/grid/way.glsl.
pub fn way(place: &Place, light: &Light, position: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let (from, size) = (place.voxels(position), place.size as f32);
    let to = match light.kind {
        LightKind::Directional { direction } => {
            let far = 2.0 * size + length(from.map(|v| v - 0.5 * size));
            return (from, direction.as_vec3().to_array().map(|d| -d * far));
        }
        LightKind::Spot { position, .. } | LightKind::Virtual { position, .. } | LightKind::Point { position } => {
            position.as_vec3().to_array()
        }
    };
    (from, from_fn(|i| (to[i] - position[i]) * place.per_unit))
}

/// What a look-up of the technique `density-grid` knows.
pub struct Soft<'a> {
    /// What voxels take on average.
    pub media: &'a Media,
    /// How their strands run, where that is known.
    pub directions: Option<&'a Directions>,
    /// Voxels a side.
    pub size: u32,
}

impl Soft<'_> {
    /// What a voxel takes of a way in a direction of unit length. Twin: media_of, directed.
    pub fn of(&self, voxel: [u32; 3], towards: [f32; 3]) -> f32 {
        let sum = self.media.of(voxel);
        let Some(directions) = self.directions.filter(|_| !self.media.is_full(voxel)) else { return sum };
        let at = 6 * self.media.index(voxel);
        let m: [f32; 6] = from_fn(|i| directions.words[at + i] as f32 * (1.0 / DIRECTION_UNITS));
        let strands = m[0] + m[1] + m[2];
        let along = (0..3).map(|i| m[i] * towards[i] * towards[i]).sum::<f32>()
            + 2.0 * (0..3).map(|i| m[3 + i] * towards[i] * towards[(i + 1) % 3]).sum::<f32>();
        let across = (strands * (strands - along)).max(0.0).sqrt();
        (sum - strands).max(0.0) + 4.0 / PI * across.min(strands)
    }

    /// Twin: media_exact with directions.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> f32 {
        let towards = way.map(|w| w / length(way).max(1e-30));
        self.media.march_by(from, way, |voxel| self.of(voxel, towards))
    }

    /// Linear between voxels' middles. Twin: media_soft.
    pub fn at(&self, place: [f32; 3], towards: [f32; 3]) -> f32 {
        let at = place.map(|p| (p - 0.5).clamp(0.0, (self.size - 1) as f32));
        let corner = at.map(|a| (a as u32).min(self.size - 2));
        let share: [f32; 3] = from_fn(|i| at[i] - corner[i] as f32);
        let corners = (0..8u32).map(|c| {
            let high: [u32; 3] = from_fn(|i| c >> i & 1);
            let weight: f32 = (0..3).map(|i| if high[i] == 1 { share[i] } else { 1.0 - share[i] }).product();
            weight * self.of(from_fn(|i| corner[i] + high[i]), towards)
        });
        corners.sum()
    }

    /// Twin: media_soft_steps.
    pub fn march_steps(&self, from: [f32; 3], way: [f32; 3], steps: u32) -> f32 {
        let Some([near, far]) = self.media.bits.clipped(from, way) else { return 0.0 };
        let towards = way.map(|w| w / length(way).max(1e-30));
        let each = (far - near) * length(way) / steps as f32;
        let sum = (0..steps).map(|i| {
            let at = near + (far - near) * (i as f32 + 0.5) / steps as f32;
            self.at(from_fn(|axis| from[axis] + way[axis] * at), towards) * each
        });
        sum.sum::<f32>().min(DARK)
    }

    /// What ratio tracking finds of a way on average, and the average of its square, where no voxel takes more than `most`: e to the power of
    /// minus ∫ σ, and of minus ∫ 2 σ − σ² / most, by steps so short that they are the integrals. Twin: media_ratio.
    pub fn ratio(&self, from: [f32; 3], way: [f32; 3], most: f32) -> [f64; 2] {
        let Some([near, far]) = self.media.bits.clipped(from, way) else { return [1.0; 2] };
        let towards = way.map(|w| w / length(way).max(1e-30));
        let steps = 4096;
        let each = f64::from((far - near) * length(way)) / f64::from(steps);
        let (mut once, mut twice) = (0.0, 0.0);
        for i in 0..steps {
            let at = near + (far - near) * (i as f32 + 0.5) / steps as f32;
            let taken = f64::from(self.at(from_fn(|axis| from[axis] + way[axis] * at), towards));
            once += taken * each;
            twice += (2.0 * taken - taken * taken / f64::from(most)) * each;
        }
        [(-once).exp(), (-twice).exp()]
    }
}
