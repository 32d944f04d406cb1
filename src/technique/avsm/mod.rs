//! Adaptive volumetric shadow maps: a compressed transmittance curve a texel. Source: seed 000, Salvi et al. 2010.
//!
//! - *two-pass*: [`super::list`] captures every segment, [`Avsm::resolve`] sorts each texel's and compresses them.
//! - *interlock*: [`Avsm::insert`] inserts each fragment's segment into its texel's curve as it is drawn, one fragment of
//!   a texel at a time.
//! - *raster-order*: [`Avsm::raster_order`] does the same with the curves in colour attachments, which the device lets one
//!   fragment of a texel at a time read and write; [`Avsm::unpack`] moves them to where the look-up reads.
//! - *binned*: [`super::bins`] bins casters to tiles. [`Avsm::cells`] adds them up in even cells of depth and compresses
//!   the sums; [`Avsm::binned`] sorts each tile's and inserts their segments into its texels' curves in registers.
//!
//! The same input gives the same bytes on the same device, except for `path=two-pass,order=captured`, whose lists stand
//! in the order in which the device happened to run the fragments.

mod packed;
mod plan;
mod raster_order;

use self::packed::Full;
use self::plan::Plan;
use self::raster_order::RasterOrder;
use super::bins::{Bins, TILE_TEXELS, Use};
use super::drawn::Drawn;
use super::light::{MapData, Maps, SceneData};
use super::list::{Keep, List};
use super::opaque::OpaqueMap;
use super::{Entry, Key, Path, Spec, Technique, Values, Visibility, filter};
use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Context, Graphics, Memory, PassTime, Pipeline, Requirement, Resource, shader,
};
use crate::scene::{FARTHEST, Scene, near_to_far};
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "avsm",
    about: "adaptive volumetric shadow maps: a compressed transmittance curve a texel (seed 000)",
    keys: &[
        Key {
            name: "nodes",
            values: Values::OneOf(&["4", "8", "16"]),
            default: "8",
            about: "nodes of a texel's curve",
        },
        Key {
            name: "curve",
            values: Values::OneOf(&["linear", "exponential"]),
            default: "exponential",
            about: "interpolate transmittance (linear, the seed's) or optical depth (exponential)",
        },
        Key {
            name: "path",
            values: Values::OneOf(&["auto", "two-pass", "interlock", "raster-order", "binned"]),
            default: "auto",
            about: "auto: binned, save for what software devices do faster and for order=captured",
        },
        Key { name: "size", values: Values::Number(1, 16384), default: "256", about: "texels a side of a light's map" },
        Key {
            name: "order",
            values: Values::OneOf(&["sorted", "captured"]),
            default: "sorted",
            about: "insert by depth (single-pass paths: casters drawn by depth) or as drawn",
        },
        Key {
            name: "resolve",
            values: Values::OneOf(&["auto", "streaming", "whole", "cells"]),
            default: "auto",
            about: "segment by segment, whole curves (two-pass, binned) or sums in cells (binned); auto chooses",
        },
        Key {
            name: "nudge",
            values: Values::OneOf(&["on", "off"]),
            default: "on",
            about: "keep the area under the curve when a node is removed (exponential only); off: the seed's",
        },
        super::SKIP,
        super::LIGHTING,
        Key {
            name: "capacity",
            values: Values::Number(1, 1 << 28),
            default: "auto",
            about: "segments that the list holds (two-pass); auto grows to the demand",
        },
        Key {
            name: "storage",
            values: Values::OneOf(&["full", "packed"]),
            default: "full",
            about: "full: 8 bytes a node; packed: 4, and 8 a texel",
        },
        Key {
            name: "batch",
            values: Values::OneOf(&["auto", "shared", "lanes"]),
            default: "auto",
            about: "resolve=cells: casters stand in shared memory or in the lanes of subgroups; auto: lanes on software devices",
        },
        filter::FILTER,
        filter::RADIUS,
    ],
    paths: &[
        Path { name: TWO_PASS, requires: &[Requirement::FragmentStores] },
        Path { name: BINNED, requires: &[] },
        Path { name: INTERLOCK, requires: &[Requirement::FragmentStores, Requirement::PixelInterlock] },
        Path { name: RASTER_ORDER, requires: &[Requirement::RasterOrder] },
    ],
    open: |context, scene, data, spec| Ok(Box::new(Avsm::new(context, scene, data, spec)?)),
};

const TWO_PASS: &str = "two-pass";
const INTERLOCK: &str = "interlock";
const RASTER_ORDER: &str = "raster-order";
const BINNED: &str = "binned";
const CELLS: &str = "cells";

/// Depth of an unused node. Twin: EMPTY in glsl/avsm/curve.glsl.
pub const EMPTY: f32 = FARTHEST;

