//! An image with one texel per ray, built by blending or by one workgroup per tile, for techniques whose data fits into
//! a texel.

use super::{Bins, CasterQuads, DrawingOrder, Entries, Levels, Maps, QuadsPush, Use, coarser_texels, stacked};
use crate::Result;
use crate::gpu::{
    Blend, Buffer, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Memory, Resource, Shader, Target,
};
use crate::shaders::set;
use crate::world::World;

/// How the texels are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelWay {
    /// By drawing and blending the casters.
    Raster,
    /// By one workgroup of 8×8 threads per tile, which loops over the tile's casters.
    Binned,
}

/// Shaders of the passes that build texels.
pub struct TexelKernels<'a> {
    /// Labels of the raster pass, the binned pass, and the passes that build levels of detail.
    pub labels: [&'static str; 3],
    /// Format of the image.
    pub format: Format,
    /// Draws a caster (maps/caster_quads.glsl).
    pub fragment: &'a Shader,
    /// How a caster is blended with those before it.
    pub blend: Blend,
    /// The image's value before the first caster.
    pub empty: [f32; 4],
    /// Writes a tile's texels: maps/bins/part.glsl, with the image as set 2.
    pub binned: &'a Shader,
    /// Builds levels of detail: maps/image_levels.glsl.
    pub levels: &'a Shader,
    /// Number of levels, including the map itself. The constants hold it too.
    pub level_count: u32,
    /// Number of words per texel of a coarser level.
    pub level_words: u32,
}

/// Passes that build the texels of all maps, drawn or binned, and the resources that hold them.
pub trait TexelPasses: Send {
    /// Records the passes that build the texels for the current world.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps) -> Result<()>;

    /// Returns whether the bins had to grow after frame `frame`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if there is no room for larger bins.
    fn settle(&mut self, frame: u64) -> Result<bool>;

    /// Returns the bins, if the texels are built from bins.
    fn bins(&self) -> Option<&Bins>;

    /// Returns the bindings of look-ups, from binding 3 on.
    fn kept(&self) -> Vec<Resource>;

    /// Returns the bytes of the resources that look-ups bind, and the bytes needed only while building, without the
    /// bins.
    fn bytes(&self) -> [u64; 2];
}

/// The image with the stacked maps, and the passes that build it.
pub struct Texels {
    /// The image that look-ups bind.
    pub image: Image,
    /// The texels of coarser levels (maps/image_levels.glsl); without such levels, a buffer that nothing reads.
    pub coarser: Buffer,
    levels: Option<Levels>,
    way: BuildPath,
}

enum BuildPath {
    Raster { quads: CasterQuads, draw: Kernel<QuadsPush>, empty: [f32; 4], label: &'static str },
    Binned { bins: Bins, kernel: Kernel, label: &'static str },
}

impl Texels {
    /// Creates the image of all maps and the passes that fill it. With `skip`, casters in the shadow of meshes are
    /// skipped. `reach` is the distance from a tile, in texels, within which look-ups read the tile.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out or the maps do not fit into one image.
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        way: TexelWay,
        (skip, reach): (bool, u32),
        kernels: &TexelKernels,
        constants: &Constants,
    ) -> Result<Self> {
        let [raster, binned, labelled] = kernels.labels;
        let size = stacked(context, raster, maps.size(), maps.count())?;
        let usage = if way == TexelWay::Raster { ImageUse::Color } else { ImageUse::Storage };
        let image = Image::new(context, raster, kernels.format, size, usage)?;
        let way = match way {
            TexelWay::Raster => {
                let quads = CasterQuads::new(context, world, maps, DrawingOrder::Index, None)?;
                let colors = [(kernels.format, kernels.blend)];
                let draw = quads.kernel(context, maps, kernels.fragment, &colors, &[], constants)?;
                BuildPath::Raster { quads, draw, empty: kernels.empty, label: raster }
            }
            TexelWay::Binned => {
                let bins = Bins::new(
                    context,
                    world,
                    maps,
                    Use { entries: Entries::Summed, skip, reach, parts: [1, 1], area: false, blocks: None },
                )?;
                let storage = set::MapsTexels { texels: &image }.bind(context, binned)?;
                let sets = [maps.scene(), bins.set(), &storage];
                let kernel = Kernel::compute(context, kernels.binned, &sets, constants)?;
                BuildPath::Binned { bins, kernel, label: binned }
            }
        };
        let words = u64::from(kernels.level_words) * coarser_texels(maps, kernels.level_count);
        let coarser = Buffer::new(context, labelled, 4 * words.max(1), Memory::Device)?;
        let set = set::MapsImageLevels { texels: &image, level_words: &coarser }.bind(context, labelled)?;
        let sets = [maps.scene(), &set];
        let levels = Levels::new(context, labelled, maps, kernels.level_count, kernels.levels, &sets, constants)?;
        Ok(Self { image, coarser, levels, way })
    }
}

impl TexelPasses for Texels {
    fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps) -> Result<()> {
        match &mut self.way {
            BuildPath::Raster { quads, draw: kernel, empty, label } => {
                quads.record(commands, world, maps, None);
                commands.pass(label, |pass| {
                    let target = Target { image: &self.image, clear: Some(*empty) };
                    pass.render(self.image.size(), &[target], None, |draw| {
                        quads.draw(draw, kernel, 0..maps.count(), 0, 0)
                    });
                });
            }
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
        vec![Resource::Texture(self.image.clone()), Resource::Buffer(self.coarser.clone())]
    }

    fn bytes(&self) -> [u64; 2] {
        [self.image.bytes() + if self.levels.is_some() { self.coarser.bytes() } else { 0 }, 0]
    }
}
