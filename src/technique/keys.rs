//! Keys of specs, with their names and words. [`super::settings`] derives keys from typed fields.

use super::settings::SKIP;
use crate::maps::{AlphaTest, FilterKind, OpaqueWay};

/// A setting of a technique, or of the command that uses it, as written in specs.
#[derive(Clone, Copy)]
pub struct Key {
    /// Name of the key.
    pub name: &'static str,
    /// Allowed values.
    pub values: Values,
    /// Default value.
    pub default: &'static str,
    /// Help text, one line.
    pub about: &'static str,
    /// If given, another key and one of its values: specs may use this key only if the other key has that value.
    pub with: Option<(&'static str, &'static str)>,
}

/// Words, or numbers as words.
pub type OneOf = &'static [&'static str];

/// Name of a key, for code that is not tied to a technique. It is one of the constants below or comes from a [`Key`], so a misspelt name
/// does not compile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name(&'static str);

impl Name {
    /// How the technique is built.
    pub const PATH: Self = Self("path");
    /// Texels or voxels per side.
    pub const SIZE: Self = Self("size");
    /// Voxels per side of a grid from which maps are built.
    pub const GRID: Self = Self("grid");
    /// Slices of a volume.
    pub const SLICES: Self = Self("slices");
    /// Points on meshes.
    pub const POINTS: Self = Self("points");
    /// How a look-up averages.
    pub const FILTER: Self = Self("filter");
    /// How opaque maps are drawn.
    pub const OPAQUE: Self = Self("opaque");
    /// Whether unneeded work is skipped.
    pub const SKIP: Self = Self("skip");

    /// Keys that decide the size of the build.
    pub const SIZES: [Self; 3] = [Self::SIZE, Self::POINTS, Self::SLICES];

    /// Returns the name as written in specs.
    pub const fn text(self) -> &'static str {
        self.0
    }
}

impl From<&Key> for Name {
    fn from(key: &Key) -> Self {
        Self(key.name)
    }
}

/// Allowed values of a setting.
#[derive(Clone, Copy)]
pub enum Values {
    /// One of these words, or the default word.
    OneOf(OneOf),
    /// A whole number in this range, or the default word.
    Number(u32, u32),
    /// A multiple of the first number, from the second to the third.
    Multiple(u32, u32, u32),
    /// The name of a file, or the default word. The name can contain neither a comma nor a `|`, since both end it. The payload lists the
    /// keys whose values are stored in that file; in a spec that names a file, they have no defaults.
    Path(OneOf),
}

/// A type whose values are words in specs.
pub trait Word: Copy + 'static {
    /// Pairs of a word and its value.
    const ALL: &'static [(&'static str, Self)];
    /// The words.
    const WORDS: &'static [&'static str];
}

/// Returns the word for `value`.
pub fn word_of<T: Word + PartialEq>(value: T) -> &'static str {
    T::ALL.iter().find(|(_, v)| *v == value).map_or("", |(word, _)| word)
}

/// Declares an enum whose values are words in specs.
#[macro_export]
#[doc(hidden)]
macro_rules! __words {
    ($(#[$meta:meta])* $visibility:vis enum $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility enum $name { $($(#[$variant_meta])* $variant),+ }

        $crate::technique::keys::word!($name { $($variant = $word),+ });
    };
}

/// Declares the words for the values of a type that is declared elsewhere.
#[macro_export]
#[doc(hidden)]
macro_rules! __word {
    ($name:ident { $($variant:ident = $word:literal),+ $(,)? }) => {
        impl $crate::technique::keys::Word for $name {
            const ALL: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),+];
            const WORDS: &'static [&'static str] = &[$($word),+];
        }
    };
}

pub use crate::{__word as word, __words as words};

word!(AlphaTest { Cut = "cut", Coverage = "coverage", Hash = "hash", Whole = "whole" });
word!(OpaqueWay { Raster = "raster", Compute = "compute" });

word!(FilterKind { Bilinear = "bilinear", Box = "box", Gaussian = "gaussian" });

impl Word for bool {
    const ALL: &'static [(&'static str, Self)] = &[("on", true), ("off", false)];
    const WORDS: OneOf = &["on", "off"];
}

/// The keys that every technique has besides its own.
pub const EVERY: &[Key] = &[SKIP.key(Name::SKIP.text())];

/// Checks a key's value; the error lists the allowed values.
pub fn check(key: &Key, value: &str) -> std::result::Result<(), String> {
    match key.values {
        Values::OneOf(words) if words.contains(&value) || value == key.default => Ok(()),
        Values::OneOf(words) => {
            let default = Some(&key.default).filter(|default| !words.contains(default));
            let known: Vec<_> = default.into_iter().chain(words).copied().collect();
            Err(format!("choose one of: {}", known.join(", ")))
        }
        // Leading zeros or signs would give one variant two names.
        Values::Number(low, high) => match value.parse::<u32>() {
            Ok(n) if (low..=high).contains(&n) && n.to_string() == value => Ok(()),
            _ if value == key.default => Ok(()),
            _ if key.default.parse::<u32>().is_err() => {
                Err(format!("give a whole number from {low} to {high}, or {}", key.default))
            }
            _ => Err(format!("give a whole number from {low} to {high}")),
        },
        Values::Multiple(step, low, high) => match value.parse::<u32>() {
            Ok(n) if (low..=high).contains(&n) && n.is_multiple_of(step) && n.to_string() == value => Ok(()),
            _ => Err(format!("give a whole number from {low} to {high} that is divisible by {step}")),
        },
        Values::Path(_) if value.is_empty() || value.contains(char::is_control) => {
            Err("give the name of a file, without commas, | and line breaks".into())
        }
        Values::Path(_) => Ok(()),
    }
}
