//! Samples of a dense grid, stored consecutively: x fastest, then y, then z.

use crate::scene::Field;
use std::cell::RefCell;
use std::io::Read;

/// The largest number of samples in a grid: 1024³.
const MOST_SAMPLES: u64 = 1 << 30;

/// Number of samples read at once.
const CHUNK: u64 = 1 << 14;

/// The type of a sample. The largest unsigned integer is density 1, and a float is the density itself. Signed integers need a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl Kind {
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Returns whether densities need a window.
    pub fn is_signed(self) -> bool {
        matches!(self, Self::I8 | Self::I16 | Self::I32)
    }

    /// Returns the number that is density 1.
    fn most(self) -> f64 {
        match self {
            Self::U8 => u8::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::U32 => u32::MAX.into(),
            _ => 1.0,
        }
    }

    fn number(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        if big_endian {
            word[..bytes.len()].reverse();
        }
        let [a, b, c, d, ..] = word;
        match self {
            Self::U8 => a.into(),
            Self::I8 => i8::from_le_bytes([a]).into(),
            Self::U16 => u16::from_le_bytes([a, b]).into(),
            Self::I16 => i16::from_le_bytes([a, b]).into(),
            Self::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Self::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Self::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Self::F64 => f64::from_le_bytes(word),
        }
    }
}

/// A grid's size and sample format.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Dense {
    pub size: [u32; 3],
    pub kind: Kind,
    pub big_endian: bool,
    /// The numbers that are densities 0 and 1, if not those of the type; beyond them densities are 0 and 1 too.
    pub window: Option<[f64; 2]>,
}

impl Dense {
    /// Returns the number of bytes of all samples. The error describes what is wrong with the size.
    pub fn bytes(&self) -> Result<u64, String> {
        let count = self.size.iter().try_fold(1u64, |product, side| product.checked_mul(u64::from(*side)));
        match count {
            Some(0) => Err(format!("a grid of {:?} has no samples", self.size)),
            Some(count) if count <= MOST_SAMPLES => Ok(count * self.kind.bytes() as u64),
            _ => Err(format!("a grid of {:?} has more than {MOST_SAMPLES} samples", self.size)),
        }
    }

    fn density(&self, sample: &[u8]) -> f32 {
        let number = self.kind.number(sample, self.big_endian);
        let density = match self.window {
            None => number / self.kind.most(),
            Some([low, high]) => ((number - low) / (high - low)).clamp(0.0, 1.0),
        };
        density as f32
    }

    /// Reads all samples from a stream. The error describes what is wrong.
    pub fn read(&self, mut stream: impl Read) -> Result<Field, String> {
        let (bytes, [wide, high, _]) = (self.kind.bytes(), self.size.map(u64::from));
        let total = self.bytes()? / bytes as u64;
        let failed = RefCell::new(None);
        let mut buffer = vec![0; CHUNK as usize * bytes];
        let chunk = |first: u64| {
            let count = (total - first).min(CHUNK);
            let part = &mut buffer[..count as usize * bytes];
            if let Err(cause) = stream.read_exact(part) {
                *failed.borrow_mut() = Some(cause);
                return None;
            }
            let densities: Vec<_> = part.chunks_exact(bytes).map(|sample| self.density(sample)).collect();
            // Samples of 0 are not stored.
            let place = |i: u64| [i % wide, i / wide % high, i / wide / high].map(|at| at as i32);
            let dense = (first..).zip(densities).filter(|(_, density)| *density != 0.0);
            Some(dense.map(move |(i, density)| (place(i), density)))
        };
        let field = Field::new((0..total).step_by(CHUNK as usize).map_while(chunk).flatten())?;
        match failed.into_inner() {
            Some(cause) => Err(format!("truncated, or damaged: {cause}")),
            None => Ok(field),
        }
    }
}
