//! Opaque maps drawn by compute shaders: small triangles by one thread each, the tiles of large ones by whole workgroups.
//! Twin: [`crate::reference::twin::opaque`].

use super::Map;
use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Memory, Pass, ReadBack, Resource,
    groups, push_struct,
};
use crate::scene::View;
use crate::shaders::constant::OPAQUE_SMALL;
use crate::shaders::maps::{
    OPAQUE_CLEAR, OPAQUE_TILES_SEEN_0, OPAQUE_TILES_SEEN_1, OPAQUE_TILES_SEEN_2, OPAQUE_TILES_SEEN_3,
    OPAQUE_TRIANGLES_SEEN_0, OPAQUE_TRIANGLES_SEEN_1, OPAQUE_TRIANGLES_SEEN_2, OPAQUE_TRIANGLES_SEEN_3,
};
use crate::shaders::set;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Texels per side of a tile. Twin: OPAQUE_TILE in glsl/maps/opaque_draw.glsl.
const TILE: u32 = 32;

/// Maximum number of texels in a triangle's bounds for one thread to draw it; for larger ones, a whole workgroup is faster.
const SMALL: u32 = 64;

/// Texels across and down that a workgroup clears. Twin: local_size in glsl/maps/opaque_clear.comp.
const CLEARED: [u32; 2] = [32, 8];

/// Workgroups per row of the dispatch over the list. Twin: OPAQUE_ITEMS_X in glsl/maps/opaque_set.glsl.
const ITEMS_X: u64 = 64;

/// Maximum number of items in the list: every device allows this many rows of workgroups.
const MOST_ITEMS: u64 = ITEMS_X * 65535;

/// Initial capacity of the list, in triangles that cover every map completely.
const FIRST_LAYERS: u64 = 2;

const ITEM_BYTES: u64 = size_of::<OpaqueItem>() as u64;

/// Twin: OpaqueTotals in glsl/maps/opaque_set.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OpaqueTotals {
    /// Number of items requested, whether they fit or not.
    pub items: u32,
    /// x of a VkDispatchIndirectCommand with one workgroup per item.
    pub groups_x: u32,
    /// y of that command.
    pub groups_y: u32,
    /// z of that command.
    pub groups_z: u32,
}

/// Some of the tiles that a triangle covers, drawn by one workgroup. Twin: OpaqueItem in glsl/maps/opaque_set.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OpaqueItem {
    /// Index of the triangle in the world.
    pub triangle: u32,
    /// Index of the map · 4096 + index of the share.
    pub map_share: u32,
}

push_struct! {
    /// Twin: OpaquePush in glsl/maps/opaque_set.glsl.
    struct OpaquePush {
        triangle_count: u32,
        /// Capacity of the list, in items.
        capacity: u32,
        /// Number of maps per column of the image.
        rows: u32,
        /// Index of the map in a dispatch's first layer.
        first_map: u32,
    }
}

/// The passes that draw opaque maps, and the list of triangles left to whole workgroups.
pub(super) struct OpaqueCompute {
    list: TriangleList,
    clear: Kernel<OpaquePush>,
    triangles: Kernel<OpaquePush>,
    tiles: Kernel<OpaquePush>,
    /// Number of maps per column of the image.
    rows: u32,
}

/// The triangles left to whole workgroups.
struct TriangleList {
    context: Context,
    totals: Buffer,
    /// Copies of the totals for the host.
    totalled: ReadBack,
    items: Buffer,
    set: Bindings,
    capacity: u64,
}

