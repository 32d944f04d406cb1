//! Splats from `.spz` files (Niantic's *spz*, versions 1 to 4): a header and an array for each property.
//!
//! | bytes per splat | what |
//! |---|---|
//! | 9; version 1: 6 | position: three 24-bit integers, in units of 2^-fraction world units; version 1: three half floats |
//! | 1 | opacity |
//! | 3 | color, as coefficients of a spherical harmonic: (byte/255 − ½) / 0.15 |
//! | 3 | logarithms of deviations: byte/16 − 10 |
//! | 4; versions 1 and 2: 3 | rotation: the three smallest components, 10 bits each; versions 1 and 2: x, y, z, a byte each |
//! | … | how the color changes with the viewing direction; not read |
//!
//! Up to version 3, one gzip stream holds it all. Version 4 has a plain header of 32 bytes, optional extensions, a table with the packed and
//! unpacked size of each array, and then each array as a zstd stream of its own.

use crate::scene::files::splat_file::{self, Row, color_of, opacity_of};
use flate2::read::GzDecoder;
use ruzstd::decoding::StreamingDecoder;
use std::io::Read;

/// The bytes "NGSP".
const MAGIC: [u8; 4] = *b"NGSP";

const HEADER_BYTES: usize = 16;
/// Bytes of version 4's header.
const LONG_HEADER_BYTES: usize = 32;
/// Bytes per array in version 4's table: the packed and the unpacked size.
const SIZES_BYTES: usize = 16;

/// Bit of the header's flags: the splats are of an antialiased rasterizer.
const ANTIALIASED: u8 = 1;

/// A block of zstd has at least 4 bytes and gives at most 128 KiB.
const MOST_PER_BYTE: usize = 32 << 10;

/// Bounds of the memory that a stream may ask for to look back at what it gave. All decoders are to allow the first (RFC 8878, 3.1.1.1.2).
const WINDOWS: [u64; 2] = [8 << 20, 128 << 20];

/// The greatest integer of a coordinate. Some writers clamp to it and to its negative.
const END: i32 = 0x7f_ffff;

const TRUNCATED_HEADER: &str = "truncated: no whole header is there";

/// What a header says of the arrays.
struct Layout {
    version: u32,
    count: usize,
    /// Bits of a coordinate that are a fraction.
    fraction: u8,
    /// Bytes per splat of positions, opacities, colors, scales and rotations.
    widths: [usize; 5],
}

/// Reads all splats and passes each to `take` with its index. `notes` gets what a user should know of the file.
///
/// # Errors
/// If the bytes are truncated, damaged or of another version.
pub(super) fn load(bytes: &[u8], notes: &mut Vec<String>, take: impl FnMut(usize, &Row)) -> Result<(), String> {
    if bytes.starts_with(&MAGIC) {
        let layout = layout(bytes.first_chunk().ok_or(TRUNCATED_HEADER)?, notes)?;
        if layout.version != 4 {
            return Err(format!("version {} without gzip is not read", layout.version));
        }
        return rows(&layout, &streams(bytes, &layout)?, notes, take);
    }
    let mut stream = GzDecoder::new(bytes);
    let mut header = [0; HEADER_BYTES];
    stream.read_exact(&mut header).map_err(|cause| format!("no gzip of a header: {cause}"))?;
    let layout = layout(&header, notes)?;
    if !(1..=3).contains(&layout.version) {
        return Err(format!("version {} in a gzip stream is not read", layout.version));
    }
    let mut arrays: [Vec<u8>; 5] = Default::default();
    for (array, width) in arrays.iter_mut().zip(layout.widths) {
        // They take memory as they come, so that a small file takes little whatever it promises.
        let needed = width as u64 * layout.count as u64;
        stream.by_ref().take(needed).read_to_end(array).map_err(|cause| format!("no whole gzip: {cause}"))?;
        if array.len() as u64 != needed {
            return Err(format!("truncated: an array has {} of its {needed} bytes", array.len()));
        }
    }
    // Later bytes are not used, but must be read, since the checksum at the end covers all bytes.
    std::io::copy(&mut stream, &mut std::io::sink()).map_err(|cause| format!("no whole gzip: {cause}"))?;
    rows(&layout, &arrays, notes, take)
}