/// Twin: Node in glsl/avsm/curve.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct NodeData {
    /// Depth in the light's range.
    pub depth: f32,
    /// Transmittance or optical depth.
    pub value: f32,
}

/// What a path builds with.
enum Build {
    TwoPass { list: Box<List>, resolve: Pipeline },
    Interlock { drawn: Drawn, clear: Pipeline, insert: Pipeline, full: Option<Full> },
    RasterOrder(Box<RasterOrder>),
    Binned { insert: Pipeline, cells: bool },
}

/// The technique, opened for one scene.
pub struct Avsm {
    context: Context,
    /// Of a map.
    size: [u32; 2],
    map_count: u32,
    /// Map after map, texel rows, then the curve of a texel, as glsl/avsm/node.glsl states it: [`NodeData`] in order of
    /// depth, or those packed.
    pub nodes: Buffer,
    node_count: u32,
    nodes_bindings: Bindings,
    /// The meshes.
    pub opaque: OpaqueMap,
    /// Which casters meet which tiles: for `path=binned`, and for what `skip=on` leaves out.
    pub bins: Option<Bins>,
    build: Build,
    skip: bool,
    built: bool,
    visibility: Bindings,
    /// NODES, EXPONENTIAL, WORK, NUDGE, SORTED, TILED, FILTER, FILTER_RADIUS, PACKED, GROUPS, STRANDS, GROUPS.
    constants: [u32; 12],
    reason: String,
}

