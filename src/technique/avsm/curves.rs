//! The curves of all texels of all maps: their buffers, and how to read them.

use super::settings::{Settings, Storage};
use crate::gpu::{Bindings, Buffer, Context, Memory};
use crate::maps::{
    BLOCK_TEXELS, Bins, FilterKind, MOST_BLOCKS, Maps, SLOTS, TILE_TEXELS, coarser_texels, table_bytes, tile_count,
};
use crate::scene::FARTHEST;
use crate::shaders::set;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Twin: Node in glsl/maps/curve/node.glsl. An unused node has the depth [`FARTHEST`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct NodeData {
    /// Depth in the light's range.
    pub depth: f32,
    /// Transmittance or optical depth.
    pub value: f32,
}

/// The curves, and a record of which tiles have any.
pub struct Curves {
    /// One curve per texel, map by map and row by row. A curve is [`NodeData`] in order of depth, or its packed form;
    /// glsl/maps/curve/node.glsl defines the layout.
    pub nodes: Buffer,
    /// Number of casters per tile, from the bins; without bins, a placeholder that no shader reads. With detail=adaptive, the positions of
    /// each tile's blocks of 8 × 8 texels among the curves.
    pub tiles: Buffer,
    /// The nodes, the tiles, and the nodes again, declared as another type; glsl/maps/curve/store.glsl explains why.
    pub set: Bindings,
    /// Width and height of one map.
    size: [u32; 2],
    texels: u64,
    settings: Settings,
}

impl Curves {
    /// Allocates the curves of all maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, maps: &Maps, bins: Option<&Bins>, settings: Settings) -> Result<Self> {
        let detail = bins.and_then(Bins::detail);
        let texels = detail.map_or(maps.texels(), |d| u64::from(d.block_count()) * u64::from(BLOCK_TEXELS));
        let coarser = coarser_texels(maps, settings.levels);
        let bytes = (texels + coarser) * pairs(&settings) as u64 * size_of::<NodeData>() as u64;
        let nodes = Buffer::new(context, "avsm.nodes", bytes, Memory::Device)?;
        let tiles = match (detail, bins) {
            (Some(detail), _) => detail.slots().clone(),
            (None, Some(bins)) => bins.counts.clone(),
            (None, None) => {
                let tiles = u64::from(maps.tiles()[0]) * u64::from(maps.tiles()[1]) * u64::from(maps.count());
                Buffer::new(context, "avsm.tiles", tiles * 4, Memory::Device)?
            }
        };
        let set = set::Curves { nodes: &nodes, counts: &tiles, full_nodes: &nodes }.bind(context, "avsm.curves")?;
        Ok(Self { nodes, tiles, set, size: maps.size(), texels, settings })
    }

    /// Returns the number of texels, over all maps, whose curve has a node; `None` with detail=adaptive, where texels differ in size.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn covered_texels(&self, bins: Option<&Bins>) -> Result<Option<u64>> {
        if self.settings.is_adaptive() {
            return Ok(None);
        }
        let pairs = pairs(&self.settings);
        let curves: Vec<NodeData> = self.nodes.read(self.texels as usize * pairs)?;
        let in_use = match bins {
            Some(bins) if self.settings.skip => bins.texels_in_use(self.size)?,
            _ => vec![true; self.texels as usize],
        };
        // A full or packed curve begins with the depth of its first node. A tight curve without nodes is all zeros.
        let has_nodes = |n: &[NodeData]| match self.settings.is_tight() {
            true => n.iter().any(|n| [n.depth, n.value].map(f32::to_bits) != [0; 2]),
            false => n[0].depth < FARTHEST,
        };
        let covered = |(n, in_use): &(&[NodeData], bool)| *in_use && has_nodes(n);
        Ok(Some(curves.chunks_exact(pairs).zip(in_use).filter(covered).count() as u64))
    }

    /// Returns the nodes, (depth, transmittance), of the curve that a look-up at a texel's centre reads. Empty if such a look-up averages
    /// several curves, which happens with filters wider than bilinear, and with detail=adaptive if the corners of four finer texels meet at
    /// the centre.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn texel(&self, bins: Option<&Bins>, map: usize, [x, y]: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        let texel = if self.settings.filter != FilterKind::Bilinear {
            None
        } else if self.settings.is_adaptive() {
            self.place(map as u32, [x, y])?
        } else {
            let in_use = |bins: &Bins| bins.texel_in_use(map, [x, y]);
            let is_built = !self.settings.skip || bins.map_or(Ok(true), in_use)?;
            is_built.then_some(((map as u32 * self.size[1] + y) * self.size[0] + x) as usize)
        };
        let Some(texel) = texel else { return Ok(Vec::new()) };
        let pairs = pairs(&self.settings);
        let curve: Vec<[u32; 2]> = self.nodes.read_from(texel * pairs, pairs)?;
        let exponential = self.settings.is_exponential();
        let transmittance = |value: f64| if exponential { (-value).exp() } else { value };
        let nodes = if self.settings.is_tight() {
            unpack_tight(&curve, exponential)
        } else if self.settings.is_packed() {
            unpack(&curve, exponential)
        } else {
            curve.iter().map(|n| (f32::from_bits(n[0]).into(), f32::from_bits(n[1]).into())).collect()
        };
        let used = nodes.into_iter().filter(|n: &(f64, f64)| n.0 < f64::from(FARTHEST));
        Ok(used.map(|(depth, value)| (depth, transmittance(value))).collect())
    }
}

