//! Voxelized shadows: bakes triangles into columns and columns into a tree of nodes, and looks voxels up in the tree. Twin of
//! glsl/technique/voxelized/.
//!
//! A bake gives the same 32-bit words here and on the device. Projected corners are rounded to 256ths of a voxel. From there on, only a
//! triangle's depth is computed in f32, with the same operations in the same order on both.

mod columns;

pub use columns::{Cube, Free, Projected, boundaries, columns, project, roundest, voxel};

use columns::place;
use std::collections::HashMap;

/// Kind of a child whose voxels are all lit. Twin: LIT in glsl/technique/voxelized/tree.glsl.
pub const LIT: u32 = 1;
/// Kind of a child whose voxels are all shadowed.
pub const SHADOWED: u32 = 2;
/// Kind of a child that has a node of its own.
pub const INTERSECTED: u32 = 3;

/// The result of a bake. Twin: technique::TreeData, and the words that it points into.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baked {
    /// Number of voxels per side.
    pub size: u32,
    /// [`LIT`], [`SHADOWED`], or [`INTERSECTED`] if there are nodes.
    pub root: u32,
    /// The value that a pointer to the root would have.
    pub root_at: u32,
    /// Index of the word at which each level's nodes start.
    pub at: Vec<u32>,
    /// Number of bits per pointer in each level's nodes.
    pub pointer_bits: Vec<u32>,
    /// Number of bits per node before its pointers: 16 in a graph, 32 in a tree.
    pub header_bits: u32,
    /// Index of the first of the words that belong to the grid's cells.
    pub shortcuts: u32,
    /// All nodes, then one word for each cell of the grid in which look-ups start.
    pub words: Vec<u32>,
}

/// All blocks of one level; a block is a square of columns. `ranges` holds, per block, the minimum exit and the maximum entry of its
/// columns; `nodes` holds, per block, the indices of its nodes in order along the light.
#[derive(Clone, Default)]
struct Blocks {
    across: u32,
    side: u32,
    ranges: Vec<[u32; 2]>,
    nodes: Vec<Vec<u32>>,
}

impl Blocks {
    fn range(&self, block: u32) -> std::ops::Range<u32> {
        let [least, most] = self.ranges[block as usize];
        least / self.side..most.div_ceil(self.side)
    }
}

/// The nodes of a level, without duplicates if equal ones merge.
#[derive(Default)]
struct Kept {
    all: Vec<Vec<u32>>,
    numbers: HashMap<Vec<u32>, u32>,
}

impl Kept {
    /// Returns the index of a node. With `merge`, it is the index of an equal node that is already stored, if any.
    fn number(&mut self, node: Vec<u32>, merge: bool) -> u32 {
        let next = self.all.len() as u32;
        let number = if merge { *self.numbers.entry(node.clone()).or_insert(next) } else { next };
        if number == next {
            self.all.push(node);
        }
        number
    }
}

/// Builds the nodes over all columns, tile by tile like the device. With `merge`, equal nodes merge into a graph; otherwise the result is a
/// tree.
pub fn bake(columns: &[[u32; 2]], size: u32, tile: u32, free: Free, merge: bool) -> Baked {
    let boundaries = boundaries(columns, size, free);
    let tile = tile.min(size);
    let top = size.ilog2() - 2;
    let mut kept: Vec<Kept> = (0..=top).map(|_| Kept::default()).collect();
    let tiles = size / tile;
    let mut above = Blocks { across: tiles, side: tile, ..Blocks::default() };
    for tile_at in 0..tiles * tiles {
        let corner = [tile_at % tiles * tile, tile_at / tiles * tile];
        let mut blocks = bricks(columns, &boundaries, size, corner, tile, &mut kept, merge);
        while blocks.across > 1 {
            blocks = octants(&blocks, &mut kept, merge);
        }
        above.ranges.push(blocks.ranges[0]);
        above.nodes.push(blocks.nodes.swap_remove(0));
    }
    while above.across > 1 {
        above = octants(&above, &mut kept, merge);
    }
    let least = above.ranges[0][0];
    pack(&kept, above.nodes[0].first().copied(), if least >= size { LIT } else { SHADOWED }, size, merge)
}

