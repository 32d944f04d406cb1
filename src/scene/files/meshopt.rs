//! The codecs of meshoptimizer, as glTF stores vertices and indices with them: the bitstreams and filters of
//! KHR_meshopt_compression (its appendices A and B), of which EXT_meshopt_compression has a part. Written from that
//! text.
//!
//! A byte of a stream gives at most 1024 bytes of vertices, 12 of triangles or 4 of other indices. What is decoded
//! grows only as the stream is read, so a short stream takes little memory, whatever number of elements is promised.

type Checked<T> = std::result::Result<T, String>;

/// The number of elements whose deltas are packed together.
const GROUP: usize = 16;

/// How the bytes of a stream become elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What is done with elements after decoding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// Decodes `count` elements of `stride` bytes each.
///
/// # Errors
/// If the mode and the filter have no elements of that size, or the stream is damaged; the message says how.
pub(super) fn decode(stream: &[u8], mode: Mode, filter: Filter, count: usize, stride: usize) -> Checked<Vec<u8>> {
    let sizes: &[usize] = match (mode, filter) {
        (Mode::Attributes, Filter::None | Filter::Exponential) => &[],
        (Mode::Attributes, Filter::Octahedral | Filter::Color) => &[4, 8],
        (Mode::Attributes, Filter::Quaternion) => &[8],
        (Mode::Triangles | Mode::Indices, Filter::None) => &[2, 4],
        (Mode::Triangles | Mode::Indices, _) => return Err(format!("filter {filter:?} is not for indices")),
    };
    let fits = if sizes.is_empty() {
        stride.is_multiple_of(4) && (4..=256).contains(&stride)
    } else {
        sizes.contains(&stride)
    };
    if !fits {
        return Err(format!("mode {mode:?} with filter {filter:?} has no elements of {stride} bytes"));
    }
    match mode {
        Mode::Attributes => {
            let mut decoded = attributes(stream, count, stride)?;
            apply(filter, stride, &mut decoded);
            Ok(decoded)
        }
        Mode::Triangles if !count.is_multiple_of(3) => Err(format!("{count} indices are no whole triangles")),
        Mode::Triangles => triangles(stream, count / 3, stride),
        Mode::Indices => indices(stream, count, stride),
    }
}

fn truncated() -> String {
    "its compressed data end too early".into()
}

/// Takes bytes off the front of a stream.
fn take<'a>(stream: &mut &'a [u8], count: usize) -> Checked<&'a [u8]> {
    stream.split_off(..count).ok_or_else(truncated)
}

fn take_byte(stream: &mut &[u8]) -> Checked<u8> {
    stream.split_off_first().copied().ok_or_else(truncated)
}

/// Splits a stream into its body and the block at its end.
fn split_tail(stream: &[u8], bytes: usize) -> Checked<(&[u8], &[u8])> {
    let body = stream.len().checked_sub(bytes).ok_or_else(truncated)?;
    stream.split_at_checked(body).ok_or_else(truncated)
}

fn expect_end(rest: &[u8]) -> Checked<()> {
    if rest.is_empty() { Ok(()) } else { Err(format!("{} bytes of its compressed data are left over", rest.len())) }
}

/// Decodes mode 0. Each byte of the elements is a column of its own, with differences between successive elements.
fn attributes(stream: &[u8], count: usize, stride: usize) -> Checked<Vec<u8>> {
    let (is_new, rest) = match stream {
        [0xa0, rest @ ..] => (false, rest),
        [0xa1, rest @ ..] => (true, rest),
        _ => return Err("its vertices are of an unknown version".into()),
    };
    let channels = stride / 4;
    let tail_bytes = stride + if is_new { channels } else { 0 };
    let (mut rest, padded) = split_tail(rest, tail_bytes.max(if is_new { 24 } else { 32 }))?;
    let (_, tail) = split_tail(padded, tail_bytes)?;
    let (first, channel_modes) = tail.split_at_checked(stride).ok_or_else(truncated)?;
    if channel_modes.iter().any(|mode| mode & 15 > 2 || mode & 15 < 2 && mode >> 4 != 0) {
        return Err("its vertices have an unknown channel mode".into());
    }
    let mut previous = first.to_vec();
    let mut decoded = Vec::new();
    let block = ((8192 / stride) & !(GROUP - 1)).min(256);
    let mut left = count;
    while left > 0 {
        let in_block = left.min(block);
        let controls = if is_new { take(&mut rest, channels)? } else { &[] };
        let mut columns = Vec::with_capacity(stride);
        for column in 0..stride {
            let control = controls.get(column / 4).map(|packed| packed >> (2 * (column % 4)) & 3);
            columns.push(deltas(&mut rest, in_block, control)?);
        }
        let from = decoded.len();
        decoded.resize(from + in_block * stride, 0);
        let elements = decoded.get_mut(from..).unwrap_or_default();
        for (channel, (columns, previous)) in columns.chunks(4).zip(previous.chunks_mut(4)).enumerate() {
            let mode = channel_modes.get(channel).copied().unwrap_or(0);
            undo_deltas(columns, mode, previous, elements.chunks_exact_mut(stride), 4 * channel);
        }
        left -= in_block;
    }
    expect_end(rest)?;
    Ok(decoded)
}

