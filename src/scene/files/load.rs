//! Loads scenes by name, from files or built in.

use crate::error::did_you_mean;
use crate::scene::files::contents::Loaded;
use crate::scene::{
    DATA_ENDINGS, Scene, built_in, built_in::cloud, built_in::cornell, built_in::courtyard, built_in::cube,
    built_in::embedded, built_in::emitters, built_in::failures, built_in::fountain, built_in::glasshouse,
    built_in::grove, built_in::hair, built_in::houses, built_in::ink, built_in::lantern, built_in::plume,
    built_in::sparse, built_in::splats, built_in::town, check_time, files::data_file, files::file, files::input,
};
use crate::{Error, Result};
use glam::DVec3;
use std::path::Path;

/// Names that [`Scene::load`] accepts without a file.
pub const BUILT_IN: [&str; 23] = [
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
    "grove",
    "glasshouse",
];

/// Returns the names that [`Scene::load`] accepts, as text for users.
pub fn known() -> String {
    let endings = DATA_ENDINGS.map(|ending| format!("*.{ending}")).join(", ");
    let built_in = BUILT_IN.map(built_in::with_keys).join(", ");
    format!("a scene file (*.toml), a data file ({endings}) or one of {built_in}")
}

impl Scene {
    /// Loads a scene file (`*.toml`), a data file of one of [`DATA_ENDINGS`] with a fitted light and camera, or a built-in scene. A scene
    /// file without a camera gets a fitted one too. Some built-in scenes take a number (`fountain:particles=1000000`,
    /// `courtyard:lights=256`). `time_s` is the time for animated scenes, in seconds since their emitters, lights or sequences of files
    /// started; other scenes ignore it.
    ///
    /// # Errors
    /// [`Error::Usage`] if there is no such built-in scene, or it does not take that number; [`Error::Input`] names the file and describes
    /// what is wrong with it.
    pub fn load(name: &str, time_s: f64) -> Result<Self> {
        open(name, time_s, None).map(|loaded| loaded.scene)
    }
}

/// Like [`Scene::load`], but also returns the sequences of files that the scene shows, and notes about its files.
/// `up`: which axis of a data file points up, if not the usual one of its format.
///
/// # Errors
/// See [`Scene::load`]; [`Error::Usage`] if `up` is given and the scene is not a data file.
pub(crate) fn open(name: &str, time_s: f64, up: Option<DVec3>) -> Result<Loaded> {
    let is_of_data = DATA_ENDINGS.contains(&input::ending(Path::new(name)).as_str());
    if up.is_some() && !is_of_data {
        let way_out = "leave it out; a scene file has `up` beside each `file`";
        return Err(Error::usage("up", format!("{name} is no data file"), way_out));
    }
    let built_in = built_in::BuiltIn::read(name)?;
    let scene = match built_in.name {
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
        "grove" => {
            let (cards, whole) = (built_in.number("cards"), built_in.number("whole") > 0);
            Ok(grove::grove(&built_in.title, cards, whole))
        }
        "glasshouse" => glasshouse::glasshouse(&built_in.title, built_in.number("colored") > 0),
        "failures" => Ok(failures::failures()),
        "lantern" => lantern::lantern(time_s),
        "splats" => Ok(splats::splats(&built_in.title, built_in.number("count"))),
        "cloud" => cloud::cloud(&built_in.title, built_in.number("samples")),
        "courtyard" => {
            let (lights, holes) = (built_in.number("lights"), built_in.number("holes") > 0);
            courtyard::courtyard(&built_in.title, lights, holes, time_s)
        }
        "fountain" => fountain::fountain(&built_in.title, built_in.number("particles"), time_s),
        path => return open_file(path, time_s, up),
    };
    Ok(scene?.into())
}

fn open_file(name: &str, time_s: f64, up: Option<DVec3>) -> Result<Loaded> {
    let path = Path::new(name);
    let loaded = match input::ending(path).as_str() {
        "toml" => file::load(path)?,
        ending if DATA_ENDINGS.contains(&ending) => data_file::load(path, up)?,
        ending if path.exists() => {
            if let Some((cause, way_out)) = input::foreign(ending) {
                return Err(Error::input(name, cause, way_out));
            }
            let what = if ending.is_empty() { "what has no ending".into() } else { format!(".{ending}") };
            let way_out = format!("give a scene file (.toml), or one that ends in .{}", DATA_ENDINGS.join(", ."));
            return Err(Error::input(name, format!("{what} is not read"), way_out));
        }
        _ => {
            let cause = format!("no such scene{}", did_you_mean(name, BUILT_IN));
            return Err(Error::usage(name, cause, format!("give {}", known())));
        }
    };
    let Some(sequences) = &loaded.sequences else { return Ok(loaded) };
    check_time(&loaded.scene.name, time_s)?;
    let mut scene = loaded.scene;
    if sequences.has_sequences() {
        (scene.particles, scene.volumes) = sequences.at(time_s)?;
    }
    sequences.show_meshes(&mut scene.meshes, time_s)?;
    Ok(Loaded { scene, ..loaded })
}
