//! Alpha of triangles on the device. It is stored behind the triangles, in the same buffer, so that no shader needs another binding and no
//! device an array of textures. Layout: glsl/world/alpha.glsl; levels behind a texture: glsl/maps/alpha_level.glsl.

use super::TriangleData;
use crate::scene::{Alpha, AlphaLevel, AlphaMode, AlphaTexture, Mesh, Wrap, alpha_levels};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Words per triangle, and per record. Twin: ALPHA_WORDS.
pub(super) const WORDS: usize = size_of::<TriangleData>() / 4;

/// The cutoff of see-through triangles. Twin: ALPHA_SEE_THROUGH.
const SEE_THROUGH: f32 = 2.0;

/// Alpha of a triangle. Twin: Alpha in glsl/world/alpha.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct Record {
    pub uvs: [[f32; 2]; 3],
    pub factors: [f32; 3],
    pub cutoff: f32,
    /// Word of the buffer that holds the texture's first texels; 0 without a texture.
    pub texels: u32,
    /// See [`packed_size`].
    pub size: u32,
}

const _: () = assert!(size_of::<Record>() == 4 * WORDS);

/// Returns the size of a texture and how it continues, in one word. Twin: Alpha::size in glsl/world/alpha.glsl.
pub(super) fn packed_size(size: [u32; 2], wrap: [Wrap; 2]) -> u32 {
    let code = |wrap: Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let [width, height] = size.map(|side| side.clamp(1, AlphaTexture::MOST_SIDE) - 1);
    let [across, down] = wrap.map(code);
    width | height << 14 | across << 28 | down << 30
}

/// Returns the number of words behind `capacity` triangles that all have alpha, with room for `texels` texels.
pub(super) fn room(capacity: u32, texels: u32) -> u64 {
    let capacity = u64::from(capacity);
    let records = capacity.next_multiple_of(WORDS as u64) + WORDS as u64 * capacity;
    (records + u64::from(texels).div_ceil(4)).next_multiple_of(WORDS as u64)
}

/// Checks that the alpha of all meshes is as [`Alpha`] says.
///
/// # Errors
/// [`Error::Input`], which names the mesh, if it is not.
pub(super) fn check(meshes: &[Mesh]) -> Result<()> {
    for mesh in meshes {
        if let Some(cause) = mesh.alpha.as_ref().and_then(|alpha| fault(alpha, mesh.positions.len())) {
            return Err(Error::input(format!("mesh {}", mesh.name), cause, "give alpha as scene::Alpha says"));
        }
    }
    Ok(())
}

/// Returns what is wrong with the alpha of a mesh of `vertices` vertices, if anything.
fn fault(alpha: &Alpha, vertices: usize) -> Option<String> {
    let Alpha { mode, factors, uvs, texture, extinction_ratio } = alpha;
    if let AlphaMode::Cut(cutoff) = mode
        && !(*cutoff > 0.0 && *cutoff <= 1.0)
    {
        return Some(format!("a cutoff of {cutoff}"));
    }
    let most = extinction_ratio.iter().copied().fold(0.0, f32::max);
    if !extinction_ratio.iter().all(|factor| (0.0..=1.0).contains(factor)) || most == 0.0 {
        return Some(format!("extinctions {extinction_ratio:?} that are not from 0 to 1, or are all 0"));
    }
    let texels = texture.as_ref().map(|texture| (texture.size, texture.texels.len()));
    let is_whole = |([width, height], texels): ([u32; 2], usize)| {
        let sides = 1..=AlphaTexture::MOST_SIDE;
        sides.contains(&width) && sides.contains(&height) && texels == width as usize * height as usize
    };
    if factors.len() != vertices || !factors.iter().all(|factor| (0.0..=1.0).contains(factor)) {
        Some(format!("{} factors in [0, 1] for {vertices} vertices", factors.len()))
    } else if texels.is_some() && (uvs.len() != vertices || !uvs.as_flattened().iter().all(|at| at.is_finite())) {
        Some(format!("{} finite places in a texture for {vertices} vertices", uvs.len()))
    } else {
        let ([width, height], texels) = texels.filter(|texture| !is_whole(*texture))?;
        Some(format!("a texture of {width} × {height} texels that has {texels}"))
    }
}

