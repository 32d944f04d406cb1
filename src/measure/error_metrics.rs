//! How far approximate visibility is from the truth, over a set of points.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Statistics of `approximate − truth`, both in [0, 1], over the points outside the boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointError {
    /// How many points. Absent in files of schema 1.
    #[serde(default)]
    pub points: Option<u64>,
    /// Mean of the absolute difference.
    pub mean_abs: f64,
    /// Signed mean: positive is too bright.
    pub bias: f64,
    /// Root mean square.
    pub rms: f64,
    /// 99th percentile of the absolute difference (nearest rank).
    pub p99: f64,
    /// Largest absolute difference.
    pub max: f64,
    /// Points that no light reaches and the answer says more than half. Absent in files of schema 1.
    #[serde(default)]
    pub leaks: Option<u64>,
    /// Points that all light reaches and the answer says less than half. Absent in files of schema 1.
    #[serde(default)]
    pub false_shadows: Option<u64>,
    /// The points nearer to where an opaque shadow begins or ends than the representation resolves. Absent where nothing
    /// opaque casts, and in files of schema 1.
    #[serde(default)]
    pub boundary: Option<BoundaryError>,
}

/// Statistics over the points in the boundary of opaque shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundaryError {
    /// How many points.
    pub points: u64,
    /// Mean of the absolute difference; absent without points.
    pub mean_abs: Option<f64>,
    /// As [`PointError::leaks`].
    pub leaks: u64,
    /// As [`PointError::false_shadows`].
    pub false_shadows: u64,
}

/// Answers at points, with the truth there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// What a technique says.
    pub approximate: Vec<f32>,
    /// What is.
    pub truth: Vec<f64>,
    /// Whether each point is in the boundary of an opaque shadow; empty where nothing opaque casts.
    pub boundary: Vec<bool>,
    /// How far the nearest mesh on the way to the light is from the light and from each point, parts of the diagonal of all meshes:
    /// infinite where there is none. Empty for points that are on no surface.
    pub casters: Vec<[f64; 2]>,
}

/// Compares `approximate` with `truth`, point by point. No points have no error, not one of zero: `None`.
///
/// # Errors
/// A value that is not a number is a failure that names its point, as is a difference in length.
pub fn point_error(approximate: &[f32], truth: &[f64]) -> Result<Option<PointError>> {
    let answers = Answers { approximate: approximate.to_vec(), truth: truth.to_vec(), ..Answers::default() };
    answers.error()
}

impl Answers {
    /// What they are off by: the points of the boundary by themselves. `None` without points outside of it.
    ///
    /// # Errors
    /// As [`point_error`].
    pub fn error(&self) -> Result<Option<PointError>> {
        let (count, truths, flags) = (self.approximate.len(), self.truth.len(), self.boundary.len());
        if count != truths || (flags != 0 && flags != count) {
            let cause = format!("{count} values for {truths} points, {flags} of which are looked at");
            return Err(Error::input("visibility", cause, "report this as a bug"));
        }
        let (mut absolute, mut error, mut beside) =
            (Vec::with_capacity(count), PointError::default(), BoundaryError::default());
        let (mut leaks, mut false_shadows, mut sum_beside) = (0, 0, 0.0);
        for (point, (&a, &t)) in self.approximate.iter().zip(&self.truth).enumerate() {
            let difference = f64::from(a) - t;
            if !difference.is_finite() {
                return Err(Error::input(
                    format!("visibility of point {point}"),
                    format!("{a} where the truth is {t}"),
                    "report this as a bug, with the scene",
                ));
            }
            let (leak, false_shadow) = (u64::from(t == 0.0 && a > 0.5), u64::from(t == 1.0 && a < 0.5));
            if self.boundary.get(point) == Some(&true) {
                beside.points += 1;
                beside.leaks += leak;
                beside.false_shadows += false_shadow;
                sum_beside += difference.abs();
                continue;
            }
            leaks += leak;
            false_shadows += false_shadow;
            error.bias += difference;
            error.mean_abs += difference.abs();
            error.rms += difference * difference;
            absolute.push(difference.abs());
        }
        if absolute.is_empty() {
            return Ok(None);
        }
        let n = absolute.len() as f64;
        let rank = ((0.99 * n).ceil() as usize).clamp(1, absolute.len()) - 1;
        let (_, &mut p99, above) = absolute.select_nth_unstable_by(rank, f64::total_cmp);
        let max = above.iter().copied().fold(p99, f64::max);
        beside.mean_abs = (beside.points > 0).then(|| sum_beside / beside.points as f64);
        Ok(Some(PointError {
            points: Some(absolute.len() as u64),
            mean_abs: error.mean_abs / n,
            bias: error.bias / n,
            rms: (error.rms / n).sqrt(),
            p99,
            max,
            leaks: Some(leaks),
            false_shadows: Some(false_shadows),
            boundary: (!self.boundary.is_empty()).then_some(beside),
        }))
    }

    /// Puts others behind these.
    pub fn extend(&mut self, others: Self) {
        self.approximate.extend(others.approximate);
        self.truth.extend(others.truth);
        self.boundary.extend(others.boundary);
        self.casters.extend(others.casters);
    }

