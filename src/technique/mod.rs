//! Shadow techniques. Each has passes that build a representation, and one GLSL function that evaluates it.
//!
//! To add a technique, create a folder in glsl/ with its passes and a visibility.glsl, a module here of the same name with an `ENTRY`, and
//! a line in the registry below. docs/guide/add-a-technique.md explains each step.

// The registry: one line per technique. REGISTRY lists them all.
pub mod avsm;
pub mod beer_shadow_map;
pub mod deep_shadow_map;
pub mod density_grid;
pub mod fourier;
pub mod grid_query;
pub mod half_angle;
pub mod ism;
pub mod layers;
pub mod marched;
pub mod moments;
pub mod none;
pub mod optical_depth_grid;
pub mod psm;
pub mod ray_query;
pub mod shadow_map;
pub mod stochastic;
pub mod translucency_map;
pub mod uncompressed;
pub mod voxel_grid;
pub mod voxelized;
pub mod wavelet;

// Code shared by techniques.
mod build;
#[doc(hidden)]
pub mod keys;
mod map_settings;
mod painter;
mod path_plan;
#[doc(hidden)]
pub mod promises;
mod requirements;
#[doc(hidden)]
pub mod runs;
#[doc(hidden)]
pub mod settings;
mod spec;
#[doc(hidden)]
pub mod sums;
mod texel_map;

pub use avsm::Avsm;
pub use beer_shadow_map::BeerShadowMap;
pub use build::{Opened, open};
pub use deep_shadow_map::DeepShadowMap;
pub use density_grid::DensityGrid;
pub use fourier::Fourier;
pub use grid_query::GridQuery;
pub use half_angle::HalfAngle;
pub use ism::Ism;
pub use layers::Layers;
pub use marched::Marched;
pub use moments::Moments;
pub use none::Unshadowed;
pub use optical_depth_grid::OpticalDepthGrid;
pub use psm::Psm;
pub use ray_query::RayQuery;
pub use requirements::{PathRequirements, requirements};
pub use shadow_map::ShadowMap;
pub use spec::{Spec, parse};
pub use stochastic::Stochastic;
pub use translucency_map::TranslucencyMap;
pub use uncompressed::Uncompressed;
pub use voxel_grid::VoxelGrid;
pub use voxelized::{Baked as VoxelizedBake, Voxelized};
pub use wavelet::Wavelet;

// Exported for the program and the tests.
#[doc(hidden)]
pub use self::{
    avsm::NodeData,
    build::Built,
    deep_shadow_map::DeepState,
    ism::{
        Atlas as IsmAtlas, BuildPath as IsmWay, CLUSTER as ISM_CLUSTER, ClusterData, Culling, Facing, PointData,
        PointsData, SUBSETS as ISM_SUBSETS,
    },
    keys::{Key, Name, Values},
    painter::{Painter, answers_in_space, half_vector},
    path_plan::{Path, PathPlan},
    promises::Promises,
    runs::Runs,
    texel_map::TexelMap,
    voxel_grid::March,
    voxelized::{Coverage, Free, LevelCounts, Structure, TreeData},
};

use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::maps::{Map, OpaqueMaps};
use crate::scene::{Kinds, Resolution};
use crate::shaders::Folder;
use crate::world::{Parts, World};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

macro_rules! registry {
    ($($folder:ident),*) => {
        /// Every technique: one per folder of glsl/ with a visibility.glsl.
        pub const REGISTRY: &[&Entry] = &[$(&$folder::ENTRY),*];
    };
}
crate::shaders::with_folders!(registry);

/// Techniques that commands use by default.
#[doc(hidden)]
pub mod usual {
    /// Default for pictures.
    pub const PICTURE: &str = super::avsm::ENTRY.name;
    /// Default for the curve of a ray.
    pub const CURVE: &str = "avsm:nodes=8,curve=linear|exponential";
    /// Default for the distances in a map.
    pub const DISTANCES: &str = super::ism::ENTRY.name;
    /// Default for baking a file.
    pub const BAKED: &str = super::voxelized::ENTRY.name;
}

/// A technique, opened for one world. [`Opened`] builds it; the technique itself never submits, waits or loops.
pub trait Technique: Send {
    /// Returns the parts of the world that the technique is built from, or that its facts depend on. No build is recorded while none of
    /// them changes. By default, these are all parts.
    fn made_of(&self) -> Parts {
        Parts::ALL
    }

    /// Records the passes of one build for the current state of the world. Results that have not changed since the last recording need not
    /// be built again.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()>;

    /// Makes the next recording build everything again, except views and sort orders, which depend on the casters alone. The default does
    /// nothing, for techniques that build everything in every recording.
    fn forget(&mut self) {}

    /// Reads the results of the finished frame `frame` without waiting. Reports whether the build is done, has another part to record, or
    /// has to be recorded again because a buffer grew. Called before frame `frame + frames_in_flight` is recorded, which reuses the memory
    /// of these results.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device does not have enough memory.
    fn settle(&mut self, _frame: u64) -> Result<BuildStatus> {
        Ok(BuildStatus::Done)
    }

