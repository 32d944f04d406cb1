//! Where the curves of all texels of all maps stand, and what they say.

use super::settings::Settings;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, Resource};
use crate::maps::{Bins, Maps};
use crate::scene::FARTHEST;
use bytemuck::{Pod, Zeroable};

/// Twin: Node in glsl/avsm/node.glsl. A depth of [`FARTHEST`] is that of an unused node.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct NodeData {
    /// Depth in the light's range.
    pub depth: f32,
    /// Transmittance or optical depth.
    pub value: f32,
}

/// The curves, and which tiles have any.
pub struct Curves {
    /// Map after map, texel rows, then the curve of a texel, as glsl/avsm/node.glsl states it: [`NodeData`] in order of
    /// depth, or those packed.
    pub nodes: Buffer,
    /// Casters of each tile: those of the bins, or a stand-in where nothing is skipped.
    pub tiles: Buffer,
    /// Nodes, tiles, and the nodes again: glsl/avsm/store.glsl says why.
    pub set: Bindings,
    /// Of one map.
    size: [u32; 2],
    texels: u64,
    settings: Settings,
}

impl Curves {
    /// Room for the curves of all maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, maps: &Maps, bins: Option<&Bins>, settings: Settings) -> Result<Self> {
        let texels = maps.texels();
        let bytes = texels * pairs(&settings) as u64 * size_of::<NodeData>() as u64;
        let nodes = Buffer::new(context, "avsm.nodes", bytes, Memory::Device)?;
        let tiles = match bins {
            Some(bins) => bins.counts.clone(),
            None => {
                let tiles = u64::from(maps.tiles()[0]) * u64::from(maps.tiles()[1]) * u64::from(maps.count());
                Buffer::new(context, "avsm.tiles", tiles * 4, Memory::Device)?
            }
        };
        let resources = [&nodes, &tiles, &nodes].map(|b| Resource::Buffer(b.clone()));
        let set = Bindings::new(context, "avsm.curves", &resources)?;
        Ok(Self { nodes, tiles, set, size: maps.size(), texels, settings })
    }

    /// Texels whose curve has a node, of all maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where they cannot be read back.
    pub fn covered_texels(&self, bins: Option<&Bins>) -> Result<u64> {
        let pairs = pairs(&self.settings);
        let curves: Vec<NodeData> = self.nodes.read(self.texels as usize * pairs)?;
        let in_use = match bins {
            Some(bins) if self.settings.skip => bins.texels_in_use(self.size)?,
            _ => vec![true; self.texels as usize],
        };
        // Packed or not, a curve begins with the depth of its first node.
        let covered = |(n, in_use): &(&[NodeData], bool)| *in_use && n[0].depth < FARTHEST;
        Ok(curves.chunks_exact(pairs).zip(in_use).filter(covered).count() as u64)
    }

    /// The nodes of a texel's curve, (depth, transmittance).
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where they cannot be read back.
    pub fn texel(&self, bins: Option<&Bins>, map: usize, [x, y]: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        if let Some(bins) = bins
            && self.settings.skip
            && !bins.texel_in_use(map, [x, y])?
        {
            return Ok(Vec::new());
        }
        let pairs = pairs(&self.settings);
        let texel = ((map as u32 * self.size[1] + y) * self.size[0] + x) as usize;
        let curve: Vec<[u32; 2]> = self.nodes.read_from(texel * pairs, pairs)?;
        let exponential = self.settings.exponential;
        let transmittance = |value: f64| if exponential { (-value).exp() } else { value };
        let nodes = if self.settings.packed {
            unpack(&curve, exponential)
        } else {
            curve.iter().map(|n| (f32::from_bits(n[0]).into(), f32::from_bits(n[1]).into())).collect()
        };
        let used = nodes.into_iter().filter(|n: &(f64, f64)| n.0 < f64::from(FARTHEST));
        Ok(used.map(|(depth, value)| (depth, transmittance(value))).collect())
    }
}

/// Pairs of words a texel. Twin: curve_pairs in glsl/avsm/node.glsl.
fn pairs(settings: &Settings) -> usize {
    (if settings.packed { 1 + settings.nodes / 2 } else { settings.nodes }) as usize
}

/// The nodes (depth, value) of a packed texel, in f64; unused ones repeat the last and are left out, so that no two are
/// the same. Twin: unpack_node in glsl/avsm/pack.glsl.
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
