//! SPIR-V that an earlier build made of the same texts. Cargo gives each set of features a folder of its own, in which every shader would be
//! compiled once more; and where one shader has changed, the others have not.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// A folder beside those of cargo, with a file for each shader.
pub struct Cache {
    folder: PathBuf,
    /// Which library compiles.
    compiler: u64,
}

impl Cache {
    /// The folder of all builds whose own are where `out` is. `None` where SHADERC_LIB_DIR has no library: then it is not known here which
    /// one this program was linked with.
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

    /// The name of the file for what is compiled of `texts`, which are all that the outcome depends on: 128 bits, so that no two texts
    /// share it.
    pub fn key(&self, texts: &impl Hash) -> String {
        let half = |number: u64| {
            let mut hasher = DefaultHasher::new();
            (number, self.compiler, texts).hash(&mut hasher);
            hasher.finish()
        };
        format!("{:016x}{:016x}.spv", half(0), half(1))
    }

    /// What is kept under `key`, if it is SPIR-V: the disk may have lost what was being written as a machine went down.
    pub fn get(&self, key: &str) -> Option<Vec<u8>> {
        const MAGIC: [u8; 4] = 0x0723_0203_u32.to_ne_bytes();
        fs::read(self.folder.join(key)).ok().filter(|spirv| spirv.starts_with(&MAGIC))
    }

    /// Keeps `spirv`, whole or not at all, also where another build writes the same. One that cannot be kept is compiled again.
    pub fn put(&self, key: &str, spirv: &[u8]) {
        let part = self.folder.join(format!("{key}.{}", process::id()));
        let _ = fs::write(&part, spirv).and_then(|()| fs::rename(&part, self.folder.join(key)));
    }

    /// Removes what is not under one of `keys`, so that the folder does not grow with each change. What another build writes meanwhile
    /// may go too, and is then compiled again.
    pub fn keep_only(&self, keys: &[String]) {
        for file in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let name = file.file_name();
            if keys.iter().all(|key| name != key[..]) {
                let _ = fs::remove_file(file.path());
            }
        }
    }
}
