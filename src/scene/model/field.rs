//! A sparse grid of densities, made of blocks of 8³ cells; empty blocks are not stored. Density is trilinear between samples and 0 outside
//! the grid.

use fnv::FnvHashMap;

/// Number of cells along each side of a block.
pub(crate) const SIDE: usize = 8;

/// Number of samples along each side of a block: the corners of its cells.
pub(crate) const CORNERS: usize = SIDE + 1;

/// The largest number of blocks in a field, at 2.9 KiB per block: about 33 million cells.
pub const MOST_BLOCKS: usize = 1 << 16;

/// The largest number of samples that a field may span along each axis. It bounds the cost of a ray, which skips 8 samples at once.
pub const MOST_SIDE: i32 = 1 << 16;

/// The maximum distance of a sample from sample 0 along an axis, in samples.
const FARTHEST_SAMPLE: i32 = 1 << 24;

/// A block of 8³ cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// Coordinates of the block's lowest sample.
    pub at: [i32; 3],
    samples: Box<[f32]>,
}

/// Densities at integer coordinates; eight of them form the corners of a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    blocks: Vec<Block>,
    places: FnvHashMap<[i32; 3], u32>,
    ends: [[i32; 3]; 2],
}

/// The samples of 8³ places, x fastest, by their coordinates in leaves.
type Leaves = FnvHashMap<[i32; 3], Box<[f32]>>;

/// A field that is being built sample by sample.
#[derive(Default)]
pub(crate) struct FieldBuilder {
    leaves: Leaves,
    /// Whether there are more blocks than a field may have.
    is_full: bool,
}

impl FieldBuilder {
    /// Adds a sample.
    ///
    /// # Errors
    /// A message if the density is negative or not finite, or the coordinates are too far out.
    pub fn add(&mut self, place: [i32; 3], density: f32) -> Result<(), String> {
        if !(density.is_finite() && density >= 0.0) {
            return Err(format!("density {density} at {place:?} is not finite and at least 0"));
        }
        if density == 0.0 {
            return Ok(());
        }
        if place.iter().any(|at| at.unsigned_abs() > FARTHEST_SAMPLE as u32) {
            return Err(format!("sample {place:?} is farther than {FARTHEST_SAMPLE} from sample 0"));
        }
        let leaf = place.map(|at| at.div_euclid(SIDE as i32));
        if self.leaves.len() >= MOST_BLOCKS && !self.leaves.contains_key(&leaf) {
            self.is_full = true;
            return Ok(());
        }
        let values = self.leaves.entry(leaf).or_insert_with(|| vec![0.0; SIDE.pow(3)].into());
        let [x, y, z] = place.map(|at| at.rem_euclid(SIDE as i32) as usize);
        values[(z * SIDE + y) * SIDE + x] = density;
        Ok(())
    }

    /// Returns the field of all samples; None if it would have more than [`MOST_BLOCKS`] blocks.
    ///
    /// # Errors
    /// A message if the field exceeds [`MOST_SIDE`].
    pub fn field(self) -> Result<Option<Field>, String> {
        if self.is_full { Ok(None) } else { Field::of_leaves(self.leaves) }
    }
}

impl Block {
    /// Returns the values at the eight corners of a cell, given its coordinates in the block, x first.
    #[cfg(feature = "program")]
    pub fn corners(&self, [x, y, z]: [usize; 3]) -> [f32; 8] {
        std::array::from_fn(|i| self.sample([x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)]))
    }

    fn sample(&self, [x, y, z]: [usize; 3]) -> f32 {
        self.samples[(z * CORNERS + y) * CORNERS + x]
    }

    /// Returns the mean density of a cube of cells that begins at `first` and has `side` cells per side.
    fn mean(&self, first: [usize; 3], side: usize) -> f64 {
        let mut sum = 0.0;
        for z in 0..=side {
            for y in 0..=side {
                for x in 0..=side {
                    let sample = f64::from(self.sample([first[0] + x, first[1] + y, first[2] + z]));
                    // A sample at an end of an axis is shared by half as many of these cells.
                    let cells = [x, y, z].iter().filter(|at| **at > 0 && **at < side).count();
                    sum += sample * f64::from(1u32 << cells);
                }
            }
        }
        sum / (8 * side.pow(3)) as f64
    }
}

