//! Grids from NanoVDB files (version 32 of the format: NanoVDB 32.3 to 32.9, of OpenVDB 9 to 13): floats, doubles and
//! floats quantized to 4, 8, 16 or a varying number of bits; uncompressed, or compressed by zip or Blosc. Source:
//! NanoVDB's NanoVDB.h, IO.h and GridHandle.h.
//!
//! A file is a sequence of segments: a header, a description of each grid, then the grids. It can also be the grids
//! alone, as they are in memory. A grid is a header, a root with a list of children, two levels of inner nodes with a
//! slot for each possible child (32³, then 16³), and leaves of 8³ samples; children are at byte offsets from their
//! parents. Checksums are not verified: writers may disable them, and how they are computed depends on the version.

use super::blosc;
use crate::scene::files::sparse_grid::{self, Described, Meaning, Tiles, Words, chosen};
use crate::scene::files::volume_file::{Grid, LevelSet};
use flate2::read::ZlibDecoder;
use glam::DVec3;
use std::borrow::Cow;
use std::cmp::min;
use std::io::Read;

/// Magic numbers: of both files and grids before 32.8; of grids; of files.
const OLD: [u8; 8] = *b"NanoVDB0";
const GRID: [u8; 8] = *b"NanoVDB1";
const FILE: [u8; 8] = *b"NanoVDB2";

/// The supported major version. It changes with the layout in memory.
const VERSION: u32 = 32;

/// Sizes in bytes: of a segment's header; of a grid's description in it, without the name; of a grid's header, after
/// which the tree begins; of a child or tile of the root.
const SEGMENT: usize = 16;
const DESCRIPTION: usize = 176;
const HEADER: usize = 672;
const CHILD: usize = 32;

/// Base-2 logarithms of an inner node's children per side, and of a child's samples per side.
const INNER: [(u32, u32); 2] = [(5, 7), (4, 3)];

/// The greatest ratios of compression by zip and by LZ4.
const MOST_BY_ZIP: usize = 1032;
const MOST_BY_LZ4: usize = 255;

/// The class of a grid of signed distances to a surface.
const LEVEL_SET: u32 = 1;

/// The number of bytes that are compressed at a time by Blosc.
const CHUNK: usize = 1 << 30;

/// Names of the types of values, by number.
const KINDS: [&str; 27] = [
    "Unknown",
    "Float",
    "Double",
    "Int16",
    "Int32",
    "Int64",
    "Vec3f",
    "Vec3d",
    "Mask",
    "Half",
    "UInt32",
    "Boolean",
    "RGBA8",
    "Fp4",
    "Fp8",
    "Fp16",
    "FpN",
    "Vec4f",
    "Vec4d",
    "Index",
    "OnIndex",
    "IndexMask",
    "OnIndexMask",
    "PointIndex",
    "Vec3u8",
    "Vec3u16",
    "UInt8",
];

/// A grid, without the leaves.
struct NanoGrid {
    /// The value outside the tree.
    background: f32,
    /// Rows of the matrix in: position = matrix · coordinates + translation.
    matrix: [[f64; 3]; 3],
    /// Position of sample (0, 0, 0).
    translation: [f64; 3],
    /// Tiles of constant value: lowest sample, samples per side (4096, 128 or 8), value. Includes inactive tiles, and
    /// omits those of value 0.
    tiles: Vec<([i32; 3], i32, f32)>,
}

/// A grid in a file.
struct Entry<'a> {
    /// Whether its values are signed distances to a surface.
    is_level_set: bool,
    packed: &'a [u8],
    codec: u16,
    /// Number of bytes, unpacked.
    size: usize,
}

/// The storage format of a grid's values.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Float,
    Double,
    /// Steps between a leaf's least and greatest value, in this number of bits: a power of two.
    Steps(usize),
    /// The same, but the number of bits varies by leaf.
    StepsByLeaf,
}

/// A traversal of a grid's tree.
struct Walk<'a, F> {
    all: &'a [u8],
    kind: Kind,
    /// Number of bytes left for nodes. Without this limit, a small file whose nodes overlap or share children could
    /// expand to a huge tree.
    left: usize,
    tiles: Vec<([i32; 3], i32, f32)>,
    leaf: F,
}

