//! The nodes of all texels, and the passes that build them from the lists.

use super::lists::Lists;
use super::settings::{Removal, Settings};
use super::{DeepPush, DeepState};
use crate::gpu::{Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, ReadBack};
use crate::maps::{Maps, TILE_TEXELS};
use crate::shaders::constant::BY_AREA;
use crate::shaders::deep_shadow_map as shaders;
use crate::shaders::set;
use crate::technique::NodeData;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Number of rounds in the search for the smallest error bound at which all nodes fit. Twin: ROUNDS in
/// glsl/technique/deep_shadow_map/choose.comp.
const ROUNDS: u32 = 14;

/// Initial number of nodes per texel in the buffer, which grows with the scene's needs.
const FIRST_NODES: u64 = 1;

/// Twins: VALUE_BITS, VALUE_CODES and LAST_DEPTH in glsl/technique/deep_shadow_map/node.glsl.
const VALUE_BITS: u32 = 14;
const VALUE_CODES: u32 = 1 << VALUE_BITS;
const LAST_DEPTH: f32 = 262_143.0;

/// The nodes, the index at which each texel's nodes start, and the passes that build them.
pub struct Curves {
    context: Context,
    /// Each node is [`NodeData`], or one packed word.
    pub nodes: Buffer,
    node_bytes: u64,
    /// Index of each texel's first node, tile by tile; one extra word marks the end of the last texel's nodes.
    pub starts: Buffer,
    tile_starts: Buffer,
    state: Buffer,
    stated: ReadBack,
    last: DeepState,
    /// Whether `bytes=` is given. If so, a search finds the error bound, and `nodes` never grows.
    has_budget: bool,
    tiles: [u32; 2],
    set: Bindings,
    events: Kernel<DeepPush>,
    compress: Kernel<DeepPush>,
    scan: Kernel<DeepPush>,
    choose: Kernel<DeepPush>,
}

fn node_buffer(context: &Context, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, "deep_shadow_map.nodes", bytes, Memory::Device)
}

impl Curves {
    pub fn new(context: &Context, maps: &Maps, lists: &Lists, settings: &Settings) -> Result<Self> {
        let buffer = |name, bytes| Buffer::new(context, name, bytes, Memory::Device);
        let tiles = maps.tiles();
        let tile_count = u64::from(tiles[0]) * u64::from(tiles[1]) * u64::from(maps.count());
        let starts = buffer("deep_shadow_map.starts", 4 * (tile_count * u64::from(TILE_TEXELS * TILE_TEXELS) + 1))?;
        let node_bytes = if settings.is_packed() { 4 } else { size_of::<NodeData>() as u64 };
        let room = match settings.bytes.map(u64::from) {
            None => tile_count * u64::from(TILE_TEXELS * TILE_TEXELS) * FIRST_NODES,
            Some(bytes) if bytes >= starts.bytes() + node_bytes => (bytes - starts.bytes()) / node_bytes,
            Some(_) => return Err(too_few(starts.bytes() + node_bytes)),
        };
        let nodes = node_buffer(context, room * node_bytes)?;
        let tile_starts = buffer("deep_shadow_map.tile_starts", 4 * tile_count)?;
        let state = Buffer::zeroed(context, "deep_shadow_map.state", size_of::<DeepState>() as u64)?;
        let set = set::DeepShadowMap {
            events: &lists.events,
            nodes: &nodes,
            starts: &starts,
            tile_starts: &tile_starts,
            state: &state,
        };
        let set = set.bind(context, "deep_shadow_map")?;
        let constants = Constants::new().set(BY_AREA, settings.removal() == Removal::Area);
        let of_lists = [maps.scene(), lists.list.set(), &set];
        let of_tiles = [maps.scene(), &set];
        let kernel = |shader, sets: &[&Bindings]| Kernel::compute(context, shader, sets, &constants);
        Ok(Self {
            events: kernel(&shaders::EVENTS, &of_lists)?,
            compress: kernel(&shaders::COMPRESS, &of_lists)?,
            scan: kernel(&shaders::SCAN, &of_tiles)?,
            choose: kernel(&shaders::CHOOSE, &of_tiles)?,
            context: context.clone(),
            nodes,
            node_bytes,
            starts,
            tile_starts,
            stated: ReadBack::new(context, "deep_shadow_map.stated", state.bytes())?,
            state,
            last: DeepState::default(),
            has_budget: settings.bytes.is_some(),
            tiles,
            set,
        })
    }

    /// Returns the capacity of the buffer, in nodes.
    pub fn room(&self) -> u32 {
        (self.nodes.bytes() / self.node_bytes).min(u32::MAX.into()) as u32
    }

    pub fn node_words(&self) -> u32 {
        (self.node_bytes / 4) as u32
    }

