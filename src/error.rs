//! The library's only error type: what failed, the object's name, the cause and the way out.

use crate::gpu::{Limit, Requirement};
use ash::vk;
use std::fmt;
use std::path::{Path, PathBuf};

/// Everything that can go wrong; each error prints as one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An input (a file, an option, a scene) cannot be used.
    #[error("{name}: {cause}; {way_out}")]
    Input {
        /// The file, option or scene.
        name: String,
        /// What is wrong with it.
        cause: String,
        /// What may help.
        way_out: WayOut,
    },
    /// A name or an argument, in a call or on the command line, is wrong regardless of files and devices: a technique, a key or a scene
    /// that does not exist, a number that is never allowed.
    #[error("{name}: {cause}; {way_out}")]
    Usage {
        /// The offending word or option.
        name: String,
        /// What is wrong with it.
        cause: String,
        /// What may help.
        way_out: WayOut,
    },
    /// A Vulkan operation failed.
    #[error("cannot {operation} {name}: {cause}; {way_out}")]
    Gpu {
        /// What was being done ("create buffer").
        operation: &'static str,
        /// The object's debug name.
        name: String,
        /// The error reported by the driver or the allocator.
        cause: GpuCause,
        /// What may help.
        way_out: WayOut,
    },
    /// A result could not be written.
    #[error("cannot write {}: {cause}; {way_out}", path.display())]
    Output {
        /// The file that could not be written.
        path: PathBuf,
        /// The error reported by the operating system.
        cause: String,
        /// What may help.
        way_out: WayOut,
    },
    /// The device or the world lacks something that a technique's path needs. This is a result, not a failure.
    #[error("refused: needs {0}")]
    Refused(Need),
}

/// The requirement behind a refusal.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// A feature of the device.
    Feature(Requirement),
    /// A limit of the device, which is too low.
    Limit {
        /// The limit, with the lowest value that suffices.
        limit: Limit,
        /// The device's value.
        has: u64,
        /// The purpose of the value, with a leading space; may be empty.
        what: String,
    },
    /// A queue that Gobo may submit to. An adopted device's queue belongs to its owner.
    Queue,
    /// Virtual lights in the scene.
    VirtualLights,
    /// A requirement on the world, the scene or the settings, in words.
    Words(String),
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Feature(requirement) => f.write_str(requirement.name()),
            Self::Limit { limit, has, what } => {
                write!(f, "{} of at least {}{what} (this device has {has})", limit.name, limit.least)
            }
            Self::Queue => f.write_str(
                "a queue, and the device's is its owner's: record it (Commands::on), and read back a frame later (Commands::read_back)",
            ),
            Self::VirtualLights => f.write_str("virtual point lights"),
            Self::Words(words) => f.write_str(words),
        }
    }
}

impl From<&str> for Need {
    fn from(words: &str) -> Self {
        Self::Words(words.into())
    }
}

impl From<String> for Need {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<Requirement> for Need {
    fn from(requirement: Requirement) -> Self {
        Self::Feature(requirement)
    }
}

/// Why an operation of the GPU failed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuCause {
    /// The result code that Vulkan returned.
    Vulkan(vk::Result),
    /// The cause, in words.
    Words(String),
}

impl fmt::Display for GpuCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vulkan(result) => write!(f, "{result:?}"),
            Self::Words(words) => f.write_str(words),
        }
    }
}

impl From<&str> for GpuCause {
    fn from(words: &str) -> Self {
        Self::Words(words.into())
    }
}

impl From<String> for GpuCause {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

/// Shorthand for a result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What may help. It mentions no program's options; a program that has suitable ones can substitute them ([`Error::with_way_out`]).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WayOut {
    /// A sentence.
    Words(String),
    /// Use any one of these: less of something, or another device.
    Less(&'static [Less]),
    /// Install the Vulkan loader.
    Loader,
    /// Install a Vulkan 1.3 driver.
    Driver,
    /// Install the validation layer, or run without validation.
    Layer,
    /// Update the driver, or use another device.
    OtherDevice,
    /// Check free space and permissions, or write to another place.
    OtherPlace,
    /// A sentence that ends with the command that creates a bake.
    Bake(String),
    /// Give each of these specs alone, not together with the others.
    Each(Vec<String>),
}

/// What to use less of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Less {
    /// Texels of a map.
    Map,
    /// Slices of a map.
    Slices,
    /// Particles and strands.
    Casters,
    /// Lights.
    Lights,
    /// Nothing less: a device with more memory.
    MoreMemory,
    /// Nothing less: another device, with higher limits.
    OtherDevice,
}

impl fmt::Display for Less {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Map => "a smaller map",
            Self::Slices => "fewer slices",
            Self::Casters => "fewer casters",
            Self::Lights => "fewer lights",
            Self::MoreMemory => "a device with more memory",
            Self::OtherDevice => "another device",
        })
    }
}

