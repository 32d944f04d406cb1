//! Particle shadow maps: the light left behind each slice of a volume. Source: Bavoil and Jansen 2013.
//!
//! Each path has its own file: `raster`, `fused`.
//!
//! A caster's whole optical depth goes to the slice of its centre or, with `assign=split`, to the two slices around its centre
//! (glsl/technique/psm/place.glsl). glsl/technique/psm/visibility.glsl defines the depths that look-ups assume for the slices. The same
//! input gives the same bytes on the same device.
//!
//! A volume stores the light left behind each slice, for smoke in many thin layers.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, smoke};
//! # on_a_device(|context| {
//! use gobo::query::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &smoke())?;
//! let mut psm = open(context, &world, &parse("psm:slices=64,size=64", &[])?[0])?;
//! psm.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&psm.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.99 && (below - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```

mod fused;
mod raster;
mod volume;

pub use self::raster::Route;
pub use self::volume::{Assign, Coverage, Storage};

use self::fused::{Fused, OTHER_BYTES, SLICE_BYTES};
use self::raster::Raster;
use self::volume::Volume;
use super::keys::{Name, word_of, words};
use super::map_settings::map_settings;
use super::promises::{EIGHT_BITS, FILTERED, ROUNDING};
use super::settings::{Keyed, Setting};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Commands, Constants, Context, Image, Limit, Requirement, Resource};
use crate::maps::{Bins, MANY_CASTERS, Map, Maps, OpaqueMaps};
use crate::shaders::constant::FETCH_AHEAD;
use crate::shaders::folder;
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};

words! {
    /// How the volume is built.
    pub enum BuildPath {
        /// Drawn and propagated.
        Raster = "raster",
        /// Summed tile by tile.
        Fused = "fused",
    }
}

