//! Built-in scenes, and parsing of their names with numbers: `NAME:key=value,key=value`.

pub(super) mod cloud;
pub(super) mod cornell;
pub(crate) mod courtyard;
pub(crate) mod courtyard_lights;
pub(super) mod courtyard_shapes;
pub(super) mod cube;
pub(super) mod embedded;
pub(crate) mod emitters;
pub(super) mod failures;
pub(crate) mod fountain;
pub(super) mod fountain_law;
pub(crate) mod fountain_steps;
pub(super) mod glasshouse;
pub(super) mod grove;
pub(super) mod grove_leaf;
pub(crate) mod hair;
pub(super) mod houses;
pub(super) mod ink;
pub(crate) mod lantern;
pub(super) mod plume;
pub(super) mod sparse;
pub(super) mod splats;
pub(super) mod town;
pub(super) mod town_house;
pub(super) mod town_shapes;

use crate::scene::{BUILT_IN, files::input};
use crate::{Error, Result};

/// A numeric parameter of a built-in scene.
struct Key {
    scene: &'static str,
    name: &'static str,
    default: u32,
    /// The largest allowed value; the smallest is 1.
    most: u32,
}

/// All numeric parameters of built-in scenes.
const KEYS: [Key; 10] = [
    Key { scene: "big-8k", name: "lights", default: 1, most: cube::MOST_LIGHTS },
    Key { scene: "fountain", name: "particles", default: 16_384, most: 4_000_000 },
    Key { scene: "cloud", name: "samples", default: 40, most: cloud::MOST },
    Key { scene: "ink", name: "inks", default: 1, most: 2 },
    Key { scene: "splats", name: "count", default: 6_000, most: splats::MOST },
    Key { scene: "grove", name: "cards", default: grove::USUAL, most: grove::MOST },
    Key { scene: "grove", name: "whole", default: 0, most: 1 },
    Key { scene: "glasshouse", name: "colored", default: 0, most: 1 },
    Key {
        scene: "courtyard",
        name: "lights",
        default: courtyard_lights::USUAL as u32,
        most: courtyard_lights::MOST as u32,
    },
    Key { scene: "courtyard", name: "holes", default: 0, most: 1 },
];

/// A scene's name, with the numbers given in it.
pub(super) struct BuiltIn<'a> {
    /// The scene's name, without numbers; the whole text if no such scene is built in.
    pub name: &'a str,
    /// The scene's own title, safe in file names: `fountain-1000000`.
    pub title: String,
    given: Vec<(&'a str, u32)>,
}

impl<'a> BuiltIn<'a> {
    /// Parses a name given by a user. Names of scenes that are not built in are kept as they are, since a path may contain colons.
    ///
    /// # Errors
    /// [`Error::Usage`] that names a key unknown to the scene, or a number that is out of range.
    pub(super) fn read(text: &'a str) -> Result<Self> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        if !BUILT_IN.contains(&name) {
            return Ok(Self { name: text, title: text.into(), given: Vec::new() });
        }
        let mut read = Self { name, title: name.into(), given: Vec::new() };
        let parts = rest.split(',').filter(|_| text.len() > name.len());
        for part in parts {
            let wrong = |cause: &str| {
                let keys = keys(name);
                let way_out = if keys.is_empty() { format!("{name} takes no numbers") } else { format!("give {keys}") };
                Error::usage(text, input::one_line(cause), way_out)
            };
            let (key, value) = part.split_once('=').ok_or_else(|| wrong(&format!("{part:?} is no key=value")))?;
            let known = KEYS.iter().find(|k| k.scene == name && k.name == key);
            let known = known.ok_or_else(|| wrong(&format!("no key {key:?}")))?;
            if read.given.iter().any(|(given, _)| *given == key) {
                return Err(wrong(&format!("{key} is given twice")));
            }
            let number = value.parse().ok().filter(|number| (1..=known.most).contains(number));
            let number = number.ok_or_else(|| wrong(&format!("{part:?} is no whole number in its range")))?;
            read.title += &if known.most == 1 { format!("-{key}") } else { format!("-{number}") };
            read.given.push((key, number));
        }
        Ok(read)
    }

    /// Returns the number given for `key`, or its default.
    pub(super) fn number(&self, key: &str) -> u32 {
        let given = self.given.iter().find(|(name, _)| *name == key).map(|(_, number)| *number);
        let known = || KEYS.iter().find(|k| k.scene == self.name && k.name == key);
        given.or_else(|| known().map(|k| k.default)).unwrap_or_default()
    }
}

