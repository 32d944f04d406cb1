//! The one error type of the library: what failed, the thing's name, the cause and the way out.

use std::path::{Path, PathBuf};

/// Everything that can go wrong, each printed as one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something the user handed in (a file, an option, a scene) cannot be used.
    #[error("{name}: {cause}; {way_out}")]
    Input {
        /// The file, option or scene.
        name: String,
        /// What is wrong with it.
        cause: String,
        /// What the user can do.
        way_out: String,
    },
    /// A Vulkan operation failed.
    #[error("cannot {operation} {name}: {cause}; {way_out}")]
    Gpu {
        /// What was being done ("create buffer").
        operation: &'static str,
        /// The object's debug name.
        name: String,
        /// The driver's or allocator's answer.
        cause: String,
        /// What the user can do.
        way_out: String,
    },
    /// A result could not be written.
    #[error("cannot write {}: {cause}; {way_out}", path.display())]
    Output {
        /// The file that was to be written.
        path: PathBuf,
        /// The system's answer.
        cause: String,
        /// What the user can do.
        way_out: String,
    },
    /// The device lacks a feature that a technique's path needs. A result, not a failure.
    #[error("refused: needs {needs}")]
    Refused {
        /// The missing feature by its Vulkan name.
        needs: String,
    },
}

/// Short for a result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An [`Error::Input`].
    pub fn input(name: impl Into<String>, cause: impl ToString, way_out: impl Into<String>) -> Self {
        Self::Input { name: name.into(), cause: cause.to_string(), way_out: way_out.into() }
    }

    /// An [`Error::Output`] with the way out that fits most causes.
    pub fn output(path: &Path, cause: impl ToString) -> Self {
        Self::Output {
            path: path.to_path_buf(),
            cause: cause.to_string(),
            way_out: "check free space and permissions, or choose another place with --out".into(),
        }
    }
}

/// ` (did you mean avsm?)`, for the cause of an error; empty where nothing that is known is near.
pub(crate) fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let length = given.chars().count();
    // Anything is near numbers, and a letter or two.
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
