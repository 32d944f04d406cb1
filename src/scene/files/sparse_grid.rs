//! What OpenVDB and NanoVDB files share: which grids of a file are read, and how their leaves and tiles become a field.

use crate::scene::files::volume_file::{Grid, LevelSet};
use crate::scene::{Field, FieldBuilder, MOST_BLOCKS};
use glam::DVec3;

/// The grid to read if no name is given.
const DENSITY: &str = "density";

/// Parts of the names of grids that are no density. Without a name, such a grid is not read even if it is the only one.
const OTHERS: [&str; 10] =
    ["temperature", "heat", "flame", "fuel", "burn", "pressure", "divergence", "vorticity", "velocity", "shadow"];

/// The greatest share of all density that may be missing for negative samples to count as 0: filters leave such.
const MOST_NEGATIVE: f64 = 1e-3;

/// Number of samples along each side of a leaf.
pub(super) const LEAF: i32 = 8;

/// The sides, in samples, of the cubes whose mean becomes one sample if a grid has more blocks than a field may have.
const COARSER: [i32; 4] = [1, 2, 4, 8];

/// The largest number of blocks of all grids of a file.
const MOST_TOGETHER: usize = 4 * MOST_BLOCKS;

/// The largest number of tiles. They take little in a file, and so are not bounded by its size.
const MOST_TILES: usize = 1 << 20;

/// A result whose error is a message for users.
pub(super) type Words<T> = Result<T, String>;

/// Takes the lowest coordinate and the 8³ values of a leaf, z fastest.
pub(super) type TakeLeaf<'a> = &'a mut dyn FnMut([i32; 3], &[f32]) -> Words<()>;

/// A grid in a file's directory.
pub(super) struct Described {
    pub name: String,
    /// The type of its tree, in the file's own words.
    pub kind: String,
    /// Whether its values are numbers that can be densities.
    pub is_of_numbers: bool,
}

/// Returns the indices of the grids to read: all with the given name, or the one that `name[index]` chooses among them. Without a name,
/// those named `density`, or else the only grid of numbers.
pub(super) fn chosen(all: &[Described], name: Option<&str>) -> Words<Vec<usize>> {
    let named = |name: &str| (0..all.len()).filter(|i| all[*i].name == name).collect::<Vec<_>>();
    let of_numbers = || (0..all.len()).filter(|i| all[*i].is_of_numbers).collect::<Vec<_>>();
    let mut found = named(name.unwrap_or(DENSITY));
    if let (true, Some((of, index))) = (found.is_empty(), name.and_then(numbered)) {
        let same = named(of);
        if !same.is_empty() {
            let chosen = same.get(index).copied();
            found.push(chosen.ok_or_else(|| format!("no grid {of}[{index}]: {} are named {of}", same.len()))?);
        }
    }
    if let (true, None, &[only]) = (found.is_empty(), name, &*of_numbers()) {
        let name = &all[only].name;
        if is_other(name) {
            return Err(format!(
                "its only grid of floats, {name}, is no density; grid = {name:?} in a scene file reads it"
            ));
        }
        found.push(only);
    }
    let Some(first) = found.first() else {
        let names = all.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(format!("no grid {}: it has {names}", name.unwrap_or(DENSITY)));
    };
    let Described { name, kind, .. } = &all[*first];
    found.retain(|i| all[*i].is_of_numbers);
    if found.is_empty() {
        return Err(format!("grid {name} is a {kind}: numbers in nodes of 5, 4 and 3 bits are read"));
    }
    Ok(found)
}

fn is_other(name: &str) -> bool {
    let name = name.to_lowercase();
    OTHERS.into_iter().any(|other| name.contains(other))
}

/// Splits `density[1]`.
fn numbered(name: &str) -> Option<(&str, usize)> {
    let (name, index) = name.strip_suffix(']')?.split_once('[')?;
    Some((name, index.parse().ok()?))
}

