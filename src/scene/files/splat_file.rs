//! Code shared by all splat formats.

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{MAX_COORDINATE, in_range};
use crate::scene::files::{input, ksplat_file, sog_file, splat_ply, spz_file};
use crate::scene::{Caster, Splat};
use glam::DQuat;
use std::path::Path;

const WAY_OUT: &str = "give a .ply, .splat, .spz, .sog or .ksplat file; name a .glb under [[meshes]]";

/// The constant of the zeroth spherical harmonic, which files use to encode colors.
const HARMONIC_0: f64 = 0.282_094_791_773_878_14;

/// What a note says of splats whose opacities leave out the pixel by which renderers widen them.
pub(in crate::scene) const ANTIALIASED: &str = "its splats are of an antialiased rasterizer";

/// Extensions of files that may hold splats.
pub(in crate::scene) const ENDINGS: [&str; 6] = ["ply", "splat", "spz", "sog", "ksplat", "json"];

/// Number of bytes per splat in a `.splat` file.
const ROW_BYTES: usize = 32;

/// The thickness of a flat splat, as a share of its greatest deviation. What it casts is the same for any that is small.
const FLAT: f64 = 1e-3;

/// The least number of splats whose sizes say something about the file's.
const MANY: usize = 16;

/// A splat as stored in a file, in f64.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Row {
    pub position: [f64; 3],
    /// Standard deviations, in world units.
    pub deviations: [f64; 3],
    /// Quaternion x, y, z, w, of any length.
    pub rotation: [f64; 4],
    pub opacity: f64,
    pub color: [f64; 3],
}

/// The splats of a file, as they are read.
#[derive(Default)]
pub(in crate::scene) struct SplatCollector {
    splats: Vec<Splat>,
    flat: usize,
    left_out: usize,
    /// What is wrong with the first one that is left out.
    first: Option<String>,
}

impl SplatCollector {
    /// Adds a splat of that number.
    pub fn add(&mut self, number: usize, row: &Row, placement: &Placement) {
        let (row, is_flat) = thickened(*row);
        match checked(&row, placement) {
            Ok(splat) => {
                self.splats.push(splat);
                self.flat += usize::from(is_flat);
            }
            Err(cause) => {
                self.first.get_or_insert_with(|| format!("splat {number} (the first is 0): {cause}"));
                self.left_out += 1;
            }
        }
    }

    /// Returns the number of splats so far.
    pub fn count(&self) -> usize {
        self.splats.len() + self.left_out
    }

    /// Returns all valid splats. `notes` tells which are left out or changed.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if there are splats, but none is valid.
    pub fn finish(self, path: &Path, notes: &mut Vec<String>) -> Result<Vec<Splat>> {
        let Self { splats, flat, left_out, first } = self;
        if let Some(first) = first {
            if splats.is_empty() {
                return Err(input::error(path, first, "correct or drop it"));
            }
            let all = splats.len() + left_out;
            notes.push(format!("{}: {left_out} of {all} splats are left out; {first}", input::file_name(path)));
        }
        let thick = "flat splat is a thousandth as thick as it is wide";
        notes.extend(input::note(path, flat, thick, "flat splats are a thousandth as thick as they are wide"));
        let large = large(&splats);
        if splats.len() >= MANY && 2 * large > splats.len() {
            let told = "splats are larger than a tenth of the scene: their scales may not be logarithms, as the format has them";
            notes.extend(input::note(path, large, told, told));
        }
        Ok(splats)
    }
}

/// Loads and places the splats of a file, depending on its extension: `.ply` as written by 3D Gaussian Splatting or compressed by
/// PlayCanvas, `.splat`, `.spz`, `.sog` or its `meta.json`, `.ksplat`. A splat whose color depends on the viewing direction gets its mean color. Splats that are invalid for
/// [`Splat`] are left out, which `notes` tells, and flat ones get a thickness.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated or malformed, or all splats are invalid; the message gives the
/// number of the first.
pub(in crate::scene) fn load(path: &Path, placement: &Placement, notes: &mut Vec<String>) -> Result<Vec<Splat>> {
    let mut taken = SplatCollector::default();
    let mut take = |number: usize, row: &Row| taken.add(number, row, placement);
    let mut told = Vec::new();
    let read = match input::ending(path).as_str() {
        "ply" => {
            splat_ply::load(path, notes, take)?;
            Ok(())
        }
        "splat" => rows(&input::read(path)?, take),
        "spz" => spz_file::load(&input::read(path)?, &mut told, take),
        "sog" => sog_file::load_archive(&input::read(path)?, &mut told, take),
        "json" => sog_file::load_folder(path, &mut told, &mut take),
        "ksplat" => ksplat_file::load(&input::read(path)?, take),
        _ => return Err(input::error(path, "unknown kind of splat file", WAY_OUT)),
    };
    read.map_err(|cause| input::error(path, cause, "check that the file was copied whole, or convert it again"))?;
    notes.extend(told.into_iter().map(|note| format!("{}: {note}", input::file_name(path))));
    taken.finish(path, notes)
}

