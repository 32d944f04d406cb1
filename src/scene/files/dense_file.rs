//! Samples of a dense grid, stored consecutively: x fastest, then y, then z.

use crate::scene::Field;
use std::cell::RefCell;
use std::io::Read;

/// The largest number of samples in a grid: 1024³.
const MOST_SAMPLES: u64 = 1 << 30;

/// Number of samples read at once.
const CHUNK: u64 = 1 << 14;

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Kind {
    /// Unsigned byte; 255 is density 1.
    U8,
    /// Unsigned 16-bit integer; 65535 is density 1.
    U16,
    /// Float; the density itself.
    F32,
}

impl Kind {
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
        }
    }

    fn density(self, bytes: &[u8], big_endian: bool) -> f32 {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        if big_endian {
            word[..bytes.len()].reverse();
        }
        match self {
            Self::U8 => f32::from(word[0]) / 255.0,
            Self::U16 => f32::from(u16::from_le_bytes([word[0], word[1]])) / 65535.0,
            Self::F32 => f32::from_le_bytes(word),
        }
    }
}

/// A grid's size and sample format.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Dense {
    pub size: [u32; 3],
    pub kind: Kind,
    pub big_endian: bool,
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
            let densities: Vec<_> = part.chunks_exact(bytes).map(|s| self.kind.density(s, self.big_endian)).collect();
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
