//! Buffers packed by Blosc, version 1 of its format, with LZ4 and byte shuffle, which is all that OpenVDB and NanoVDB write. Sources: c-blosc's
//! README_HEADER.rst and blosc.c; LZ4's lz4_Block_format.md.

use std::cmp::min;

/// Size of a header, in bytes.
const HEADER: usize = 16;

/// Conditions for splitting a block, so that each byte of its numbers is packed separately: it has at least this many numbers, and each
/// number has at most this many bytes.
const SPLIT: [usize; 2] = [128, 16];

/// Unpacks `packed`, which must yield `count` bytes.
///
/// # Errors
/// A message if the codec is not supported, the data are damaged, or the length differs.
pub(super) fn unpacked(packed: &[u8], count: usize) -> Result<Vec<u8>, String> {
    let damaged = || "its Blosc data are damaged".to_owned();
    let header = packed.get(..HEADER).ok_or_else(damaged)?;
    let word = |at: usize| {
        packed.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).ok_or_else(damaged)
    };
    let (flags, wide, bytes, block) = (header[2], usize::from(header[3]), word(4)?, word(8)?);
    if bytes != count || wide == 0 || block == 0 {
        return Err(damaged());
    }
    if flags & 2 != 0 {
        return packed.get(HEADER..HEADER + count).map(<[u8]>::to_vec).ok_or_else(damaged);
    }
    if flags & 4 != 0 || flags >> 5 != 1 {
        return Err("its Blosc data are not of LZ4 and whole bytes, as OpenVDB and NanoVDB write them".into());
    }
    let mut all = Vec::with_capacity(count);
    for number in 0..count.div_ceil(block) {
        let length = min(block, count - all.len());
        let is_split = flags & 16 == 0 && wide <= SPLIT[1] && block / wide >= SPLIT[0] && length == block;
        let parts = if is_split { wide } else { 1 };
        let (mut at, mut sorted) = (word(HEADER + 4 * number)?, Vec::with_capacity(length));
        for part in 0..parts {
            // The last part gets the remainder.
            let part = if part + 1 < parts { length / parts } else { length - sorted.len() };
            let size = word(at)?;
            let data = at.checked_add(4 + size).and_then(|end| packed.get(at + 4..end)).ok_or_else(damaged)?;
            at += 4 + size;
            if size == part {
                sorted.extend_from_slice(data)
            } else {
                lz4(data, part, &mut sorted).ok_or_else(damaged)?
            }
        }
        if flags & 1 != 0 && wide > 1 { shuffled(&sorted, wide, &mut all) } else { all.extend(sorted) }
    }
    Ok(all)
}

/// Undoes the byte shuffle, which stores the first bytes of all numbers together, then the second bytes, and so on. Bytes after the last
/// whole number are not shuffled.
fn shuffled(sorted: &[u8], wide: usize, all: &mut Vec<u8>) {
    let (count, begin) = (sorted.len() / wide, all.len());
    all.extend_from_slice(sorted);
    for (i, bytes) in sorted.chunks_exact(count.max(1)).take(wide).enumerate().filter(|_| count > 0) {
        let places = all[begin + i..].iter_mut().step_by(wide);
        places.zip(bytes).for_each(|(to, from)| *to = *from);
    }
}

/// Appends the `count` bytes of an LZ4 block; returns None if the block is damaged.
fn lz4(mut packed: &[u8], count: usize, all: &mut Vec<u8>) -> Option<()> {
    let (begin, end) = (all.len(), all.len() + count);
    loop {
        let token = take(&mut packed, 1)?[0];
        let literals = length(token >> 4, &mut packed)?;
        if literals > end - all.len() {
            return None;
        }
        all.extend_from_slice(take(&mut packed, literals)?);
        if all.len() == end {
            return Some(());
        }
        let offset = take(&mut packed, 2)?;
        let offset = usize::from(u16::from_le_bytes([offset[0], offset[1]]));
        let mut length = 4 + length(token & 15, &mut packed)?;
        if offset == 0 || offset > all.len() - begin || length > end - all.len() {
            return None;
        }
        // A match may overlap its own output, so that each copy doubles what can be copied next.
        let from = all.len() - offset;
        while length > 0 {
            let count = min(length, all.len() - from);
            all.extend_from_within(from..from + count);
            length -= count;
        }
    }
}

/// Reads a length whose lowest part is four bits; 15 means that more bytes follow.
fn length(low: u8, packed: &mut &[u8]) -> Option<usize> {
    let mut length = usize::from(low);
    let mut last = if low == 15 { 255 } else { 0 };
    while last == 255 {
        last = take(packed, 1)?[0];
        length += usize::from(last);
    }
    Some(length)
}

fn take<'a>(packed: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, rest) = packed.split_at_checked(count)?;
    *packed = rest;
    Some(taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hand-written block: three literals; a match of 9 bytes that overlaps its own output; two literals at the end.
    #[test]
    fn a_block_of_lz4() {
        let packed = [0x35, b'a', b'b', b'c', 3, 0, 0x20, b'x', b'y'];
        let mut all = b"before".to_vec();
        assert_eq!(lz4(&packed, 14, &mut all), Some(()));
        assert_eq!(all, b"beforeabcabcabcabcxy");
        for (wrong, count) in
            [(&packed[..8], 14), (&packed[..], 13), (&packed[..], 15), (&[0x35, 1, 2, 3, 4, 0][..], 14)]
        {
            assert_eq!(lz4(wrong, count, &mut Vec::new()), None, "{wrong:?} {count}");
        }
    }

    #[test]
    fn bytes_are_put_back() {
        let mut all = Vec::new();
        shuffled(&[1, 4, 2, 5, 3, 6, 7], 3, &mut all);
        assert_eq!(all, [1, 2, 3, 4, 5, 6, 7]);
    }
}
