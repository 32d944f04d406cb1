//! Contents far from the origin, where floats are coarse: a scene on a globe is 6,378 km away, and its floats are half a metre apart. It is
//! loaded again, moved to the origin in f64.

use crate::Result;
use crate::scene::files::contents::Contents;
use crate::scene::files::input;
use glam::DVec3;
use std::path::Path;

/// The farthest that contents may be from the origin, in sizes of theirs. A float is then good to 1/500,000 of that size.
const FARTHEST: f64 = 32.0;

/// The farthest that contents without any size may be: a point, or what floats cannot tell from one.
const FARTHEST_POINT: f64 = 1048576.0;

/// Loads contents by `load`, which moves them by the negative of its argument; far ones are moved to the origin. Returns them with by how
/// much they are moved.
///
/// # Errors
/// Those of `load`.
pub(in crate::scene) fn brought_home<T>(
    mut load: impl FnMut(DVec3) -> Result<T>,
    contents: impl Fn(&T) -> &Contents,
) -> Result<(T, DVec3)> {
    let mut away = DVec3::ZERO;
    let mut loaded = load(away)?;
    // How large they are may only be seen when they are near.
    for _ in 0..3 {
        let Some(farther) = away_by(contents(&loaded)) else { break };
        away += farther;
        loaded = load(away)?;
    }
    Ok((loaded, away))
}

/// Returns a note about contents that were moved; none if they were not.
pub(in crate::scene) fn note(path: &Path, away: DVec3) -> Option<String> {
    // Without a −0.
    let DVec3 { x, y, z } = DVec3::ZERO - away;
    let moved = format!("all of it is moved by {x}, {y}, {z}, and so must be a camera that is given");
    let told = format!("far from the origin, where floats are coarse: {moved}");
    (away != DVec3::ZERO).then(|| format!("{}: {told}", input::file_name(path)))
}

/// Returns the middle of far contents, in whole units; `None` if they are near.
fn away_by(contents: &Contents) -> Option<DVec3> {
    let (low, high) = contents.bounds()?;
    let (middle, size) = (0.5 * (low + high), (high - low).max_element());
    // Small contents are moved by whole fractions, so that they get as near.
    let unit = if size > 0.0 { size.log2().floor().exp2().min(1.0) } else { 1.0 };
    let away = (middle / unit).round() * unit;
    let farthest = if size > 0.0 { FARTHEST * size } else { FARTHEST_POINT };
    (away != DVec3::ZERO && middle.abs().max_element() > farthest).then_some(away)
}
