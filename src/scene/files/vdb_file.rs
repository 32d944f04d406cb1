//! Grids from OpenVDB files (versions 222 to 225 of the format: OpenVDB 3.0 to 13): a tree of floats or half floats, compressed by zip
//! or Blosc, or uncompressed. Source: OpenVDB's io/Archive.cc, io/Compression.h, tree/{Root,Internal,Leaf}Node.h and math/Maps.h.
//!
//! Samples are at integer coordinates of the grid's index space; the grid's map converts them to positions in space. The background,
//! outside the tree, must be 0.

use super::{blosc, spz_file};
use crate::scene::files::volume_file::Grid;
use crate::scene::{Field, MOST_BLOCKS};
use flate2::read::ZlibDecoder;
use glam::DVec3;
use std::io::Read;

/// Magic number: the first bytes of a file.
const MAGIC: [u8; 8] = [0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0];

/// Supported versions of the format.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;

/// The grid to read if no name is given.
const DENSITY: &str = "density";

/// Parts of the names of grids that are no density. Without a name, such a grid is not read even if it is the only one.
const OTHERS: [&str; 10] =
    ["temperature", "heat", "flame", "fuel", "burn", "pressure", "divergence", "vorticity", "velocity", "shadow"];

/// The greatest share of all density that may be missing for negative samples to count as 0: filters leave such.
const MOST_NEGATIVE: f64 = 1e-3;

/// Flags for the compression of a node's values.
const ZIPPED: u32 = 1;
const ACTIVE_ALONE: u32 = 2;
const BLOSC: u32 = 4;

/// Base-2 logarithms of a node's children per side, from the root's children down to the leaves, whose children are samples.
const SIDES: [u32; 3] = [5, 4, 3];

/// A result whose error is a message for users.
type Words<T> = Result<T, String>;

/// A grid's entry in the file's directory.
struct Described {
    name: String,
    kind: String,
    is_half: bool,
    instance_of: String,
    at: usize,
    blocks: usize,
}

/// The storage format of a grid's values.
struct Packing {
    flags: u32,
    is_half: bool,
}

/// The contents of a grid's tree.
#[derive(Default)]
struct Tree {
    /// Tiles of constant value: lowest sample, samples per side, value.
    tiles: Vec<([i32; 3], i32, f32)>,
    /// Number of blocks of 8³ samples that the tiles fill.
    filled: u64,
    /// The lowest sample of each leaf.
    leaves: Vec<[i32; 3]>,
}

struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

/// Reads the grid with the given name; without a name, the grid `density`, or the only grid of floats.
///
/// # Errors
/// A message if the file is not OpenVDB or of an older version; if there is no such grid, or it is a level set or stores other values; or
/// if the file is truncated or damaged.
pub(super) fn read(all: &[u8], name: Option<&str>) -> Words<Grid> {
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
    let described = (0..bytes.u32()?).map(|_| bytes.described()).collect::<Words<Vec<_>>>()?;
    let grid = chosen(&described, name)?;
    bytes.grid(grid).map_err(|cause| format!("grid {}: {cause}", grid.name))
}

fn is_other(name: &str) -> bool {
    let name = name.to_lowercase();
    OTHERS.into_iter().any(|other| name.contains(other))
}