/// Decodes the part of the header that all versions have.
fn layout(header: &[u8; HEADER_BYTES], notes: &mut Vec<String>) -> Result<Layout, String> {
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    let (version, count, fraction) = (word(4), word(8), header[13]);
    if header[..4] != MAGIC || !(1..=4).contains(&version) {
        return Err(format!("begins with {:#x} and version {version}, not \"NGSP\" and 1 to 4", word(0)));
    }
    if fraction > 24 {
        return Err(format!("{fraction} bits of a position's 24 are a fraction"));
    }
    if header[14] & ANTIALIASED != 0 {
        notes.push(splat_file::ANTIALIASED.into());
    }
    let widths = [if version == 1 { 6 } else { 9 }, 1, 3, 3, if version < 3 { 3 } else { 4 }];
    Ok(Layout { version, count: count as usize, fraction, widths })
}

/// Unpacks the first five streams of a file of version 4.
fn streams(bytes: &[u8], layout: &Layout) -> Result<[Vec<u8>; 5], String> {
    let header: &[u8; LONG_HEADER_BYTES] = bytes.first_chunk().ok_or(TRUNCATED_HEADER)?;
    let stream_count = usize::from(header[15]);
    let table_at = u32::from_le_bytes([16, 17, 18, 19].map(|i: usize| header[i])) as usize;
    if stream_count < layout.widths.len() || table_at < LONG_HEADER_BYTES {
        return Err(format!("has {stream_count} streams, listed at byte {table_at}, not at least 5 after the header"));
    }
    let (table, mut rest) = bytes
        .get(table_at..)
        .and_then(|rest| rest.split_at_checked(stream_count * SIZES_BYTES))
        .ok_or("truncated: no whole list of its streams is there")?;
    let mut arrays: [Vec<u8>; 5] = Default::default();
    let mut sources = Vec::new();
    for (number, sizes) in table.chunks_exact(SIZES_BYTES).enumerate() {
        let size = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| sizes[at + i]));
        let packed = usize::try_from(size(0)).unwrap_or(usize::MAX);
        let there = rest.len();
        let (source, after) = rest
            .split_at_checked(packed)
            .ok_or_else(|| format!("truncated: {there} of {packed} bytes of its stream {number} are there"))?;
        rest = after;
        let needed = layout.widths.get(number).map(|width| *width as u64 * layout.count as u64);
        if needed.is_some_and(|needed| needed != size(8) || needed > (packed.saturating_mul(MOST_PER_BYTE)) as u64) {
            let unpacked = size(8);
            return Err(format!(
                "stream {number} cannot hold {} splats in {packed} bytes that give {unpacked}",
                layout.count
            ));
        }
        if needed.is_some() {
            sources.push((source, size(8)));
        }
    }
    let unpacked: Vec<_> = std::thread::scope(|scope| {
        let all: Vec<_> = sources.iter().map(|(source, needed)| scope.spawn(|| unpack(source, *needed))).collect();
        all.into_iter().map(|stream| stream.join().unwrap_or_else(|_| Err("it is not zstd".into()))).collect()
    });
    for (number, (array, stream)) in arrays.iter_mut().zip(unpacked).enumerate() {
        *array = stream.map_err(|cause| format!("stream {number} is damaged: {cause}"))?;
    }
    Ok(arrays)
}