/// Returns the first number in a scene's name such as `fountain:particles=1000`: its key, its value, and the largest value allowed. None if the
/// scene has no numeric parameter, or there is no such scene.
pub fn number_of(text: &str) -> Option<(&'static str, u32, u32)> {
    let scene = BuiltIn::read(text).ok()?;
    let key = KEYS.iter().find(|key| key.scene == scene.name && key.most > 1)?;
    Some((key.name, scene.number(key.name), key.most))
}

/// Returns the scene's name with another number, clamped to the allowed range; `text` itself if the scene has no numeric parameter.
pub fn with_number(text: &str, number: u32) -> String {
    match (number_of(text), BuiltIn::read(text)) {
        (Some((key, _, most)), Ok(scene)) => format!("{}:{key}={}", scene.name, number.clamp(1, most)),
        _ => text.to_owned(),
    }
}

/// Returns the keys of a scene and their ranges, as text for users.
fn keys(scene: &str) -> String {
    let of = KEYS.iter().filter(|key| key.scene == scene);
    of.map(|key| format!("{}=1..{}", key.name, key.most)).collect::<Vec<_>>().join(", ")
}

/// Returns a scene's name with its keys, as text for users.
pub(super) fn with_keys(scene: &str) -> String {
    let keys = keys(scene);
    if keys.is_empty() { scene.into() } else { format!("{scene} ({scene}:{keys})") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_another() {
        assert_eq!(number_of("fountain"), Some(("particles", 16_384, 4_000_000)));
        assert_eq!(number_of("courtyard:lights=7").map(|(key, number, _)| (key, number)), Some(("lights", 7)));
        assert_eq!(with_number("fountain:particles=5", 9), "fountain:particles=9");
        assert_eq!(with_number("splats", u32::MAX), format!("splats:count={}", splats::MOST));
        for text in ["town", "a/b.toml", "fountain:particles=0"] {
            assert_eq!((number_of(text), with_number(text, 3)), (None, text.to_owned()));
        }
        // `number_of` finds a scene's first key.
        assert_eq!(number_of("grove:whole=1"), Some(("cards", grove::USUAL, grove::MOST)));
    }

    #[test]
    fn numbers_and_their_titles() {
        let plain = BuiltIn::read("fountain").expect("plain");
        assert_eq!((plain.name, &*plain.title, plain.number("particles")), ("fountain", "fountain", 16_384));
        for number in [1, 4_000_000] {
            let text = format!("fountain:particles={number}");
            let read = BuiltIn::read(&text).expect("in range");
            assert_eq!((read.name, read.number("particles")), ("fountain", number));
            assert_eq!(read.title, format!("fountain-{number}"));
        }
        let whole = BuiltIn::read("grove:cards=9,whole=1").expect("both");
        assert_eq!((whole.number("cards"), whole.number("whole"), &*whole.title), (9, 1, "grove-9-whole"));
        assert_eq!(BuiltIn::read("grove").expect("plain").number("whole"), 0);
        for path in ["a:b.ply", "C:/town:particles=0.glb", "fountains:particles=0", ":", ""] {
            assert_eq!(BuiltIn::read(path).expect("a path").name, path);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, words) in [
            ("fountain:particles=0", ["particles=0", "particles=1..4000000"]),
            ("fountain:particles=4000001", ["particles=4000001", "particles=1..4000000"]),
            ("fountain:particles=-1", ["particles=-1", "no whole number"]),
            ("fountain:particles=1e6", ["particles=1e6", "no whole number"]),
            ("fountain:particles=", ["particles=", "no whole number"]),
            ("fountain:", ["no key=value", "particles=1..4000000"]),
            ("fountain:particles", ["no key=value", "particles=1..4000000"]),
            ("fountain:lights=3", ["no key \"lights\"", "particles=1..4000000"]),
            ("fountain:particles=3,particles=4", ["given twice", "particles=1..4000000"]),
            ("courtyard:lights=1025", ["lights=1025", "lights=1..1024"]),
            ("town:particles=3", ["no key \"particles\"", "town takes no numbers"]),
        ] {
            let error = BuiltIn::read(text).err().expect(text).to_string();
            assert!(error.starts_with(text) && words.iter().all(|word| error.contains(word)), "{error}");
        }
    }
}