/// Returns a splat with a thickness where it has none, and whether it had none.
fn thickened(mut row: Row) -> (Row, bool) {
    let widest = row.deviations.iter().copied().fold(0.0, f64::max);
    let is_flat = widest > 0.0 && row.deviations.contains(&0.0);
    for deviation in row.deviations.iter_mut().filter(|deviation| is_flat && **deviation == 0.0) {
        *deviation = FLAT * widest;
    }
    (row, is_flat)
}

/// Returns the number of splats that are larger than a tenth of all together.
fn large(splats: &[Splat]) -> usize {
    let bounds = |axis: usize| {
        let all = splats.iter().map(|splat| f64::from(splat.position[axis]));
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)))
    };
    let diagonal = [0, 1, 2].map(bounds).iter().map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt();
    // Splats in one place say nothing of the scene's size.
    let is_large = |splat: &&Splat| {
        diagonal > 0.0 && splat.deviations.iter().any(|deviation| f64::from(*deviation) > 0.1 * diagonal)
    };
    splats.iter().filter(is_large).count()
}

/// Reads the rows of a `.splat` file.
fn rows(bytes: &[u8], mut take: impl FnMut(usize, &Row)) -> std::result::Result<(), String> {
    if !bytes.len().is_multiple_of(ROW_BYTES) {
        return Err(format!("truncated: {} bytes are no whole number of splats of {ROW_BYTES}", bytes.len()));
    }
    bytes.chunks_exact(ROW_BYTES).enumerate().for_each(|(number, row)| take(number, &of_splat(row)));
    Ok(())
}

/// Decodes a row of a `.splat` file: position and deviations as floats; red, green, blue, opacity and a quaternion w, x, y, z as bytes.
fn of_splat(row: &[u8]) -> Row {
    let float = |i: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|byte| row[4 * i + byte])));
    let share = |i: usize| f64::from(row[24 + i]) / 255.0;
    let turn = |i: usize| (f64::from(row[28 + i]) - 128.0) / 128.0;
    Row {
        position: [0, 1, 2].map(float),
        deviations: [3, 4, 5].map(float),
        rotation: [1, 2, 3, 0].map(turn),
        opacity: opacity_of(row[27].into()),
        color: [0, 1, 2].map(share),
    }
}

/// Decodes an opacity byte. 255 decodes to the smallest value that rounds to it, so that no splat is fully opaque.
pub(in crate::scene) fn opacity_of(byte: f64) -> f64 {
    (byte / 255.0).min(254.5 / 255.0)
}

/// Returns the color for the zeroth spherical harmonic coefficients.
pub(in crate::scene) fn color_of(coefficients: [f64; 3]) -> [f64; 3] {
    coefficients.map(|c| 0.5 + HARMONIC_0 * c)
}

/// Returns a splat that is valid according to the documentation of [`Splat`]; the error describes what is wrong. Checked in f32, because a
/// finite f64 may become infinite or zero when converted.
fn checked(row: &Row, placement: &Placement) -> std::result::Result<Splat, String> {
    let Row { position, rotation, opacity, .. } = *row;
    let deviations = row.deviations.map(|d| d * placement.scale);
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 1e-6) {
        return Err(format!("rotation {rotation:?} is no quaternion: its length is {length}"));
    }
    if !(0.0..=1.0).contains(&opacity) {
        return Err(format!("opacity {opacity} is not in [0, 1]"));
    }
    if !row.color.iter().all(|c| c.is_finite()) {
        return Err(format!("color {:?} is not finite", row.color));
    }
    let turned = placement.rotate * DQuat::from_array(rotation.map(|x| x / length));
    let splat = Splat {
        position: placement.position(position).map(|x| x as f32),
        deviations: deviations.map(|d| d as f32),
        rotation: turned.to_array().map(|x| x as f32),
        opacity: opacity as f32,
        color: row.color.map(|c| c.clamp(0.0, 1.0) as f32),
    };
    if !in_range(&splat.position) {
        return Err(format!("position {position:?} is not finite or exceeds {MAX_COORDINATE:e}"));
    }
    if !splat.deviations.iter().all(|d| f64::from(*d) <= MAX_COORDINATE && *d > 0.0) {
        return Err(format!("deviations {deviations:?} are not greater than 0 or exceed {MAX_COORDINATE:e}"));
    }
    // An extremely thin splat would have an infinite extinction.
    let caster = Caster::from(&splat);
    if !(caster.density.is_finite() && in_range(&[caster.radius]) && caster.radius.is_normal()) {
        return Err(format!("deviations {deviations:?} are too small or too large for floats"));
    }
    Ok(splat)
}