/// What a grid's values are.
pub(super) struct Meaning {
    /// The value outside the tree.
    pub background: f32,
    /// Whether values are distances from a surface, negative inside.
    pub is_level_set: bool,
    /// Length of a step between samples, in the unit of a level set's distances.
    pub voxel: f64,
}

/// The tiles of a grid, each a cube of one value.
#[derive(Default)]
pub(super) struct Tiles {
    /// Lowest coordinate, number of samples along each side, and density.
    all: Vec<([i32; 3], i32, f32)>,
    /// Number of blocks of 8³ samples that they fill.
    filled: u64,
    negative: Negative,
}

impl Tiles {
    /// Adds a tile, unless its density is 0.
    pub fn add(&mut self, meaning: &Meaning, at: [i32; 3], side: i32, value: f32) -> Words<()> {
        let density = meaning.density(value);
        if density == 0.0 {
            return Ok(());
        }
        if !density.is_finite() {
            return Err(format!("density {density} at {at:?} is not finite and at least 0"));
        }
        if density < 0.0 {
            self.negative.add(at, density, f64::from(side).powi(3));
            return Ok(());
        }
        if self.all.len() == MOST_TILES {
            return Err(format!("more than {MOST_TILES} tiles of one value"));
        }
        self.all.push((at, side, density));
        self.filled = self.filled.saturating_add((side as u64 / 8).pow(3));
        Ok(())
    }
}

/// A field made of a grid, and how it differs from the grid.
pub(super) struct SparseField {
    pub field: Field,
    /// How many samples of the grid became one, along each axis. Sample (0, 0, 0) is the mean of the grid's first ones.
    pub coarser: i32,
    pub notes: Vec<String>,
}

/// Builds a field from tiles and from leaves: `read` passes each to its argument, and may be called several times.
pub(super) fn build_field(
    meaning: &Meaning,
    tiles: &Tiles,
    leaves: usize,
    mut read: impl FnMut(TakeLeaf) -> Words<()>,
) -> Words<SparseField> {
    let blocks = tiles.filled.saturating_add(leaves as u64);
    for coarser in COARSER {
        if blocks / (coarser as u64).pow(3) > MOST_BLOCKS as u64 {
            continue;
        }
        let mut sums = Sums { meaning, coarser, builder: FieldBuilder::default(), negative: tiles.negative };
        tiles.all.iter().try_for_each(|tile| sums.add_tile(*tile))?;
        read(&mut |at, values| sums.add_leaf(at, values))?;
        let Some(field) = sums.builder.field()? else { continue };
        let mut notes = sums.negative.note()?;
        if meaning.background != 0.0 && !meaning.is_level_set {
            notes.push(format!("its background of {} counts as 0", meaning.background));
        }
        if coarser > 1 {
            let mean = format!("the mean of each {coarser} × {coarser} × {coarser} is read");
            notes.push(format!("more than {MOST_BLOCKS} blocks of 8 × 8 × 8 samples: {mean}"));
        }
        return Ok(SparseField { field, coarser, notes });
    }
    Err(format!("more than {} blocks of 8 × 8 × 8 samples", MOST_BLOCKS as u64 * 512))
}

impl SparseField {
    /// Returns the grid, given the position of the file's sample (0, 0, 0) and the steps between its samples.
    pub fn grid(self, origin: DVec3, steps: [DVec3; 3]) -> Grid {
        let (by, middle) = (f64::from(self.coarser), 0.5 * f64::from(self.coarser - 1));
        let origin = origin + middle * (steps[0] + steps[1] + steps[2]);
        let (own_steps, steps) = (Some(steps), steps.map(|step| by * step));
        Grid { field: self.field, origin, steps, own_steps, extinction: 1.0, color: None, notes: self.notes }
    }
}

