//! Levels of detail of maps, for what is wider than a texel: each texel is made of the four below it. Where they stand:
//! glsl/maps/level_place.glsl.

use super::{Maps, TILE_TEXELS};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Kernel, Shader, push_struct};

push_struct! {
    /// Twin: LevelPush in glsl/maps/curve/levels.comp and glsl/technique/layers/levels.comp.
    struct LevelPush { level: u32 }
}

/// Texels a side of a level of a map. Twin: level_size.
pub fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|texels| texels.div_ceil(1 << level))
}

/// Texels of a level of all maps.
pub fn level_texels(maps: &Maps, level: u32) -> u64 {
    let [x, y] = level_size(maps.size(), level).map(u64::from);
    x * y * u64::from(maps.count())
}

/// The pass that makes them, one level after the other.
pub struct Levels {
    label: &'static str,
    kernel: Kernel<LevelPush>,
    /// Workgroups of each.
    groups: Vec<[u32; 3]>,
}

impl Levels {
    /// Makes so many, the map itself among them; none where it is alone. `shader` makes a texel a thread, 8 × 8 a workgroup, the map in z.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader.
    pub fn new(
        context: &Context,
        label: &'static str,
        maps: &Maps,
        count: u32,
        shader: &Shader,
        sets: &[&Bindings],
        constants: &Constants,
    ) -> Result<Option<Self>> {
        if count == 1 {
            return Ok(None);
        }
        let group = |level| {
            let [x, y] = level_size(maps.size(), level).map(|texels| texels.div_ceil(TILE_TEXELS));
            [x, y, maps.count()]
        };
        let kernel = Kernel::compute(context, shader, sets, constants)?;
        Ok(Some(Self { label, kernel, groups: (1..count).map(group).collect() }))
    }

    /// Makes all of them of the map.
    pub fn record(&self, commands: &mut Commands) {
        for (level, groups) in (1..).zip(&self.groups) {
            commands.pass(self.label, |pass| pass.dispatch(&self.kernel, &LevelPush { level }, *groups));
        }
    }
}
