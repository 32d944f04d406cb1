//! Scenes that move. A [`Scene`] is a snapshot; [`Animated`] describes it at other times, and an [`AnimatedScene`] combines the two. Scenes
//! from files and built-in ones come from [`AnimatedScene::load`]; an engine's own scene works the same way:
//!
//! ```
//! use gobo::animate::{Animated, AnimatedScene, SceneParts};
//! use gobo::bench::{Effort, Frames, standard::EFFORT, with_case};
//! use gobo::scene::{Particle, Scene};
//! use gobo::{Result, shading};
//!
//! /// A ball of smoke that swings from side to side.
//! #[derive(Debug)]
//! struct Pendulum;
//!
//! impl Animated for Pendulum {
//!     fn at(&self, _: &Scene, time_s: f64) -> Result<SceneParts> {
//!         let ball = Particle { position: [time_s.sin() as f32, 0.0, 1.0], radius: 0.5, extinction: 2.0 };
//!         Ok(SceneParts { particles: Some(vec![ball]), ..SceneParts::default() })
//!     }
//! }
//!
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # example::on_a_device(|context| {
//! let pendulum = AnimatedScene::new(Scene { name: "pendulum".into(), ..Scene::default() }, Pendulum);
//! let times_s = [0.0, 0.5, 1.0];
//! let states: Vec<Scene> = times_s.iter().map(|time_s| pendulum.at(*time_s)).collect::<Result<_>>()?;
//! let frames = Frames { times_s: &times_s, ..Frames::from(&states[..]) };
//! let effort = Effort { frames: 3, space_points: 256, seen_points: 256, lookups: 0, picture: [32, 18], ..EFFORT };
//! let spec = &shading::parse("avsm:size=64")?[0];
//! let row = with_case(context, frames, effort, |case| Ok(case.measure(spec).0))?;
//! let space = row.error.and_then(|error| error.space);
//! assert!(space.is_some_and(|space| space.mean_abs < 0.01), "{}", row.reason);
//! # Ok(()) });
//! ```

mod built_in;
mod simulate;

pub use simulate::Simulation;

use crate::scene::{
    Animation, Fountain, Light, Loaded, MOST_GRAVITY, Mesh, Particle, Scene, Splat, Strand, Volume, open,
};
use crate::world::{Moved, World};
use crate::{Error, Result};
use glam::DVec3;
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

/// The animation of a scene. Its `Debug` text is part of [`AnimatedScene::fingerprint`], to distinguish one motion from another.
pub trait Animated: Any + Debug + Send + Sync {
    /// Returns the parts of `scene` that move, as they are `time_s` seconds after its start. If there are more casters at some times than
    /// in `scene`, its [`Scene::reserve`] gives their maximum number.
    ///
    /// # Errors
    /// Fails if the parts cannot be computed: for a time that is out of range, or a file that cannot be read.
    fn at(&self, scene: &Scene, time_s: f64) -> Result<SceneParts>;
}

/// Parts of a scene; `None` for those that stay unchanged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneParts {
    /// See [`Scene::particles`].
    pub particles: Option<Vec<Particle>>,
    /// See [`Scene::strands`].
    pub strands: Option<Vec<Strand>>,
    /// See [`Scene::splats`].
    pub splats: Option<Vec<Splat>>,
    /// See [`Scene::volumes`].
    pub volumes: Option<Vec<Volume>>,
    /// See [`Scene::meshes`].
    pub meshes: Option<Vec<Mesh>>,
    /// See [`Scene::lights`].
    pub lights: Option<Vec<Light>>,
}

impl SceneParts {
    /// Swaps these parts with the scene's own.
    pub fn swap(&mut self, scene: &mut Scene) {
        fn swap<T>(part: &mut Option<T>, of_scene: &mut T) {
            if let Some(part) = part {
                std::mem::swap(part, of_scene);
            }
        }
        swap(&mut self.particles, &mut scene.particles);
        swap(&mut self.strands, &mut scene.strands);
        swap(&mut self.splats, &mut scene.splats);
        swap(&mut self.volumes, &mut scene.volumes);
        swap(&mut self.meshes, &mut scene.meshes);
        swap(&mut self.lights, &mut scene.lights);
    }

