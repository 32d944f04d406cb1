//! A world built on the device from the caller's buffers.

use super::alpha;
use super::gather::{Gather, Slots};
use super::gather_alpha::GatherAlpha;
use super::gather_sheets::GatherSheets;
use super::source::{Corners, Count, Source, SphereAt, SplatAt, StrandAt};
use super::{Bounds, Gathered, Generations, LightData, TriangleData, World, WorldSource};
use crate::gpu::{Buffer, Commands, Context, Memory};
use crate::scene::{AlphaMode, Camera, Caster, Kinds, Volume};
use crate::{Error, Result};
use glam::{DVec3, Vec3};

/// A world's capacities. Techniques are created for them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capacity {
    /// Number of smoke spheres.
    pub particles: u32,
    /// Number of straight pieces of hair.
    pub strands: u32,
    /// Number of anisotropic Gaussians.
    pub splats: u32,
    /// Number of volume cells ([`Volume::cells`]).
    pub cells: u32,
    /// Number of triangles.
    pub triangles: u32,
    /// Number of texels of the triangles' alpha ([`Corners::alpha`]). None: no triangle has alpha, and kernels are compiled without it.
    pub alpha_texels: Option<u32>,
    /// Whether triangles may be see-through. The world then has room for as many casters more as it has triangles.
    pub see_through: bool,
    /// Number of lights.
    pub lights: u32,
}

impl Capacity {
    pub(super) fn kinds(self) -> Kinds {
        let Self { particles, strands, splats, cells, triangles, .. } = self;
        Kinds {
            particles: particles > 0,
            strands: strands > 0,
            splats: splats > 0,
            volumes: cells > 0,
            meshes: triangles > 0,
            see_through: self.sheets() > 0,
        }
    }

    /// Number of see-through triangles.
    fn sheets(self) -> u32 {
        if self.see_through { self.triangles } else { 0 }
    }

    /// Returns whether the capacity of more than one kind of caster is above 0.
    fn is_mixed(self) -> bool {
        [self.particles, self.strands, self.splats, self.sheets(), self.cells].iter().filter(|room| **room > 0).count()
            > 1
    }
}

/// Fills a world from the caller's buffers.
pub(super) struct External {
    pub capacity: Capacity,
    pub gather: Gather,
    gather_alpha: GatherAlpha,
    gather_sheets: GatherSheets,
    volumes: Vec<Volume>,
    /// Whether unwritten casters have been given radius 0.
    cleared: bool,
}

/// Returns the error for a call that is only valid in a world filled from the caller's buffers.
fn of_a_scene(name: &str) -> Error {
    let cause = "a scene fills this world, and no buffer of the caller's";
    Error::input(name, cause, "make the world with World::of, or move the scene with World::replace")
}

