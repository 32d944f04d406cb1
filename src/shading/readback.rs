//! Buffers that passes wrote, read back for tests that compare them with the twins.

use super::interleaved::PartReadback;
use super::kernels::{Casters, Kernels, Meshes};
use super::many_lights::TileReadback;
use super::painter::ListReadback;
use super::{Renderer, lock};
use crate::Result;

impl Renderer {
    /// Reads the buffers of `shading=tiled` after the last frame; `None` if no tiled kernels were created.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn read_tiles(&self) -> Result<Option<TileReadback>> {
        self.shared.tiles.borrow().as_ref().map(|tiles| tiles.seen()).transpose()
    }

    /// Returns the size of the buffers of `shading=tiled`, in bytes; `None` if no tiled kernels were created.
    pub fn tiles_bytes(&self) -> Option<u64> {
        self.shared.tiles.borrow().as_ref().map(|tiles| tiles.bytes())
    }

    /// Reads the lists of casters of the last frame that compute passes painted, and the order of all casters; `None` if no such kernels
    /// were created.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn read_lists(&self) -> Result<Option<(ListReadback, Vec<u32>)>> {
        let casters = self.blending.casters;
        let Some(lists) = self.shared.lists.get() else { return Ok(None) };
        let seen = lock(lists).seen(casters)?;
        Ok(Some((seen, self.blending.order.read(casters as usize)?)))
    }

    /// Returns the bytes of the lists of casters that compute passes paint, with the layers of their parts and the light at vertices;
    /// `None` if `kernels` draw casters instead.
    pub fn lists_bytes(&self, kernels: &Kernels) -> Option<u64> {
        match &kernels.casters {
            Casters::Painted(painter) => painter.bytes(),
            Casters::PaintedSlices(slices) => Some(slices.bytes()),
            _ => None,
        }
    }

    /// Returns the bytes of the buffers between G-buffer and picture with `shading=interleaved` or `shading=reservoir`; otherwise `None`.
    pub fn estimates_bytes(&self, kernels: &Kernels) -> Option<u64> {
        match &kernels.meshes {
            Meshes::Interleaved { interleaved, .. } => Some(interleaved.gather.estimates.bytes()),
            Meshes::Reservoir { reservoirs, .. } => Some(reservoirs.bytes()),
            _ => None,
        }
    }

    /// Reads per-pixel values of the last frame that `kernels` drew with `shading=interleaved` or `shading=reservoir`; otherwise `None`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read back.
    pub fn read_parts(&self, kernels: &Kernels) -> Result<Option<PartReadback>> {
        let (gbuffer, estimates, reservoirs) = match &kernels.meshes {
            Meshes::Interleaved { gbuffer, interleaved } => (gbuffer, &interleaved.gather.estimates, Vec::new()),
            Meshes::Reservoir { gbuffer, reservoirs } => (gbuffer, &reservoirs.gather.estimates, reservoirs.kept()?),
            _ => return Ok(None),
        };
        Ok(Some(PartReadback {
            reservoirs,
            numbers: gbuffer.numbers()?,
            estimates: estimates.read(estimates.bytes() as usize / 12)?,
            albedo: self.targets.albedo.read()?,
            normal: self.targets.normal.read()?,
            z: self.targets.distance.read()?,
        }))
    }
}
