//! Levels of detail of maps, for pixels wider than a texel: each texel combines four texels of the next finer level.
//! glsl/maps/level_place.glsl defines where the levels are stored, glsl/maps/level_tile.glsl how they are built.

use super::{Maps, TILE_TEXELS};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Kernel, Shader, push_struct};

push_struct! {
    /// The first level to build. Twin: LevelPush in glsl/maps/level_tile.glsl.
    struct LevelPush { level: u32 }
}

/// Number of levels that a workgroup builds from a tile, each from the previous level. Twin: LEVELS_A_PASS in
/// glsl/maps/level_tile.glsl.
const LEVELS_A_PASS: usize = 3;

/// Returns the texels per side of a level of a map. Twin: level_size.
pub fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|texels| texels.div_ceil(1 << level))
}

/// Returns the number of texels in a level, over all maps.
pub fn level_texels(maps: &Maps, level: u32) -> u64 {
    let [x, y] = level_size(maps.size(), level).map(u64::from);
    x * y * u64::from(maps.count())
}

/// Returns the number of texels in all levels of a square map; `levels` includes the map itself.
pub fn leveled_texels(size: u32, levels: u32) -> u64 {
    (0..levels.max(1)).map(|level| u64::from(level_size([size; 2], level)[0]).pow(2)).sum()
}

/// Returns the number of texels, over all maps, in the levels coarser than the map itself; `levels` includes the map.
pub fn coarser_texels(maps: &Maps, levels: u32) -> u64 {
    (1..levels).map(|level| level_texels(maps, level)).sum()
}

/// Returns the number of texels, over all maps, in the levels that one pass ends with and the next reads; `levels`
/// includes the map.
pub fn carried_texels(maps: &Maps, levels: u32) -> u64 {
    (1..levels).step_by(LEVELS_A_PASS).skip(1).map(|level| level_texels(maps, level - 1)).sum()
}

/// The passes that build the levels, up to three levels each.
pub struct Levels {
    label: &'static str,
    kernel: Kernel<LevelPush>,
    /// First level and workgroups of each pass.
    passes: Vec<(u32, [u32; 3])>,
}

impl Levels {
    /// Creates the passes for `count` levels, the first of which is the map itself. Returns `None` if `count` is 1,
    /// since there is nothing to build. `shader` includes glsl/maps/level_tile.glsl; `constants` must also hold the
    /// number of levels.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver rejects the shader.
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
        let pass = |level: u32| {
            let [x, y] = level_size(maps.size(), level - 1).map(|texels| texels.div_ceil(TILE_TEXELS));
            (level, [x, y, maps.count()])
        };
        let kernel = Kernel::compute(context, shader, sets, constants)?;
        Ok(Some(Self { label, kernel, passes: (1..count).step_by(LEVELS_A_PASS).map(pass).collect() }))
    }

    /// Builds all coarser levels from the map.
    pub fn record(&self, commands: &mut Commands) {
        for (level, groups) in &self.passes {
            commands.pass(self.label, |pass| pass.dispatch(&self.kernel, &LevelPush { level: *level }, *groups));
        }
    }
}
