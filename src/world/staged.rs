//! A world created from a scene on the host: uploaded, moved, and read back if the device simulates it.

use super::alpha;
use super::{Bounds, Generations, LightData, StagedWorld, TriangleData, World, WorldSource};
use crate::gpu::{Buffer, Commands, Context, Memory, PassTime};
use crate::scene::{Camera, Caster, Light, Particle, Scene, Side, sides};
use crate::{Error, Result};
use std::ops::Range;
use std::time::Instant;

/// Timings of moving the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Device time of the pass `world.move`, if the device has timestamps.
    pub pass: Option<PassTime>,
    /// Host time from the new scene to its copy on the device, in nanoseconds: writing, submitting and waiting, but not creating the scene.
    pub host_ns: f64,
}

impl World {
    /// Creates a world and uploads `scene` to it.
    ///
    /// # Errors
    /// [`Error::Input`] if lights or inks are not as [`Scene::with_inks`] leaves them, or the alpha of a mesh is not as [`crate::scene::Alpha`]
    /// says; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self> {
        scene.check_inks()?;
        alpha::check(&scene.meshes)?;
        check_sheets(scene)?;
        let triangle_count = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>() as u32;
        let (colors, capacity) = (scene.colors(), scene.most_casters());
        let bytes = (colors * capacity * size_of::<Caster>()) as u64;
        let buffer = Buffer::new(context, "world.casters", bytes, Memory::Device)?;
        let casters = scene.casters();
        if colors == 1 {
            buffer.write(&casters)?;
        } else {
            let empty = Caster { radius: 0.0, density: 0.0, position: [0.0; 3], axis: [0.0; 3] };
            let mut all = vec![empty; colors * capacity];
            for (color, room) in all.chunks_mut(capacity).enumerate() {
                room[..casters.len()].copy_from_slice(&scene.in_color(casters.clone(), 0, color));
            }
            buffer.write(&all)?;
        }
        Ok(Self {
            context: context.clone(),
            name: scene.name.clone(),
            casters: buffer,
            caster_capacity: capacity as u32,
            colors: colors as u32,
            particle_count: scene.particles.len() as u32,
            strand_count: scene.strands.len() as u32,
            splat_count: scene.splats.len() as u32,
            sheet_count: scene.sheet_count() as u32,
            cell_count: scene.cell_count() as u32,
            triangles: Buffer::with_data(context, "world.triangles", &with_alpha(scene))?,
            triangle_capacity: triangle_count,
            triangle_count,
            alpha_generation: 0,
            alpha_first: if alpha::is_any(&scene.meshes) { triangle_count } else { 0 },
            sides: Buffer::with_data(context, "world.sides", &signs(scene))?,
            strands: !scene.strands.is_empty(),
            packed: !scene.splats.is_empty() || !scene.volumes.is_empty(),
            sheets: scene.sheet_count() > 0,
            lights: Buffer::with_data(context, "world.lights", &LightData::all(scene))?,
            generations: Generations { lights: vec![0; scene.lights.len()], ..Generations::default() },
            lit: scene.lights.clone(),
            knows_lights: true,
            camera: Some(scene.camera),
            anchors: scene.aim().anchors,
            bounds: Some([Bounds::of_meshes(&scene.meshes), Bounds::of_casters(&casters)]),
            filled: WorldSource::Scene(Box::new(StagedWorld { scene: scene.clone(), written: false, mixed: false })),
        })
    }

    /// Lets passes write the casters on the device, if the world is simulated there. The number of casters stays the same. The host's scene
    /// is unchanged until [`World::read_back`]. Returns the time of each pass.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost, [`Error::Refused`] as for [`World::scene`].
    pub fn write_casters(&mut self, record: impl FnOnce(&mut Commands)) -> Result<Vec<PassTime>> {
        self.casters_move()?;
        self.context.submit(record)
    }

    /// Registers that passes being recorded now write the casters, as in [`World::write_casters`].
    ///
    /// # Errors
    /// [`Error::Refused`] as for [`World::scene`].
    pub fn casters_move(&mut self) -> Result<()> {
        self.one_color("passes that write casters give")?;
        self.staged()?.written = true;
        self.generations.particles += 1;
        self.generations.strands += u64::from(self.strands);
        self.generations.bounds += 1;
        Ok(())
    }

    /// Copies the particles on the device into the host's scene.
    ///
    /// # Errors
    /// [`Error::Gpu`] if they cannot be read, [`Error::Refused`] as for [`World::scene`].
    pub fn read_back(&mut self) -> Result<()> {
        let casters: Vec<Caster> = self.casters.read(self.particle_count as usize)?;
        self.take_particles(&casters)?;
        let staged = self.staged()?;
        staged.written = false;
        let bounds = Bounds::of_casters(&staged.scene.casters());
        self.bounds = Some([self.known_bounds()[0], bounds]);
        Ok(())
    }

    /// Like [`World::read_back`], but uses `casters`, a copy of the world's casters that was read back with frames in flight, so that
    /// nothing waits. No pass may have written the casters since.
    ///
    /// # Errors
    /// [`Error::Refused`] as for [`World::scene`].
    pub fn particles_are(&mut self, casters: &[Caster]) -> Result<()> {
        self.take_particles(casters)?;
        let known = self.known_bounds();
        let staged = self.staged()?;
        staged.written = false;
        let bounds = [known[0], Bounds::of_casters(&staged.scene.casters())];
        self.generations.bounds += u64::from(whole(bounds) != whole(known));
        self.bounds = Some(bounds);
        Ok(())
    }

    fn take_particles(&mut self, casters: &[Caster]) -> Result<()> {
        let particles = casters.iter().take(self.particle_count as usize);
        let particle = |c: &Caster| Particle { position: c.position, radius: c.radius, extinction: c.density };
        let particles = particles.map(particle);
        let staged = self.staged()?;
        staged.scene.particles.clear();
        staged.scene.particles.extend(particles);
        Ok(())
    }

    /// Sets a new camera and the same number of new lights, and records their copy. Casters stay as they are, and are neither compared nor
    /// copied.
    ///
    /// # Errors
    /// Same as [`World::replace`].
    pub fn turn_in(&mut self, commands: &mut Commands, camera: Camera, lights: &[Light]) -> Result<()> {
        let maps = |lights: &[Light]| lights.iter().map(Light::map_count).collect::<Vec<_>>();
        let is_other = maps(lights) != maps(&self.lit);
        let staged = self.staged()?;
        if staged.mixed || is_other {
            let scene = Scene { camera, lights: lights.to_vec(), ..staged.scene.clone() };
            return self.replace_in(commands, &scene);
        }
        staged.scene.camera = camera;
        if staged.scene.lights != lights {
            staged.scene.lights = lights.to_vec();
            staged.mixed = true;
            let data = LightData::all(&staged.scene);
            raise_lights(&mut self.generations, lights, &self.lit, false);
            let copy = commands.stage(&self.lights, &data)?;
            commands.pass("world.move", |pass| copy.iter().for_each(|copy| pass.copy_staged(copy)));
            self.lit = lights.to_vec();
            self.staged()?.mixed = false;
        }
        self.generations.camera += u64::from(self.camera != Some(camera));
        self.camera = Some(camera);
        Ok(())
    }

    fn staged(&mut self) -> Result<&mut StagedWorld> {
        match &mut self.filled {
            WorldSource::Scene(staged) => Ok(staged),
            WorldSource::External(_) => Err(Error::Refused("a scene that the host knows".into())),
        }
    }

    /// Returns the bounds on the host, which knows them if a scene fills the world.
    fn known_bounds(&self) -> [Bounds; 2] {
        self.bounds.unwrap_or([Bounds::NONE; 2])
    }

    /// Replaces the scene with another state of the same scene: particles, strands, meshes, lights and the camera may have moved and
    /// changed. Unchanged parts are not copied, and their generations do not change.
    ///
    /// # Errors
    /// [`Error::Input`] if everything has to be created again: there are more casters than the capacity, there are strands but the first
    /// scene had none, the number of triangles or of lights has changed, a mesh has other alpha, or a light has a different number of maps.
    /// [`Error::Gpu`] if a copy fails; [`Error::Refused`] as for [`World::scene`].
    pub fn replace(&mut self, scene: &Scene) -> Result<Moved> {
        let start = Instant::now();
        let context = self.context.clone();
        let moved = self.change(scene, |copies| {
            let pass = context.try_submit(|commands| copies.record(commands))?.into_iter().next();
            Ok(Moved { pass, host_ns: start.elapsed().as_nanos() as f64 })
        })?;
        Ok(moved.unwrap_or_else(|| Moved { pass: None, host_ns: start.elapsed().as_nanos() as f64 }))
    }

    /// Like [`World::replace`], but records the copies: later commands see the new state.
    ///
    /// # Errors
    /// Same as [`World::replace`].
    pub fn replace_in(&mut self, commands: &mut Commands, scene: &Scene) -> Result<()> {
        self.change(scene, |copies| copies.record(commands)).map(|_| ())
    }

    /// Replaces the scene with another state. `copy` transfers the changed parts to the device, if there are any.
    fn change<T>(&mut self, scene: &Scene, copy: impl FnOnce(&Copies) -> Result<T>) -> Result<Option<T>> {
        self.check(scene)?;
        let has_strands = self.strands;
        let staged = self.staged()?;
        let (mixed, written) = (staged.mixed, staged.written);
        let changed = Changed::of(staged, scene, has_strands);
        let is_new = changed.particles || changed.strands;
        let casters = if is_new { scene.casters() } else { Vec::new() };
        let known = self.known_bounds();
        let bounds = [
            if changed.meshes { Bounds::of_meshes(&scene.meshes) } else { known[0] },
            if is_new { Bounds::of_casters(&casters) } else { known[1] },
        ];
        // The generations are incremented before the copies, because the device's data belong to neither scene if a copy fails.
        self.raise(scene, &changed, mixed);
        self.generations.bounds += u64::from(mixed || written || whole(bounds) != whole(known));
        self.staged()?.mixed = true;
        let copies = Copies { world: self, scene, changed: &changed, casters: &casters };
        let copied = if changed.on_device() { Some(copy(&copies)?) } else { None };
        self.bounds = Some(bounds);
        (self.particle_count, self.strand_count) = (scene.particles.len() as u32, scene.strands.len() as u32);
        (self.splat_count, self.cell_count) = (scene.splats.len() as u32, scene.cell_count() as u32);
        self.lit.clone_from(&scene.lights);
        self.anchors = scene.aim().anchors;
        self.camera = Some(scene.camera);
        self.name.clone_from(&scene.name);
        let staged = self.staged()?;
        (staged.written, staged.mixed) = (false, false);
        staged.scene.clone_from(scene);
        Ok(copied)
    }

    /// Fails if `scene` is not another state of this world's scene.
    fn check(&self, scene: &Scene) -> Result<()> {
        let casters = scene.first_cell() + scene.cell_count();
        let triangle_count: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
        let maps = |lights: &[Light]| lights.iter().map(Light::map_count).collect::<Vec<_>>();
        let cause = if casters > self.caster_capacity as usize {
            format!("{casters} casters, and the world has room for {}", self.caster_capacity)
        } else if !scene.strands.is_empty() && !self.strands {
            "it has strands, and the world was made without".into()
        } else if !(self.packed || scene.splats.is_empty() && scene.volumes.is_empty()) {
            "it has splats or volumes, and the world was made without".into()
        } else if triangle_count != self.triangle_count as usize || maps(&scene.lights) != maps(&self.lit) {
            "meshes or lights are others than those that the world was made for".into()
        } else if scene.extinction_ratio != self.extinction_ratio() || scene.inks != self.scene()?.inks {
            "its casters are of another color than those that the world was made with".into()
        } else if !alpha::is_alike(&scene.meshes, &self.scene()?.meshes) {
            "its meshes have other alpha than those that the world was made with".into()
        } else {
            return scene.check_inks();
        };
        Err(Error::input(scene.name.clone(), cause, "make a new world, and open its techniques anew"))
    }

    fn raise(&mut self, scene: &Scene, changed: &Changed, mixed: bool) {
        let now = &mut self.generations;
        now.meshes += u64::from(changed.meshes);
        now.particles += u64::from(changed.particles);
        now.strands += u64::from(changed.strands);
        raise_lights(now, &scene.lights, &self.lit, mixed);
        now.camera += u64::from(Some(scene.camera) != self.camera);
    }
}