/// Builds the two lowest levels of a tree: leaves of 8 × 8 × 1 voxels, and bricks of eight leaves.
fn bricks(
    columns: &[[u32; 2]],
    boundaries: &[u32],
    size: u32,
    corner: [u32; 2],
    tile: u32,
    kept: &mut [Kept],
    merge: bool,
) -> Blocks {
    let across = tile / 8;
    let mut blocks = Blocks { across, side: 8, ..Blocks::default() };
    let block_at = |block: u32| (corner[1] / 8 + block / across) * (size / 8) + corner[0] / 8 + block % across;
    let mut leaves: Vec<Vec<u32>> = Vec::new();
    for block in 0..across * across {
        let at = |c: u32| place(size, block_at(block), c);
        let least = (0..64).map(|c| columns[at(c)][1]).min().unwrap_or(0);
        let most = (0..64).map(|c| columns[at(c)][0]).max().unwrap_or(0);
        let leaf = |z: u32| {
            let bits = (0..64).map(|c| u64::from(z >= boundaries[at(c)]) << c).sum::<u64>();
            kept[0].number(vec![bits as u32, (bits >> 32) as u32], merge)
        };
        leaves.push((least..most).map(leaf).collect());
        blocks.ranges.push([least, most]);
    }
    for block in 0..across * across {
        let [least, most] = blocks.ranges[block as usize];
        let brick = |z: u32| {
            let child = |slice: u32| match 8 * z + slice {
                z if z >= most => (SHADOWED, 0),
                z if z < least => (LIT, 0),
                z => (INTERSECTED, leaves[block as usize][(z - least) as usize]),
            };
            kept[1].number(node((0..8).map(child)), merge)
        };
        let nodes = blocks.range(block).map(brick).collect();
        blocks.nodes.push(nodes);
    }
    blocks
}

/// Returns a node's words: a mask with the kind of each child, then the indices of the intersected children.
fn node(children: impl Iterator<Item = (u32, u32)>) -> Vec<u32> {
    let mut words = vec![0];
    for (c, (kind, number)) in children.enumerate() {
        words[0] |= kind << (2 * c);
        if kind == INTERSECTED {
            words.push(number);
        }
    }
    words
}

/// Builds the blocks of the next level up, each from 2 × 2 blocks below.
fn octants(below: &Blocks, kept: &mut [Kept], merge: bool) -> Blocks {
    let across = below.across / 2;
    let mut blocks = Blocks { across, side: 2 * below.side, ..Blocks::default() };
    for block in 0..across * across {
        let child = |c: u32| (2 * (block / across) + (c >> 1 & 1)) * below.across + 2 * (block % across) + (c & 1);
        let ranges = (0..4).map(|c| below.ranges[child(c) as usize]);
        blocks.ranges.push(ranges.fold([u32::MAX, 0], |all, r| [all[0].min(r[0]), all[1].max(r[1])]));
        let octant = |z: u32, c: u32| {
            let (of, z) = (child(c), 2 * z + (c >> 2));
            let [least, most] = below.ranges[of as usize];
            if z * below.side >= most {
                (SHADOWED, 0)
            } else if (z + 1) * below.side <= least {
                (LIT, 0)
            } else {
                (INTERSECTED, below.nodes[of as usize][(z - least / below.side) as usize])
            }
        };
        let level = (blocks.side.ilog2() - 2) as usize;
        let all = |z| kept[level].number(node((0..8).map(|c| octant(z, c))), merge);
        let nodes = blocks.range(block).map(all).collect();
        blocks.nodes.push(nodes);
    }
    blocks
}

/// Returns the number of bits needed for numbers from 0 to `end` − 1.
fn bits_below(end: usize) -> u32 {
    if end > 1 { (end - 1).ilog2() + 1 } else { 1 }
}

/// Packs the stored nodes into the words that look-ups read. `root` is the root's index; if there is no root, `else_is` is the kind of all
/// voxels.
fn pack(kept: &[Kept], root: Option<u32>, else_is: u32, size: u32, merge: bool) -> Baked {
    let header_bits = if merge { 16 } else { 32 };
    let mut baked =
        Baked { size, header_bits, root: if root.is_some() { INTERSECTED } else { else_is }, ..Baked::default() };
    // The pointer to each stored node of the level below, and the number of pointer units (each as long as a header) in that level.
    let (mut names, mut units): (Vec<u32>, usize) = (Vec::new(), 0);
    for (level, nodes) in kept.iter().enumerate() {
        baked.at.push(baked.words.len() as u32);
        if level == 0 {
            baked.pointer_bits.push(0);
            baked.words.extend(nodes.all.iter().flatten());
            (names, units) = ((0..nodes.all.len() as u32).collect(), nodes.all.len());
            continue;
        }
        let pointer_bits = if merge { bits_below(units) } else { 32 };
        let (mut own, mut bits): (Vec<u32>, Vec<bool>) = (Vec::new(), Vec::new());
        let push = |bits: &mut Vec<bool>, value: u32, count: u32| bits.extend((0..count).map(|b| value >> b & 1 == 1));
        for node in &nodes.all {
            own.push((bits.len() / header_bits as usize) as u32);
            push(&mut bits, node[0], header_bits);
            node[1..].iter().for_each(|child| push(&mut bits, names[*child as usize], pointer_bits));
            bits.resize(bits.len().next_multiple_of(header_bits as usize), false);
        }
        // A level without nodes has no pointers.
        baked.pointer_bits.push(if nodes.all.is_empty() { 0 } else { pointer_bits });
        units = bits.len() / header_bits as usize;
        let word = |bits: &[bool]| bits.iter().enumerate().map(|(b, set)| u32::from(*set) << b).sum::<u32>();
        baked.words.extend(bits.chunks(32).map(word));
        names = own;
    }
    baked.root_at = root.map_or(0, |number| names[number as usize]);
    baked.shortcuts = baked.words.len() as u32;
    let cells = shortcuts(&baked);
    baked.words.extend(cells);
    baked
}

