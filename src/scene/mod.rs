//! Scenes: casters, lights and the camera. This module does not depend on Vulkan.

// Files and built-in scenes.
#[cfg(feature = "program")]
pub(crate) mod built_in;
#[cfg(feature = "program")]
mod files;
mod model;

#[cfg(feature = "program")]
pub(crate) use built_in::emitters::Smoke;
#[cfg(feature = "program")]
pub(crate) use built_in::fountain_steps;
#[cfg(feature = "program")]
pub(crate) use files::load::open;
pub use model::field::Field;
#[cfg(feature = "program")]
pub(crate) use model::field::trilinear;
pub(crate) use model::field::{CORNERS, SIDE};
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

// For the program and the tests.
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

/// A sphere of constant extinction: a caster that lets some light pass.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    /// Centre, world units.
    pub position: [f32; 3],
    /// Radius, world units, > 0.
    pub radius: f32,
    /// Extinction σ, 1 / world unit, ≥ 0 and finite.
    pub extinction: f32,
}

/// A straight piece of a hair: a ribbon that faces every ray, `2 · radius` wide, and has no thickness along the ray. A ray that passes its
/// axis within the radius loses `opacity` of its light in one step, at the point of the axis that is nearest to the ray. That point must be
/// the start, or lie between start and end; the end does not count, so that a joint of two strands counts once. A ray along the axis
/// misses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strand {
    /// World units.
    pub start: [f32; 3],
    /// Half the ribbon's width, world units, > 0.
    pub radius: f32,
    /// World units, not `start`.
    pub end: [f32; 3],
    /// In [0, 1]; the optical depth is −ln(1 − opacity), at most [`MAX_OPTICAL_DEPTH`].
    pub opacity: f32,
}

/// An opaque triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// For messages and labels.
    pub name: String,
    /// Vertices, world units.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Diffuse reflectance in [0, 1].
    pub albedo: [f32; 3],
    /// Whether the mesh's back is never seen, like that of a ground. Techniques are not asked for light behind its front faces
    /// (counter-clockwise).
    pub solid: bool,
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World units.
    pub position: DVec3,
    /// A point in the middle of the picture.
    pub target: DVec3,
    /// Up, any length.
    pub up: DVec3,
    /// Full vertical field of view, degrees.
    pub fov_y_degrees: f64,
}

impl Camera {
    /// The camera after turning around its target, about its up, by `degrees`.
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
    /// Opaque triangles.
    pub meshes: bool,
}

/// All casters, lights and the camera at one time, on the host. A [`crate::world::World`] can be made from a scene. The default has no
/// casters, one directional light straight down, and a camera that looks at the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The name shown in tables and file names.
    pub name: String,
    /// Translucent casters.
    pub particles: Vec<Particle>,
    /// Hair: translucent casters too.
    pub strands: Vec<Strand>,
    /// Splats: translucent casters too.
    pub splats: Vec<Splat>,
    /// Grids of densities: translucent casters too.
    pub volumes: Vec<Volume>,
    /// Opaque casters and receivers.
    pub meshes: Vec<Mesh>,
    /// At least one.
    pub lights: Vec<Light>,
    /// The camera.
    pub camera: Camera,
    /// Factors of the casters' extinction for red, green and blue light: finite, ≥ 0, not all 0. So a color's transmittance is the grey one
    /// to the power of its factor. Meshes block all colors alike.
    pub extinction_ratio: [f32; 3],
    /// Where casters have different ratios, their ratios in place of [`Scene::extinction_ratio`], which is then [`Scene::GREY`]; the lights
    /// stand three times ([`Scene::with_inks`]). Else empty.
    pub inks: Vec<ExtinctionGroup>,
    /// What the scene has at most, where this is its state at one of several times.
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

/// The greatest optical depth across a particle's diameter. It stands for an `opacity` of 1, whose optical depth −ln(1 − opacity) would be
/// infinite. exp(−80) is the smallest transmittance that techniques can tell from 0.
#[doc(hidden)]
pub const MAX_OPTICAL_DEPTH: f32 = 80.0;

impl Scene {
    /// The extinction ratio of casters that absorb all colors equally.
    pub const GREY: [f32; 3] = [1.0; 3];

    /// The most casters that the scene has at once, over all times.
    pub fn most_casters(&self) -> usize {
        self.particles.len().max(self.reserve.particles) + self.strands.len() + self.splats.len() + self.most_cells()
    }

    /// The most cells of volumes that the scene has at once, over all times.
    pub(crate) fn most_cells(&self) -> usize {
        self.cell_count().max(self.reserve.cells)
    }

    /// The most blocks that each volume's field has, over all times.
    pub(crate) fn most_blocks(&self) -> Vec<usize> {
        let reserved = self.reserve.blocks.iter().copied().chain(std::iter::repeat(0));
        let blocks = self.volumes.iter().map(|volume| volume.field().blocks().len());
        blocks.zip(reserved).map(|(now, most)| now.max(most)).collect()
    }

    /// Whether anything is opaque.
    pub fn has_triangles(&self) -> bool {
        self.meshes.iter().any(|mesh| !mesh.triangles.is_empty())
    }

    /// The kinds of casters in the scene.
    pub fn kinds(&self) -> Kinds {
        Kinds {
            particles: !self.particles.is_empty(),
            strands: !self.strands.is_empty(),
            splats: !self.splats.is_empty(),
            volumes: !self.volumes.is_empty(),
            meshes: !self.meshes.is_empty(),
        }
    }

    /// The number of maps of all lights together.
    pub fn map_count(&self) -> usize {
        self.first_map(self.lights.len())
    }

    /// The number of the first map of light `light`, counted over the maps of all lights in order.
    pub fn first_map(&self, light: usize) -> usize {
        self.lights.iter().take(light).map(Light::map_count).sum()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A scene of spheres (z, radius, extinction) on the z axis, under a light that shines down along it.
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

    /// A map with a single texel, whose ray goes from z = 2 to −2, and spheres on that ray as in [`on_the_axis`].
    #[cfg(feature = "program")]
    pub(crate) fn along_the_axis(spheres: &[(f32, f32, f32)]) -> (View, Vec<Caster>) {
        let held = on_the_axis(&[(-1.0, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        (View::volumes(&held, 1)[0], on_the_axis(spheres).casters())
    }

    /// A mesh that is not solid, with the given vertices and triangles.
    pub(crate) fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
        Mesh { name: "test".into(), positions, triangles, albedo: [0.5; 3], solid: false }
    }

    /// The sides of a cube, counter-clockwise from outside; bit 0 of a corner's number is x, bit 1 y, bit 2 z.
    pub(crate) const CUBE: [[u32; 4]; 6] =
        [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6], [4, 5, 7, 6], [0, 2, 3, 1]];

    /// A closed cube, by its lowest corner and side.
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
