//! Adaptive volumetric shadow maps: a compressed transmittance curve a texel. Source: seed 000, Salvi et al. 2010.
//!
//! - *two-pass*: [`super::list`] captures every segment, [`Avsm::resolve`] sorts each texel's and compresses them.
//! - *interlock*: [`Avsm::insert`] inserts each fragment's segment into its texel's curve as it is drawn, one fragment of
//!   a texel at a time.
//! - *binned*: [`super::bins`] bins particles to tiles, [`Avsm::binned`] sorts each tile's and inserts their segments into
//!   its texels' curves in registers.
//!
//! The same input gives the same bytes on the same device, except for `path=two-pass,order=captured`, whose lists stand
//! in the order in which the device happened to run the fragments.

use super::bins::Bins;
use super::light::{LightData, SceneData};
use super::list::{List, scene_bindings};
use super::opaque::OpaqueMap;
use super::{Entry, Key, Path, Spec, Technique, Values, Visibility};
use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Context, Graphics, Memory, PassTime, Pipeline, Requirement, Resource, shader,
};
use crate::scene::{Scene, View};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
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
            about: "nodes of a texel's curve, 8 bytes each",
        },
        Key {
            name: "curve",
            values: Values::OneOf(&["linear", "exponential"]),
            default: "exponential",
            about: "interpolate transmittance (linear, the seed's) or optical depth (exponential)",
        },
        Key {
            name: "path",
            values: Values::OneOf(&["auto", "two-pass", "interlock", "binned"]),
            default: "auto",
            about: "auto: binned on GPUs; on software devices interlock where there is one, else two-pass",
        },
        Key {
            name: "size",
            values: Values::Number(1, 16384),
            default: "256",
            about: "texels a side of the light's map",
        },
        Key {
            name: "order",
            values: Values::OneOf(&["sorted", "captured"]),
            default: "sorted",
            about: "insert by depth (interlock: particles drawn by depth) or as drawn",
        },
        Key {
            name: "resolve",
            values: Values::OneOf(&["streaming", "whole"]),
            default: "streaming",
            about: "compress segment by segment, or the whole curve of a texel at once (two-pass only)",
        },
        Key {
            name: "nudge",
            values: Values::OneOf(&["on", "off"]),
            default: "on",
            about: "keep the area under the curve when a node is removed (exponential only); off: the seed's",
        },
        Key {
            name: "capacity",
            values: Values::Number(1, 1 << 28),
            default: "auto",
            about: "segments that the list holds (two-pass); auto grows to the demand",
        },
    ],
    paths: &[
        Path { name: TWO_PASS, requires: &[Requirement::FragmentStores] },
        Path { name: BINNED, requires: &[] },
        Path { name: INTERLOCK, requires: &[Requirement::FragmentStores, Requirement::PixelInterlock] },
    ],
    open: |context, scene, data, spec| Ok(Box::new(Avsm::new(context, scene, data, spec)?)),
};

/// WORK − NODES where a texel's whole curve is compressed at once. With 16 the error on plume_8k is within 2 % of what
/// 112 give, which hold almost every curve exactly; what does go on the way is what changes the area least.
const WHOLE_NODES: u32 = 16;

/// WORK − NODES of the binned path, whose curves stay in registers. They make up for sorting by tile and not by texel.
const BINNED_NODES: u32 = 4;

const TWO_PASS: &str = "two-pass";
const INTERLOCK: &str = "interlock";
const BINNED: &str = "binned";

/// Depth of an unused node. Twin: EMPTY in glsl/avsm/curve.glsl.
pub const EMPTY: f32 = 3e38;

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
    Interlock { scene: Bindings, clear: Pipeline, insert: Pipeline },
    Binned { bins: Box<Bins>, insert: Pipeline },
}