/// Changed data to be copied to the device.
struct Copies<'a> {
    world: &'a World,
    scene: &'a Scene,
    changed: &'a Changed,
    casters: &'a [Caster],
}

impl Copies<'_> {
    fn record(&self, commands: &mut Commands) -> Result<()> {
        let Self { world, scene, .. } = self;
        let Range { start, end } = self.changed.casters.clone();
        let mut staged = Vec::new();
        for color in 0..world.colors as usize {
            let first = ((color * world.caster_capacity as usize + start) * size_of::<Caster>()) as u64;
            let casters = &self.casters[start..end];
            staged.push(match world.colors {
                1 => commands.stage_at(&world.casters, first, casters)?,
                _ => commands.stage_at(&world.casters, first, &scene.in_color(casters.to_vec(), start, color))?,
            });
        }
        if self.changed.lights {
            staged.push(commands.stage(&world.lights, &LightData::all(scene))?);
        }
        if self.changed.meshes {
            staged.push(commands.stage(&world.triangles, &triangles(scene))?);
            staged.push(commands.stage(&world.sides, &signs(scene))?);
        }
        commands.pass("world.move", |pass| staged.iter().flatten().for_each(|staged| pass.copy_staged(staged)));
        Ok(())
    }
}

/// The parts of a scene that have changed.
struct Changed {
    meshes: bool,
    particles: bool,
    /// Strands, splats, volumes or see-through meshes.
    strands: bool,
    /// The lights, even if only their colors have changed.
    lights: bool,
    /// The range of changed casters on the device.
    casters: Range<usize>,
}

