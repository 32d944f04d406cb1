//! Grids from three-dimensional NRRD files (Teem's *nearly raw raster data*, versions 1 to 5), raw or gzip, with the data in the same file.

use crate::scene::files::dense_file::{Dense, Kind};
use crate::scene::files::volume_file::Grid;
use flate2::read::GzDecoder;
use glam::DVec3;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};

/// The maximum size of a header, in bytes.
const MOST_HEADER: u64 = 1 << 16;

/// The largest number of bytes to which deflate can expand one byte.
const MOST_RATIO: u64 = 1032;

/// The fields of a header.
#[derive(Default)]
struct Header {
    kind: Option<Kind>,
    size: Option<[u32; 3]>,
    zipped: bool,
    big_endian: Option<bool>,
    steps: Option<[DVec3; 3]>,
    origin: Option<DVec3>,
}

/// Reads an NRRD file of `size` bytes. `window`: see [`Dense::window`].
///
/// # Errors
/// A message if the file is not NRRD, its number of dimensions, type or encoding is not supported, its data are in another file, or it is
/// truncated.
pub(in crate::scene) fn read(file: File, size: u64, window: Option<[f64; 2]>) -> Result<Grid, String> {
    let mut stream = BufReader::new(file);
    let (header, length) = header(&mut stream)?;
    let kind = header.kind.ok_or("its header has no type")?;
    if kind.is_signed() && window.is_none() {
        let cause = "its numbers are signed: a scene file says which are densities 0 and 1";
        return Err(format!("{cause}, as in window = [-1000.0, 400.0] of [[volumes]]"));
    }
    let dense = Dense {
        size: header.size.ok_or("its header has no sizes")?,
        kind,
        window,
        big_endian: match header.big_endian {
            None if kind.bytes() > 1 => return Err("its header has no endian".into()),
            given => given.unwrap_or(false),
        },
    };
    let (needed, left) = (dense.bytes()?, size.saturating_sub(length));
    if !header.zipped && left != needed || header.zipped && needed > left.saturating_mul(MOST_RATIO) {
        return Err(format!("{left} bytes of data, and a grid of {:?} has {needed}", dense.size));
    }
    let field = if header.zipped { dense.read(GzDecoder::new(stream))? } else { dense.read(stream)? };
    let steps = header.steps.unwrap_or([DVec3::X, DVec3::Y, DVec3::Z]);
    Ok(Grid {
        field,
        origin: header.origin.unwrap_or_default(),
        steps,
        own_steps: None,
        extinction: 1.0,
        color: None,
        notes: Vec::new(),
    })
}

/// Reads the header; returns it with its length in bytes.
fn header(stream: &mut impl BufRead) -> Result<(Header, u64), String> {
    let (mut header, mut length, mut is_first) = (Header::default(), 0, true);
    loop {
        let mut line = Vec::new();
        let read = stream.by_ref().take(MOST_HEADER).read_until(b'\n', &mut line).map_err(|cause| cause.to_string())?;
        length += read as u64;
        let line = str::from_utf8(&line).map_err(|_| "its header is no text")?;
        if is_first && !(line.starts_with("NRRD000") && line.trim_end().len() == 8) {
            return Err("no NRRD: it does not begin with NRRD0001 to NRRD0005".into());
        }
        if length > MOST_HEADER || read == 0 {
            return Err(format!("no empty line ends its header within {MOST_HEADER} bytes"));
        }
        let line = line.trim_end();
        if line.is_empty() {
            return Ok((header, length));
        }
        // key:=value pairs are free-form data for other programs.
        if !is_first && !line.starts_with('#') && !line.contains(":=") {
            let (name, value) = line.split_once(": ").ok_or_else(|| format!("{line:?} is no field"))?;
            header.field(&name.to_lowercase(), value.trim())?;
        }
        is_first = false;
    }
}

impl Header {
    fn field(&mut self, name: &str, value: &str) -> Result<(), String> {
        let wrong = || format!("{name}: {value} is not read");
        match name {
            "type" => {
                self.kind = Some(match value {
                    "uchar" | "unsigned char" | "uint8" | "uint8_t" => Kind::U8,
                    "signed char" | "int8" | "int8_t" => Kind::I8,
                    "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Kind::U16,
                    "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Kind::I16,
                    "uint" | "unsigned int" | "uint32" | "uint32_t" => Kind::U32,
                    "int" | "signed int" | "int32" | "int32_t" => Kind::I32,
                    "float" => Kind::F32,
                    "double" => Kind::F64,
                    _ => return Err(format!("{}: give an integer of up to 32 bits, float or double", wrong())),
                });
            }
            "dimension" if value == "4" => {
                // Components come first, frames last.
                let way_out =
                    "`unu slice -a 3 -p 0 -i IN -o OUT` takes the first of its frames, -a 0 of its components";
                return Err(format!("{}: {way_out}", wrong()));
            }
            "dimension" if value != "3" => return Err(format!("{}: give 3", wrong())),
            "sizes" => self.size = Some(three(value.split_whitespace()).ok_or_else(wrong)?),
            "encoding" => {
                self.zipped = match value {
                    "raw" => false,
                    "gzip" | "gz" => true,
                    _ => return Err(format!("{}: give raw or gzip", wrong())),
                }
            }
            "endian" => {
                self.big_endian = Some(match value {
                    "little" => false,
                    "big" => true,
                    _ => return Err(wrong()),
                });
            }
            "spacings" => {
                let [x, y, z]: [f64; 3] = three(value.split_whitespace()).ok_or_else(wrong)?;
                self.steps = Some([DVec3::X * x, DVec3::Y * y, DVec3::Z * z]);
            }
            "space directions" => {
                self.steps = Some(three_of(value.split_whitespace().map(vector)).ok_or_else(wrong)?);
            }
            "space origin" => self.origin = Some(vector(value).ok_or_else(wrong)?),
            "data file" | "datafile" => return Err("its data is in another file: attach it".into()),
            "byte skip" | "byteskip" | "line skip" | "lineskip" if value != "0" => return Err(wrong()),
            _ => {}
        }
        Ok(())
    }
}

fn three<'a, T: std::str::FromStr>(words: impl Iterator<Item = &'a str>) -> Option<[T; 3]> {
    three_of(words.map(|word| word.parse().ok()))
}

fn three_of<T>(all: impl Iterator<Item = Option<T>>) -> Option<[T; 3]> {
    all.collect::<Option<Vec<_>>>()?.try_into().ok()
}

/// Parses a vector such as "(1,2,3)".
fn vector(text: &str) -> Option<DVec3> {
    let inner = text.strip_prefix('(')?.strip_suffix(')')?;
    three(inner.split(',').map(str::trim)).map(DVec3::from_array)
}
