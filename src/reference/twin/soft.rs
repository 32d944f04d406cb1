//! Directions of strands in the voxels of a grid, and marches through a grid that is interpolated linearly between voxel centres. Twin of
//! glsl/grid/directions.comp and directions.glsl (bit-exact), and of soft.glsl.

use super::grid::Place;
use super::media::{DARK, Media, Motes, UNITS, inverse_root, length, mote};
use super::sheet::points;
use crate::scene::{Caster, Light, LightKind};
use std::array::from_fn;
use std::f32::consts::PI;

/// Twin: DIRECTION_UNITS.
const DIRECTION_UNITS: f32 = 4_194_304.0;

/// A symmetric matrix per voxel, the sum of the outer products of the strands: xx, yy, zz, xy, yz, zx.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Directions {
    /// Six words per voxel, in the order of [`Media::voxels`].
    pub words: Vec<i32>,
}

impl Directions {
    /// Deposits the directions of the strands among `casters` into the grid `place`. Twin: glsl/grid/directions.comp.
    pub fn deposit(casters: &[Caster], place: &Place, media: &Media) -> Self {
        let mut words = vec![0i32; 6 * place.size.pow(3) as usize];
        for caster in casters.iter().filter(|caster| caster.is_strand()) {
            let axis = caster.axis.map(|a| a * place.per_unit);
            let inverse = inverse_root(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
            let run = axis.map(|a| a * inverse);
            let products: [f32; 6] = from_fn(|i| run[i % 3] * run[if i < 3 { i } else { (i + 1) % 3 }]);
            let radius = caster.radius * place.per_unit;
            let motes = Motes::of_strand(place.voxels(caster.position), axis, radius, caster.density);
            motes.shares(place.size, |voxel, amount| add(&mut words, media.index(voxel), amount, products));
        }
        Self { words }
    }

    /// Deposits the normals of sheets of constant alpha, given the corners of all triangles. Twin: glsl/grid/directions.comp with FACING.
    pub fn of_sheets(casters: &[Caster], triangles: &[[[f32; 3]; 3]], place: &Place, media: &Media) -> Self {
        let mut words = vec![0i32; 6 * place.size.pow(3) as usize];
        for caster in casters.iter().filter(|caster| caster.is_sheet()) {
            let corners = triangles[caster.sheet_triangle() as usize];
            let side = |i: usize| from_fn::<f32, 3, _>(|axis| (corners[i][axis] - corners[0][axis]) * place.per_unit);
            let (b, c) = (side(1), side(2));
            let normal: [f32; 3] = from_fn(|i| {
                let (next, last) = ((i + 1) % 3, (i + 2) % 3);
                b[next] * c[last] - b[last] * c[next]
            });
            let inverse = inverse_root(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
            let run = normal.map(|a| a * inverse);
            let products: [f32; 6] = from_fn(|i| run[i % 3] * run[if i < 3 { i } else { (i + 1) % 3 }]);
            points(caster, corners, place, |at, amount| {
                mote(at, amount, place.size, |voxel, amount| add(&mut words, media.index(voxel), amount, products));
            });
        }
        Self { words }
    }
}

/// Adds the product of an amount and a matrix to a voxel.
fn add(words: &mut [i32], index: usize, amount: u32, products: [f32; 6]) {
    let exact = if amount < 1 << 24 { amount as f32 } else { (amount >> 8) as f32 * 256.0 };
    let units = exact * (DIRECTION_UNITS / UNITS);
    for (word, product) in words[6 * index..6 * index + 6].iter_mut().zip(products) {
        *word = word.wrapping_add((units * product) as i32);
    }
}

/// Returns the start and direction of the ray from a point to a light, in voxels. Twin: grid_way in glsl/grid/way.glsl.
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

/// Twin: SPREAD_SHARE.
const SPREAD_SHARE: f32 = 0.75;

/// Returns the extinction of a voxel in the direction `towards`, of unit length. `sum` is the mean over all directions, and `m` the matrix
/// of the voxel's strands. Twin: directed.
fn directed(sum: f32, m: [f32; 6], towards: [f32; 3]) -> f32 {
    let strands = m[0] + m[1] + m[2];
    let seen: [f32; 3] = from_fn(|i| {
        let (next, last) = ((i + 1) % 3, (i + 2) % 3);
        m[i] * towards[i] + m[3 + i] * towards[next] + m[3 + last] * towards[last]
    });
    let along = (0..3).map(|i| seen[i] * towards[i]).sum::<f32>();
    let across = (strands - along).max(0.0);
    let aside = (0..3).map(|i| (seen[i] - along * towards[i]).powi(2)).sum::<f32>();
    let one_way = (aside / (along * across).max(1e-30)).clamp(0.0, 1.0);
    let (least, most) = (across.min(strands), (strands * across).max(0.0).sqrt().min(strands));
    let share = SPREAD_SHARE + (1.0 - SPREAD_SHARE) * one_way;
    (sum - strands).max(0.0) + 4.0 / PI * (least + share * (most - least))
}

/// Data of a look-up of the technique `density-grid`.
pub struct Soft<'a> {
    /// Mean extinction of voxels.
    pub media: &'a Media,
    /// Directions of the strands; `None` if the technique does not store them.
    pub directions: Option<&'a Directions>,
    /// Number of voxels per side.
    pub size: u32,
}

impl Soft<'_> {
    /// Returns the extinction of a voxel in a direction of unit length. Twin: media_of, directed.
    pub fn of(&self, voxel: [u32; 3], towards: [f32; 3]) -> f32 {
        let sum = self.media.of(voxel);
        let Some(directions) = self.directions.filter(|_| !self.media.is_full(voxel)) else { return sum };
        let at = 6 * self.media.index(voxel);
        let m: [f32; 6] = from_fn(|i| directions.words[at + i] as f32 * (1.0 / DIRECTION_UNITS));
        directed(sum, m, towards)
    }

