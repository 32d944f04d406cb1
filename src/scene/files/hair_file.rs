//! Strands from HAIR files (Cem Yuksel, <http://www.cemyuksel.com/research/hairmodels>), little-endian: a header of 128 bytes, then the
//! arrays in this order. The file contains array N if bit N of the header is set.
//!
//! | byte | header | array | content |
//! |---|---|---|---|
//! | 0 | `HAIR` | 0 | segments of each hair, u16 |
//! | 4 | hairs, u32 | 1 | points, 3 × f32, segments + 1 for each hair, root first |
//! | 8 | points, u32 | 2 | thickness of each point, f32 |
//! | 12 | bits, u32 | 3 | transparency of each point, f32 |
//! | 16 | segments per hair, u32, for files without array 0 | 4 | color of each point, 3 × f32; ignored |
//! | 20 | thickness, f32, for files without array 2 | | |
//! | 24 | transparency, f32, for files without array 3 | | |
//! | 28 | color, 3 × f32, for files without array 4; then 88 bytes of text | | |
//!
//! The format does not define *thickness*, and programs differ; here it is the diameter. *Opacity* is 1 − transparency. A segment uses the
//! mean of the values at its two points. Programs add arrays of further bits behind these; they are skipped.

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::files::strand_file::{Overrides, SIZE_A_RADIUS, checked};
use crate::scene::{Strand, files::input};
use std::path::Path;

const WAY_OUT: &str = "check that the file is a HAIR file and was copied whole";

const HEADER_BYTES: u64 = 128;

/// Bit number of each array; colors have bit 4.
const SEGMENTS: u32 = 0;
const POINTS: u32 = 1;
const THICKNESS: u32 = 2;
const TRANSPARENCY: u32 = 3;

/// The longest side of the box around all hairs, in widths of one, below which the width is noted: it may be in another unit.
const FEW_WIDTHS: f64 = 50.0;

/// Loads and places the segments of all hairs. Segments of zero length are dropped, since they cover nothing. Hairs without a width in a file
/// without any get one that fits.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated or not a HAIR file, if its counts are inconsistent, or if a
/// position, radius or opacity is invalid for a [`Strand`]; the message gives the hair's number.
pub(in crate::scene) fn load(
    path: &Path,
    placement: &Placement,
    overrides: Overrides,
    notes: &mut Vec<String>,
) -> Result<Vec<Strand>> {
    let bytes = input::read(path)?;
    let wrong = |cause: String| input::error(path, cause, WAY_OUT);
    let file = HairFile::new(&bytes).map_err(wrong)?;
    let (one, many) = ("array beyond the format's five is skipped", "arrays beyond the format's five are skipped");
    notes.extend(input::note(path, file.further as usize, one, many));
    let size = file.size();
    let widest = file.widest();
    let mut overrides = overrides;
    if overrides.radius.is_none() && widest == 0.0 {
        overrides.radius = Some(size * placement.scale / SIZE_A_RADIUS);
        notes.push(format!("{}: no width: hairs are 1/400 of the longest side wide", input::file_name(path)));
    } else if overrides.radius.is_none() && widest * FEW_WIDTHS > size && size > 0.0 {
        let told = format!(
            "hairs are up to {} wide on a longest side of {}: give a radius if they should not be",
            widest as f32, size as f32
        );
        notes.push(format!("{}: {told}", input::file_name(path)));
    }
    let mut strands = Vec::new();
    let mut first = 0;
    for hair in 0..file.hairs {
        for point in first..first + file.segments(hair) {
            let strand = strand(&file, point, placement, overrides).map_err(|cause| {
                let cause = format!("hair {hair} (the first is 0), segment {}: {cause}", point - first);
                input::error(path, cause, "correct the file, or give radius and opacity in the scene file")
            })?;
            if strand.start != strand.end {
                strands.push(strand);
            }
        }
        first += file.segments(hair) + 1;
    }
    Ok(strands)
}

/// Builds the segment from `point` to the next point.
fn strand(
    file: &HairFile,
    point: usize,
    placement: &Placement,
    overrides: Overrides,
) -> std::result::Result<Strand, String> {
    let mean = |name, array, standing, most| {
        let ends = [point, point + 1].map(|point| file.number(array, point, standing));
        match ends.iter().find(|value| !(0.0..=most).contains(*value)) {
            Some(value) => Err(format!("{name} {value} is not from 0 to {most:?}")),
            None => Ok(0.5 * (ends[0] + ends[1])),
        }
    };
    let radius = match overrides.radius {
        Some(radius) => radius,
        None => 0.5 * placement.scale * mean("thickness", file.thickness, file.standing[0], f32::MAX.into())?,
    };
    let opacity = match overrides.opacity {
        Some(opacity) => opacity,
        None => 1.0 - mean("transparency", file.transparency, file.standing[1], 1.0)?,
    };
    checked([point, point + 1].map(|point| placement.position(file.position(point))), radius, opacity)
}

