//! The content of files before it becomes a scene.

use crate::Result;
use crate::scene::files::default_view;
use crate::scene::files::gltf_motion::Motion;
use crate::scene::{Animation, Camera, Light, Mesh, Particle, Scene, Splat, Strand, Volume, model::view};
use glam::DVec3;

/// The content of one or more files, with lights and a camera if the files have them.
#[derive(Default)]
pub(in crate::scene) struct Contents {
    pub particles: Vec<Particle>,
    pub strands: Vec<Strand>,
    pub splats: Vec<Splat>,
    pub volumes: Vec<Volume>,
    pub meshes: Vec<Mesh>,
    pub lights: Vec<Light>,
    pub camera: Option<Camera>,
    /// What moves meshes.
    pub motions: Vec<Motion>,
    /// What the files have that is left out, one line per file and kind.
    pub notes: Vec<String>,
}

/// A loaded scene.
pub(crate) struct Loaded {
    pub scene: Scene,
    /// The sequences of files that the scene shows, if any.
    pub sequences: Option<Animation>,
    /// What its files have that is left out, one line per file and kind.
    pub notes: Vec<String>,
}

impl From<Scene> for Loaded {
    fn from(scene: Scene) -> Self {
        Self { scene, sequences: None, notes: Vec::new() }
    }
}

impl Contents {
    /// Returns spheres (centre, radius) whose convex hull contains everything.
    pub(in crate::scene) fn spheres(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let casters = view::caster_spheres(&self.particles, &self.strands, &self.splats, &self.volumes, &[]);
        view::mesh_points(&self.meshes).chain(casters)
    }

    /// Returns the corners of the box around everything; `None` if there is nothing.
    pub(in crate::scene) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let boxes = self.spheres().map(|(centre, radius)| (centre - radius, centre + radius));
        boxes.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))
    }

    /// Returns the camera that sees everything, wherever meshes move; the inner error says what is wrong.
    pub(in crate::scene) fn fitted_camera(&mut self, up: DVec3) -> Result<std::result::Result<Camera, String>> {
        let at_rest = self.meshes.len();
        let moved = self.motions.iter().map(|motion| motion.some(&self.meshes)).collect::<Result<Vec<_>>>()?;
        self.meshes.extend(moved.into_iter().flatten());
        let camera = default_view::camera(self, up);
        self.meshes.truncate(at_rest);
        Ok(camera)
    }

    /// Creates the scene with all contents, the given lights and the given camera.
    pub(in crate::scene) fn scene(self, name: String, lights: Vec<Light>, camera: Camera) -> Scene {
        let Self { particles, strands, splats, volumes, meshes, .. } = self;
        Scene { name, particles, strands, splats, volumes, meshes, lights, camera, ..Scene::default() }
    }
}
