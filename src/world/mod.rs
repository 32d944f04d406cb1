//! The scene on the device as it is now: casters, triangles, lights, and a generation that says whether anything moved.

mod light;

pub use light::LightData;

use crate::gpu::{Buffer, Context};
use crate::scene::{Caster, Scene};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Twin: Triangle in glsl/world/triangle.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleData {
    /// World units.
    pub corners: [[f32; 3]; 3],
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
}

/// What casts and what shines, on the device. All techniques of a scene share it.
pub struct World {
    scene: Scene,
    generation: u64,
    /// [`Caster`]: spheres, then strands; [`World::caster_count`] of them.
    pub casters: Buffer,
    caster_capacity: u32,
    /// [`TriangleData`].
    pub triangles: Buffer,
    triangle_count: u32,
    /// Whether it began with strands: without, kernels are compiled for spheres alone.
    strands: bool,
    /// [`LightData`].
    pub lights: Buffer,
}

impl World {
    /// Uploads `scene`.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self> {
        let (casters, triangles) = (scene.casters(), triangles(scene));
        Ok(Self {
            casters: Buffer::with_data(context, "world.casters", &casters)?,
            caster_capacity: casters.len() as u32,
            triangles: Buffer::with_data(context, "world.triangles", &triangles)?,
            triangle_count: triangles.len() as u32,
            strands: !scene.strands.is_empty(),
            lights: Buffer::with_data(context, "world.lights", &LightData::all(scene))?,
            scene: scene.clone(),
            generation: 0,
        })
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Rises whenever anything has moved.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Casters as they are now.
    pub fn caster_count(&self) -> u32 {
        (self.scene.particles.len() + self.scene.strands.len()) as u32
    }

    /// Whether there may be strands: whether the scene began with some.
    pub fn has_strands(&self) -> bool {
        self.strands
    }

    /// Casters that there is room for: as many as the scene began with.
    pub fn caster_capacity(&self) -> u32 {
        self.caster_capacity
    }

    /// Triangles of all meshes.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Puts another state of the same scene in its place: particles, strands and lights may have moved and changed.
    ///
    /// # Errors
    /// [`Error::Input`] where there are more casters than the scene began with, strands where it began with none, or lights or
    /// meshes of another number, or a point light for another, for which everything has to be opened anew; [`Error::Gpu`] where a copy fails.
    pub fn replace(&mut self, scene: &Scene) -> Result<()> {
        let (casters, triangles) = (scene.casters(), triangles(scene));
        let maps = |s: &Scene| s.lights.iter().map(crate::scene::Light::map_count).collect::<Vec<_>>();
        let cause = if casters.len() > self.caster_capacity as usize {
            format!("{} casters, and the world has room for {}", casters.len(), self.caster_capacity)
        } else if !scene.strands.is_empty() && !self.strands {
            "it has strands, and the world was made without".into()
        } else if triangles.len() != self.triangle_count as usize || maps(scene) != maps(&self.scene) {
            "meshes or lights are others than those that the world was made for".into()
        } else {
            // First: where a copy fails, what is on the device is of neither scene.
            self.generation += 1;
            self.casters.write(&casters)?;
            self.triangles.write(&triangles)?;
            self.lights.write(&LightData::all(scene))?;
            self.scene.clone_from(scene);
            return Ok(());
        };
        Err(Error::input(scene.name.clone(), cause, "make a new world, and open its techniques anew"))
    }
}

fn triangles(scene: &Scene) -> Vec<TriangleData> {
    let corner = |positions: &[[f32; 3]], i: u32| positions.get(i as usize).copied().unwrap_or_default();
    let of_mesh = |m: &crate::scene::Mesh| -> Vec<TriangleData> {
        let triangle = |t: &[u32; 3]| TriangleData { corners: t.map(|i| corner(&m.positions, i)), albedo: m.albedo };
        m.triangles.iter().map(triangle).collect()
    };
    scene.meshes.iter().flat_map(of_mesh).collect()
}

// The device has them as the host does.
const _: () = assert!(size_of::<Caster>() == 32);
