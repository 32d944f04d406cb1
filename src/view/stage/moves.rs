//! Moves the world of a stage to a new state: on the device if possible, otherwise on the host, and only the parts that have changed.

use super::super::state::State;
use super::{Stage, next_version};
use crate::Result;
use crate::animate::Simulation;
use crate::gpu::{Commands, ReadBack};
use crate::scene::{Camera, Caster, Scene, check_time};
use std::sync::Arc;

/// Particles moved by the device, on their way to the host.
pub(super) struct Simulated {
    read: ReadBack,
    /// Whether the host's scene still lacks the particles' latest positions.
    pub(super) is_moving: bool,
    /// Last frame in which the device moved the particles.
    frame: u64,
}

impl Stage {
    /// Returns the world's scene for threads that outlast a frame: its camera, and a scene with its casters and lights. These are copied
    /// once, and again only after they have changed. `None` while only the device knows the particles' positions.
    pub fn shared(&mut self) -> Option<(Camera, Arc<Scene>)> {
        let camera = self.world.scene().ok()?.camera;
        self.scene_of_now().map(|scene| (camera, scene))
    }

    pub(super) fn scene_of_now(&mut self) -> Option<Arc<Scene>> {
        if self.simulated.as_ref().is_some_and(|simulated| simulated.is_moving) {
            return None;
        }
        let kept = self.kept.take().filter(|(of, _)| *of == self.cast).map(|(_, scene)| scene);
        let scene = kept.or_else(|| self.world.scene().ok().map(|scene| Arc::new(scene.clone())))?;
        self.kept = Some((self.cast, scene.clone()));
        Some(scene)
    }

    /// Moves the world to `state`. Static parts are not updated, even if time has passed.
    pub(super) fn move_world(&mut self, commands: &mut Commands, state: &State) -> Result<()> {
        let (change, was) = (state.change(), self.change);
        let pulls = self.pull != state.pull();
        let moves = pulls || self.of.1 != state.time_s && self.base.moves();
        if !moves && change == was {
            self.of.1 = state.time_s;
            return Ok(());
        }
        let thickens = change.extinction != was.extinction;
        // If the host changes the extinction, the device's particles would be rounded differently.
        let by_device = moves && change.extinction == 1.0 && !thickens && self.base.fountain().is_some();
        if by_device {
            self.simulate(commands, state)?;
        } else if moves || thickens {
            self.replace(commands, state)?;
        }
        let (camera, lights) = change.aimed(&self.base.scene)?;
        let turns = self.world.all_lights() != lights;
        self.world.turn_in(commands, camera, &lights)?;
        (self.of.1, self.pull, self.change) = (state.time_s, state.pull(), change);
        self.version = next_version();
        if moves || thickens || turns {
            self.cast = next_version();
        }
        Ok(())
    }

    /// Moves the particles on the device, and copies them to the host.
    fn simulate(&mut self, commands: &mut Commands, state: &State) -> Result<()> {
        check_time(&self.base.scene.name, state.time_s)?;
        // Reports errors in the changes before anything has moved.
        state.change().aimed(&self.base.scene)?;
        let pulled =
            if self.pull == state.pull() { None } else { Some(self.base.pull(state.attractor, state.gravity)?) };
        if let (None, Some(fountain)) = (&self.simulation, self.base.fountain()) {
            self.simulation = Some(Simulation::new(&self.context, &self.world, fountain)?);
        }
        let Some(simulation) = &mut self.simulation else { return Ok(()) };
        if let Some(fountain) = pulled {
            self.base.set_fountain(fountain);
        }
        if let Some(fountain) = self.base.fountain() {
            simulation.pull(commands, fountain)?;
        }
        simulation.record(commands, &mut self.world, state.time_s)?;
        if self.simulated.is_none() {
            let bytes = (self.base.scene.particles.len() * size_of::<Caster>()) as u64;
            let read = ReadBack::new(&self.context, "view.simulated", bytes)?;
            self.simulated = Some(Simulated { read, is_moving: true, frame: 0 });
        }
        if let Some(simulated) = &mut self.simulated {
            commands.read_back(&self.world.casters, &simulated.read);
            (simulated.is_moving, simulated.frame) = (true, commands.frame());
        }
        Ok(())
    }

    /// Takes the particles' positions from a completed frame into the host's scene, if they have not moved since.
    pub(super) fn take_particles(&mut self, over: u64) -> Result<()> {
        let is_over = |simulated: &&mut Simulated| simulated.is_moving && simulated.frame <= over;
        let Some(simulated) = self.simulated.as_mut().filter(is_over) else { return Ok(()) };
        let Some(casters) = simulated.read.read::<Caster>(over, self.base.scene.particles.len())? else {
            return Ok(());
        };
        self.world.particles_are(&casters)?;
        simulated.is_moving = false;
        self.base.scene.particles.clone_from(&self.world.scene()?.particles);
        (self.version, self.cast) = (next_version(), next_version());
        Ok(())
    }

    /// Moves the animated parts on the host, and copies those that have changed to the device. On failure, everything stays as it was.
    fn replace(&mut self, commands: &mut Commands, state: &State) -> Result<()> {
        let animation = self.base.animation.clone();
        if self.pull != state.pull() {
            self.base.set_fountain(self.base.pull(state.attractor, state.gravity)?);
        }
        let moved = self.base.parts_at(state.time_s).and_then(|mut parts| {
            let base = &mut self.base.scene;
            parts.swap(base);
            let change = state.change();
            let replaced = match parts.are_lights() && change.extinction == self.change.extinction {
                true => change.aimed(base).map(|_| ()),
                false => change.of(base).and_then(|scene| self.world.replace_in(commands, &scene)),
            };
            if replaced.is_err() {
                parts.swap(base);
            }
            replaced
        });
        match &moved {
            Err(_) => self.base.animation = animation,
            Ok(()) => {
                // The device's next simulation starts from the beginning.
                self.simulation.iter_mut().for_each(Simulation::forget);
                self.simulated.iter_mut().for_each(|simulated| simulated.is_moving = false);
            }
        }
        moved
    }
}
