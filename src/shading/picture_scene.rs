//! Contents of a picture: the buffers and counts of the world, and the camera's buffer.

use crate::gpu::{Bindings, Buffer, Constants, Context, Memory};
use crate::scene::View;
use crate::shaders::set;
use crate::world::World;
use crate::{Error, Result};

/// Buffers that the passes of a picture read, and how much of them is in use.
pub(super) struct PictureScene {
    /// All of these buffers: set 0 of most passes.
    pub set: Bindings,
    pub lights: Buffer,
    pub casters: Buffer,
    pub triangles: Buffer,
    pub splats: Buffer,
    pub camera: Buffer,
    /// The world's constants.
    pub constants: Constants,
    /// Whether any triangle may have alpha.
    pub has_alpha: bool,
    pub light_count: u32,
    pub triangle_vertices: u32,
    /// Number of casters in the world, including the cells of volumes.
    pub caster_count: u32,
}

/// Kinds of casters that may occur, for which shaders are specialized.
#[derive(Clone, Copy)]
pub(super) struct CasterKinds {
    /// See [`crate::scene::Scene::extinction_ratio`].
    pub extinction_ratio: [f32; 3],
    /// If the buffer stores casters once per color ([`World::colors`]), how many fit per color; otherwise 0.
    pub room_per_color: u32,
    pub has_strands: bool,
    /// Whether there may be splats or cells of volumes.
    pub has_splats_or_cells: bool,
    /// Whether there may be see-through triangles.
    pub has_sheets: bool,
    /// See [`World::alpha_first`].
    pub alpha_first: u32,
}

/// Returns the words of the buffer `Splats` of glsl/shading/picture_set.glsl: the index of the first splat, sheet or cell among the
/// casters, then the color of each.
///
/// # Errors
/// [`Error::Refused`] if the host knows no scene.
pub(super) fn splat_colors(world: &World) -> Result<Vec<u32>> {
    if !has_colors(world) {
        return Ok(vec![0; 4]);
    }
    let needs = "a scene that the host knows, for the colors of splats and volumes in a picture: draw these otherwise";
    let scene = world.scene().map_err(|_| Error::Refused(needs.into()))?;
    let first = (scene.particles.len() + scene.strands.len()) as u32;
    let splats = scene.splats.iter().map(|g| g.color);
    let glass = scene.meshes.iter().filter(|mesh| mesh.is_see_through());
    let sheets = glass.flat_map(|mesh| std::iter::repeat_n(mesh.albedo, mesh.triangles.len()));
    let cells = scene.volumes.iter().flat_map(|v| std::iter::repeat_n(v.placed().color, v.cells().len()));
    Ok(std::iter::once(first)
        .chain(splats.chain(sheets).chain(cells).flat_map(|color| color.map(f32::to_bits)))
        .collect())
}

/// Returns whether there may be casters with colors of their own.
fn has_colors(world: &World) -> bool {
    world.has_splats_or_cells() || world.has_sheets()
}

impl CasterKinds {
    pub fn of(world: &World) -> Self {
        Self {
            extinction_ratio: world.extinction_ratio(),
            room_per_color: if world.colors() > 1 { world.caster_capacity() } else { 0 },
            has_strands: world.has_strands(),
            has_splats_or_cells: world.has_splats_or_cells(),
            has_sheets: world.has_sheets(),
            alpha_first: world.alpha_first(),
        }
    }
}

impl PictureScene {
    /// `order` holds the indices of casters from far to near; `colors` comes from [`splat_colors`].
    pub fn new(context: &Context, world: &World, view: &View, order: &Buffer, colors: &[u32]) -> Result<Self> {
        let camera = Buffer::with_data(context, "picture.camera", &[*view])?;
        // A sequence of files may have more cells at other times, so the buffer is allocated for the maximum.
        let most = match world.scene() {
            Ok(scene) if has_colors(world) => 1 + 3 * (scene.splats.len() + scene.sheet_count() + scene.most_cells()),
            _ => 0,
        };
        let words = colors.len().max(most) as u64;
        let splats = Buffer::new(context, "picture.splats", 4 * words, Memory::Device)?;
        splats.write(colors)?;
        let set = set::PictureScene {
            lights: &world.lights,
            camera: &camera,
            triangles: &world.triangles,
            casters: &world.casters,
            order,
            sides: &world.sides,
            splats: &splats,
        };
        Ok(Self {
            set: set.bind(context, "picture.scene")?,
            lights: world.lights.clone(),
            casters: world.casters.clone(),
            triangles: world.triangles.clone(),
            splats,
            camera,
            constants: world.constants(),
            has_alpha: world.has_alpha(),
            light_count: world.light_count(),
            triangle_vertices: 3 * world.triangle_count(),
            caster_count: world.caster_count(),
        })
    }

    /// Updates colors and counts from the current world.
    pub fn look(&mut self, world: &World) -> Result<()> {
        if has_colors(world) {
            self.splats.write(&splat_colors(world)?)?;
        }
        (self.light_count, self.caster_count) = (world.light_count(), world.caster_count());
        self.triangle_vertices = 3 * world.triangle_count();
        Ok(())
    }
}
