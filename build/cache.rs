//! A cache of compiled SPIR-V, looked up by the texts that it was compiled from. Cargo gives each set of features its own folder, so
//! without the cache each of them would compile every shader; and if one shader changes, the others are not compiled again.

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
    /// Opens the folder `shaders` next to cargo's folder `build`, shared by all builds of this profile. Returns `None` if SHADERC_LIB_DIR
    /// contains no library: it is then unknown which library this program was linked with.
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

    /// Returns the file name for the SPIR-V compiled from `texts`, which are everything that the result depends on. The name is a 128-bit
    /// hash, so that different texts get different names.
    pub fn key(&self, texts: &impl Hash) -> String {
        let half = |number: u64| {
            let mut hasher = DefaultHasher::new();
            (number, self.compiler, texts).hash(&mut hasher);
            hasher.finish()
        };
        format!("{:016x}{:016x}.spv", half(0), half(1))
    }

    /// Returns the file stored under `key` if it is SPIR-V: after a crash of the machine, its contents may be missing.
    pub fn get(&self, key: &str) -> Option<Vec<u8>> {
        const MAGIC: [u8; 4] = 0x0723_0203_u32.to_ne_bytes();
        fs::read(self.folder.join(key)).ok().filter(|spirv| spirv.starts_with(&MAGIC))
    }

    /// Stores `spirv` atomically, even if another build writes the same file. A shader that cannot be stored is compiled again by the next
    /// build.
    pub fn put(&self, key: &str, spirv: &[u8]) {
        let part = self.folder.join(format!("{key}.{}", process::id()));
        let _ = fs::write(&part, spirv).and_then(|()| fs::rename(&part, self.folder.join(key)));
    }

    /// Removes the files whose name is not in `keys`, so that the folder does not grow with each change. This may also remove files that
    /// another build is writing; their shaders are then compiled again.
    pub fn keep_only(&self, keys: &[String]) {
        for file in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = file.file_name();
            if keys.iter().all(|key| name != key[..]) {
                let _ = fs::remove_file(file.path());
            }
        }
    }
}
