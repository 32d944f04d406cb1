//! Errors of answers against the mean over an area. Hair thinner than a pixel is judged as a pixel sees it: by the mean of the truth over a
//! square around each point, perpendicular to the light.

use crate::bench::case::truth::{Points, Truth};
use crate::reference::truth::Casters;
use crate::scene::{Random, Scene, View};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Sides of the squares, in texels of a 256² map fitted to the casters.
pub const FOOTPRINTS: [f64; 4] = [0.25, 1.0, 4.0, 16.0];

/// Texels per side of the map that defines the unit of [`FOOTPRINTS`].
const MAP: u32 = 256;

/// Number of points queried, over all lights.
const POINTS: usize = 2048;

/// Strata per side of a square, each with one random ray.
const STRATA: u32 = 6;

/// Error of answers against means over squares of one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FootprintError {
    /// Side of the square, in texels of a 256² map fitted to the casters.
    pub texels: f64,
    /// Number of points queried.
    pub points: u64,
    /// Root mean square of (answer − mean of the truth over the square). Its square is estimated without bias, from two means that share no
    /// ray. If there is no error, the estimate may fall below 0 and then counts as 0.
    pub rms: f64,
    /// Square root of that estimate's standard error: a smaller error cannot be distinguished from zero.
    pub noise: f64,
    /// Mean of (answer − mean of the truth).
    pub bias: f64,
}

/// Means of the truth over areas around some points.
pub(crate) struct Footprints {
    /// One list of points per light.
    pub points: Vec<Points>,
    /// Two means that share no ray, per size and per point of all lights.
    means: [Vec<[f64; 2]>; FOOTPRINTS.len()],
    /// Side of the square in world units, per size and point.
    pub sides: [Vec<f32>; FOOTPRINTS.len()],
}

/// Computes means of the truth over areas around some of its points in space.
pub(crate) fn footprints(truth: &Truth, scene: &Scene) -> Footprints {
    let views = View::volumes(scene, MAP);
    let casters = truth.casters();
    let each = (POINTS / scene.lights.len().max(1)).max(1);
    let some = |p: &Points| {
        let count = each.min(p.positions.len());
        Points::in_space(p.light, p.positions[..count].to_vec(), p.visibility[..count].to_vec())
    };
    let points: Vec<Points> = truth.space().iter().map(some).collect();
    let places: Vec<_> = points.iter().flat_map(|p| p.positions.iter().map(|at| (p.light, *at))).collect();
    let square = |texels: f64, light: usize, position: [f32; 3]| {
        let view = &views[scene.first_map(light) + scene.lights[light].map_at(position)];
        view.texel_at(DVec3::from(position.map(f64::from))).map(|side| texels * side)
    };
    let sides = |texels: f64| {
        let of = |(light, position): &(usize, [f32; 3])| {
            let [a, b] = square(texels, *light, *position).map(DVec3::length);
            (a * b).sqrt() as f32
        };
        places.iter().map(of).collect()
    };
    let means = |texels: f64| {
        let of = |(i, (light, position)): (usize, &(usize, [f32; 3]))| {
            let centre = DVec3::from(position.map(f64::from));
            let square = square(texels, *light, *position);
            [0, 1].map(|half| mean(casters, *light, centre, square, 2 * i as u64 + half))
        };
        places.par_iter().enumerate().map(of).collect()
    };
    Footprints { means: FOOTPRINTS.map(means), sides: FOOTPRINTS.map(sides), points }
}

/// Returns the mean over a square around `centre` with the given sides.
fn mean(casters: &Casters, light: usize, centre: DVec3, sides: [DVec3; 2], seed: u64) -> f64 {
    let mut random = Random::new([seed.wrapping_mul(0x9e37_79b9_7f4a_7c15), seed]);
    let mut share = |stratum: u32| (f64::from(stratum) + random.between(0.0, 1.0)) / f64::from(STRATA) - 0.5;
    let mut sum = 0.0;
    for i in 0..STRATA * STRATA {
        let (across, up) = (share(i % STRATA), share(i / STRATA));
        sum += casters.visibility(light, centre + across * sides[0] + up * sides[1]);
    }
    sum / f64::from(STRATA * STRATA)
}

/// Returns the errors of the answers for each size of square, over the points of all lights; empty without points.
pub(crate) fn footprint_errors(answers: &[Vec<f32>], footprints: &Footprints) -> Vec<FootprintError> {
    let of = |(i, texels): (usize, f64)| footprint_error(answers.get(i)?, texels, &footprints.means[i]);
    FOOTPRINTS.into_iter().enumerate().filter_map(of).collect()
}