impl World {
    /// Creates a world with these capacities, which has no casters and no lights yet. Call [`World::update_lights`] or
    /// [`World::update_lights_from_buffer`] before a technique is created for it, and supply the casters before its passes are recorded.
    ///
    /// Casters and triangles are copied on the device, in passes named `world.gather`, from the caller's layout to this crate's: 32 bytes
    /// per caster and 48 per triangle, written once.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub fn of(context: &Context, capacity: Capacity) -> Result<Self> {
        let casters = capacity
            .particles
            .checked_add(capacity.strands)
            .and_then(|casters| casters.checked_add(capacity.splats))
            .and_then(|casters| casters.checked_add(capacity.sheets()))
            .and_then(|casters| casters.checked_add(capacity.cells))
            .ok_or_else(|| Error::input("a capacity", "more casters than numbers of 32 bits", "make room for fewer"))?;
        let buffer = |name, count: u32, bytes: usize| {
            Buffer::new(context, name, u64::from(count) * bytes as u64, Memory::Device)
        };
        let alpha_words = capacity.alpha_texels.map_or(0, |texels| alpha::room(capacity.triangles, texels));
        let triangle_bytes = u64::from(capacity.triangles) * size_of::<TriangleData>() as u64 + 4 * alpha_words;
        Ok(Self {
            context: context.clone(),
            name: "a world of buffers".into(),
            generations: Generations::default(),
            casters: buffer("world.casters", casters, size_of::<Caster>())?,
            caster_capacity: casters,
            colors: 1,
            particle_count: 0,
            strand_count: 0,
            splat_count: 0,
            sheet_count: 0,
            cell_count: 0,
            // Zeroed, so that no triangle has alpha before the first update.
            triangles: Buffer::zeroed(context, "world.triangles", triangle_bytes)?,
            triangle_capacity: capacity.triangles,
            triangle_count: 0,
            alpha_generation: 0,
            alpha_first: capacity.alpha_texels.map_or(0, |_| capacity.triangles),
            sides: buffer("world.sides", capacity.triangles, size_of::<i32>())?,
            strands: capacity.strands > 0,
            packed: capacity.splats > 0 || capacity.cells > 0,
            sheets: capacity.sheets() > 0,
            lights: buffer("world.lights", capacity.lights, size_of::<LightData>())?,
            lit: Vec::new(),
            knows_lights: true,
            camera: None,
            anchors: [DVec3::ZERO; 2],
            bounds: None,
            filled: WorldSource::External(Box::new(External {
                capacity,
                gather: Gather::new(context)?,
                gather_alpha: GatherAlpha::new(),
                gather_sheets: GatherSheets::new(capacity),
                volumes: Vec::new(),
                cleared: false,
            })),
        })
    }

    pub(super) fn theirs(&mut self) -> Result<&mut External> {
        match &mut self.filled {
            WorldSource::External(theirs) => Ok(theirs),
            WorldSource::Scene(_) => Err(of_a_scene(&self.name)),
        }
    }

    /// Replaces the particles with those in the caller's buffer: records the pass that gathers them, and marks them as moved. Particles
    /// that have a non-finite number or no size cast nothing, and are counted as refused ([`World::gathered`]).
    ///
    /// If only the device knows the number of particles, kernels iterate over the full capacity, but skip casters past the count
    /// immediately.
    ///
    /// # Errors
    /// [`Error::Input`] if the host's count exceeds the capacity, or the layout extends past the buffer; [`Error::Gpu`] if memory runs out.
    pub fn update_particles(&mut self, commands: &mut Commands, source: &Source, at: SphereAt) -> Result<()> {
        let (context, casters) = (self.context.clone(), self.casters.clone());
        let theirs = self.theirs()?;
        let Capacity { particles: capacity, strands, splats, cells, .. } = theirs.capacity;
        // Casters of other kinds are stored after the full capacity of particles.
        let count = shown(&source.count, capacity, strands + splats + theirs.capacity.sheets() + cells > 0);
        theirs.clear(commands, &casters);
        let slots = Slots { first: 0, count, capacity };
        theirs.gather.spheres(&context, commands, (&casters, slots), (source, at))?;
        self.particle_count = count;
        self.generations.particles += 1;
        self.generations.bounds += 1;
        Ok(())
    }

    /// Replaces the strands with those in the caller's buffer, as in [`World::update_particles`].
    ///
    /// # Errors
    /// Same as [`World::update_particles`].
    pub fn update_strands(&mut self, commands: &mut Commands, source: &Source, at: StrandAt) -> Result<()> {
        let (context, casters) = (self.context.clone(), self.casters.clone());
        let theirs = self.theirs()?;
        let Capacity { particles: first, strands: capacity, splats, cells, .. } = theirs.capacity;
        let count = shown(&source.count, capacity, splats + theirs.capacity.sheets() + cells > 0);
        theirs.clear(commands, &casters);
        let slots = Slots { first, count, capacity };
        theirs.gather.strands(&context, commands, (&casters, slots), (source, at))?;
        (self.particle_count, self.strand_count) = (first, count);
        self.generations.strands += 1;
        self.generations.bounds += 1;
        Ok(())
    }

    /// Replaces the splats with those in the caller's buffer, as in [`World::update_particles`]. Splats without axes or with an opacity out
    /// of range cast nothing either. Splats are packed in f32 here but in f64 in a scene, so directions and deviations may differ in the
    /// last bit.
    ///
    /// # Errors
    /// Same as [`World::update_particles`].
    pub fn update_splats(&mut self, commands: &mut Commands, source: &Source, at: SplatAt) -> Result<()> {
        let (context, casters) = (self.context.clone(), self.casters.clone());
        let theirs = self.theirs()?;
        let Capacity { particles, strands, splats: capacity, cells, .. } = theirs.capacity;
        let count = shown(&source.count, capacity, theirs.capacity.sheets() + cells > 0);
        theirs.clear(commands, &casters);
        let slots = Slots { first: particles + strands, count, capacity };
        theirs.gather.splats(&context, commands, (&casters, slots), (source, at))?;
        (self.particle_count, self.strand_count, self.splat_count) = (particles, strands, count);
        self.generations.strands += 1;
        self.generations.bounds += 1;
        Ok(())
    }

    /// Replaces the volumes with the host's `volumes`. If any has changed, records the copy of their cells, in a pass `world.volumes`, and
    /// marks them as moved. Unchanged volumes need no pass and cost nothing. Clones of a volume share its field, so comparing them does not
    /// compare the field. An empty slice removes all volumes.
    ///
    /// # Errors
    /// [`Error::Input`] if the volumes have more cells than the capacity, or a scene fills the world; [`Error::Gpu`] if memory runs out.
    pub fn volumes(&mut self, commands: &mut Commands, volumes: &[Volume]) -> Result<()> {
        let casters = self.casters.clone();
        let theirs = self.theirs()?;
        if theirs.volumes == volumes {
            return Ok(());
        }
        let Capacity { particles, strands, splats, cells: capacity, .. } = theirs.capacity;
        let cells: Vec<Caster> = volumes.iter().flat_map(Volume::cells).copied().collect();
        if cells.len() > capacity as usize {
            let cause = format!("{} cells, and the world has room for {capacity}", cells.len());
            return Err(Error::input("volumes", cause, "make the world with a larger capacity"));
        }
        theirs.clear(commands, &casters);
        let sheets = theirs.capacity.sheets();
        let first = u64::from(particles + strands + splats + sheets) * size_of::<Caster>() as u64;
        if let Some(staged) = commands.stage_at(&casters, first, &cells)? {
            commands.pass("world.volumes", |pass| pass.copy_staged(&staged));
        }
        theirs.volumes = volumes.to_vec();
        (self.particle_count, self.strand_count, self.splat_count) = (particles, strands, splats);
        (self.sheet_count, self.cell_count) = (sheets, cells.len() as u32);
        self.generations.strands += 1;
        self.generations.bounds += 1;
        Ok(())
    }

    /// Replaces the triangles with those in the caller's buffers: records the pass that gathers them, and marks them as moved. Whether
    /// these triangles form closed meshes is unknown. Triangles with a corner that is not finite, or with an invalid vertex index, cast
    /// nothing, and are counted as refused. These triangles, and those past the count, collapse to a point: a corner of a
    /// valid triangle, if a few tries find one. Kernels iterate over the full triangle capacity.
    ///
    /// # Errors
    /// Same as [`World::update_particles`].
    pub fn update_triangles(&mut self, commands: &mut Commands, corners: &Corners) -> Result<()> {
        let (context, triangles, casters) = (self.context.clone(), self.triangles.clone(), self.casters.clone());
        let place = self.anchors[1].as_vec3().to_array();
        let theirs = self.theirs()?;
        let capacity = theirs.capacity.triangles;
        let sheets = theirs.capacity.sheets();
        if corners.alpha.as_ref().is_some_and(|at| at.mode == AlphaMode::SeeThrough) && sheets == 0 {
            let cause = "see-through ones, and the world was made without";
            return Err(Error::input("triangles", cause, "give Capacity::see_through"));
        }
        if let Some(at) = &corners.alpha {
            let Some(room) = theirs.capacity.alpha_texels else {
                let cause = "alpha, and the world was made without";
                return Err(Error::input("triangles", cause, "give Capacity::alpha_texels"));
            };
            let to = (&triangles, capacity, room);
            theirs.gather_alpha.record(&context, commands, to, corners, at)?;
        } else if theirs.capacity.alpha_texels.is_some() {
            let first = u64::from(capacity) * size_of::<TriangleData>() as u64;
            commands.pass("world.gather", |pass| pass.fill_part(&triangles, first, 4 * u64::from(capacity), 0));
        }
        theirs.gather.triangles(&context, commands, (&triangles, capacity), corners, place)?;
        let has_alpha = theirs.capacity.alpha_texels.is_some();
        if sheets > 0 {
            let Capacity { particles, strands, splats, .. } = theirs.capacity;
            theirs.clear(commands, &casters);
            theirs.gather_sheets.record(
                &context,
                commands,
                (&triangles, &casters),
                [particles + strands + splats, sheets],
            )?;
            (self.particle_count, self.strand_count, self.splat_count) = (particles, strands, splats);
            self.sheet_count = sheets;
            self.generations.strands += 1;
        }
        self.alpha_generation += u64::from(has_alpha);
        if self.triangle_count == 0 && capacity > 0 {
            commands.pass("world.gather", |pass| pass.fill(&self.sides, 0));
        }
        self.triangle_count = capacity;
        self.generations.meshes += 1;
        self.generations.bounds += 1;
        Ok(())
    }

    /// Sets the camera, which camera-dependent techniques read from the world.
    pub fn set_camera(&mut self, camera: Camera) {
        self.generations.camera += u64::from(self.camera != Some(camera));
        self.camera = Some(camera);
    }

    /// Sets a box that contains all casters at all times, by its low and high corners, for a world filled from the caller's buffers.
    /// Techniques that need a box on the host (`voxelized`, `ray-query`) cannot be created without one. The views of directional lights are
    /// relative to the centre of the box, or to the world's origin without a box: the farther the origin is from the casters, the coarser
    /// the views. Set the box before creating techniques.
    ///
    /// # Errors
    /// [`Error::Input`] if low exceeds high, a number is not finite, or a scene fills the world.
    pub fn set_box(&mut self, low: [f32; 3], high: [f32; 3]) -> Result<()> {
        self.theirs()?;
        let is_box = low.iter().zip(&high).all(|(low, high)| low <= high && (high - low).is_finite());
        if !is_box {
            return Err(Error::input("a box", format!("from {low:?} to {high:?}"), "give its low and its high corner"));
        }
        let bounds = Bounds::of([Vec3::from(low), Vec3::from(high)]);
        let [low, high] = bounds.ends();
        self.anchors = [(low + high) * 0.5; 2];
        self.bounds = Some([bounds; 2]);
        self.generations.bounds += 1;
        Ok(())
    }

    /// Returns the counts of elements that the completed frame `frame` gathered from the caller's buffers. None if that frame gathered
    /// nothing, or if a later recorded frame reuses the memory of its counts.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the counts cannot be read, [`Error::Input`] if a scene fills the world.
    pub fn gathered(&self, frame: u64) -> Result<Option<Gathered>> {
        match &self.filled {
            WorldSource::External(theirs) => theirs.gather.read(frame),
            WorldSource::Scene(_) => Err(of_a_scene(&self.name)),
        }
    }
}

impl External {
    /// Clears all casters before the first are written, so that kinds of casters not supplied yet cast nothing.
    fn clear(&mut self, commands: &mut Commands, casters: &Buffer) {
        if !self.cleared && self.capacity.is_mixed() {
            commands.pass("world.gather", |pass| pass.fill(casters, 0));
            self.cleared = true;
        }
    }
}

/// Returns how many casters of one kind kernels iterate over: the number of casters if the host knows it and no casters of another kind
/// follow in the buffer, otherwise the capacity.
fn shown(count: &Count, capacity: u32, others_behind: bool) -> u32 {
    match count {
        Count::Host(count) if !others_behind => (*count).min(capacity),
        _ => capacity,
    }
}
