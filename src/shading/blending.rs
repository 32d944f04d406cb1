//! The casters and volumes that a picture blends, in order. The device sorts casters; the host counts how many precede
//! each volume.

use super::FarToNear;
use crate::gpu::{Buffer, Commands, Context, Memory};
use crate::scene::{Blended, View, blended, volumes_among};
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};
use std::cell::Cell;
use std::ops::Range;

/// Casters and volumes from far to near.
pub(super) struct Blending {
    /// Runs of casters, by their positions in the order, and the volumes between them.
    pub runs: Vec<Blended>,
    /// Number of casters in the order.
    pub casters: u32,
    /// Indices of casters, from far to near.
    pub order: Buffer,
    /// Maximum number of casters that can be sorted.
    room: u32,
    /// The sort; `None` if there is nothing to sort.
    sort: Option<FarToNear>,
    /// Whether the order is out of date, and is sorted with the next picture.
    stale: Cell<bool>,
    /// Number of times that casters or the camera have moved.
    moves: u64,
    /// State that was last sorted.
    made: BuildStamp,
}

impl Blending {
    /// Prepares pictures of the current `world`, as `camera` sees it.
    ///
    /// # Errors
    /// Same as [`Blending::look`]; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, camera: &View) -> Result<Self> {
        let room = FarToNear::room(world);
        let sort = if room > 0 { Some(FarToNear::new(context, world)?) } else { None };
        let order = match &sort {
            Some(sort) => sort.sorted().clone(),
            None => Buffer::new(context, "picture.order", 4, Memory::Device)?,
        };
        let made = BuildStamp::of(Parts::CASTERS);
        let mut blending =
            Self { runs: Vec::new(), casters: 0, order, room, sort, stale: Cell::default(), moves: 0, made };
        blending.look(world, camera, true)?;
        Ok(blending)
    }

    /// Updates to the current world and to `camera`; `turned` is set if the camera differs from the previous one.
    ///
    /// # Errors
    /// [`Error::Refused`] if there are volumes but the host knows no scene; [`Error::Input`] if there are more casters than can be sorted.
    pub fn look(&mut self, world: &World, camera: &View, turned: bool) -> Result<()> {
        let moved = self.made.make(world) || turned;
        self.casters = world.caster_count() - world.cell_count();
        if self.casters > self.room {
            let cause = "it has more casters beside volumes' cells than this renderer was made for";
            return Err(Error::input(world.name(), cause, "make a new one"));
        }
        self.stale.set((self.stale.get() || moved) && self.casters > 0);
        self.moves += u64::from(moved);
        let mut volumes = Vec::new();
        if world.kinds().volumes {
            let needs = "a scene that the host knows, for volumes in a picture: draw these otherwise";
            let scene = world.scene().map_err(|_| Error::Refused(needs.into()))?;
            volumes = volumes_among(scene, camera);
        }
        self.runs = blended(self.casters, &volumes).collect();
        Ok(())
    }

    /// Returns the maximum number of casters that can be sorted.
    pub fn room(&self) -> u32 {
        self.room
    }

    /// Returns how often casters or the camera have moved, counting the first time they were looked at.
    pub fn moves(&self) -> u64 {
        self.moves
    }

    /// Forces a sort with the next picture, even if nothing has moved.
    pub fn forget(&self) {
        self.stale.set(self.casters > 0);
    }

    /// Returns the casters at positions `part` of the order, and the volumes that come before one of these, or after the last caster of
    /// all.
    pub fn within(&self, part: &Range<u32>) -> impl Iterator<Item = Blended> {
        let (part, casters, mut behind) = (part.clone(), self.casters, 0);
        self.runs.iter().filter_map(move |next| match next {
            Blended::Casters(places) => {
                behind = places.end;
                let places = places.start.max(part.start)..places.end.min(part.end);
                (!places.is_empty()).then_some(Blended::Casters(places))
            }
            Blended::Volume(volume) => {
                let is_last = behind == casters && part.end >= behind;
                (is_last || part.contains(&behind)).then_some(Blended::Volume(*volume))
            }
        })
    }

    /// Sorts the casters, if they or the camera have moved.
    pub fn record(&self, commands: &mut Commands, camera: &View) {
        if let (Some(sort), true) = (&self.sort, self.stale.take()) {
            sort.record(commands, camera, self.casters);
        }
    }
}
