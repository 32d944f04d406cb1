//! What shadows add to a frame: the build, plus the picture with the technique minus the picture without shadows, drawn the same way.

use crate::bench::{Row, Timing};
use serde::{Deserialize, Serialize};

/// The picture without shadows, drawn in the same run and in the same way as a row's picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unshadowed {
    /// Device time to draw it; absent if the device has no timestamps.
    pub draw_ns: Option<Timing>,
    /// Its seen error.
    pub seen: Option<f64>,
    /// Its mean FLIP; absent if no picture of the truth was rendered.
    pub flip_mean: Option<f64>,
}

/// Writes a row's cost and its band. `build` is `None` if a build is not part of a frame.
pub(in crate::bench) fn add_cost(row: &mut Row, build: Option<Timing>, unshadowed: Unshadowed) {
    row.unshadowed = Some(unshadowed);
    let Some((draw, without)) = row.draw_ns.zip(unshadowed.draw_ns) else { return };
    if row.technique == "none" {
        row.cost_ns = Some(0.0);
        row.cost_band_ns = Some([0.0; 2]);
        return;
    }
    let median = build.map_or(0.0, |build| build.median) + draw.median - without.median;
    // The three are measured separately, so their deviations add in quadrature.
    let off = |to: fn(&Timing) -> f64, from: fn(&Timing) -> f64| {
        let parts = [build.as_ref().map_or(0.0, to), to(&draw), from(&without)];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    };
    let (below, above) = (|t: &Timing| t.median - t.p05, |t: &Timing| t.p95 - t.median);
    row.cost_ns = Some(median);
    row.cost_band_ns = Some([median - off(below, above), median + off(above, below)]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A build of 2 ± 0.3 and a picture of 5 ± 0.4 must cost 3 ± 0.5 if the picture without shadows takes 4.
    #[test]
    fn cost_is_what_shadows_add() {
        let timing = |median: f64, off: f64| Timing { median, p05: median - off, p95: median + off, samples: 9 };
        let row =
            |technique: &str| Row { technique: technique.into(), draw_ns: Some(timing(5.0, 0.4)), ..Row::default() };
        let unshadowed = |draw_ns| Unshadowed { draw_ns, ..Unshadowed::default() };
        let mut avsm = row("avsm");
        add_cost(&mut avsm, Some(timing(2.0, 0.3)), unshadowed(Some(timing(4.0, 0.0))));
        let [low, high] = avsm.cost_band_ns.expect("timed");
        assert_eq!(avsm.cost_ns, Some(3.0));
        assert!((low - 2.5).abs() < 1e-12 && (high - 3.5).abs() < 1e-12, "{low} to {high}");
        // Without timestamps there is no cost, and `none` costs nothing.
        let (mut untimed, mut none) = (row("avsm"), row("none"));
        add_cost(&mut untimed, None, unshadowed(None));
        add_cost(&mut none, None, unshadowed(Some(timing(4.0, 1.0))));
        assert_eq!((untimed.cost_ns, none.cost_ns), (None, Some(0.0)));
    }
}