    /// Twin: media_exact with directions.
    pub fn march_exact(&self, from: [f32; 3], way: [f32; 3]) -> f32 {
        let towards = way.map(|w| w / length(way).max(1e-30));
        self.media.march_by(from, way, |voxel| self.of(voxel, towards))
    }

    /// Returns the extinction at a position, interpolated linearly between voxel centres. Twin: media_soft.
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

    /// Returns the mean and the mean square of a ratio tracking estimate along a ray on which no extinction exceeds `most`: exp(−∫ σ) and
    /// exp(−∫ 2 σ − σ² / most). The integrals are sums over short steps. Twin: media_ratio.
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    /// Returns the extinction along z of strands with these directions, relative to the extinction perpendicular to a strand: by their
    /// matrix, and exactly.
    fn taken(directions: &[[f64; 3]]) -> [f64; 2] {
        let n = directions.len() as f64;
        let mean = |of: &dyn Fn(&[f64; 3]) -> f64| directions.iter().map(of).sum::<f64>() / n;
        let m: [f32; 6] = from_fn(|i| {
            let (a, b) = (i % 3, if i < 3 { i } else { (i + 1) % 3 });
            mean(&|d| d[a] * d[b]) as f32
        });
        let found = f64::from(directed(1.0, m, [0.0, 0.0, 1.0])) * std::f64::consts::FRAC_PI_4;
        [found, mean(&|d| (1.0 - d[2] * d[2]).max(0.0).sqrt())]
    }

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let length = v.iter().map(|a| a * a).sum::<f64>().sqrt();
        v.map(|a| a / length)
    }

    /// Strands that all run one way have a relative extinction of |sin| of their angle to the light, which the matrix gives exactly.
    #[test]
    fn strands_that_run_one_way_are_exact() {
        for i in 0..=90 {
            let angle = f64::from(i).to_radians();
            let [found, truth] = taken(&[unit([0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos()])]);
            assert!((truth - angle.sin()).abs() < 1e-12 && (found - truth).abs() < 2e-3, "{i}°: {found}, not {truth}");
        }
    }

    /// The mean sine of the angle between strands and light has closed forms: π/4 if strands run in all directions, and 2/π if they run in
    /// all directions of a plane that contains the light. The matrix's error is below 3 %.
    #[test]
    fn strands_that_run_every_way_are_near() {
        let count = 20_000;
        let place = |i: i32| (f64::from(i) + 0.5) / f64::from(count);
        let sphere: Vec<_> = (0..count)
            .map(|i| (1.0 - 2.0 * place(i), f64::from(i) * 2.399_963))
            .map(|(z, turn)| [(1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z])
            .collect();
        let plane: Vec<_> =
            (0..count).map(|i| std::f64::consts::TAU * place(i)).map(|a| [a.cos(), 0.0, a.sin()]).collect();
        for (directions, closed) in [(sphere, std::f64::consts::FRAC_PI_4), (plane, std::f64::consts::FRAC_2_PI)] {
            let [found, truth] = taken(&directions);
            assert!((truth - closed).abs() < 1e-3 && (found / closed - 1.0).abs() < 0.03, "{found}, not {closed}");
        }
    }

    /// The matrix's result always lies between E[sin²] and its square root, and so does the truth. For bundles of spread-out strands, the
    /// result is closer to the truth than the square root is.
    #[test]
    fn bundles_are_nearer_than_the_root() {
        let mut random = Pcg32::seed_from_u64(7);
        let mut between = |low: f64, high: f64| random.random_range(low..high);
        let mut off = [0.0; 2];
        for _ in 0..500 {
            let (axis, spread) = (unit(from_fn(|_| between(-1.0, 1.0))), between(0.0, 2.0));
            let directions: Vec<_> =
                (0..200).map(|_| unit(from_fn(|i| axis[i] + spread * between(-1.0, 1.0)))).collect();
            let [found, truth] = taken(&directions);
            let square = directions.iter().map(|d| 1.0 - d[2] * d[2]).sum::<f64>() / 200.0;
            assert!(found > square - 1e-5 && found < square.sqrt() + 1e-5, "{found} of {square}");
            off[0] += (found - truth).abs() / 500.0;
            off[1] += (square.sqrt() - truth).abs() / 500.0;
        }
        println!("off by {} on average, the root by {}", off[0], off[1]);
        assert!(off[0] < 0.5 * off[1], "{off:?}");
    }
}
