//! What casts shadows, the light and the camera. Knows nothing of Vulkan.

mod cube;
mod emitters;
mod file;
mod input;
mod mesh_file;
mod particle_file;
mod picture;
mod ply;
mod view;

pub use picture::Picture;
pub use view::{Projection, Ray, View};

use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

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

/// An opaque triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// For messages and labels.
    pub name: String,
    /// Vertices, world units.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Diffuse reflectance in [0, 1].
    pub albedo: [f32; 3],
}

/// Where a light stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional {
        /// The way the light travels, unit length.
        direction: DVec3,
    },
    /// A cone.
    Spot {
        /// World units.
        position: DVec3,
        /// The axis, unit length.
        direction: DVec3,
        /// Full opening angle, degrees, in (0, 170].
        cone_degrees: f64,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it stands.
    pub kind: LightKind,
    /// Radiance scale, linear RGB; 1 lights a white surface fully.
    pub radiance: [f32; 3],
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

/// Everything a technique needs to know of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The name shown in tables and file names.
    pub name: String,
    /// Translucent casters.
    pub particles: Vec<Particle>,
    /// Opaque casters and receivers.
    pub meshes: Vec<Mesh>,
    /// The light.
    pub light: Light,
    /// The camera.
    pub camera: Camera,
}

/// The optical depth across the diameter of a particle whose file says `opacity` 1, where the formula has none.
/// exp(−80) is the smallest transmittance that the techniques tell from none.
pub const MAX_OPTICAL_DEPTH: f32 = 80.0;

/// Names that [`Scene::load`] knows without a file.
pub const BUILT_IN: [&str; 2] = ["three-emitters", "big-8k"];

impl Scene {
    /// Loads a scene file (`*.toml`) or makes a built-in scene. `time_s` is how long the emitters of `three-emitters`
    /// have been running, in seconds; other scenes stand still and ignore it.
    ///
    /// # Errors
    /// [`Error::Input`] names the file and what is wrong with it.
    pub fn load(name: &str, time_s: f64) -> Result<Self> {
        match name {
            "three-emitters" => emitters::three_emitters(time_s),
            "big-8k" => Ok(cube::big_8k()),
            path if path.ends_with(".toml") => file::load(path.as_ref()),
            _ => Err(Error::input(
                name,
                "no such scene",
                format!("give a scene file (*.toml) or one of {}", BUILT_IN.join(", ")),
            )),
        }
    }
}