/// Returns an error for a level set that a scene file does not say how to read, and for another grid that it says to be one.
pub(super) fn check_level_set(is_level_set: bool, level_set: Option<LevelSet>) -> Words<()> {
    if !is_level_set && level_set.is_some() {
        return Err("no level set: leave `level_set` out".into());
    }
    let way = "level_set = \"fog\" of [[volumes]] in a scene file fills it";
    if is_level_set && level_set.is_none() {
        return Err(format!("a level set, which has distances for densities: {way}"));
    }
    Ok(())
}

/// Returns an error if grids have more blocks together than a few of them may have: a small file can describe one tree many times.
pub(super) fn check_together(grids: &[Grid]) -> Words<()> {
    let blocks: usize = grids.iter().map(|grid| grid.field.blocks().len()).sum();
    if blocks > MOST_TOGETHER {
        return Err(format!("its grids have more than {MOST_TOGETHER} blocks of 8 × 8 × 8 samples together"));
    }
    Ok(())
}

/// Notes that several grids of one name are read, and which of a file's grids are not if no name was given.
pub(super) fn tell_several(grids: &mut [Grid], all: &[Described], chosen: &[usize], wanted: Option<&str>) {
    let (count, name) = (grids.len(), chosen.first().map_or("", |first| &all[*first].name));
    let rest = (0..all.len()).filter(|i| !chosen.contains(i)).map(|i| all[i].name.as_str()).collect::<Vec<_>>();
    if let (Some(first), None, false) = (grids.first_mut(), wanted, rest.is_empty()) {
        let told = if rest.len() == 1 {
            "1 other grid is not read"
        } else {
            &format!("{} other grids are not read", rest.len())
        };
        first.notes.push(format!("{told}: {}", rest.join(", ")));
    }
    if let [first, _, ..] = grids {
        first
            .notes
            .push(format!("{count} grids named {name}: `grid` = \"{name}[0]\" in a scene file is the first alone"));
    }
}

impl Meaning {
    /// Returns the density of a value; negative ones stay so.
    fn density(&self, value: f32) -> f32 {
        match self.is_level_set {
            true => (0.5 - f64::from(value) / self.voxel).clamp(0.0, 1.0) as f32,
            false => value,
        }
    }
}

struct Sums<'a> {
    meaning: &'a Meaning,
    coarser: i32,
    builder: FieldBuilder,
    negative: Negative,
}

impl Sums<'_> {
    fn add_tile(&mut self, (at, side, density): ([i32; 3], i32, f32)) -> Words<()> {
        self.negative.all += f64::from(density) * f64::from(side).powi(3);
        let mut places = cube(at.map(|at| at.div_euclid(self.coarser)), side / self.coarser);
        places.try_for_each(|place| self.builder.add(place, density))
    }

    fn add_leaf(&mut self, at: [i32; 3], values: &[f32]) -> Words<()> {
        let by = self.coarser;
        if by == 1 {
            for (place, value) in cube(at, LEAF).zip(values) {
                let density = self.negative.taken(place, self.meaning.density(*value));
                self.builder.add(place, density)?;
            }
            return Ok(());
        }
        let count = LEAF / by;
        let mut sums = [0.0; 64];
        for (offset, value) in cube([0; 3], LEAF).zip(values) {
            let [x, y, z] = offset.map(|at| at / by);
            let place = [0, 1, 2].map(|axis| at[axis] + offset[axis]);
            let density = self.negative.taken(place, self.meaning.density(*value));
            sums[((x * count + y) * count + z) as usize] += f64::from(density);
        }
        let mut means = cube(at.map(|at| at.div_euclid(by)), count).zip(sums);
        means.try_for_each(|(place, sum)| self.builder.add(place, (sum / f64::from(by.pow(3))) as f32))
    }
}

/// Negative samples, which count as 0 if they are slight.
#[derive(Clone, Copy, Default)]
struct Negative {
    count: usize,
    missing: f64,
    all: f64,
    first: Option<([i32; 3], f32)>,
}

impl Negative {
    fn add(&mut self, at: [i32; 3], value: f32, samples: f64) {
        self.first.get_or_insert((at, value));
        self.count += 1;
        self.missing -= f64::from(value) * samples;
    }

