//! Flicker: what answers change from frame to frame that the truth does not.

use super::Answers;
use super::truth::Points;
use crate::scene::Scene;
use glam::DVec3;

/// How answers at fixed points change from frame to frame, beside how the truth does.
#[derive(Default)]
pub(super) struct Flicker {
    before: Option<(Answers, Vec<bool>)>,
    squares: f64,
    changes: u64,
}

impl Flicker {
    /// The next frame. Points in a boundary or out of a light are left out.
    pub fn frame(&mut self, answers: Answers, points: &[Points], scene: &Scene) {
        let in_light = |p: &Points| {
            let light = scene.lights[p.light];
            p.positions.iter().map(move |p| light.shines_on(DVec3::from(p.map(f64::from)))).collect::<Vec<_>>()
        };
        let shines: Vec<bool> = points.iter().flat_map(in_light).collect();
        let outside = |i: usize| answers.boundary.get(i) != Some(&true) && shines[i];
        let now: Vec<bool> = (0..shines.len()).map(outside).collect();
        if let Some((before, was)) = &self.before {
            for i in (0..now.len()).filter(|i| now[*i] && was[*i]) {
                let change = f64::from(answers.approximate[i]) - f64::from(before.approximate[i]);
                self.squares += (change - (answers.truth[i] - before.truth[i])).powi(2);
                self.changes += 1;
            }
        }
        self.before = Some((answers, now));
    }

    /// The root mean square of what the changes differ by; none without changes.
    pub fn rms(&self) -> Option<f64> {
        (self.changes > 0).then(|| (self.squares / self.changes as f64).sqrt())
    }
}
