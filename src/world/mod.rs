//! The scene on the device as it is now: casters, triangles, lights, and generations that say what of it has changed.

mod bounds;
mod generations;
mod light;

pub use generations::{Generations, Made, Parts};
pub use light::LightData;

use self::bounds::Bounds;

use crate::gpu::{Buffer, Commands, Context, Memory, PassTime};
use crate::scene::{Caster, Particle, Scene, Side, sides};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use std::time::Instant;

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
    context: Context,
    scene: Scene,
    generations: Generations,
    /// The device's casters are others than the host's scene has.
    written: bool,
    /// A copy failed: what is on the device is of neither scene.
    mixed: bool,
    /// The bounds of the meshes, and of smoke and hair as the host knows them.
    bounds: [Bounds; 2],
    /// [`Caster`]: spheres, then strands; [`World::caster_count`] of them.
    pub casters: Buffer,
    caster_capacity: u32,
    /// [`TriangleData`].
    pub triangles: Buffer,
    triangle_count: u32,
    /// Of each triangle, [`Side::sign`](crate::scene::Side::sign): 1 where a ray along its normal leaves a closed thing, −1 where
    /// it enters one, 0 where it belongs to none.
    pub sides: Buffer,
    /// Whether it began with strands: without, kernels are compiled for spheres alone.
    strands: bool,
    /// [`LightData`].
    pub lights: Buffer,
}

/// What moving the world took.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Device time of the pass `world.move`, where the device has timestamps.
    pub pass: Option<PassTime>,
    /// The host's time from the new scene to its copy on the device, nanoseconds: writing, submitting and waiting. What made
    /// the scene is not in it.
    pub host_ns: f64,
}