impl Changed {
    /// Finds the differences between a scene and the device.
    fn of(staged: &StagedWorld, scene: &Scene, has_strands: bool) -> Self {
        let StagedWorld { scene: was, written, mixed } = staged;
        let particles =
            bytemuck::cast_slice::<_, u8>(&scene.particles) != bytemuck::cast_slice::<_, u8>(&was.particles);
        let sheets = scene.sheet_count() > 0 && scene.meshes != was.meshes;
        let others =
            scene.strands != was.strands || scene.splats != was.splats || scene.volumes != was.volumes || sheets;
        // As long as the number of particles stays the same, the casters after them keep their places.
        let behind = scene.particles.len();
        let count = scene.first_cell() + scene.cell_count();
        let casters = match (particles, others) {
            _ if *mixed || *written || behind != was.particles.len() => 0..count,
            (true, true) => 0..count,
            (true, false) => 0..behind,
            (false, true) => behind..count,
            (false, false) => 0..0,
        };
        Self {
            casters,
            meshes: *mixed || scene.meshes != was.meshes,
            // The box that particles stay in determines where views begin.
            particles: *mixed || *written || particles || scene.reserve.stay_in != was.reserve.stay_in,
            strands: *mixed || *written && has_strands || others,
            lights: *mixed || scene.lights != was.lights,
        }
    }

