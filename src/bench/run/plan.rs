//! What a run measures: a list of rows.

use crate::Error;
use crate::bench::{Effort, Frames, Margins, Results, Row, Shard};
use crate::gpu::Context;
use crate::technique::Spec;
use std::ops::Range;

/// A scene, with a spec for each of its rows. The spec also determines how the row's picture is shaded.
pub struct PlannedScene<'a> {
    /// The scene in each frame.
    pub frames: Frames<'a>,
    /// Specs, in the order in which they are measured.
    pub specs: Vec<Spec>,
}

/// The rows of a run, scene by scene.
pub struct Plan<'a> {
    /// How much each row measures.
    pub effort: Effort,
    /// Whether the pipelines of a scene's rows are created before the first of them is measured.
    pub makes_pipelines_first: bool,
    /// Rows from an earlier look at the same scenes, which show which builds are slow.
    pub earlier: &'a [Row],
    /// An earlier run: a row that seems slower than in that run is measured again.
    pub baseline: Option<(&'a Results, Margins)>,
    pub(super) scenes: Vec<PlannedScene<'a>>,
    /// The shard that this process measures; `None` for all rows.
    shard: Option<Shard>,
    /// The rows of the list; `None` for rows not measured yet.
    pub(super) rows: Vec<Option<Row>>,
}

impl PlannedScene<'_> {
    /// The scene's name.
    pub fn name(&self) -> &str {
        self.frames.states.first().map_or("", |first| first.name.as_str())
    }
}

impl<'a> Plan<'a> {
    /// Creates a plan in which no row is measured yet.
    pub fn new(effort: Effort, scenes: Vec<PlannedScene<'a>>) -> Self {
        let rows = vec![None; scenes.iter().map(|scene| scene.specs.len()).sum()];
        Self { effort, makes_pipelines_first: false, earlier: &[], baseline: None, scenes, shard: None, rows }
    }

    /// Returns scene and spec of every row.
    pub fn list(&self) -> Vec<(&str, &Spec)> {
        self.scenes.iter().flat_map(|scene| scene.specs.iter().map(|spec| (scene.name(), spec))).collect()
    }

    /// Keeps only the rows of one shard: `number` of `of`.
    pub fn take_shard(&mut self, [number, of]: [usize; 2]) -> Shard {
        let list: Vec<_> = self.list().into_iter().map(|(scene, spec)| (scene, spec.to_string())).collect();
        let shard = Shard::of_list(number, of, &list);
        self.shard = Some(shard.clone());
        shard
    }

    /// Returns the list indices of the rows that this process measures.
    fn places(&self) -> impl Iterator<Item = usize> {
        (0..self.rows.len()).filter(|place| self.shard.as_ref().is_none_or(|shard| shard.has(*place)))
    }

    /// Returns scene and spec of the rows that this process measures.
    pub fn share(&self) -> Vec<(&str, &Spec)> {
        let list = self.list();
        self.places().map(|place| list[place]).collect()
    }

    /// Accepts rows that have already been measured: one entry per row of [`Plan::share`].
    pub fn keep(&mut self, kept: Vec<Option<Row>>) {
        let places: Vec<usize> = self.places().collect();
        places.into_iter().zip(kept).for_each(|(place, row)| self.rows[place] = row);
    }

    /// Returns the number of rows that this process measures.
    pub fn count(&self) -> usize {
        self.places().count()
    }

    /// Returns the number of rows not measured yet.
    pub fn left(&self) -> usize {
        self.left_in(0..self.rows.len()).len()
    }

    /// Returns the rows measured so far.
    pub fn measured(&self) -> Vec<Row> {
        self.rows.iter().flatten().cloned().collect()
    }

    /// Returns the list indices of the remaining rows within a part of the list.
    pub(super) fn left_in(&self, part: Range<usize>) -> Vec<usize> {
        self.places().filter(|place| part.contains(place) && self.rows[*place].is_none()).collect()
    }

    /// Returns the error for a run that was ended by a lost device.
    pub fn lost(&self, context: &Context) -> Error {
        Error::Gpu {
            operation: "go on with",
            name: context.features().name.clone(),
            cause: format!("the device is lost, and {} of {} rows are not measured", self.left(), self.count()).into(),
            way_out: "repeat the command; if it is lost again, update the driver".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::standard;
    use crate::scene::Scene;
    use crate::shading::parse;

    /// Plans two scenes of two rows each. The second of two shards must have every other row. One of its rows is
    /// already measured, so one must be left.
    #[test]
    fn a_shard_keeps_its_own_rows() {
        let scenes = ["cornell", "houses"].map(|name| [Scene::load(name, 0.0).expect("built in")]);
        let planned = |scene: &'static str, states| PlannedScene {
            frames: Frames::from(states),
            specs: ["none", "shadow-map"].map(|spec| parse(spec).expect(scene).remove(0)).into(),
        };
        let both = vec![planned("cornell", &scenes[0][..]), planned("houses", &scenes[1][..])];
        let mut plan = Plan::new(standard::EFFORT, both);
        assert_eq!((plan.list().len(), plan.count(), plan.left()), (4, 4, 4));
        assert_eq!(plan.take_shard([2, 2]).share(), 2);
        let named = |(scene, spec): (&str, &Spec)| format!("{scene} {}", spec.entry.name);
        let share: Vec<String> = plan.share().into_iter().map(named).collect();
        assert_eq!(share, ["cornell shadow-map", "houses shadow-map"]);
        plan.keep(vec![None, Some(Row::default())]);
        assert_eq!((plan.count(), plan.left(), plan.measured().len()), (2, 1, 1));
        assert_eq!((plan.left_in(0..2), plan.left_in(2..4)), (vec![1], vec![]));
    }
}