/// Reads the grids with the given name, as [`chosen`] says. `level_set`: how to read level sets; `None` to refuse them.
///
/// # Errors
/// A message if the file is not NanoVDB or of another version; if there is no such grid, or it is a level set or stores other values; or
/// if the file is truncated or damaged.
pub(super) fn read(all: &[u8], name: Option<&str>, level_set: Option<LevelSet>) -> Words<Vec<Grid>> {
    let (described, entries): (Vec<_>, Vec<_>) = entries(all)?.into_iter().unzip();
    let chosen = chosen(&described, name)?;
    let mut grids = Vec::new();
    for i in &chosen {
        let read = sparse_grid::check_level_set(entries[*i].is_level_set, level_set)
            .and_then(|()| unpacked(&entries[*i]))
            .and_then(|all| build_grid(&all, entries[*i].is_level_set));
        grids.push(read.map_err(|cause| format!("grid {}: {cause}", described[*i].name))?);
        sparse_grid::check_together(&grids)?;
    }
    sparse_grid::tell_several(&mut grids, &described, &chosen, name);
    Ok(grids)
}

/// Makes a field of an unpacked grid.
fn build_grid(all: &[u8], is_level_set: bool) -> Words<Grid> {
    let mut leaves = 0;
    let NanoGrid { background, matrix, translation, tiles: found } = grid(all, |_, _| {
        leaves += 1;
        Ok(())
    })?;
    let steps = [0, 1, 2].map(|axis| DVec3::from_array(matrix.map(|row| row[axis])));
    let meaning = Meaning { background, is_level_set, voxel: steps[0].length() };
    let mut tiles = Tiles::default();
    // Slots without a child hold the background, active or not; a fog is 0 around what the grid holds.
    let around = if is_level_set { background } else { 0.0 };
    let counted = |value: f32| if value == background { around } else { value };
    found.into_iter().try_for_each(|(at, side, value)| tiles.add(&meaning, at, side, counted(value)))?;
    let built = sparse_grid::build_field(&meaning, &tiles, leaves, |take| {
        grid(all, |at, values| take(at, &values.map(counted))).map(|_| ())
    })?;
    Ok(built.grid(translation.into(), steps))
}

fn entries(all: &[u8]) -> Words<Vec<(Described, Entry<'_>)>> {
    match array(all, 0).map_err(|_| "no NanoVDB file: it is too short")? {
        FILE => segments(all),
        GRID => grids(all),
        // Grids that are not in segments: 32.6 and 32.7 mark them; before, their version is at another place.
        OLD if array(all, HEADER - 8) == Ok(GRID) || version(all, 8).is_err() && version(all, 16).is_ok() => grids(all),
        OLD => segments(all),
        _ => Err("no NanoVDB file: it begins otherwise".into()),
    }
}

fn segments(all: &[u8]) -> Words<Vec<(Described, Entry<'_>)>> {
    let (mut entries, mut at) = (Vec::new(), 0);
    while at < all.len() {
        let header = part(all, at, SEGMENT)?;
        if ![OLD, FILE].contains(&array(header, 0)?) {
            return Err(format!("damaged: no segment at byte {at}"));
        }
        version(header, 8)?;
        let [count, codec] = [u16::from_le_bytes(array(header, 12)?), u16::from_le_bytes(array(header, 14)?)];
        at += SEGMENT;
        let mut of_segment = Vec::new();
        for _ in 0..count {
            let about = part(all, at, DESCRIPTION)?;
            let name = part(all, at + DESCRIPTION, word(about, 136)? as usize)?;
            at += DESCRIPTION + name.len();
            let is_level_set = word(about, 36)? == LEVEL_SET;
            of_segment.push((described(name, word(about, 32)?), is_level_set, size(about, 0)?, size(about, 8)?));
        }
        for (described, is_level_set, size, packed) in of_segment {
            let packed = part(all, at, packed)?;
            at += packed.len();
            entries.push((described, Entry { is_level_set, packed, codec, size }));
        }
    }
    Ok(entries)
}

/// Finds the grids in a file without segments.
fn grids(all: &[u8]) -> Words<Vec<(Described, Entry<'_>)>> {
    let (mut entries, mut at) = (Vec::new(), 0);
    for _ in 0..word(all, 28)? {
        let header = part(all, at, HEADER)?;
        version(header, 16)?;
        let packed = part(all, at, size(header, 32)?)?;
        if packed.len() < HEADER {
            return Err(format!("damaged: a grid of {} bytes", packed.len()));
        }
        at += packed.len();
        let described = described(part(header, 40, 256)?, word(header, 636)?);
        let is_level_set = word(header, 632)? == LEVEL_SET;
        entries.push((described, Entry { is_level_set, packed, codec: 0, size: packed.len() }));
    }
    Ok(entries)
}