    /// Returns the bindings and constants with which shaders query the technique.
    fn answer(&self) -> Answer<'_>;

    /// Returns the interface for measuring the technique.
    fn inspect(&self) -> &dyn Inspect;
}

/// What a technique reports for measurement and display. Rendering does not need it.
pub trait Inspect {
    /// Returns the technique's maps as the last build fitted them. Empty before the first build, and for techniques without maps.
    fn maps(&self) -> &[Map] {
        &[]
    }

    /// Returns how finely the technique resolves the edges of opaque shadows, one entry per map of all lights. Empty if the technique is
    /// exact, or if the host does not know the meshes or the lights. By default, this is the resolution of the opaque maps.
    fn resolution(&self) -> Vec<Resolution> {
        self.maps().iter().map(|map| OpaqueMaps::SHARED.resolution(map.opaque)).collect()
    }

    /// Returns figures of the last build.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if counts cannot be read back.
    fn facts(&self) -> Result<Facts>;

    /// After a build, returns the nodes of the curve that look-ups read along the ray through a texel's centre: (depth in the range of the
    /// map's volume, transmittance). Empty for techniques without nodes, and if look-ups average several curves there. `map` is an index
    /// into the maps of all lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    fn nodes(&self, _map: usize, _texel: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        Ok(Vec::new())
    }

    /// After a build, returns the nearest distances in the map of light `light`: a square of texels, infinite where there is nothing. Empty
    /// for techniques without such maps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    fn distances(&self, _light: usize) -> Result<Vec<f32>> {
        Ok(Vec::new())
    }

    /// After a build for the current state of the world, returns the bytes of a file from which the technique can be opened again. `None`
    /// for techniques that are not baked.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if it cannot be read back.
    fn file(&self, _world: &World) -> Result<Option<Vec<u8>>> {
        Ok(None)
    }
}

/// Progress of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildStatus {
    /// The build is complete.
    Done,
    /// A buffer was too small and has been enlarged: record again.
    Retry,
    /// This part of the build is done: record the next.
    Continue,
}

impl BuildStatus {
    /// Returns [`BuildStatus::Retry`] if a buffer grew, else [`BuildStatus::Done`].
    pub fn of(grew: bool) -> Self {
        if grew { Self::Retry } else { Self::Done }
    }
}

/// How to query a technique: the constants and bindings of a shader with `#include "visibility.glsl"`, or the painter that draws the
/// casters instead.
#[derive(Clone, Copy)]
pub struct Answer<'a> {
    /// Folder with the technique's visibility.glsl.
    pub folder: Folder,
    /// Descriptor set 1.
    pub bindings: &'a Bindings,
    /// Specialization constants.
    pub constants: &'a Constants,
    /// Painter of a picture's casters, for a technique that cannot evaluate points among casters: its look-up is right only behind all
    /// casters, where surfaces query it. Most techniques have none.
    pub painter: Option<&'a Arc<Painter>>,
}

impl<'a> Answer<'a> {
    /// Creates the answer of a technique whose look-up works at all points.
    pub fn new(folder: Folder, bindings: &'a Bindings, constants: &'a Constants) -> Self {
        Self { folder, bindings, constants, painter: None }
    }
}

/// Figures of a technique after a build.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// Path in use.
    pub path: &'static str,
    /// Reason for choosing this path.
    pub reason: String,
    /// Number of bytes that look-ups need.
    pub bytes_resident: u64,
    /// Number of bytes needed only while building.
    pub bytes_transient: u64,
    /// Number of bytes that `gobo bake` writes, or has written, for techniques that can be baked.
    pub bytes_on_disk: Option<u64>,
    /// Values of keys that the spec left to a file.
    pub found: BTreeMap<String, String>,
    /// Number of nodes per curve, for techniques that have curves.
    pub nodes: Option<u32>,
    /// Counts of the last build, by name.
    pub counters: BTreeMap<String, u64>,
}

/// Kinds of casters from which a technique casts shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Casts {
    /// Smoke, as spheres.
    pub particles: bool,
    /// Hair.
    pub strands: bool,
    /// Splats.
    pub splats: bool,
    /// Density grids.
    pub volumes: bool,
    /// Opaque triangles.
    pub meshes: bool,
    /// See-through triangles.
    pub see_through: bool,
}

impl Casts {
    /// All kinds of casters.
    pub const ALL: Self =
        Self { particles: true, strands: true, splats: true, volumes: true, meshes: true, see_through: true };

    /// No casters at all: all light passes.
    pub const NONE: Self =
        Self { particles: false, strands: false, splats: false, volumes: false, meshes: false, see_through: false };

    /// Meshes alone.
    pub const MESHES: Self = Self { meshes: true, ..Self::NONE };

