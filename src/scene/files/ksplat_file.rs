//! Splats from `.ksplat` files (mkkellogg's *GaussianSplats3D*, version 0.1).
//!
//! A header of 4096 bytes is followed by a header of 1024 bytes for each section and then by the sections. A section has the lengths of its
//! partly filled buckets (32 bits each), the centers of its buckets (three floats each) and its splats. Level 0 has no buckets and stores
//! floats. Levels 1 and 2 store halves, and a position as 16-bit integers around the center of a bucket; the two differ only in how the
//! color changes with the viewing direction, which is not read. Full buckets come first.
//!
//! | bytes per splat: level 0, else | what |
//! |---|---|
//! | 12, 6 | position |
//! | 12, 6 | deviations |
//! | 16, 8 | rotation: w, x, y, z |
//! | 4, 4 | red, green, blue, opacity |
//! | … | how the color changes with the viewing direction |

use crate::scene::files::splat_file::{Row, opacity_of};
use crate::scene::files::spz_file::half;

const HEADER_BYTES: usize = 4096;
const SECTION_HEADER_BYTES: usize = 1024;

/// Bytes of a bucket's center.
const CENTER_BYTES: usize = 12;

/// Numbers per splat for spherical harmonics of a degree.
const HARMONICS: [usize; 4] = [0, 9, 24, 45];

/// Offset of a 16-bit coordinate where the header gives none.
const HALF_RANGE: u32 = 32767;

/// What says how to decode a section's splats.
struct Section<'a> {
    level: u16,
    splats: &'a [u8],
    splat_bytes: usize,
    count: usize,
    /// Lengths of the partly filled buckets, 4 bytes each.
    lengths: &'a [u8],
    centers: &'a [u8],
    /// Number of full buckets and of splats in each.
    full: usize,
    bucket: usize,
    /// Subtracted from a coordinate's integer.
    half_range: u32,
    /// World units per unit of a coordinate's integer.
    unit: f64,
}

/// Reads all splats and passes each to `take` with its index.
///
/// # Errors
/// If the bytes are truncated, damaged or of another version.
pub(super) fn load(bytes: &[u8], mut take: impl FnMut(usize, &Row)) -> Result<(), String> {
    let header: &[u8; HEADER_BYTES] = bytes.first_chunk().ok_or("truncated: no whole header is there")?;
    let [major, minor] = [header[0], header[1]];
    let level = short(header, 20);
    if major != 0 || minor < 1 || level > 2 {
        return Err(format!("version {major}.{minor} with compression level {level} is not read"));
    }
    let (section_count, count) = (word(header, 4) as usize, word(header, 16) as usize);
    let headers = bytes[HEADER_BYTES..]
        .get(..section_count.saturating_mul(SECTION_HEADER_BYTES))
        .ok_or_else(|| format!("truncated: not all headers of {section_count} sections are there"))?;
    let (mut rest, mut number) = (&bytes[HEADER_BYTES + headers.len()..], 0);
    for (i, header) in headers.chunks_exact(SECTION_HEADER_BYTES).enumerate() {
        let section;
        (section, rest) = split_section(header, level, rest).map_err(|cause| format!("section {i} {cause}"))?;
        let mut buckets = Buckets::default();
        for splat in section.splats.chunks_exact(section.splat_bytes).take(section.count) {
            let center = match level {
                0 => [0.0; 3],
                _ => buckets.next_center(&section).ok_or_else(|| format!("section {i} has too few buckets"))?,
            };
            take(number, &row(&section, splat, center));
            number += 1;
        }
    }
    if number != count {
        return Err(format!("its sections have {number} splats and not {count}"));
    }
    Ok(())
}

/// Decodes a section's header and returns it with the bytes that follow the section.
fn split_section<'a>(header: &[u8], level: u16, bytes: &'a [u8]) -> Result<(Section<'a>, &'a [u8]), String> {
    let size = |at: usize| word(header, at) as usize;
    let (count, capacity, bucket, buckets) = (size(0), size(4), size(8), size(12));
    let (full, partial, center_bytes) = (size(32), size(36), short(header, 20));
    let degree = short(header, 40);
    let harmonics = *HARMONICS.get(usize::from(degree)).ok_or_else(|| format!("has harmonics of degree {degree}"))?;
    let splat_bytes = match level {
        0 => 44 + 4 * harmonics,
        1 => 24 + 2 * harmonics,
        _ => 24 + harmonics,
    };
    if count > capacity || level > 0 && (usize::from(center_bytes) != CENTER_BYTES || bucket == 0 && full > 0) {
        return Err(format!(
            "has {count} splats of {capacity}, in buckets of {bucket}, centers of {center_bytes} bytes"
        ));
    }
    let (lengths, rest) = split(bytes, partial, 4)?;
    let (centers, rest) = split(rest, buckets, center_bytes.into())?;
    let (splats, rest) = split(rest, capacity, splat_bytes)?;
    let half_range = if word(header, 24) == 0 { HALF_RANGE } else { word(header, 24) };
    let unit = float(header, 16) / 2.0 / f64::from(half_range);
    Ok((Section { level, splats, splat_bytes, count, lengths, centers, full, bucket, half_range, unit }, rest))
}

/// Splits off `count` items of `size` bytes.
fn split(bytes: &[u8], count: usize, size: usize) -> Result<(&[u8], &[u8]), String> {
    let there = bytes.len();
    let truncated = || format!("is truncated: {there} bytes are there for {count} items of {size}");
    bytes.split_at_checked(count.saturating_mul(size)).ok_or_else(truncated)
}

/// Goes through a section's buckets, splat by splat.
#[derive(Default)]
struct Buckets {
    /// Number of the bucket after the present one.
    next: usize,
    /// The present one's splats that are still to come, and its center.
    left: usize,
    center: [f64; 3],
}

impl Buckets {
    /// Returns the center of the next splat's bucket, or nothing if no bucket is left.
    fn next_center(&mut self, section: &Section) -> Option<[f64; 3]> {
        while self.left == 0 {
            let center = section.centers.chunks_exact(CENTER_BYTES).nth(self.next)?;
            self.center = [0, 4, 8].map(|at| float(center, at));
            self.left = length(section, self.next)?;
            self.next += 1;
        }
        self.left -= 1;
        Some(self.center)
    }
}

/// Returns the number of splats in a section's bucket.
fn length(section: &Section, number: usize) -> Option<usize> {
    let Some(partial) = number.checked_sub(section.full) else { return Some(section.bucket) };
    Some(word(section.lengths.chunks_exact(4).nth(partial)?, 0) as usize)
}

fn row(section: &Section, splat: &[u8], center: [f64; 3]) -> Row {
    let is_float = section.level == 0;
    let number = |i: usize| if is_float { float(splat, 4 * i) } else { half([splat[2 * i], splat[2 * i + 1]]) };
    let color = if is_float { 40 } else { 20 };
    let position = match section.level {
        0 => [0, 1, 2].map(number),
        _ => [0, 1, 2].map(|axis| {
            let offset = f64::from(short(splat, 2 * axis)) - f64::from(section.half_range);
            center[axis] + offset * section.unit
        }),
    };
    Row {
        position,
        deviations: [3, 4, 5].map(number),
        rotation: [7, 8, 9, 6].map(number),
        opacity: opacity_of(splat[color + 3].into()),
        color: [0, 1, 2].map(|i| f64::from(splat[color + i]) / 255.0),
    }
}

fn short(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]))
}

fn float(bytes: &[u8], at: usize) -> f64 {
    f32::from_bits(word(bytes, at)).into()
}