impl Avsm {
    /// Opens the path that `spec` names for `scene`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what the path needs, [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene, data: &SceneData, spec: &Spec) -> Result<Self> {
        let Plan { path, cells, lanes, reason, reach, constants } = Plan::new(context, scene, spec)?;
        let maps = Maps::new(context, scene, spec.number("size"))?;
        let opaque = OpaqueMap::new(context, data, &maps)?;
        let node_count = spec.number("nodes");
        let texels: u64 = maps.data.iter().map(|m| m.volume.texels() as u64).sum();
        let packed = spec.value("storage") == "packed";
        let bytes = texels * packed::pairs(node_count, packed) as u64 * size_of::<NodeData>() as u64;
        let nodes = Buffer::new(context, "avsm.nodes", bytes, Memory::Device)?;
        let skip = spec.value("skip") == "on";
        let bins = if skip || path == BINNED {
            let parts = if cells && lanes { 2 } else { 1 };
            let what = Use { entries: path == BINNED, skip, reach, parts: [parts, if skip { 0 } else { parts }] };
            Some(Bins::new(context, data, &maps, &opaque, what)?)
        } else {
            None
        };
        let size = maps.size();
        let tiles = match &bins {
            Some(bins) => bins.counts.clone(),
            None => {
                let tiles = size.map(|s| u64::from(s.div_ceil(TILE_TEXELS)));
                Buffer::new(context, "avsm.tiles", tiles[0] * tiles[1] * u64::from(maps.count()) * 4, Memory::Device)?
            }
        };
        // The nodes twice: glsl/avsm/store.glsl says why.
        let resources = [&nodes, &tiles, &nodes].map(|b| Resource::Buffer(b.clone()));
        let nodes_bindings = Bindings::new(context, "avsm.nodes", &resources)?;
        // Single-pass paths insert casters in the order in which they are drawn, which each map has its own of.
        let drawn = || {
            let captured = || (0..data.caster_count).collect();
            let sorted = spec.value("order") == "sorted";
            let order = |map: &MapData| if sorted { near_to_far(scene, &map.volume) } else { captured() };
            let orders: Vec<u32> = maps.data.iter().flat_map(order).collect();
            Drawn::new(context, data, &maps, &orders, bins.as_ref())
        };
        let build = if let (BINNED, Some(bins)) = (path, &bins) {
            let sets = [bins.scene_bindings(), bins.bindings(), &nodes_bindings];
            let cells_shader = format!("avsm/cells.comp/{}", u32::from(lanes));
            let insert = shader(if cells { &cells_shader } else { "avsm/binned.comp" })?;
            let insert = Pipeline::compute(context, insert, &sets, &constants)?;
            Build::Binned { insert, cells }
        } else if path == INTERLOCK {
            let drawn = drawn()?;
            let state = Graphics {
                vertex: shader("list/caster.vert")?,
                fragment: shader("avsm/insert.frag")?,
                colors: &[],
                depth: false,
            };
            let full = if packed { Some(Full::new(context, size, &nodes_bindings, &tiles, &constants)?) } else { None };
            let curves = full.as_ref().map_or(&nodes_bindings, Full::bindings);
            Build::Interlock {
                clear: Pipeline::compute(context, shader("avsm/clear.comp")?, &[curves], &constants)?,
                insert: Pipeline::graphics(context, &state, &[drawn.bindings(), curves], &constants)?,
                drawn,
                full,
            }
        } else if path == RASTER_ORDER {
            let path = RasterOrder::new(context, size, drawn()?, &nodes_bindings, &constants)?;
            Build::RasterOrder(Box::new(path))
        } else {
            let capacity = match spec.number("capacity") {
                0 => None,
                n => Some(n),
            };
            let orders: Vec<u32> = (0..maps.count()).flat_map(|_| 0..data.caster_count).collect();
            let drawn = Drawn::new(context, data, &maps, &orders, bins.as_ref())?;
            let list = List::new(context, &maps, drawn, Keep::One, capacity)?;
            let sets = [list.scene_bindings(), list.bindings(), &nodes_bindings];
            let resolve = Pipeline::compute(context, shader("avsm/resolve.comp")?, &sets, &constants)?;
            Build::TwoPass { list: Box::new(list), resolve }
        };
        let resources = [
            Resource::Buffer(maps.lights.clone()),
            Resource::Buffer(nodes.clone()),
            Resource::Texture(opaque.image.clone()),
            Resource::Buffer(tiles),
            Resource::Buffer(maps.buffer.clone()),
        ];
        Ok(Self {
            context: context.clone(),
            size,
            map_count: maps.count(),
            nodes,
            node_count,
            nodes_bindings,
            opaque,
            bins,
            build,
            skip,
            built: false,
            visibility: Bindings::new(context, "avsm.visibility", &resources)?,
            constants,
            reason,
        })
    }

    /// A workgroup a tile.
    fn tiles(&self) -> [u32; 3] {
        [self.size[0].div_ceil(TILE_TEXELS), self.size[1].div_ceil(TILE_TEXELS), 1]
    }

    /// Two-pass: sorts and compresses each list of a map.
    fn resolve(&self, commands: &mut Commands, map: u32, list: &List, pipeline: &Pipeline) {
        commands.pass("avsm.resolve", |pass| {
            let sets = [list.scene_bindings(), list.bindings(), &self.nodes_bindings];
            pass.dispatch(pipeline, &sets, bytemuck::bytes_of(&map), self.tiles());
        });
    }

    /// Interlock: empties every curve of a map.
    fn clear(&self, commands: &mut Commands, map: u32, curves: &Bindings, pipeline: &Pipeline) {
        commands.pass("avsm.clear", |pass| {
            let push = [map, self.size[0], self.size[1]];
            pass.dispatch(pipeline, &[curves], bytemuck::bytes_of(&push), self.tiles());
        });
    }

    /// Interlock: draws the casters into the curves of a map, in the map's order.
    fn insert(&self, commands: &mut Commands, map: u32, drawn: &Drawn, curves: &Bindings, pipeline: &Pipeline) {
        let push = [map, drawn.first(map)];
        commands.pass("avsm.insert", |pass| {
            pass.render(self.size, &[], None, |draw| {
                let sets = [drawn.bindings(), curves];
                drawn.draw(draw, pipeline, &sets, bytemuck::bytes_of(&push), map);
            });
        });
    }

    /// Binned: builds the curves of each tile of a map segment by segment.
    fn binned(&self, commands: &mut Commands, map: u32, bins: &Bins, pipeline: &Pipeline) {
        commands.pass("avsm.binned", |pass| {
            let sets = [bins.scene_bindings(), bins.bindings(), &self.nodes_bindings];
            bins.per_part(pass, map, pipeline, &sets);
        });
    }

    /// Binned: builds the curves of each tile of a map from sums in cells.
    fn cells(&self, commands: &mut Commands, map: u32, bins: &Bins, pipeline: &Pipeline) {
        commands.pass("avsm.cells", |pass| {
            let sets = [bins.scene_bindings(), bins.bindings(), &self.nodes_bindings];
            bins.per_part(pass, map, pipeline, &sets);
        });
    }

    fn build_map(&self, commands: &mut Commands, map: u32) {
        if let Some(bins) = &self.bins {
            bins.horizon(commands, map);
            bins.count(commands, map);
            bins.place(commands, map);
        }
        match (&self.build, &self.bins) {
            (Build::TwoPass { list, resolve }, bins) => {
                list.clear(commands, map);
                list.capture(commands, map, bins.as_ref());
                self.resolve(commands, map, list, resolve);
            }
            (Build::Interlock { drawn, clear, insert, full }, bins) => {
                let curves = full.as_ref().map_or(&self.nodes_bindings, Full::bindings);
                drawn.compact(commands, map, bins.as_ref());
                self.clear(commands, map, curves, clear);
                self.insert(commands, map, drawn, curves, insert);
                if let Some(full) = full {
                    self.pack(commands, map, full);
                }
            }
            (Build::RasterOrder(path), bins) => {
                path.drawn.compact(commands, map, bins.as_ref());
                self.raster_order(commands, map, path);
                self.unpack(commands, map, path);
            }
            (Build::Binned { insert, cells }, Some(bins)) => {
                bins.scatter(commands, map);
                if *cells {
                    self.cells(commands, map, bins, insert);
                } else {
                    self.binned(commands, map, bins, insert);
                }
            }
            // Binned never is without bins.
            (Build::Binned { .. }, None) => {}
        }
    }

    /// Texels whose curve has a node, of all maps.
    fn covered_texels(&self) -> Result<u64> {
        let texels = (self.map_count * self.size[0] * self.size[1]) as usize;
        let pairs = packed::pairs(self.node_count, self.packed());
        let curves: Vec<NodeData> = self.nodes.read(texels * pairs)?;
        let in_use = match &self.bins {
            Some(bins) if self.skip => bins.texels_in_use(self.size)?,
            _ => vec![true; texels],
        };
        // Packed or not, a curve begins with the depth of its first node.
        let covered = |(n, in_use): &(&[NodeData], bool)| *in_use && n[0].depth < EMPTY;
        Ok(curves.chunks_exact(pairs).zip(in_use).filter(covered).count() as u64)
    }
}