/// Reads a column of a block. `control`: how version 1 stores it; without, it is of version 0.
fn deltas(rest: &mut &[u8], count: usize, control: Option<u8>) -> Checked<Vec<u8>> {
    let bits = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => return Ok(vec![0; count]),
        Some(_) => return Ok(take(rest, count)?.to_vec()),
    };
    let groups = count.div_ceil(GROUP);
    let headers = take(rest, groups.div_ceil(4))?;
    let mut column = Vec::with_capacity(groups * GROUP);
    let headers = headers.iter().flat_map(|packed| [0, 2, 4, 6].map(|shift| usize::from(packed >> shift & 3)));
    for header in headers.take(groups) {
        match bits[header] {
            0 => column.extend([0; GROUP]),
            8 => column.extend(take(rest, GROUP)?),
            bits => {
                let packed = take(rest, GROUP * bits / 8)?;
                let largest = (1 << bits) - 1;
                for place in 0..GROUP {
                    // A bit alone is stored from the lowest on, two or four from the highest.
                    let (in_byte, of_byte) = (place % (8 / bits), place / (8 / bits));
                    let shift = if bits == 1 { in_byte } else { 8 - bits - bits * in_byte };
                    let delta = packed.get(of_byte).map_or(0, |byte| byte >> shift & largest);
                    column.push(if delta == largest { take_byte(rest)? } else { delta });
                }
            }
        }
    }
    Ok(column)
}

/// Turns four columns of differences into four bytes of each element, from `at` on. `previous`: these bytes of the
/// element before.
fn undo_deltas<'a>(
    columns: &[Vec<u8>],
    mode: u8,
    previous: &mut [u8],
    elements: impl Iterator<Item = &'a mut [u8]>,
    at: usize,
) {
    let ([a, b, c, d], Ok(before)) = (columns, <[u8; 4]>::try_from(&*previous)) else { return };
    let mut last = before;
    for ((((element, a), b), c), d) in elements.zip(a).zip(b).zip(c).zip(d) {
        let delta = [*a, *b, *c, *d];
        last = match mode & 15 {
            0 => {
                let [p, q, r, s] = last;
                let [a, b, c, d] = delta.map(|delta| (delta >> 1) ^ (delta & 1).wrapping_neg());
                [p.wrapping_add(a), q.wrapping_add(b), r.wrapping_add(c), s.wrapping_add(d)]
            }
            1 => {
                let half = |of: [u8; 2], delta: [u8; 2]| {
                    let delta = u16::from_le_bytes(delta);
                    let delta = (delta >> 1) ^ (delta & 1).wrapping_neg();
                    u16::from_le_bytes(of).wrapping_add(delta).to_le_bytes()
                };
                let ([p, q, r, s], [a, b, c, d]) = (last, delta);
                let ([p, q], [r, s]) = (half([p, q], [a, b]), half([r, s], [c, d]));
                [p, q, r, s]
            }
            _ => {
                let turned = u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4));
                (u32::from_le_bytes(last) ^ turned).to_le_bytes()
            }
        };
        if let Some(place) = element.get_mut(at..at + 4) {
            place.copy_from_slice(&last);
        }
    }
    previous.copy_from_slice(&last);
}

/// The last 16 things that were added.
struct Recent<T> {
    items: [T; 16],
    added: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { items: [T::default(); 16], added: 0 }
    }

    fn add(&mut self, item: T) {
        self.items[self.added % 16] = item;
        self.added += 1;
    }

    /// Returns what was added `age` additions before the last one.
    fn get(&self, age: u8) -> Checked<T> {
        let place = self.added.checked_sub(1 + usize::from(age));
        let place = place.ok_or("its triangles refer to others before the first")?;
        Ok(self.items[place % 16])
    }
}

/// Reads a number of 7 bits per byte, the lowest first.
fn variable(rest: &mut &[u8]) -> Checked<u32> {
    let mut number = 0;
    for shift in [0, 7, 14, 21, 28] {
        let byte = take_byte(rest)?;
        number |= u32::from(byte & 127) << shift;
        if byte < 128 {
            return Ok(number);
        }
    }
    Err("one of its indices has more than 5 bytes".into())
}

fn push_index(decoded: &mut Vec<u8>, index: u32, stride: usize) {
    decoded.extend(index.to_le_bytes().iter().take(stride));
}