/// The technique, opened for one scene.
pub struct Avsm {
    context: Context,
    size: [u32; 2],
    /// [`NodeData`]: texel rows, then the nodes of a texel in order of depth.
    pub nodes: Buffer,
    node_count: u32,
    particle_count: u32,
    nodes_bindings: Bindings,
    opaque: OpaqueMap,
    build: Build,
    visibility: Bindings,
    /// NODES, EXPONENTIAL, WORK, NUDGE, SORTED, TILED.
    constants: [u32; 6],
    reason: String,
}

impl Avsm {
    /// Opens the path that `spec` names for `scene`.
    ///
    /// # Errors
    /// [`crate::Error::Refused`] where the device lacks what the path needs, [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene, data: &SceneData, spec: &Spec) -> Result<Self> {
        let (path, reason) = choose(context, spec);
        for known in ENTRY.paths.iter().filter(|p| p.name == path) {
            super::require(context, known.requires)?;
        }
        let light = LightData::new(scene, spec.number("size"));
        let lights = Buffer::with_data(context, "lights", &[light])?;
        let opaque = OpaqueMap::new(context, data, &light, &lights)?;
        let node_count = spec.number("nodes");
        let bytes = light.volume.texels() as u64 * u64::from(node_count) * size_of::<NodeData>() as u64;
        let nodes = Buffer::new(context, "avsm.nodes", bytes, Memory::Device)?;
        let nodes_bindings = Bindings::new(context, "avsm.nodes", &[Resource::Buffer(nodes.clone())])?;
        let whole = spec.value("resolve") == "whole";
        let sorted = spec.value("order") == "sorted";
        if whole && path == INTERLOCK {
            let needs = "every segment of a texel (resolve=whole), which path=interlock does not keep".into();
            return Err(crate::Error::Refused { needs });
        }
        if !sorted && path == BINNED {
            return Err(crate::Error::Refused { needs: "order=sorted: path=binned has no other".into() });
        }
        let more_nodes = match path {
            _ if whole => WHOLE_NODES,
            BINNED => BINNED_NODES,
            _ => 0,
        };
        let constants = [
            node_count,
            u32::from(spec.value("curve") == "exponential"),
            node_count + more_nodes,
            u32::from(spec.value("nudge") == "on"),
            sorted.into(),
            u32::from(path == BINNED),
        ];
        let mut tiles = Buffer::new(context, "avsm.tiles", 4, Memory::Device)?;
        let build = if path == BINNED {
            let bins = Bins::new(context, data, &light, &lights)?;
            let sets = [bins.scene_bindings(), bins.bindings(), &nodes_bindings];
            let insert = Pipeline::compute(context, shader("avsm/binned.comp")?, &sets, &constants)?;
            tiles = bins.counts.clone();
            Build::Binned { bins: Box::new(bins), insert }
        } else if path == INTERLOCK {
            let order = if sorted { near_to_far(scene, &light.volume) } else { (0..data.particle_count).collect() };
            let scene = scene_bindings(context, data, &lights, &order)?;
            let state = Graphics {
                vertex: shader("list/particle.vert")?,
                fragment: shader("avsm/insert.frag")?,
                colors: &[],
                depth: false,
            };
            Build::Interlock {
                clear: Pipeline::compute(context, shader("avsm/clear.comp")?, &[&nodes_bindings], &constants)?,
                insert: Pipeline::graphics(context, &state, &[&scene, &nodes_bindings], &constants)?,
                scene,
            }
        } else {
            let capacity = match spec.number("capacity") {
                0 => None,
                n => Some(n),
            };
            let list = List::new(context, data, &light, &lights, capacity)?;
            let sets = [list.scene_bindings(), list.bindings(), &nodes_bindings];
            let resolve = Pipeline::compute(context, shader("avsm/resolve.comp")?, &sets, &constants)?;
            Build::TwoPass { list: Box::new(list), resolve }
        };
        let resources = [
            Resource::Buffer(lights),
            Resource::Buffer(nodes.clone()),
            Resource::Texture(opaque.image.clone()),
            Resource::Buffer(tiles),
        ];
        Ok(Self {
            context: context.clone(),
            size: [light.volume.width, light.volume.height],
            nodes,
            node_count,
            particle_count: data.particle_count,
            nodes_bindings,
            opaque,
            build,
            visibility: Bindings::new(context, "avsm.visibility", &resources)?,
            constants,
            reason,
        })
    }

    /// Two-pass: sorts and compresses each texel's list.
    fn resolve(&self, commands: &mut Commands, list: &List, pipeline: &Pipeline) {
        commands.pass("avsm.resolve", |pass| {
            let sets = [list.scene_bindings(), list.bindings(), &self.nodes_bindings];
            pass.dispatch(pipeline, &sets, &[], [self.size[0].div_ceil(8), self.size[1].div_ceil(8), 1]);
        });
    }

    /// Interlock: empties every curve.
    fn clear(&self, commands: &mut Commands, pipeline: &Pipeline) {
        let count = self.size[0] * self.size[1] * self.node_count;
        commands.pass("avsm.clear", |pass| {
            let groups = [count.div_ceil(256), 1, 1];
            pass.dispatch(pipeline, &[&self.nodes_bindings], bytemuck::bytes_of(&count), groups);
        });
    }

    /// Interlock: draws all particles into the curves.
    fn insert(&self, commands: &mut Commands, scene: &Bindings, pipeline: &Pipeline) {
        commands.pass("avsm.insert", |pass| {
            pass.render(self.size, &[], None, |draw| {
                draw.draw(pipeline, &[scene, &self.nodes_bindings], &[], 6 * self.particle_count);
            });
        });
    }

    /// Binned: builds the curves of each tile.
    fn binned(&self, commands: &mut Commands, bins: &Bins, pipeline: &Pipeline) {
        commands.pass("avsm.binned", |pass| {
            let sets = [bins.scene_bindings(), bins.bindings(), &self.nodes_bindings];
            pass.dispatch(pipeline, &sets, &[], [bins.tiles[0], bins.tiles[1], 1]);
        });
    }

    /// Texels whose curve has a node.
    fn covered_texels(&self) -> Result<u64> {
        let texels = (self.size[0] * self.size[1]) as usize;
        let nodes: Vec<NodeData> = self.nodes.read(texels * self.node_count as usize)?;
        let in_use = match &self.build {
            Build::Binned { bins, .. } => bins.texels_in_use(self.size)?,
            _ => vec![true; texels],
        };
        let covered = |(n, in_use): &(&[NodeData], bool)| *in_use && n[0].depth < EMPTY;
        Ok(nodes.chunks_exact(self.node_count as usize).zip(in_use).filter(covered).count() as u64)
    }
}

