//! What all techniques are that keep one texel a ray, which blending makes, or one workgroup a tile: they differ in their
//! shaders alone.

use super::keys::{Key, SIZE, SKIP, Values, Word, filter, opaque, word};
use super::{Answer, Facts, Settled, Spec, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Resource};
use crate::maps::{Map, Maps, TexelKernels, TexelWay, Texels};
use crate::shaders::Folder;
use crate::shaders::constant::STRANDS;
use crate::world::{Made, Parts, World};

word!(TexelWay { Raster = "raster", Binned = "binned" });

/// The names of the paths.
pub const RASTER: &str = "raster";
/// As above.
pub const BINNED: &str = "binned";

/// The key of the path.
pub const PATH: Key = Key {
    name: "path",
    values: Values::OneOf(TexelWay::WORDS),
    default: "auto",
    about: "casters are drawn and blended, or each texel written once; auto: binned where the device can",
};

/// A technique of one texel a ray, opened for one world.
pub struct TexelMap {
    /// What look-ups fetch.
    pub texels: Texels,
    written: Made,
    maps: Maps,
    look_up: Bindings,
    constants: Constants,
    folder: Folder,
    way: TexelWay,
    reason: String,
}

impl TexelMap {
    /// Opens the path that `spec` names; `kernels` are its shaders, glsl/`folder`/visibility.glsl its look-up, with the image
    /// at binding 3.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what the path needs, [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, spec: &Spec, folder: Folder, kernels: &TexelKernels) -> Result<Self> {
        let (size, filter) = (spec.number(SIZE.name), filter(spec));
        filter.check(world.scene(), size)?;
        let binned = spec.entry.require(context, BINNED);
        let (way, reason) = match (spec.word(PATH.name), &binned) {
            (Some(way), _) => (way, "asked for".to_owned()),
            (None, Ok(())) => (TexelWay::Binned, format!("auto: {} device", context.features().kind)),
            (None, Err(missing)) => (TexelWay::Raster, format!("auto: binned is {missing}")),
        };
        if way == TexelWay::Binned {
            binned?;
        }
        let maps = Maps::new(context, world, size, opaque(spec))?;
        let constants = filter.constants(Constants::new()).set(STRANDS, world.has_strands());
        let skip = (spec.is_on(SKIP.name), filter.reach());
        let texels = Texels::new(context, world, &maps, way, skip, kernels, &constants)?;
        let look_up = maps.look_up(context, folder.name, &[Resource::Texture(texels.image.clone())])?;
        // What is hidden behind meshes is not written; what is drawn is drawn behind them too.
        let of_meshes = if way == TexelWay::Binned { Maps::OPAQUE } else { Maps::VOLUME };
        let written = Made::of(Maps::VOLUME.and(of_meshes));
        Ok(Self { texels, written, maps, look_up, constants, folder, way, reason })
    }
}

impl Technique for TexelMap {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.written.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world);
        if self.written.make(world) { self.texels.record(commands, world, &self.maps) } else { Ok(()) }
    }

    fn settle(&mut self, frame: u64) -> Result<Settled> {
        let grew = self.texels.settle(frame)?;
        let grew = self.maps.settle(frame, grew)?;
        if grew {
            self.written.forget();
        }
        Ok(Settled::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer { folder: self.folder, bindings: &self.look_up, constants: &self.constants }
    }

    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        let bins = self.texels.bins();
        Ok(Facts {
            path: if self.way == TexelWay::Raster { RASTER } else { BINNED },
            reason: self.reason.clone(),
            bytes_resident: self.texels.image.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: bins.map_or(0, |b| b.counts.bytes() + b.bytes_transient())
                + self.maps.opaque_bytes_transient(),
            counters: bins.map_or(Ok(Default::default()), |b| b.counters())?,
            ..Facts::default()
        })
    }
}
