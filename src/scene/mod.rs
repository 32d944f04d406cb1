//! Scenes: casters, lights and the camera. This module does not depend on Vulkan.

// Scene files and built-in scenes.
#[cfg(feature = "program")]
pub(crate) mod built_in;
#[cfg(feature = "program")]
mod files;
mod model;

#[cfg(feature = "program")]
pub(crate) use built_in::emitters::Smoke;
#[cfg(feature = "program")]
pub(crate) use built_in::fountain_steps;
#[cfg(feature = "view")]
pub(crate) use files::up::name as axis_name;
#[cfg(feature = "program")]
pub(crate) use files::{contents::Loaded, load::open, up::parse as axis};
pub use model::alpha::{Alpha, AlphaMode, AlphaTexture, Wrap};
pub(crate) use model::alpha_levels::{AlphaLevel, alpha_levels};
pub use model::field::Field;
pub(crate) use model::field::{CORNERS, SIDE};
#[cfg(feature = "program")]
pub(crate) use model::field::{FieldBuilder, trilinear};
pub use model::fog::Fog;
pub use model::light::{Light, LightKind};
pub use model::picture::Picture;
#[cfg(feature = "program")]
pub(crate) use model::random::Random;
pub use model::reserve::{ParticleBox, Reserve};
pub use model::show::Show;
pub use model::splat::Splat;
#[cfg(feature = "program")]
pub(crate) use model::splat::{REACH, Shape};
pub use model::view::View;
pub use model::volume::{Placed, Volume};
#[cfg(feature = "program")]
pub(crate) use model::voxels::Facet;

// Used by the program and the tests.
#[cfg(feature = "program")]
#[doc(hidden)]
pub use self::{
    built_in::fountain_law::{Fountain, Jet, Law, MOST_GRAVITY},
    built_in::{number_of, with_number},
    files::animation::Animation,
    files::data_file::DATA_ENDINGS,
    files::load::{BUILT_IN, known},
    model::change::SceneChange,
    model::order::{Order, far_to_near},
    model::time::check_time,
    model::voxels::{Bits, Place},
};
#[doc(hidden)]
pub use self::{
    model::backdrop::Backdrop,
    model::body::Body,
    model::caster::Caster,
    model::extinction_group::ExtinctionGroup,
    model::field::{MOST_BLOCKS, MOST_SIDE},
    model::fit::{Aim, Casting, gutter_texels},
    model::light::FACES,
    model::order::{Blended, blended, volumes_among},
    model::picture::SKY,
    model::resolution::{Moved, Resolution},
    model::sides::{Side, sides},
    model::smooth::smooth_normals,
    model::view::{FARTHEST, Projection, Ray},
    model::volume::MOST_CELLS,
};

use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec3};

/// A sphere of constant extinction: a translucent caster.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    /// Centre, in world units.
    pub position: [f32; 3],
    /// Radius in world units, > 0.
    pub radius: f32,
    /// Extinction σ, 1 / world unit, ≥ 0 and finite.
    pub extinction: f32,
}

/// A straight piece of a hair: a ribbon, `2 · radius` wide and infinitely thin, that faces every ray. A ray that passes within the radius
/// of the axis loses `opacity` of its light in one step, at the axis point nearest to the ray. That point must be the start, or lie between
/// start and end. The end itself is excluded, so that a joint between two strands counts once. A ray parallel to the axis misses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strand {
    /// Start point, in world units.
    pub start: [f32; 3],
    /// Half the ribbon's width in world units, > 0.
    pub radius: f32,
    /// End point in world units, different from `start`.
    pub end: [f32; 3],
    /// Opacity in [0, 1]; the optical depth is −ln(1 − opacity), at most [`MAX_OPTICAL_DEPTH`].
    pub opacity: f32,
}

