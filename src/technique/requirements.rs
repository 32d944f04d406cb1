//! What the paths of a technique require of a device, known before a device is opened.

use super::{PathPlan, Spec};
use crate::gpu::{Enabled, Limit};
use std::ffi::CStr;

/// What a path requires of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathRequirements {
    /// Name of the path in specs.
    pub path: &'static str,
    /// Sets of features to open the device with, each including `Enabled::FLOOR`; any one set is enough. [`Enabled::structures`] passes
    /// them to Vulkan.
    pub any_of: Vec<Enabled>,
    /// Limits that the device must meet.
    pub limits: Vec<Limit>,
}

impl PathRequirements {
    fn of(plan: PathPlan) -> Self {
        let mut any_of = vec![Enabled::FLOOR];
        for requirement in plan.path.requires {
            let each = requirement.any_of();
            any_of = any_of.iter().flat_map(|one| each.iter().map(|other| one.or(*other))).collect();
        }
        let limits = Limit::FLOOR.into_iter().chain(plan.limits).collect();
        Self { path: plan.path.name, any_of, limits }
    }

    /// Returns the device extensions of each set in `any_of`.
    pub fn extensions(&self) -> Vec<Vec<&'static CStr>> {
        self.any_of.iter().map(Enabled::extensions).collect()
    }
}

/// Returns what the path named by `spec` requires of a device, or what each of the technique's paths requires if `spec` names none. The
/// limits suffice for a world with one light and smoke. A world with more lights needs higher limits, and one with strands or meshes may;
/// opening the technique checks those. Lists grow with the casters on each ray, so the limits that they need are known only while they are
/// built.
pub fn requirements(spec: &Spec) -> Vec<PathRequirements> {
    spec.plans().into_iter().map(PathRequirements::of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::{REGISTRY, parse};

    fn of(text: &str) -> Vec<PathRequirements> {
        requirements(&parse(text, &[]).expect(text)[0])
    }

    #[test]
    fn a_named_path_is_alone() {
        let interlock = of("avsm:path=interlock");
        let wants =
            Enabled { fragment_stores_and_atomics: true, fragment_shader_pixel_interlock: true, ..Enabled::FLOOR };
        assert_eq!((interlock.len(), interlock[0].path, &interlock[0].any_of[..]), (1, "interlock", &[wants][..]));
        assert_eq!(interlock[0].extensions(), [[ash::ext::fragment_shader_interlock::NAME]]);
        assert_eq!(interlock[0].limits[0].name, "maxPerStageDescriptorStorageBuffers");
        assert_eq!(of("avsm").len(), 4);
        // Shared memory of a workgroup that holds one map of ISM: 64² texels of four bytes and all coarser levels down to 4².
        let bytes = 4 * (64 * 64 + 32 * 32 + 16 * 16 + 8 * 8 + 4 * 4);
        let room = Limit { name: "maxComputeSharedMemorySize", least: bytes };
        assert_eq!(of("ism:path=tiled")[0].limits[1..], [room]);
        assert_eq!(of("ism:path=atomic")[0].limits, Limit::FLOOR);
        // 16 nodes take eight attachments.
        let drawn = &of("avsm:path=raster-order,nodes=16")[0].limits;
        assert!(drawn.contains(&Limit { name: "maxColorAttachments", least: 8 }), "{drawn:?}");
        assert_eq!(of("shadow-map:opaque=compute").iter().map(|path| path.path).collect::<Vec<_>>(), ["compute"]);
        assert_eq!(of("beer-shadow-map:opaque=raster").len(), 2, "how opaque maps are drawn is no path of it");
    }

    /// Asserts that path=raster of PSM can be met by either of two sets of features: layers chosen in vertex shaders or in geometry
    /// shaders. Also asserts that ray-query needs three extensions, and that every set of every technique includes scalar block layout and
    /// synchronization2.
    #[test]
    fn either_will_do() {
        let raster = &of("psm:path=raster")[0];
        let vertex = Enabled { vertex_layer_output: true, ..Enabled::FLOOR };
        let geometry = Enabled { geometry_shader: true, multi_viewport: true, ..Enabled::FLOOR };
        assert_eq!(raster.any_of, [vertex, geometry]);
        assert_eq!(of("ray-query")[0].extensions()[0].len(), 3);
        let all = REGISTRY.iter().flat_map(|entry| of(entry.name));
        assert!(all.flat_map(|path| path.any_of).all(|one| one.scalar_block_layout && one.synchronization2));
    }
}
