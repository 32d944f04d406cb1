//! Results that the host reads after a frame: one copy per frame in flight, so that nothing waits.

use crate::Result;
use crate::gpu::{Buffer, Context, Memory};
use bytemuck::Pod;
use std::sync::{Arc, Mutex, PoisonError};

/// Copies of a result, as many as frames may run at the same time. Clones share them.
#[derive(Clone)]
pub struct ReadBack(Arc<Inner>);

struct Inner {
    copies: Vec<Buffer>,
    /// Per copy, the frame that writes it.
    frames: Mutex<Vec<Option<u64>>>,
}

impl ReadBack {
    /// Room for `bytes` of each frame.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn new(context: &Context, name: &str, bytes: u64) -> Result<Self> {
        let count = context.frames_in_flight().max(1) as usize;
        let copy = |_| Buffer::new(context, name, bytes, Memory::Readback);
        let copies = (0..count).map(copy).collect::<Result<Vec<_>>>()?;
        Ok(Self(Arc::new(Inner { copies, frames: Mutex::new(vec![None; count]) })))
    }

    /// The first `count` elements that were copied in frame `frame`, which must be over. None where that frame copied
    /// nothing, or where a later recorded frame uses the same memory for its copy.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where there are fewer elements.
    pub fn read<T: Pod>(&self, frame: u64, count: usize) -> Result<Option<Vec<T>>> {
        let place = self.place(frame);
        if self.0.frames.lock().unwrap_or_else(PoisonError::into_inner)[place] != Some(frame) {
            return Ok(None);
        }
        self.0.copies[place].read(count).map(Some)
    }

    /// Makes [`ReadBack::read`] ignore all copies recorded so far, which are older than the last change.
    pub fn forget(&self) {
        self.0.frames.lock().unwrap_or_else(PoisonError::into_inner).fill(None);
    }

    /// Bytes of all copies.
    pub fn bytes(&self) -> u64 {
        self.0.copies.iter().map(Buffer::bytes).sum()
    }

    /// Whether both are clones of one.
    pub(in crate::gpu) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The copy that `frame` writes.
    pub(in crate::gpu) fn begin(&self, frame: u64) -> Buffer {
        let place = self.place(frame);
        self.0.frames.lock().unwrap_or_else(PoisonError::into_inner)[place] = Some(frame);
        self.0.copies[place].clone()
    }

    fn place(&self, frame: u64) -> usize {
        (frame % self.0.copies.len() as u64) as usize
    }
}
