//! Splats from SOG (PlayCanvas' *Spatially Ordered Gaussians*): a `meta.json` and images, each with a pixel per splat in rows from the top.
//! They are in one folder, or in a zip archive with the ending `.sog`.
//!
//! | image | what |
//! |---|---|
//! | `means_l`, `means_u` | position: low and high byte of x, y, z, between bounds, as sign(x) ln(1 + \|x\|) |
//! | `scales` | logarithms of deviations |
//! | `quats` | rotation: three components from −1/√2 to 1/√2; alpha is 252 to 255 if w, x, y or z is left out, the greatest |
//! | `sh0` | red, green, blue as coefficients of a spherical harmonic; opacity |
//!
//! Version 2 of `meta.json` has a list of 256 numbers to which the bytes of scales and colors point, and opacity/255. Version 1 has bounds
//! between which the bytes interpolate, and opacity before a logistic function. How the color changes with the viewing direction is not read.

use crate::scene::files::splat_file::{self, Row, color_of, opacity_of};
use image::{ColorType, ImageDecoder, ImageReader};
use serde::Deserialize;
use std::io::{Cursor, Read};
use std::path::{Component, Path};

/// The most bytes of a `meta.json`, which has a few hundred numbers.
const MOST_META: u64 = 1 << 20;

/// The most bytes that deflate makes of one.
const MOST_PER_BYTE: u64 = 1032;

/// The most splats.
const MOST_SPLATS: u64 = 1 << 27;

/// The most pixels per splat, and beside them: images have whole rows. Like splats take next to nothing in an image, so that its size in
/// bytes says nothing.
const MOST_PIXELS: [u64; 2] = [2, 1 << 16];

const META: &str = "meta.json";

/// Places in x, y, z, w of the three components of a pixel and of the greatest, if that is w, x, y or z.
const PLACES: [[usize; 4]; 4] = [[0, 1, 2, 3], [3, 1, 2, 0], [3, 0, 2, 1], [3, 0, 1, 2]];

#[derive(Deserialize)]
struct Meta {
    /// Version 1 has none.
    version: Option<u32>,
    /// Version 1 has the shape of the means instead.
    count: Option<u64>,
    /// How the splats are to be rendered.
    model: Option<String>,
    means: Means,
    scales: Channels,
    quats: Files,
    sh0: Channels,
}

#[derive(Deserialize)]
struct Means {
    shape: Option<Vec<u64>>,
    mins: [f64; 3],
    maxs: [f64; 3],
    files: [String; 2],
}

/// An image of numbers, which version 2 takes from a codebook and version 1 from between bounds.
#[derive(Deserialize)]
struct Channels {
    codebook: Option<Vec<Option<f64>>>,
    mins: Option<Vec<f64>>,
    maxs: Option<Vec<f64>>,
    files: [String; 1],
}

#[derive(Deserialize)]
struct Files {
    files: [String; 1],
}

/// A decoded image.
struct Pixels {
    bytes: Vec<u8>,
    /// Bytes per pixel: 3 without alpha, else 4.
    width: usize,
}

/// What the bytes of an image stand for: 256 numbers for each channel.
type Tables = [[f64; 256]; 4];

/// Reads all splats of an archive and passes each to `take` with its index. `notes` gets what a user should know of the file.
///
/// # Errors
/// If the bytes are no archive, truncated, damaged or of another version, or files are missing.
pub(super) fn load_archive(bytes: &[u8], notes: &mut Vec<String>, take: impl FnMut(usize, &Row)) -> Result<(), String> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|cause| format!("no zip archive: {cause}"))?;
    let most = MOST_META + MOST_PER_BYTE * bytes.len() as u64;
    let read = |name: &str| {
        let mut file = archive.by_name(name).map_err(|cause| format!("{name}: {cause}"))?;
        read(name, &mut file, most)
    };
    load(read, notes, take)
}