/// Returns whether any mesh has alpha.
pub(super) fn is_any(meshes: &[Mesh]) -> bool {
    meshes.iter().any(|mesh| mesh.alpha.is_some())
}

/// Returns whether two lists of as many triangles have the same alpha, triangle by triangle.
pub(super) fn is_alike(are: &[Mesh], were: &[Mesh]) -> bool {
    let same = |(is, was): (&Mesh, &Mesh)| {
        let as_many = is.triangles.len() == was.triangles.len() && is.alpha == was.alpha;
        as_many && (is.alpha.is_none() || is.triangles == was.triangles)
    };
    !is_any(are) && !is_any(were) || are.len() == were.len() && are.iter().zip(were).all(same)
}

/// Returns the words that are stored behind the triangles of these meshes.
pub(super) fn words(meshes: &[Mesh]) -> Vec<u32> {
    let count: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let with_alpha = |mesh: &&Mesh| mesh.alpha.is_some();
    let records: usize = meshes.iter().filter(with_alpha).map(|mesh| mesh.triangles.len()).sum();
    let mut numbers = vec![0_u32; count.next_multiple_of(WORDS)];
    let mut all: Vec<Record> = Vec::with_capacity(records);
    let mut textures: Vec<(Arc<AlphaTexture>, f32, u32)> = Vec::new();
    let mut texels: Vec<u32> = Vec::new();
    let first_texels = WORDS * (count + records) + numbers.len();
    let mut first = 0;
    for mesh in meshes {
        if let Some(alpha) = &mesh.alpha {
            let at = alpha.texture.as_ref().map_or(0, |texture| {
                // The levels of a texture depend on the cutoff.
                let cutoff = cutoff(alpha.mode);
                let same =
                    |(other, of, _): &&(Arc<AlphaTexture>, f32, u32)| Arc::ptr_eq(other, texture) && *of == cutoff;
                let known = textures.iter().find(same).map(|(.., at)| *at);
                known.unwrap_or_else(|| {
                    let at = (first_texels + texels.len()) as u32;
                    textures.push((texture.clone(), cutoff, at));
                    texels.extend(words_of(&texture.texels));
                    if let AlphaMode::Cut(cutoff) = alpha.mode {
                        push_levels(&mut texels, first_texels, &alpha_levels(texture, cutoff));
                    }
                    at
                })
            });
            for (number, triangle) in numbers.iter_mut().skip(first).zip(&mesh.triangles) {
                all.push(record(alpha, *triangle, at));
                *number = all.len() as u32;
            }
        }
        first += mesh.triangles.len();
    }
    numbers.extend_from_slice(bytemuck::cast_slice(&all));
    numbers.extend(texels);
    numbers.resize(numbers.len().next_multiple_of(WORDS), 0);
    numbers
}

/// Returns texels, four in a word.
fn words_of(texels: &[u8]) -> impl Iterator<Item = u32> + '_ {
    texels.chunks(4).map(|bytes| bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte)))
}

/// Appends the levels of a texture whose first words were stored at `first`: for each the word of its texels and its threshold, then the
/// texels of all.
fn push_levels(words: &mut Vec<u32>, first: usize, levels: &[AlphaLevel]) {
    let heads = words.len();
    words.resize(heads + 2 * levels.len(), 0);
    for (number, level) in levels.iter().enumerate() {
        words[heads + 2 * number] = (first + words.len()) as u32;
        words[heads + 2 * number + 1] = level.threshold.to_bits();
        words.extend(words_of(&level.shares.texels));
    }
}

/// Returns the cutoff as it is stored.
pub(super) fn cutoff(mode: AlphaMode) -> f32 {
    match mode {
        AlphaMode::Cut(cutoff) => cutoff,
        AlphaMode::SeeThrough => SEE_THROUGH,
    }
}

fn record(alpha: &Alpha, triangle: [u32; 3], texels: u32) -> Record {
    let at = |i: u32| i as usize;
    Record {
        uvs: triangle.map(|i| alpha.uvs.get(at(i)).copied().unwrap_or_default()),
        factors: triangle.map(|i| alpha.factors.get(at(i)).copied().unwrap_or(1.0)),
        cutoff: cutoff(alpha.mode),
        texels,
        size: alpha.texture.as_deref().map_or(0, |texture| packed_size(texture.size, texture.wrap)),
    }
}
