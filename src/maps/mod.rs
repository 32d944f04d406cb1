//! Code shared by techniques that build maps in a light's view: the maps of all lights, the depth maps of meshes, bins
//! of casters, casters drawn as quads, per-texel lists, filters.
//!
//! A light has one map. A point light instead has six, the faces of a cube, and a directional light may have one map
//! per cascade. A look-up reads one of a light's maps. All maps have the same size; in images they are stacked. A pass
//! covers all maps at once: in a dispatch, the map is the workgroup's z; in a render, each map has its own draw,
//! because it has its own casters and its own edge.

mod bins;
mod caster_quads;
mod detail;
mod filter;
mod fit;
mod levels;
mod list;
mod opaque;
mod opaque_compute;
mod opaque_raster;
mod order;
mod ray_sums;
mod texels;

pub use bins::compact::Compact;
pub use bins::threads::MANY_CASTERS;
pub use bins::totals::{BinTotals, TilePart};
pub use bins::uses::{Entries, Use};
pub use bins::{Bins, TILE_TEXELS};
pub use caster_quads::{CasterQuads, DrawingOrder, QuadsPush};
pub use detail::{BLOCK_TEXELS, Detail, MOST_BLOCKS, SLOTS, Survey, table_bytes, tile_count};
pub use filter::{Filter, FilterKind};
pub use fit::Extents;
pub use levels::{Levels, carried_texels, coarser_texels, level_size, level_texels, leveled_texels};
pub use list::{Keep, List, SegmentData};
pub use opaque::{AlphaTest, OPAQUE_SIZE, OpaqueMaps, OpaqueWay};
pub use opaque_compute::{OpaqueItem, OpaqueTotals, SeenTriangles};
pub use opaque_raster::{OPAQUE_PARTS, OpaqueDraw, opaque_corner};
pub use order::{CountedOrder, ItemData, NearToFar, Order, Ranking};
pub use ray_sums::{EVEN_CELLS, SumKernels, Sums, sum_targets};
pub use texels::{TexelKernels, TexelPasses, TexelWay, Texels};

use self::fit::Fit;
use self::opaque::Opaque;
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, ReadBack, Resource};
use crate::scene::{Aim, Casting, Light, LightKind, Resolution, View};
use crate::shaders::constant::{CASTER_ROOM, COLOR_MAPS};
use crate::shaders::set;
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// A map of a light. Twin: Map in glsl/world/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Map {
    /// The view of the translucent casters.
    pub caster_view: View,
    /// The view of the meshes.
    pub opaque: View,
}

/// Maximum number of maps in a scene: in a dispatch the map is the workgroup's z, and every device allows this many.
const MAX_MAPS: usize = 65535;

/// Returns the error for a driver that ends a shader's loops before they have visited all casters of `place`
/// (glsl/maps/rounds.glsl). Without the error, the result would be too bright.
fn cut_short(place: &str) -> Error {
    Error::Refused(format!(
            "more rounds of a shader's loops than this driver gives, for the casters of {place}: fewer casters, a larger map or another driver"
        ).into())
}

impl Map {
    /// Returns the maps of all lights before they are fitted ([`View::aimed`]), in the order of the lights. Volume maps
    /// have `size` texels per side. Opaque maps have `opaque_size` texels per side, or a single texel in a scene
    /// without meshes. The whole list is repeated once per cascade.
    pub fn aimed(aim: &Aim, size: u32, opaque_size: u32, cascades: u32) -> Vec<Self> {
        let opaque_size = if aim.has_triangles { opaque_size } else { 1 };
        let volumes = View::aimed(aim, size, Casting::Volume).into_iter();
        let opaques = View::aimed(aim, opaque_size, Casting::Opaque);
        let all: Vec<_> = volumes.zip(opaques).map(|(caster_view, opaque)| Self { caster_view, opaque }).collect();
        all.repeat(cascades as usize)
    }
}