/// Reads all splats of a `meta.json` and the images beside it, like [`load_archive`].
///
/// # Errors
/// If a file is missing, truncated, damaged or of another version.
pub(super) fn load_folder(meta: &Path, notes: &mut Vec<String>, take: impl FnMut(usize, &Row)) -> Result<(), String> {
    let read = |name: &str| {
        let path = if name == META { meta.to_owned() } else { meta.with_file_name(name) };
        let mut file = std::fs::File::open(path).map_err(|cause| format!("{name}: {cause}"))?;
        read(name, &mut file, u64::MAX)
    };
    load(read, notes, take)
}

/// Reads a file, at most `most` bytes of it.
fn read(name: &str, file: &mut impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let most = if name == META { MOST_META } else { most };
    file.take(most).read_to_end(&mut bytes).map_err(|cause| format!("{name}: {cause}"))?;
    if bytes.len() as u64 == most { Err(format!("{name} has {most} bytes or more")) } else { Ok(bytes) }
}

/// Reads all splats of the files that `read` gives.
fn load(
    mut read: impl FnMut(&str) -> Result<Vec<u8>, String>,
    notes: &mut Vec<String>,
    mut take: impl FnMut(usize, &Row),
) -> Result<(), String> {
    let meta: Meta = serde_json::from_slice(&read(META)?).map_err(|cause| format!("{META}: {cause}"))?;
    let version = meta.version.unwrap_or(1);
    if !(1..=2).contains(&version) {
        return Err(format!("{META} has version {version}, which is not read"));
    }
    if meta.model.as_deref() == Some("antialiased") {
        notes.push(splat_file::ANTIALIASED.into());
    }
    let count = meta.count.or(meta.means.shape.as_ref().and_then(|shape| shape.first().copied()));
    let count = count.ok_or_else(|| format!("{META} has no number of splats"))?;
    let [low, high] = &meta.means.files;
    let names = [low, high, &meta.quats.files[0], &meta.scales.files[0], &meta.sh0.files[0]];
    let mut files = Vec::new();
    for name in names {
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(format!("{META} names {name:?}, which is not beside it"));
        }
        files.push((name, read(name)?));
    }
    if count > MOST_SPLATS {
        return Err(format!("{count} splats, of at most {MOST_SPLATS}"));
    }
    let most = MOST_PIXELS[0] * count + MOST_PIXELS[1];
    let images = std::thread::scope(|scope| {
        let decoded: Vec<_> = files.iter().map(|(_, bytes)| scope.spawn(move || pixels(bytes, count, most))).collect();
        let joined = decoded.into_iter().map(|image| image.join().unwrap_or_else(|_| Err("is damaged".into())));
        let named = joined.zip(&files).map(|(image, (name, _))| image.map_err(|cause| format!("{name} {cause}")));
        named.collect::<Result<Vec<_>, _>>()
    })?;
    let (scales, colors) = (tables(&meta.scales, version, 3)?, tables(&meta.sh0, version, 4)?);
    let deviations = scales.map(|table| table.map(f64::exp));
    let [low, high, turns, scales, sh0] = &images[..] else { return Ok(()) };
    let [low, high, turns, scales, sh0] = [low, high, turns, scales, sh0].map(Pixels::iter);
    let all = low.zip(high).zip(turns).zip(scales).zip(sh0).take(count as usize).enumerate();
    for (number, ((((low, high), turn), scale), color)) in all {
        let opacity = color.get(3).copied().unwrap_or(255);
        let row = Row {
            position: [0, 1, 2].map(|axis| {
                let share = f64::from(u16::from_le_bytes([low[axis], high[axis]])) / 65535.0;
                let [least, greatest] = [meta.means.mins[axis], meta.means.maxs[axis]];
                let of = least + share * (greatest - least);
                (of.abs().exp() - 1.0).copysign(of)
            }),
            deviations: [0, 1, 2].map(|axis| deviations[axis][usize::from(scale[axis])]),
            rotation: rotation(turn),
            opacity: match version {
                1 => 1.0 / (1.0 + (-colors[3][usize::from(opacity)]).exp()),
                _ => opacity_of(opacity.into()),
            },
            color: color_of([0, 1, 2].map(|i| colors[i][usize::from(color[i])])),
        };
        take(number, &row);
    }
    Ok(())
}