fn footprint_error(answers: &[f32], texels: f64, means: &[[f64; 2]]) -> Option<FootprintError> {
    let off = |(answer, means): (&f32, &[f64; 2])| means.map(|mean| f64::from(*answer) - mean);
    let errors: Vec<[f64; 2]> = answers.iter().zip(means).map(off).collect();
    let n = Some(errors.len() as f64).filter(|n| *n > 0.0)?;
    let squares = || errors.iter().map(|[one, other]| one * other);
    let square = squares().sum::<f64>() / n;
    let variance = squares().map(|s| (s - square).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let bias = errors.iter().map(|[one, other]| 0.5 * (one + other)).sum::<f64>() / n;
    let [rms, noise] = [square.max(0.0), (variance / n).sqrt()].map(f64::sqrt);
    Some(FootprintError { texels, points: errors.len() as u64, rms, noise, bias })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{Extent, Wanted};
    use crate::scene::tests::on_the_axis;
    use crate::scene::{LightKind, Strand};

    /// An answer equal to the truth must have no error, although the noisy means deviate from the truth in both directions.
    #[test]
    fn noise_of_the_truth_is_no_error() {
        let mut random = Random::new([1, 1]);
        let means: Vec<_> = (0..4000).map(|_| [0, 1].map(|_| random.between(0.4, 0.6))).collect();
        let exact = footprint_error(&[0.5; 4000], 4.0, &means).expect("points");
        assert!(exact.rms <= 2.0 * exact.noise && exact.noise < 0.01, "{exact:?}");
        let off = footprint_error(&[0.6; 4000], 4.0, &means).expect("points");
        assert!((off.rms - 0.1).abs() < 0.003 && (off.bias - 0.1).abs() < 0.003, "{off:?}");
        assert_eq!((off.points, off.texels), (4000, 4.0));
        assert_eq!(footprint_error(&[], 4.0, &[]), None);
    }

    /// Parallel ribbons under a light that shines down: the mean over a square is 1 − opacity × the share of the square's width that
    /// ribbons cover. Answers equal to this mean must have no error.
    #[test]
    fn a_lattice_has_a_closed_form() {
        let (spacing, radius, opacity, count) = (0.25, 0.03125, 0.75, 64);
        let middle = |i: u32| (f64::from(i) + 0.5) * spacing;
        let mut scene = on_the_axis(&[]);
        scene.lights[0].kind = LightKind::Directional { direction: DVec3::NEG_Z };
        scene.strands = (0..count)
            .map(|i| {
                let at = |x: f32| [x, middle(i) as f32, 1.0];
                Strand { start: at(-20.0), end: at(20.0), radius: radius as f32, opacity: opacity as f32 }
            })
            .collect();
        let wanted = Wanted {
            extent: Extent::Sample,
            points: 1500,
            picture: [8, 8],
            bounds: Some([DVec3::new(-1.0, 4.0, -2.0), DVec3::new(1.0, 12.0, 0.0)]),
            watched: Default::default(),
            seen: (0, 0),
        };
        let truth = Truth::new(&scene, wanted);
        let areas = footprints(&truth, &scene);
        let view = View::volumes(&scene, MAP)[0];
        // Covered length of the line from 0 to y.
        let covered = |y: f64| {
            let whole = (y / spacing).floor();
            2.0 * radius * whole + (y - whole * spacing - 0.5 * spacing + radius).clamp(0.0, 2.0 * radius)
        };
        for (texels, means) in FOOTPRINTS.into_iter().zip(&areas.means) {
            let closed = |position: &[f32; 3]| {
                let centre = DVec3::from(position.map(f64::from));
                let side: DVec3 = view.texel_at(centre).map(|side| texels * side).into_iter().sum();
                let [low, high] = [-0.5, 0.5].map(|end| covered(centre.y + end * side.y.abs()));
                1.0 - opacity * (high - low) / side.y.abs()
            };
            let exact: Vec<f32> = areas.points[0].positions.iter().map(|p| closed(p) as f32).collect();
            let error = footprint_error(&exact, texels, means).expect("points");
            assert!(error.rms <= 2.0 * error.noise && error.bias.abs() < 0.002, "{error:?}");
            // The truth at the points differs from the means, unless squares are far narrower than ribbons.
            let of_points: Vec<f32> = areas.points[0].visibility.iter().map(|v| *v as f32).collect();
            let points = footprint_error(&of_points, texels, means).expect("points");
            let spread = |of: &[f32]| of.iter().map(|v| f64::from(*v)).sum::<f64>() / of.len() as f64;
            assert!((spread(&of_points) - (1.0 - opacity * 2.0 * radius / spacing)).abs() < 0.01, "the mean of all");
            let squares = exact.iter().zip(&of_points).map(|(a, b)| f64::from(a - b).powi(2));
            let known = (squares.sum::<f64>() / exact.len() as f64).sqrt();
            assert!((points.rms - known).abs() < 0.1 * known + 2.0 * points.noise.powi(2), "{points:?}, not {known}");
        }
    }
}
