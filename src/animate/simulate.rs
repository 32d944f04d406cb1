//! Particles that the device simulates: positions and velocities are in buffers, and each step is one dispatch. Twin:
//! reference::twin::simulate.

use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, PassTime, groups, push_struct};
use crate::grid::{Grid, GridData};
use crate::scene::{Body, Caster, Fountain, check_time};
use crate::shaders::set;
use crate::shaders::simulate as shaders;
use crate::world::World;
use crate::{Error, Result};
use bytemuck::Zeroable;
use std::ops::Range;

/// Threads per workgroup.
const THREADS: u32 = 64;

push_struct! {
    /// Twin: StepPush in glsl/animate/simulate/step.comp.
    struct StepPush {
        step_number: u32,
        particles: u32,
        attractor_x: f32,
        attractor_y: f32,
        attractor_z: f32,
    }
}

/// The particles of a world that shows a fountain. Their state depends only on the step's number, not on how that step was reached.
pub struct Simulation {
    context: Context,
    fountain: Fountain,
    /// Constants for all particles, a [`Law`](crate::scene::Law).
    law: Buffer,
    /// The current state of each particle, a [`Body`].
    bodies: Buffer,
    grid: Grid,
    kernel: Kernel<StepPush>,
    /// Index of the last step that the bodies have completed; `None` before the first step.
    at: Option<u32>,
    /// Whether the grid is filled.
    ready: bool,
}

