//! Sums over the casters on each texel's ray, for techniques that store a few numbers about where on the ray light is
//! lost. Shaders: glsl/maps/sums/.

use super::texels::TexelPasses;
use super::{
    Bins, CasterQuads, DrawingOrder, Entries, Levels, Maps, QuadsPush, TexelWay, Use, carried_texels, coarser_texels,
    stacked,
};
use crate::gpu::{
    Blend, Buffer, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Limit, Memory, Resource, Shader,
    Target,
};
use crate::shaders::constant::SUM_RANGE;
use crate::shaders::{self, set};
use crate::world::World;
use crate::{Error, Result};

/// Number of cells into which a coarser level's range is divided, if the technique's own sums do not divide it.
/// Twin: LEVEL_CELLS in glsl/maps/sums/even_cells.glsl.
pub const EVEN_CELLS: u32 = 32;

/// Maximum number of targets that sums are drawn to, with four sums each. Twin: drawn_7 in glsl/maps/sums/pack.glsl.
const MOST_TARGETS: u32 = 8;

/// Shaders of the passes that compute sums. Their constants include SUM_RANGE.
pub struct SumKernels<'a> {
    /// Labels of four kinds of passes: the binned pass, the pass that draws sums, the pass that packs drawn sums, and
    /// the passes that build levels of detail.
    pub labels: [&'static str; 4],
    /// Number of sums per texel, at most 32.
    pub sums: u32,
    /// Number of words per texel, as packed by the technique.
    pub words: u32,
    /// Writes a tile's texels: maps/sums/binned.glsl.
    pub binned: &'a Shader,
    /// Draws a caster to 1, 2, 4 or 8 targets: maps/sums/raster.glsl.
    pub raster: [&'a Shader; 4],
    /// Packs drawn sums: maps/sums/pack.glsl.
    pub pack: &'a Shader,
    /// Builds levels of detail: maps/sums/levels.glsl.
    pub levels: &'a Shader,
    /// Number of levels, including the map itself. The constants hold it too.
    pub level_count: u32,
    /// Number of cells into which a coarser level's range is divided.
    pub level_cells: u32,
}

/// The words of all texels, map after map, and the passes that compute them.
pub struct Sums {
    /// The words that look-ups bind.
    pub words: Buffer,
    way: BuildPath,
    /// Builds the coarser levels, stored after the maps' words.
    levels: Option<Levels>,
    /// Intermediate data that one of the levels' passes leaves for the next.
    curves: Buffer,
}

enum BuildPath {
    Binned { bins: Bins, kernel: Kernel, label: &'static str },
    Raster(Raster),
}

/// Draws the casters twice: for the ends of each texel's range, if the technique needs them, and for the texel's sums.
struct Raster {
    labels: [&'static str; 2],
    quads: CasterQuads,
    ends: Buffer,
    draw_ends: Option<Kernel<QuadsPush>>,
    targets: Vec<Image>,
    draw: Kernel<QuadsPush>,
    pack: Kernel,
}

/// Returns the limit on color targets that `sums` sums require.
pub fn sum_targets(sums: u32) -> Limit {
    Limit::color_attachments(sums.div_ceil(4).next_power_of_two().min(MOST_TARGETS).into())
}

impl Sums {
    /// Creates the buffer of the texels of all maps, as words, and the passes that fill it. With `skip`, casters in the
    /// shadow of meshes are skipped. `reach` is the distance from a tile, in texels, within which look-ups read the
    /// tile.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out, [`Error::Refused`] if the device supports too few targets.
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        way: TexelWay,
        (skip, reach): (bool, u32),
        kernels: &SumKernels,
        constants: &Constants,
    ) -> Result<Self> {
        let label = kernels.labels[0];
        let count = kernels.level_count;
        let bytes = 4 * u64::from(kernels.words) * (maps.texels() + coarser_texels(maps, count));
        let words = Buffer::new(context, label, bytes, Memory::Device)?;
        let way = match way {
            TexelWay::Raster => BuildPath::Raster(Raster::new(context, world, maps, &words, kernels, constants)?),
            TexelWay::Binned => {
                let what = Use { entries: Entries::Summed, skip, reach, parts: [1, 1], area: false, blocks: None };
                let bins = Bins::new(context, world, maps, what)?;
                let storage = set::MapsSums { sum_words: &words }.bind(context, label)?;
                let sets = [maps.scene(), bins.set(), &storage];
                let kernel = Kernel::compute(context, kernels.binned, &sets, constants)?;
                BuildPath::Binned { bins, kernel, label }
            }
        };
        let label = kernels.labels[3];
        let bytes = 4 * u64::from(kernels.level_cells) * carried_texels(maps, count);
        let curves = Buffer::new(context, label, bytes.max(4), Memory::Device)?;
        let sets =
            [maps.scene(), &set::MapsLevelSums { sum_words: &words, level_curves: &curves }.bind(context, label)?];
        let levels = Levels::new(context, label, maps, count, kernels.levels, &sets, constants)?;
        Ok(Self { words, way, levels, curves })
    }
}

impl Raster {
    fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        words: &Buffer,
        kernels: &SumKernels,
        constants: &Constants,
    ) -> Result<Self> {
        let [_, label, packs, _] = kernels.labels;
        let targets = sum_targets(kernels.sums);
        if let Some(needs) = targets.lacks(context.features(), "") {
            return Err(Error::Refused(needs));
        }
        let count = targets.least as u32;
        // Half-float sums are rounded at each caster, so full floats are preferred.
        let float32 = context.features().float32_blend;
        let format = if float32 { Format::R32G32B32A32_SFLOAT } else { Format::R16G16B16A16_SFLOAT };
        let size = stacked(context, label, maps.size(), maps.count())?;
        let targets: Vec<_> =
            (0..count).map(|_| Image::new(context, label, format, size, ImageUse::Color)).collect::<Result<_>>()?;
        // If the range is the map's, nothing reads the ends.
        let has_ends = constants.word(SUM_RANGE.id()) != Some(0);
        let ends = Buffer::new(context, "sums.ends", if has_ends { 8 * maps.texels() } else { 4 }, Memory::Device)?;
        let quads = CasterQuads::new(context, world, maps, DrawingOrder::Index, None)?;
        let set = set::MapsEnds { ends: &ends }.bind(context, "sums.ends")?;
        let drawn = |fragment: &Shader, colors: &[(Format, Blend)]| {
            quads.kernel(context, maps, fragment, colors, &[&set], constants)
        };
        let draw_ends = has_ends.then(|| drawn(&shaders::sums::ENDS_FRAG, &[])).transpose()?;
        let draw = drawn(kernels.raster[count.ilog2() as usize], &vec![(format, Blend::Add); count as usize])?;
        let target = |i: usize| &targets[i % targets.len()];
        let read = set::MapsDrawnSums {
            ends: &ends,
            drawn_0: target(0),
            drawn_1: target(1),
            drawn_2: target(2),
            drawn_3: target(3),
            drawn_4: target(4),
            drawn_5: target(5),
            drawn_6: target(6),
            drawn_7: target(7),
        };
        let read = read.bind(context, packs)?;
        let storage = set::MapsSums { sum_words: words }.bind(context, packs)?;
        let pack = Kernel::compute(context, kernels.pack, &[maps.scene(), &read, &storage], constants)?;
        Ok(Self { labels: [label, packs], quads, ends, draw_ends, targets, draw, pack })
    }

    fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps) {
        let size = self.targets.first().map_or([1, 1], Image::size);
        let all = 0..maps.count();
        self.quads.record(commands, world, maps, None);
        if let Some(kernel) = &self.draw_ends {
            commands.pass("sums.clear", |pass| pass.fill(&self.ends, 0));
            commands.pass("sums.ends", |pass| {
                pass.render(size, &[], None, |draw| self.quads.draw(draw, kernel, all.clone(), 0, 0));
            });
        }
        let [label, packs] = self.labels;
        commands.pass(label, |pass| {
            let targets: Vec<_> = self.targets.iter().map(|image| Target { image, clear: Some([0.0; 4]) }).collect();
            pass.render(size, &targets, None, |draw| self.quads.draw(draw, &self.draw, all, 0, 0));
        });
        let [x, y] = maps.tiles();
        commands.pass(packs, |pass| pass.dispatch(&self.pack, &(), [x, y, maps.count()]));
    }

    fn bytes(&self) -> u64 {
        self.quads.bytes() + self.ends.bytes() + self.targets.iter().map(Image::bytes).sum::<u64>()
    }
}

impl TexelPasses for Sums {
    fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps) -> Result<()> {
        match &mut self.way {
            BuildPath::Raster(raster) => raster.record(commands, world, maps),
            BuildPath::Binned { bins, kernel, label } => {
                bins.record(commands, world);
                commands.pass(label, |pass| bins.per_part(pass, kernel, &()));
            }
        }
        if let Some(levels) = &self.levels {
            levels.record(commands);
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<bool> {
        if let BuildPath::Binned { bins, .. } = &mut self.way { bins.settle(frame) } else { Ok(false) }
    }

    fn bins(&self) -> Option<&Bins> {
        if let BuildPath::Binned { bins, .. } = &self.way { Some(bins) } else { None }
    }

    fn kept(&self) -> Vec<Resource> {
        vec![Resource::Buffer(self.words.clone())]
    }

    fn bytes(&self) -> [u64; 2] {
        let drawn = if let BuildPath::Raster(raster) = &self.way { raster.bytes() } else { 0 };
        [self.words.bytes(), drawn + self.curves.bytes()]
    }
}