/// Chooses the grid to read.
fn chosen<'a>(all: &'a [Described], name: Option<&str>) -> Words<&'a Described> {
    let names = || all.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>().join(", ");
    let is_of_floats = |grid: &&Described| grid.kind == "Tree_float_5_4_3";
    let grid = all.iter().find(|grid| grid.name == name.unwrap_or(DENSITY));
    let only = || {
        let mut of_floats = all.iter().filter(is_of_floats);
        of_floats.next().filter(|_| name.is_none() && of_floats.next().is_none())
    };
    let grid = grid.or_else(only);
    if let Some(grid) = grid.filter(|grid| name.is_none() && is_other(&grid.name)) {
        let named = format!("grid = {:?}", grid.name);
        return Err(format!("its only grid of floats, {}, is no density; {named} in a scene file reads it", grid.name));
    }
    let grid = grid.ok_or_else(|| format!("no grid {}: it has {}", name.unwrap_or(DENSITY), names()))?;
    if !is_of_floats(&grid) {
        return Err(format!("grid {} is a {}: floats in nodes of 5, 4 and 3 bits are read", grid.name, grid.kind));
    }
    if !grid.instance_of.is_empty() {
        return Err(format!("grid {} shares the tree of {}: name that", grid.name, grid.instance_of));
    }
    Ok(grid)
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

    fn f32(&mut self) -> Words<f32> {
        self.array().map(f32::from_le_bytes)
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

    fn described(&mut self) -> Words<Described> {
        let (unique, kind, instance_of) = (self.text()?, self.text()?, self.text()?);
        // `end` is the offset of the next grid's entry.
        let (at, blocks, end) = (self.place()?, self.place()?, self.place()?);
        if end < self.at {
            return Err("damaged: a grid ends before it begins".into());
        }
        self.at = end;
        // Text after this character only distinguishes grids of the same name.
        let name = unique.split('\u{1e}').next().unwrap_or_default().to_owned();
        let of_floats = kind.strip_suffix("_HalfFloat");
        let (is_half, kind) = (of_floats.is_some(), of_floats.unwrap_or(&kind).to_owned());
        Ok(Described { name, kind, is_half, instance_of, at, blocks })
    }

    fn grid(&mut self, grid: &Described) -> Words<Grid> {
        self.at = grid.at;
        let flags = self.u32()?;
        if flags & !(ZIPPED | ACTIVE_ALONE | BLOSC) != 0 {
            return Err(format!("packed in a way, {flags}, that is not read"));
        }
        if self.metadata()? == "level set" {
            return Err("a level set: make a fog volume of it".into());
        }
        let (origin, steps) = self.map()?;
        let packing = Packing { flags, is_half: grid.is_half };
        if self.u32()? != 1 {
            return Err("a tree of several buffers".into());
        }
        let tree = self.root(&packing)?;
        self.at = grid.blocks;
        let (field, negative) = self.field(&tree, &packing)?;
        Ok(Grid { field, origin, steps, extinction: 1.0, color: None, negative })
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

    fn root(&mut self, packing: &Packing) -> Words<Tree> {
        let mut tree = Tree::default();
        if self.f32()? != 0.0 {
            return Err("what is around it is not 0: a level set? Make a fog volume of it".into());
        }
        let (tiles, children) = (self.u32()?, self.u32()?);
        let side = 1 << SIDES.iter().sum::<u32>();
        for _ in 0..tiles {
            let (at, value) = (self.corner()?, self.f32()?);
            self.u8()?;
            tree.add(at, side, value)?;
        }
        for _ in 0..children {
            let at = self.corner()?;
            self.node(at, 0, packing, &mut tree)?;
        }
        Ok(tree)
    }

    /// Collects the tiles and leaf coordinates below a node.
    fn node(&mut self, at: [i32; 3], level: usize, packing: &Packing, tree: &mut Tree) -> Words<()> {
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
            tree.add(place(i), 1 << below, value)?;
        }
        for i in (0..count).filter(|i| is_on(children, *i)) {
            self.node(place(i), level + 1, packing, tree)?;
        }
        Ok(())
    }

    /// Reads all values of a node; the file may store only the active ones.
    fn values(&mut self, active: &[u8], packing: &Packing) -> Words<Vec<f32>> {
        let count = 8 * active.len();
        let how = self.u8()?;
        // Values that are not stored are 0, or one of two values selected by another mask.
        let inactive = match how {
            2 | 4 => [self.f32()?, 0.0],
            5 => [self.f32()?, self.f32()?],
            0 | 1 | 3 | 6 => [0.0; 2],
            _ => return Err("damaged: a node without a known way of its values".into()),
        };
        let chosen = if matches!(how, 3..=5) { Some(self.take(active.len())?) } else { None };
        let all_there = packing.flags & ACTIVE_ALONE == 0 || how == 6;
        let there = if all_there { count } else { active.iter().map(|byte| byte.count_ones() as usize).sum() };
        let mut found = self.floats(there, packing)?.into_iter();
        let value = |i: usize| {
            if all_there || is_on(active, i) {
                return found.next().unwrap_or_default();
            }
            inactive[usize::from(chosen.is_some_and(|mask| is_on(mask, i)))]
        };
        Ok((0..count).map(value).collect())
    }

    fn floats(&mut self, count: usize, packing: &Packing) -> Words<Vec<f32>> {
        let wide = if packing.is_half { 2 } else { 4 };
        if count == 0 && packing.is_half {
            return Ok(Vec::new());
        }
        let raw = self.unpacked(count * wide, packing.flags)?;
        let float = |bytes: &[u8]| match *bytes {
            [a, b] => spz_file::half([a, b]) as f32,
            _ => f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        };
        Ok(raw.chunks_exact(wide).map(float).collect())
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

    /// Reads the data of the leaves, which follow in tree order; each begins with its mask of active voxels again. Also returns the number
    /// of samples that are slightly negative and count as 0.
    fn field(&mut self, tree: &Tree, packing: &Packing) -> Words<(Field, usize)> {
        let tiles = tree.tiles.iter().flat_map(|&(at, side, value)| voxels(at, side).map(move |at| (at, value)));
        let mut failed = None;
        let leaves = tree.leaves.iter().map_while(|at| {
            let leaf = self.take(64).and_then(|active| self.values(active, packing));
            let values = leaf.map_err(|cause| failed = Some(cause)).ok()?;
            Some(voxels(*at, 1 << SIDES[2]).zip(values).filter(|(_, value)| *value != 0.0))
        });
        let (mut count, mut missing, mut all, mut first) = (0, 0.0, 0.0, None);
        let samples = tiles.chain(leaves.flatten()).map(|(at, value)| {
            if value > f32::NEG_INFINITY && value < 0.0 {
                first.get_or_insert((at, value));
                (count, missing) = (count + 1, missing - f64::from(value));
                return (at, 0.0);
            }
            all += f64::from(value);
            (at, value)
        });
        let field = Field::new(samples)?;
        if let Some(cause) = failed {
            return Err(cause);
        }
        match first {
            Some((at, value)) if missing > MOST_NEGATIVE * all => {
                Err(format!("density {value} at {at:?} is less than 0"))
            }
            _ => Ok((field, count)),
        }
    }
}

impl Tree {
    /// Adds a tile, unless its value is 0.
    fn add(&mut self, at: [i32; 3], side: i32, value: f32) -> Words<()> {
        if value == 0.0 {
            return Ok(());
        }
        self.tiles.push((at, side, value));
        self.filled += (side as u64 / 8).pow(3);
        if self.filled > MOST_BLOCKS as u64 {
            return Err(format!("tiles of one value fill more than {MOST_BLOCKS} blocks of 8 × 8 × 8 samples"));
        }
        Ok(())
    }
}

/// Returns the coordinates of a cube's samples, z fastest.
fn voxels(at: [i32; 3], side: i32) -> impl Iterator<Item = [i32; 3]> {
    // 4096³ overflows i32; a tile that large has already been rejected, since it exceeds the maximum size of a field.
    (0..side.checked_pow(3).unwrap_or(0))
        .map(move |i| [at[0] + i / (side * side), at[1] + i / side % side, at[2] + i % side])
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
        read(&bytes(name), wanted).expect(name)
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
        for name in ["ok-blosc", "ok-half", "ok-zipped", "ok-turned"] {
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
        let grid = grid("ok-two-others", Some("density"));
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
            let error = read(&bytes("ok-blosc"), Some(name)).map(|_| ()).expect_err(name);
            assert!(error.contains(name) && error.contains(words), "{error}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, words) in [
            ("bad-cut-off", "truncated"),
            ("bad-cut-in-the-tree", "truncated"),
            ("bad-not-a-number", "density NaN at [1, 1, 1]"),
            ("bad-negative", "density -0.5 at [1, 1, 1] is less than 0"),
            ("bad-level-set", "level set"),
            ("bad-background", "not 0"),
            ("bad-old", "version 213"),
            ("bad-ends-before", "ends before it begins"),
            ("bad-million-wide", "1000008 samples"),
        ] {
            let error = read(&bytes(name), None).map(|_| ()).expect_err(name);
            assert!(error.contains(words), "{name}: {error}");
        }
        assert!(read(b"NRRD0004", None).map(|_| ()).expect_err("no VDB").contains("no OpenVDB file"));
    }
}