/// Describes a grid, given its name, which a zero byte ends, and the number of its type.
fn described(name: &[u8], number: u32) -> Described {
    let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
    let name = String::from_utf8_lossy(name).into_owned();
    Described { name, kind: kind_name(number), is_of_numbers: kind(number).is_some() }
}

/// Returns the storage format with this number; `None` if it is not read.
fn kind(number: u32) -> Option<Kind> {
    Some(match number {
        1 => Kind::Float,
        2 => Kind::Double,
        13 => Kind::Steps(4),
        14 => Kind::Steps(8),
        15 => Kind::Steps(16),
        16 => Kind::StepsByLeaf,
        _ => return None,
    })
}

fn kind_name(kind: u32) -> String {
    KINDS.get(kind as usize).map_or_else(|| format!("type {kind}"), |name| (*name).to_owned())
}

fn unpacked<'a>(entry: &Entry<'a>) -> Words<Cow<'a, [u8]>> {
    let (packed, count) = (entry.packed, entry.size);
    let part_at = |at: usize, most: usize, count: usize| {
        let data = part(packed, at + 8, size(packed, at)?)?;
        let fits = count / most <= data.len();
        if fits { Ok(data) } else { Err(format!("damaged: {} bytes cannot yield {count}", data.len())) }
    };
    let mut raw = Vec::new();
    match entry.codec {
        0 => return part(packed, 0, count).map(Cow::Borrowed),
        1 => {
            let stream = ZlibDecoder::new(part_at(0, MOST_BY_ZIP, count)?);
            raw.reserve_exact(count);
            // One more byte, so that the end of the stream is verified.
            let read = stream.take(count as u64 + 1).read_to_end(&mut raw);
            read.map_err(|cause| format!("truncated, or damaged: {cause}"))?;
        }
        2 => {
            let mut at = 0;
            while raw.len() < count {
                let count = min(count - raw.len(), CHUNK);
                let data = part_at(at, MOST_BY_LZ4, count)?;
                let chunk = blosc::unpacked(data, count)?;
                at += 8 + data.len();
                if raw.is_empty() { raw = chunk } else { raw.extend(chunk) }
            }
        }
        codec => return Err(format!("packed in a way, {codec}, that is not read")),
    }
    if raw.len() == count { Ok(Cow::Owned(raw)) } else { Err("damaged: it has another number of bytes".into()) }
}

fn grid(all: &[u8], leaf: impl FnMut([i32; 3], &[f32; 512]) -> Words<()>) -> Words<NanoGrid> {
    if ![OLD, GRID].contains(&array(all, 0)?) {
        return Err("damaged: it does not begin as a grid".into());
    }
    version(all, 16)?;
    let number = word(all, 636)?;
    let wrong = || format!("it stores values of {}: floats are read", kind_name(number));
    let kind = kind(number).ok_or_else(wrong)?;
    let numbers = |at: usize| -> Words<[f64; 3]> {
        let number = |i: usize| array(all, at + 8 * i).map(f64::from_le_bytes);
        Ok([number(0)?, number(1)?, number(2)?])
    };
    let mut walk = Walk { all, kind, left: all.len(), tiles: Vec::new(), leaf };
    let background = walk.root(child(HEADER, array(all, HEADER + 24)?)?)?;
    let matrix = [numbers(384)?, numbers(408)?, numbers(432)?];
    Ok(NanoGrid { background, matrix, translation: numbers(528)?, tiles: walk.tiles })
}

