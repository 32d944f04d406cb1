//! path=binned: one workgroup builds the curves of a tile from its casters, either by summing them in even cells of depth or by inserting
//! sorted segments in registers. No lists, no blending, no interlock. Source: ours.

use super::Site;
use super::plan::Cells;
use crate::Result;
use crate::gpu::{Commands, Kernel};
use crate::maps::Bins;
use crate::shaders::avsm;

/// The build state of this path.
pub struct Binned {
    kernel: Kernel,
    /// Whether the kernel is glsl/technique/avsm/cells.comp, not binned.comp.
    cells: bool,
}

impl Binned {
    pub fn new(site: &Site, bins: &Bins) -> Result<Self> {
        let Site { context, maps, curves, plan, .. } = *site;
        let sets = [maps.scene(), bins.set(), &curves.set];
        let kernel = match plan.cells {
            Some(Cells::Whole) => Kernel::compute(context, &avsm::CELLS_LANES_0, &sets, &plan.constants),
            Some(Cells::Lanes) => Kernel::full_subgroups(context, &avsm::CELLS_LANES_1, &sets, &plan.constants),
            Some(Cells::Half) => Kernel::compute(context, &avsm::CELLS_LANES_2, &sets, &plan.constants),
            None if plan.lanes => Kernel::full_subgroups(context, &avsm::BINNED_LANES_1, &sets, &plan.constants),
            None => Kernel::compute(context, &avsm::BINNED_LANES_0, &sets, &plan.constants),
        };
        Ok(Self { kernel: kernel?, cells: plan.cells.is_some() })
    }

    pub fn record(&self, commands: &mut Commands, bins: &Bins) {
        let label = if self.cells { "avsm.cells" } else { "avsm.binned" };
        commands.pass(label, |pass| bins.per_part(pass, &self.kernel, &()));
    }
}
