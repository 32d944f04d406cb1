//! Bakes as files. docs/notebook/voxelized.md describes the layout byte by byte.

use super::check::stays_inside;
use super::settings::{Coverage, Free, Plan, Settings, Structure};
use super::{COUNTS, TreeData};
use crate::scene::{Light, LightKind, Mesh};
use crate::technique::keys::Word;
use crate::{Error, Result, WayOut};
use bytemuck::{Pod, Zeroable};
use fnv::FnvHasher;
use glam::DVec3;
use std::hash::Hasher;

/// The first bytes of every file.
const MAGIC: [u8; 8] = *b"gobo-vox";

/// Version that is written, and the only version that can be read.
const VERSION: u32 = 3;

/// Size of the checksum at the end, in bytes.
const CHECKSUM: usize = 4;

const AGAIN: &str = "bake it again";

// Files are little-endian, and so are machines with Vulkan: words go to the device exactly as stored.
const _: () = assert!(cfg!(target_endian = "little"));

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    version: u32,
    size: u32,
    structure: u32,
    closed: u32,
    free: u32,
    coverage: u32,
    trees: u32,
    /// Padding of 0, so that later fields are aligned to 8 bytes.
    padding: u32,
    scene: u64,
    words: u64,
    counts: [u64; COUNTS.len()],
}

/// A bake that is to be written, or that was read.
pub struct Baked<'a> {
    /// The settings of the bake; a file holds size, structure, closed, free and coverage.
    pub plan: Plan,
    /// Hash of the scene that was baked.
    pub scene: u64,
    /// Counts of leaves and nodes, as listed in the `counters` of the facts.
    pub counts: [u64; COUNTS.len()],
    /// One tree per light, or one per face of a light that shines in all directions.
    pub trees: Vec<TreeData>,
    /// Nodes of all trees, as little-endian words.
    pub words: &'a [u8],
}

/// Returns the size in bytes of a file with `trees` trees and `words` words. The type is wide enough for anything that a corrupt header may
/// hold.
pub fn bytes_on_disk(trees: u32, words: u64) -> u128 {
    let fixed = (size_of::<Header>() + CHECKSUM) as u128;
    fixed + u128::from(trees) * size_of::<TreeData>() as u128 + 4 * u128::from(words)
}

impl<'a> Baked<'a> {
    /// Returns the whole file.
    pub fn bytes(&self) -> Vec<u8> {
        let header = Header {
            magic: MAGIC,
            version: VERSION,
            size: self.plan.size,
            structure: self.plan.structure as u32,
            closed: self.plan.closed.into(),
            free: self.plan.free as u32,
            coverage: self.plan.coverage as u32,
            trees: self.trees.len() as u32,
            padding: 0,
            scene: self.scene,
            words: self.words.len() as u64 / 4,
            counts: self.counts,
        };
        let mut bytes = [bytemuck::bytes_of(&header), bytemuck::cast_slice(&self.trees), self.words].concat();
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// Reads the bytes of the file `name`. No allocation is larger than the file.
    ///
    /// # Errors
    /// [`Error::Input`] if the bytes are not a bake, are cut off or damaged, or are of another version.
    pub fn read(name: &str, bytes: &'a [u8]) -> Result<Self> {
        let wrong = |cause: String, way_out: &str| Err(Error::input(name, cause, WayOut::Bake(way_out.into())));
        if !bytes.starts_with(&MAGIC[..MAGIC.len().min(bytes.len())]) {
            return wrong("it does not begin as a bake does".into(), "name the file of one, or write one");
        }
        // The version is checked first: in a file of another version, the rest may mean anything.
        let version = bytes.get(MAGIC.len()..MAGIC.len() + 4).map(bytemuck::pod_read_unaligned::<u32>);
        if let Some(version) = version.filter(|version| *version != VERSION) {
            let cause = format!("version {version}, and version {VERSION} is read here");
            return wrong(cause, &format!("read it with what wrote it, or {AGAIN}"));
        }
        let Some(header) = bytes.get(..size_of::<Header>()) else {
            return wrong(format!("cut off: {} bytes, and more are its header", bytes.len()), AGAIN);
        };
        let header: Header = bytemuck::pod_read_unaligned(header);
        let (has, says) = (bytes.len() as u128, bytes_on_disk(header.trees, header.words));
        if has != says {
            let what = if has < says { "cut off" } else { "damaged" };
            return wrong(format!("{what}: {has} bytes, and its header says {says}"), AGAIN);
        }
        let (content, sum) = bytes.split_at(bytes.len() - CHECKSUM);
        if crc32fast::hash(content).to_le_bytes() != sum {
            return wrong("damaged: its checksum is not that of its bytes".into(), AGAIN);
        }
        let (trees, words) = content[size_of::<Header>()..].split_at(header.trees as usize * size_of::<TreeData>());
        let trees: Vec<TreeData> = bytemuck::pod_collect_to_vec(trees);
        match plan(&header).filter(|plan| stays_inside(plan, &trees, words)) {
            Some(plan) => Ok(Self { plan, scene: header.scene, counts: header.counts, trees, words }),
            None => wrong("damaged: it says what no bake comes to".into(), AGAIN),
        }
    }
}

/// Returns the plan in a header, or `None` if no bake can have these values.
fn plan(header: &Header) -> Option<Plan> {
    let structure = Structure::ALL.iter().map(|(_, s)| *s).find(|s| *s as u32 == header.structure)?;
    let free = Free::ALL.iter().map(|(_, f)| *f).find(|f| *f as u32 == header.free)?;
    let coverage = Coverage::ALL.iter().map(|(_, c)| *c).find(|c| *c as u32 == header.coverage)?;
    let is_size = header.size.is_power_of_two() && (64..=65536).contains(&header.size);
    let (size, closed) = (header.size, header.closed == 1);
    let is_right = is_size && header.closed <= 1 && header.padding == 0;
    is_right.then_some(Plan { size, structure, closed, free, coverage, ..Plan::of(&Settings::default()) })
}

/// Returns a hash of everything about the meshes and lights that a bake depends on: 64-bit FNV-1a of their shapes.
pub fn scene_hash(meshes: &[Mesh], lights: &[Light]) -> u64 {
    let mut hash = FnvHasher::default();
    let mut numbers = vec![meshes.len() as u64, lights.len() as u64];
    for mesh in meshes {
        numbers.extend([mesh.positions.len() as u64, mesh.triangles.len() as u64, mesh.solid.into()]);
    }
    for light in lights {
        let (kind, place, way, width) = match light.kind {
            LightKind::Directional { direction } => (0, DVec3::ZERO, direction, 0.0),
            LightKind::Spot { position, direction, cone_degrees } => (1, position, direction, cone_degrees),
            LightKind::Point { position } | LightKind::Virtual { position, .. } => (2, position, DVec3::ZERO, 0.0),
        };
        numbers.push(kind);
        numbers
            .extend(place.to_array().into_iter().chain(way.to_array()).chain([width, light.radius]).map(f64::to_bits));
    }
    hash.write(bytemuck::cast_slice(&numbers));
    for mesh in meshes {
        hash.write(bytemuck::cast_slice(&mesh.positions));
        hash.write(bytemuck::cast_slice(&mesh.triangles));
    }
    hash.finish()
}
