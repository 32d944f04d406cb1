//! CPU twin of glsl/shading/far_to_near.glsl: the keys by which a picture's casters are sorted, in f32, and the order of casters at the
//! same distance.

use super::bins::caster_order;
use super::order::{float_order, sort};
use super::splat::strand_axis;
use crate::scene::{Caster, View};
use glam::Vec3;

/// Returns each caster's distance in front of the camera, measured at its centre, as an integer that falls as the distance rises.
pub fn far_to_near(camera: &View, casters: &[Caster]) -> Vec<u32> {
    let forward = Vec3::from(camera.forward);
    let middle = |c: &Caster| Vec3::from(c.position) - Vec3::from(camera.origin) + 0.5 * strand_axis(c);
    casters.iter().map(|caster| !float_order(middle(caster).dot(forward))).collect()
}

/// Longest run of casters at the same distance that is ordered by their values. Twin: LONGEST_RUN.
const LONGEST_RUN: usize = 256;

/// Returns the indices of casters from far to near by their `keys`; equal keys are ordered by the casters' values, but in long runs by
/// index. Twin:
/// glsl/shading/far_to_near_ties.comp.
pub fn order(keys: &[u32], casters: &[Caster]) -> Vec<u32> {
    let mut order = sort(keys);
    for run in order.chunk_by_mut(|a, b| keys[*a as usize] == keys[*b as usize]).filter(|run| run.len() <= LONGEST_RUN)
    {
        run.sort_by(|a, b| caster_order(&casters[*a as usize], &casters[*b as usize]));
    }
    order
}
