//! The one error type of the library: what failed, the thing's name, the cause and the way out.

use crate::gpu::{Limit, Requirement};
use ash::vk;
use std::fmt;
use std::path::{Path, PathBuf};

/// Everything that can go wrong, each printed as one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Something that was handed in (a file, an option, a scene) cannot be used.
    #[error("{name}: {cause}; {way_out}")]
    Input {
        /// The file, option or scene.
        name: String,
        /// The fault that was found.
        cause: String,
        /// What may help.
        way_out: WayOut,
    },
    /// What was named or given in a call or in a command line is wrong whatever files and devices there are: a technique, a
    /// key or a scene that does not exist, a number that is never allowed.
    #[error("{name}: {cause}; {way_out}")]
    Usage {
        /// The word or the option.
        name: String,
        /// The fault that was found.
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
        /// The driver's or allocator's answer.
        cause: GpuCause,
        /// What may help.
        way_out: WayOut,
    },
    /// A result could not be written.
    #[error("cannot write {}: {cause}; {way_out}", path.display())]
    Output {
        /// The file that was to be written.
        path: PathBuf,
        /// The system's answer.
        cause: String,
        /// What may help.
        way_out: WayOut,
    },
    /// The device or the world lacks what a technique's path needs. A result, not a failure.
    #[error("refused: needs {0}")]
    Refused(Need),
}

/// What was needed where something is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// A feature of the device.
    Feature(Requirement),
    /// A limit of the device, at least so high.
    Limit {
        /// The limit, and the least value that is enough.
        limit: Limit,
        /// The device's value.
        has: u64,
        /// What the value is needed for, or nothing; begins with a space.
        what: String,
    },
    /// A queue on which Gobo may submit: an adopted device's is its owner's.
    Queue,
    /// Virtual lights in the scene.
    VirtualLights,
    /// What the sentence says, of the world, the scene or the settings.
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
    /// What Vulkan returned.
    Vulkan(vk::Result),
    /// What the sentence says.
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

/// Short for a result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What may help. It names no option of any program; a program that has options for it can say them instead
/// ([`Error::with_way_out`]).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WayOut {
    /// A sentence.
    Words(String),
    /// Any one of these: less of something, or another device.
    Less(&'static [Less]),
    /// The Vulkan loader, to be installed.
    Loader,
    /// A Vulkan 1.3 driver, to be installed.
    Driver,
    /// The validation layer, to be installed, or no validation.
    Layer,
    /// A newer driver, or another device.
    OtherDevice,
    /// A place that can be written to.
    OtherPlace,
    /// A sentence that ends with the command that makes a bake.
    Bake(String),
    /// These specs, each given alone and not together with the others.
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
    /// Less of nothing: a device with more memory.
    MoreMemory,
    /// Less of nothing: another device, with higher limits.
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

/// `a, b or c`.
pub(crate) fn one_of(all: impl Iterator<Item = String>) -> String {
    let mut all: Vec<_> = all.collect();
    match (all.pop(), all.join(", ")) {
        (Some(last), first) if !first.is_empty() => format!("{first} or {last}"),
        (last, _) => last.unwrap_or_default(),
    }
}

impl Error {
    /// An [`Error::Input`].
    pub fn input(name: impl Into<String>, cause: impl ToString, way_out: impl Into<WayOut>) -> Self {
        Self::Input { name: name.into(), cause: cause.to_string(), way_out: way_out.into() }
    }

    /// An [`Error::Usage`].
    pub fn usage(name: impl Into<String>, cause: impl ToString, way_out: impl Into<WayOut>) -> Self {
        Self::Usage { name: name.into(), cause: cause.to_string(), way_out: way_out.into() }
    }

    /// An [`Error::Input`] as an [`Error::Usage`]; others stay as they are.
    #[must_use]
    pub fn as_usage(self) -> Self {
        match self {
            Self::Input { name, cause, way_out } => Self::Usage { name, cause, way_out },
            other => other,
        }
    }

    /// An [`Error::Output`] with the way out that fits most causes.
    pub fn output(path: &Path, cause: impl ToString) -> Self {
        Self::Output { path: path.to_path_buf(), cause: cause.to_string(), way_out: WayOut::OtherPlace }
    }

    /// The way out; a refusal only says what is needed.
    pub fn way_out(&self) -> Option<&WayOut> {
        match self {
            Self::Input { way_out, .. }
            | Self::Usage { way_out, .. }
            | Self::Gpu { way_out, .. }
            | Self::Output { way_out, .. } => Some(way_out),
            Self::Refused { .. } => None,
        }
    }

    /// The same error with another way out; a refusal stays as it is.
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

    /// The same error with another name of the input; only an [`Error::Input`] and an [`Error::Usage`] have one.
    #[must_use]
    pub fn with_name(mut self, other: impl FnOnce(&str) -> String) -> Self {
        if let Self::Input { name, .. } | Self::Usage { name, .. } = &mut self {
            *name = other(name);
        }
        self
    }
}

/// ` (did you mean avsm?)`, for the cause of an error; empty where no known word is similar.
pub(crate) fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let length = given.chars().count();
    // Too many words are similar to a number or to a letter or two.
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