/// A triangle mesh: opaque, or with alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Name used in messages and labels.
    pub name: String,
    /// Vertex positions, in world units.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Diffuse reflectance in [0, 1].
    pub albedo: [f32; 3],
    /// Whether the mesh's back is never seen, as for a ground. Techniques are not queried for light behind its front faces
    /// (counter-clockwise).
    pub solid: bool,
    /// Holes, or glass. None: the mesh blocks all light.
    pub alpha: Option<Alpha>,
}

impl Mesh {
    /// Returns whether light passes through the mesh, in part.
    pub fn is_see_through(&self) -> bool {
        self.alpha.as_ref().is_some_and(|alpha| alpha.mode == AlphaMode::SeeThrough)
    }
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position, in world units.
    pub position: DVec3,
    /// The point at the centre of the picture.
    pub target: DVec3,
    /// Up vector, of any length.
    pub up: DVec3,
    /// Full vertical field of view, in degrees.
    pub fov_y_degrees: f64,
}

impl Camera {
    /// Returns the camera rotated by `degrees` around its target, about its up vector.
    pub fn turned(mut self, degrees: f64) -> Self {
        let way = DQuat::from_axis_angle(self.up.normalize(), degrees.to_radians());
        self.position = self.target + way * (self.position - self.target);
        self
    }
}

/// Kinds of casters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kinds {
    /// Spheres of smoke.
    pub particles: bool,
    /// Hair.
    pub strands: bool,
    /// Splats.
    pub splats: bool,
    /// Grids of densities.
    pub volumes: bool,
    /// Opaque triangles, some perhaps with holes.
    pub meshes: bool,
    /// See-through triangles ([`AlphaMode::SeeThrough`]).
    pub see_through: bool,
}

/// All casters, lights and the camera at one time, on the host; a [`crate::world::World`] can be created from it. The default scene has no
/// casters, one directional light pointing straight down, and a camera that looks at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name shown in tables and used in file names.
    pub name: String,
    /// Translucent casters.
    pub particles: Vec<Particle>,
    /// Hair; its strands are translucent casters.
    pub strands: Vec<Strand>,
    /// Splats, also translucent casters.
    pub splats: Vec<Splat>,
    /// Grids of densities, also translucent casters.
    pub volumes: Vec<Volume>,
    /// Opaque casters and receivers.
    pub meshes: Vec<Mesh>,
    /// Lights, at least one.
    pub lights: Vec<Light>,
    /// The camera.
    pub camera: Camera,
    /// Factors of the casters' extinction for red, green and blue light: finite, ≥ 0, not all 0. A color's transmittance is thus the grey
    /// transmittance raised to the power of its factor. Meshes block all colors alike.
    pub extinction_ratio: [f32; 3],
    /// Per-group ratios, if casters have different ones. They replace [`Scene::extinction_ratio`], which is then [`Scene::GREY`], and each
    /// light is listed three times ([`Scene::with_inks`]). Otherwise empty.
    pub inks: Vec<ExtinctionGroup>,
    /// Upper bounds over all times, if this scene is one state of an animation.
    pub reserve: Reserve,
}

impl Default for Scene {
    fn default() -> Self {
        let kind = LightKind::Directional { direction: DVec3::NEG_Z };
        Self {
            name: String::new(),
            particles: Vec::new(),
            strands: Vec::new(),
            splats: Vec::new(),
            volumes: Vec::new(),
            meshes: Vec::new(),
            lights: vec![Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }],
            camera: Camera {
                position: DVec3::new(4.0, -4.0, 3.0),
                target: DVec3::ZERO,
                up: DVec3::Z,
                fov_y_degrees: 40.0,
            },
            extinction_ratio: Self::GREY,
            inks: Vec::new(),
            reserve: Reserve::default(),
        }
    }
}

/// The maximum optical depth across a particle's diameter. It also replaces the infinite optical depth −ln(1 − opacity) of an `opacity` of
/// 1. exp(−80) is the smallest transmittance that techniques can tell from 0.
#[doc(hidden)]
pub const MAX_OPTICAL_DEPTH: f32 = 80.0;

impl Scene {
    /// The extinction ratio of casters that absorb all colors equally.
    pub const GREY: [f32; 3] = [1.0; 3];

