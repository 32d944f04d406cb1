//! Finds the casters in tiles that light reaches. Other casters are neither binned nor drawn.

use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Kernel, Memory, Pass};
use crate::maps::bins::BinPush;
use crate::maps::{Maps, detail};
use crate::world::World;

/// Buffers for culling.
pub(in crate::maps) struct Cull {
    /// One word per caster and map, map after map: the mark ([`Cull::mark`]) of the last build in which the caster met
    /// a tile of the map.
    pub(in crate::maps) met: Buffer,
    /// For each tile, the z in the map's volume view beyond which no light gets: map after map, rows of tiles.
    pub(in crate::maps) horizon: Buffer,
    /// Whether casters beyond the horizon are skipped.
    pub(in crate::maps) hides: bool,
    /// The mark of casters that are in some tile, different in each build. Older marks are cleared before it returns to 1.
    pub(in crate::maps) mark: u32,
}

impl Cull {
    pub(in crate::maps) fn new(context: &Context, world: &World, maps: &Maps, skip: bool) -> Result<Self> {
        let marks = u64::from(maps.count()) * u64::from(world.caster_capacity()).max(1);
        Ok(Self {
            met: Buffer::new(context, "bins.met", marks * 4, Memory::Device)?,
            horizon: Buffer::new(context, "bins.horizon", detail::tile_count(maps) * 4, Memory::Device)?,
            hides: skip && world.triangle_count() > 0,
            mark: 0,
        })
    }

    /// Chooses the mark of the next build. If no entries are kept, it is always 1, as the passes that read marks expect.
    pub(in crate::maps) fn begin(&mut self, keeps_entries: bool) {
        self.mark = if keeps_entries { self.mark.checked_add(1).unwrap_or(1) } else { 1 };
    }

    /// Clears the marks if an older mark could be mistaken for this build's.
    pub(in crate::maps) fn clear(&self, pass: &mut Pass) {
        if self.mark == 1 {
            pass.fill(&self.met, 0);
        }
    }

    /// Finds how far light gets in each tile. Records no pass if casters beyond the horizon are not skipped.
    pub(in crate::maps) fn horizon(
        &self,
        commands: &mut Commands,
        kernel: &Kernel<BinPush>,
        push: &BinPush,
        tiles: [u32; 2],
    ) {
        if self.hides {
            let [x, y] = tiles;
            commands.pass("bins.horizon", |pass| pass.dispatch(kernel, push, [x, y, push.map_count]));
        }
    }

    /// Returns how many casters of all maps are in some tile.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the marks cannot be read back.
    pub(in crate::maps) fn met_count(&self, casters: u64) -> Result<u64> {
        Ok(self.met.read::<u32>(casters as usize)?.into_iter().filter(|mark| *mark == self.mark).count() as u64)
    }

    pub(in crate::maps) fn bytes(&self) -> u64 {
        self.met.bytes() + self.horizon.bytes()
    }
}
