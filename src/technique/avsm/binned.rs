//! path=binned: a workgroup builds a tile's curves from its casters, by sums in even cells of depth or by insertion of
//! sorted segments in registers. No lists, no blending, no interlock. Source: ours.

use super::Site;
use crate::Result;
use crate::gpu::{Commands, Kernel};
use crate::maps::Bins;
use crate::shaders::avsm;

/// What the path builds with.
pub struct Binned {
    kernel: Kernel,
    /// glsl/avsm/cells.comp, not binned.comp.
    cells: bool,
}

impl Binned {
    pub fn new(site: &Site, bins: &Bins) -> Result<Self> {
        let Site { context, maps, curves, plan, .. } = *site;
        let shader = match (plan.cells, plan.lanes) {
            (true, true) => &avsm::CELLS_LANES_1,
            (true, false) => &avsm::CELLS_LANES_0,
            (false, _) => &avsm::BINNED,
        };
        let sets = [maps.scene(), bins.set(), &curves.set];
        Ok(Self { kernel: Kernel::compute(context, shader, &sets, &plan.constants)?, cells: plan.cells })
    }

    pub fn record(&self, commands: &mut Commands, bins: &Bins) {
        let label = if self.cells { "avsm.cells" } else { "avsm.binned" };
        commands.pass(label, |pass| bins.per_part(pass, &self.kernel, &()));
    }
}
