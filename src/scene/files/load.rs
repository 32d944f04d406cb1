//! Loads scenes by name, from files or built in, and moves them to other times.

use crate::error::did_you_mean;
use crate::scene::built_in::emitters::Smoke;
use crate::scene::{
    DATA_ENDINGS, Fountain, Light, MOST_GRAVITY, Motion, Particle, Scene, Volume, built_in, built_in::cloud,
    built_in::cornell, built_in::courtyard, built_in::courtyard_lights, built_in::cube, built_in::embedded,
    built_in::emitters, built_in::failures, built_in::fountain, built_in::hair, built_in::houses, built_in::ink,
    built_in::lantern, built_in::plume, built_in::sparse, built_in::splats, built_in::town, check_time,
    files::data_file, files::file, files::input,
};
use crate::{Error, Result};
use glam::DVec3;

/// Names that [`Scene::load`] knows without a file.
pub const BUILT_IN: [&str; 21] = [
    "three-emitters",
    "plume_8k",
    "plume_64k",
    "plume-1m",
    "big-8k",
    "hair",
    "mohawk",
    "lantern",
    "sparse",
    "town",
    "houses",
    "leaves",
    "shafts",
    "terrain",
    "courtyard",
    "cornell",
    "fountain",
    "splats",
    "cloud",
    "failures",
    "ink",
];

/// The names that [`Scene::load`] takes, as text for users.
pub fn known() -> String {
    let endings = DATA_ENDINGS.map(|ending| format!("*.{ending}")).join(", ");
    let built_in = BUILT_IN.map(built_in::with_keys).join(", ");
    format!("a scene file (*.toml), a data file ({endings}) or one of {built_in}")
}

impl Scene {
    /// Loads a scene file (`*.toml`), a data file of one of [`DATA_ENDINGS`] with a fitted light and camera, or a built-in scene. A scene file
    /// without a camera has a fitted one too. Some
    /// built-in scenes take a number (`fountain:particles=1000000`, `courtyard:lights=256`). `time_s` is the time for scenes that move, in
    /// seconds since their emitters, lights or sequences of files started; other scenes ignore it.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is no such built-in scene, or it does not take that number; [`Error::Input`] names the file
    /// and what is wrong with it.
    pub fn load(name: &str, time_s: f64) -> Result<Self> {
        let built_in = built_in::BuiltIn::read(name)?;
        match built_in.name {
            "three-emitters" => emitters::three_emitters(time_s),
            "plume-1m" => plume::plume_1m(),
            "big-8k" => Ok(cube::big_8k(&built_in.title, built_in.number("lights"))),
            "sparse" => Ok(sparse::sparse()),
            "hair" => hair::hair(time_s),
            "plume_8k" => Ok(embedded::plume_8k()),
            "plume_64k" => Ok(embedded::plume_64k()),
            "terrain" => embedded::terrain(),
            "mohawk" => embedded::mohawk(),
            "houses" => Ok(houses::houses()),
            "leaves" => Ok(houses::leaves()),
            "shafts" => Ok(houses::shafts()),
            "town" => Ok(town::town()),
            "cornell" => Ok(cornell::cornell()),
            "ink" => ink::ink(&built_in.title, built_in.number("inks")),
            "failures" => Ok(failures::failures()),
            "lantern" => lantern::lantern(time_s),
            "splats" => Ok(splats::splats(&built_in.title, built_in.number("count"))),
            "cloud" => cloud::cloud(&built_in.title, built_in.number("samples")),
            "courtyard" => courtyard::courtyard(&built_in.title, built_in.number("lights"), time_s),
            "fountain" => fountain::fountain(&built_in.title, built_in.number("particles"), time_s),
            path => match input::ending(path.as_ref()).as_str() {
                "toml" => begun(file::load(path.as_ref())?, time_s),
                ending if DATA_ENDINGS.contains(&ending) => begun(data_file::load(path.as_ref())?, time_s),
                ending if std::path::Path::new(path).exists() => {
                    let what = if ending.is_empty() { "what has no ending".into() } else { format!(".{ending}") };
                    let way_out =
                        format!("give a scene file (.toml), or one that ends in .{}", DATA_ENDINGS.join(", ."));
                    Err(Error::input(name, format!("{what} is not read"), way_out))
                }
                _ => {
                    let cause = format!("no such scene{}", did_you_mean(built_in.name, BUILT_IN));
                    Err(Error::usage(name, cause, format!("give {}", known())))
                }
            },
        }
    }