map_settings! {
    /// Settings of particle shadow maps. `coverage` and `route` belong to the raster path: [`Psm::new`] refuses them with the fused path.
    #[derive(Copy)]
    pub struct Settings {
        /// How the volume is built. `None`: summed tile by tile if the device supports it.
        path: Option<BuildPath> = Setting::auto("auto: fused where the device can");
        /// Texels per side of a light's map, 8 to 512.
        size: u32 = Setting::number("256", 8, 512, "texels per side of a light's map");
        /// Number of slices of the volume, four per texel: 4 to 256, a multiple of 4.
        slices: u32 = Setting::multiple("256", [4, 4, 256], "slices of the volume, four per texel");
        /// What the volume holds: transmittances in 8 bits in Bavoil and Jansen 2013.
        storage: Storage = Setting::word(
            "rgba8", "multiply transmittances in 8 bits (as published) or half floats, or add optical depths in half floats");
        /// Which slices a caster is added to: the slice of its centre in Bavoil and Jansen 2013.
        assign: Assign = Setting::word(
            "nearest", "a caster goes to its slice (as published), or is shared by the two about its centre");
        /// How the raster path finds rays without casters, so that its last pass skips them.
        coverage: Coverage = Setting::word(
            "off", "rays without casters are not propagated (raster): known from a second viewport (as published), from bins");
        /// The shader that chooses a caster's layer. `None`: the vertex shader if the device supports that, else the geometry shader.
        route: Option<Route> = Setting::auto(
            "the shader that chooses a caster's layer (raster); auto: vertex where it can, else geometry");
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "psm",
    about: "particle shadow maps: what is left of the light behind each slice of a volume (Bavoil and Jansen 2013)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: FUSED, requires: &[] }, Path { name: RASTER, requires: &[Requirement::Layers] }],
    plan: |spec, path| PathPlan { path, limits: limits(&spec.settings(), path), promises: promises(path) },
    runs: Runs {
        usual: &["path=fused"],
        usual_on_cpu: &["size=128,path=fused"],
        compare: &["path=raster|fused"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &[
            "size=32,slices=64,path=raster|fused",
            "size=32,slices=64,path=raster,storage=rgba16f,coverage=viewport,route=geometry",
            "size=32,slices=64,path=raster,storage=optical-depth,coverage=tiles,route=vertex",
            "size=32,slices=64,path=fused,assign=split",
        ],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Psm::new(context, world, &spec.settings())?)),
};

/// A sphere's whole optical depth goes to one or two slices, so depths may be wrong by up to the sphere's size: no mean error is promised.
fn promises(path: &Path) -> Promises {
    let in_hardware = Promises { rise: Some(ROUNDING + FILTERED), ..Promises::OF_DEPTH };
    if path.is(BuildPath::Fused) {
        // 8-bit values are quantized once.
        Promises { tail: Some(EIGHT_BITS), order: Some(0.0), ..in_hardware }
    } else {
        // Blending quantizes the volume again at each sphere.
        in_hardware
    }
}

const FUSED: &str = "fused";
const RASTER: &str = "raster";

/// The build state of the chosen path.
enum Build {
    Raster(Box<Raster>),
    Fused(Box<Fused>),
}

/// The technique, opened for one world.
pub struct Psm {
    /// Four slices per texel, map by map.
    pub volume: Image,
    maps: Maps,
    build: Build,
    built: BuildStamp,
    look_up: Bindings,
    constants: Constants,
    reason: String,
}

impl Psm {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light; [`Error::Refused`]
    /// if settings cannot be combined, or the device lacks what the path needs; [`Error::Gpu`] if the volume is larger than the device
    /// allows or memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        Self::with_threads(context, world, settings, fused::threads(context), world.caster_capacity() >= MANY_CASTERS)
    }

    /// Same as [`Psm::new`], but the caller makes two choices for path=fused. `fused_threads`: threads per workgroup, a multiple of 16.
    /// `fetch_ahead`: whether casters are fetched ahead.
    ///
    /// # Errors
    /// Same as [`Psm::new`].
    pub fn with_threads(
        context: &Context,
        world: &World,
        settings: &Settings,
        fused_threads: u32,
        fetch_ahead: bool,
    ) -> Result<Self> {
        settings.check()?;
        let layout = Volume::of(settings);
        let (way, reason) = choose(context, settings)?;
        let has = context.features().max_compute_workgroup_threads;
        if way == BuildPath::Fused && fused_threads > has {
            let needs = format!("maxComputeWorkGroupInvocations of at least {fused_threads} (this device has {has})");
            return Err(Error::Refused(needs.into()));
        }
        layout.filter.check(world, layout.size)?;
        let maps = Maps::new(context, world, layout.size, OpaqueMaps::shared(settings.opaque))?;
        let volume = layout.image(context, maps.count(), way == BuildPath::Raster)?;
        let constants = layout.constants(world);
        let build = match way {
            BuildPath::Raster => {
                let raster = Raster::new(context, world, &maps, settings.route, &layout, &volume, &constants)?;
                Build::Raster(Box::new(raster))
            }
            BuildPath::Fused => {
                let layout = (&layout, settings.skip);
                let constants = constants.clone().set(FETCH_AHEAD, fetch_ahead);
                let fused = Fused::new(context, world, &maps, layout, &volume, &constants, fused_threads)?;
                Build::Fused(Box::new(fused))
            }
        };
        let more = [Resource::Sampled(volume.clone(), layout.empty().1)];
        let look_up = maps.look_up(context, "psm.look_up", &more)?;
        // The fused path leaves out casters hidden behind meshes; the raster path draws them too.
        let of_meshes = if way == BuildPath::Fused { Maps::OPAQUE } else { Maps::VOLUME };
        let built = BuildStamp::of(Maps::VOLUME.and(of_meshes));
        Ok(Self { volume, maps, build, built, look_up, constants, reason })
    }

    /// Records only the first pass of path=raster; does nothing for path=fused.
    pub fn clear(&self, commands: &mut Commands) {
        if let Build::Raster(raster) = &self.build {
            raster.clear(commands);
        }
    }

    /// Records only the second pass of path=raster; does nothing for path=fused.
    pub fn voxelize(&self, commands: &mut Commands) {
        if let Build::Raster(raster) = &self.build {
            raster.voxelize(commands, &self.maps);
        }
    }

    /// Records only the third pass of path=raster; does nothing for path=fused.
    pub fn propagate(&self, commands: &mut Commands) {
        if let Build::Raster(raster) = &self.build {
            raster.propagate(commands, &self.maps);
        }
    }

    fn bins(&self) -> Option<&Bins> {
        match &self.build {
            Build::Raster(raster) => raster.bins.as_ref(),
            Build::Fused(fused) => Some(&fused.bins),
        }
    }
}