impl World {
    /// Uploads `scene`.
    ///
    /// # Errors
    /// [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self> {
        let (casters, triangles) = (scene.casters(), triangles(scene));
        let capacity = scene.most_casters();
        let bytes = (capacity * size_of::<Caster>()) as u64;
        let buffer = Buffer::new(context, "world.casters", bytes, Memory::Device)?;
        buffer.write(&casters)?;
        Ok(Self {
            context: context.clone(),
            casters: buffer,
            caster_capacity: capacity as u32,
            triangles: Buffer::with_data(context, "world.triangles", &triangles)?,
            triangle_count: triangles.len() as u32,
            sides: Buffer::with_data(context, "world.sides", &signs(scene))?,
            strands: !scene.strands.is_empty(),
            lights: Buffer::with_data(context, "world.lights", &LightData::all(scene))?,
            generations: Generations { lights: vec![0; scene.lights.len()], ..Generations::default() },
            written: false,
            mixed: false,
            bounds: [Bounds::of_meshes(&scene.meshes), Bounds::of_casters(&casters)],
            scene: scene.clone(),
        })
    }

    /// The scene as it is now; its particles, where the device simulates them, as they were last read back.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Each rises whenever its part has changed.
    pub fn generations(&self) -> &Generations {
        &self.generations
    }

    /// Casters as they are now.
    pub fn caster_count(&self) -> u32 {
        (self.scene.particles.len() + self.scene.strands.len()) as u32
    }

    /// Whether there may be strands: whether the scene began with some.
    pub fn has_strands(&self) -> bool {
        self.strands
    }

    /// Casters that there is room for: as many as the scene has at any time, or began with.
    pub fn caster_capacity(&self) -> u32 {
        self.caster_capacity
    }

    /// Triangles of all meshes.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// Moves what moves by itself to where it is `time_s` seconds after the scene's emitters began. A scene of which nothing
    /// does stays as it is, generations and all.
    ///
    /// # Errors
    /// As [`Scene::at`] and [`World::replace`].
    #[cfg(feature = "program")]
    pub fn move_to(&mut self, time_s: f64) -> Result<Moved> {
        if self.scene.motion == crate::scene::Motion::Still {
            return Ok(Moved { pass: None, host_ns: 0.0 });
        }
        self.replace(&self.scene.at(time_s)?)
    }

    /// Lets passes write the casters, as many as there are, on the device: a world that is simulated there. The host's scene stays
    /// what it was until [`World::read_back`]. Returns the time of each pass.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost.
    pub fn write_casters(&mut self, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        self.written = true;
        self.generations.particles += 1;
        self.generations.strands += u64::from(self.strands);
        self.generations.bounds += 1;
        self.context.submit(record)
    }

    /// Makes the particles of the host's scene those that are on the device.
    ///
    /// # Errors
    /// [`Error::Gpu`] where they cannot be read.
    pub fn read_back(&mut self) -> Result<()> {
        let casters: Vec<Caster> = self.casters.read(self.scene.particles.len())?;
        let particle = |c: &Caster| Particle { position: c.position, radius: c.radius, extinction: c.density };
        self.scene.particles = casters.iter().map(particle).collect();
        self.bounds[1] = Bounds::of_casters(&self.scene.casters());
        self.written = false;
        Ok(())
    }

    /// Puts another state of the same scene in its place: particles, strands, meshes, lights and the camera may have moved and
    /// changed. What has not is not copied, and its generation stays.
    ///
    /// # Errors
    /// [`Error::Input`] where there are more casters than there is room for, strands where it began with none, or lights or
    /// meshes of another number, or a point light for another, for which everything has to be opened anew; [`Error::Gpu`] where a copy fails.
    pub fn replace(&mut self, scene: &Scene) -> Result<Moved> {
        let start = Instant::now();
        self.check(scene)?;
        let changed = self.changed(scene);
        let casters = if changed.particles || changed.strands { scene.casters() } else { Vec::new() };
        let bounds = [
            if changed.meshes { Bounds::of_meshes(&scene.meshes) } else { self.bounds[0] },
            if changed.particles || changed.strands { Bounds::of_casters(&casters) } else { self.bounds[1] },
        ];
        // First: where a copy fails, what is on the device is of neither scene.
        self.raise(scene, &changed, bounds);
        self.mixed = true;
        let pass = if changed.on_device() { self.copy(scene, &changed, &casters)? } else { None };
        (self.written, self.mixed, self.bounds) = (false, false, bounds);
        let host_ns = start.elapsed().as_nanos() as f64;
        self.scene.clone_from(scene);
        Ok(Moved { pass, host_ns })
    }

    /// An error where a scene is no other state of this one.
    fn check(&self, scene: &Scene) -> Result<()> {
        let casters = scene.particles.len() + scene.strands.len();
        let triangle_count: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
        let maps = |s: &Scene| s.lights.iter().map(crate::scene::Light::map_count).collect::<Vec<_>>();
        let cause = if casters > self.caster_capacity as usize {
            format!("{casters} casters, and the world has room for {}", self.caster_capacity)
        } else if !scene.strands.is_empty() && !self.strands {
            "it has strands, and the world was made without".into()
        } else if triangle_count != self.triangle_count as usize || maps(scene) != maps(&self.scene) {
            "meshes or lights are others than those that the world was made for".into()
        } else {
            return Ok(());
        };
        Err(Error::input(scene.name.clone(), cause, "make a new world, and open its techniques anew"))
    }

    /// What a scene has otherwise than the device.
    fn changed(&self, scene: &Scene) -> Changed {
        let was = &self.scene;
        let particles =
            bytemuck::cast_slice::<_, u8>(&scene.particles) != bytemuck::cast_slice::<_, u8>(&was.particles);
        Changed {
            meshes: self.mixed || scene.meshes != was.meshes,
            // What simulates them decides where views begin.
            particles: self.mixed || self.written || particles || scene.motion != was.motion,
            strands: self.mixed || self.written && self.strands || scene.strands != was.strands,
            lights: self.mixed || scene.lights != was.lights,
        }
    }

    fn raise(&mut self, scene: &Scene, changed: &Changed, bounds: [Bounds; 2]) {
        let whole = |[meshes, casters]: [Bounds; 2]| meshes.with(casters);
        let now = &mut self.generations;
        now.meshes += u64::from(changed.meshes);
        now.particles += u64::from(changed.particles);
        now.strands += u64::from(changed.strands);
        let lights = scene.lights.iter().zip(&self.scene.lights).zip(&mut now.lights);
        for ((is, was), generation) in lights {
            *generation += u64::from(self.mixed || (is.kind, is.radius) != (was.kind, was.radius));
        }
        now.camera += u64::from(scene.camera != self.scene.camera);
        now.bounds += u64::from(self.mixed || self.written || whole(bounds) != whole(self.bounds));
    }

    /// Copies what has changed to the device.
    fn copy(&self, scene: &Scene, changed: &Changed, casters: &[Caster]) -> Result<Option<PassTime>> {
        let passes = self.context.try_submit(|commands| {
            let mut staged = vec![commands.stage(&self.casters, casters)?];
            if changed.lights {
                staged.push(commands.stage(&self.lights, &LightData::all(scene))?);
            }
            if changed.meshes {
                staged.push(commands.stage(&self.triangles, &triangles(scene))?);
                staged.push(commands.stage(&self.sides, &signs(scene))?);
            }
            commands.pass("world.move", |pass| staged.iter().flatten().for_each(|staged| pass.copy_staged(staged)));
            Ok(())
        })?;
        Ok(passes.into_iter().next())
    }
}

/// Parts of a scene that are other than they were.
struct Changed {
    meshes: bool,
    particles: bool,
    strands: bool,
    /// Or their colours.
    lights: bool,
}

impl Changed {
    fn on_device(&self) -> bool {
        self.meshes || self.particles || self.strands || self.lights
    }
}

/// Of each triangle, in the order of [`triangles`].
fn signs(scene: &Scene) -> Vec<i32> {
    scene.meshes.iter().flat_map(|mesh| sides(mesh).into_iter().map(Side::sign)).collect()
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