/// Decodes mode 1: triangles that share edges and vertices with triangles before.
fn triangles(stream: &[u8], count: usize, stride: usize) -> Checked<Vec<u8>> {
    let [0xe1, rest @ ..] = stream else { return Err("its triangles are of an unknown version".into()) };
    let (mut rest, table) = split_tail(rest, 16)?;
    let codes = take(&mut rest, count)?;
    let mut decoded = Vec::with_capacity(3 * stride * count);
    let mut edges = Recent::<(u32, u32)>::new();
    let mut vertices = Recent::<u32>::new();
    let (mut next, mut last) = (0_u32, 0_u32);
    for code in codes {
        let (high, low) = (code >> 4, code & 15);
        let [a, b, c] = if high < 15 {
            let (a, b) = edges.get(high)?;
            let (c, is_new) = match low {
                0 => (fresh(&mut next), true),
                1..13 => (vertices.get(low)?, false),
                13 => (step(&mut last, u32::MAX), true),
                14 => (step(&mut last, 1), true),
                _ => (near(&mut rest, &mut last)?, true),
            };
            if is_new {
                vertices.add(c);
            }
            [a, b, c]
        } else {
            // Each of the two halves says where its corner comes from: 0 a new vertex, 15 a number in the data, else a
            // vertex before.
            let corners = match low {
                0..14 => table.get(usize::from(low)).copied().ok_or_else(truncated)?,
                _ => take_byte(&mut rest)?,
            };
            if low >= 14 && corners == 0 {
                next = 0;
            }
            let a = if low == 15 { near(&mut rest, &mut last)? } else { fresh(&mut next) };
            let mut corner = |from: u8| match from {
                0 => Ok((fresh(&mut next), true)),
                15 if low >= 14 => Ok((near(&mut rest, &mut last)?, true)),
                15 => Err("its table of triangles is damaged".to_string()),
                _ => Ok((vertices.get(from - 1)?, false)),
            };
            let (b, b_is_new) = corner(corners >> 4)?;
            let (c, c_is_new) = corner(corners & 15)?;
            vertices.add(a);
            for (vertex, _) in [(b, b_is_new), (c, c_is_new)].into_iter().filter(|(_, is_new)| *is_new) {
                vertices.add(vertex);
            }
            edges.add((b, a));
            [a, b, c]
        };
        edges.add((c, b));
        edges.add((a, c));
        [a, b, c].into_iter().for_each(|index| push_index(&mut decoded, index, stride));
    }
    expect_end(rest)?;
    Ok(decoded)
}

/// Returns the number of a vertex that no triangle had before.
fn fresh(next: &mut u32) -> u32 {
    let index = *next;
    *next = next.wrapping_add(1);
    index
}

fn step(last: &mut u32, by: u32) -> u32 {
    *last = last.wrapping_add(by);
    *last
}

/// Reads an index as the difference to the last one that was read so.
fn near(rest: &mut &[u8], last: &mut u32) -> Checked<u32> {
    let delta = variable(rest)?;
    Ok(step(last, (delta >> 1) ^ (delta & 1).wrapping_neg()))
}

/// Decodes mode 2: indices, each as the difference to one of two before.
fn indices(stream: &[u8], count: usize, stride: usize) -> Checked<Vec<u8>> {
    let [0xd1, rest @ ..] = stream else { return Err("its indices are of an unknown version".into()) };
    let (mut rest, _) = split_tail(rest, 4)?;
    let mut decoded = Vec::new();
    let mut lasts = [0_u32; 2];
    for _ in 0..count {
        let packed = variable(&mut rest)?;
        let last = &mut lasts[usize::from(packed & 1 == 1)];
        let sign = (packed >> 1 & 1).wrapping_neg();
        push_index(&mut decoded, step(last, (packed >> 2) ^ sign), stride);
    }
    expect_end(rest)?;
    Ok(decoded)
}

fn apply(filter: Filter, stride: usize, elements: &mut [u8]) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => each_8(elements, |[x, y, one, w]| {
            let [x, y, z] = octahedral([x, y, one].map(|number| f32::from(number as i8)), 127.0);
            [x as i8 as u8, y as i8 as u8, z as i8 as u8, w]
        }),
        (Filter::Octahedral, _) => each_16(elements, |[x, y, one, w]| {
            let [x, y, z] = octahedral([x, y, one].map(|number| f32::from(number as i16)), 32767.0);
            [x as i16 as u16, y as i16 as u16, z as i16 as u16, w]
        }),
        (Filter::Quaternion, _) => each_16(elements, quaternion),
        (Filter::Exponential, _) => each_8(elements, exponential),
        (Filter::Color, 4) => each_8(elements, |[y, orange, green, alpha]| {
            color([y.into(), (orange as i8).into(), (green as i8).into()], alpha.into(), 255.0).map(|share| share as u8)
        }),
        (Filter::Color, _) => each_16(elements, |[y, orange, green, alpha]| {
            let numbers = [y.into(), (orange as i16).into(), (green as i16).into()];
            color(numbers, alpha.into(), 65535.0).map(|share| share as u16)
        }),
    }
}