/// The maps of all lights, on the device.
pub struct Maps {
    all: Vec<Map>,
    size: u32,
    opaque_size: u32,
    cascades: u32,
    views: BuildStamp,
    sees_casters: bool,
    /// State of everything built from the volume views.
    orders: BuildStamp,
    buffer: Buffer,
    /// Copies of the maps for the host; after a fit they are newer than `all`.
    fitted: ReadBack,
    /// Whether the last recording fitted the maps, moved the volume views, or drew the opaque maps: one flag each.
    fits: bool,
    moves: bool,
    draws: bool,
    drawn: BuildStamp,
    /// Whether any build has fitted the maps; before that, they are invalid.
    ready: bool,
    fit: Fit,
    lights: Buffer,
    opaque: Opaque,
    scene: Bindings,
    /// The capacity for casters per color, and the number of maps per color; `None` unless casters are stored once per color.
    inks: Option<[u32; 2]>,
}

impl Maps {
    /// Parts of the world that the opaque maps and their views depend on.
    pub const OPAQUE: Parts = Parts::MESHES.and(Parts::LIGHTS);

    /// Parts of the world that the volume views, and everything built from casters in them, depend on. Meshes are not among these parts.
    pub const VOLUME: Parts = Parts::CASTERS.and(Parts::LIGHTS);

