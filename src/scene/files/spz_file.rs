//! Splats from `.spz` files (Niantic's *spz*, versions 1 to 3): one gzip stream with a header and an array for each property.
//!
//! | bytes per splat | what |
//! |---|---|
//! | 9; version 1: 6 | position: three 24-bit integers, in units of 2^-fraction world units; version 1: three half floats |
//! | 1 | opacity |
//! | 3 | color, as coefficients of a spherical harmonic: (byte/255 − ½) / 0.15 |
//! | 3 | logarithms of deviations: byte/16 − 10 |
//! | 3; version 3: 4 | rotation: x, y, z of a quaternion; version 3: its three smallest components, 10 bits each |
//! | … | how the color changes with the viewing direction; not read |

use crate::Result;
use crate::scene::files::input;
use crate::scene::files::splat_file::{self, Row, color_of, opacity_of};
use flate2::read::GzDecoder;
use std::io::{BufReader, Read};
use std::path::Path;

/// The bytes "NGSP".
const MAGIC: u32 = 0x5053_474e;

const HEADER_BYTES: usize = 16;

/// Bit of the header's flags: the splats are of an antialiased rasterizer.
const ANTIALIASED: u8 = 1;

const WAY_OUT: &str = "check that the file is an .spz file of version 1 to 3 and was copied whole";

/// Reads all splats and passes each to `take` with its index.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable, truncated, not gzip or of another version. Errors of `take` are passed
/// on.
pub(in crate::scene) fn load(
    path: &Path,
    notes: &mut Vec<String>,
    mut take: impl FnMut(usize, &Row) -> Result<()>,
) -> Result<()> {
    let wrong = |cause: String| input::error(path, cause, WAY_OUT);
    let (mut file, _) = input::open(path)?;
    let mut header = [0; HEADER_BYTES];
    let mut first = [0; 8];
    file.read_exact(&mut first).map_err(|cause| wrong(format!("no header: {cause}")))?;
    if first[..4] == MAGIC.to_le_bytes() {
        let version = u32::from_le_bytes([4, 5, 6, 7].map(|i: usize| first[i]));
        return Err(input::error(path, format!("version {version} is not read"), "save it as version 3"));
    }
    let mut stream = GzDecoder::new(first.chain(BufReader::new(file)));
    stream.read_exact(&mut header).map_err(|cause| wrong(format!("no gzip of a header: {cause}")))?;
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    let (magic, version, count, fraction) = (word(0), word(4), word(8), header[13]);
    if magic != MAGIC || !(1..=3).contains(&version) {
        return Err(wrong(format!("begins with {magic:#x} and version {version}, not {MAGIC:#x} and 1 to 3")));
    }
    if fraction > 24 {
        return Err(wrong(format!("{fraction} bits of a position's 24 are a fraction")));
    }
    let (place_bytes, turn_bytes) = (if version == 1 { 6 } else { 9 }, if version == 3 { 4 } else { 3 });
    let splat_bytes = place_bytes + 1 + 3 + 3 + turn_bytes;
    let needed = u64::from(count) * splat_bytes as u64;
    if header[14] & ANTIALIASED != 0 {
        notes.push(format!("{}: {}", input::file_name(path), splat_file::ANTIALIASED));
    }
    // Only the needed bytes are unpacked, no matter how long the stream is.
    // They take memory as they come, so that a small file takes little whatever it promises.
    let mut bytes = Vec::new();
    stream.by_ref().take(needed).read_to_end(&mut bytes).map_err(|cause| wrong(format!("no whole gzip: {cause}")))?;
    if bytes.len() as u64 != needed {
        return Err(wrong(format!("truncated: {} of {needed} bytes of {count} splats are there", bytes.len())));
    }
    // Later bytes are not used, but must be read, since the checksum at the end covers all bytes.
    std::io::copy(&mut stream, &mut std::io::sink()).map_err(|cause| wrong(format!("no whole gzip: {cause}")))?;
    let (places, rest) = bytes.split_at(count as usize * place_bytes);
    let (opacities, rest) = rest.split_at(count as usize);
    let (colors, rest) = rest.split_at(3 * count as usize);
    let (scales, turns) = rest.split_at(3 * count as usize);
    for i in 0..count as usize {
        let place = &places[i * place_bytes..][..place_bytes];
        let three = |of: &[u8]| [0, 1, 2].map(|axis| f64::from(of[3 * i + axis]));
        let row = Row {
            position: [0, 1, 2].map(|axis| {
                if version == 1 {
                    half([place[2 * axis], place[2 * axis + 1]])
                } else {
                    // The arithmetic right shift sign-extends the 24 bits.
                    let word = i32::from_le_bytes([0, place[3 * axis], place[3 * axis + 1], place[3 * axis + 2]]) >> 8;
                    f64::from(word) / f64::from(1u32 << fraction)
                }
            }),
            deviations: three(scales).map(|byte| (byte / 16.0 - 10.0).exp()),
            rotation: if version == 3 {
                smallest_three(u32::from_le_bytes([0, 1, 2, 3].map(|byte| turns[4 * i + byte])))
            } else {
                let [x, y, z] = three(turns).map(|byte| byte / 127.5 - 1.0);
                [x, y, z, (1.0 - (x * x + y * y + z * z)).max(0.0).sqrt()]
            },
            opacity: opacity_of(opacities[i].into()),
            color: color_of(three(colors).map(|byte| (byte / 255.0 - 0.5) / 0.15)),
        };
        take(i, &row)?;
    }
    Ok(())
}

/// Decodes a quaternion. The top bits select the component of greatest magnitude among x, y, z, w. The other three follow in this order, so
/// the last one is in the lowest bits. Each is a sign and 9 bits for a magnitude from 0 to 1/√2.
fn smallest_three(mut word: u32) -> [f64; 4] {
    let greatest = (word >> 30) as usize;
    let mut xyzw = [0.0; 4];
    for place in (0..4).rev().filter(|place| *place != greatest) {
        let size = f64::from(word & 511) / 511.0 * 0.5_f64.sqrt();
        xyzw[place] = if word & 512 == 0 { size } else { -size };
        word >>= 10;
    }
    xyzw[greatest] = (1.0 - xyzw.iter().map(|x| x * x).sum::<f64>()).max(0.0).sqrt();
    xyzw
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
