//! Packed curves, `storage=packed`: how long they are, what they say, and the interlock path's way to them. The other paths
//! pack where they store.

use super::{Avsm, NodeData};
use crate::Result;
use crate::gpu::{Bindings, Buffer, Commands, Context, Memory, Pipeline, Resource, shader};

/// Pairs of words a texel. Twin: curve_pairs in glsl/avsm/node.glsl.
pub fn pairs(nodes: u32, packed: bool) -> usize {
    (if packed { 1 + nodes / 2 } else { nodes }) as usize
}

/// The nodes (depth, value) of a packed texel, in f64; unused ones repeat the last and are left out, so that no two are
/// the same. Twin: unpack_node in glsl/avsm/pack.glsl.
pub fn unpack(curve: &[[u32; 2]], exponential: bool) -> Vec<(f64, f64)> {
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

/// What path=interlock builds one map after the other in before it is packed: nodes that fragments read back must not
/// be rounded.
pub struct Full {
    nodes: Buffer,
    bindings: Bindings,
    pack: Pipeline,
}

impl Full {
    /// Room for a map of `size` texels with the NODES of `constants`, and the way from there to `packed`; `tiles`
    /// counts the casters of each tile.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(
        context: &Context,
        size: [u32; 2],
        packed: &Bindings,
        tiles: &Buffer,
        constants: &[u32],
    ) -> Result<Self> {
        let count = u64::from(size[0]) * u64::from(size[1]) * u64::from(constants[0]);
        let nodes = Buffer::new(context, "avsm.full", count * size_of::<NodeData>() as u64, Memory::Device)?;
        let resources = [Resource::Buffer(nodes.clone()), Resource::Buffer(tiles.clone())];
        let bindings = Bindings::new(context, "avsm.full", &resources)?;
        let pack = Pipeline::compute(context, shader("avsm/pack.comp")?, &[&bindings, packed], constants)?;
        Ok(Self { nodes, bindings, pack })
    }

    /// The nodes, as avsm/clear.comp and avsm/insert.frag take them.
    pub fn bindings(&self) -> &Bindings {
        &self.bindings
    }

    /// Bytes of the nodes.
    pub fn bytes(&self) -> u64 {
        self.nodes.bytes()
    }
}

impl Avsm {
    pub(super) fn packed(&self) -> bool {
        self.constants[8] == 1
    }

    /// Interlock: packs the curves of a map.
    pub(super) fn pack(&self, commands: &mut Commands, map: u32, full: &Full) {
        let texels = self.size[0] * self.size[1];
        commands.pass("avsm.pack", |pass| {
            let sets = [&full.bindings, &self.nodes_bindings];
            pass.dispatch(&full.pack, &sets, bytemuck::bytes_of(&[map, texels]), [texels.div_ceil(256), 1, 1]);
        });
    }
}
