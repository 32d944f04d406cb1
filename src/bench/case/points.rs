//! Number of points queried per case, and per batch.

use crate::Result;
use crate::bench::case::effort::LOOKUPS;
use crate::bench::case::truth::Points;
use crate::gpu::Context;
use crate::query::{PointBatch, Query};
use crate::technique::Technique;

/// Maximum number of lights that each get a full set of points. With more lights, the total number of points stays that
/// of this many full sets, divided between all lights.
pub(in crate::bench) const FULLY_ASKED: usize = 8;

/// Minimum number of points per light, however many lights there are.
const LEAST_POINTS: usize = 32;

/// Returns the number of points per light if there are `lights` lights: `points` up to [`FULLY_ASKED`] lights, fewer
/// beyond.
pub(in crate::bench) fn of_each_light(points: usize, lights: usize) -> usize {
    if lights <= FULLY_ASKED { points } else { (points * FULLY_ASKED / lights).max(LEAST_POINTS.min(points)) }
}

/// Splits all points, in order, into lists of at most [`LOOKUPS`].
pub(in crate::bench) fn at_once<'a>(all: impl IntoIterator<Item = &'a Points>) -> Vec<Vec<PointBatch<'a>>> {
    let (mut lists, mut room) = (vec![vec![]], LOOKUPS);
    for points in all {
        let (mut positions, mut normals) = (&points.positions[..], &points.normals[..]);
        while !positions.is_empty() {
            if room == 0 {
                lists.push(vec![]);
                room = LOOKUPS;
            }
            let (now, later) = positions.split_at(room.min(positions.len()));
            let (now_normals, later_normals) = normals.split_at(now.len().min(normals.len()));
            let part = PointBatch { light: points.light, points: now, normals: now_normals };
            lists.last_mut().into_iter().for_each(|list| list.push(part));
            room -= now.len();
            (positions, normals) = (later, later_normals);
        }
    }
    lists
}

/// Looks up the visibility of all lights at their points, about a million at a time.
pub(in crate::bench) fn ask<'a>(
    context: &Context,
    technique: &dyn Technique,
    all: impl IntoIterator<Item = &'a Points>,
) -> Result<Vec<f32>> {
    let mut answers = Vec::new();
    for list in at_once(all) {
        answers.extend(Query::of_lights(context, &list)?.ask(&technique.answer())?);
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Splits the points of four lights; one has enough points for two full lists, another has none. No point may be
    /// lost, and all must keep their order.
    #[test]
    fn points_are_asked_at_most_a_million_at_a_time() {
        let position = |light: usize, i: usize| [light as f32, i as f32, 0.0];
        let of = |(light, count): (usize, usize)| {
            Points::in_space(light, (0..count).map(|i| position(light, i)).collect(), vec![0.5; count])
        };
        let all: Vec<_> = [5, 2 * LOOKUPS, 0, 3].into_iter().enumerate().map(of).collect();
        let lists = at_once(&all);
        let sizes: Vec<usize> = lists.iter().map(|list| list.iter().map(|part| part.points.len()).sum()).collect();
        assert_eq!(sizes, [LOOKUPS, LOOKUPS, 8]);
        let asked = lists.iter().flatten().flat_map(|part| part.points);
        assert!(asked.eq(all.iter().flat_map(|points| &points.positions)));
        let lights: Vec<_> = lists.iter().map(|list| list.iter().map(|part| part.light).collect::<Vec<_>>()).collect();
        assert_eq!(lights, [vec![0, 1], vec![1], vec![1, 3]]);
        assert!(at_once(&Vec::<Points>::new()).concat().is_empty());
    }

    #[test]
    fn many_lights_share_the_points_of_few() {
        assert_eq!([1, 3, 8].map(|lights| of_each_light(65536, lights)), [65536; 3]);
        assert_eq!([9, 32, 1024].map(|lights| of_each_light(65536, lights)), [58254, 16384, 512]);
        assert_eq!(([1024, 100_000].map(|lights| of_each_light(2048, lights)), of_each_light(8, 64)), ([32, 32], 8));
    }
}
