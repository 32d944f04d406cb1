//! Flicker: frame-to-frame changes in the answers that do not occur in the truth.

use crate::bench::Answers;
use crate::bench::case::truth::Points;
use crate::scene::Scene;
use glam::DVec3;

/// Frame-to-frame changes of answers at fixed points, compared with the changes of the truth.
#[derive(Default)]
pub(in crate::bench) struct Flicker {
    before: Option<(Answers, Vec<bool>)>,
    squares: f64,
    changes: u64,
}

impl Flicker {
    /// Adds the next frame, leaving out points that a light does not shine on.
    pub fn frame(&mut self, answers: Answers, points: &[Points], scene: &Scene) {
        let in_light = |p: &Points| {
            let light = scene.lights[p.light];
            p.positions.iter().map(move |p| light.shines_on(DVec3::from(p.map(f64::from)))).collect::<Vec<_>>()
        };
        let shines: Vec<bool> = points.iter().flat_map(in_light).collect();
        if let Some((before, was)) = &self.before {
            for i in (0..shines.len()).filter(|i| shines[*i] && was[*i]) {
                let change = f64::from(answers.approximate[i]) - f64::from(before.approximate[i]);
                self.squares += (change - (answers.truth[i] - before.truth[i])).powi(2);
                self.changes += 1;
            }
        }
        self.before = Some((answers, shines));
    }

    /// Returns the root mean square of the differences between changes; `None` without changes.
    pub fn rms(&self) -> Option<f64> {
        (self.changes > 0).then(|| (self.squares / self.changes as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::on_the_axis;

    /// Two points over three frames. The answer at the first has a constant error, which is not flicker. At the second
    /// the truth stays constant while the answer changes by an eighth, and then by a quarter; the second change counts
    /// although the point is then nearer to a shadow's edge than the resolution.
    #[test]
    fn what_changes_beside_the_truth() {
        let scene = on_the_axis(&[(0.0, 0.5, 1.0)]);
        let points = [Points::in_space(0, vec![[0.0; 3], [0.1; 3]], vec![0.5, 0.5])];
        let frame = |approximate: [f32; 2], truth: [f64; 2], second: bool| Answers {
            approximate: approximate.to_vec(),
            truth: truth.to_vec(),
            within: vec![false, second],
            casters: vec![],
        };
        let mut flicker = Flicker::default();
        assert_eq!(flicker.rms(), None);
        flicker.frame(frame([0.75, 0.5], [0.5, 0.5], false), &points, &scene);
        assert_eq!(flicker.rms(), None, "one frame has no change");
        flicker.frame(frame([1.0, 0.625], [0.75, 0.5], false), &points, &scene);
        assert_eq!(flicker.rms(), Some((0.125f64 * 0.125 / 2.0).sqrt()));
        flicker.frame(frame([0.5, 0.375], [0.25, 0.5], true), &points, &scene);
        assert_eq!(flicker.rms(), Some(((0.125f64.powi(2) + 0.25f64.powi(2)) / 4.0).sqrt()));
    }
}
