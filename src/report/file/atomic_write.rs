//! Atomic file writes: after a crash or on a full disk, a reader finds the old file or the new one, never half of one.

use crate::gpu::fault;
use crate::{Error, Result};
use std::io::Write;
use std::path::Path;

/// Suffix of a file's name until the file is complete. A process that is killed may leave such a file behind.
const UNFINISHED: &str = ".unfinished";

/// Writes a temporary file next to `path` and renames it to `path` once it is on disk. If `path` is not a regular file (a pipe, say), the
/// bytes are written to it directly.
///
/// # Errors
/// [`Error::Output`] names the file; an old file stays unchanged.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let written = || -> std::io::Result<()> {
        if std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            fault::write()?;
            return std::fs::write(path, bytes);
        }
        let name = path.file_name().ok_or_else(|| std::io::Error::other("it names no file"))?;
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{}.", name.to_string_lossy());
        builder.prefix(&prefix).suffix(UNFINISHED);
        // A temporary file is readable by its owner alone by default; a result must be as readable as any other file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        file.write_all(bytes)?;
        fault::write()?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        Ok(())
    };
    // tempfile appends the temporary file's path to the cause, which would put a second path on the line.
    written().map_err(|cause| {
        let told = cause.to_string();
        Error::output(path, told.split(" at path \"").next().unwrap_or(&told))
    })
}

/// Removes the unfinished files of killed processes from a folder. A file that cannot be removed does no harm.
pub fn remove_unfinished(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with('.') && name.ends_with(UNFINISHED) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Writes a PNG of `size` pixels from `rgb8`: rows from the top, three bytes per pixel.
///
/// # Errors
/// See [`write_whole`]; also if `rgb8` has the wrong number of bytes.
pub fn write_png(path: &Path, [width, height]: [u32; 2], rgb8: &[u8]) -> Result<()> {
    if rgb8.len() as u64 != u64::from(width) * u64::from(height) * 3 {
        return Err(Error::output(path, format!("{} bytes for {width} × {height} pixels", rgb8.len())));
    }
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    image::ImageEncoder::write_image(encoder, rgb8, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|cause| Error::output(path, cause))?;
    write_whole(path, &png)
}