/// Decodes an image with at least a pixel for each splat and at most `most` pixels.
fn pixels(bytes: &[u8], count: u64, most: u64) -> Result<Pixels, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    // What is allocated is checked here.
    reader.no_limits();
    let reader = reader.with_guessed_format().map_err(|cause| cause.to_string())?;
    let decoder = reader.into_decoder().map_err(|cause| format!("is no image: {cause}"))?;
    let (columns, rows) = decoder.dimensions();
    let size = u64::from(columns) * u64::from(rows);
    if size < count || size > most {
        return Err(format!("has {columns} by {rows} pixels, not {count} to {most}"));
    }
    let width = match decoder.color_type() {
        ColorType::Rgb8 => 3,
        ColorType::Rgba8 => 4,
        other => return Err(format!("has pixels of {other:?} and not 8 bits per channel")),
    };
    let mut bytes = vec![0; size as usize * width];
    decoder.read_image(&mut bytes).map_err(|cause| format!("is damaged: {cause}"))?;
    Ok(Pixels { bytes, width })
}

impl Pixels {
    /// Returns each pixel's bytes.
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes.chunks_exact(self.width)
    }
}

/// Returns the numbers for the bytes of the image's channels.
fn tables(channels: &Channels, version: u32, count: usize) -> Result<Tables, String> {
    let mut tables = [[0.0; 256]; 4];
    if version == 1 {
        let (Some(mins), Some(maxs)) = (&channels.mins, &channels.maxs) else {
            return Err(format!("{META} has no bounds of {}", channels.files[0]));
        };
        if mins.len() < count || maxs.len() < count {
            return Err(format!("{META} has too few bounds of {}", channels.files[0]));
        }
        for (table, (least, greatest)) in tables.iter_mut().zip(mins.iter().zip(maxs)) {
            *table = std::array::from_fn(|byte| least + (greatest - least) * byte as f64 / 255.0);
        }
        return Ok(tables);
    }
    let codebook = channels.codebook.as_deref().unwrap_or_default();
    let mut table: [Option<f64>; 256] = codebook
        .try_into()
        .map_err(|_| format!("{META} has {} of 256 numbers of {}", codebook.len(), channels.files[0]))?;
    // Null for the first number is read as by others: the list is continued.
    if let ([None, ..], [_, Some(next), .., Some(last)]) = (&table, &table) {
        table[0] = Some(next + (next - last) / 255.0);
    }
    let of = |number: Option<f64>| {
        number.ok_or_else(|| format!("{META} has null among the numbers of {}", channels.files[0]))
    };
    for (place, number) in table.into_iter().enumerate() {
        let number = of(number)?;
        tables[..3].iter_mut().for_each(|channel| channel[place] = number);
    }
    Ok(tables)
}

/// Decodes a quaternion. One with another alpha is no rotation: the reader of the format's makers does not turn it either.
fn rotation(pixel: &[u8]) -> [f64; 4] {
    let [a, b, c] = [0, 1, 2].map(|i| (f64::from(pixel[i]) / 255.0 - 0.5) * std::f64::consts::SQRT_2);
    let alpha = pixel.get(3).copied().unwrap_or(255);
    let Some([first, second, third, fourth]) = PLACES.get(usize::from(alpha.wrapping_sub(252))) else {
        return [0.0, 0.0, 0.0, 1.0];
    };
    let mut xyzw = [0.0; 4];
    xyzw[*first] = a;
    xyzw[*second] = b;
    xyzw[*third] = c;
    xyzw[*fourth] = (1.0 - (a * a + b * b + c * c)).max(0.0).sqrt();
    xyzw
}

#[cfg(test)]
mod tests {
    use super::{Channels, tables};

    #[test]
    fn a_list_that_begins_with_null_is_continued() {
        let mut codebook: Vec<_> = (0..256).map(|i| Some(f64::from(i) * 2.0)).collect();
        codebook[0] = None;
        let channels = Channels { codebook: Some(codebook), mins: None, maxs: None, files: ["scales.webp".into()] };
        let [red, _, blue, _] = tables(&channels, 2, 3).unwrap();
        assert_eq!((red[0], red[1], blue[255]), (2.0 - 508.0 / 255.0, 2.0, 510.0));
        assert_eq!(red, blue);
    }
}