/// A validated file: all arrays are present, and hairs have all their points.
struct HairFile<'a> {
    hairs: usize,
    /// Number of segments of each hair, two bytes per hair; empty if all hairs have `every` segments.
    segments: &'a [u8],
    every: usize,
    points: &'a [u8],
    thickness: &'a [u8],
    transparency: &'a [u8],
    /// Number of arrays behind these that are not of the format.
    further: u32,
    /// Default thickness and transparency, for files without these arrays.
    standing: [f64; 2],
}

impl<'a> HairFile<'a> {
    fn new(bytes: &'a [u8]) -> std::result::Result<Self, String> {
        if !bytes.starts_with(b"HAIR") {
            return Err("does not begin with HAIR".into());
        }
        if (bytes.len() as u64) < HEADER_BYTES {
            return Err(format!("truncated: a header has {HEADER_BYTES} bytes, {} are there", bytes.len()));
        }
        let [hairs, points, bits, every] = [4, 8, 12, 16].map(|at| u32::from_le_bytes(four(bytes, at)));
        if bits & 1 << POINTS == 0 {
            return Err("has no points".into());
        }
        // Counts are not trusted: they must match the file's size before anything is allocated for them.
        let mut end = HEADER_BYTES;
        let places = [(hairs, 2_u64), (points, 12), (points, 4), (points, 4), (points, 12)];
        let arrays = [0, 1, 2, 3, 4].map(|bit| {
            let (count, size) = places[bit];
            let begin = end;
            end += if bits & 1 << bit == 0 { 0 } else { u64::from(count) * size };
            begin..end
        });
        if end > bytes.len() as u64 {
            return Err(format!("truncated: the header promises {end} bytes, {} are there", bytes.len()));
        }
        let array = |bit: u32| {
            let range = &arrays[bit as usize];
            bytes.get(range.start as usize..range.end as usize).unwrap_or_default()
        };
        let file = Self {
            hairs: hairs as usize,
            segments: array(SEGMENTS),
            every: every as usize,
            points: array(POINTS),
            thickness: array(THICKNESS),
            transparency: array(TRANSPARENCY),
            further: (bits >> 5).count_ones(),
            standing: [20, 24].map(|at| f32::from_le_bytes(four(bytes, at)).into()),
        };
        let needed = if bits & 1 << SEGMENTS == 0 {
            u128::from(hairs) * (u128::from(every) + 1)
        } else {
            (0..file.hairs).map(|hair| file.segments(hair) as u128 + 1).sum()
        };
        if needed != u128::from(points) {
            return Err(format!("its {hairs} hairs have {needed} points by their segments, {points} by the header"));
        }
        Ok(file)
    }

    fn segments(&self, hair: usize) -> usize {
        match self.segments {
            [] => self.every,
            all => all.get(2 * hair..2 * hair + 2).map_or(0, |s| usize::from(u16::from_le_bytes([s[0], s[1]]))),
        }
    }

    fn position(&self, point: usize) -> [f32; 3] {
        [0, 4, 8].map(|at| f32::from_le_bytes(four(self.points, 12 * point + at)))
    }

    /// Returns the longest side of the box around all points.
    fn size(&self) -> f64 {
        let side = |axis: usize| {
            let all = (0..self.points.len() / 12).map(|point| f64::from(self.position(point)[axis]));
            let (low, high) =
                all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
            high - low
        };
        [0, 1, 2].map(side).into_iter().fold(0.0, f64::max)
    }

    /// Returns the greatest thickness.
    fn widest(&self) -> f64 {
        let all = (0..self.thickness.len() / 4).map(|point| self.number(self.thickness, point, 0.0));
        if self.thickness.is_empty() { self.standing[0] } else { all.fold(0.0, f64::max) }
    }

    /// Returns a point's value, or the default.
    fn number(&self, array: &[u8], point: usize, standing: f64) -> f64 {
        if array.is_empty() { standing } else { f32::from_le_bytes(four(array, 4 * point)).into() }
    }
}

/// Returns four bytes at an offset. They would be 0 past the end, but [`HairFile::new`] has checked that there are enough.
fn four(bytes: &[u8], at: usize) -> [u8; 4] {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).unwrap_or_default()
}
