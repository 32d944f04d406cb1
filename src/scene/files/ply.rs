//! Row-by-row reading of PLY files, shared by the particle and mesh loaders. The header's counts are never trusted.

use crate::scene::files::input;
use crate::{Error, Result};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyType, ScalarType,
};
use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
use std::path::{Path, PathBuf};

const WAY_OUT: &str = "check that the file is a PLY file and was copied whole";

/// An open PLY file; its header has been read and checked against the file's size.
pub(in crate::scene) struct PlyFile {
    path: PathBuf,
    header: Header,
    reader: BufReader<File>,
}

/// Opens a PLY file and reads its header.
///
/// # Errors
/// [`Error::Input`] if the file is unreadable, not a PLY file, or too short for the rows declared in its header. This check keeps later
/// code from allocating more than the file's size justifies.
pub(in crate::scene) fn open(path: &Path) -> Result<PlyFile> {
    let (file, size_bytes) = input::open(path)?;
    let mut reader = Reader::new(BufReader::new(file));
    let header = Parser::<DefaultElement>::new()
        .read_header(&mut reader)
        .map_err(|cause| input::error(path, format!("not a PLY header: {cause}"), WAY_OUT))?;
    let mut reader = reader.into_inner();
    let header_bytes = reader.stream_position().map_err(|cause| input::error(path, cause, WAY_OUT))?;
    let data_bytes = size_bytes.saturating_sub(header_bytes);

    let mut needed_bytes = 0_u128;
    for (name, element) in &header.elements {
        if element.count > 0 && element.properties.is_empty() {
            return Err(input::error(path, format!("element {name} has no properties"), WAY_OUT));
        }
        needed_bytes = needed_bytes.saturating_add(element.count as u128 * smallest_row_bytes(&header, element));
    }
    // The last line of an ASCII file may lack its line break.
    let slack_bytes = u128::from(header.encoding == Encoding::Ascii);
    if needed_bytes > u128::from(data_bytes) + slack_bytes {
        let cause =
            format!("truncated: the header promises at least {needed_bytes} bytes of data, {data_bytes} are there");
        return Err(input::error(path, cause, WAY_OUT));
    }
    Ok(PlyFile { path: path.to_path_buf(), header, reader })
}

/// Returns the smallest possible size of a row in bytes: lists may be empty, and an ASCII number has at least a digit and a separator.
fn smallest_row_bytes(header: &Header, element: &ElementDef) -> u128 {
    let binary_bytes = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let property_bytes = |data_type: &PropertyType| match (header.encoding, data_type) {
        (Encoding::Ascii, _) => 2,
        (_, PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) => binary_bytes(scalar),
    };
    element.properties.values().map(|property| property_bytes(&property.data_type)).sum()
}

impl PlyFile {
    /// Returns an element's definition.
    ///
    /// # Errors
    /// An error if the file has no such element.
    pub(in crate::scene) fn element(&self, name: &str) -> Result<&ElementDef> {
        let way_out = "give a file with that element";
        self.header.elements.get(name).ok_or_else(|| self.error(format!("has no element {name}"), way_out))
    }

    /// Returns whether the element exists and has rows.
    /// Returns whether the header has this comment.
    pub(in crate::scene) fn has_comment(&self, text: &str) -> bool {
        self.header.comments.iter().any(|comment| comment.trim() == text)
    }

    pub(in crate::scene) fn has_rows(&self, element: &str) -> bool {
        self.header.elements.get(element).is_some_and(|element| element.count > 0)
    }

    /// Returns whether an element has a scalar property of that name, of any number type.
    pub(in crate::scene) fn has_scalar(&self, element: &str, property: &str) -> bool {
        let definition = self.header.elements.get(element).and_then(|element| element.properties.get(property));
        definition.is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
    }

    /// Reports the first scalar property that an element lacks.
    ///
    /// # Errors
    /// An error if the file lacks the element or one of the properties.
    pub(in crate::scene) fn require_scalars(&self, element: &str, properties: &[&str]) -> Result<()> {
        self.element(element)?;
        match properties.iter().find(|property| !self.has_scalar(element, property)) {
            Some(missing) => {
                Err(self
                    .error(format!("element {element} lacks the property {missing}"), "add the property to the file"))
            }
            None => Ok(()),
        }
    }

    /// Reads rows in file order and passes each to `visit` with its element's name and its index from 0, up to the last row of the last of
    /// the `wanted` elements.
    ///
    /// # Errors
    /// [`Error::Input`] names the row that cannot be read; errors of `visit` are passed on.
    pub(in crate::scene) fn read_rows<Row: PropertyAccess>(
        mut self,
        wanted: &[&str],
        mut visit: impl FnMut(&str, usize, Row) -> Result<()>,
    ) -> Result<()> {
        let parser = Parser::<Row>::new();
        let elements = std::mem::take(&mut self.header.elements);
        let last = elements.keys().rposition(|name| wanted.contains(&name.as_str()));
        let mut line = String::new();
        for (name, element) in elements.iter().take(last.map_or(0, |last| last + 1)) {
            for row in 0..element.count {
                let read = match self.header.encoding {
                    Encoding::Ascii => {
                        next_line(&mut self.reader, &mut line).and_then(|()| parser.read_ascii_element(&line, element))
                    }
                    Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.reader, element),
                    Encoding::BinaryLittleEndian => parser.read_little_endian_element(&mut self.reader, element),
                };
                let read = read.map_err(|cause| {
                    self.error(format!("cannot read {name} {row} (the first is 0): {cause}"), WAY_OUT)
                })?;
                visit(name, row, read)?;
            }
        }
        Ok(())
    }

    /// Creates an [`Error::Input`] about this file.
    pub(in crate::scene) fn error(&self, cause: impl ToString, way_out: &str) -> Error {
        input::error(&self.path, cause, way_out)
    }
}

/// Reads the next line that is not blank: some writers separate elements by blank lines.
fn next_line(reader: &mut impl BufRead, line: &mut String) -> std::result::Result<(), ParseError> {
    loop {
        line.clear();
        if reader.read_line(line)? == 0 {
            return Err(std::io::Error::new(std::io::ErrorKind::UnexpectedEof, "the file ends here").into());
        }
        if !line.trim().is_empty() {
            return Ok(());
        }
    }
}

/// Converts a scalar of any type to f64, exactly; `None` for a list.
pub(in crate::scene) fn scalar(value: &Property) -> Option<f64> {
    match *value {
        Property::Char(value) => Some(value.into()),
        Property::UChar(value) => Some(value.into()),
        Property::Short(value) => Some(value.into()),
        Property::UShort(value) => Some(value.into()),
        Property::Int(value) => Some(value.into()),
        Property::UInt(value) => Some(value.into()),
        Property::Float(value) => Some(value.into()),
        Property::Double(value) => Some(value),
        _ => None,
    }
}
