//! One representation for particles, strands, splats, see-through triangles and volume cells, shared by the shaders and the reference.

use super::sheet::sheets;
use crate::scene::{MAX_OPTICAL_DEPTH, Particle, Scene, Strand, Volume};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
#[cfg(feature = "program")]
use std::cmp::Ordering;

/// A translucent caster. Numbers are rounded to f32 once, here, so that the f64 reference and the device use the same values. Twin: Caster
/// in glsl/world/caster.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// Centre of a sphere, splat or cell, or of a sphere around a sheet; or start of a strand. In world units.
    pub position: [f32; 3],
    /// Radius in world units, > 0; for a splat, 3 times the largest standard deviation; for a cell, half its diagonal; for a sheet, of a
    /// sphere around it.
    pub radius: f32,
    /// Vector from a strand's start to its end, in world units; 0 for a sphere; for a splat or a cell, bits that encode its shape; for a
    /// sheet, bits of its triangle's number.
    pub axis: [f32; 3],
    /// Extinction of a sphere or cell, or of a splat at its centre, in 1 / world unit; optical depth of a strand; the greatest optical depth
    /// of a sheet.
    pub density: f32,
}

impl Caster {
    /// Compares by values alone: position, radius, axis, density.
    #[cfg(feature = "program")]
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        let values = |c: &Self| (c.position, c.radius, c.axis, c.density);
        values(self).partial_cmp(&values(other)).unwrap_or(Ordering::Equal)
    }

    /// Returns whether the caster is a strand.
    pub fn is_strand(&self) -> bool {
        self.axis != [0.0; 3] && !self.is_splat_or_cell() && !self.is_sheet()
    }

    /// Returns whether the shape is packed into the axis, as for a splat or a cell.
    pub fn is_splat_or_cell(&self) -> bool {
        self.is_splat() || self.is_cell()
    }

    /// Returns the centre, or a strand's start.
    pub fn start(&self) -> DVec3 {
        DVec3::from(self.position.map(f64::from))
    }

    /// Returns the centre, or a strand's end. The caster lies within the convex hull of two spheres of its radius, at [`Caster::start`] and
    /// at this point.
    pub fn end(&self) -> DVec3 {
        if self.is_strand() { self.start() + DVec3::from(self.axis.map(f64::from)) } else { self.start() }
    }
}

impl From<&Particle> for Caster {
    fn from(particle: &Particle) -> Self {
        let Particle { position, radius, extinction } = *particle;
        Self { position, radius, axis: [0.0; 3], density: extinction }
    }
}

impl From<&Strand> for Caster {
    fn from(strand: &Strand) -> Self {
        let [start, end] = [strand.start, strand.end];
        Self {
            position: start,
            radius: strand.radius,
            axis: [0, 1, 2].map(|i| end[i] - start[i]),
            // ln_1p, because computing 1 − opacity would round a thin strand's opacity away.
            density: (-(-f64::from(strand.opacity)).ln_1p()).min(MAX_OPTICAL_DEPTH.into()) as f32,
        }
    }
}

impl Scene {
    /// Returns the particles, then the strands, the splats, the sheets, which are see-through triangles, and last the volumes' cells. All caster indices follow this order.
    pub fn casters(&self) -> Vec<Caster> {
        let strands = self.strands.iter().map(Caster::from);
        let cells = self.volumes.iter().flat_map(Volume::cells).copied();
        let splats = self.splats.iter().map(Caster::from);
        self.particles
            .iter()
            .map(Caster::from)
            .chain(strands)
            .chain(splats)
            .chain(sheets(&self.meshes))
            .chain(cells)
            .collect()
    }

    /// Returns the number of cells of all volumes; they are the last of all casters.
    pub fn cell_count(&self) -> usize {
        self.volumes.iter().map(|volume| volume.cells().len()).sum()
    }

    /// Returns whether the scene has no translucent casters.
    pub fn has_only_meshes(&self) -> bool {
        self.first_cell() == 0 && self.volumes.is_empty()
    }
}
