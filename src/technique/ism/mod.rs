//! Imperfect shadow maps: meshes become points, which are splatted into a small map per virtual point light. Sources: Ritschel et al. 2008
//! (the maps), Tokuyoshi 2014 (culling of points); maps in shared memory are ours.
//!
//! One set of points on the meshes fills the small maps of hundreds of virtual lights.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use glam::DVec3;
//! use gobo::query::Query;
//! use gobo::scene::{Light, LightKind, Scene};
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let lamp = LightKind::Virtual { position: DVec3::Z * 4.0, normal: DVec3::NEG_Z, nearest: 0.1 };
//! let lights = vec![Light { kind: lamp, radiance: [1.0; 3], radius: f64::INFINITY }];
//! let world = World::new(context, &Scene { lights, ..solid() })?;
//! let mut ism = open(context, &world, &parse("ism:size=64,points=16384", &[])?[0])?;
//! ism.build(&world)?;
//! // Between the lamp and the box, and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&ism.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above > 0.5 && below < 0.5);
//! # Ok(()) });
//! ```

mod adapt;
mod atlas;
mod raster;
mod sample;
mod settings;

pub use settings::{BuildPath, Culling, Facing, Settings};

// Exported for the program and the tests.
#[doc(hidden)]
pub use self::{
    adapt::{CLUSTER, ClusterData},
    atlas::Atlas,
    sample::{PointData, PointsData, SUBSETS},
};

use self::adapt::Adapt;
use self::sample::Sample;
use super::keys::word_of;
use super::settings::Keyed;
use super::{Answer, Casts, Entry, Facts, Inspect, Lifetime, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::scene::{Light, LightKind, Resolution, View};
use crate::shaders::set;
use crate::shaders::{constant, folder};
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Need, Result};
use settings::PATHS;

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "ism",
    about: "points on the meshes, splatted into a small map of each virtual point light (Ritschel 2008, Tokuyoshi 2014)",
    casts: Casts::MESHES,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: PATHS,
    // Nothing is promised: points leave holes, and which triangles they fall on depends on the order of the triangles.
    plan: |spec, path| PathPlan { path, limits: settings::limits(&spec.settings(), path), promises: Promises::NONE },
    runs: Runs {
        stress_meshes: &["size=32,points=1024,path=tiled|atomic|quads|triangles,adaptive=on|off"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(Ism::new(context, world, &spec.settings())?)),
};

/// The technique, opened for one world.
pub struct Ism {
    settings: Settings,
    way: BuildPath,
    reason: &'static str,
    sample: Sample,
    sampled: BuildStamp,
    adapt: Option<Adapt>,
    atlas: Atlas,
    /// Number of maps that the lights had when the technique was opened.
    maps: usize,
    resolution: Vec<Resolution>,
    look_up: Bindings,
    constants: Constants,
}

/// Refuses all lights but virtual ones: a map covers one hemisphere, and only virtual lights stay within one. Each build checks this, since
/// a light may change its kind after the technique is opened.
fn lights_are_virtual(world: &World) -> Result<()> {
    match world.all_lights().iter().all(|light| matches!(light.kind, LightKind::Virtual { .. })) {
        true => Ok(()),
        false => Err(Error::Refused(Need::VirtualLights)),
    }
}

