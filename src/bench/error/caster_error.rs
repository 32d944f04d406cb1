//! Errors in opaque shadows, by how far the caster is from the light and from the shadowed surface.

use crate::bench::Answers;
use serde::{Deserialize, Serialize};

/// Where the classes of distances begin, as shares of the diagonal of the box about all meshes. Each class spans an
/// octave, but the first also takes all nearer distances, and the last all farther ones.
pub const CLASSES: [f64; 6] = [0.0, 1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0];

/// Errors at surface points that a mesh shadows fully, sorted into classes of distances in two ways: by the distance
/// from the light to the first mesh on the way to the point, and by that from the last mesh on the way to the point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CasterError {
    /// By the distance to the light. Absent where all lights are infinitely far.
    pub from_light: Option<Vec<CasterClass>>,
    /// By the distance to the point.
    pub from_receiver: Vec<CasterClass>,
}

/// Points whose caster is about as far away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CasterClass {
    /// The least distance of the class, as a share of the diagonal of the box about all meshes. The next class begins
    /// where this one ends.
    pub from: f64,
    /// How many points.
    pub points: u64,
    /// Mean of the answers, all of which should be 0. Absent without points.
    pub mean_abs: Option<f64>,
    /// Points at which the answer says more than half.
    pub leaks: u64,
}

impl Answers {
    /// Errors by the distance of the caster; none without points in a mesh's shadow.
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

    /// In either sorting, each shadowed point is in one class, even if it lies within the resolution of the shadow's
    /// edge. Lit points are in no class. Points under a light that is infinitely far have no distance from the light.
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