    fn on_device(&self) -> bool {
        self.meshes || self.particles || self.strands || self.lights
    }
}

/// Checks that see-through meshes and casters of a color are not mixed without inks: one ratio for all would color the glass.
fn check_sheets(scene: &Scene) -> Result<()> {
    let cause = if scene.sheet_count() > 0 && scene.extinction_ratio != Scene::GREY {
        "see-through meshes, and one extinction ratio for all casters"
    } else if scene.inks.is_empty() && scene.is_tinted() {
        "see-through meshes of a color, and lights that are not listed once per color"
    } else {
        return Ok(());
    };
    Err(Error::input(scene.name.clone(), cause, "give each caster its ratio (Scene::with_inks)"))
}

fn whole([meshes, casters]: [Bounds; 2]) -> Bounds {
    meshes.with(casters)
}

/// Increments the generations of lights that have moved. A change of color alone does not count.
pub(super) fn raise_lights(now: &mut Generations, lights: &[Light], before: &[Light], all: bool) {
    for ((is, was), generation) in lights.iter().zip(before).zip(&mut now.lights) {
        *generation += u64::from(all || (is.kind, is.radius) != (was.kind, was.radius));
    }
}

/// Returns the sign ([`Side::sign`]) of each triangle, in the order of [`triangles`].
fn signs(scene: &Scene) -> Vec<i32> {
    scene.meshes.iter().flat_map(|mesh| sides(mesh).into_iter().map(Side::sign)).collect()
}

/// Returns all triangles, and the alpha behind them, as words.
fn with_alpha(scene: &Scene) -> Vec<u32> {
    let mut words = bytemuck::cast_vec::<_, [u32; alpha::WORDS]>(triangles(scene)).into_flattened();
    if alpha::is_any(&scene.meshes) {
        words.extend(alpha::words(&scene.meshes));
    }
    words
}

fn triangles(scene: &Scene) -> Vec<TriangleData> {
    let corner = |positions: &[[f32; 3]], i: u32| positions.get(i as usize).copied().unwrap_or_default();
    let of_mesh = |m: &crate::scene::Mesh| -> Vec<TriangleData> {
        let triangle = |t: &[u32; 3]| TriangleData { corners: t.map(|i| corner(&m.positions, i)), albedo: m.albedo };
        m.triangles.iter().map(triangle).collect()
    };
    scene.meshes.iter().flat_map(of_mesh).collect()
}