/// Returns the limit on shared memory for a workgroup of the fused path.
fn room(settings: &Settings) -> Limit {
    Limit::shared_memory((settings.slices * SLICE_BYTES + OTHER_BYTES).into())
}

fn limits(settings: &Settings, path: &Path) -> Vec<Limit> {
    let layers = u64::from(Volume::of(settings).layers());
    let image = Limit::image_3d(layers.max(settings.size.into()));
    if path.is(BuildPath::Fused) { vec![room(settings), image] } else { vec![image, Limit::layers(layers)] }
}

/// Chooses the path and gives the reason. `auto` chooses the fused path wherever it runs, since it writes each voxel once and blends
/// nothing.
fn choose(context: &Context, settings: &Settings) -> Result<(BuildPath, String)> {
    let lacks_room = room(settings).lacks(context.features(), " for as many slices");
    let coverage = Some(settings.coverage).filter(|coverage| *coverage != Coverage::Off);
    let wants_raster = coverage.map(|coverage| format!("coverage={}", word_of(coverage)));
    let wants_raster = wants_raster.or(settings.route.map(|route| format!("route={}", word_of(route))));
    let (way, reason) = match (settings.path, &lacks_room, wants_raster) {
        (Some(BuildPath::Raster), ..) => (BuildPath::Raster, "asked for".to_owned()),
        (Some(BuildPath::Fused), Some(missing), _) => return Err(Error::Refused(missing.clone())),
        (Some(BuildPath::Fused), _, Some(wants)) => {
            let needs = format!("path=raster: {wants} has no meaning for path=fused");
            return Err(Error::Refused(needs.into()));
        }
        (Some(BuildPath::Fused), ..) => (BuildPath::Fused, "asked for".to_owned()),
        (None, _, Some(wants)) => (BuildPath::Raster, format!("auto: {wants}")),
        (None, Some(missing), _) => (BuildPath::Raster, format!("auto: fused needs {missing}")),
        (None, ..) => (BuildPath::Fused, format!("auto: {} device", context.features().kind)),
    };
    ENTRY.require(context, if way == BuildPath::Raster { RASTER } else { FUSED })?;
    Ok((way, reason))
}

impl Technique for Psm {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.built.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        if !self.built.make(world) {
            return Ok(());
        }
        match &mut self.build {
            Build::Raster(raster) => raster.record(commands, world, &self.maps),
            Build::Fused(fused) => fused.record(commands, world),
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = if let Build::Fused(fused) = &mut self.build { fused.bins.settle(frame)? } else { false };
        let grew = self.maps.settle(frame, grew)?;
        if grew {
            self.built.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::PSM, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Psm {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        let bins = self.bins();
        let counters = match &self.build {
            Build::Fused(fused) => fused.bins.counters()?,
            Build::Raster(_) => Default::default(),
        };
        Ok(Facts {
            path: if matches!(self.build, Build::Raster(_)) { RASTER } else { FUSED },
            reason: self.reason.clone(),
            bytes_resident: self.volume.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: bins.map_or(0, |b| b.counts.bytes() + b.bytes_transient())
                + self.maps.opaque_bytes_transient(),
            counters,
            ..Facts::default()
        })
    }
}
