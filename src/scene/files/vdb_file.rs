//! Grids from OpenVDB files (versions 222 to 225 of the format: OpenVDB 3.0 to 13): trees of floats, doubles or half floats, compressed by
//! zip or Blosc, or uncompressed. Source: OpenVDB's io/Archive.cc, io/Compression.h, tree/{Root,Internal,Leaf}Node.h and math/Maps.h.
//!
//! Samples are at integer coordinates of the grid's index space; the grid's map converts them to positions in space.

use super::{blosc, spz_file};
use crate::scene::files::sparse_grid::{self, Described, Meaning, TakeLeaf, Tiles, Words, chosen};
use crate::scene::files::volume_file::{Grid, LevelSet};
use flate2::read::ZlibDecoder;
use glam::DVec3;
use std::io::Read;

/// Magic number: the first bytes of a file.
const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];

/// Supported versions of the format.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;

/// Flags for the compression of a node's values.
const ZIPPED: u32 = 1;
const ACTIVE_ALONE: u32 = 2;
const BLOSC: u32 = 4;

/// Base-2 logarithms of a node's children per side, from the root's children down to the leaves, whose children are samples.
const SIDES: [u32; 3] = [5, 4, 3];

/// A grid's entry in the file's directory.
struct Entry {
    /// Its name with what tells it from others of that name.
    unique: String,
    /// The unique name of the grid whose tree it shares; empty if it has its own.
    instance_of: String,
    stored: Stored,
    at: usize,
    blocks: usize,
}

/// The type of a tree's values.
#[derive(Clone, Copy)]
struct Stored {
    /// Bytes of a value on its own.
    bytes: usize,
    /// Bytes of a value in an array.
    array_bytes: usize,
}

/// The storage format of a grid's values.
struct Packing {
    flags: u32,
    stored: Stored,
    background: f32,
    /// What inactive values of the background count as: a fog is 0 around what the grid holds.
    around: f32,
}

/// The contents of a grid's tree.
#[derive(Default)]
struct Tree {
    tiles: Tiles,
    /// The lowest sample of each leaf.
    leaves: Vec<[i32; 3]>,
}

/// What stands before a grid's tree.
struct Head {
    flags: u32,
    is_level_set: bool,
    /// Position of sample (0, 0, 0), and the steps between samples.
    map: (DVec3, [DVec3; 3]),
}

struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