/// Maximum number of upper levels that the grid of cells lets a look-up skip. Twin: SHORTCUT_BITS in glsl/technique/voxelized/tree.glsl.
const SHORTCUT_BITS: u32 = 4;

/// Twin: glsl/technique/voxelized/shortcuts.comp.
fn shortcuts(baked: &Baked) -> Vec<u32> {
    let (bits, level) = baked.shortcut_bits_and_level();
    let cell = |c: u32| {
        let voxel = [c, c >> bits, c >> (2 * bits)].map(|c| (c & ((1 << bits) - 1)) << (level + 2));
        let walk = baked.walk(Walk { level: baked.at.len() - 1, at: baked.root_at, kind: baked.root }, voxel, level);
        walk.kind | if walk.kind == INTERSECTED { walk.at << 2 } else { 0 }
    };
    (0..1 << (3 * bits)).map(cell).collect()
}

/// A node reached while descending the tree. Twin: Walk in glsl/technique/voxelized/walk.glsl.
struct Walk {
    level: usize,
    at: u32,
    kind: u32,
}

impl Baked {
    /// Returns the number of bits of a cell's index along each axis, and the level of its node.
    fn shortcut_bits_and_level(&self) -> (u32, usize) {
        let bits = SHORTCUT_BITS.min(self.at.len() as u32 - 2);
        (bits, self.at.len() - 1 - bits as usize)
    }

    /// Descends towards a voxel, to level `to` or to a node whose voxels are all lit or all shadowed. Twin: walk_down.
    fn walk(&self, mut walk: Walk, voxel: [u32; 3], to: usize) -> Walk {
        while walk.kind == INTERSECTED && walk.level > to {
            let bit = u64::from(self.at[walk.level]) * 32 + u64::from(walk.at) * u64::from(self.header_bits);
            let mask = self.bits(bit, 16);
            let child = match walk.level {
                1 => voxel[2] & 7,
                _ => (0..3).map(|axis| (voxel[axis] >> (walk.level + 1) & 1) << axis).sum(),
            };
            walk.kind = mask >> (2 * child) & 3;
            if walk.kind == INTERSECTED {
                let before = (0..child).filter(|c| mask >> (2 * c) & 3 == INTERSECTED).count() as u64;
                let pointer_bits = self.pointer_bits[walk.level];
                walk.at = self.bits(bit + u64::from(self.header_bits) + before * u64::from(pointer_bits), pointer_bits);
            }
            walk.level -= 1;
        }
        walk
    }

    /// Returns whether a voxel is shadowed, and how many words or nodes were read, one per level. Twin: glsl/technique/voxelized/walk.glsl.
    pub fn shadowed(&self, voxel: [u32; 3]) -> (bool, u32) {
        let (bits, level) = self.shortcut_bits_and_level();
        let cell = voxel.map(|v| v >> (level + 2));
        let cell = self.words[(self.shortcuts + (cell[0] | (cell[1] | cell[2] << bits) << bits)) as usize];
        let walk = self.walk(Walk { level, at: cell >> 2, kind: cell & 3 }, voxel, 0);
        let steps = 1 + (level - walk.level) as u32;
        if walk.kind != INTERSECTED {
            return (walk.kind == SHADOWED, steps);
        }
        let bit = u64::from(self.at[0]) * 32 + 64 * u64::from(walk.at) + u64::from(8 * (voxel[1] & 7) + (voxel[0] & 7));
        (self.bits(bit, 1) == 1, steps)
    }

    fn bits(&self, from: u64, count: u32) -> u32 {
        let bit = |b: u64| self.words[(b / 32) as usize] >> (b % 32) & 1;
        (0..count).map(|b| bit(from + u64::from(b)) << b).sum()
    }

    /// Returns the result of a look-up at a position in the cube, in voxels: the lit share of `filter` × `filter` columns. Twin:
    /// glsl/technique/voxelized/visibility.glsl, which counts bits of whole leaves instead of single voxels.
    pub fn look_up(&self, at: [f32; 3], filter: u32) -> f64 {
        let (size, reach) = (i64::from(self.size), i64::from(filter / 2));
        let [x, y] = [at[0], at[1]].map(|v| v.floor() as i64);
        if at[2].is_nan() || at[2] < 0.0 || !at[0].is_finite() || !at[1].is_finite() {
            return 1.0;
        }
        let z = (at[2].min(self.size as f32 - 1.0)) as u32;
        let inside = |v: &i64| (0..size).contains(v);
        let columns = |v: i64| (v - reach..=v + reach).filter(inside);
        let count = columns(y).flat_map(|y| columns(x).map(move |x| [x as u32, y as u32, z]));
        let shadowed = count.filter(|voxel| self.shadowed(*voxel).0).count();
        1.0 - shadowed as f64 / f64::from(filter * filter)
    }
}