impl Technique for Avsm {
    fn changed(&mut self) {
        self.built = false;
    }

    fn build(&mut self) -> Result<Vec<PassTime>> {
        if self.built && self.skip {
            return Ok(Vec::new());
        }
        loop {
            let passes = self.context.submit(|commands| {
                self.opaque.depth(commands);
                if let Some(bins) = &self.bins {
                    bins.clear(commands);
                }
                (0..self.map_count).for_each(|map| self.build_map(commands, map));
            })?;
            let lists = if let Build::TwoPass { list, .. } = &mut self.build { list.grow()? } else { false };
            let bins = self.bins.as_mut().map_or(Ok(false), Bins::grow)?;
            if !lists && !bins {
                self.built = true;
                return Ok(passes);
            }
        }
    }

    fn visibility(&self) -> Visibility<'_> {
        Visibility { folder: ENTRY.name, bindings: &self.visibility, constants: &self.constants }
    }

    fn nodes(&self, map: usize, [x, y]: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        let texel = ((map as u32 * self.size[1] + y) * self.size[0] + x) as usize;
        let in_use = match &self.bins {
            Some(bins) if self.skip => bins.texels_in_use(self.size)?[texel],
            _ => true,
        };
        if !in_use {
            return Ok(Vec::new());
        }
        let pairs = packed::pairs(self.node_count, self.packed());
        let all: Vec<[u32; 2]> = self.nodes.read((texel + 1) * pairs)?;
        let exponential = self.constants[1] == 1;
        let transmittance = |value: f64| if exponential { (-value).exp() } else { value };
        let nodes = if self.packed() {
            packed::unpack(&all[texel * pairs..], exponential)
        } else {
            let bits = |n: &[u32; 2]| (f32::from_bits(n[0]).into(), f32::from_bits(n[1]).into());
            all[texel * pairs..].iter().map(bits).collect()
        };
        let used = nodes.into_iter().filter(|n| n.0 < f64::from(EMPTY));
        Ok(used.map(|(depth, value)| (depth, transmittance(value))).collect())
    }

    fn path(&self) -> &'static str {
        match self.build {
            Build::TwoPass { .. } => TWO_PASS,
            Build::Interlock { .. } => INTERLOCK,
            Build::RasterOrder(_) => RASTER_ORDER,
            Build::Binned { .. } => BINNED,
        }
    }

    fn reason(&self) -> String {
        match &self.build {
            Build::TwoPass { list, .. } if list.overflowed() > 0 => {
                format!("{}; overflowed: {}", self.reason, list.overflowed())
            }
            _ => self.reason.clone(),
        }
    }

    fn bytes_resident(&self) -> u64 {
        let tiles = self.bins.as_ref().map_or(0, |b| b.counts.bytes());
        self.nodes.bytes() + tiles + self.opaque.image.bytes()
    }

    fn bytes_transient(&self) -> u64 {
        let bins = self.bins.as_ref().map_or(0, Bins::bytes_transient);
        bins + match &self.build {
            Build::TwoPass { list, .. } => list.bytes(),
            Build::Interlock { drawn, full, .. } => drawn.bytes() + full.as_ref().map_or(0, Full::bytes),
            Build::RasterOrder(path) => path.bytes(),
            Build::Binned { .. } => 0,
        }
    }

    fn counters(&self) -> Result<BTreeMap<String, u64>> {
        let mut counters = BTreeMap::from([("covered_texels".to_owned(), self.covered_texels()?)]);
        counters.extend(self.bins.iter().flat_map(Bins::counters));
        if let Build::TwoPass { list, .. } = &self.build {
            counters.insert("fragments".into(), list.fragments());
            counters.insert("overflowed".into(), list.overflowed());
        }
        Ok(counters)
    }
}