    /// Whether at most the lights change.
    #[cfg(feature = "view")]
    pub(crate) fn are_lights(&self) -> bool {
        let Self { particles, strands, splats, volumes, meshes, lights: _ } = self;
        particles.is_none() && strands.is_none() && splats.is_none() && volumes.is_none() && meshes.is_none()
    }
}

/// A scene and its animation.
#[derive(Clone, Debug)]
pub struct AnimatedScene {
    /// The scene at one time.
    pub scene: Scene,
    /// The animation; `None` if nothing moves.
    pub animation: Option<Arc<dyn Animated>>,
    /// What the scene's files have that is left out, one line per file and kind.
    pub notes: Vec<String>,
}

impl From<Scene> for AnimatedScene {
    fn from(scene: Scene) -> Self {
        Self { scene, animation: None, notes: Vec::new() }
    }
}

impl AnimatedScene {
    /// Creates an animated scene: `scene`, moved by `animation`.
    pub fn new(scene: Scene, animation: impl Animated) -> Self {
        Self { scene, animation: Some(Arc::new(animation)), notes: Vec::new() }
    }

    /// Same as [`Scene::load`], but includes the scene's animation.
    ///
    /// # Errors
    /// See [`Scene::load`].
    pub fn load(name: &str, time_s: f64) -> Result<Self> {
        Self::load_upright(name, time_s, None)
    }

