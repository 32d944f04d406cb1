//! Numbers of glTF accessors, with all ranges checked. The glTF crate's own reader assumes that accessors lie inside their buffers.

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};
use std::result::Result;

/// Number types allowed for positions and texture coordinates: floats, and the integers of KHR_mesh_quantization.
pub(in crate::scene) const NUMBERS: [DataType; 5] =
    [DataType::F32, DataType::I8, DataType::U8, DataType::I16, DataType::U16];

/// Returns the bytes of each element of an accessor.
pub(in crate::scene) fn elements<'a>(
    buffers: &'a [Vec<u8>],
    accessor: &Accessor,
    dimensions: Dimensions,
    types: &[DataType],
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
    let found = (accessor.dimensions(), accessor.data_type());
    if found.0 != dimensions || !types.contains(&found.1) {
        return Err(format!("is {:?} of {:?}, not {dimensions:?} of one of {types:?}", found.0, found.1));
    }
    if accessor.sparse().is_some() {
        return Err("is sparse, which is not supported".into());
    }
    let view = accessor.view().ok_or("has no buffer view")?;
    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    if stride < size {
        return Err(format!("has a stride of {stride} bytes for elements of {size}"));
    }
    let within = || {
        let bytes = view_bytes(buffers, &view)?.get(accessor.offset()..)?;
        let last_end = accessor.count().checked_sub(1)?.checked_mul(stride)?.checked_add(size)?;
        bytes.get(..last_end)
    };
    let bytes = match within() {
        Some(bytes) => bytes,
        None if accessor.count() == 0 => &[],
        None => return Err("reaches beyond its buffer".into()),
    };
    Ok(bytes.chunks(stride).filter_map(move |chunk| chunk.get(..size)))
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
