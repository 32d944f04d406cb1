//! SPIR-V that an earlier build compiled from the same texts. Cargo gives each set of features its own folder, in which every shader would
//! be compiled once more; and when one shader changes, the others need not be compiled again.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// A folder next to cargo's own, with one file per shader.
pub struct Cache {
    folder: PathBuf,
    /// Hash that identifies the compiler library.
    compiler: u64,
}

impl Cache {
    /// Opens the folder shared by all builds whose own folders are next to that of `out`. `None` if SHADERC_LIB_DIR has no library: it is
    /// then unknown which one this program was linked with.
    pub fn open(out: &Path) -> Option<Self> {
        let libraries = fs::read_dir(env::var_os("SHADERC_LIB_DIR")?).ok()?.flatten();
        let mut libraries: Vec<_> =
            libraries.filter(|file| file.file_name().to_string_lossy().contains("shaderc")).map(|f| f.path()).collect();
        libraries.sort();
        let mut hasher = DefaultHasher::new();
        for library in &libraries {
            hasher.write(&fs::read(library).ok()?);
        }
        // `out` is target/release/build/gobo-…/out.
        let folder = out.ancestors().nth(3).filter(|_| !libraries.is_empty())?.join("shaders");
        fs::create_dir_all(&folder).ok()?;
        Some(Self { folder, compiler: hasher.finish() })
    }

    /// Returns the file name for the SPIR-V compiled from `texts`, which are everything that the result depends on. It has 128 bits, so
    /// that no two texts share it.
    pub fn key(&self, texts: &impl Hash) -> String {
        let half = |number: u64| {
            let mut hasher = DefaultHasher::new();
            (number, self.compiler, texts).hash(&mut hasher);
            hasher.finish()
        };
        format!("{:016x}{:016x}.spv", half(0), half(1))
    }

    /// Returns the file stored under `key` if it is SPIR-V: the disk may have lost a write when a machine went down.
    pub fn get(&self, key: &str) -> Option<Vec<u8>> {
        const MAGIC: [u8; 4] = 0x0723_0203_u32.to_ne_bytes();
        fs::read(self.folder.join(key)).ok().filter(|spirv| spirv.starts_with(&MAGIC))
    }

    /// Stores `spirv`, whole or not at all, even if another build writes the same file. A shader that cannot be stored is compiled again.
    pub fn put(&self, key: &str, spirv: &[u8]) {
        let part = self.folder.join(format!("{key}.{}", process::id()));
        let _ = fs::write(&part, spirv).and_then(|()| fs::rename(&part, self.folder.join(key)));
    }

    /// Removes the files whose name is not in `keys`, so that the folder does not grow with each change. Files that another build is
    /// writing may be removed too, and are then compiled again.
    pub fn keep_only(&self, keys: &[String]) {
        for file in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = file.file_name();
            if keys.iter().all(|key| name != key[..]) {
                let _ = fs::remove_file(file.path());
            }
        }
    }
}