impl Ism {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed; [`Error::Refused`] if a light is not virtual, or the device has no room for a
    /// map; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        lights_are_virtual(world)?;
        let lack = settings.room().lacks(context.features(), "");
        let (way, reason) = match (settings.path, lack) {
            (Some(BuildPath::Tiled), Some(needs)) => return Err(Error::Refused(needs)),
            (Some(way), _) => (way, "asked for"),
            (None, None) => (BuildPath::Tiled, "a workgroup has room for a map"),
            (None, Some(_)) => (BuildPath::Atomic, "no workgroup has room for a map"),
        };
        let sample = Sample::new(context, world, settings.points, settings.adaptive)?;
        let adapt = settings.adaptive.then(|| Adapt::new(context, world, settings, &sample)).transpose()?;
        let atlas = Atlas::new(context, world, settings, way, &sample, adapt.as_ref())?;
        let look_up = set::IsmLookUp { lights: &world.lights, points: &sample.head, maps: &atlas.maps };
        let look_up = look_up.bind(context, "ism.look_up")?;
        let constants =
            Constants::new().set(constant::ISM_SIZE, settings.size).set(constant::ISM_STRIDE, atlas.stride());
        Ok(Self {
            settings: *settings,
            way,
            reason,
            sample,
            sampled: BuildStamp::of(Parts::MESHES),
            adapt,
            atlas,
            maps: world.map_count(),
            resolution: Vec::new(),
            look_up,
            constants,
        })
    }

    /// After a build, returns totals over all points, and the points, subset by subset.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn points(&self) -> Result<(PointsData, Vec<PointData>)> {
        let count = (SUBSETS * self.settings.points) as usize;
        Ok((self.sample.head.read(1)?[0], self.sample.pool.read(count)?))
    }

    /// With adaptive points, returns the clusters, and the points that each light uses, light by light. A point is one word: its index in
    /// the pool, plus 2^18 times the number of times that its cluster's area was halved.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read back.
    pub fn taken(&self) -> Result<Option<(Vec<ClusterData>, Vec<u32>)>> {
        let read = |adapt: &Adapt| {
            let clusters = adapt.clusters.read((SUBSETS * self.settings.points / CLUSTER) as usize)?;
            Ok((clusters, adapt.taken.read((adapt.taken.bytes() / 4) as usize)?))
        };
        self.adapt.as_ref().map(read).transpose()
    }

    /// Returns the maps.
    pub fn atlas(&self) -> &Atlas {
        &self.atlas
    }
}

/// Returns how finely each map resolves the meshes, which depends on its texels. A light has one map but six entries, one per face of the
/// cube around it, all of them equal. Empty if the host does not know the lights. Twin: light_visibility.
fn resolution(world: &World, settings: &Settings) -> Vec<Resolution> {
    if !world.knows_lights() {
        return Vec::new();
    }
    let maps = |light: &Light| {
        let LightKind::Virtual { position, normal, .. } = light.kind else { return Vec::new() };
        let view = View::paraboloid(position, normal, settings.size);
        vec![Resolution::of_paraboloid(view); light.map_count()]
    };
    world.all_lights().iter().flat_map(maps).collect()
}

impl Technique for Ism {
    /// Adaptive points depend on the camera.
    fn made_of(&self) -> Parts {
        let of = Parts::MESHES.and(Parts::LIGHTS);
        if self.settings.adaptive { of.and(Parts::CAMERA) } else { of }
    }

    fn forget(&mut self) {
        self.sampled.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        world.has_maps(self.maps)?;
        lights_are_virtual(world)?;
        self.resolution = resolution(world, &self.settings);
        if self.sampled.make(world) {
            self.sample.record(commands, world);
            if let Some(adapt) = &self.adapt {
                adapt.gather(commands);
            }
        }
        if let Some(adapt) = &self.adapt {
            adapt.record(commands, world);
        }
        self.atlas.record(commands, world);
        Ok(())
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::ISM, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Ism {
    fn resolution(&self) -> Vec<Resolution> {
        self.resolution.clone()
    }

    fn distances(&self, light: usize) -> Result<Vec<f32>> {
        self.atlas.map(light)
    }

    fn facts(&self) -> Result<Facts> {
        let mut counters = std::collections::BTreeMap::new();
        let seen = self.atlas.seen()?;
        counters.insert("points".into(), seen.len() as u64 * u64::from(self.settings.points));
        // Points drawn without a list are not counted.
        if self.settings.culling != Culling::Off || matches!(self.way, BuildPath::Tiled | BuildPath::Atomic) {
            counters.insert("points_seen".into(), seen.into_iter().map(u64::from).sum());
        }
        Ok(Facts {
            path: word_of(self.way),
            reason: self.reason.into(),
            bytes_resident: self.atlas.maps.bytes() + self.sample.head.bytes(),
            bytes_transient: self.sample.transient_bytes()
                + self.adapt.as_ref().map_or(0, Adapt::transient_bytes)
                + self.atlas.transient_bytes(),
            counters,
            ..Facts::default()
        })
    }
}