impl TriangleList {
    /// Creates the list for `count` maps of `width` × `height` texels, drawn into `image`.
    fn new(context: &Context, image: &Image, [width, height, count]: [u32; 3]) -> Result<Self> {
        let tiles = u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE));
        let capacity = (FIRST_LAYERS * tiles * u64::from(count)).clamp(ITEMS_X, most_items(context));
        let totals = Buffer::new(context, "maps.opaque.totals", size_of::<OpaqueTotals>() as u64, Memory::Device)?;
        let totalled = ReadBack::new(context, "maps.opaque.totalled", totals.bytes())?;
        let items = Buffer::new(context, "maps.opaque.items", capacity * ITEM_BYTES, Memory::Device)?;
        let set = set::MapsOpaque { depths: image, totals: &totals, items: &items }.bind(context, "maps.opaque")?;
        Ok(Self { context: context.clone(), totals, totalled, items, set, capacity })
    }

    /// Runs a shader with one workgroup per item.
    fn per_item(&self, pass: &mut Pass, kernel: &Kernel<OpaquePush>, push: &OpaquePush) {
        pass.dispatch_indirect(kernel, push, &self.totals, std::mem::offset_of!(OpaqueTotals, groups_x) as u64);
    }

    /// Enlarges the list to what the completed frame `frame` needed, as far as the device allows; returns whether the list grew. Triangles
    /// that do not fit into the list are still drawn, but slowly. Devices that end a shader's long loops early draw them incompletely.
    fn settle(&mut self, frame: u64) -> Result<bool> {
        let Some(totals) = self.totalled.read::<OpaqueTotals>(frame, 1)? else { return Ok(false) };
        let asked = totals.first().map_or(0, |totals| u64::from(totals.items));
        let most = most_items(&self.context);
        if asked <= self.capacity || self.capacity == most {
            return Ok(false);
        }
        // An eighth more than needed, so that an animated scene does not grow the buffer every frame.
        let wanted = (asked + asked / 8).min(most);
        self.items = Buffer::new(&self.context, "maps.opaque.items", wanted * ITEM_BYTES, Memory::Device)?;
        self.set.replace(set::MapsOpaque::ITEMS, &self.items)?;
        self.capacity = wanted;
        // Frames recorded earlier used a smaller buffer, so their totals do not show whether the items fit now.
        self.totalled.forget();
        Ok(true)
    }

    fn bytes(&self) -> u64 {
        self.totals.bytes() + self.items.bytes()
    }
}

impl OpaqueCompute {
    /// Creates the passes for `count` maps of `width` × `height` texels in `image`.
    pub(super) fn new(
        context: &Context,
        image: &Image,
        scene: &Bindings,
        constants: &Constants,
        [width, height, count]: [u32; 3],
    ) -> Result<Self> {
        let list = TriangleList::new(context, image, [width, height, count])?;
        let constants = constants.clone().set(OPAQUE_SMALL, SMALL);
        let kernel = |shader| Kernel::compute(context, shader, &[scene, &list.set], &constants);
        let (clear, triangles, tiles) =
            (kernel(&OPAQUE_CLEAR)?, kernel(&OPAQUE_TRIANGLES_SEEN_0)?, kernel(&OPAQUE_TILES_SEEN_0)?);
        Ok(Self { list, clear, triangles, tiles, rows: (image.size()[1] / height).max(1) })
    }

    /// Draws the first `triangle_count` triangles into `maps`, of `width` × `height` texels each.
    pub(super) fn record(
        &mut self,
        commands: &mut Commands,
        [width, height]: [u32; 2],
        triangle_count: u32,
        maps: &[Range<u32>],
    ) {
        let (capacity, rows) = (self.list.capacity as u32, self.rows);
        let push = |first_map| OpaquePush { triangle_count, capacity, rows, first_map };
        let layers = |run: &Range<u32>| run.end - run.start;
        commands.pass("maps.opaque_clear", |pass| {
            let [x, y] = [width.div_ceil(CLEARED[0]), height.div_ceil(CLEARED[1])];
            maps.iter().for_each(|run| pass.dispatch(&self.clear, &push(run.start), [x, y, layers(run)]));
        });
        let [x, y] = groups(u64::from(triangle_count.div_ceil(64)));
        commands.pass("maps.opaque_triangles", |pass| {
            maps.iter().for_each(|run| pass.dispatch(&self.triangles, &push(run.start), [x, y, layers(run)]));
        });
        commands.pass("maps.opaque_tiles", |pass| self.list.per_item(pass, &self.tiles, &push(0)));
        commands.read_back(&self.list.totals, &self.list.totalled);
    }

    /// Enlarges the list if it was too small for the build of the completed frame `frame`; returns whether the list grew.
    pub(super) fn settle(&mut self, frame: u64) -> Result<bool> {
        self.list.settle(frame)
    }

    pub(super) fn bytes_transient(&self) -> u64 {
        self.list.bytes()
    }
}

/// The triangle that each pixel of a camera's picture sees, found by the same passes.
pub struct SeenTriangles {
    /// Two words per pixel: the index of the nearest triangle, 0xFFFFFFFF if there is none, and the bits of its z.
    pub pixels: Buffer,
    view: Buffer,
    list: TriangleList,
    size: [u32; 2],
    /// Each pair draws small triangles, and then the listed ones. There is one pair if a pixel's triangle number and z are compared at
    /// once, otherwise one for z and one for numbers.
    rounds: Vec<[Kernel<OpaquePush>; 2]>,
}