    /// Returns the largest number of casters that the scene has at any time.
    pub fn most_casters(&self) -> usize {
        self.particles.len().max(self.reserve.particles) + self.first_cell() - self.particles.len() + self.most_cells()
    }

    /// Returns the largest number of volume cells that the scene has at any time.
    pub(crate) fn most_cells(&self) -> usize {
        self.cell_count().max(self.reserve.cells)
    }

    /// Returns the largest number of blocks that each volume's field has at any time.
    pub(crate) fn most_blocks(&self) -> Vec<usize> {
        let reserved = self.reserve.blocks.iter().copied().chain(std::iter::repeat(0));
        let blocks = self.volumes.iter().map(|volume| volume.field().blocks().len());
        blocks.zip(reserved).map(|(now, most)| now.max(most)).collect()
    }

    /// Returns whether the scene contains any opaque geometry.
    pub fn has_triangles(&self) -> bool {
        self.meshes.iter().any(|mesh| !mesh.triangles.is_empty())
    }

    /// Returns the kinds of casters in the scene.
    pub fn kinds(&self) -> Kinds {
        Kinds {
            particles: !self.particles.is_empty(),
            strands: !self.strands.is_empty(),
            splats: !self.splats.is_empty(),
            volumes: !self.volumes.is_empty(),
            meshes: self.meshes.iter().any(|mesh| !mesh.is_see_through()),
            see_through: self.meshes.iter().any(Mesh::is_see_through),
        }
    }

    /// Returns the number of maps of all lights together.
    pub fn map_count(&self) -> usize {
        self.first_map(self.lights.len())
    }

    /// Returns the index of the first map of light `light`, counting the maps of all lights in order.
    pub fn first_map(&self, light: usize) -> usize {
        self.lights.iter().take(light).map(Light::map_count).sum()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Builds a scene of spheres (z, radius, extinction) on the z axis, under a light that shines down along it.
    pub(crate) fn on_the_axis(spheres: &[(f32, f32, f32)]) -> Scene {
        let particle =
            |&(z, radius, extinction): &(f32, f32, f32)| Particle { position: [0.0, 0.0, z], radius, extinction };
        Scene {
            name: "axis".into(),
            particles: spheres.iter().map(particle).collect(),
            camera: Camera { position: DVec3::ONE, target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 },
            ..Scene::default()
        }
    }

    /// Builds a map with a single texel, whose ray runs from z = 2 to −2, and spheres on that ray as in [`on_the_axis`].
    #[cfg(feature = "program")]
    pub(crate) fn along_the_axis(spheres: &[(f32, f32, f32)]) -> (View, Vec<Caster>) {
        let held = on_the_axis(&[(-1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        (View::volumes(&held, 1)[0], on_the_axis(spheres).casters())
    }

    /// Builds a mesh that is not solid, with the given vertices and triangles.
    pub(crate) fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
        Mesh { name: "test".into(), positions, triangles, albedo: [0.5; 3], solid: false, alpha: None }
    }

    /// The faces of a cube, counter-clockwise from outside; bit 0 of a corner's number is x, bit 1 y, bit 2 z.
    pub(crate) const CUBE: [[u32; 4]; 6] =
        [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];

    /// Builds a closed cube from its lowest corner and side length.
    pub(crate) fn cube(low: [f32; 3], side: f32) -> Mesh {
        let corner = |i: u32| [0, 1, 2].map(|axis| low[axis] + if i >> axis & 1 == 1 { side } else { 0.0 });
        let triangles = CUBE.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        mesh((0..8).map(corner).collect(), triangles)
    }

    pub(crate) fn inside_out(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh
    }

    /// Joins two meshes into one.
    pub(crate) fn both(mut a: Mesh, b: Mesh) -> Mesh {
        let first = a.positions.len() as u32;
        a.positions.extend(b.positions);
        a.triangles.extend(b.triangles.iter().map(|t| t.map(|i| first + i)));
        a
    }
}
