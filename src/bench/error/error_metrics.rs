//! Errors of approximate visibility against the truth, over a set of points.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Statistics of `approximate − truth`, both in [0, 1], over all points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointError {
    /// Number of points. Absent in files of schema 1.
    #[serde(default)]
    pub points: Option<u64>,
    /// Mean of the absolute difference.
    pub mean_abs: f64,
    /// Signed mean: positive is too bright. This field and the three below are absent if a file of schema 1 or 2 has them only for some
    /// points.
    pub bias: Option<f64>,
    /// Root mean square.
    pub rms: Option<f64>,
    /// 99th percentile of the absolute difference (nearest rank).
    pub p99: Option<f64>,
    /// Largest absolute difference.
    pub max: Option<f64>,
    /// Number of points that no light reaches but whose answer exceeds one half. Absent in files of schema 1.
    #[serde(default)]
    pub leaks: Option<u64>,
    /// Number of points that all light reaches but whose answer is below one half. Absent in files of schema 1.
    #[serde(default)]
    pub false_shadows: Option<u64>,
    /// Errors at points that are nearer to the edge of an opaque shadow than the representation resolves. Absent if nothing opaque casts,
    /// and in files of schema 1. Schema 2 called it `boundary`.
    #[serde(default, alias = "boundary")]
    pub within: Option<PartError>,
}

/// Statistics over some of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartError {
    /// Number of points.
    pub points: u64,
    /// Mean of the absolute difference; absent without points.
    pub mean_abs: Option<f64>,
    /// See [`PointError::leaks`].
    pub leaks: u64,
    /// See [`PointError::false_shadows`].
    pub false_shadows: u64,
}

impl PointError {
    /// Returns the share of all points that are within the resolution, in [0, 1].
    pub fn share_within(&self) -> Option<f64> {
        let (all, within) = (self.points.filter(|n| *n > 0)?, self.within?);
        Some(within.points as f64 / all as f64)
    }

    /// Returns the errors at all points beyond the resolution. A correct method has no leaks and no false shadows there.
    pub fn beyond(&self) -> Option<PartError> {
        let (all, within) = (self.points?, self.within?);
        let points = all.saturating_sub(within.points);
        let sum = self.mean_abs * all as f64 - within.mean_abs.unwrap_or(0.0) * within.points as f64;
        Some(PartError {
            points,
            mean_abs: (points > 0).then(|| (sum / points as f64).max(0.0)),
            leaks: self.leaks?.saturating_sub(within.leaks),
            false_shadows: self.false_shadows?.saturating_sub(within.false_shadows),
        })
    }

    /// Merges the errors within the resolution, which files of schemas 1 and 2 store separately, into the errors over all points, as far as
    /// these can be recovered.
    pub(in crate::bench) fn over_all_points(&mut self) {
        let Some(within) = self.within.filter(|within| within.points > 0) else { return };
        let beyond = self.points.unwrap_or(0);
        let all = beyond + within.points;
        let sum = self.mean_abs * beyond as f64 + within.mean_abs.unwrap_or(0.0) * within.points as f64;
        self.points = Some(all);
        self.mean_abs = sum / all as f64;
        self.leaks = self.leaks.map(|leaks| leaks + within.leaks);
        self.false_shadows = self.false_shadows.map(|count| count + within.false_shadows);
        (self.bias, self.rms, self.p99, self.max) = (None, None, None, None);
    }
}

/// A technique's answers at some points, with the truth there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Visibility according to the technique.
    pub approximate: Vec<f32>,
    /// True visibility.
    pub truth: Vec<f64>,
    /// Whether each point is nearer to an opaque shadow's edge than the technique resolves; empty if nothing opaque casts.
    pub within: Vec<bool>,
    /// Two distances per point along the ray to the light: from the light to the first mesh, and from the point to the mesh nearest to it.
    /// Both are fractions of the diagonal of the box around all meshes, and infinite if no mesh is on the ray. Empty for points that are
    /// not on a surface.
    pub casters: Vec<[f64; 2]>,
}

