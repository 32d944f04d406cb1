//! Memory-mapped files. This module is in `gpu` because mapping needs `unsafe`, and because mapped files are uploaded.

use std::fs::File;
use std::io;
use std::ops::Deref;
use std::path::Path;

/// The bytes of a regular file. With the feature `program`, the file is mapped, and its bytes are loaded from disk as
/// they are read; without the feature, the whole file is read into memory at once.
#[cfg(feature = "program")]
pub struct Mapped(memmap2::Mmap);

/// The bytes of a regular file, read into memory.
#[cfg(not(feature = "program"))]
pub struct Mapped(Vec<u8>);

impl Mapped {
    /// Opens a file.
    ///
    /// # Errors
    /// The system's error, or an error for a folder, a pipe or a device, which are not regular files.
    pub fn open(path: &Path) -> io::Result<Self> {
        // Check the kind of file before opening it: opening a pipe waits for its writer.
        if !std::fs::metadata(path)?.is_file() {
            return Err(io::Error::other("not a regular file"));
        }
        Self::of(File::open(path)?)
    }

    #[cfg(not(feature = "program"))]
    fn of(mut file: File) -> io::Result<Self> {
        let mut bytes = Vec::new();
        io::Read::read_to_end(&mut file, &mut bytes)?;
        Ok(Self(bytes))
    }

    #[cfg(feature = "program")]
    fn of(file: File) -> io::Result<Self> {
        // SAFETY: the mapping is only read, and as bytes, for which every value is valid. The bytes must not change while they are mapped:
        // this program never writes to an existing file. It replaces the old file with a new one, and the bytes of the old file remain
        // unchanged.
        Ok(Self(unsafe { memmap2::Mmap::map(&file) }?))
    }
}

impl Deref for Mapped {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}