impl Field {
    /// Builds a field from samples (coordinates, density) in any order; missing samples are 0.
    ///
    /// # Errors
    /// A message if a density is negative or not finite, coordinates are too far out, or the field exceeds [`MOST_BLOCKS`] or
    /// [`MOST_SIDE`].
    pub fn new(samples: impl IntoIterator<Item = ([i32; 3], f32)>) -> Result<Self, String> {
        let mut builder = FieldBuilder::default();
        for (place, density) in samples {
            builder.add(place, density)?;
            if builder.is_full {
                break;
            }
        }
        builder.field()?.ok_or_else(too_many)
    }

    /// Builds a field from leaves: the samples of 8³ places, x fastest, by their coordinates in leaves. Returns None if it would have more
    /// than [`MOST_BLOCKS`] blocks.
    fn of_leaves(mut leaves: Leaves) -> Result<Option<Self>, String> {
        let side = |axis: usize| {
            let ends =
                leaves.keys().fold([i32::MAX, i32::MIN], |[low, high], at| [low.min(at[axis]), high.max(at[axis])]);
            if leaves.is_empty() { 0 } else { (ends[1] - ends[0] + 1) * SIDE as i32 }
        };
        if let Some(side) = [0, 1, 2].map(side).into_iter().find(|side| *side > MOST_SIDE) {
            return Err(format!("its densities reach over {side} samples along an axis, of at most {MOST_SIDE}"));
        }
        // A cell's corners may lie in the next leaf along each axis, so the leaves before a filled one need cells too.
        let mut all: Vec<[i32; 3]> =
            leaves.keys().flat_map(|leaf| (0..8).map(|i| [0, 1, 2].map(|axis| leaf[axis] - (i >> axis & 1)))).collect();
        all.sort_unstable_by_key(|[x, y, z]| [*z, *y, *x]);
        all.dedup();
        let mut field = Self::default();
        let mut layer = i32::MIN;
        for leaf in all {
            // Leaves of layers below are in no later block: with them, a large field would take twice the memory.
            if leaf[2] != layer {
                layer = leaf[2];
                leaves.retain(|[_, _, z], _| *z >= layer);
            }
            let near: [Option<&Box<[f32]>>; 8] =
                std::array::from_fn(|i| leaves.get(&[0, 1, 2].map(|axis| leaf[axis] + (i >> axis & 1) as i32)));
            let sample = |i: usize| {
                let offset = [i % CORNERS, i / CORNERS % CORNERS, i / CORNERS / CORNERS];
                let of = (0..3).map(|axis| usize::from(offset[axis] == SIDE) << axis).sum::<usize>();
                let [x, y, z] = offset.map(|at| at % SIDE);
                near[of].map_or(0.0, |leaf| leaf[(z * SIDE + y) * SIDE + x])
            };
            let at = leaf.map(|at| at * SIDE as i32);
            let samples: Box<[f32]> = (0..CORNERS.pow(3)).map(sample).collect();
            if samples.iter().any(|s| *s > 0.0) {
                if field.blocks.len() == MOST_BLOCKS {
                    return Ok(None);
                }
                let far = at.map(|at| at + SIDE as i32);
                let [low, high] = if field.blocks.is_empty() { [at, far] } else { field.ends };
                let each =
                    |of: fn(i32, i32) -> i32, a: [i32; 3], b: [i32; 3]| [0, 1, 2].map(|axis| of(a[axis], b[axis]));
                field.ends = [each(i32::min, low, at), each(i32::max, high, far)];
                field.places.insert(leaf, field.blocks.len() as u32);
                field.blocks.push(Block { at, samples });
            }
        }
        Ok(Some(field))
    }

    /// Returns whether all densities are 0.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Returns the number of samples that are not 0.
    #[doc(hidden)]
    pub fn samples(&self) -> usize {
        let own = |i: &usize| [i % CORNERS, i / CORNERS % CORNERS, i / CORNERS / CORNERS].iter().all(|at| *at < SIDE);
        let of_block = |block: &Block| (0..block.samples.len()).filter(own).filter(|i| block.samples[*i] > 0.0).count();
        self.blocks.iter().map(of_block).sum()
    }

    /// Returns the coordinates of the lowest and the highest sample of all cells.
    pub fn range(&self) -> [[i32; 3]; 2] {
        self.ends
    }

