//! Files as memory. This module is in `gpu` because mapping takes `unsafe`, and because mapped files go to the device.

use std::fs::File;
use std::io;
use std::ops::Deref;
use std::path::Path;

/// The bytes of a regular file. With the feature `program` the file is mapped, and its bytes come from the disk when
/// they are read; without the feature all of it is read into memory at once.
#[cfg(feature = "program")]
pub struct Mapped(memmap2::Mmap);

/// The bytes of a regular file, read into memory.
#[cfg(not(feature = "program"))]
pub struct Mapped(Vec<u8>);

impl Mapped {
    /// Opens a file.
    ///
    /// # Errors
    /// The system's error, or one for a folder, a pipe or a device, which are no regular files.
    pub fn open(path: &Path) -> io::Result<Self> {
        // The kind of file is checked before opening: opening a pipe waits for its writer.
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
        // SAFETY: the bytes are only read, and as bytes, of which all values are valid. They must not change while they are mapped: this
        // program never writes into an existing file. It puts a new file in the place of the old one, and the bytes of the old file stay as
        // they were.
        Ok(Self(unsafe { memmap2::Mmap::map(&file) }?))
    }
}

impl Deref for Mapped {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}