impl<'a, F: FnMut([i32; 3], &[f32; 512]) -> Words<()>> Walk<'a, F> {
    fn node(&mut self, at: usize, size: usize) -> Words<&'a [u8]> {
        self.left = self.left.checked_sub(size).ok_or("damaged: its nodes overlap")?;
        part(self.all, at, size)
    }

    /// Visits all nodes and returns the background.
    fn root(&mut self, at: usize) -> Words<f32> {
        let (size, value) = if self.kind == Kind::Double { (96, 32) } else { (64, 28) };
        let count = word(self.node(at, size)?, 24)? as usize;
        let background = self.value(array(self.all, at + value)?);
        for slot in self.node(at + size, CHILD.saturating_mul(count))?.as_chunks::<CHILD>().0 {
            let key = u64::from_le_bytes(array(slot, 0)?);
            let corner = [42, 21, 0].map(|low| ((key >> low) as i32) << 12);
            match array(slot, 8)? {
                [0, 0, 0, 0, 0, 0, 0, 0] => {
                    let value = self.value(array(slot, if self.kind == Kind::Double { 24 } else { 20 })?);
                    self.tile(corner, 4096, value);
                }
                offset => self.inner(child(at, offset)?, corner, 0)?,
            }
        }
        Ok(background)
    }

    fn inner(&mut self, at: usize, corner: [i32; 3], level: usize) -> Words<()> {
        let (bits, below) = INNER[level];
        let count = 1 << (3 * bits);
        let mask = count / 8;
        // Box and flags; masks of active tiles and of children; statistics; children or values.
        let node = self.node(at, 64 + 2 * mask + 8 * count)?;
        let (children, slots) = (&node[32 + mask..32 + 2 * mask], &node[64 + 2 * mask..]);
        for (i, slot) in slots.as_chunks::<8>().0.iter().enumerate() {
            let place = [0, 1, 2].map(|axis| {
                let along = (i >> (bits * (2 - axis))) & ((1 << bits) - 1);
                corner[axis as usize] + ((along as i32) << below)
            });
            if children[i / 8] >> (i % 8) & 1 == 0 {
                self.tile(place, 1 << below, self.value(*slot));
            } else if level == 0 {
                self.inner(child(at, *slot)?, place, 1)?;
            } else {
                self.leaf(child(at, *slot)?, place)?;
            }
        }
        Ok(())
    }

    fn leaf(&mut self, at: usize, corner: [i32; 3]) -> Words<()> {
        let mut values = [0.0; 512];
        match self.kind {
            Kind::Float => {
                let node = self.node(at, 96 + 512 * 4)?;
                for (value, bytes) in values.iter_mut().zip(node[96..].as_chunks().0) {
                    *value = f32::from_le_bytes(*bytes);
                }
            }
            Kind::Double => {
                let node = self.node(at, 128 + 512 * 8)?;
                for (value, bytes) in values.iter_mut().zip(node[128..].as_chunks().0) {
                    *value = f64::from_le_bytes(*bytes) as f32;
                }
            }
            Kind::Steps(bits) => self.steps(at, bits, &mut values)?,
            Kind::StepsByLeaf => {
                let [flags] = array(self.all, at.saturating_add(15))?;
                self.steps(at, 1 << (flags >> 5), &mut values)?;
            }
        }
        (self.leaf)(corner, &values)
    }

    fn steps(&mut self, at: usize, bits: usize, values: &mut [f32; 512]) -> Words<()> {
        if bits > 16 {
            return Err(format!("damaged: a leaf of {bits} bits per value"));
        }
        let node = self.node(at, 96 + 512 / 8 * bits)?;
        let (least, step) = (f32::from_le_bytes(array(node, 80)?), f32::from_le_bytes(array(node, 84)?));
        let words = node[96..].as_chunks().0;
        for (i, value) in values.iter_mut().enumerate() {
            let word = u32::from_le_bytes(words[i * bits / 32]) >> (i * bits % 32);
            *value = (word & ((1 << bits) - 1)) as f32 * step + least;
        }
        Ok(())
    }

    fn tile(&mut self, corner: [i32; 3], side: i32, value: f32) {
        if value != 0.0 {
            self.tiles.push((corner, side, value));
        }
    }

    fn value(&self, bytes: [u8; 8]) -> f32 {
        match (self.kind, bytes) {
            (Kind::Double, bytes) => f64::from_le_bytes(bytes) as f32,
            (_, [a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]),
        }
    }
}

/// Returns where a child is, given its parent's place and its offset from there.
fn child(parent: usize, offset: [u8; 8]) -> Words<usize> {
    let offset = isize::try_from(i64::from_le_bytes(offset)).ok();
    let at = offset.and_then(|offset| parent.checked_add_signed(offset));
    at.ok_or_else(|| "damaged: a node outside the grid".into())
}

/// Returns an error if the version at this place is not supported.
fn version(all: &[u8], at: usize) -> Words<()> {
    let version = word(all, at)?;
    // Before 29, the numbers had other sizes.
    let before_29 = version >> 21 == 0;
    let [major, minor] =
        if before_29 { [version & 0xffff, version >> 16] } else { [version >> 21, version >> 10 & 0x7ff] };
    if major == VERSION {
        return Ok(());
    }
    Err(format!(
        "version {major}.{minor} of NanoVDB's format, of which {VERSION} is read: convert its OpenVDB file again"
    ))
}

fn part(all: &[u8], at: usize, count: usize) -> Words<&[u8]> {
    let part = at.checked_add(count).and_then(|end| all.get(at..end));
    part.ok_or_else(|| format!("truncated, or damaged: no {count} bytes at byte {at} of {}", all.len()))
}

