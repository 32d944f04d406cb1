//! Code shared by techniques that store one texel per ray, built by blending or by one workgroup per tile. They differ only in their
//! shaders and in the texel format.

use super::keys::word;
use super::settings::Setting;
use super::{Answer, BuildStatus, Entry, Facts, Inspect, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::maps::{Filter, Map, Maps, OpaqueMaps, OpaqueWay, TexelPasses, TexelWay, Texels};
use crate::shaders::Folder;
use crate::shaders::constant::LEVELS;
use crate::world::{BuildStamp, Parts, World};

word!(TexelWay { Raster = "raster", Binned = "binned" });

/// The name of the path that draws casters.
pub const RASTER: &str = "raster";
/// The name of the path that builds tile by tile.
pub const BINNED: &str = "binned";

/// Setting for the path.
pub const PATH: Setting<Option<TexelWay>> =
    Setting::auto("casters are drawn and blended, or each texel written once; auto: binned where the device can");

/// Declares the settings of such a technique: the shared ones and its own.
#[macro_export]
#[doc(hidden)]
macro_rules! __texel_settings {
    ($($(#[$meta:meta])* $field:ident: $type:ty = $setting:expr;)*) => {
        $crate::technique::map_settings::map_settings! {
            /// Settings of the technique.
            #[derive(Copy)]
            pub struct Settings {
                /// How the map is built: casters are drawn and blended, or one workgroup per tile writes each texel once. `None`: one
                /// workgroup per tile, if the device supports it.
                path: Option<$crate::maps::TexelWay> = $crate::technique::texel_map::PATH;
                $($(#[$meta])* $field: $type = $setting;)*
                /// Texels per side of a light's map, 1 to 16,384.
                size: u32 = $crate::technique::settings::SIZE;
                /// Number of levels of detail, 1 to 12, including the map itself; each has half as many texels per side as the one before.
                /// Look-ups for pixels wider than a texel read the coarser levels.
                levels: u32 = $crate::technique::settings::LEVELS;
            }
        }

        impl Settings {
            /// Returns the settings that all such techniques share. `constants`: specialization constants of this technique's shaders.
            fn common(&self, constants: $crate::gpu::Constants) -> $crate::technique::texel_map::Common {
                let Self { path, size, levels, opaque, skip, .. } = *self;
                let filter = self.filter();
                $crate::technique::texel_map::Common { path, size, levels, filter, opaque, skip, constants }
            }
        }
    };
}

pub use crate::__texel_settings as texel_settings;

/// Settings that all such techniques share.
pub struct Common {
    pub path: Option<TexelWay>,
    pub size: u32,
    pub levels: u32,
    pub filter: Filter,
    pub opaque: Option<OpaqueWay>,
    pub skip: bool,
    /// Specialization constants of the technique's shaders, except for the filter and the levels.
    pub constants: Constants,
}

/// A technique that stores one texel per ray, opened for one world with settings `S`. `P` builds and holds the texels.
pub struct TexelMap<S, P = Texels> {
    /// Settings that the technique was opened with.
    pub settings: S,
    /// Texels that look-ups fetch.
    pub texels: P,
    written: BuildStamp,
    maps: Maps,
    look_up: Bindings,
    constants: Constants,
    folder: Folder,
    way: TexelWay,
    reason: String,
}

impl<S: Clone, P: TexelPasses> TexelMap<S, P> {
    /// Opens the technique of `entry`. `make` creates its passes from the maps, the way in which they are built, a pair (whether casters
    /// are skipped, how far look-ups reach), and the constants. The look-up is visibility.glsl of `folder`; from binding 3 on, it reads the
    /// output of the passes.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] if the device lacks what the path needs, [`crate::Error::Gpu`] if memory runs out.
    pub(super) fn open(
        context: &Context,
        world: &World,
        entry: &Entry,
        (settings, common): (&S, Common),
        folder: Folder,
        make: impl FnOnce(&Maps, TexelWay, (bool, u32), &Constants) -> Result<P>,
    ) -> Result<Self> {
        let Common { path, size, levels, filter, opaque, skip, constants } = common;
        filter.check(world, size)?;
        let binned = entry.require(context, BINNED);
        let (way, reason) = match (path, &binned) {
            (Some(way), _) => (way, "asked for".to_owned()),
            (None, Ok(())) => (TexelWay::Binned, format!("auto: {} device", context.features().kind)),
            (None, Err(missing)) => (TexelWay::Raster, format!("auto: binned is {missing}")),
        };
        if way == TexelWay::Binned {
            binned?;
        }
        let maps = Maps::new(context, world, size, OpaqueMaps::shared(opaque))?;
        let constants = filter.constants(constants).and(&world.constants()).set(LEVELS, levels);
        let texels = make(&maps, way, (skip, filter.reach()), &constants)?;
        let look_up = maps.look_up(context, folder.name, &texels.kept())?;
        // The binned path leaves out casters hidden behind meshes; the raster path draws them too.
        let of_meshes = if way == TexelWay::Binned { Maps::OPAQUE } else { Maps::VOLUME };
        let written = BuildStamp::of(Maps::VOLUME.and(of_meshes));
        Ok(Self { settings: settings.clone(), texels, written, maps, look_up, constants, folder, way, reason })
    }
}

impl<S: Send, P: TexelPasses> Technique for TexelMap<S, P> {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.written.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        if self.written.make(world) { self.texels.record(commands, world, &self.maps) } else { Ok(()) }
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.texels.settle(frame)?;
        let grew = self.maps.settle(frame, grew)?;
        if grew {
            self.written.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(self.folder, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl<S: Send, P: TexelPasses> Inspect for TexelMap<S, P> {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        let bins = self.texels.bins();
        let [resident, transient] = self.texels.bytes();
        Ok(Facts {
            path: if self.way == TexelWay::Raster { RASTER } else { BINNED },
            reason: self.reason.clone(),
            bytes_resident: resident + self.maps.opaque_image().bytes(),
            bytes_transient: transient
                + bins.map_or(0, |b| b.counts.bytes() + b.bytes_transient())
                + self.maps.opaque_bytes_transient(),
            counters: bins.map_or(Ok(Default::default()), |b| b.counters())?,
            ..Facts::default()
        })
    }
}
