//! Errors in opaque shadows, classified by the caster's distance from the light and from the shadowed surface.

use crate::bench::Answers;
use serde::{Deserialize, Serialize};

/// Lower bounds of the distance classes, as fractions of the diagonal of the box around all meshes. Each class spans an
/// octave, but the first also includes all nearer distances, and the last all farther ones.
pub const CLASSES: [f64; 6] = [0.0, 1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0];

/// Errors at surface points that a mesh shadows fully, classified in two ways: by the distance from the light to the
/// first mesh on the ray, and by the distance from the last mesh on the ray to the point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CasterError {
    /// Classes by distance to the light. Absent if all lights are infinitely far away.
    pub from_light: Option<Vec<CasterClass>>,
    /// Classes by distance to the point.
    pub from_receiver: Vec<CasterClass>,
}

/// Points whose casters are in the same class of distances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CasterClass {
    /// Lower bound of the class, as a fraction of the diagonal of the box around all meshes. The next class begins
    /// where this one ends.
    pub from: f64,
    /// Number of points.
    pub points: u64,
    /// Mean of the answers, all of which should be 0. Absent without points.
    pub mean_abs: Option<f64>,
    /// Number of points where the answer exceeds one half.
    pub leaks: u64,
}

impl Answers {
    /// Returns errors by the distance of the caster; `None` if no point is in a mesh's shadow.
    pub fn caster_error(&self) -> Option<CasterError> {
        let [from_light, from_receiver] = [0, 1].map(|end| {
            let mut classes = CLASSES.map(|from| CasterClass { from, points: 0, mean_abs: None, leaks: 0 });
            let mut sums = [0.0; CLASSES.len()];
            for (point, distances) in self.casters.iter().enumerate() {
                let Some(at) = CLASSES.iter().rposition(|from| *from <= distances[end]) else { continue };
                if distances[end].is_finite() {
                    classes[at].points += 1;
                    classes[at].leaks += u64::from(self.approximate[point] > 0.5);
                    sums[at] += f64::from(self.approximate[point]);
                }
            }
            for (class, sum) in classes.iter_mut().zip(sums) {
                class.mean_abs = (class.points > 0).then(|| sum / class.points as f64);
            }
            classes.iter().any(|class| class.points > 0).then(|| classes.to_vec())
        });
        Some(CasterError { from_light, from_receiver: from_receiver? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In both classifications each shadowed point is in one class, even if it lies within the resolution of the
    /// shadow's edge. Lit points are in no class. Points under an infinitely distant light have no distance from the
    /// light.
    #[test]
    fn each_point_is_in_one_class() {
        let far = f64::INFINITY;
        let answers = Answers {
            approximate: vec![1.0, 0.25, 0.5, 0.75, 1.0, 0.5],
            truth: vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            within: vec![false, false, false, false, false, true],
            casters: vec![[0.0, 3.0], [0.01, 0.25], [0.02, 0.03], [far, 0.0], [far, far], [0.0, 0.0]],
        };
        let class = |from, points, mean_abs, leaks| CasterClass { from, points, mean_abs, leaks };
        let found = answers.caster_error().expect("points in shadow");
        let by_light = found.from_light.expect("lights have places");
        assert_eq!(by_light[0], class(0.0, 3, Some(1.75 / 3.0), 1));
        assert_eq!(by_light[1], class(1.0 / 64.0, 1, Some(0.5), 0));
        assert_eq!(by_light[2..].iter().map(|c| c.points).sum::<u64>(), 0);
        assert_eq!(by_light[5], class(0.25, 0, None, 0));
        let receivers: Vec<_> = found.from_receiver.iter().map(|c| (c.points, c.mean_abs, c.leaks)).collect();
        let none = (0, None, 0);
        assert_eq!(receivers, [(2, Some(0.625), 1), (1, Some(0.5), 0), none, none, none, (2, Some(0.625), 1)]);
        let sun = Answers { approximate: vec![0.0], casters: vec![[far, 0.5]], ..Answers::default() };
        assert_eq!(sun.caster_error().expect("one").from_light, None);
        assert_eq!(Answers { casters: vec![[far; 2]], ..sun }.caster_error(), None);
    }
}