    /// Returns the lowest sample of each block, and the samples at its cells' corners, x fastest.
    pub(crate) fn blocks(&self) -> impl ExactSizeIterator<Item = ([i32; 3], &[f32])> {
        self.blocks.iter().map(|block| (block.at, &*block.samples))
    }

    /// Adds the whole field to a checksum.
    #[cfg(feature = "program")]
    pub(super) fn hash(&self, hasher: &mut crc32fast::Hasher) {
        for block in &self.blocks {
            hasher.update(bytemuck::bytes_of(&block.at));
            hasher.update(bytemuck::cast_slice(&block.samples));
        }
    }

    /// Returns the block at the given coordinates, counted in blocks along each axis.
    #[cfg(feature = "program")]
    pub(crate) fn block(&self, number: [i32; 3]) -> Option<&Block> {
        self.places.get(&number).map(|place| &self.blocks[*place as usize])
    }

    /// Returns all non-empty cubes of `side` cells per side (1, 2, 4 or 8): the lowest sample and mean density of each.
    pub(crate) fn cubes(&self, side: usize) -> impl Iterator<Item = ([i32; 3], f64)> {
        let count = SIDE / side;
        let of_block = move |block: &Block| {
            let cube = |i: usize| {
                let first = [i % count, i / count % count, i / count / count].map(|at| at * side);
                ([0, 1, 2].map(|axis| block.at[axis] + first[axis] as i32), block.mean(first, side))
            };
            (0..count.pow(3)).map(cube).filter(|(_, density)| *density > 0.0).collect::<Vec<_>>()
        };
        self.blocks.iter().flat_map(of_block)
    }

    /// Returns the density at a position given in samples.
    #[cfg(test)]
    pub(crate) fn at(&self, place: [f64; 3]) -> f64 {
        let whole = place.map(|at| at.floor() as i32);
        let Some(block) = self.block(whole.map(|at| at.div_euclid(SIDE as i32))) else { return 0.0 };
        let cell = whole.map(|at| at.rem_euclid(SIDE as i32) as usize);
        trilinear(&block.corners(cell), [0, 1, 2].map(|axis| place[axis] - f64::from(whole[axis])))
    }
}

/// Interpolates trilinearly between eight corners, x fastest.
#[cfg(feature = "program")]
pub(crate) fn trilinear(corners: &[f32; 8], [x, y, z]: [f64; 3]) -> f64 {
    let along = |i: usize| f64::from(corners[i]) * (1.0 - x) + f64::from(corners[i + 1]) * x;
    (along(0) * (1.0 - y) + along(2) * y) * (1.0 - z) + (along(4) * (1.0 - y) + along(6) * y) * z
}

fn too_many() -> String {
    format!("more than {MOST_BLOCKS} blocks of 8 × 8 × 8 samples are not empty")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_named() {
        for (density, word) in [(-1.0, "-1"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
            let error = Field::new([([1, 2, 3], density)]).expect_err(word);
            assert!(error.contains(word) && error.contains("[1, 2, 3]"), "{error}");
        }
        assert!(Field::new([([1 << 25, 0, 0], 1.0)]).expect_err("far").contains("33554432"));
        let apart = (0..).map(|i| ([8 * i, 0, 0], 1.0)).take(MOST_BLOCKS + 1);
        assert!(Field::new(apart).expect_err("many").contains("65536 blocks"));
        let wide = Field::new([([0, -1_000_000, 3], 1.0), ([0; 3], 1.0)]).expect_err("wide");
        assert!(wide.contains("1000008 samples"), "{wide}");
        assert!(Field::new([([0; 3], 0.0)]).expect("empty").is_empty());
    }

    /// A single sample of density 1 fills the eight cells around it. If the sample is at a corner of a block, these cells lie in eight
    /// different blocks. The cubes together hold the integral of the density, which is 1.
    #[test]
    fn cubes_hold_what_the_field_does() {
        for place in [[3, 4, 5], [0, 0, 0], [-8, 7, 16], [-1, -1, -1]] {
            let field = Field::new([(place, 1.0)]).expect("a field");
            for side in [1, 2, 4, 8] {
                let sum: f64 = field.cubes(side).map(|(_, density)| density * (side as f64).powi(3)).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{place:?} {side}: {sum}");
            }
            assert_eq!(field.cubes(1).count(), 8, "{place:?}");
        }
        assert_eq!(Field::new([([0; 3], 1.0)]).expect("a field").blocks.len(), 8);
    }
}