/// Reads the grids with the given name; without a name, those named `density`, or the only grid of floats. `level_set`: how to read level
/// sets; `None` to refuse them.
///
/// # Errors
/// A message if the file is not OpenVDB or of an older version; if there is no such grid, or it is a level set or stores other values; or
/// if the file is truncated or damaged.
pub(super) fn read(all: &[u8], name: Option<&str>, level_set: Option<LevelSet>) -> Words<Vec<Grid>> {
    let mut bytes = Bytes { all, at: 0 };
    if bytes.take(8).ok() != Some(&MAGIC) {
        return Err("no OpenVDB file: it begins otherwise".into());
    }
    let version = bytes.u32()?;
    if !VERSIONS.contains(&version) {
        return Err(format!("version {version} of OpenVDB's format, of which {VERSIONS:?} are read"));
    }
    bytes.take(8)?;
    if bytes.u8()? == 0 {
        return Err("it was written as a stream, without where its grids are: write it to a file".into());
    }
    bytes.take(36)?;
    bytes.metadata()?;
    let entries = (0..bytes.u32()?).map(|_| bytes.entry()).collect::<Words<Vec<_>>>()?;
    let (described, entries): (Vec<_>, Vec<_>) = entries.into_iter().unzip();
    let chosen = chosen(&described, name)?;
    let mut grids = Vec::new();
    for i in &chosen {
        let grid = bytes.grid(&entries, &entries[*i], level_set);
        grids.push(grid.map_err(|cause| format!("grid {}: {cause}", described[*i].name))?);
        sparse_grid::check_together(&grids)?;
    }
    sparse_grid::tell_several(&mut grids, &described, &chosen, name);
    Ok(grids)
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Words<&'a [u8]> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.all.get(self.at..end)).ok_or("truncated, or damaged")?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Words<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u8(&mut self) -> Words<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    fn u32(&mut self) -> Words<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Words<[f64; N]> {
        let mut all = [0.0; N];
        for number in &mut all {
            *number = f64::from_le_bytes(self.array()?);
        }
        Ok(all)
    }

    fn text(&mut self) -> Words<String> {
        let length = self.u32()?;
        Ok(String::from_utf8_lossy(self.take(length as usize)?).into_owned())
    }

    /// Reads a byte offset into the file.
    fn place(&mut self) -> Words<usize> {
        usize::try_from(i64::from_le_bytes(self.array()?)).map_err(|_| "damaged: a place before the file".into())
    }

    /// Reads entries of name, type and value; returns the value of `class`, which is the kind of grid.
    fn metadata(&mut self) -> Words<String> {
        let mut class = String::new();
        for _ in 0..self.u32()? {
            let (name, _, value) = (self.text()?, self.text()?, self.text()?);
            if name == "class" {
                class = value;
            }
        }
        Ok(class)
    }

    fn entry(&mut self) -> Words<(Described, Entry)> {
        let (unique, kind, instance_of) = (self.text()?, self.text()?, self.text()?);
        // `end` is the offset of the next grid's entry.
        let (at, blocks, end) = (self.place()?, self.place()?, self.place()?);
        if end < self.at {
            return Err("damaged: a grid ends before it begins".into());
        }
        self.at = end;
        // Text after this character only distinguishes grids of the same name.
        let name = unique.split('\u{1e}').next().unwrap_or_default().to_owned();
        let saved_as_half = kind.strip_suffix("_HalfFloat");
        let kind = saved_as_half.unwrap_or(&kind).to_owned();
        let bytes = match kind.as_str() {
            "Tree_half_5_4_3" => 2,
            "Tree_float_5_4_3" => 4,
            "Tree_double_5_4_3" => 8,
            _ => 0,
        };
        let stored = Stored { bytes, array_bytes: if saved_as_half.is_some() { 2 } else { bytes } };
        let described = Described { name, kind, is_of_numbers: bytes > 0 };
        Ok((described, Entry { unique, instance_of, stored, at, blocks }))
    }

    fn grid(&mut self, entries: &[Entry], entry: &Entry, level_set: Option<LevelSet>) -> Words<Grid> {
        let own = self.head(entry)?;
        // An instance has its own map and class, and the tree of another grid, packed as that is.
        let (tree_of, flags) = if entry.instance_of.is_empty() {
            (entry, None)
        } else {
            let parent = entries.iter().find(|other| other.unique == entry.instance_of);
            let parent = parent.filter(|parent| parent.instance_of.is_empty() && parent.stored.bytes > 0);
            let parent =
                parent.ok_or_else(|| format!("the tree of {:?}, which it shares, is not there", entry.instance_of))?;
            (parent, Some(self.head(parent)?.flags))
        };
        let (origin, steps) = own.map;
        let flags = flags.unwrap_or(own.flags);
        if self.u32()? != 1 {
            return Err("a tree of several buffers".into());
        }
        let background = self.value(tree_of.stored)?;
        let meaning = Meaning { background, is_level_set: own.is_level_set, voxel: steps[0].length() };
        sparse_grid::check_level_set(meaning.is_level_set, level_set)?;
        let around = if meaning.is_level_set { background } else { 0.0 };
        let packing = Packing { flags, stored: tree_of.stored, background, around };
        let tree = self.root(&packing, &meaning)?;
        let built = sparse_grid::build_field(&meaning, &tree.tiles, tree.leaves.len(), |take| {
            self.at = tree_of.blocks;
            self.leaves(&tree, &packing, take)
        })?;
        Ok(built.grid(origin, steps))
    }

    /// Reads what stands before a grid's tree.
    fn head(&mut self, entry: &Entry) -> Words<Head> {
        self.at = entry.at;
        let flags = self.u32()?;
        if flags & !(ZIPPED | ACTIVE_ALONE | BLOSC) != 0 {
            return Err(format!("packed in a way, {flags}, that is not read"));
        }
        let is_level_set = self.metadata()? == "level set";
        Ok(Head { flags, is_level_set, map: self.map()? })
    }

    /// Reads a value that stands on its own.
    fn value(&mut self, stored: Stored) -> Words<f32> {
        self.take(stored.bytes).map(number)
    }

    /// Reads the grid's map: the position of sample (0, 0, 0), and the steps between samples.
    fn map(&mut self) -> Words<(DVec3, [DVec3; 3])> {
        let kind = self.text()?;
        let straight = |scale: DVec3| [DVec3::X * scale.x, DVec3::Y * scale.y, DVec3::Z * scale.z];
        match kind.as_str() {
            "UniformScaleMap" | "ScaleMap" => {
                let scale = DVec3::from_slice(&self.numbers::<15>()?);
                Ok((DVec3::ZERO, straight(scale)))
            }
            "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
                let all = self.numbers::<18>()?;
                Ok((DVec3::from_slice(&all), straight(DVec3::from_slice(&all[3..]))))
            }
            "TranslationMap" => Ok((self.numbers().map(DVec3::from_array)?, straight(DVec3::ONE))),
            "AffineMap" | "UnitaryMap" => {
                // Rows of a matrix for row vectors: position = (x, y, z, 1) · matrix.
                let rows = self.numbers::<16>()?;
                let row = |i: usize| DVec3::from_slice(&rows[4 * i..]);
                Ok((row(3), [row(0), row(1), row(2)]))
            }
            other => Err(format!("its map is a {other}, which is not read")),
        }
    }

    fn corner(&mut self) -> Words<[i32; 3]> {
        let corner = [self.array()?, self.array()?, self.array()?].map(i32::from_le_bytes);
        // Only guards against overflow; [`Field::new`] rejects coordinates that are too far out.
        if corner.iter().any(|at| at.unsigned_abs() > 1 << 30) {
            return Err(format!("a node at {corner:?}"));
        }
        Ok(corner)
    }

    fn root(&mut self, packing: &Packing, meaning: &Meaning) -> Words<Tree> {
        let mut tree = Tree::default();
        let (tiles, children) = (self.u32()?, self.u32()?);
        let side = 1 << SIDES.iter().sum::<u32>();
        for _ in 0..tiles {
            let (at, value, is_active) = (self.corner()?, self.value(packing.stored)?, self.u8()? != 0);
            tree.tiles.add(meaning, at, side, if is_active { value } else { packing.inactive(value) })?;
        }
        for _ in 0..children {
            let at = self.corner()?;
            self.node(at, 0, packing, meaning, &mut tree)?;
        }
        Ok(tree)
    }

    /// Collects the tiles and leaf coordinates below a node.
    fn node(&mut self, at: [i32; 3], level: usize, packing: &Packing, meaning: &Meaning, tree: &mut Tree) -> Words<()> {
        let (bits, count) = (SIDES[level], 1usize << (3 * SIDES[level]));
        if level == 2 {
            self.take(count / 8)?;
            tree.leaves.push(at);
            return Ok(());
        }
        let (children, active) = (self.take(count / 8)?, self.take(count / 8)?);
        let values = self.values(active, packing)?;
        let below: u32 = SIDES[level + 1..].iter().sum();
        let place = |i: usize| {
            let of_axis = |axis: u32| (i >> (bits * (2 - axis)) & ((1 << bits) - 1)) as i32;
            [0, 1, 2].map(|axis| at[axis as usize] + (of_axis(axis) << below))
        };
        for (i, value) in values.into_iter().enumerate().filter(|(i, _)| !is_on(children, *i)) {
            tree.tiles.add(meaning, place(i), 1 << below, value)?;
        }
        for i in (0..count).filter(|i| is_on(children, *i)) {
            self.node(place(i), level + 1, packing, meaning, tree)?;
        }
        Ok(())
    }

    /// Reads all values of a node; the file may store only the active ones.
    fn values(&mut self, active: &[u8], packing: &Packing) -> Words<Vec<f32>> {
        let count = 8 * active.len();
        let how = self.u8()?;
        // Values that are not stored are one of two, selected by another mask.
        let background = packing.background;
        let inactive = match how {
            0 | 6 => [background; 2],
            1 => [-background; 2],
            3 => [-background, background],
            2 | 4 => [self.value(packing.stored)?, background],
            5 => [self.value(packing.stored)?, self.value(packing.stored)?],
            _ => return Err("damaged: a node without a known way of its values".into()),
        };
        let chosen = if matches!(how, 3..=5) { Some(self.take(active.len())?) } else { None };
        let all_there = packing.flags & ACTIVE_ALONE == 0 || how == 6;
        let there = if all_there { count } else { active.iter().map(|byte| byte.count_ones() as usize).sum() };
        let mut found = self.floats(there, packing)?.into_iter();
        let value = |i: usize| {
            let is_active = is_on(active, i);
            let value = if all_there || is_active {
                found.next().unwrap_or_default()
            } else {
                inactive[usize::from(chosen.is_some_and(|mask| is_on(mask, i)))]
            };
            if is_active { value } else { packing.inactive(value) }
        };
        Ok((0..count).map(value).collect())
    }

    fn floats(&mut self, count: usize, packing: &Packing) -> Words<Vec<f32>> {
        let Stored { bytes, array_bytes } = packing.stored;
        if count == 0 && array_bytes < bytes {
            return Ok(Vec::new());
        }
        let raw = self.unpacked(count * array_bytes, packing.flags)?;
        Ok(raw.chunks_exact(array_bytes).map(number).collect())
    }

    fn unpacked(&mut self, count: usize, flags: u32) -> Words<Vec<u8>> {
        if flags & (ZIPPED | BLOSC) == 0 {
            return self.take(count).map(<[u8]>::to_vec);
        }
        let size = i64::from_le_bytes(self.array()?);
        let packed = self.take(usize::try_from(size.unsigned_abs()).unwrap_or(usize::MAX))?;
        if size <= 0 {
            return if packed.len() == count {
                Ok(packed.to_vec())
            } else {
                Err("damaged: other data than a node's".into())
            };
        }
        if flags & BLOSC != 0 {
            return blosc::unpacked(packed, count);
        }
        let mut raw = vec![0; count];
        let mut stream = ZlibDecoder::new(packed);
        stream.read_exact(&mut raw).map_err(|cause| format!("truncated, or damaged: {cause}"))?;
        Ok(raw)
    }

    /// Reads the data of the leaves, which follow in tree order, and passes each leaf on. A leaf begins with its mask of active voxels again.
    fn leaves(&mut self, tree: &Tree, packing: &Packing, take: TakeLeaf) -> Words<()> {
        for at in &tree.leaves {
            let active = self.take(64)?;
            take(*at, &self.values(active, packing)?)?;
        }
        Ok(())
    }
}