/// The path and why. `auto` follows what was measured (README, "Which path"):
///
/// | device | path |
/// |---|---|
/// | a GPU | binned: fastest on the H200, by far less memory than two-pass, and exact order does not matter |
/// | a software device with pixel interlock | interlock: fastest on lavapipe 26.1 |
/// | a software device without | two-pass: fastest on lavapipe 22.3 |
///
/// `resolve=whole` and `order=captured` are left to the paths that have them.
fn choose(context: &Context, spec: &Spec) -> (&'static str, String) {
    if let Some(asked) = [INTERLOCK, TWO_PASS, BINNED].into_iter().find(|p| *p == spec.value("path")) {
        return (asked, "asked for".into());
    }
    let features = context.features();
    let captured = spec.value("order") == "captured";
    if features.kind != "cpu" && !captured {
        return (BINNED, format!("auto: {} device", features.kind));
    }
    match features.lacks(Requirement::PixelInterlock) {
        _ if spec.value("resolve") == "whole" => (TWO_PASS, "auto: resolve=whole on a software device".into()),
        None => (INTERLOCK, "auto: a software device with fragmentShaderPixelInterlock".into()),
        Some(missing) => (TWO_PASS, format!("auto: a software device that lacks {missing}")),
    }
}

/// Particle indices by rising depth of their nearest point in the light's view; ties by index. It is near the order of
/// entry depths in each texel, which a drawing order cannot match in all texels at once.
pub fn near_to_far(scene: &Scene, view: &View) -> Vec<u32> {
    let nearest = |i: &u32| {
        let particle = &scene.particles[*i as usize];
        view.project(DVec3::from(particle.position.map(f64::from))).1 - f64::from(particle.radius)
    };
    let mut order: Vec<u32> = (0..scene.particles.len() as u32).collect();
    order.sort_by(|a, b| nearest(a).total_cmp(&nearest(b)).then(a.cmp(b)));
    order
}