    /// Records the passes that build the nodes of a group of maps from their lists.
    pub fn record(&self, commands: &mut Commands, maps: &Maps, push: &DeepPush) {
        let [x, y] = maps.tiles();
        let all = [x, y, push.map_count];
        commands.pass("deep_shadow_map.events", |pass| pass.dispatch(&self.events, push, all));
        if self.has_budget {
            self.search(commands, all, push);
        }
        self.count(commands, all, push);
        commands.pass("deep_shadow_map.scan", |pass| pass.dispatch(&self.scan, push, [1; 3]));
        let push = DeepPush { is_written: 1, ..*push };
        commands.pass("deep_shadow_map.write", |pass| pass.dispatch(&self.compress, &push, all));
    }

    fn count(&self, commands: &mut Commands, all: [u32; 3], push: &DeepPush) {
        commands.pass("deep_shadow_map.count", |pass| pass.dispatch(&self.compress, push, all));
    }

    /// Records the search for the smallest error bound at which all nodes fit.
    fn search(&self, commands: &mut Commands, all: [u32; 3], push: &DeepPush) {
        for round in 0..=ROUNDS {
            if round > 0 {
                self.count(commands, all, push);
            }
            let push = DeepPush { round, ..*push };
            commands.pass("deep_shadow_map.choose", |pass| pass.dispatch(&self.choose, &push, [1; 3]));
        }
    }

    /// Records the read-back of the state, after all groups.
    pub fn end(&self, commands: &mut Commands) {
        commands.read_back(&self.state, &self.stated);
    }

    /// Binds the events again after the lists have grown.
    pub fn bind_events(&self, lists: &Lists) -> Result<()> {
        self.set.replace(set::DeepShadowMap::EVENTS, &lists.events)
    }

    /// Reads how many nodes the build in the finished frame `frame` needs, and replaces `nodes` with a larger buffer if they do not fit.
    /// Returns whether it did so. `is_short`: the lists were too short, so the count is meaningless.
    pub fn settle(&mut self, frame: u64, is_short: bool) -> Result<bool> {
        let Some(state) = self.stated.read::<DeepState>(frame, 1)? else { return Ok(false) };
        if is_short {
            self.stated.forget();
            return Ok(false);
        }
        self.last = state.first().copied().unwrap_or_default();
        let wanted = u64::from(self.last.nodes);
        if wanted <= u64::from(self.room()) {
            return Ok(false);
        }
        if self.has_budget {
            return Err(too_few(self.starts.bytes() + wanted * self.node_bytes));
        }
        // One sixteenth more, so that the buffer does not grow every frame while the scene moves.
        self.nodes = node_buffer(&self.context, (wanted + wanted / 16) * self.node_bytes)?;
        self.set.replace(set::DeepShadowMap::NODES, &self.nodes)?;
        self.stated.forget();
        Ok(true)
    }

    /// Returns the number of bytes that look-ups read.
    pub fn bytes(&self) -> u64 {
        self.nodes.bytes() + self.starts.bytes()
    }

    pub fn bytes_transient(&self) -> u64 {
        self.tile_starts.bytes() + self.state.bytes()
    }

    pub fn counters(&self) -> BTreeMap<String, u64> {
        let DeepState { nodes, covered, error, .. } = self.last;
        let mut counters = BTreeMap::from([
            ("nodes".to_owned(), nodes.into()),
            ("covered_texels".to_owned(), covered.into()),
            ("bytes_used".to_owned(), self.starts.bytes() + u64::from(nodes) * self.node_bytes),
        ]);
        if self.has_budget {
            counters.insert("error_millionths".into(), (f64::from(error) * 1e6).round() as u64);
        }
        counters
    }

    /// Returns the nodes of a texel.
    pub fn texel(&self, map: usize, [x, y]: [u32; 2]) -> Result<Vec<NodeData>> {
        let tile = (map as u32 * self.tiles[1] + y / TILE_TEXELS) * self.tiles[0] + x / TILE_TEXELS;
        let place = (tile * TILE_TEXELS + y % TILE_TEXELS) * TILE_TEXELS + x % TILE_TEXELS;
        let ends: Vec<u32> = self.starts.read_from(place as usize, 2)?;
        let [first, end] = ends[..] else { return Ok(Vec::new()) };
        let (first, count) = (first as usize, (end - first) as usize);
        if count == 0 {
            return Ok(Vec::new());
        }
        if self.node_bytes > 4 {
            return self.nodes.read_from(first, count);
        }
        Ok(self.nodes.read_from(first, count)?.into_iter().map(unpack).collect())
    }
}

/// Twin: unpack_depth and unpack_value in glsl/technique/deep_shadow_map/node.glsl.
fn unpack(word: u32) -> NodeData {
    let value = word & (VALUE_CODES - 1);
    NodeData { depth: (word >> VALUE_BITS) as f32 / LAST_DEPTH, value: value as f32 / (VALUE_CODES - value) as f32 }
}

/// Returns the refusal for curves whose nodes do not fit into `bytes=`.
fn too_few(bytes: u64) -> Error {
    Error::Refused(format!("at least bytes={bytes} for these maps, or a smaller size").into())
}
