//! Numbers of glTF accessors, with all ranges checked. The glTF crate's own reader assumes that accessors lie inside their buffers.

use crate::scene::files::gltf_document::GltfDocument;
use gltf::Accessor;
use gltf::accessor::sparse::{IndexType, Sparse};
use gltf::accessor::{DataType, Dimensions};
use std::borrow::Cow;
use std::result::Result;

/// Number types allowed for positions and texture coordinates: floats, and the integers of KHR_mesh_quantization.
pub(in crate::scene) const NUMBERS: [DataType; 5] =
    [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];

/// The largest number of elements that an accessor may have without bytes for each in the file.
const MOST_UNSTORED: usize = 1 << 20;

/// The largest size of an element: 16 floats.
const MOST_SIZE: usize = 64;

/// The elements of an accessor.
pub(in crate::scene) struct Elements<'a> {
    bytes: Cow<'a, [u8]>,
    stride: usize,
    size: usize,
    /// The number of elements that are 0 and not stored.
    zeros: usize,
}

impl Elements<'_> {
    /// Returns the bytes of each element.
    pub(in crate::scene) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        const ZERO: [u8; MOST_SIZE] = [0; MOST_SIZE];
        let stored = self.bytes.chunks(self.stride).filter_map(|chunk| chunk.get(..self.size));
        stored.chain(std::iter::repeat_n(&ZERO[..self.size.min(MOST_SIZE)], self.zeros))
    }
}

/// Returns the elements of an accessor. Those of an accessor without a buffer view are 0, and sparse ones are replaced (glTF 2.0, 3.6.2.3).
pub(in crate::scene) fn elements<'a>(
    file: &'a GltfDocument,
    accessor: &Accessor,
    dimensions: Dimensions,
    types: &[DataType],
) -> Result<Elements<'a>, String> {
    let found = (accessor.dimensions(), accessor.data_type());
    if found.0 != dimensions || !types.contains(&found.1) {
        return Err(format!("is {:?} of {:?}, not {dimensions:?} of one of {types:?}", found.0, found.1));
    }
    let is_stored = !file.unstored.contains(&accessor.index());
    let stored = match accessor.view().filter(|_| is_stored) {
        Some(view) => stored(&file.buffers, accessor, &view)?,
        None if accessor.count() > MOST_UNSTORED => {
            return Err(format!("has {} elements without a buffer view, more than {MOST_UNSTORED}", accessor.count()));
        }
        None => {
            let size = accessor.size();
            Elements { bytes: Cow::Borrowed(&[]), stride: size, size, zeros: accessor.count() }
        }
    };
    match accessor.sparse() {
        Some(sparse) => replaced(&file.buffers, &stored, &sparse),
        None => Ok(stored),
    }
}

fn stored<'a>(buffers: &'a [Vec<u8>], accessor: &Accessor, view: &gltf::buffer::View) -> Result<Elements<'a>, String> {
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(format!("has a stride of {stride} bytes for elements of {size}"));
    }
    let within = || {
        let bytes = view_bytes(buffers, view)?.get(accessor.offset()..)?;
        let last_end = accessor.count().checked_sub(1)?.checked_mul(stride)?.checked_add(size)?;
        bytes.get(..last_end)
    };
    let bytes = match within() {
        Some(bytes) => bytes,
        None if accessor.count() == 0 => &[],
        None => return Err("reaches beyond its buffer".into()),
    };
    Ok(Elements { bytes: Cow::Borrowed(bytes), stride, size, zeros: 0 })
}

/// Returns elements of which some are replaced.
fn replaced<'a>(buffers: &[Vec<u8>], elements: &Elements, sparse: &Sparse) -> Result<Elements<'a>, String> {
    let size = elements.size;
    let mut all: Vec<u8> = elements.iter().flatten().copied().collect();
    let (indices, values) = (sparse.indices(), sparse.values());
    let width = match indices.index_type() {
        IndexType::U8 => 1,
        IndexType::U16 => 2,
        IndexType::U32 => 4,
    };
    let bytes = |view: &gltf::buffer::View, offset: usize, size: usize| {
        view_bytes(buffers, view)?.get(offset..)?.get(..sparse.count().checked_mul(size)?)
    };
    let indices = bytes(&indices.view(), indices.offset(), width);
    let values = bytes(&values.view(), values.offset(), size);
    let (Some(indices), Some(values)) = (indices, values) else {
        return Err("has sparse elements that reach beyond their buffer".into());
    };
    for (index, value) in indices.chunks_exact(width).zip(values.chunks_exact(size)) {
        let index = index.iter().rev().fold(0, |index, &byte| index << 8 | usize::from(byte));
        let place = index.checked_mul(size).and_then(|at| all.get_mut(at..)?.get_mut(..size));
        place
            .ok_or_else(|| format!("has a sparse element {index} of {}", elements.iter().count()))?
            .copy_from_slice(value);
    }
    Ok(Elements { bytes: Cow::Owned(all), stride: size, size, zeros: 0 })
}

/// Returns the bytes of a buffer view; `None` if it reaches beyond its buffer.
pub(in crate::scene) fn view_bytes<'a>(buffers: &'a [Vec<u8>], view: &gltf::buffer::View) -> Option<&'a [u8]> {
    buffers.get(view.buffer().index())?.get(view.offset()..)?.get(..view.length())
}

/// Returns the numbers of an element of an accessor; NaN for those that it does not have.
pub(in crate::scene) fn numbers<const N: usize>(accessor: &Accessor, element: &[u8]) -> [f64; N] {
    let mut numbers = element.chunks(accessor.data_type().size()).map(|bytes| number(accessor, bytes));
    [(); N].map(|()| numbers.next().unwrap_or(f64::NAN))
}

/// Reads one number: a float, or an integer, which may be normalized to [−1, 1] (glTF 2.0, 3.11).
fn number(accessor: &Accessor, bytes: &[u8]) -> f64 {
    let (value, largest): (f64, f64) = match (accessor.data_type(), bytes) {
        (DataType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]).into(),
        (DataType::I8, &[a]) => (i8::from_le_bytes([a]).into(), i8::MAX.into()),
        (DataType::U8, &[a]) => (a.into(), u8::MAX.into()),
        (DataType::I16, &[a, b]) => (i16::from_le_bytes([a, b]).into(), i16::MAX.into()),
        (DataType::U16, &[a, b]) => (u16::from_le_bytes([a, b]).into(), u16::MAX.into()),
        _ => return f64::NAN,
    };
    if accessor.normalized() { (value / largest).max(-1.0) } else { value }
}