    /// The scene `courtyard` with `count` lights in place of its 32, at a time as in [`Scene::load`].
    ///
    /// # Errors
    /// [`Error::Input`] where the scene is not `courtyard`, [`Error::Usage`] where the number or the time is out of range.
    pub fn with_lights(self, count: usize, time_s: f64) -> Result<Self> {
        if self.motion != Motion::Courtyard {
            let way_out = "leave their number out, or name courtyard";
            return Err(Error::input(self.name, "its lights are not a number to choose", way_out));
        }
        if !(1..=courtyard_lights::MOST).contains(&count) {
            let cause = format!("{count} lights, and there are 1 to {}", courtyard_lights::MOST);
            return Err(Error::usage(self.name, cause, "choose another number"));
        }
        Ok(Self { lights: courtyard::lights_at(count, time_s)?, ..self })
    }

    /// The scene `fountain` with a fixed attractor, if one is given, and `gravity` times the earth's gravity, at a time as in
    /// [`Scene::load`]. Particles move as if these had always been in force.
    ///
    /// # Errors
    /// [`Error::Input`] where the scene is not simulated, [`Error::Usage`] where a number or the time is out of range.
    pub fn pulled(mut self, attractor: Option<DVec3>, gravity: f64, time_s: f64) -> Result<Self> {
        self.motion = Motion::Fountain(self.pull(attractor, gravity)?);
        self.at(time_s)
    }

    /// The fountain with this attractor and gravity, without its particles.
    ///
    /// # Errors
    /// As [`Scene::pulled`], except for the time.
    pub(crate) fn pull(&self, attractor: Option<DVec3>, gravity: f64) -> Result<Fountain> {
        let name = || self.name.clone();
        let Motion::Fountain(fountain) = self.motion else {
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

    /// The scene at another time: parts that move are as they are `time_s` seconds after their start; all else stays.
    ///
    /// # Errors
    /// [`Error::Usage`] where the time is out of range.
    pub fn at(&self, time_s: f64) -> Result<Self> {
        let mut parts = self.parts_at(time_s, &mut Smoke::default())?;
        let mut scene = self.clone();
        scene.swap(&mut parts);
        Ok(scene)
    }

    /// Waits until the next frame of each sequence of files is read, which a thread begins when one is shown.
    #[cfg(feature = "program")]
    pub(crate) fn read_ahead(&self) {
        if let Motion::Animation(animation) = &self.motion {
            animation.read_ahead();
        }
    }

    /// The parts of the scene that move, at another time. Smoke continues from its state in `before`.
    ///
    /// # Errors
    /// As [`Scene::at`].
    pub(crate) fn parts_at(&self, time_s: f64, before: &mut Smoke) -> Result<SceneParts> {
        let (mut particles, mut lights, mut volumes) = (None, None, None);
        match &self.motion {
            Motion::Still => {}
            Motion::ThreeEmitters => particles = Some(emitters::particles(time_s, before)?),
            Motion::Lantern => {
                (particles, lights) = (Some(lantern::particles(time_s, before)?), Some(lantern::lights(time_s)));
            }
            Motion::Hair => lights = Some(hair::lights(time_s)?),
            Motion::Courtyard => lights = Some(courtyard::lights_at(self.lights.len(), time_s)?),
            Motion::Fountain(fountain) => particles = Some(fountain::particles(fountain, time_s)?),
            Motion::Animation(animation) => {
                check_time(&self.name, time_s)?;
                let (now, fields) = animation.at(time_s)?;
                (particles, volumes) = (Some(now), Some(fields));
            }
        }
        Ok(SceneParts { particles, lights, volumes })
    }

    /// Exchanges the scene's parts with `parts`, where these are given.
    pub(crate) fn swap(&mut self, parts: &mut SceneParts) {
        fn swap<T>(own: &mut T, other: Option<&mut T>) {
            if let Some(other) = other {
                std::mem::swap(own, other);
            }
        }
        swap(&mut self.particles, parts.particles.as_mut());
        swap(&mut self.lights, parts.lights.as_mut());
        swap(&mut self.volumes, parts.volumes.as_mut());
    }
}

/// The parts of a scene that change with time; `None` for parts that do not.
pub(crate) struct SceneParts {
    pub(crate) particles: Option<Vec<Particle>>,
    lights: Option<Vec<Light>>,
    volumes: Option<Vec<Volume>>,
}

/// Moves content from sequences of files to a time; other content is already there.
fn begun(scene: Scene, time_s: f64) -> Result<Scene> {
    if matches!(scene.motion, Motion::Animation(_)) { scene.at(time_s) } else { Ok(scene) }
}