impl SeenTriangles {
    /// Creates the passes for pictures of the camera's size, with the world's constants. They read only `triangles`, but `casters` must be
    /// bound too.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(
        context: &Context,
        (casters, triangles): (&Buffer, &Buffer),
        constants: &Constants,
        camera: &View,
    ) -> Result<Self> {
        let size = [camera.width, camera.height];
        let pixels = Buffer::new(context, "picture.seen", 8 * camera.texels() as u64, Memory::Device)?;
        let view = Buffer::with_data(context, "picture.view", &[Map { caster_view: *camera, opaque: *camera }])?;
        // No opaque map is drawn, but the passes need one to be bound.
        let none = Image::new(context, "picture.no_map", Format::R32_UINT, [1, 1], ImageUse::FloatBits)?;
        let scene = set::MapsScene { maps: &view, casters, triangles, opaque_map: &Resource::Gathered(none.clone()) };
        let scene = scene.bind(context, "picture.triangles")?;
        let list = TriangleList::new(context, &none, [size[0], size[1], 1])?;
        let seen = set::MapsSeen { seen_words: &pixels, seen_pairs: &pixels }.bind(context, "picture.seen")?;
        let constants = constants.clone().set(OPAQUE_SMALL, SMALL);
        let kernel = |shader| Kernel::compute(context, shader, &[&scene, &list.set, &seen], &constants);
        let pair = |[triangles, tiles]: [_; 2]| Ok([kernel(triangles)?, kernel(tiles)?]);
        let shaders = match context.features().buffer_int64_atomics {
            true => vec![[&OPAQUE_TRIANGLES_SEEN_1, &OPAQUE_TILES_SEEN_1]],
            false => {
                vec![[&OPAQUE_TRIANGLES_SEEN_2, &OPAQUE_TILES_SEEN_2], [&OPAQUE_TRIANGLES_SEEN_3, &OPAQUE_TILES_SEEN_3]]
            }
        };
        Ok(Self { rounds: shaders.into_iter().map(pair).collect::<Result<_>>()?, pixels, view, list, size })
    }

    /// Sets the camera of the next pictures.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn look(&self, camera: &View) -> Result<()> {
        self.view.write(&[Map { caster_view: *camera, opaque: *camera }])
    }

    /// Finds the nearest of the first `triangle_count` triangles at each pixel.
    pub fn record(&self, commands: &mut Commands, triangle_count: u32) {
        let push = OpaquePush { triangle_count, capacity: self.list.capacity as u32, rows: 1, first_map: 0 };
        commands.pass("picture.clear", |pass| pass.fill(&self.pixels, u32::MAX));
        let [x, y] = groups(u64::from(triangle_count.div_ceil(64)));
        for [triangles, tiles] in self.rounds.iter().filter(|_| triangle_count > 0) {
            commands.pass("picture.list", |pass| {
                pass.update(
                    &self.list.totals,
                    &[OpaqueTotals { groups_x: ITEMS_X as u32, groups_z: 1, ..OpaqueTotals::default() }],
                );
            });
            commands.pass("picture.triangles", |pass| pass.dispatch(triangles, &push, [x, y, 1]));
            commands.pass("picture.tiles", |pass| self.list.per_item(pass, tiles, &push));
        }
        if triangle_count > 0 {
            commands.read_back(&self.list.totals, &self.list.totalled);
        }
    }

    /// Enlarges the list of large triangles if it was too small for the completed frame `frame`; returns whether the list grew. That frame
    /// still shows all large triangles, but took longer.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn settle(&mut self, frame: u64) -> Result<bool> {
        self.list.settle(frame)
    }

    /// Returns the number of the triangle at each pixel, counted from 1, row by row; 0 if there is none.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn numbers(&self) -> Result<Vec<u32>> {
        let words: Vec<[u32; 2]> = self.pixels.read((self.size[0] * self.size[1]) as usize)?;
        Ok(words.into_iter().map(|[number, _]| number.wrapping_add(1)).collect())
    }
}

fn most_items(context: &Context) -> u64 {
    MOST_ITEMS.min(u64::from(context.features().max_storage_buffer_range) / ITEM_BYTES)
}