    /// Returns whether the technique sees at least one kind of caster in the scene. Also true if the scene has no casters, or if the
    /// technique sees none by design.
    pub fn any_of(self, has: Kinds) -> bool {
        has == Kinds::default() || self == Self::NONE || self.are_in(has)
    }

    /// Returns whether the technique sees at least one kind of caster in the scene.
    pub fn are_in(self, has: Kinds) -> bool {
        has.particles && self.particles
            || has.strands && self.strands
            || has.splats && self.splats
            || has.volumes && self.volumes
            || has.meshes && self.meshes
            || has.see_through && self.see_through
    }

    /// Returns the kinds of casters in the scene that the technique does not see: `smoke`, `hair`, `splats`, `volumes`, `meshes`,
    /// `see-through meshes`.
    pub fn unseen_of(self, has: Kinds) -> Vec<String> {
        let kinds = [
            ("smoke", has.particles, self.particles),
            ("hair", has.strands, self.strands),
            ("splats", has.splats, self.splats),
            ("volumes", has.volumes, self.volumes),
            ("meshes", has.meshes, self.meshes),
            ("see-through meshes", has.see_through, self.see_through),
        ];
        kinds.into_iter().filter(|(_, has, sees)| *has && !sees).map(|(name, ..)| name.into()).collect()
    }

    /// Returns the kinds of casters as words to print.
    pub fn names(self) -> String {
        if self == Self::ALL {
            return "all kinds of casters".into();
        }
        let names = [
            (self.particles, "particles"),
            (self.strands, "strands"),
            (self.splats, "splats"),
            (self.volumes, "volumes"),
            (self.meshes, "meshes"),
            (self.see_through, "see-through meshes"),
        ];
        let all: Vec<_> = names.into_iter().filter(|n| n.0).map(|n| n.1).collect();
        if all.is_empty() { "nothing".into() } else { all.join(", ") }
    }
}

/// How often a representation is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lifetime {
    /// Whenever something in the world has moved.
    Frame,
    /// Once, for a static world.
    Baked,
}

/// Opens a technique.
#[doc(hidden)]
pub type Open = fn(&Context, &World, &Spec) -> Result<Box<dyn Technique>>;

/// A registry entry: everything that the program knows about a technique.
pub struct Entry {
    /// Name in specs.
    pub name: &'static str,
    /// Description, one line.
    pub about: &'static str,
    /// Kinds of casters that the technique sees.
    pub casts: Casts,
    /// How often its representation is built.
    pub lifetime: Lifetime,
    /// Keys of its specs, besides [`keys::EVERY`]: [`settings::Keyed::KEYS`] of its settings.
    pub keys: &'static [Key],
    /// Paths on which it can be built.
    pub paths: &'static [Path],
    /// Returns the limits and promises of a spec on a path.
    pub plan: fn(&Spec, &'static Path) -> PathPlan,
    /// Specs that commands run if none is named.
    pub runs: Runs,
    /// Opens the technique for a world with casters that it sees.
    pub open: Open,
}

impl Entry {
    /// Returns the technique's own keys, then the keys that all techniques have.
    pub fn all_keys(&self) -> impl Iterator<Item = &'static Key> + Clone + use<> {
        self.keys.iter().chain(keys::EVERY)
    }

    /// Returns the error for the scene `name`, in which the technique sees no caster.
    pub fn casts_from_nothing(&self, name: &str) -> Error {
        Error::Refused(format!("{} in the scene, and {name} has none", self.casts.names()).into())
    }

    /// Checks that the device has the features needed for the path named `path`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`], naming the first missing feature.
    pub fn require(&self, context: &Context, path: &str) -> Result<()> {
        self.path(path).map_or(Ok(()), |path| context.features().require(path.requires))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    /// Asserts that a technique suits only scenes with casters that it sees, and that a scene without any casters suits all techniques.
    #[test]
    fn casts_from_what_the_scene_has() {
        let smoke = on_the_axis(&[(0.0, 0.5, 1.0)]);
        let mut nothing = smoke.clone();
        nothing.particles.clear();
        let meshes = Casts::MESHES;
        let [smoke, nothing] = [smoke.kinds(), nothing.kinds()];
        assert!(Casts::ALL.are_in(smoke) && !Casts::ALL.are_in(nothing) && !meshes.are_in(smoke));
        assert!(Casts::ALL.any_of(smoke) && !meshes.any_of(smoke) && meshes.any_of(nothing));
        assert!(Casts::NONE.any_of(smoke) && Casts::NONE.any_of(nothing) && !Casts::NONE.are_in(smoke));
        assert_eq!((Casts::ALL.names().as_str(), Casts::MESHES.names().as_str()), ("all kinds of casters", "meshes"));
        assert_eq!((Casts::NONE.names(), Casts::NONE.unseen_of(smoke)), ("nothing".into(), vec!["smoke".to_owned()]));
        assert_eq!((meshes.unseen_of(smoke), Casts::ALL.unseen_of(smoke)), (vec!["smoke".to_owned()], vec![]));
    }
}