/// Unpacks a zstd stream of one or more frames, which must give exactly `needed` bytes. Memory is taken as they come.
fn unpack(mut source: &[u8], needed: u64) -> Result<Vec<u8>, String> {
    let mut array = Vec::new();
    let window = needed.clamp(WINDOWS[0], WINDOWS[1]);
    while !source.is_empty() && array.len() as u64 <= needed {
        let frame =
            StreamingDecoder::new_with_max_window_size(&mut source, window).map_err(|cause| cause.to_string())?;
        let most = needed + 1 - array.len() as u64;
        frame.take(most).read_to_end(&mut array).map_err(|cause| cause.to_string())?;
    }
    if array.len() as u64 == needed { Ok(array) } else { Err(format!("it does not give {needed} bytes")) }
}

/// Decodes the splats of the arrays of positions, opacities, colors, scales and rotations.
fn rows(
    layout: &Layout,
    [places, opacities, colors, scales, turns]: &[Vec<u8>; 5],
    notes: &mut Vec<String>,
    mut take: impl FnMut(usize, &Row),
) -> Result<(), String> {
    let (unit, mut cut_off) = (1.0 / f64::from(1u32 << layout.fraction), 0);
    let places = places.chunks_exact(layout.widths[0]);
    let turns = turns.chunks_exact(layout.widths[4]);
    let threes = colors.chunks_exact(3).zip(scales.chunks_exact(3));
    for (number, (((place, turn), opacity), (color, scale))) in places.zip(turns).zip(opacities).zip(threes).enumerate()
    {
        let position = if layout.version == 1 {
            [0, 1, 2].map(|axis| half([place[2 * axis], place[2 * axis + 1]]))
        } else {
            // The arithmetic right shift sign-extends the 24 bits.
            let units = [0, 3, 6].map(|at| i32::from_le_bytes([0, place[at], place[at + 1], place[at + 2]]) >> 8);
            cut_off += usize::from(units.iter().any(|of| of.abs() >= END));
            units.map(|of| f64::from(of) * unit)
        };
        let three = |of: &[u8]| [0, 1, 2].map(|i| f64::from(of[i]));
        let row = Row {
            position,
            deviations: three(scale).map(|byte| (byte / 16.0 - 10.0).exp()),
            rotation: if layout.version < 3 {
                let [x, y, z] = three(turn).map(|byte| byte / 127.5 - 1.0);
                [x, y, z, (1.0 - (x * x + y * y + z * z)).max(0.0).sqrt()]
            } else {
                smallest_three(u32::from_le_bytes([0, 1, 2, 3].map(|i| turn[i])))
            },
            opacity: opacity_of((*opacity).into()),
            color: color_of(three(color).map(|byte| (byte / 255.0 - 0.5) / 0.15)),
        };
        take(number, &row);
    }
    if cut_off > 0 {
        let reach = f64::from(END) * unit;
        notes.push(format!(
            "{cut_off} of {} splats are at {reach:.0} or -{reach:.0}, where positions end",
            layout.count
        ));
    }
    Ok(())
}

/// Decodes a quaternion. The top bits select the component of greatest magnitude among x, y, z, w. The other three follow in this order, so
/// the last one is in the lowest bits. Each is a sign and 9 bits for a magnitude from 0 to 1/√2.
fn smallest_three(word: u32) -> [f64; 4] {
    let number = |bits: u32| {
        let size = f64::from(bits & 511) / 511.0 * 0.5_f64.sqrt();
        if bits & 512 == 0 { size } else { -size }
    };
    let [a, b, c] = [word >> 20, word >> 10, word].map(number);
    let greatest = (1.0 - (a * a + b * b + c * c)).max(0.0).sqrt();
    match word >> 30 {
        0 => [greatest, a, b, c],
        1 => [a, greatest, b, c],
        2 => [a, b, greatest, c],
        _ => [a, b, c, greatest],
    }
}

/// Decodes a half-precision float.
pub(super) fn half(bytes: [u8; 2]) -> f64 {
    let bits = u16::from_le_bytes(bytes);
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => mantissa * 2f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + mantissa / 1024.0) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}