impl Technique for Avsm {
    fn build(&mut self) -> Result<Vec<PassTime>> {
        loop {
            let passes = self.context.submit(|commands| {
                self.opaque.depth(commands);
                match &self.build {
                    Build::TwoPass { list, resolve } => {
                        list.clear(commands);
                        list.capture(commands);
                        self.resolve(commands, list, resolve);
                    }
                    Build::Interlock { scene, clear, insert } => {
                        self.clear(commands, clear);
                        self.insert(commands, scene, insert);
                    }
                    Build::Binned { bins, insert } => {
                        bins.clear(commands);
                        bins.count(commands);
                        bins.scan(commands);
                        bins.scatter(commands);
                        self.binned(commands, bins, insert);
                    }
                }
            })?;
            let again = match &mut self.build {
                Build::TwoPass { list, .. } => list.grow()?,
                Build::Binned { bins, .. } => bins.grow()?,
                Build::Interlock { .. } => false,
            };
            if !again {
                return Ok(passes);
            }
        }
    }

    fn visibility(&self) -> Visibility<'_> {
        Visibility { folder: ENTRY.name, bindings: &self.visibility, constants: &self.constants }
    }

    fn nodes(&self, [x, y]: [u32; 2]) -> Result<Vec<(f64, f64)>> {
        let texel = (y * self.size[0] + x) as usize;
        let in_use = match &self.build {
            Build::Binned { bins, .. } => bins.texels_in_use(self.size)?[texel],
            _ => true,
        };
        if !in_use {
            return Ok(Vec::new());
        }
        let count = self.node_count as usize;
        let all: Vec<NodeData> = self.nodes.read((texel + 1) * count)?;
        let exponential = self.constants[1] == 1;
        let transmittance = |value: f32| if exponential { (-f64::from(value)).exp() } else { value.into() };
        let used = all.iter().skip(texel * count).filter(|n| n.depth < EMPTY);
        Ok(used.map(|n| (n.depth.into(), transmittance(n.value))).collect())
    }

    fn path(&self) -> &'static str {
        match self.build {
            Build::TwoPass { .. } => TWO_PASS,
            Build::Interlock { .. } => INTERLOCK,
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
        let tiles = if let Build::Binned { bins, .. } = &self.build { bins.counts.bytes() } else { 0 };
        self.nodes.bytes() + tiles + self.opaque.image.bytes()
    }

    fn bytes_transient(&self) -> u64 {
        match &self.build {
            Build::TwoPass { list, .. } => list.bytes(),
            Build::Binned { bins, .. } => bins.bytes_transient(),
            Build::Interlock { .. } => 0,
        }
    }

    fn counters(&self) -> Result<BTreeMap<String, u64>> {
        let mut counters = BTreeMap::from([("covered_texels".to_owned(), self.covered_texels()?)]);
        match &self.build {
            Build::TwoPass { list, .. } => {
                counters.insert("fragments".into(), list.fragments().into());
                counters.insert("overflowed".into(), list.overflowed().into());
            }
            Build::Binned { bins, .. } => counters.extend(bins.counters()),
            Build::Interlock { .. } => {}
        }
        Ok(counters)
    }
}
