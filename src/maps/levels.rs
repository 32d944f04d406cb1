//! Levels of detail of maps, for pixels wider than a texel: each texel combines the four texels of the finer level.
//! glsl/maps/level_place.glsl says where the levels lie, glsl/maps/level_tile.glsl how they are made.

use super::{Maps, TILE_TEXELS};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context, Kernel, Shader, push_struct};

push_struct! {
    /// The first level that is made. Twin: LevelPush in glsl/maps/level_tile.glsl.
    struct LevelPush { level: u32 }
}

/// Levels that a workgroup makes of a tile, each from the level before. Twin: LEVELS_A_PASS in
/// glsl/maps/level_tile.glsl.
const LEVELS_A_PASS: usize = 3;

/// Texels per side of a level of a map. Twin: level_size.
pub fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|texels| texels.div_ceil(1 << level))
}

/// Texels that all maps have in a level.
pub fn level_texels(maps: &Maps, level: u32) -> u64 {
    let [x, y] = level_size(maps.size(), level).map(u64::from);
    x * y * u64::from(maps.count())
}

/// Texels of a square map in all of its levels together; `levels` counts the map itself too.
pub fn leveled_texels(size: u32, levels: u32) -> u64 {
    (0..levels.max(1)).map(|level| u64::from(level_size([size; 2], level)[0]).pow(2)).sum()
}

/// Texels of all maps in the levels coarser than the map itself; `levels` counts the map too.
pub fn coarser_texels(maps: &Maps, levels: u32) -> u64 {
    (1..levels).map(|level| level_texels(maps, level)).sum()
}

/// Texels of all maps in the levels from which a pass goes on where another has ended; `levels` counts the map too.
pub fn carried_texels(maps: &Maps, levels: u32) -> u64 {
    (1..levels).step_by(LEVELS_A_PASS).skip(1).map(|level| level_texels(maps, level - 1)).sum()
}

/// The passes that make levels, up to three levels each.
pub struct Levels {
    label: &'static str,
    kernel: Kernel<LevelPush>,
    /// The first level of each pass, and the pass's workgroups.
    passes: Vec<(u32, [u32; 3])>,
}

impl Levels {
    /// Makes `count` levels, of which the map itself is the first. Returns `None` where `count` is 1, since nothing is
    /// left to make. `shader` includes glsl/maps/level_tile.glsl; `constants` must hold the number of levels too.
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
        let pass = |level: u32| {
            let [x, y] = level_size(maps.size(), level - 1).map(|texels| texels.div_ceil(TILE_TEXELS));
            (level, [x, y, maps.count()])
        };
        let kernel = Kernel::compute(context, shader, sets, constants)?;
        Ok(Some(Self { label, kernel, passes: (1..count).step_by(LEVELS_A_PASS).map(pass).collect() }))
    }

    /// Makes all coarser levels from the map.
    pub fn record(&self, commands: &mut Commands) {
        for (level, groups) in &self.passes {
            commands.pass(self.label, |pass| pass.dispatch(&self.kernel, &LevelPush { level: *level }, *groups));
        }
    }
}
