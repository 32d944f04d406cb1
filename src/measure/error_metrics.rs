//! How far approximate visibility is from the truth, over a set of points.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Statistics of `approximate − truth`, both in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
}

/// Compares `approximate` with `truth`, point by point. No points have no error, not one of zero: `None`.
///
/// # Errors
/// A value that is not a number is a failure that names its point, as is a difference in length.
pub fn point_error(approximate: &[f32], truth: &[f64]) -> Result<Option<PointError>> {
    if approximate.len() != truth.len() {
        return Err(Error::input(
            "visibility",
            format!("{} values for {} points", approximate.len(), truth.len()),
            "report this as a bug",
        ));
    }
    if truth.is_empty() {
        return Ok(None);
    }
    let mut absolute = Vec::with_capacity(truth.len());
    let (mut sum, mut sum_abs, mut sum_square) = (0.0, 0.0, 0.0);
    for (point, (&a, &t)) in approximate.iter().zip(truth).enumerate() {
        let difference = f64::from(a) - t;
        if !difference.is_finite() {
            return Err(Error::input(
                format!("visibility of point {point}"),
                format!("{a} where the truth is {t}"),
                "report this as a bug, with the scene",
            ));
        }
        sum += difference;
        sum_abs += difference.abs();
        sum_square += difference * difference;
        absolute.push(difference.abs());
    }
    let n = truth.len() as f64;
    let rank = ((0.99 * n).ceil() as usize).clamp(1, absolute.len()) - 1;
    let (_, &mut p99, above) = absolute.select_nth_unstable_by(rank, f64::total_cmp);
    let max = above.iter().copied().fold(p99, f64::max);
    Ok(Some(PointError {
        points: Some(truth.len() as u64),
        mean_abs: sum_abs / n,
        bias: sum / n,
        rms: (sum_square / n).sqrt(),
        p99,
        max,
    }))
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
        assert_eq!(e, Some(PointError { points: Some(100), mean_abs: 0.005, bias: 0.0, rms, p99: 0.25, max: 0.25 }));
    }

    #[test]
    fn no_points_are_no_perfect_score() {
        assert_eq!(point_error(&[], &[]).expect("as many answers as points"), None);
    }

    #[test]
    fn nan_names_its_point() {
        let e = point_error(&[0.0, f32::NAN], &[0.0, 0.0]).expect_err("a NaN is a failure");
        assert!(e.to_string().contains("point 1"), "{e}");
    }
}
