//! Opaque maps drawn by the device's rasterizer, with one draw per map. If maps may not see all meshes, the triangles
//! are split into parts, and each map draws the parts that it may see.

use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Format, Graphics, Image, Kernel, Memory, Target, groups,
    push_struct,
};
use crate::shaders;
use crate::shaders::set;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Returns the upper left texel of a map of `size` in the image. Twin: opaque_corner in glsl/maps/opaque.glsl.
pub fn opaque_corner(image: &Image, size: [u32; 2], map: u32) -> [u32; 2] {
    let rows = (image.size()[1] / size[1]).max(1);
    [map / rows * size[0], map % rows * size[1]]
}

/// Maximum number of parts into which the triangles are split. Twin: OPAQUE_PARTS in glsl/maps/opaque_cull.comp.
pub const OPAQUE_PARTS: u32 = 16;

/// VkDrawIndirectCommand for one part of the triangles. Twin: OpaqueDraw in glsl/maps/opaque_cull.comp.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OpaqueDraw {
    /// Number of vertices: three per triangle of the part.
    pub vertex_count: u32,
    /// 1 if the map may see any triangle of the part, else 0.
    pub instance_count: u32,
    /// First vertex of the part.
    pub first_vertex: u32,
    /// Always 0.
    pub first_instance: u32,
}

const DRAW_BYTES: u64 = size_of::<OpaqueDraw>() as u64;

push_struct! {
    /// Twin: MapPush in glsl/maps/opaque.vert and glsl/maps/opaque.frag.
    struct MapPush {
        map: u32,
        /// The map's upper left texel in the image.
        corner: [u32; 2],
    }
}

push_struct! {
    /// Twin: CullPush in glsl/maps/opaque_cull.comp.
    struct CullPush {
        triangle_count: u32,
        part_triangles: u32,
        first_map: u32,
    }
}

/// The passes that draw the maps.
pub(super) struct OpaqueRaster {
    draw: Kernel<MapPush>,
    map_count: u32,
    /// `None` if all maps see all meshes, since views of directional lights are fitted to them.
    cull: Option<Cull>,
}

/// The pass that finds the parts that each map may see.
struct Cull {
    kernel: Kernel<CullPush>,
    /// [`OpaqueDraw`]: [`OPAQUE_PARTS`] per map.
    draws: Buffer,
}

/// Returns the number of triangles per part.
fn part_triangles(triangle_count: u32) -> u32 {
    triangle_count.div_ceil(OPAQUE_PARTS).next_multiple_of(64).max(64)
}

impl OpaqueRaster {
    /// Creates the passes for `map_count` maps, which may not see all meshes if `culls` is set.
    pub(super) fn new(
        context: &Context,
        scene: &Bindings,
        format: Format,
        constants: &Constants,
        (map_count, culls): (u32, bool),
    ) -> Result<Self> {
        let state = Graphics {
            vertex: &shaders::maps::OPAQUE_VERT,
            fragment: &shaders::maps::OPAQUE_FRAG,
            colors: &[],
            depth: Some(format),
        };
        let draw = Kernel::graphics(context, &state, &[scene], constants)?;
        let cull = if culls { Some(Cull::new(context, scene, map_count)?) } else { None };
        Ok(Self { draw, map_count, cull })
    }

    /// Draws the first `triangle_count` triangles into `maps`, of `size` texels each.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        image: &Image,
        size: [u32; 2],
        triangle_count: u32,
        maps: &[Range<u32>],
    ) {
        if let Some(cull) = &self.cull {
            cull.record(commands, triangle_count, self.map_count, maps);
        }
        let corner = |map| opaque_corner(image, size, map);
        // All maps are drawn in one render. If only some maps are drawn, each of them has its own render, so that the
        // other maps are unchanged.
        let renders: Vec<_> = match maps {
            [all] if *all == (0..self.map_count) => vec![([0, 0], image.size(), all.clone())],
            some => some.iter().flat_map(Clone::clone).map(|map| (corner(map), size, map..map + 1)).collect(),
        };
        commands.pass("maps.opaque", |pass| {
            for (first, area, maps) in renders {
                let target = Target { image, clear: Some([1.0; 4]) };
                pass.render_area(first, area, &[], Some(target), |draw| {
                    for map in maps {
                        let push = MapPush { map, corner: corner(map) };
                        draw.area(push.corner, size);
                        let Some(cull) = &self.cull else {
                            draw.draw(&self.draw, &push, 3 * triangle_count, 1);
                            continue;
                        };
                        for part in 0..triangle_count.div_ceil(part_triangles(triangle_count)) {
                            let at = DRAW_BYTES * u64::from(OPAQUE_PARTS * map + part);
                            draw.draw_indirect(&self.draw, &push, &cull.draws, at);
                        }
                    }
                });
            }
        });
    }

    /// Returns the draw commands ([`OpaqueDraw`]) of the parts of all maps, if maps may not see all meshes.
    pub(super) fn draws(&self) -> Option<&Buffer> {
        self.cull.as_ref().map(|cull| &cull.draws)
    }
}

impl Cull {
    fn new(context: &Context, scene: &Bindings, map_count: u32) -> Result<Self> {
        let bytes = DRAW_BYTES * u64::from(OPAQUE_PARTS) * u64::from(map_count);
        let draws = Buffer::new(context, "maps.opaque.draws", bytes, Memory::Device)?;
        let set = set::MapsOpaqueCull { draws: &draws }.bind(context, "maps.opaque_cull")?;
        let kernel = Kernel::compute(context, &shaders::maps::OPAQUE_CULL, &[scene, &set], &Constants::new())?;
        Ok(Self { kernel, draws })
    }

    fn record(&self, commands: &mut Commands, triangle_count: u32, map_count: u32, maps: &[Range<u32>]) {
        let part = part_triangles(triangle_count);
        let unseen = |i: u32| {
            let first = (i * part).min(triangle_count);
            let count = part.min(triangle_count - first);
            OpaqueDraw { vertex_count: 3 * count, first_vertex: 3 * first, ..OpaqueDraw::default() }
        };
        let of_map: Vec<_> = (0..OPAQUE_PARTS).map(unseen).collect();
        let [x, y] = groups(u64::from(triangle_count.div_ceil(64)));
        commands.pass("maps.opaque_cull", |pass| {
            pass.update(&self.draws, &of_map.repeat(map_count as usize));
            pass.barrier();
            for run in maps {
                let push = CullPush { triangle_count, part_triangles: part, first_map: run.start };
                pass.dispatch(&self.kernel, &push, [x, y, run.end - run.start]);
            }
        });
    }
}
