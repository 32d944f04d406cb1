//! Volumes from files: grids of densities, with their placement in space.
//!
//! | extension | what it is |
//! |---|---|
//! | `.volume` | TOML that names a raw file of a dense grid beside it |
//! | `.nrrd` | a dense grid with its header ([`nrrd_file`]) |
//! | `.vdb` | a sparse grid among others ([`vdb_file`]) |
//! | `.nvdb` | the same, laid out for GPUs ([`nanovdb_file`]) |
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
use crate::scene::files::placement::Placement;
use crate::scene::files::{input, nanovdb_file, nrrd_file, stage::finite, straight, vdb_file};
use crate::scene::{Field, Placed, Volume};
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

/// File extensions of volumes.
pub(in crate::scene) const ENDINGS: [&str; 4] = ["volume", "nrrd", "vdb", "nvdb"];

/// Albedo of smoke, and of casters whose file gives no color.
const COLOR: [f32; 3] = [0.92, 0.92, 0.95];

/// A field with the placement, extinction and color given in the file.
pub(in crate::scene) struct Grid {
    pub field: Field,
    /// Position of sample (0, 0, 0).
    pub origin: DVec3,
    /// Steps between neighbouring samples along each axis.
    pub steps: [DVec3; 3],
    /// The same steps as the file has them, if fewer samples were made of its own.
    pub own_steps: Option<[DVec3; 3]>,
    /// Extinction at density 1.
    pub extinction: f64,
    pub color: Option<[f32; 3]>,
    /// What was left out, or is not as the file has it; one line each.
    pub notes: Vec<String>,
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
    /// The name of the grids to read, in files with several.
    pub grid: Option<String>,
    /// How to read level sets; `None` to refuse them.
    pub level_set: Option<LevelSet>,
    /// See [`Dense::window`].
    pub window: Option<[f64; 2]>,
    /// Moves the grid by so many samples along its axes.
    pub offset: DVec3,
}

/// How to read a level set.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::scene) enum LevelSet {
    /// Density 1 inside, 0 outside, and linear across one voxel at the surface.
    Fog,
}

impl From<Placement> for Placing {
    fn from(Placement { translate, rotate, scale }: Placement) -> Self {
        Self {
            translate,
            rotate,
            scale,
            extinction: None,
            color: None,
            side: 1,
            grid: None,
            level_set: None,
            window: None,
            offset: DVec3::ZERO,
        }
    }
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

/// Loads the volumes of a file and places them.
///
/// # Errors
/// Same as [`frame`], and also if all densities are 0.
pub(in crate::scene) fn load(path: &Path, placing: &Placing, notes: &mut Vec<String>) -> Result<Vec<Volume>> {
    let volumes = frame(path, placing, notes)?;
    if volumes.iter().all(|volume| volume.field().is_empty()) {
        let cause = "nothing in it casts a shadow: all densities are 0";
        return Err(input::error(path, cause, "correct the file, or where it is placed"));
    }
    Ok(volumes)
}

/// Loads and places one file of a sequence: at least one volume. All densities may be 0, for instance before any smoke has risen.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is invalid, or numbers are out of range after placing.
pub(in crate::scene) fn frame(path: &Path, placing: &Placing, notes: &mut Vec<String>) -> Result<Vec<Volume>> {
    let ending = input::ending(path);
    let is_dense = ["volume", "nrrd"].contains(&ending.as_str());
    let refused = [
        (placing.grid.is_some() && is_dense, "it has one grid without a name: leave `grid` out"),
        (placing.level_set.is_some() && is_dense, "it has no level set: leave `level_set` out"),
        (placing.window.is_some() && !is_dense, "its numbers are densities: leave `window` out"),
    ];
    if let Some((_, cause)) = refused.into_iter().find(|(is_refused, _)| *is_refused) {
        return Err(input::error(path, cause, "correct the scene file"));
    }
    let grids = match ending.as_str() {
        "volume" => vec![sidecar(path, placing.window)?],
        "nrrd" => {
            let (file, size) = input::open(path)?;
            let grid = nrrd_file::read(file, size, placing.window);
            vec![grid.map_err(|cause| input::error(path, cause, "give a whole grid of three dimensions"))?]
        }
        "vdb" | "nvdb" => {
            let (bytes, name) = (input::read(path)?, placing.grid.as_deref());
            let read = if ending == "vdb" { vdb_file::read } else { nanovdb_file::read };
            let way_out = "give a fog volume (densities of 0 and more) that was copied whole, or name another grid";
            read(&bytes, name, placing.level_set).map_err(|cause| input::error(path, cause, way_out))?
        }
        _ => return Err(input::error(path, "it ends in none of .vdb, .nvdb, .nrrd and .volume", "give such a file")),
    };
    grids.into_iter().map(|grid| place(path, placing, grid, notes)).collect()
}

/// Places a grid.
fn place(path: &Path, placing: &Placing, mut grid: Grid, notes: &mut Vec<String>) -> Result<Volume> {
    let wrong = |cause: String| input::error(path, cause, "correct the file, or where it is placed");
    let [x, y, z] = grid.own_steps.unwrap_or(grid.steps);
    if let Some(degrees) = straight::sheared_by(&grid.steps) {
        (grid.field, grid.steps) = straight::straightened(&grid.field, &grid.steps).map_err(wrong)?;
        grid.notes.push(format!("its axes are {degrees:.1} degrees off right angles: sampled along straight ones"));
    }
    notes.extend(grid.notes.into_iter().map(|note| format!("{}: {note}", input::file_name(path))));
    let placed = |v: DVec3| placing.rotate * (v * placing.scale);
    let color = placing.color.or(grid.color).unwrap_or(COLOR);
    if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Err(wrong(format!("color {color:?} is not in [0, 1]")));
    }
    let offset = x * placing.offset.x + y * placing.offset.y + z * placing.offset.z;
    let origin = finite("origin", (grid.origin + offset).to_array()).map_err(wrong)?;
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
fn sidecar(path: &Path, window: Option<[f64; 2]>) -> Result<Grid> {
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
    let dense = Dense { size: parsed.size, kind, big_endian, window };
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
        own_steps: None,
        extinction: parsed.extinction,
        color: parsed.color,
        notes: Vec::new(),
    })
}
