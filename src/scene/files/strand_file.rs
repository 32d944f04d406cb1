//! Code shared by all hair formats.

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{MAX_COORDINATE, in_range};
use crate::scene::{Strand, files::hair_file, files::input, files::tressfx_file};
use std::path::Path;

/// Values that replace those in the file.
#[derive(Clone, Copy, Default)]
pub(in crate::scene) struct Overrides {
    /// Radius, in world units.
    pub radius: Option<f64>,
    /// Opacity in [0, 1].
    pub opacity: Option<f64>,
}

/// The longest side of the box around all strands, in radii of a hair, for a file without thickness. A hair is thus 1/400 of that side
/// wide. That is ten times the width of a real hair, but real heads have ten times as many hairs.
pub(in crate::scene) const SIZE_A_RADIUS: f64 = 800.0;

/// Loads and places the strands of a file: TressFX if its extension is `.tfx`, otherwise HAIR.
///
/// # Errors
/// Same as [`tressfx_file::load`] and [`hair_file::load`].
pub(in crate::scene) fn load(
    path: &Path,
    placement: &Placement,
    overrides: Overrides,
    notes: &mut Vec<String>,
) -> Result<Vec<Strand>> {
    let ending = input::ending(path);
    if let Some((cause, way_out)) = input::foreign(&ending) {
        return Err(input::error(path, cause, way_out));
    }
    match ending.as_str() {
        "tfx" => tressfx_file::load(path, placement, overrides),
        _ => hair_file::load(path, placement, overrides, notes),
    }
}

/// Returns a strand that is valid according to the documentation of [`Strand`], except that its length may be zero; the error describes
/// what is wrong. Checked in f32, because a finite f64 may become infinite or zero when converted.
pub(in crate::scene) fn checked(
    [start, end]: [[f64; 3]; 2],
    radius: f64,
    opacity: f64,
) -> std::result::Result<Strand, String> {
    let [from, to] = [start, end].map(|p| p.map(|value| value as f32));
    let strand = Strand { start: from, radius: radius as f32, end: to, opacity: opacity as f32 };
    if !(in_range(&from) && in_range(&to)) {
        return Err(format!("position {start:?} or {end:?} is not finite or exceeds {MAX_COORDINATE:e}"));
    }
    if !(in_range(&[strand.radius]) && strand.radius > 0.0) {
        return Err(format!("radius {radius} is not greater than 0 or exceeds {MAX_COORDINATE:e}"));
    }
    if !(0.0..=1.0).contains(&strand.opacity) {
        return Err(format!("opacity {opacity} is not in [0, 1]"));
    }
    Ok(strand)
}
