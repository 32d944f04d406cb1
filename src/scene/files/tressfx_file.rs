//! Strands from TressFX files (`.tfx`) of versions 3 and 4, little-endian: a header, then arrays anywhere, each at an offset given in the
//! header. All strands have the same number of points. Files of version 2 are text, and are rejected.
//!
//! | header | version 3 | version 4 |
//! |---|---|---|
//! | version, f32 | byte 0 | byte 0 |
//! | strands, u32 | 4 | 4 |
//! | points of each strand, u32 | 8 | 8 |
//! | offset of the points, u32 | 144: 3 × f32 each | 12: 4 × f32 each, the last one the inverse mass |
//! | offset of each strand's thickness (f32), u32, or 0 | 148 | 24 |
//! | bytes of the header | 296 | 160 |
//!
//! Only the strands in the file are used, without the hairs that a program would add around them. Thickness is the diameter, as in HAIR
//! files. Exporters leave it out, and the format has no opacity; see [`SIZE_A_RADIUS`] and [`OPACITY`].

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::files::strand_file::{Overrides, SIZE_A_RADIUS, checked};
use crate::scene::{Strand, files::input};
use std::path::Path;

const WAY_OUT: &str = "check that the file is a TressFX file and was copied whole";

/// Opacity of hairs if the scene file gives none.
const OPACITY: f64 = 0.5;

/// Loads and places the segments of all strands. Segments of zero length are dropped, since they cover nothing.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated or of another version, has no strands or has arrays past the
/// end, or if a position or thickness is invalid for a [`Strand`]; the message gives the strand's number.
pub(in crate::scene) fn load(path: &Path, placement: &Placement, overrides: Overrides) -> Result<Vec<Strand>> {
    let bytes = input::read(path)?;
    let file = TressFxFile::new(&bytes).map_err(|cause| input::error(path, cause, WAY_OUT))?;
    let without_thickness = file.size() / SIZE_A_RADIUS;
    let mut strands = Vec::new();
    for number in 0..file.strands {
        let wrong = |cause: String| {
            let cause = format!("strand {number} (the first is 0): {cause}");
            input::error(path, cause, "correct the file, or give a radius in a scene file")
        };
        let own_radius = match file.thickness(number) {
            _ if overrides.radius.is_some() => 0.0,
            None => without_thickness,
            Some(thickness) if (0.0..=f32::MAX).contains(&thickness) => 0.5 * f64::from(thickness),
            Some(thickness) => return Err(wrong(format!("thickness {thickness} is not from 0 to {:?}", f32::MAX))),
        };
        let radius = overrides.radius.unwrap_or(own_radius * placement.scale);
        let first = number * file.points;
        for point in first..first + file.points - 1 {
            let ends = [point, point + 1].map(|point| placement.position(file.position(point)));
            let strand = checked(ends, radius, overrides.opacity.unwrap_or(OPACITY)).map_err(wrong)?;
            if strand.start != strand.end {
                strands.push(strand);
            }
        }
    }
    Ok(strands)
}

/// A validated file: all arrays are present, and positions are finite.
struct TressFxFile<'a> {
    strands: usize,
    /// Number of points per strand, at least 2.
    points: usize,
    positions: &'a [u8],
    position_bytes: usize,
    /// Thickness of each strand, four bytes per strand; empty if the file has none.
    thickness: &'a [u8],
}

impl<'a> TressFxFile<'a> {
    fn new(bytes: &'a [u8]) -> std::result::Result<Self, String> {
        let version = f32::from_bits(number(bytes, 0)?);
        let (header_bytes, positions_at, thickness_at, position_bytes) = match version {
            3.0..4.0 => (296, 144, 148, 12),
            4.0..5.0 => (160, 12, 24, 16),
            _ => return Err(format!("is no TressFX file of version 3 or 4: its version reads as {version:?}")),
        };
        if bytes.len() < header_bytes {
            return Err(format!("truncated: a header has {header_bytes} bytes, {} are there", bytes.len()));
        }
        let [strands, points] = [number(bytes, 4)?, number(bytes, 8)?];
        if strands == 0 || points < 2 {
            return Err(format!("has {strands} strands of {points} points: nothing that casts a shadow"));
        }
        // Counts are not trusted: they must match the file's size before anything is allocated for them.
        let array = |name: &str, at: usize, count: u128, size: usize| {
            let begin = number(bytes, at)? as usize;
            let length = count * size as u128;
            let found = usize::try_from(length).ok().and_then(|length| bytes.get(begin..)?.get(..length));
            match found {
                Some(_) if begin < header_bytes => Err(format!("its {name} begin inside the header, at byte {begin}")),
                Some(found) => Ok(found),
                None => Err(format!("truncated: {length} bytes of {name} from {begin}, {} bytes in all", bytes.len())),
            }
        };
        let file = Self {
            strands: strands as usize,
            points: points as usize,
            positions: array("points", positions_at, u128::from(strands) * u128::from(points), position_bytes)?,
            position_bytes,
            thickness: match number(bytes, thickness_at)? {
                0 => &[],
                _ => array("thicknesses", thickness_at, strands.into(), 4)?,
            },
        };
        let mut points = 0..file.strands * file.points;
        match points.find(|point| !file.position(*point).iter().all(|value| value.is_finite())) {
            Some(point) => {
                let [strand, place] = [point / file.points, point % file.points];
                let position = file.position(point);
                Err(format!("strand {strand}, point {place} (the first is 0): position {position:?} is not finite"))
            }
            None => Ok(file),
        }
    }

    fn position(&self, point: usize) -> [f32; 3] {
        let at = point * self.position_bytes;
        [0, 4, 8].map(|i| number(self.positions, at + i).map_or(f32::NAN, f32::from_bits))
    }

    fn thickness(&self, strand: usize) -> Option<f32> {
        number(self.thickness, 4 * strand).ok().map(f32::from_bits)
    }

    /// Returns the longest side of the bounds of all points.
    fn size(&self) -> f64 {
        let points = || (0..self.strands * self.points).map(|point| self.position(point).map(f64::from));
        let side = |axis: usize| {
            let along = || points().map(|position| position[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        (0..3).map(side).fold(0.0, f64::max)
    }
}

/// Reads four bytes as a little-endian number.
fn number(bytes: &[u8], at: usize) -> std::result::Result<u32, String> {
    let four = bytes.get(at..).and_then(<[u8]>::first_chunk);
    four.map(|four| u32::from_le_bytes(*four)).ok_or_else(|| format!("truncated: it has {} bytes", bytes.len()))
}
