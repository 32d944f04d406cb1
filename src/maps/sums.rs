//! Sums over the casters on each texel's ray, for techniques that keep some numbers of where in a range of depths light is lost:
//! glsl/maps/sums/.

use super::texels::TexelPasses;
use super::{Bins, Entries, Maps, TexelWay, Use};
use crate::Result;
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, Memory, Resource, Shader};
use crate::shaders::set;
use crate::world::World;

/// What makes them. The constants that it is made with say what SUM_RANGE is.
pub struct SumKernels<'a> {
    /// Label of the binned pass.
    pub label: &'static str,
    /// Words of a texel, as the technique packs its sums.
    pub words: u32,
    /// Writes a tile's texels: maps/sums/binned.glsl.
    pub binned: &'a Shader,
}

/// The texels' words, map after map, and the way to them.
pub struct Sums {
    /// What look-ups fetch.
    pub words: Buffer,
    bins: Bins,
    kernel: Kernel,
    label: &'static str,
}

impl Sums {
    /// Words of the texels of all maps. `skip`: casters in the dark behind meshes are left out; `reach`: texels around a tile from
    /// which look-ups read it.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        _way: TexelWay,
        (skip, reach): (bool, u32),
        kernels: &SumKernels,
        constants: &Constants,
    ) -> Result<Self> {
        let label = kernels.label;
        let words = Buffer::new(context, label, 4 * u64::from(kernels.words) * maps.texels(), Memory::Device)?;
        let what = Use { entries: Entries::Summed, skip, reach, parts: [1, 1], area: false, blocks: None };
        let bins = Bins::new(context, world, maps, what)?;
        let storage = set::MapsSums { sum_words: &words }.bind(context, label)?;
        let kernel = Kernel::compute(context, kernels.binned, &[maps.scene(), bins.set(), &storage], constants)?;
        Ok(Self { words, bins, kernel, label })
    }
}

impl TexelPasses for Sums {
    fn record(&mut self, commands: &mut Commands, world: &World, _maps: &Maps) -> Result<()> {
        self.bins.record(commands, world);
        commands.pass(self.label, |pass| self.bins.per_part(pass, &self.kernel, &()));
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<bool> {
        self.bins.settle(frame)
    }

    fn bins(&self) -> Option<&Bins> {
        Some(&self.bins)
    }

    fn kept(&self) -> Resource {
        Resource::Buffer(self.words.clone())
    }

    fn bytes(&self) -> [u64; 2] {
        [self.words.bytes(), 0]
    }
}