impl Simulation {
    /// Creates the simulation of `fountain`, whose particles are in the scene of `world`.
    ///
    /// # Errors
    /// [`Error::Input`] if the world's capacity is too small for them, [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, fountain: Fountain) -> Result<Self> {
        let room = world.casters.bytes() / size_of::<Caster>() as u64;
        if room < u64::from(fountain.particles) {
            let cause = format!("it has room for {room} casters, and the fountain has {}", fountain.particles);
            return Err(Error::input(world.name(), cause, "make the world of the fountain's scene"));
        }
        let place = fountain.place();
        let given = GridData {
            origin: place.origin,
            voxel: place.voxel,
            per_unit: place.per_unit,
            size: place.size,
            ..GridData::zeroed()
        };
        let grid = Grid::of_meshes(context, world, given)?;
        let bytes = u64::from(fountain.particles) * size_of::<Body>() as u64;
        // Zeros, so that particles not born yet hold finite numbers.
        let bodies = Buffer::zeroed(context, "simulate.bodies", bytes)?;
        let law = Buffer::with_data(context, "simulate.law", &[fountain.law()])?;
        let jets = Buffer::with_data(context, "simulate.jets", &fountain.jets())?;
        let set = set::Simulate {
            law: &law,
            jets: &jets,
            grid: grid.buffers().data,
            grid_bits: grid.buffers().bits,
            bodies: &bodies,
            casters: &world.casters,
        };
        let set = set.bind(context, "simulate")?;
        let kernel = Kernel::compute(context, &shaders::STEP, &[&set], &Constants::new())?;
        Ok(Self { context: context.clone(), fountain, law, bodies, grid, kernel, at: None, ready: false })
    }

    /// Records a change of the fountain's attractor or gravity. The next move restarts the simulation, as if the change had always been in
    /// force. The number of particles does not change.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out.
    pub fn pull(&mut self, commands: &mut Commands, fountain: Fountain) -> Result<()> {
        let fountain = Fountain { particles: self.fountain.particles, ..fountain };
        if fountain == self.fountain {
            return Ok(());
        }
        let law = commands.stage(&self.law, &[fountain.law()])?;
        commands.pass("simulate.pull", |pass| law.iter().for_each(|law| pass.copy_staged(law)));
        (self.fountain, self.at) = (fountain, None);
        Ok(())
    }

    /// Forgets the current step, since the host has moved the casters: the next move restarts the simulation.
    #[cfg(feature = "view")]
    pub(crate) fn forget(&mut self) {
        self.at = None;
    }

    /// Records the passes that move the casters of `world` to their positions at a time. It records as many steps as
    /// [`Simulation::move_to`] would run. `world` must be the world for which this simulation was created; `commands` may record into the
    /// caller's own command buffer.
    ///
    /// # Errors
    /// [`Error::Usage`] if the time is out of range.
    pub fn record(&mut self, commands: &mut Commands, world: &mut World, time_s: f64) -> Result<()> {
        let steps = self.steps_to(world.name(), time_s)?;
        if !steps.is_empty() {
            world.casters_move()?;
            self.fill_grid(commands, world);
            self.at = Some(steps.end - 1);
            steps.for_each(|step| self.step(commands, step));
        }
        Ok(())
    }

    /// Fills the grid, once, with the static meshes of the world.
    fn fill_grid(&mut self, commands: &mut Commands, world: &World) {
        if !self.ready {
            self.grid.record(commands, world);
            self.ready = true;
        }
    }

    /// Returns the steps from the current step to a time; empty if the time is in the current step. For an earlier time, or one more than a
    /// particle's life later, they are the steps of one particle's life up to that time: by its end every particle has been reborn.
    fn steps_to(&self, name: &str, time_s: f64) -> Result<Range<u32>> {
        check_time(name, time_s)?;
        let step = self.fountain.step_at(time_s);
        let life = self.fountain.law().life;
        Ok(match self.at {
            Some(at) if (at..=at + life).contains(&step) => at + 1..step + 1,
            _ => step + 1 - life..step + 1,
        })
    }

    /// Moves the casters of `world`, for which this simulation was created, to their positions at a time. If the last move was no more than
    /// a particle's life earlier, it runs the steps since then. Otherwise it starts one particle's life before the time, since every
    /// particle is reborn within that time. Returns the duration of each step; after such a start, only the duration of the last step.
    /// Nothing is read back ([`World::read_back`]). If the time is in the current step, nothing is done.
    ///
    /// # Errors
    /// [`Error::Usage`] if the time is out of range, [`Error::Gpu`] if the device is lost.
    pub fn move_to(&mut self, world: &mut World, time_s: f64) -> Result<Vec<PassTime>> {
        let mut steps = self.steps_to(world.name(), time_s)?;
        if steps.is_empty() {
            return Ok(Vec::new());
        }
        let (context, last) = (self.context.clone(), steps.end - 1);
        // Until all steps are done, the bodies on the device belong to no known step: an error must leave `None` here.
        let goes_on = self.at.take().is_some_and(|at| at + 1 == steps.start);
        if !goes_on {
            let before = context.submit(|commands| {
                self.fill_grid(commands, world);
                (steps.start..last).for_each(|s| self.step(commands, s));
            });
            if let Err(error) = before {
                self.ready = false;
                self.grid.forget();
                return Err(error);
            }
            steps.start = last;
        }
        let passes = world.write_casters(|commands| steps.for_each(|s| self.step(commands, s)))?;
        self.at = Some(last);
        Ok(passes)
    }

    fn step(&self, commands: &mut Commands, step_number: u32) {
        let particles = self.fountain.particles;
        let [attractor_x, attractor_y, attractor_z] = self.fountain.attractor(step_number);
        let push = StepPush { step_number, particles, attractor_x, attractor_y, attractor_z };
        let [x, y] = groups(u64::from(particles.div_ceil(THREADS)));
        commands.pass("simulate.step", |pass| pass.dispatch(&self.kernel, &push, [x, y, 1]));
    }

    /// Returns the fountain being simulated.
    pub fn fountain(&self) -> Fountain {
        self.fountain
    }

    /// Returns the current state of each particle, a [`Body`].
    pub fn bodies(&self) -> &Buffer {
        &self.bodies
    }

    /// Returns the voxels that particles bounce off; empty before the first step.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}