/// Replaces each four bytes.
fn each_8(elements: &mut [u8], change: impl Fn([u8; 4]) -> [u8; 4]) {
    elements.as_chunks_mut().0.iter_mut().for_each(|element| *element = change(*element));
}

/// Replaces each four 16-bit numbers.
fn each_16(elements: &mut [u8], change: impl Fn([u16; 4]) -> [u16; 4]) {
    for element in elements.as_chunks_mut::<8>().0 {
        let [a, b, c, d, e, f, g, h] = *element;
        let changed = change([[a, b], [c, d], [e, f], [g, h]].map(u16::from_le_bytes));
        let [[a, b], [c, d], [e, f], [g, h]] = changed.map(u16::to_le_bytes);
        *element = [a, b, c, d, e, f, g, h];
    }
}

/// Decodes a unit vector from its place on an octahedron that is unfolded to a square. `largest`: the integer that
/// stands for 1.
fn octahedral([x, y, one]: [f32; 3], largest: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded over the edges.
    let fold = z.min(0.0);
    let (x, y) = (x + if x >= 0.0 { fold } else { -fold }, y + if y >= 0.0 { fold } else { -fold });
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|number| (number / length * largest).round())
}

/// Decodes a unit quaternion from its three smaller components. The last number's lowest bits say which one is left
/// out.
fn quaternion([x, y, z, one]: [u16; 4]) -> [u16; 4] {
    let greatest = usize::from(one & 3);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from((one | 3) as i16);
    let [x, y, z] = [x, y, z].map(|number| f32::from(number as i16) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut turned = [w, x, y, z].map(|number| (number * 32767.0).round() as i16 as u16);
    turned.rotate_right(greatest);
    turned
}

/// Decodes a float from 24 bits of a whole number and 8 of an exponent of 2.
fn exponential(bytes: [u8; 4]) -> [u8; 4] {
    let packed = i32::from_le_bytes(bytes);
    let whole = packed << 8 >> 8;
    // Exact in f64, where no power of 2 with 8 bits is too small.
    ((2_f64.powi(packed >> 24) * f64::from(whole)) as f32).to_le_bytes()
}

/// Decodes a color from its brightness, an orange and a green share. The highest bit of `alpha` says how many bits all
/// have.
fn color([brightness, orange, green]: [i32; 3], alpha: u32, largest: f32) -> [f32; 4] {
    let all = 1_u32.checked_shl(32 - alpha.leading_zeros()).map_or(0, |above| above - 1);
    let alpha = alpha & all >> 1;
    let alpha = (alpha << 1 | alpha & 1) as i32;
    let numbers = [brightness + orange - green, brightness + green, brightness - orange - green, alpha];
    numbers.map(|number| (number as f32 * (largest / all as f32)).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A generator of numbers that are the same in each run.
    struct Numbers(u64);

    impl Numbers {
        fn below(&mut self, most: usize) -> usize {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 33) as usize % most
        }
    }

    /// Bytes with nothing of a stream but its first one.
    #[test]
    fn noise_does_not_panic() {
        let mut numbers = Numbers(2);
        for round in 0..5000 {
            let mut stream: Vec<u8> = (0..numbers.below(400)).map(|_| numbers.below(256) as u8).collect();
            let (mode, first) =
                [(Mode::Attributes, 0xa0 + (round & 1) as u8), (Mode::Triangles, 0xe1), (Mode::Indices, 0xd1)]
                    [numbers.below(3)];
            if let Some(byte) = stream.first_mut() {
                *byte = first;
            }
            let filter = [Filter::None, Filter::Octahedral, Filter::Quaternion, Filter::Exponential, Filter::Color]
                [numbers.below(5)];
            let stride = [2, 4, 8, 12, 256, 0][numbers.below(6)];
            let _ = decode(&stream, mode, filter, numbers.below(1000), stride);
        }
    }

    /// A short stream of nothing but zeros promises many elements: version 1 has a quarter of a byte for each 256 bytes.
    #[test]
    fn memory_grows_only_with_the_stream() {
        let mut stream = vec![0xa1];
        stream.extend([0xaa; 1000]);
        stream.extend([0; 24]);
        let decoded = decode(&stream, Mode::Attributes, Filter::None, 256 * 1000, 4).unwrap();
        assert_eq!(decoded, vec![0; 1_024_000]);
        let cause = decode(&stream, Mode::Attributes, Filter::None, usize::MAX / 4, 4).unwrap_err();
        assert_eq!(cause, "its compressed data end too early");
    }
}
