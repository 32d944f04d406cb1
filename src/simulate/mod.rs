//! Particles that the device moves: positions and speeds in buffers, a dispatch a step. Twin: [`crate::reference::twin::simulate`].

use crate::Result;
use crate::gpu::{
    Bindings, Buffer, Commands, Constants, Context, Kernel, Memory, PassTime, Resource, groups, push_struct,
};
use crate::grid::{Grid, GridData};
use crate::scene::{Body, Fountain, Motion, check_time};
use crate::shaders::simulate as shaders;
use crate::world::World;
use bytemuck::Zeroable;

/// Threads of a workgroup.
const THREADS: u32 = 64;

push_struct! {
    /// Twin: StepPush in glsl/simulate/step.comp.
    struct StepPush {
        step_number: u32,
        particles: u32,
        attractor_x: f32,
        attractor_y: f32,
        attractor_z: f32,
    }
}

/// The particles of a world that is a fountain. What they are is a function of the step alone.
pub struct Simulation {
    context: Context,
    fountain: Fountain,
    /// [`Body`]: what they are now.
    bodies: Buffer,
    grid: Grid,
    kernel: Kernel<StepPush>,
    /// The step that the bodies are at; none before the first.
    at: Option<u32>,
}

impl Simulation {
    /// Of a world whose scene is simulated; none of any other.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn of(context: &Context, world: &World) -> Result<Option<Self>> {
        let Ok(Motion::Fountain(fountain)) = world.scene().map(|scene| scene.motion) else { return Ok(None) };
        let place = fountain.place();
        let stands = GridData {
            origin: place.origin,
            voxel: place.voxel,
            per_unit: place.per_unit,
            size: place.size,
            ..GridData::zeroed()
        };
        let mut grid = Grid::standing(context, world, stands)?;
        let bytes = u64::from(fountain.particles) * size_of::<Body>() as u64;
        let bodies = Buffer::new(context, "simulate.bodies", bytes, Memory::Device)?;
        let law = Buffer::with_data(context, "simulate.law", &[fountain.law()])?;
        let jets = Buffer::with_data(context, "simulate.jets", &fountain.jets())?;
        let [data, bits, ..] = grid.buffers();
        let resources = [&law, &jets, data, bits, &bodies, &world.casters].map(|b| Resource::Buffer(b.clone()));
        let set = Bindings::new(context, "simulate", &resources)?;
        let kernel = Kernel::compute(context, &shaders::STEP, &[&set], &Constants::new())?;
        context.submit(|commands| {
            // Until each is born: numbers.
            commands.pass("simulate.clear", |pass| pass.fill(&bodies, 0));
            grid.record(commands, world);
        })?;
        Ok(Some(Self { context: context.clone(), fountain, bodies, grid, kernel, at: None }))
    }

    /// Moves the casters of `world`, which it was made for, to where they are at a time: from step to step where the world goes
    /// on; from anywhere else as many steps before it as a particle lives, after which all have been born. Returns the time of
    /// each step, in the latter case of the last alone. Nothing is read back ([`World::read_back`]), and where the step is the
    /// one that it is at, nothing is done.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where the time is out of range, [`crate::Error::Gpu`] where the device is lost.
    pub fn move_to(&mut self, world: &mut World, time_s: f64) -> Result<Vec<PassTime>> {
        check_time(world.name(), time_s)?;
        let step = self.fountain.step_at(time_s);
        let life = self.fountain.law().life;
        // What stands on the device is at no step until all is done.
        let next = match self.at.take() {
            Some(at) if at == step => {
                self.at = Some(at);
                return Ok(Vec::new());
            }
            Some(at) if (at..=at + life).contains(&step) => at + 1,
            _ => {
                let before = step + 1 - life..step;
                self.context.submit(|commands| before.for_each(|s| self.step(commands, s)))?;
                step
            }
        };
        let passes = world.write_casters(|commands| (next..=step).for_each(|s| self.step(commands, s)))?;
        self.at = Some(step);
        Ok(passes)
    }

    fn step(&self, commands: &mut Commands, step_number: u32) {
        let particles = self.fountain.particles;
        let [attractor_x, attractor_y, attractor_z] = self.fountain.attractor(step_number);
        let push = StepPush { step_number, particles, attractor_x, attractor_y, attractor_z };
        let [x, y] = groups(u64::from(particles.div_ceil(THREADS)));
        commands.pass("simulate.step", |pass| pass.dispatch(&self.kernel, &push, [x, y, 1]));
    }

    /// What is simulated.
    pub fn fountain(&self) -> Fountain {
        self.fountain
    }

    /// [`Body`]: what they are now.
    pub fn bodies(&self) -> &Buffer {
        &self.bodies
    }

    /// What they bounce off.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}
