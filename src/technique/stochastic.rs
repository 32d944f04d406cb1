//! Stochastic shadow maps: a few rays per texel, each of which ends at random where light would. Sources: Enderton et al. 2010; hashed
//! alpha in Filament and other engines.
//!
//! Results are right on average but noisy: averages over texels or frames converge to the truth.
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
//! let mut stochastic = open(context, &world, &parse("stochastic:samples=64,sampling=stratified,size=64", &[])?[0])?;
//! stochastic.build(&world)?;
//! // Above the smoke and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&stochastic.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && (below - (-2f32).exp()).abs() < 1.0 / 64.0);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::map_settings::map_settings;
use super::settings::{Keyed, SIZE, Setting};
use super::texel_map::{BINNED, RASTER};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Limit, Memory, Requirement};
use crate::maps::{Bins, CasterQuads, DrawingOrder, Entries, Map, Maps, OpaqueMaps, QuadsPush, TexelWay, Use, stacked};
use crate::shaders::constant::{SAMPLES, SAMPLING};
use crate::shaders::{folder, set, stochastic as shaders};
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};

words! {
    /// How samples are drawn.
    pub enum Sampling {
        /// Independently, as in Enderton et al. 2010.
        Plain = "plain",
        /// At even quantiles of the transmittance: the number of samples that end in front of a depth is right to within one.
        Stratified = "stratified",
        /// From noise that all casters of a texel share, as engines do.
        Hash = "hash",
    }
}

map_settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// How the map is built: casters are drawn, or one workgroup per tile builds it. `None`: one workgroup per tile.
        path: Option<TexelWay> = Setting::auto("casters are drawn, or a workgroup takes each tile's; auto: binned");
        /// Texels per side of a light's map, 1 to 16,384.
        size: u32 = SIZE;
        /// Number of samples per texel: 1, 4, 8, 16, 32 or 64.
        samples: u32 = Setting::one_of("16", &["1", "4", "8", "16", "32", "64"], "rays of each texel, 4 bytes each");
        /// How samples are drawn.
        sampling: Sampling = Setting::word(
            "plain", "each ray by itself (Enderton 2010); even quantiles, with path=binned; or engines' hashed alpha, which is biased");
    }
}

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "stochastic",
    about: "a few rays per texel that end by chance where light would: no bias, and noise (Enderton et al. 2010)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: BINNED, requires: &[] }, Path { name: RASTER, requires: &[Requirement::FragmentStores] }],
    plan: |spec, path| {
        let settings: Settings = spec.settings();
        let bytes = 4 * u64::from(settings.samples) * u64::from(settings.size).pow(2);
        PathPlan { path, limits: vec![Limit::buffer_range(bytes)], promises: promises(&settings) }
    },
    runs: Runs {
        usual: &["path=binned,sampling=stratified,samples=16"],
        usual_on_cpu: &["size=128,path=binned,sampling=plain,samples=16"],
        compare: &[
            "path=binned,sampling=plain|stratified,samples=4|8|16|64",
            "path=binned,sampling=hash,samples=1|16,filter=bilinear|gaussian",
            "path=raster",
        ],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,path=raster|binned", "size=32,path=binned,sampling=stratified|hash"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Stochastic::new(context, world, &spec.settings())?)),
};

/// A sample that ends at a depth counts at all greater depths, so transmittance never rises along a ray. Samples are right on average,
/// which promises nothing about a single picture.
fn promises(settings: &Settings) -> Promises {
    let even = settings.sampling == Sampling::Stratified;
    // At most one of the samples at quantiles ends too early or too late.
    let one = even.then(|| 1.0 / f64::from(settings.samples) + 1e-3);
    // Plain samples depend on the indices of casters, and so on the order of casters.
    let order = (settings.sampling != Sampling::Plain).then_some(0.0);
    Promises { tail: one, mean: one, order, step: None, ..Promises::OF_DEPTH }
}

enum BuildPath {
    Raster { quads: CasterQuads, draw: Kernel<QuadsPush> },
    Binned { bins: Bins, kernel: Kernel },
}

/// The technique, opened for one world.
pub struct Stochastic {
    maps: Maps,
    /// The depths at which samples end, in the layout of glsl/technique/stochastic/place.glsl.
    pub samples: Buffer,
    drawn: BuildStamp,
    way: BuildPath,
    label: &'static str,
    reason: &'static str,
    look_up: Bindings,
    constants: Constants,
}

