//! The *limit*: the lowest mean absolute error of any curve of K nodes whose vertices lie on the true curve.

use super::casters::Casters;
use super::points::{MapTruth, texel_curve};
use super::true_curve::TrueCurve;
use crate::scene::View;
use rayon::prelude::*;

/// Maximum number of texels over which the limit is averaged: an even sample of the covered texels of all maps.
pub const LIMIT_TEXELS: usize = 93;

/// Number of depths at which errors are summed, spread evenly over the light's range: four times as dense as the points at which maps are
/// compared, so that errors between these points count too.
const DEPTHS: usize = 253;

/// Returns the limit for each number of nodes in `nodes`: the mean over a fixed sample of covered texels. Nodes are chosen among the true
/// curve's vertices by dynamic programming; between nodes, optical depth is interpolated linearly, as in the true curve.
pub fn limit_mean_abs(casters: &Casters, views: &[View], truths: &[MapTruth], nodes: &[usize]) -> Vec<f64> {
    let mut texels: Vec<_> = truths.iter().flat_map(|t| t.texels.iter().map(|texel| (t.map, *texel))).collect();
    texels.sort_unstable();
    let count = texels.len().min(LIMIT_TEXELS);
    let most = nodes.iter().copied().max().unwrap_or(0);
    let per_texel: Vec<Vec<f64>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let (map, texel) = texels[i * texels.len() / count];
            let best = texel_limit(&texel_curve(casters, map, &views[map], texel), most);
            nodes.iter().map(|k| best[k.min(&(best.len() - 1)).to_owned()]).collect()
        })
        .collect();
    (0..nodes.len()).map(|k| per_texel.iter().map(|t: &Vec<f64>| t[k]).sum::<f64>() / count.max(1) as f64).collect()
}

/// Returns the number of steps of [`limit_mean_abs`] for a texel with that many segments: pairs of vertices times the samples between them.
pub fn limit_steps(segments: u64) -> f64 {
    // Two vertices per segment; on average a third of the samples lies between two vertices.
    let vertices = 2.0 * segments as f64;
    vertices * vertices / 2.0 * (DEPTHS as f64 / 3.0)
}

/// Returns a list whose element k is the lowest mean absolute error with k nodes, for k = 0 to `most`.
fn texel_limit(curve: &TrueCurve, most: usize) -> Vec<f64> {
    let vertices = curve.depths.len();
    let sample = |k: usize| k as f64 / (DEPTHS - 1) as f64;
    let truth: Vec<f64> = (0..DEPTHS).map(|k| curve.transmittance(sample(k))).collect();
    let none = truth.iter().map(|t| 1.0 - t).sum::<f64>() / DEPTHS as f64;
    let mut best = vec![none];
    if vertices == 0 {
        best.resize(most + 1, 0.0);
        return best;
    }
    // First sample at or behind each vertex.
    let behind: Vec<usize> =
        curve.depths.iter().map(|d| (0..DEPTHS).find(|&k| sample(k) >= *d).unwrap_or(DEPTHS)).collect();
    // Summed error of the samples from vertex i up to vertex j, if both are nodes with no node in between.
    let span = |i: usize, j: usize| {
        let (d0, d1) = (curve.depths[i], curve.depths[j]);
        let (t0, t1) = (curve.optical_depths[i], curve.optical_depths[j]);
        if behind[i] == behind[j] {
            return 0.0;
        }
        let slope = (t1 - t0) / (d1 - d0);
        // The samples are evenly spaced on an exponential, so each is the previous one times a constant.
        let mut transmittance = (-(t0 + slope * (sample(behind[i]) - d0))).exp();
        let ratio = (-slope * sample(1)).exp();
        let mut error = 0.0;
        for true_transmittance in &truth[behind[i]..behind[j]] {
            error += (transmittance - true_transmittance).abs();
            transmittance *= ratio;
        }
        error
    };
    // In front of the first node all light arrives; behind the last one the transmittance stays constant.
    let head: Vec<f64> = (0..vertices).map(|i| truth[..behind[i]].iter().map(|t| 1.0 - t).sum()).collect();
    let tail: Vec<f64> = (0..vertices)
        .map(|i| {
            let last = (-curve.optical_depths[i]).exp();
            truth[behind[i]..].iter().map(|t| (last - t).abs()).sum()
        })
        .collect();
    let spans: Vec<f64> = (0..vertices * vertices)
        .map(|ij| (ij / vertices, ij % vertices))
        .map(|(i, j)| if i < j { span(i, j) } else { 0.0 })
        .collect();
    let mut reach = head;
    for k in 1..=most {
        let least = reach.iter().zip(&tail).map(|(r, t)| r + t).fold(f64::INFINITY, f64::min);
        // More nodes can never be worse, since the last one may repeat.
        best.push((least / DEPTHS as f64).min(best[k - 1]));
        reach = (0..vertices)
            .map(|j| (0..j).map(|i| reach[i] + spans[i * vertices + j]).fold(f64::INFINITY, f64::min))
            .collect();
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three segments have six vertices, even if some are steps, so six nodes are exact. For three nodes, brute force over all triples
    /// finds the same limit.
    #[test]
    fn finds_the_best_of_all_subsets() {
        for segments in [
            [(0.1, 0.3, 0.7), (0.5, 0.6, 1.2), (0.55, 0.9, 0.4)],
            [(0.1, 0.1, 0.7), (0.5, 0.5, 1.2), (0.55, 0.9, 0.4)],
            [(0.1, 0.1, 0.7), (0.5, 0.5, 0.3), (0.75, 0.75, 0.4)],
        ] {
            finds_the_best(&TrueCurve::new(&segments));
        }
    }

    fn finds_the_best(curve: &TrueCurve) {
        let limit = texel_limit(curve, 6);
        assert!(limit[6] < 1e-12, "six vertices, six nodes: {}", limit[6]);
        let sample = |k: usize| k as f64 / (DEPTHS - 1) as f64;
        let mut least = f64::INFINITY;
        let n = curve.depths.len();
        for a in 0..n {
            for b in a + 1..n {
                for c in b + 1..n {
                    let pick = TrueCurve {
                        depths: [a, b, c].map(|i| curve.depths[i]).to_vec(),
                        optical_depths: [a, b, c].map(|i| curve.optical_depths[i]).to_vec(),
                        smooth: vec![],
                        volumes: vec![],
                    };
                    let error = (0..DEPTHS)
                        .map(|k| (pick.transmittance(sample(k)) - curve.transmittance(sample(k))).abs())
                        .sum::<f64>();
                    least = least.min(error / DEPTHS as f64);
                }
            }
        }
        assert!((limit[3] - least).abs() < 1e-12, "{} is not {least}", limit[3]);
    }
}