    fn taken(&mut self, at: [i32; 3], value: f32) -> f32 {
        if value > f32::NEG_INFINITY && value < 0.0 {
            self.add(at, value, 1.0);
            return 0.0;
        }
        self.all += f64::from(value);
        value
    }

    fn note(&self) -> Words<Vec<String>> {
        match (self.first, self.count) {
            (Some((at, value)), _) if self.missing > MOST_NEGATIVE * self.all => {
                Err(format!("density {value} at {at:?} is less than 0"))
            }
            (None, _) => Ok(Vec::new()),
            (_, 1) => Ok(vec!["1 slightly negative density counts as 0".into()]),
            (_, count) => Ok(vec![format!("{count} slightly negative densities count as 0")]),
        }
    }
}

/// Returns the coordinates of a cube's samples, z fastest.
fn cube(at: [i32; 3], side: i32) -> impl Iterator<Item = [i32; 3]> {
    let end = move |axis: usize| at[axis].saturating_add(side);
    (at[0]..end(0)).flat_map(move |x| (at[1]..end(1)).flat_map(move |y| (at[2]..end(2)).map(move |z| [x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More tiles than blocks fit, and a leaf of different samples: each sample is the mean of eight, so that all are there in sum, and the
    /// first one is in their middle.
    #[test]
    fn a_large_grid_is_read_coarser() {
        let meaning = Meaning { background: 0.0, is_level_set: false, voxel: 1.0 };
        let mut tiles = Tiles::default();
        for i in 0..17 {
            tiles.add(&meaning, [128 * i, 0, -128], 128, 0.5).expect("a tile");
        }
        let values: Vec<f32> = (0..512).map(|i| i as f32).collect();
        let built = build_field(&meaning, &tiles, 1, |take| take([-16, 8, 24], &values)).expect("a field");
        assert_eq!(built.coarser, 2);
        assert!(built.notes[0].contains("the mean of each 2 × 2 × 2 is read"), "{:?}", built.notes);
        let (field, i) = (&built.field, |x: i32, y: i32, z: i32| f64::from((x * 8 + y) * 8 + z));
        assert_eq!((field.at([0.0, 0.0, -64.0]), field.at([17.0 * 64.0, 0.0, -64.0])), (0.5, 0.0));
        for place in cube([0; 3], 4) {
            let [x, y, z] = place.map(|at| 2 * at);
            let mean = cube([x, y, z], 2).map(|[x, y, z]| i(x, y, z)).sum::<f64>() / 8.0;
            let at = [place[0] - 8, place[1] + 4, place[2] + 12].map(f64::from);
            assert_eq!(field.at(at), mean, "{place:?}");
        }
        let grid = built.grid(DVec3::new(1.0, 2.0, 3.0), [DVec3::X, 2.0 * DVec3::Y, DVec3::Z]);
        assert_eq!((grid.origin, grid.steps[1]), (DVec3::new(1.5, 3.0, 3.5), 4.0 * DVec3::Y));
    }

    #[test]
    fn too_large_a_grid_is_refused() {
        let meaning = Meaning { background: 0.0, is_level_set: false, voxel: 1.0 };
        let mut tiles = Tiles::default();
        tiles.add(&meaning, [0; 3], 4096, 0.5).expect("a tile");
        let error = build_field(&meaning, &tiles, 0, |_| Ok(())).map(|_| ()).expect_err("134 million blocks");
        assert!(error.contains("more than 33554432 blocks"), "{error}");
        let mut tiles = Tiles::default();
        [(8, 1.0), (16, -0.5)]
            .into_iter()
            .for_each(|(at, value)| tiles.add(&meaning, [at; 3], 8, value).expect("finite"));
        let error = build_field(&meaning, &tiles, 0, |_| Ok(())).map(|_| ()).expect_err("negative");
        assert!(error.contains("density -0.5"), "{error}");
    }
}
