//! Results that the host reads after a frame: one copy per frame in flight, so that nothing waits.

use crate::Result;
use crate::gpu::{Buffer, Context, Memory};
use bytemuck::Pod;
use std::sync::{Arc, Mutex, PoisonError};

/// Copies of a result, one per frame in flight. Clones share them.
#[derive(Clone)]
pub struct ReadBack(Arc<Inner>);

struct Inner {
    copies: Vec<Buffer>,
    /// For each copy, the frame that writes it.
    frames: Mutex<Vec<Option<u64>>>,
}

impl ReadBack {
    /// Allocates `bytes` bytes per frame in flight.
    ///
    /// # Errors
    /// Same as [`Buffer::new`].
    pub fn new(context: &Context, name: &str, bytes: u64) -> Result<Self> {
        let count = context.frames_in_flight().max(1) as usize;
        let copy = |_| Buffer::new(context, name, bytes, Memory::Readback);
        let copies = (0..count).map(copy).collect::<Result<Vec<_>>>()?;
        Ok(Self(Arc::new(Inner { copies, frames: Mutex::new(vec![None; count]) })))
    }

    /// Reads the first `count` elements that were copied in frame `frame`, which must have finished. `None` if that
    /// frame copied nothing, or if a later recorded frame reuses the memory for its copy.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if there are fewer elements.
    pub fn read<T: Pod>(&self, frame: u64, count: usize) -> Result<Option<Vec<T>>> {
        let place = self.place(frame);
        if self.0.frames.lock().unwrap_or_else(PoisonError::into_inner)[place] != Some(frame) {
            return Ok(None);
        }
        self.0.copies[place].read(count).map(Some)
    }

    /// Makes [`ReadBack::read`] ignore all copies recorded so far, because they predate the last change.
    pub fn forget(&self) {
        self.0.frames.lock().unwrap_or_else(PoisonError::into_inner).fill(None);
    }

    /// Returns the size of all copies, in bytes.
    pub fn bytes(&self) -> u64 {
        self.0.copies.iter().map(Buffer::bytes).sum()
    }

    /// Returns whether both are clones of the same object.
    pub(in crate::gpu) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Returns the copy for `frame` to write.
    pub(in crate::gpu) fn begin(&self, frame: u64) -> Buffer {
        let place = self.place(frame);
        self.0.frames.lock().unwrap_or_else(PoisonError::into_inner)[place] = Some(frame);
        self.0.copies[place].clone()
    }

    fn place(&self, frame: u64) -> usize {
        (frame % self.0.copies.len() as u64) as usize
    }
}