    /// The standard error of the mean absolute error outside the boundary, where each `per_texel` points are a texel's and the
    /// texels are a random sample of more, `share` of all: what the mean would differ by from that over all of them. Points of
    /// a texel are alike, so that texels are counted and not points. None for fewer than two texels.
    pub fn standard_error(&self, per_texel: usize, share: f64) -> Option<f64> {
        let outside = |point: usize| self.boundary.get(point) != Some(&true);
        let (mut sums, mut counts) = (Vec::new(), Vec::new());
        for texel in 0..self.truth.len() / per_texel.max(1) {
            let points = (texel * per_texel..(texel + 1) * per_texel).filter(|p| outside(*p));
            let (mut sum, mut count) = (0.0, 0.0);
            for point in points {
                sum += (f64::from(self.approximate[point]) - self.truth[point]).abs();
                count += 1.0;
            }
            sums.push(sum);
            counts.push(count);
        }
        let (n, all) = (sums.len() as f64, counts.iter().sum::<f64>());
        if n < 2.0 || all == 0.0 {
            return None;
        }
        // Of a ratio: Cochran, Sampling Techniques, section 6.3.
        let mean = sums.iter().sum::<f64>() / all;
        let square: f64 = sums.iter().zip(&counts).map(|(s, c)| (s - mean * c).powi(2)).sum();
        Some((square / (n - 1.0) * n * (1.0 - share.clamp(0.0, 1.0))).sqrt() / all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_differences() {
        let truth = vec![0.5; 100];
        let mut approximate = vec![0.5f32; 100];
        approximate[3] = 0.75;
        approximate[7] = 0.25;
        let e = point_error(&approximate, &truth).expect("finite");
        let rms = (0.125f64 / 100.0).sqrt();
        let (points, none) = (Some(100), Some(0));
        let expected = PointError {
            points,
            mean_abs: 0.005,
            bias: 0.0,
            rms,
            p99: 0.25,
            max: 0.25,
            leaks: none,
            false_shadows: none,
            boundary: None,
        };
        assert_eq!(e, Some(expected));
    }

    #[test]
    fn no_points_are_no_perfect_score() {
        assert_eq!(point_error(&[], &[]).expect("as many answers as points"), None);
    }

    /// Two wrong points of four outside, two of three in the boundary; smoke is neither a leak nor a false shadow.
    #[test]
    fn the_boundary_is_counted_by_itself() {
        let answers = Answers {
            approximate: vec![1.0, 0.0, 0.25, 0.75, 1.0, 0.25, 0.5],
            truth: vec![0.0, 1.0, 0.5, 0.5, 0.0, 1.0, 0.5],
            boundary: vec![false, false, false, false, true, true, true],
            casters: vec![],
        };
        let error = answers.error().expect("finite").expect("points outside");
        assert_eq!((error.points, error.leaks, error.false_shadows), (Some(4), Some(1), Some(1)));
        assert_eq!((error.mean_abs, error.bias, error.max), (0.625, 0.0, 1.0));
        let boundary = BoundaryError { points: 3, mean_abs: Some(1.75 / 3.0), leaks: 1, false_shadows: 1 };
        assert_eq!(error.boundary, Some(boundary));
        let inside = Answers { boundary: vec![true; 7], ..answers };
        assert_eq!(inside.error().expect("finite"), None);
    }

    /// Against the spread of the mean over many samples of a population of texels.
    #[test]
    fn standard_error_is_the_spread_of_samples() {
        use rand::Rng;
        let mut random = rand_pcg::Pcg32::new(1, 2);
        let mut fraction = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        // Four points a texel that err alike, half of all texels not at all.
        let errors: Vec<f64> = (0..2000).map(|_| (fraction() - 0.5).max(0.0)).collect();
        let (mut means, mut stated) = (Vec::new(), Vec::new());
        for _ in 0..400 {
            // Without replacement: the first of a shuffle.
            let mut order: Vec<usize> = (0..errors.len()).collect();
            for i in 0..200 {
                let j = i + (fraction() * (order.len() - i) as f64) as usize;
                order.swap(i, j.min(errors.len() - 1));
            }
            let approximate: Vec<f32> = order[..200].iter().flat_map(|i| [errors[*i] as f32; 4]).collect();
            let sample = Answers { truth: vec![0.0; approximate.len()], approximate, ..Answers::default() };
            means.push(sample.error().expect("finite").expect("points").mean_abs);
            stated.push(sample.standard_error(4, 0.1).expect("texels"));
        }
        let mean = means.iter().sum::<f64>() / 400.0;
        let spread = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
        let stated = stated.iter().sum::<f64>() / 400.0;
        // The spread of 400 samples is itself known to some 4 %; three times that.
        assert!((stated / spread - 1.0).abs() < 0.12, "{stated}, and means spread by {spread}");
    }

    #[test]
    fn nan_names_its_point() {
        let e = point_error(&[0.0, f32::NAN], &[0.0, 0.0]).expect_err("a NaN is a failure");
        assert!(e.to_string().contains("point 1"), "{e}");
    }
}