impl Stochastic {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a setting's value is not allowed, or the filter is too wide for the faces of a point light;
    /// [`crate::Error::Refused`] if the device lacks what the path needs, or stratified samples are requested with path=raster;
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { path, size, samples: count, sampling, opaque, skip, .. } = *settings;
        let way = path.unwrap_or(TexelWay::Binned);
        if way == TexelWay::Raster {
            ENTRY.require(context, RASTER)?;
            if sampling == Sampling::Stratified {
                let needs = "path=binned for sampling=stratified: one draw knows nothing of the others".into();
                return Err(Error::Refused(needs));
            }
        }
        let filter = settings.filter();
        filter.check(world, size)?;
        let maps = Maps::new(context, world, size, OpaqueMaps::shared(opaque))?;
        let bytes = 4 * u64::from(count) * maps.texels();
        let samples = Buffer::new(context, "stochastic.samples", bytes, Memory::Device)?;
        let set = set::Stochastic { samples: &samples }.bind(context, "stochastic")?;
        let drawn_by = if sampling == Sampling::Hash { 1u32 } else { 0 };
        let constants = filter.constants(Constants::new()).set(SAMPLES, count);
        let passes = constants.clone().set(SAMPLING, drawn_by).and(&world.constants());
        let (label, shader) = match sampling {
            Sampling::Stratified => ("stochastic.quantiles", &shaders::QUANTILES),
            Sampling::Plain | Sampling::Hash => ("stochastic.nearest", &shaders::NEAREST),
        };
        let (label, way) = match way {
            TexelWay::Raster => {
                stacked(context, "stochastic.draw", maps.size(), maps.count())?;
                let quads = CasterQuads::new(context, world, &maps, DrawingOrder::Index, None)?;
                let draw = quads.kernel(context, &maps, &shaders::DRAW_FRAG, &[], &[&set], &passes)?;
                ("stochastic.draw", BuildPath::Raster { quads, draw })
            }
            TexelWay::Binned => {
                let reach = filter.reach();
                let what = Use { entries: Entries::Summed, skip, reach, parts: [1, 1], area: false, blocks: None };
                let bins = Bins::new(context, world, &maps, what)?;
                let kernel =
                    Kernel::compute(context, shader, &[maps.scene(), bins.set(), &set], &maps.colored(&passes))?;
                (label, BuildPath::Binned { bins, kernel })
            }
        };
        let more = set::StochasticLookUp { samples: &samples };
        let look_up = maps.look_up(context, "stochastic.look_up", &more.resources())?;
        // The binned path leaves out casters hidden behind meshes; the raster path draws them too.
        let of_meshes = if matches!(way, BuildPath::Binned { .. }) { Maps::OPAQUE } else { Maps::VOLUME };
        let drawn = BuildStamp::of(Maps::VOLUME.and(of_meshes));
        let reason = if path.is_some() { "asked for" } else { "auto: needs nothing that is optional" };
        Ok(Self { maps, samples, drawn, way, label, reason, look_up, constants })
    }

    fn draw(&mut self, commands: &mut Commands, world: &World) {
        match &mut self.way {
            BuildPath::Raster { quads, draw } => {
                quads.record(commands, world, &self.maps, None);
                commands.pass("stochastic.clear", |pass| pass.fill(&self.samples, u32::MAX));
                let [width, height] = self.maps.size();
                let count = self.maps.count();
                commands.pass(self.label, |pass| {
                    pass.render([width, height * count], &[], None, |d| quads.draw(d, draw, 0..count, 0, 0));
                });
            }
            BuildPath::Binned { bins, kernel } => {
                bins.record(commands, world);
                commands.pass(self.label, |pass| bins.per_part(pass, kernel, &()));
            }
        }
    }

    fn bins(&self) -> Option<&Bins> {
        if let BuildPath::Binned { bins, .. } = &self.way { Some(bins) } else { None }
    }
}

impl Technique for Stochastic {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.drawn.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        if self.drawn.make(world) {
            self.draw(commands, world);
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = if let BuildPath::Binned { bins, .. } = &mut self.way { bins.settle(frame)? } else { false };
        let grew = self.maps.settle(frame, grew)?;
        if grew {
            self.drawn.forget();
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::STOCHASTIC, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Stochastic {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        let bins = self.bins();
        Ok(Facts {
            path: if bins.is_some() { BINNED } else { RASTER },
            reason: self.reason.into(),
            bytes_resident: self.samples.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: bins.map_or(0, |b| b.counts.bytes() + b.bytes_transient())
                + self.maps.opaque_bytes_transient(),
            counters: bins.map_or(Ok(Default::default()), Bins::counters)?,
            ..Facts::default()
        })
    }
}
