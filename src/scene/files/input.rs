//! Opens the user's files, and formats error messages about them.

use crate::{Error, Result, WayOut};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Maximum length of a message taken over from another crate, in characters. Parsers may quote whole lines of the input.
const MAX_MESSAGE_CHARS: usize = 300;

/// Folds a multi-line message into one line, because every error of this program is a single line.
pub(in crate::scene) fn one_line(text: impl ToString) -> String {
    let text = text.to_string();
    let words = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty());
    let folded = words.collect::<Vec<_>>().join(" ");
    match folded.char_indices().nth(MAX_MESSAGE_CHARS) {
        Some((end, _)) => format!("{}…", folded.get(..end).unwrap_or_default()),
        None => folded,
    }
}

/// Returns a file's name for messages. Control characters, such as line breaks, become `?`.
pub(in crate::scene) fn file_name(path: &Path) -> String {
    path.display().to_string().replace(char::is_control, "?")
}

/// Returns the name that a file gives to a scene or a mesh: its own name, without directory and extension.
pub(in crate::scene) fn stem(path: &Path) -> String {
    let name = path.file_stem().unwrap_or_default();
    file_name(Path::new(name))
}

/// Returns a file's extension without the dot, in lower case; empty if it has none.
pub(in crate::scene) fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Returns what is wrong with a file of a format that is not read, and how to convert it, by its extension; `None` for other files.
pub(in crate::scene) fn foreign(ending: &str) -> Option<(&'static str, &'static str)> {
    match ending {
        "abc" => {
            Some(("Alembic is not read", "make a .hair of its curves: python results/files/abc_to_hair.py IN OUT.hair"))
        }
        "usd" | "usda" | "usdc" | "usdz" => {
            let way_out = "make a .hair of its curves: python results/files/usd_to_hair.py IN OUT.hair; of its meshes a .glb by Blender";
            Some(("USD is not read", way_out))
        }
        _ => None,
    }
}

/// Creates an [`Error::Input`] about a file.
pub(in crate::scene) fn error(path: &Path, cause: impl ToString, way_out: impl Into<WayOut>) -> Error {
    Error::input(file_name(path), one_line(cause), way_out)
}

/// Returns a note about a file that has `count` of something; none if it has none.
pub(in crate::scene) fn note(path: &Path, count: usize, one: &str, many: &str) -> Option<String> {
    let told = if count == 1 { format!("1 {one}") } else { format!("{count} {many}") };
    (count > 0).then(|| format!("{}: {told}", file_name(path)))
}

/// Returns a function that turns the error of a referenced file into one that names both files.
pub(in crate::scene) fn named_by(asker: &Path) -> impl Fn(Error) -> Error {
    move |error| error.with_name(|name| format!("{name}, which {} names", file_name(asker)))
}

/// Opens a regular file and returns its size in bytes. Rejects folders, pipes and devices: a loader that waits for a pipe or reads
/// /dev/zero never ends.
pub(in crate::scene) fn open(path: &Path) -> Result<(File, u64)> {
    let unreadable = |cause: std::io::Error| error(path, cause, "check the path and its permissions");
    // Checked before opening, because opening a pipe blocks until there is a writer.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(error(path, "not a regular file", "give a file"));
    }
    Ok((File::open(path).map_err(unreadable)?, metadata.len()))
}

/// Reads a whole regular file.
pub(in crate::scene) fn read(path: &Path) -> Result<Vec<u8>> {
    let (mut file, _) = open(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|cause| error(path, cause, "check the disk and the file's permissions"))?;
    Ok(bytes)
}