impl Curves {
    /// With detail=adaptive, returns the index of the curve of the finer texel whose centre is also the centre of this texel of the map.
    /// `None` if no block is stored here, or if an even number of finer texels spans this texel, so that their corners meet at its centre.
    /// Twin: detailed_transmittance in glsl/technique/avsm/visibility.glsl.
    fn place(&self, map: u32, [x, y]: [u32; 2]) -> Result<Option<usize>> {
        let [across, down] = self.size.map(|texels| texels.div_ceil(TILE_TEXELS));
        let tile = (map * down + y / TILE_TEXELS) * across + x / TILE_TEXELS;
        let words: Vec<u32> = self.tiles.read_from((tile * SLOTS) as usize, SLOTS as usize)?;
        let side = words[0] >> 28;
        let [x, y] = [x, y].map(|i| (2 * (i % TILE_TEXELS) + 1) * side / 2);
        let place = words[(y / TILE_TEXELS * side + x / TILE_TEXELS) as usize] & MOST_BLOCKS;
        let within = y % TILE_TEXELS * TILE_TEXELS + x % TILE_TEXELS;
        Ok((side % 2 == 1 && place > 0).then(|| ((place - 1) * BLOCK_TEXELS + within) as usize))
    }
}

/// Returns the maximum number of blocks that detail=adaptive may build; `None` with detail=even. Without `bytes=`, adaptive maps may take
/// as many bytes as maps with detail=even whose nodes have the storage `even`.
///
/// # Errors
/// [`Error::Refused`] if the allowed bytes cannot hold one block per tile.
pub fn blocks(maps: &Maps, settings: &Settings, even: Storage) -> Result<Option<u32>> {
    if !settings.is_adaptive() {
        return Ok(None);
    }
    let texel =
        |storage: Option<Storage>| pairs(&Settings { storage, ..*settings }) as u64 * size_of::<NodeData>() as u64;
    let block = u64::from(BLOCK_TEXELS) * texel(settings.storage);
    let least = tile_count(maps) * block + table_bytes(maps);
    let even = u64::from(settings.size).pow(2) * u64::from(maps.count()) * texel(Some(even));
    let bytes = settings.bytes.map_or(even.max(least), u64::from);
    if bytes < least {
        let needs = format!("at least {least} bytes, for the coarsest texels of these maps, or a smaller size");
        return Err(Error::Refused(needs.into()));
    }
    Ok(Some(((bytes - table_bytes(maps)) / block).min(u64::from(MOST_BLOCKS)) as u32))
}

/// Returns the number of word pairs per texel. Twin: curve_pairs in glsl/maps/curve/node.glsl.
pub fn pairs(settings: &Settings) -> usize {
    let pairs = match (settings.is_tight(), settings.is_packed()) {
        (true, _) => settings.nodes / 4,
        (_, true) => 1 + settings.nodes / 2,
        _ => settings.nodes,
    };
    pairs as usize
}

/// Returns the nodes (depth, value) of a packed texel, in f64. Omits unused nodes, which repeat the last used one. Twin: unpack_node in
/// glsl/maps/curve/pack.glsl.
fn unpack(curve: &[[u32; 2]], exponential: bool) -> Vec<(f64, f64)> {
    let [first, extent] = curve[0].map(|bits| f64::from(f32::from_bits(bits)));
    let mut words: Vec<u32> = curve[1..].iter().flatten().copied().collect();
    words.dedup();
    let node = |word: u32| {
        let (depth, value) = (f64::from(word >> 16), f64::from(word & 0xFFFF));
        let value = if exponential { value / (65536.0 - value) } else { 1.0 - value / 65535.0 };
        (first + extent * depth / 65535.0, value)
    };
    words.into_iter().map(node).collect()
}

/// Returns the nodes (depth, value) of a tight texel, in f64. Code 0 means no node.
fn unpack_tight(curve: &[[u32; 2]], exponential: bool) -> Vec<(f64, f64)> {
    let mut words: Vec<u32> = curve.iter().flatten().flat_map(|pair| [pair & 0xFFFF, pair >> 16]).collect();
    words.dedup();
    let node = |word: u32| {
        let (depth, value) = (f64::from(word >> 8), f64::from(word & 0xFF));
        (depth / 255.0, if exponential { value / (256.0 - value) } else { 1.0 - value / 255.0 })
    };
    words.into_iter().filter(|word| *word != 0).map(node).collect()
}
