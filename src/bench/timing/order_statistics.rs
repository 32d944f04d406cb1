//! Order statistics of repeated timings.

use serde::{Deserialize, Serialize};

/// Statistics of some samples, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Median, the middle sample.
    pub median: f64,
    /// 5th percentile.
    pub p05: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Number of samples.
    pub samples: usize,
}

impl Timing {
    /// Computes the statistics; `None` without samples. Percentiles interpolate linearly between ranks.
    pub fn of(samples_ns: &[f64]) -> Option<Self> {
        if samples_ns.is_empty() {
            return None;
        }
        let mut sorted = samples_ns.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let at = |q: f64| {
            let rank = q * (sorted.len() - 1) as f64;
            let (low, high) = (rank.floor() as usize, rank.ceil() as usize);
            sorted[low] + (sorted[high] - sorted[low]) * (rank - low as f64)
        };
        Some(Self { median: at(0.5), p05: at(0.05), p95: at(0.95), samples: sorted.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_ramp() {
        let samples: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(Timing::of(&samples), Some(Timing { median: 50.0, p05: 5.0, p95: 95.0, samples: 101 }));
        assert_eq!(Timing::of(&[]), None);
    }
}