/// Compares `approximate` with `truth`, point by point. Without points the result is `None`, not an error of zero.
///
/// # Errors
/// Fails if a value is not a number, naming its point, and if the lengths differ.
pub fn point_error(approximate: &[f32], truth: &[f64]) -> Result<Option<PointError>> {
    let answers = Answers { approximate: approximate.to_vec(), truth: truth.to_vec(), ..Answers::default() };
    answers.error()
}

impl Answers {
    /// Returns the errors over all points, and separately over those within the resolution. `None` without points.
    ///
    /// # Errors
    /// See [`point_error`].
    pub fn error(&self) -> Result<Option<PointError>> {
        let (count, truths, flags) = (self.approximate.len(), self.truth.len(), self.within.len());
        if count != truths || (flags != 0 && flags != count) {
            let cause = format!("{count} values for {truths} points, {flags} of which are looked at");
            return Err(Error::input("visibility", cause, "report this as a bug"));
        }
        let (mut absolute, mut within) = (Vec::with_capacity(count), PartError::default());
        let [mut bias, mut sum, mut squares, mut sum_within] = [0.0; 4];
        let (mut leaks, mut false_shadows) = (0, 0);
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
            leaks += leak;
            false_shadows += false_shadow;
            bias += difference;
            sum += difference.abs();
            squares += difference * difference;
            absolute.push(difference.abs());
            if self.within.get(point) == Some(&true) {
                within.points += 1;
                within.leaks += leak;
                within.false_shadows += false_shadow;
                sum_within += difference.abs();
            }
        }
        if absolute.is_empty() {
            return Ok(None);
        }
        let n = absolute.len() as f64;
        let rank = ((0.99 * n).ceil() as usize).clamp(1, absolute.len()) - 1;
        let (_, &mut p99, above) = absolute.select_nth_unstable_by(rank, f64::total_cmp);
        let max = above.iter().copied().fold(p99, f64::max);
        within.mean_abs = (within.points > 0).then(|| sum_within / within.points as f64);
        Ok(Some(PointError {
            points: Some(count as u64),
            mean_abs: sum / n,
            bias: Some(bias / n),
            rms: Some((squares / n).sqrt()),
            p99: Some(p99),
            max: Some(max),
            leaks: Some(leaks),
            false_shadows: Some(false_shadows),
            within: (!self.within.is_empty()).then_some(within),
        }))
    }

    /// Appends other answers.
    pub fn extend(&mut self, others: Self) {
        self.approximate.extend(others.approximate);
        self.truth.extend(others.truth);
        self.within.extend(others.within);
        self.casters.extend(others.casters);
    }

    /// Returns the standard error of the mean absolute error: how far the mean over the sample is from the mean over all texels. Points
    /// come in groups of `per_texel`, one group per texel. The texels are a random sample of all texels, and `share` is the fraction
    /// sampled. Points of one texel are alike, so texels are counted, not points. `None` for fewer than two texels.
    pub fn standard_error(&self, per_texel: usize, share: f64) -> Option<f64> {
        let per_texel = per_texel.max(1);
        let pairs: Vec<_> = self.approximate.iter().zip(&self.truth).collect();
        let error = |(a, t): &(&f32, &f64)| (f64::from(**a) - **t).abs();
        let means: Vec<f64> = pairs
            .chunks_exact(per_texel)
            .map(|texel| texel.iter().map(error).sum::<f64>() / per_texel as f64)
            .collect();
        let n = means.len() as f64;
        if n < 2.0 {
            return None;
        }
        // The variance of a simple random sample without replacement: Cochran, Sampling Techniques, section 2.6.
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Some((variance / n * (1.0 - share.clamp(0.0, 1.0))).sqrt())
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
            bias: Some(0.0),
            rms: Some(rms),
            p99: Some(0.25),
            max: Some(0.25),
            leaks: none,
            false_shadows: none,
            within: None,
        };
        assert_eq!(e, Some(expected));
    }

    #[test]
    fn no_points_are_no_perfect_score() {
        assert_eq!(point_error(&[], &[]).expect("as many answers as points"), None);
    }

    /// Two of the four points beyond the resolution have a leak or a false shadow, and two of the three points within it. Partial
    /// visibility, as in smoke, must count as neither.
    #[test]
    fn an_error_is_over_all_points_and_its_parts_stand_beside_it() {
        let answers = Answers {
            approximate: vec![1.0, 0.0, 0.25, 0.75, 1.0, 0.25, 0.5],
            truth: vec![0.0, 1.0, 0.5, 0.5, 0.0, 1.0, 0.5],
            within: vec![false, false, false, false, true, true, true],
            casters: vec![],
        };
        let error = answers.error().expect("finite").expect("points");
        assert_eq!((error.points, error.leaks, error.false_shadows), (Some(7), Some(2), Some(2)));
        assert_eq!((error.mean_abs, error.bias, error.max), (4.25 / 7.0, Some(0.25 / 7.0), Some(1.0)));
        let within = PartError { points: 3, mean_abs: Some(1.75 / 3.0), leaks: 1, false_shadows: 1 };
        assert_eq!((error.within, error.share_within()), (Some(within), Some(3.0 / 7.0)));
        let beyond = error.beyond().expect("opaque casters");
        assert_eq!((beyond.points, beyond.leaks, beyond.false_shadows), (4, 1, 1));
        assert!((beyond.mean_abs.expect("points") - 0.625).abs() < 1e-15, "{beyond:?}");
        let all = Answers { within: vec![true; 7], ..answers };
        let all = all.error().expect("finite").expect("they count, however near an edge");
        assert_eq!((all.mean_abs, all.beyond().expect("none").mean_abs), (4.25 / 7.0, None));
    }

    /// Figures that schema 2 stored separately must be merged if possible: means can be, percentiles cannot.
    #[test]
    fn older_errors_are_over_all_points_too() {
        let old = r#"{"points":4,"mean_abs":0.625,"bias":0.0,"rms":0.7,"p99":1.0,"max":1.0,"leaks":1,"false_shadows":1,
            "boundary":{"points":3,"mean_abs":0.25,"leaks":1,"false_shadows":0}}"#;
        let mut error: PointError = serde_json::from_str(old).expect("schema 2");
        error.over_all_points();
        assert_eq!((error.points, error.mean_abs), (Some(7), (4.0 * 0.625 + 3.0 * 0.25) / 7.0));
        assert_eq!((error.leaks, error.false_shadows, error.max, error.rms), (Some(2), Some(1), None, None));
        assert!((error.beyond().and_then(|b| b.mean_abs).expect("four points") - 0.625).abs() < 1e-15);
    }

    /// Compares the standard error with the spread of the mean over many samples of a population of texels.
    #[test]
    fn standard_error_is_the_spread_of_samples() {
        use rand::Rng;
        let mut random = rand_pcg::Pcg32::new(1, 2);
        let mut fraction = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        // Each texel has four points with the same error; half of all texels have no error.
        let errors: Vec<f64> = (0..2000).map(|_| (fraction() - 0.5).max(0.0)).collect();
        let (mut means, mut stated) = (Vec::new(), Vec::new());
        for _ in 0..400 {
            // Samples without replacement, by taking the first texels of a shuffle.
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
        // The spread of 400 samples is itself only known to about 4 %; the bound is three times that.
        assert!((stated / spread - 1.0).abs() < 0.12, "{stated}, and means spread by {spread}");
    }

    #[test]
    fn nan_names_its_point() {
        let e = point_error(&[0.0, f32::NAN], &[0.0, 0.0]).expect_err("a NaN is a failure");
        assert!(e.to_string().contains("point 1"), "{e}");
    }
}