impl Packing {
    /// Returns what an inactive value counts as.
    fn inactive(&self, value: f32) -> f32 {
        if value == self.background { self.around } else { value }
    }
}

/// Returns the number in 2, 4 or 8 bytes: a half float, float or double.
fn number(bytes: &[u8]) -> f32 {
    match *bytes {
        [a, b] => spz_file::half([a, b]) as f32,
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32,
        _ => f32::NAN,
    }
}

fn is_on(mask: &[u8], i: usize) -> bool {
    mask[i / 8] >> (i % 8) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn bytes(name: &str) -> Vec<u8> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb").join(name).with_extension("vdb");
        std::fs::read(&path).unwrap_or_else(|cause| panic!("{}: {cause}", path.display()))
    }

    fn grid(name: &str, wanted: Option<&str>) -> Grid {
        read(&bytes(name), wanted, None).expect(name).swap_remove(0)
    }

    fn at(grid: &Grid, place: [i32; 3]) -> f64 {
        grid.field.at(place.map(f64::from))
    }

    /// The densities written by results/files/vdb.py.
    fn ball([x, y, z]: [i32; 3]) -> f64 {
        let inside = (x - 6).pow(2) + (y + 4).pow(2) + (z - 9).pow(2) < 30;
        if inside { f64::from((7 * x + 11 * y + 13 * z).rem_euclid(29) + 1) / 32.0 } else { 0.0 }
    }

    fn places() -> impl Iterator<Item = [i32; 3]> {
        (0..22i32.pow(3)).map(|i| [i % 22 - 4, i / 22 % 22 - 14, i / 484 - 2])
    }

    /// Reads files written by OpenVDB 10.0.1, and some others that OpenVDB reads the same way: every sample and its position must be right.
    #[test]
    fn balls_are_read() {
        for name in ["ok-blosc", "ok-half", "ok-zipped", "ok-turned", "ok-half-tree"] {
            let grid = grid(name, None);
            places().for_each(|place| assert_eq!(at(&grid, place), ball(place), "{name} {place:?}"));
            let (c, s) = (3f64.sqrt() / 2.0, 0.5);
            let (origin, steps) = match name {
                "ok-turned" => {
                    let steps = [DVec3::new(0.5 * c, 0.5 * s, 0.0), DVec3::new(-s, c, 0.0), DVec3::new(0.0, 0.0, 2.0)];
                    (DVec3::new(7.0, 8.0, 9.0), steps)
                }
                _ => (DVec3::new(1.0, 2.0, 3.0), [0.25 * DVec3::X, 0.25 * DVec3::Y, 0.25 * DVec3::Z]),
            };
            assert_eq!(grid.origin, origin, "{name}");
            assert!((0..3).all(|i| grid.steps[i].distance(steps[i]) < 1e-15), "{name}: {:?}", grid.steps);
        }
    }

    /// Inactive samples inside leaves alternate between two values along z: 0.5 if z is even, otherwise 0.25.
    #[test]
    fn other_values_are_read() {
        ["ok-two-others", "ok-half-tree-others"].into_iter().for_each(others_are_read);
    }

    fn others_are_read(name: &str) {
        let grid = grid(name, Some("density"));
        let mut others = 0;
        for place in places() {
            let (found, active) = (at(&grid, place), ball(place));
            let other = if place[2].rem_euclid(2) == 0 { 0.5 } else { 0.25 };
            assert!(found == active || active == 0.0 && found == other, "{place:?}: {found}");
            others += usize::from(active == 0.0 && found == other);
        }
        // There are at most sixteen leaves, partly filled by the ball.
        assert!(others > 1000 && others < 16 * 512, "{others}");
    }

    /// A slab of whole leaves is stored as tiles; this tests the values inside the slab and around its ends.
    #[test]
    fn tiles_are_read() {
        let grid = grid("ok-tiles", None);
        for place in (0..40i32.pow(3)).map(|i| [i % 40 - 16, i / 40 % 40 - 16, i / 1600 - 4]) {
            let [x, y, z] = place;
            let inside = (-8..=15).contains(&x) && (0..=7).contains(&y) && (8..=23).contains(&z);
            assert_eq!(at(&grid, place), if inside { 0.5 } else { 0.0 }, "{place:?}");
        }
    }

    /// Other grids can be read by name, but not grids of another type.
    #[test]
    fn grids_are_named() {
        let temperature = grid("ok-blosc", Some("temperature"));
        assert_eq!(at(&temperature, [2, 3, 4]), 0.75);
        assert_eq!(temperature.field.cubes(1).count(), 8);
        for (name, words) in [("velocity", "Tree_vec3s_5_4_3"), ("smoke", "velocity, temperature, density")] {
            let error = read(&bytes("ok-blosc"), Some(name), None).map(|_| ()).expect_err(name);
            assert!(error.contains(name) && error.contains(words), "{error}");
        }
    }

    /// The densities written by results/files/openvdb12.py.
    fn bead([x, y, z]: [i32; 3]) -> f64 {
        let inside = (x - 6).pow(2) + (y - 5).pow(2) + (z - 9).pow(2) < 12;
        if inside { f64::from((7 * x + 11 * y + 13 * z).rem_euclid(29) + 1) / 32.0 } else { 0.0 }
    }

    /// Doubles, a background, and maps of every kind, by OpenVDB 12. What is around a fog counts as 0.
    #[test]
    fn beads_are_read() {
        let straight = |by: f64| [by * DVec3::X, by * DVec3::Y, by * DVec3::Z];
        let place = DVec3::new(1.0, 2.0, 3.0);
        let sheared = [DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.25, 1.0, 0.0), DVec3::new(0.0, 0.125, 2.0)];
        for (name, wanted, origin, steps, notes) in [
            ("ok-double", None, place, straight(0.25), &[][..]),
            ("ok-double-as-half", None, place, straight(0.25), &[]),
            ("ok-background-fog", None, place, straight(0.25), &["its background of 0.25 counts as 0"]),
            ("ok-instance", None, place, straight(0.25), &["1 other grid is not read: moved"]),
            ("ok-instance", Some("moved"), DVec3::ZERO, straight(2.0), &[]),
            ("ok-instance-same-name", Some("density[1]"), DVec3::new(4.0, 5.0, 6.0), straight(0.5), &[]),
            ("ok-same-names", Some("density[0]"), place, straight(0.25), &[]),
            ("ok-sheared", None, DVec3::new(7.0, 8.0, 9.0), sheared, &[]),
        ] {
            let grid = grid(name, wanted);
            places().for_each(|place| assert_eq!(at(&grid, place), bead(place), "{name} {place:?}"));
            assert_eq!((grid.origin, grid.steps), (origin, steps), "{name}");
            assert_eq!(grid.notes, notes, "{name}");
        }
    }

    /// All grids of a name are read; an index chooses one of them.
    #[test]
    fn grids_of_one_name_are_read() {
        let grids = read(&bytes("ok-same-names"), None, None).expect("two grids");
        assert_eq!(grids.len(), 2);
        assert!(grids[0].notes[0].ends_with("1 other grid is not read: temperature"), "{:?}", grids[0].notes);
        assert!(grids[0].notes[1].contains("2 grids named density"), "{:?}", grids[0].notes);
        for grid in [&grids[1], &grid("ok-same-names", Some("density[1]"))] {
            assert_eq!((at(grid, [1, 2, 3]), at(grid, [6, 5, 9])), (0.5, 0.0));
        }
        assert_eq!(read(&bytes("ok-instance-same-name"), None, None).expect("three grids").len(), 3);
        let error = read(&bytes("ok-same-names"), Some("density[2]"), None).map(|_| ()).expect_err("two alone");
        assert_eq!(error, "no grid density[2]: 2 are named density");
    }

    /// The seven ways in which a node keeps its inactive values, in floats, half floats and doubles. Negative ones and the background count
    /// as 0.
    #[test]
    fn all_ways_of_inactive_values_are_read() {
        let others: [&[f64]; 7] = [&[0.0], &[0.0], &[0.75], &[0.0], &[0.75, 0.0], &[0.75, 1.5], &[0.75, 1.5, 2.5]];
        for name in ["ok-codes", "ok-codes-as-half", "ok-codes-double"] {
            let grid = grid(name, None);
            for (code, others) in others.into_iter().enumerate() {
                for i in 0..512 {
                    let place = [8 * code + i / 64, i / 8 % 8, i % 8].map(|at| at as i32);
                    let expected = if i % 5 == 0 { (i + 1) as f64 / 1024.0 } else { others[i % others.len()] };
                    assert_eq!(at(&grid, place), expected, "{name} code {code} {i}");
                }
            }
            for (place, value) in
                [([64, 0, 0], 3.0), ([71, 7, 7], 3.0), ([72, 3, 5], 4.0), ([130, 7, 9], 5.0), ([80, 0, 0], 0.0)]
            {
                assert_eq!(at(&grid, place), value, "{name} {place:?}");
            }
            assert!(grid.notes.iter().any(|note| note.ends_with("slightly negative densities count as 0")), "{name}");
        }
    }

    /// A tile of 128 samples per side, and six of 8.
    #[test]
    fn large_tiles_are_read() {
        let grid = grid("ok-large-tiles", None);
        for (place, value) in [
            ([0, 0, 0], 0.5),
            ([15, 7, 23], 0.5),
            ([16, 0, 0], 0.0),
            ([128, 0, 0], 0.75),
            ([255, 127, 127], 0.75),
            ([256, 0, 0], 0.0),
        ] {
            assert_eq!(at(&grid, place), value, "{place:?}");
        }
    }

    /// A sphere of radius 2.5, filled: its middle and its volume.
    #[test]
    fn a_level_set_is_filled() {
        let read = read(&bytes("bad-level-set-sphere"), None, Some(LevelSet::Fog));
        let grid = read.expect("a sphere").swap_remove(0);
        let (mut sum, mut middle) = (0.0, DVec3::ZERO);
        for place in (0..32i32.pow(3)).map(|i| [i % 32, i / 32 % 32, i / 1024]) {
            let density = at(&grid, place);
            sum += density;
            middle += density * 0.5 * DVec3::from_array(place.map(f64::from));
        }
        // The sphere's own volume is 65.4; a shell of one voxel, 0.5, in which density falls linearly adds a hundredth.
        let volume = 4.0 / 3.0 * std::f64::consts::PI * (2.5f64.powi(3) + 2.5 * 0.5 * 0.5 / 4.0);
        assert!((sum * 0.125 / volume - 1.0).abs() < 1e-3, "{} for {volume}", sum * 0.125);
        assert!((middle / sum - DVec3::new(5.0, 5.25, 5.5)).length() < 0.01, "{}", middle / sum);
        assert_eq!(at(&grid, [10, 11, 11]), 1.0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, words) in [
            ("bad-cut-off", "truncated"),
            ("bad-cut-in-the-tree", "truncated"),
            ("bad-not-a-number", "density NaN at [1, 1, 1]"),
            ("bad-negative", "density -0.5 at [1, 1, 1] is less than 0"),
            ("bad-level-set", "level set"),
            ("bad-level-set-sphere", "level_set = \"fog\""),
            ("bad-old", "version 213"),
            ("bad-ends-before", "ends before it begins"),
            ("bad-million-wide", "1000008 samples"),
        ] {
            let error = read(&bytes(name), None, None).map(|_| ()).expect_err(name);
            assert!(error.contains(words), "{name}: {error}");
        }
        assert!(read(b"NRRD0004", None, None).map(|_| ()).expect_err("no VDB").contains("no OpenVDB file"));
    }
}
