//! What a picture blends, in its order. The device sorts casters. The host sorts them where volumes are blended among them, since it has to
//! know how many casters come before each volume.

use super::FarToNear;
use crate::gpu::{Buffer, Commands, Context, Memory};
use crate::scene::{Blended, View, far_to_near};
use crate::world::{Made, Parts, World};
use crate::{Error, Result};
use std::cell::Cell;

/// Casters and volumes from far to near.
pub(super) struct Blending {
    /// Runs of casters, by their places in the order, and the volumes between them.
    pub runs: Vec<Blended>,
    /// How many casters these are.
    pub casters: u32,
    /// Indices of casters, from far to near.
    pub order: Buffer,
    /// The sort; none where the host sorts, and where there is nothing to sort.
    sort: Option<FarToNear>,
    /// Whether the order is out of date, and is sorted with the next picture.
    stale: Cell<bool>,
    /// What was last sorted.
    made: Made,
}

impl Blending {
    /// For pictures of `world` as it is now, as `camera` sees it.
    ///
    /// # Errors
    /// As [`Blending::look`]; [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let sorts = world.caster_capacity() > 0 && !world.kinds().volumes;
        let sort = if sorts { Some(FarToNear::new(context, world)?) } else { None };
        let order = match &sort {
            Some(sort) => sort.sorted().clone(),
            None => Buffer::new(context, "picture.order", 4 * u64::from(world.caster_capacity()), Memory::Device)?,
        };
        let made = Made::of(Parts::CASTERS);
        let mut blending = Self { runs: Vec::new(), casters: 0, order, sort, stale: Cell::new(false), made };
        blending.look(world, camera, true)?;
        Ok(blending)
    }

    /// Takes over the world as it is now, and a camera, of which `turned` says whether it is another than before.
    ///
    /// # Errors
    /// [`Error::Refused`] where the host sorts, and knows no scene.
    pub fn look(&mut self, world: &World, camera: &View, turned: bool) -> Result<()> {
        let casters = world.caster_count();
        let moved = self.made.make(world) || turned;
        if self.sort.is_some() || casters == 0 {
            self.runs.clear();
            self.runs.extend((casters > 0).then_some(Blended::Casters(0..casters)));
            self.casters = casters;
            self.stale.set((self.stale.get() || moved) && casters > 0);
            return Ok(());
        }
        let needs = "a scene that the host knows, for volumes in a picture: draw these otherwise";
        let scene = world.scene().map_err(|_| Error::Refused { needs: needs.into() })?;
        let order = far_to_near(scene, camera);
        self.order.write(&order.casters)?;
        (self.runs, self.casters) = (order.blended().collect(), order.casters.len() as u32);
        Ok(())
    }

    /// Sorts the casters, where the device does that and they or the camera have moved.
    pub fn record(&self, commands: &mut Commands, camera: &View) {
        if let (Some(sort), true) = (&self.sort, self.stale.take()) {
            sort.record(commands, camera, self.casters);
        }
    }
}