impl fmt::Display for WayOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(words) | Self::Bake(words) => f.write_str(words),
            Self::Less(less) => write!(f, "use {}", one_of(less.iter().map(Less::to_string))),
            Self::Loader => f.write_str("install it"),
            Self::Driver => f.write_str("install a Vulkan 1.3 driver"),
            Self::Layer => f.write_str("install it, or ask for no validation"),
            Self::OtherDevice => f.write_str("update the driver, or choose another device"),
            Self::OtherPlace => f.write_str("check free space and permissions, or choose another place"),
            Self::Each(specs) if specs.is_empty() => f.write_str("give each technique alone"),
            Self::Each(specs) => write!(f, "give each alone: {}", specs.join("; ")),
        }
    }
}

impl From<&str> for WayOut {
    fn from(words: &str) -> Self {
        Self::Words(words.into())
    }
}

impl From<String> for WayOut {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

/// Joins the items as `a, b or c`.
pub(crate) fn one_of(all: impl Iterator<Item = String>) -> String {
    let mut all: Vec<_> = all.collect();
    match (all.pop(), all.join(", ")) {
        (Some(last), first) if !first.is_empty() => format!("{first} or {last}"),
        (last, _) => last.unwrap_or_default(),
    }
}

impl Error {
    /// Creates an [`Error::Input`].
    pub fn input(name: impl Into<String>, cause: impl ToString, way_out: impl Into<WayOut>) -> Self {
        Self::Input { name: name.into(), cause: cause.to_string(), way_out: way_out.into() }
    }

    /// Creates an [`Error::Usage`].
    pub fn usage(name: impl Into<String>, cause: impl ToString, way_out: impl Into<WayOut>) -> Self {
        Self::Usage { name: name.into(), cause: cause.to_string(), way_out: way_out.into() }
    }

    /// Turns an [`Error::Input`] into an [`Error::Usage`]; other errors are unchanged.
    #[must_use]
    pub fn as_usage(self) -> Self {
        match self {
            Self::Input { name, cause, way_out } => Self::Usage { name, cause, way_out },
            other => other,
        }
    }

    /// Creates an [`Error::Output`] with the way out that fits most causes.
    pub fn output(path: &Path, cause: impl ToString) -> Self {
        Self::Output { path: path.to_path_buf(), cause: cause.to_string(), way_out: WayOut::OtherPlace }
    }

    /// Returns the way out; `None` for a refusal, which only states what is needed.
    pub fn way_out(&self) -> Option<&WayOut> {
        match self {
            Self::Input { way_out, .. }
            | Self::Usage { way_out, .. }
            | Self::Gpu { way_out, .. }
            | Self::Output { way_out, .. } => Some(way_out),
            Self::Refused { .. } => None,
        }
    }

    /// Replaces the way out; a refusal is unchanged.
    #[must_use]
    pub fn with_way_out(mut self, other: impl Into<WayOut>) -> Self {
        match &mut self {
            Self::Input { way_out, .. }
            | Self::Usage { way_out, .. }
            | Self::Gpu { way_out, .. }
            | Self::Output { way_out, .. } => {
                *way_out = other.into();
            }
            Self::Refused { .. } => {}
        }
        self
    }

    /// Replaces the name of an [`Error::Input`] or [`Error::Usage`]; other errors are unchanged.
    #[must_use]
    pub fn with_name(mut self, other: impl FnOnce(&str) -> String) -> Self {
        if let Self::Input { name, .. } | Self::Usage { name, .. } = &mut self {
            *name = other(name);
        }
        self
    }
}

/// Returns ` (did you mean avsm?)` for the cause of an error; empty if no known word is similar.
pub(crate) fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let length = given.chars().count();
    // Numbers and words of one or two letters resemble too many other words.
    if !(3..=64).contains(&length) || !given.contains(char::is_alphabetic) {
        return String::new();
    }
    let given = given.to_lowercase();
    let changes = |known: &str| match known.starts_with(&given) {
        true => 0,
        false => strsim::damerau_levenshtein(&given, known),
    };
    let nearest = known.into_iter().map(|known| (changes(known), known)).min_by_key(|(changes, _)| *changes);
    let near = nearest.filter(|(changes, _)| *changes <= (length / 3).max(1));
    near.map_or_else(String::new, |(_, known)| format!(" (did you mean {known}?)"))
}

#[cfg(test)]
mod tests {
    use super::did_you_mean;

    #[test]
    fn what_is_near_is_meant() {
        let known = ["avsm", "voxel-grid", "voxelized", "exponential", "4", "16"];
        for (given, meant) in [
            ("vsm", "avsm"),
            ("AVSM", "avsm"),
            ("voxelgrid", "voxel-grid"),
            ("voxelised", "voxelized"),
            ("exp", "exponential"),
            ("expoential", "exponential"),
        ] {
            assert_eq!(did_you_mean(given, known), format!(" (did you mean {meant}?)"));
        }
        for given in ["", "av", "5", "161", "shadow-map", "linear", &"avsm".repeat(100)] {
            assert_eq!(did_you_mean(given, known), "", "{given}");
        }
        assert_eq!(did_you_mean("avsm", []), "");
    }
}
