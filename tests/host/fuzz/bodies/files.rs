//! Files: any bytes must give a scene with valid numbers, or an error of one line that names the file.

use super::assert_one_line;
use super::memory::bounded;
use super::valid::assert_valid;
use gobo::scene::Scene;

/// Files that glTF files may refer to.
const LEAF: &[(&str, &[u8])] = &[("leaf.bin", include_bytes!("../../../../fuzz/seeds/gltf/leaf.bin"))];

/// Files that scene files may refer to.
const BESIDE: &[(&str, &[u8])] = &[
    ("smoke.ply", include_bytes!("../../../../fuzz/seeds/ply/ok-particles-ascii.ply")),
    ("ground.ply", include_bytes!("../../../../fuzz/seeds/ply/ok-mesh-ascii.ply")),
    ("lit.glb", include_bytes!("../../../../fuzz/seeds/gltf/ok-lights-and-camera.gltf")),
    ("garden.splat", include_bytes!("../../../../fuzz/seeds/splat/ok-two.splat")),
    ("cloud.nrrd", include_bytes!("../../../../fuzz/seeds/nrrd/ok-bytes.nrrd")),
    ("fog.vdb", include_bytes!("../../../../fuzz/seeds/vdb/ok-plain.vdb")),
    ("head.hair", include_bytes!("../../../../fuzz/seeds/hair/ok-defaults.hair")),
];

/// Returns a scene file that refers to the file in the given table.
fn placing(table: &str, name: &str) -> String {
    format!(
        "[[{table}]]\nfile = \"{name}\"\nscale = 2.0\ntranslate = [0, 0, 1]\n\
        [light]\nkind = \"directional\"\ndirection = [0, 0, -1]\n\
        [camera]\nposition = [3, 0, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov_y_degrees = 40\n"
    )
}

/// Loads a file by itself and, if that is a scene, through scene files too, which may refuse what is too large once placed.
fn alone_and_placed(name: &str, bytes: &[u8], tables: &[&str]) -> bool {
    let is_scene = load(name, bytes, LEAF);
    for table in tables.iter().filter(|_| is_scene) {
        load("scene.toml", placing(table, name).as_bytes(), &[LEAF, &[(name, bytes)]].concat());
    }
    is_scene
}

/// Loads a file of that name, with the other files next to it.
fn load(name: &str, bytes: &[u8], beside: &[(&str, &[u8])]) -> bool {
    load_and_more(name, bytes, beside, 0)
}

/// Same as `load`, but allows memory for `more` bytes of input.
fn load_and_more(name: &str, bytes: &[u8], beside: &[(&str, &[u8])], more: usize) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    beside.iter().for_each(|(name, bytes)| write(name, bytes));
    write(name, bytes);
    let path = folder.path().join(name);
    let input_bytes = more + bytes.len() + beside.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
    match bounded(input_bytes, || Scene::load(path.to_str().expect("UTF-8"), 0.0)) {
        Ok(scene) => assert_valid(&scene),
        Err(error) => {
            assert_one_line(&error, &folder.path().to_string_lossy());
            return false;
        }
    }
    true
}

/// Fuzzes particles, splats and meshes.
pub fn ply(bytes: &[u8]) -> bool {
    alone_and_placed("input.ply", bytes, &["particles", "splats", "meshes"])
}

/// Fuzzes HAIR files.
pub fn hair(bytes: &[u8]) -> bool {
    alone_and_placed("input.hair", bytes, &["hair"])
}

/// Fuzzes splats of 32 bytes.
pub fn splat(bytes: &[u8]) -> bool {
    alone_and_placed("input.splat", bytes, &["splats"])
}

/// Fuzzes packed and zipped splats. Deflate makes up to 1,032 bytes of one, so more memory is allowed, as for more input.
pub fn spz(bytes: &[u8]) -> bool {
    let more = 4 * bytes.len();
    load_and_more("input.spz", bytes, &[], more)
        && load_and_more("scene.toml", placing("splats", "input.spz").as_bytes(), &[("input.spz", bytes)], more)
}

/// Fuzzes zip archives of images of splats. An image may have many pixels per byte.
pub fn sog(bytes: &[u8]) -> bool {
    let more = 8 * bytes.len();
    load_and_more("input.sog", bytes, &[], more)
        && load_and_more("scene.toml", placing("splats", "input.sog").as_bytes(), &[("input.sog", bytes)], more)
}

/// Fuzzes splats in buckets.
pub fn ksplat(bytes: &[u8]) -> bool {
    alone_and_placed("input.ksplat", bytes, &["splats"])
}

/// Fuzzes grids with a header.
pub fn nrrd(bytes: &[u8]) -> bool {
    alone_and_placed("input.nrrd", bytes, &["volumes"])
}

/// Fuzzes sparse grids. Their constant tiles expand to whole fields from few bytes, so more memory is allowed, as for more input.
pub fn vdb(bytes: &[u8]) -> bool {
    load_and_more("input.vdb", bytes, &[], 2 << 20)
        && load_and_more("scene.toml", placing("volumes", "input.vdb").as_bytes(), &[("input.vdb", bytes)], 2 << 20)
}

/// Fuzzes the same grids as they are laid out for GPUs. Zip makes up to 1,032 bytes of one.
pub fn nvdb(bytes: &[u8]) -> bool {
    let more = (2 << 20) + 4 * bytes.len();
    load_and_more("input.nvdb", bytes, &[], more)
        && load_and_more("scene.toml", placing("volumes", "input.nvdb").as_bytes(), &[("input.nvdb", bytes)], more)
}

/// Fuzzes files that name a grid next to them; skips input that could name a file elsewhere.
pub fn volume(bytes: &[u8]) -> bool {
    if bytes.iter().any(|byte| matches!(byte, b'/' | b'\\')) {
        return false;
    }
    load("input.volume", bytes, &[("grid.raw", &[0, 1, 2, 4, 8, 16, 32, 64, 128, 255, 0, 0])])
}

/// Fuzzes TressFX files.
pub fn tressfx(bytes: &[u8]) -> bool {
    alone_and_placed("input.tfx", bytes, &["hair"])
}

/// Fuzzes glTF, text or binary. Skips names that could lead out of the folder: strings that begin with a slash, `..`, and escapes that
/// could spell them.
pub fn gltf(bytes: &[u8]) -> bool {
    let has = |what: &[u8]| bytes.windows(what.len()).any(|window| window == what);
    if has(b"\"/") || has(b"..") || has(b"\\") || has(b"%2") || has(b"%5") {
        return false;
    }
    alone_and_placed("input.gltf", bytes, &["meshes"])
}

/// Fuzzes scene files with other files next to them; skips input that could name files elsewhere.
pub fn scene(bytes: &[u8]) -> bool {
    if bytes.iter().any(|byte| matches!(byte, b'/' | b'\\')) {
        return false;
    }
    load("input.toml", bytes, BESIDE)
}
