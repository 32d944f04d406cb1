//! Volumes from files: grids of densities, with their placement in space.
//!
//! | extension | what it is |
//! |---|---|
//! | `.volume` | TOML that names a raw file of a dense grid beside it |
//! | `.nrrd` | a dense grid with its header ([`nrrd_file`]) |
//! | `.vdb` | a sparse grid among others ([`vdb_file`]) |
//!
//! ```toml
//! file = "smoke.raw"            # beside it: samples, x first, then y, then z
//! size = [64, 64, 96]           # samples along x, y, z
//! type = "f32"                  # or "u8" or "u16", whose largest value is density 1
//! endian = "little"             # optional, or "big"
//! spacing = [0.1, 0.1, 0.1]     # optional, world units between samples
//! origin = [0.0, 0.0, 0.0]      # optional, position of the first sample
//! extinction = 4.0              # optional, at density 1, in 1 / world unit
//! color = [0.9, 0.9, 0.95]      # optional, albedo
//! ```

use crate::Result;
use crate::scene::files::dense_file::{Dense, Kind};
use crate::scene::files::{input, nrrd_file, stage::finite, vdb_file};
use crate::scene::{Field, Placed, Volume};
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

/// File extensions of volumes.
pub(in crate::scene) const ENDINGS: [&str; 3] = ["volume", "nrrd", "vdb"];

/// Albedo of smoke, and of casters whose file gives no color.
const COLOR: [f32; 3] = [0.92, 0.92, 0.95];

/// A field with the placement, extinction and color given in the file.
pub(in crate::scene) struct Grid {
    pub field: Field,
    /// Position of sample (0, 0, 0).
    pub origin: DVec3,
    /// Steps between neighbouring samples along each axis.
    pub steps: [DVec3; 3],
    /// Extinction at density 1.
    pub extinction: f64,
    pub color: Option<[f32; 3]>,
    /// Number of samples that are slightly negative and count as 0.
    pub negative: usize,
}

/// How a scene file places and modifies a grid.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Placing {
    pub translate: DVec3,
    pub rotate: DQuat,
    pub scale: f64,
    /// Replaces the file's extinction.
    pub extinction: Option<f64>,
    pub color: Option<[f32; 3]>,
    pub side: u32,
    /// The name of the grid to read, in files with several.
    pub grid: Option<String>,
}

impl Placing {
    pub const AS_IT_STANDS: Self = Self {
        translate: DVec3::ZERO,
        rotate: DQuat::IDENTITY,
        scale: 1.0,
        extinction: None,
        color: None,
        side: 1,
        grid: None,
    };
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sidecar {
    file: String,
    size: [u32; 3],
    #[serde(rename = "type")]
    kind: String,
    #[serde(default = "little")]
    endian: String,
    #[serde(default = "ones")]
    spacing: [f64; 3],
    #[serde(default)]
    origin: [f64; 3],
    #[serde(default = "one")]
    extinction: f64,
    color: Option<[f32; 3]>,
}

fn little() -> String {
    "little".into()
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn one() -> f64 {
    1.0
}

/// Loads a volume and places it.
///
/// # Errors
/// Same as [`frame`], and also if all densities are 0.
pub(in crate::scene) fn load(path: &Path, placing: &Placing, notes: &mut Vec<String>) -> Result<Volume> {
    let volume = frame(path, placing, notes)?;
    if volume.field().is_empty() {
        let cause = "nothing in it casts a shadow: all densities are 0";
        return Err(input::error(path, cause, "correct the file, or where it is placed"));
    }
    Ok(volume)
}

/// Loads and places one file of a sequence. All its densities may be 0, for instance before any smoke has risen.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is invalid, or numbers are out of range after placing.
pub(in crate::scene) fn frame(path: &Path, placing: &Placing, notes: &mut Vec<String>) -> Result<Volume> {
    let ending = input::ending(path);
    if placing.grid.is_some() && ending != "vdb" {
        return Err(input::error(path, "it has one grid without a name", "leave `grid` out"));
    }
    let grid = match ending.as_str() {
        "volume" => sidecar(path)?,
        "nrrd" => {
            let (file, size) = input::open(path)?;
            nrrd_file::read(file, size)
                .map_err(|cause| input::error(path, cause, "give a whole grid of three dimensions"))?
        }
        "vdb" => vdb_file::read(&input::read(path)?, placing.grid.as_deref()).map_err(|cause| {
            input::error(
                path,
                cause,
                "give a fog volume (densities of 0 and more) that was copied whole, or name another grid",
            )
        })?,
        _ => return Err(input::error(path, "it ends in none of .vdb, .nrrd and .volume", "give such a file")),
    };
    let negative = "slightly negative density counts as 0";
    notes.extend(input::note(path, grid.negative, negative, "slightly negative densities count as 0"));
    let wrong = |cause: String| input::error(path, cause, "correct the file, or where it is placed");
    let placed = |v: DVec3| placing.rotate * (v * placing.scale);
    let color = placing.color.or(grid.color).unwrap_or(COLOR);
    if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Err(wrong(format!("color {color:?} is not in [0, 1]")));
    }
    let origin = finite("origin", grid.origin.to_array()).map_err(wrong)?;
    let placed = Placed {
        origin: placed(origin) + placing.translate,
        steps: grid.steps.map(placed),
        // A larger model of the same smoke is as dark as the smaller one.
        extinction: placing.extinction.unwrap_or(grid.extinction) / placing.scale,
        color,
        side: placing.side,
    };
    Volume::new(Arc::new(grid.field), placed).map_err(wrong)
}

/// Reads a `.volume` file and the raw file it names.
fn sidecar(path: &Path) -> Result<Grid> {
    let bytes = input::read(path)?;
    let text = str::from_utf8(&bytes).map_err(|cause| input::error(path, cause, "save it as UTF-8"))?;
    let wrong = |cause: String| input::error(path, cause, "correct the file");
    let parsed: Sidecar = toml::from_str(text).map_err(|cause| wrong(cause.message().into()))?;
    let kind = match parsed.kind.as_str() {
        "u8" => Kind::U8,
        "u16" => Kind::U16,
        "f32" => Kind::F32,
        other => return Err(wrong(format!("type {other:?} is none of u8, u16 and f32"))),
    };
    let big_endian = match parsed.endian.as_str() {
        "little" => false,
        "big" => true,
        other => return Err(wrong(format!("endian {other:?} is neither little nor big"))),
    };
    let dense = Dense { size: parsed.size, kind, big_endian };
    let needed = dense.bytes().map_err(wrong)?;
    let data = path.parent().unwrap_or(Path::new("")).join(&parsed.file);
    let (file, size) = input::open(&data).map_err(input::named_by(path))?;
    if size != needed {
        let cause = format!("{size} bytes, and a grid of {:?} of {} has {needed}", parsed.size, parsed.kind);
        return Err(input::error(&data, cause, format!("correct {}", input::file_name(path))));
    }
    let field = dense.read(BufReader::new(file)).map_err(|cause| input::error(&data, cause, "correct the file"))?;
    let [x, y, z] = parsed.spacing;
    Ok(Grid {
        field,
        origin: parsed.origin.into(),
        steps: [DVec3::X * x, DVec3::Y * y, DVec3::Z * z],
        extinction: parsed.extinction,
        color: parsed.color,
        negative: 0,
    })
}