fn array<const N: usize>(all: &[u8], at: usize) -> Words<[u8; N]> {
    let mut array = [0; N];
    array.copy_from_slice(part(all, at, N)?);
    Ok(array)
}

fn word(all: &[u8], at: usize) -> Words<u32> {
    array(all, at).map(u32::from_le_bytes)
}

fn size(all: &[u8], at: usize) -> Words<usize> {
    let size = usize::try_from(u64::from_le_bytes(array(all, at)?));
    size.map_err(|_| "damaged: a size beyond memory".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::path::Path;

    /// A grid with its leaves and tiles by place.
    struct Whole {
        grid: NanoGrid,
        leaves: HashMap<[i32; 3], [f32; 512]>,
        tiles: HashMap<([i32; 3], i32), f32>,
    }

    impl Whole {
        fn at(&self, place: [i32; 3]) -> f32 {
            let of_tile = [8, 128, 4096].iter().find_map(|side| self.tiles.get(&(lowest(place, *side), *side)));
            let of_leaf = self.leaves.get(&lowest(place, 8)).map(|leaf| {
                let [x, y, z] = place.map(|at| at.rem_euclid(8) as usize);
                leaf[(x * 8 + y) * 8 + z]
            });
            assert!(of_leaf.is_none() || of_tile.is_none(), "{place:?} is in both a leaf and a tile");
            of_leaf.or(of_tile.copied()).unwrap_or(self.grid.background)
        }
    }

    /// The lowest sample of the cube with the given side around a place.
    fn lowest(place: [i32; 3], side: i32) -> [i32; 3] {
        place.map(|at| at - at.rem_euclid(side))
    }

    /// A file that results/files/nanovdb.cpp wrote.
    fn bytes(name: &str) -> Vec<u8> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/nvdb").join(name).with_extension("nvdb");
        std::fs::read(&path).unwrap_or_else(|cause| panic!("{}: {cause}", path.display()))
    }

    /// The grid of a file as it is in memory, which is a file too.
    fn raw(name: &str) -> Vec<u8> {
        let all = bytes(name);
        let entries = entries(&all).expect(name);
        unpacked(&entries[0].1).expect(name).into_owned()
    }

    /// The same file, uncompressed.
    fn plain(name: &str) -> Vec<u8> {
        let (mut all, raw) = (bytes(name), raw(name));
        all.truncate(SEGMENT + DESCRIPTION + word(&all, SEGMENT + 136).expect("a length") as usize);
        all[14..16].fill(0);
        all[SEGMENT + 8..SEGMENT + 16].copy_from_slice(&(raw.len() as u64).to_le_bytes());
        [all, raw].concat()
    }

    fn all_described(all: &[u8]) -> Words<Vec<Described>> {
        Ok(entries(all)?.into_iter().map(|(described, _)| described).collect())
    }

    fn whole(all: &[u8], index: usize) -> Words<Whole> {
        let mut leaves = HashMap::new();
        let entries = entries(all)?;
        let (described, entry) = entries.get(index).ok_or("no such grid")?;
        let grid = grid(&unpacked(entry)?, |corner, values| {
            assert_eq!(corner, lowest(corner, 8));
            assert!(leaves.insert(corner, *values).is_none(), "leaf {corner:?} is there twice");
            Ok(())
        });
        let grid = grid.map_err(|cause| format!("grid {}: {cause}", described.name))?;
        let tiles: HashMap<_, _> = grid.tiles.iter().map(|&(corner, side, value)| ((corner, side), value)).collect();
        assert_eq!(tiles.len(), grid.tiles.len(), "a tile is there twice");
        assert!(tiles.iter().all(|((corner, side), value)| lowest(*corner, *side) == *corner && *value != 0.0));
        Ok(Whole { grid, leaves, tiles })
    }

    fn named(name: &str, index: usize) -> Whole {
        whole(&bytes(name), index).expect(name)
    }

    fn failure(all: &[u8], index: usize) -> String {
        whole(all, index).map(|_| ()).expect_err("a grid")
    }

    /// All places of a box that has all that write.cpp writes, except tiles.
    fn places() -> impl Iterator<Item = [i32; 3]> {
        let of_axis = |from: i32, to: i32| from..to;
        of_axis(-32, 64).flat_map(move |x| of_axis(-32, 40).flat_map(move |y| of_axis(-32, 56).map(move |z| [x, y, z])))
    }

    fn corners() -> impl Iterator<Item = [i32; 3]> {
        places().filter(|place| lowest(*place, 8) == *place)
    }

    fn of_leaf([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
        (0..512).map(move |i| [x + i / 64, y + i / 8 % 8, z + i % 8])
    }

    // The closed forms of write.cpp.

    fn ball([x, y, z]: [i32; 3]) -> f64 {
        let inside = (x + 6).pow(2) + (y + 4).pow(2) + (z - 9).pow(2) < 30;
        if inside { f64::from((7 * x + 11 * y + 13 * z).rem_euclid(29) + 1) / 29.0 } else { 0.0 }
    }

    fn slab([x, y, z]: [i32; 3]) -> f64 {
        if (-16..8).contains(&x) && (16..32).contains(&y) && (40..48).contains(&z) { 0.5 } else { 0.0 }
    }

    fn steps([x, y, z]: [i32; 3]) -> f64 {
        if !((16..56).contains(&x) && (0..8).contains(&y) && (0..8).contains(&z)) {
            return 0.0;
        }
        let (levels, most) = [(2, 1.0), (4, 1.0), (16, 1.0), (256, 1.0), (65536, 100.0)][(x as usize - 16) / 8];
        f64::from((7919 * x + 104729 * y + 1299709 * z) % levels) / (f64::from(levels) - 1.0) * most
    }

    fn field(place: [i32; 3]) -> f64 {
        ball(place) + slab(place) + steps(place)
    }

    /// Compares each sample with `field`; `error` gives the greatest error in a leaf, given the range of its values.
    fn assert_is_field(name: &str, found: &Whole, error: impl Fn(f64) -> f64) {
        let mut leaves = 0;
        for corner in corners() {
            let values = || of_leaf(corner).map(field);
            let (least, most) = values().fold((f64::MAX, f64::MIN), |(a, b), value| (a.min(value), b.max(value)));
            let error = error(most - least);
            for (place, value) in of_leaf(corner).zip(values()) {
                let found = found.at(place);
                let is_right =
                    if error == 0.0 { found == value as f32 } else { (f64::from(found) - value).abs() < error };
                assert!(is_right, "{name} {place:?}: {found}, not {value}");
            }
            assert_eq!(found.leaves.contains_key(&corner), most > least, "{name} {corner:?}");
            leaves += usize::from(most > least);
        }
        let is_slab = |(corner, side): &([i32; 3], i32), value: f32| *side == 8 && slab(*corner) == f64::from(value);
        assert_eq!((found.grid.background, found.tiles.len(), found.leaves.len()), (0.0, 6, leaves), "{name}");
        assert!(found.tiles.iter().all(|(place, value)| is_slab(place, *value)), "{name}");
        let straight = |a: f64| [[a, 0.0, 0.0], [0.0, a, 0.0], [0.0, 0.0, a]];
        assert_eq!((found.grid.matrix, found.grid.translation), (straight(0.25), [1.0, 2.0, 3.0]), "{name}");
    }

    /// Error of half a step, and of the arithmetic in f32.
    fn half_step(bits: i32) -> impl Fn(f64) -> f64 {
        move |range| range / (2f64.powi(bits) - 1.0) / 2.0 + range.max(1.0) * 1e-6
    }

    #[test]
    fn all_types_and_codecs_are_read() {
        for name in ["ok-float-zip", "ok-float-blosc", "ok-double-zip", "ok-double-blosc"] {
            assert_is_field(name, &named(name, 0), |_| 0.0);
        }
        for all in [raw("ok-float-zip"), plain("ok-float-zip")] {
            assert_is_field("uncompressed", &whole(&all, 0).expect("a grid"), |_| 0.0);
        }
        for (name, bits) in [("ok-fp4-zip", 4), ("ok-fp8-blosc", 8), ("ok-fp16-zip", 16)] {
            assert_is_field(name, &named(name, 0), half_step(bits));
        }
        // The writer chose each leaf's number of bits so that the error is at most 0.002.
        assert_is_field("ok-fpn-zip", &named("ok-fpn-zip", 0), |_| 0.002 + 1e-6);
    }

    #[test]
    fn grids_are_described() {
        for (name, expected) in [
            ("ok-double-zip", &["density Double"][..]),
            ("ok-fp4-zip", &["density Fp4"]),
            ("ok-fp8-blosc", &["density Fp8"]),
            ("ok-fp16-zip", &["density Fp16"]),
            ("ok-fpn-zip", &["density FpN"]),
            ("bad-level-set", &["surface Float"]),
            ("bad-int32", &["ids Int32"]),
            ("ok-two-grids", &["density Float", "temperature Float"]),
            ("ok-two-segments", &["temperature Float", "density Float"]),
        ] {
            let found = all_described(&bytes(name)).expect(name);
            let told: Vec<_> = found.iter().map(|grid| format!("{} {}", grid.name, grid.kind)).collect();
            assert_eq!(told, expected, "{name}");
        }
    }

    #[test]
    fn several_grids_are_read() {
        for (name, [density, temperature]) in [("ok-two-grids", [0, 1]), ("ok-two-segments", [1, 0])] {
            assert_is_field(name, &named(name, density), |_| 0.0);
            let temperature = named(name, temperature);
            for place in places() {
                assert_eq!(temperature.at(place), (1000.0 * ball(place)) as f32, "{name} {place:?}");
            }
            assert_eq!(temperature.grid.matrix[2], [0.0, 0.0, 0.5]);
        }
    }

    /// Values inside and outside the band are those of inactive samples and tiles.
    #[test]
    fn level_sets_are_read() {
        let found = named("bad-level-set", 0);
        for place in places() {
            let [x, y, z] = place;
            let square = (x + 6).pow(2) + (y + 4).pow(2) + (z - 9).pow(2);
            let distance = (f64::from(square).sqrt() - 12.0) as f32;
            assert_eq!(found.at(place), distance.clamp(-3.0, 3.0), "{place:?}");
        }
        assert_eq!(found.grid.background, 3.0);
        assert_eq!(found.tiles.get(&([-8, -8, 8], 8)), Some(&-3.0));
    }

    #[test]
    fn maps_are_read() {
        let found = named("ok-sheared", 0);
        let matrix = [[0.5, 0.25, 0.0], [-0.125, 0.75, 0.0625], [0.0, 0.3, 1.5]];
        assert_eq!((found.grid.matrix, found.grid.translation), (matrix, [7.0, -8.0, 9.5]));
        places().for_each(|place| assert_eq!(found.at(place), ball(place) as f32, "{place:?}"));
    }

    /// Slots without a child have the background's value, so that they are tiles.
    #[test]
    fn backgrounds_are_read() {
        let found = named("ok-background", 0);
        assert_eq!(found.grid.background, 0.125);
        places().for_each(|place| assert_eq!(found.at(place), (ball(place) + 0.125) as f32, "{place:?}"));
        assert_eq!(found.at([-5000, 0, 0]), 0.125);
        assert_eq!(found.tiles.get(&([-128, 0, 128], 128)), Some(&0.125));
    }

    #[test]
    fn tiles_of_all_levels_are_read() {
        let found = named("bad-tiles", 0);
        let slab = |i: i32| (([i / 2 * 8 - 16, i % 2 * 8 + 16, 40], 8), 0.5);
        let mut tiles: HashMap<_, _> = (0..6).map(slab).collect();
        tiles.insert(([-384, 128, 256], 128), 0.75);
        tiles.insert(([-8192, 4096, -4096], 4096), 0.25);
        tiles.insert(([0, -4096, 12288], 4096), -0.375);
        assert_eq!((found.tiles, found.leaves.len(), found.grid.background), (tiles, 0, 0.0));
    }

    /// Later versions have other magic numbers; grids may be without segments.
    #[test]
    fn later_versions_are_read() {
        let version = |minor: u32| (32u32 << 21 | minor << 10).to_le_bytes();
        let (mut file, raw) = (plain("ok-float-zip"), raw("ok-float-zip"));
        let begin = file.len() - raw.len();
        file[..8].copy_from_slice(&FILE);
        file[8..12].copy_from_slice(&version(9));
        file[begin..begin + 8].copy_from_slice(&GRID);
        file[begin + 16..begin + 20].copy_from_slice(&version(9));
        assert_is_field("a file of 32.9", &whole(&file, 0).expect("a file of 32.9"), |_| 0.0);

        let (mut first, mut second) = (file[begin..].to_vec(), file[begin..].to_vec());
        assert_is_field("a grid of 32.9", &whole(&first, 0).expect("a grid of 32.9"), |_| 0.0);
        first[28] = 2;
        [second[24], second[28], second[40]] = [1, 2, b'D'];
        let both = [first, second].concat();
        assert_eq!(all_described(&both).unwrap()[1].name, "Density");
        assert_is_field("a second grid", &whole(&both, 1).expect("a second grid"), |_| 0.0);

        // Version 32.7, with a checksum that looks like a version.
        let mut marked = raw;
        marked[8..12].copy_from_slice(&version(7));
        marked[HEADER - 8..HEADER].copy_from_slice(&GRID);
        assert_is_field("a grid of 32.7", &whole(&marked, 0).expect("a grid of 32.7"), |_| 0.0);
    }

    fn with(all: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
        let mut all = all.to_vec();
        all[at..at + bytes.len()].copy_from_slice(bytes);
        all
    }

    #[test]
    fn what_is_wrong_is_named() {
        let (zip, raw) = (bytes("ok-float-zip"), raw("ok-float-zip"));
        let old = (29u32 << 21 | 3 << 10).to_le_bytes();
        // A tree whose only lower node has the same leaf in each slot.
        let root = HEADER + 64;
        let upper = root + i64::from_le_bytes(array(&raw, root + 64 + 8).unwrap()) as usize;
        let mut shared = with(&raw, upper + 32 + 4096, &[255; 4096]);
        for i in 0..32768 {
            let slot = upper + 64 + 8192 + 8 * i;
            let lower: [u8; 8] = array(&raw, upper + 64 + 8192 + 8 * first_child(&raw, upper)).unwrap();
            shared[slot..slot + 8].copy_from_slice(&lower);
        }
        for (all, words) in [
            (bytes("bad-int32"), "grid ids: it stores values of Int32"),
            (with(&raw, 636, &[9]), "values of Half"),
            (with(&raw, 636, &[99]), "values of type 99"),
            (b"NRRD0004".to_vec(), "no NanoVDB file"),
            (b"Nano".to_vec(), "no NanoVDB file: it is too short"),
            (with(&zip, 8, &old), "version 29.3 of NanoVDB's format"),
            (with(&zip, 8, &[28, 0, 1, 0]), "version 28.1 of NanoVDB's format"),
            (with(&raw, 16, &old), "version"),
            (with(&zip, 14, &[3]), "packed in a way, 3"),
            (with(&zip, 16, &[0, 0, 0, 1]), "cannot yield"),
            (with(&zip, zip.len() - 1, &[0]), "damaged"),
            ([&zip[..], b"more"].concat(), "truncated"),
            ([&zip[..], &[7; 20]].concat(), "no segment at byte"),
            (with(&raw, HEADER + 24, &[255; 8]), "damaged"),
            (with(&raw, root + 24, &[255; 4]), "overlap"),
            (shared, "overlap"),
        ] {
            let error = failure(&all, 0);
            assert!(error.contains(words), "{error}, not {words}");
        }
        // In FpN, a leaf of 32 bits.
        let fpn = super::tests::raw("ok-fpn-zip");
        let leaf = HEADER + i64::from_le_bytes(array(&fpn, HEADER).unwrap()) as usize;
        assert!(failure(&with(&fpn, leaf + 15, &[5 << 5]), 0).contains("32 bits"));
    }

    fn first_child(all: &[u8], upper: usize) -> usize {
        (0..32768).find(|i| all[upper + 32 + 4096 + i / 8] >> (i % 8) & 1 == 1).unwrap()
    }

    /// Files cut off, and a tree with wrong bytes where there were others than 0: an error, and memory in proportion to the file.
    #[test]
    fn damaged_files_do_no_harm() {
        let used = |all: &[u8]| {
            let mut is_read = false;
            let used = allocation_counter::measure(|| is_read = read(all, None, None).is_ok()).bytes_max;
            (used, is_read)
        };
        for name in ["ok-float-zip", "ok-float-blosc", "ok-fpn-zip", "ok-two-grids"] {
            let all = bytes(name);
            for cut in (0..all.len()).step_by(37) {
                let (used, is_read) = used(&all[..cut]);
                assert!(!is_read && used < 1200 * all.len() as u64, "{name} cut at {cut}: {used} bytes");
            }
        }
        let (mut random, mut refused) = (crate::scene::Random::new([7, 0]), 0);
        for name in ["ok-float-zip", "ok-fpn-zip", "bad-tiles"] {
            let all = raw(name);
            let full: Vec<_> = (0..all.len()).filter(|at| all[*at] != 0).collect();
            for _ in 0..100 {
                let mut number = |count: usize| random.between(0.0, count as f64 - 0.5) as usize;
                let damaged = with(&all, full[number(full.len())], &[number(256) as u8]);
                let (used, is_read) = used(&damaged);
                refused += usize::from(!is_read);
                assert!(used < 100 * all.len() as u64 + (40 << 20), "{name}: {used} bytes");
            }
        }
        assert!(refused > 30, "{refused} refused");
    }
}