    /// Creates maps of `size` texels per side for all lights of `world`, fitted to smoke and hair, with opaque maps.
    ///
    /// # Errors
    /// [`Error::Input`] if the lights have too many maps, [`Error::Refused`] if the device has no image, or not enough
    /// memory, for that many opaque maps, [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, size: u32, opaque: OpaqueMaps) -> Result<Self> {
        Self::seeing(context, world, size, opaque, Self::VOLUME)
    }

    /// Creates maps for a technique that ignores smoke and hair, with its own settings of opaque maps. Their volume
    /// views are fitted to the meshes, like their opaque views.
    ///
    /// # Errors
    /// Same as [`Maps::new`].
    pub fn with_opaque(context: &Context, world: &World, size: u32, opaque: OpaqueMaps) -> Result<Self> {
        Self::seeing(context, world, size, opaque, Self::OPAQUE)
    }

    /// Creates the opaque maps with the settings that techniques share, for a technique without other maps.
    ///
    /// # Errors
    /// Same as [`Maps::new`].
    pub fn opaque_alone(context: &Context, world: &World, way: Option<OpaqueWay>) -> Result<Self> {
        Self::with_opaque(context, world, OPAQUE_SIZE, OpaqueMaps::shared(way))
    }

    fn seeing(context: &Context, world: &World, size: u32, opaque: OpaqueMaps, seen: Parts) -> Result<Self> {
        let count = world.map_count() * opaque.cascades as usize;
        let camera = if opaque.cascades > 1 { Parts::CAMERA } else { Parts::LIGHTS };
        if !(1..=MAX_MAPS).contains(&count) {
            let cause =
                format!("{count} maps (six for a point light, one for any other), and 1 to {MAX_MAPS} are built");
            let name = format!("the lights of {}", world.name());
            let way_out = if opaque.cascades > 1 {
                "change cascades or the number of lights"
            } else {
                "change the number of lights"
            };
            return Err(Error::input(name, cause, way_out));
        }
        let all = Map::aimed(&world.aim(), size, opaque.size, opaque.cascades);
        let buffer = Buffer::with_data(context, "maps", &all)?;
        let fitted = ReadBack::new(context, "maps.fitted", buffer.bytes())?;
        let one = all.first().map_or([1, 1], |m| [m.opaque.width, m.opaque.height]);
        let image = opaque::image(context, opaque, one, count as u32)?;
        let scene = set::MapsScene {
            maps: &buffer,
            casters: &world.casters,
            triangles: &world.triangles,
            opaque_map: &Resource::Gathered(image.clone()),
        };
        let scene = scene.bind(context, "maps.scene")?;
        let (opaque_size, cascades) = (opaque.size, opaque.cascades);
        // The view of a directional light is fitted to all meshes, so its map sees all of them.
        let sees_all = |light: &Light| cascades == 1 && matches!(light.kind, LightKind::Directional { .. });
        let culls = world.triangle_capacity() > 0 && !world.all_lights().iter().all(sees_all);
        let opaque = Opaque::new(context, image, &scene, (opaque, &world.constants()), one, (count as u32, culls))?;
        let fit = Fit::new(context, world, &buffer, &scene, count as u32)?;
        let lights = world.lights.clone();
        Ok(Self {
            all,
            size,
            opaque_size,
            cascades,
            views: BuildStamp::of(seen.and(Self::OPAQUE).and(camera)),
            sees_casters: seen == Self::VOLUME,
            orders: BuildStamp::of(Self::VOLUME),
            buffer,
            fitted,
            fits: false,
            moves: false,
            draws: false,
            drawn: BuildStamp::of(Self::OPAQUE.and(camera)),
            ready: false,
            fit,
            lights,
            opaque,
            scene,
            inks: (world.colors() > 1).then(|| [world.caster_capacity(), (count as u32 / world.colors()).max(1)]),
        })
    }

    /// Returns the maps as the last build fitted them, starting with the first light's; empty before the first build.
    pub fn all(&self) -> &[Map] {
        if self.ready { &self.all } else { &[] }
    }

    /// Returns the number of maps.
    pub fn count(&self) -> u32 {
        self.all.len() as u32
    }

    /// Returns the width and height of a volume map, in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.size; 2]
    }

    /// Returns the number of texels in all volume maps.
    pub fn texels(&self) -> u64 {
        u64::from(self.size).pow(2) * u64::from(self.count())
    }

    /// Returns the number of tiles across and down a volume map.
    pub fn tiles(&self) -> [u32; 2] {
        self.size().map(|texels| texels.div_ceil(TILE_TEXELS))
    }

    /// Returns set 0 of every pass over the maps: glsl/maps/scene.glsl.
    pub fn scene(&self) -> &Bindings {
        &self.scene
    }

    /// Returns the constants of a shader that loops over the casters of a map, including those that select which
    /// casters a map sees, if maps see different casters.
    pub fn colored(&self, constants: &Constants) -> Constants {
        let Some([room, maps]) = self.inks else { return constants.clone() };
        constants.clone().set(CASTER_ROOM, room).set(COLOR_MAPS, maps)
    }

    /// Creates the set of a look-up: the bindings of glsl/maps/look_up.glsl, then `more` from binding 3 on.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub fn look_up(&self, context: &Context, name: &str, more: &[Resource]) -> Result<Bindings> {
        let look_up = set::MapsLookUp {
            lights: &self.lights,
            maps: &self.buffer,
            opaque: &Resource::Gathered(self.opaque.image().clone()),
        };
        Bindings::new(context, name, &[&look_up.resources(), more].concat())
    }

    /// Returns the bindings of a look-up that reads only the opaque maps: the maps of all lights, and the image that
    /// holds them (glsl/grid/meshes.glsl).
    pub fn opaque_bindings(&self) -> (&Buffer, Resource) {
        (&self.buffer, Resource::Gathered(self.opaque.image().clone()))
    }

    /// Fits the maps to a world that has moved. Draws all opaque maps if meshes have moved, otherwise only the maps of
    /// lights that have moved. Records no pass if nothing has moved.
    ///
    /// # Errors
    /// Same as [`Maps::fit`].
    pub fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.fit(commands, world)?;
        let moved = self.drawn.make_lights(world);
        self.draws = moved.contains(&true);
        if self.draws {
            self.opaque.record(commands, world, &self.maps_of(world, &moved));
        }
        Ok(())
    }

    /// Returns the maps of the lights that are flagged in `lights`, as runs of consecutive maps.
    fn maps_of(&self, world: &World, lights: &[bool]) -> Vec<Range<u32>> {
        let of_lights = world.all_lights().iter().zip(lights);
        let all = of_lights.flat_map(|(light, moved)| std::iter::repeat_n(*moved, light.map_count()));
        let all = all.collect::<Vec<_>>().repeat(self.cascades as usize);
        let mut runs: Vec<Range<u32>> = Vec::new();
        for (map, _) in (0..).zip(all).filter(|(_, moved)| *moved) {
            match runs.last_mut() {
                Some(run) if run.end == map => run.end += 1,
                _ => runs.push(map..map + 1),
            }
        }
        runs
    }

    /// Same as [`Maps::record`], in a world with capacity for meshes; in other worlds, opaque maps are not read.
    ///
    /// # Errors
    /// Same as [`Maps::fit`].
    pub fn record_opaque(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        if world.triangle_capacity() == 0 { Ok(()) } else { self.record(commands, world) }
    }

    /// Fits the maps to a world that has moved, for a technique that draws the meshes itself. Records no pass if
    /// nothing has moved.
    ///
    /// # Errors
    /// [`Error::Input`] if the world's lights are not those that the maps were created for, [`Error::Gpu`] if memory
    /// runs out.
    pub fn fit(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        world.has_maps(self.all.len() / self.cascades as usize)?;
        (self.fits, self.moves) = (self.views.make(world), self.orders.make(world));
        if self.fits {
            let aimed = Map::aimed(&world.aim(), self.size, self.opaque_size, self.cascades);
            let casters = if self.sees_casters { world.caster_count() } else { 0 };
            let recorded = self.fit.record(commands, world, casters, &self.buffer, &aimed);
            recorded.inspect_err(|_| {
                self.views.forget();
                self.orders.forget();
            })?;
            commands.read_back(&self.buffer, &self.fitted);
        }
        Ok(())
    }

    /// Returns whether the last recording found that casters or the volume views had moved. Results that depend on them must then be
    /// rebuilt.
    pub fn moved(&self) -> bool {
        self.moves
    }

    /// Makes the next recording draw the opaque maps, even if nothing has changed.
    pub fn forget(&mut self) {
        self.drawn.forget();
    }

    /// Ends frame `frame`: reads back the maps as they were fitted. Returns whether the build has to run again, because
    /// the caller's buffers grew (`grew`) or a list of the opaque maps did. In that case, the next recording rebuilds
    /// everything, so that the last submission holds a complete build.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the maps cannot be read back.
    pub fn settle(&mut self, frame: u64, grew: bool) -> Result<bool> {
        if let Some(fitted) = self.fitted.read(frame, self.all.len())? {
            self.all = fitted;
            self.ready = true;
        }
        let has_room = self.opaque.settle(frame)?;
        if has_room {
            // Draws the opaque maps again, even if a later frame has drawn them since.
            self.drawn.forget();
        }
        let again = has_room || grew;
        for (made, recorded) in
            [(&mut self.views, self.fits), (&mut self.orders, self.moves), (&mut self.drawn, self.draws)]
        {
            if again && recorded {
                made.forget();
            }
        }
        Ok(again)
    }

    /// Returns the resolution of the shared opaque maps, one entry per map.
    pub fn opaque_resolution(&self) -> Vec<Resolution> {
        self.all().iter().map(|map| OpaqueMaps::SHARED.resolution(map.opaque)).collect()
    }

    /// Returns how the opaque maps are drawn here.
    pub fn opaque_way(&self) -> OpaqueWay {
        self.opaque.way()
    }

    /// Returns the bytes needed to draw the opaque maps, besides the maps themselves.
    pub fn opaque_bytes_transient(&self) -> u64 {
        self.opaque.bytes_transient()
    }

    /// Returns the draw commands ([`OpaqueDraw`]) of the opaque maps as last drawn: [`OPAQUE_PARTS`] per map, one for
    /// each part of the triangles. `None` if compute shaders draw the maps, or if each map sees all meshes.
    pub fn opaque_draws(&self) -> Option<&Buffer> {
        self.opaque.draws()
    }

    /// Returns the image of all opaque maps; [`opaque_corner`] locates each map in it.
    pub fn opaque_image(&self) -> &crate::gpu::Image {
        self.opaque.image()
    }

    /// Splits the maps into groups of at most `at_once`.
    pub fn groups(&self, at_once: u32) -> impl Iterator<Item = Range<u32>> + use<> {
        let count = self.count();
        (0..count).step_by(at_once.max(1) as usize).map(move |first| first..(first + at_once.max(1)).min(count))
    }

    /// Returns how many maps can be stacked in one image on this device.
    pub fn stacked_at_once(&self, context: &Context) -> u32 {
        (context.features().max_image_dimension_2d / self.size).clamp(1, self.count())
    }
}

/// Returns the size of an image of `count` stacked maps of `size`.
///
/// # Errors
/// [`Error::Refused`] if the device has no images with that many rows.
pub(crate) fn stacked(context: &Context, name: &str, size: [u32; 2], count: u32) -> Result<[u32; 2]> {
    let limit = context.features().max_image_dimension_2d;
    match size[1].checked_mul(count) {
        Some(rows) if count == 1 || rows <= limit => Ok([size[0], rows]),
        _ => Err(Error::Refused(
            format!(
                "maxImageDimension2D of {} for {name}, {count} maps of {} rows (this device has {limit})",
                u64::from(size[1]) * u64::from(count),
                size[1]
            )
            .into(),
        )),
    }
}