    /// Same as [`AnimatedScene::load`], with the axis of a data file that points up.
    ///
    /// # Errors
    /// See [`Scene::load`]; [`Error::Usage`] if `up` is given and the scene is not a data file.
    pub(crate) fn load_upright(name: &str, time_s: f64, up: Option<DVec3>) -> Result<Self> {
        let Loaded { scene, sequences, notes } = open(name, time_s, up)?;
        let animation = match sequences {
            Some(sequences) => Some(Arc::new(sequences) as Arc<dyn Animated>),
            None => built_in::animation(name, &scene),
        };
        Ok(Self { scene, animation, notes })
    }

    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        self.animation.is_some()
    }

    /// Returns the scene at another time: moving parts are as they are `time_s` seconds after their start; everything else stays unchanged.
    ///
    /// # Errors
    /// See [`Animated::at`]; [`Error::Usage`] if the time is out of range.
    pub fn at(&self, time_s: f64) -> Result<Scene> {
        moved(&self.scene, self.animation.as_deref(), time_s)
    }

    /// Moves `world`, which was created from this scene, to another time. If nothing moves, it is left unchanged, and its generations do
    /// not increase.
    ///
    /// # Errors
    /// See [`AnimatedScene::at`] and [`World::replace`].
    pub fn move_world(&self, world: &mut World, time_s: f64) -> Result<Moved> {
        match self.animation.as_deref() {
            None => Ok(Moved { pass: None, host_ns: 0.0 }),
            animation => world.replace(&moved(world.scene()?, animation, time_s)?),
        }
    }

    /// Returns the moving parts of the scene, at another time.
    ///
    /// # Errors
    /// See [`AnimatedScene::at`].
    #[cfg(feature = "view")]
    pub(crate) fn parts_at(&self, time_s: f64) -> Result<SceneParts> {
        self.animation.as_ref().map_or_else(|| Ok(SceneParts::default()), |animation| animation.at(&self.scene, time_s))
    }

    /// Same as [`Scene::fingerprint`], but includes the motion: scenes that move in different ways almost never share a fingerprint.
    pub fn fingerprint(&self) -> u32 {
        fingerprint(&self.scene, self.animation.as_deref())
    }

    /// Returns the fountain that the scene's particles form, which the device can simulate.
    pub fn fountain(&self) -> Option<Fountain> {
        fountain(self.animation.as_deref())
    }

    /// Whether states are read from files.
    pub(crate) fn is_read(&self) -> bool {
        sequences(self.animation.as_deref()).is_some()
    }

    /// Returns the scene `courtyard` with `count` lights instead of its 32, at a time as in [`Scene::load`].
    ///
    /// # Errors
    /// [`Error::Input`] if the scene is not `courtyard`, [`Error::Usage`] if the number or the time is out of range.
    pub fn with_lights(mut self, count: usize, time_s: f64) -> Result<Self> {
        if kind::<built_in::Courtyard>(self.animation.as_deref()).is_none() {
            let way_out = "leave their number out, or name courtyard";
            return Err(Error::input(self.scene.name, "its lights are not a number to choose", way_out));
        }
        self.scene.lights = built_in::courtyard_lights(&self.scene.name, count, time_s)?;
        Ok(self)
    }

    /// Returns the scene `fountain` with a fixed attractor, if one is given, and `gravity` times the earth's gravity, at a time as in
    /// [`Scene::load`]. Particles move as if these had always been in force.
    ///
    /// # Errors
    /// [`Error::Input`] if the scene is not simulated, [`Error::Usage`] if a number or the time is out of range.
    pub fn pulled(mut self, attractor: Option<DVec3>, gravity: f64, time_s: f64) -> Result<Self> {
        self.set_fountain(self.pull(attractor, gravity)?);
        self.scene = self.at(time_s)?;
        Ok(self)
    }

    /// Lets another fountain with the same number of particles move the scene from now on.
    pub(crate) fn set_fountain(&mut self, fountain: Fountain) {
        self.animation = Some(Arc::new(built_in::Fountain(fountain)));
    }

    /// Returns the fountain with this attractor and gravity.
    ///
    /// # Errors
    /// See [`AnimatedScene::pulled`], except for the time.
    pub(crate) fn pull(&self, attractor: Option<DVec3>, gravity: f64) -> Result<Fountain> {
        let name = || self.scene.name.clone();
        let Some(fountain) = self.fountain() else {
            let way_out = "leave attractor and gravity out, or name fountain";
            return Err(Error::input(name(), "nothing of it is simulated", way_out));
        };
        if !(0.0..=MOST_GRAVITY).contains(&gravity) {
            let cause = format!("a gravity of {gravity}, of 0 to {MOST_GRAVITY} times the earth's");
            return Err(Error::usage(name(), cause, "choose another"));
        }
        if attractor.is_some_and(|at| at.abs().max_element() > 1e3 || !at.is_finite()) {
            return Err(Error::usage(name(), "an attractor farther than 1000 away", "bring it nearer"));
        }
        let attractor = attractor.map(|at| at.as_vec3().into());
        Ok(Fountain { attractor, gravity: gravity as f32, ..fountain })
    }
}

/// Returns `scene` as `animation` moves it to a time.
///
/// # Errors
/// See [`AnimatedScene::at`].
pub(crate) fn moved(scene: &Scene, animation: Option<&dyn Animated>, time_s: f64) -> Result<Scene> {
    let mut parts = animation.map_or_else(|| Ok(SceneParts::default()), |animation| animation.at(scene, time_s))?;
    let mut scene = scene.clone();
    parts.swap(&mut scene);
    Ok(scene)
}

/// See [`AnimatedScene::fingerprint`].
pub(crate) fn fingerprint(scene: &Scene, animation: Option<&dyn Animated>) -> u32 {
    animation.map_or_else(|| scene.fingerprint(), |animation| scene.fingerprint_with(&format!("{animation:?}")))
}

/// See [`AnimatedScene::fountain`].
pub(crate) fn fountain(animation: Option<&dyn Animated>) -> Option<Fountain> {
    kind::<built_in::Fountain>(animation).map(|fountain| fountain.0)
}

/// The sequences of files that move a scene.
pub(crate) fn sequences(animation: Option<&dyn Animated>) -> Option<&Animation> {
    kind(animation)
}

fn kind<T: Animated>(animation: Option<&dyn Animated>) -> Option<&T> {
    let animation: &dyn Any = animation?;
    animation.downcast_ref()
}
