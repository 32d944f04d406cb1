//! The truth of a scene in each of its frames.

use crate::Result;
use crate::bench::case::effort::Effort;
use crate::bench::case::frames::States;
use crate::bench::case::points::of_each_light;
use crate::bench::case::sampled_errors::moments;
use crate::bench::case::truth::{Known, LitPicture, Truth, Wanted};
use crate::reference::truth::{Casters, bounds, points_outside};
use crate::scene::Scene;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of points per light at which a moving world is watched; fewer with many lights.
const WATCHED: usize = 2048;

/// Minimum number of seen points per frame of a moving world.
const LEAST_SEEN: usize = 256;

/// The truths that `with_case` owns.
#[derive(Clone, Copy)]
pub(in crate::bench) struct FrameTruths<'a> {
    pub states: States<'a>,
    /// The truth in each frame, for states that are in memory.
    pub truths: &'a [Truth<'a>],
    /// The parts of the truth computed so far, for each frame.
    pub known: &'a [Arc<Known>],
}

/// The boxes that contain the space points.
pub(in crate::bench) struct FrameBounds {
    /// The box of each frame; `None` without casters.
    each: Vec<Option<[DVec3; 2]>>,
    /// The box around all of them.
    all: Option<[DVec3; 2]>,
}

impl FrameBounds {
    pub fn of(states: States) -> Result<Self> {
        let each =
            (0..states.count()).map(|frame| Ok(bounds(states.at(frame)?.as_ref()))).collect::<Result<Vec<_>>>()?;
        let all = each.iter().copied().flatten().reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
        Ok(Self { each, all })
    }

    /// Returns points per light within the box around all frames.
    pub fn points(&self, lights: usize, of: impl Fn(usize, [DVec3; 2]) -> Vec<[f32; 3]>) -> Vec<Vec<[f32; 3]>> {
        (0..lights).map(|light| self.all.map_or_else(Vec::new, |all| of(light, all))).collect()
    }
}

/// Returns which parts of the truth a case needs in each frame; none of them is computed yet.
pub(in crate::bench) fn known(states: States, first: &Scene, effort: &Effort, bounds: &FrameBounds) -> Vec<Arc<Known>> {
    let (count, lights) = (states.count(), first.lights.len());
    let watch = |casters: &Casters| {
        bounds.points(lights, |light, all| points_outside(casters, all, light, of_each_light(WATCHED, lights)))
    };
    let watched = Arc::new(if count > 1 { watch(&Casters::new(first)) } else { Vec::new() });
    let seen = (effort.seen_points / count).max(LEAST_SEEN.min(effort.seen_points));
    let of = |(frame, bounds): (usize, &Option<[DVec3; 2]>)| {
        Arc::new(Known::new(Wanted {
            extent: effort.truth,
            points: of_each_light(effort.space_points, lights),
            seen: (seen, frame as u64),
            picture: effort.picture,
            bounds: *bounds,
            watched: watched.clone(),
        }))
    };
    bounds.each.iter().enumerate().map(of).collect()
}

/// Creates the truths of states that are in memory.
pub(in crate::bench) fn held_truths<'a>(states: States<'a>, known: &[Arc<Known>]) -> Vec<Truth<'a>> {
    match states {
        States::Held(states) => {
            states.iter().zip(known).map(|(scene, known)| Truth::of(scene, known.clone())).collect()
        }
        States::Read { .. } => Vec::new(),
    }
}

/// Computes the parts of every frame's truth that do not depend on a technique, until `stop` is set.
pub(in crate::bench) fn compute_ahead(truths: &[Truth], stop: &AtomicBool) {
    let moments = moments(truths.len());
    let stopped = || stop.load(Ordering::Relaxed);
    for (frame, truth) in truths.iter().enumerate() {
        if !stopped() {
            truth.seen();
        }
        if truths.len() > 1 && !stopped() {
            truth.watched();
        }
        let has_reasons = truth.known().has_reasons() && moments.contains(&frame);
        if has_reasons && !stopped() {
            truth.space();
        }
        if has_reasons && !stopped() {
            truth.surface();
        }
        if moments.last() == Some(&frame) && truth.known().has_picture() && !stopped() {
            truth.picture();
        }
    }
}

impl<'a> FrameTruths<'a> {
    /// Calls `ask` with the truth in a frame. A state that is not in memory is read, and freed afterwards.
    pub fn with<R>(&self, frame: usize, ask: impl FnOnce(&Truth) -> Result<R>) -> Result<R> {
        if let Some(truth) = self.truths.get(frame) {
            return ask(truth);
        }
        let state = self.states.at(frame)?;
        ask(&Truth::of(&state, self.known[frame].clone()))
    }

    /// Returns the last frame's picture if one is wanted. If its state is in memory, it is rendered now.
    pub fn picture(&self) -> Option<&'a LitPicture> {
        let known = self.known.last().filter(|known| known.has_picture())?;
        self.truths.last().map_or_else(|| known.picture(), Truth::picture)
    }

    /// Renders the last frame's picture; `None` if it is not wanted or would take too long.
    pub fn make_picture(&self) -> Result<Option<&'a LitPicture>> {
        let Some(last) = self.known.last().filter(|known| known.has_picture()) else { return Ok(None) };
        if !last.has_tried_picture() {
            self.with(self.known.len() - 1, |truth| {
                truth.picture();
                Ok(())
            })?;
        }
        Ok(last.picture())
    }
}
