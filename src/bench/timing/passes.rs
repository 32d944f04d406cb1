//! Times of passes over the frames of a run.

use crate::bench::results::{PassCount, PassTiming};
use crate::bench::timing::order_statistics::Timing;
use crate::gpu::PassTime;

/// Returns the time from the start of the first pass to the end of the last.
pub fn frame_ns(passes: &[PassTime]) -> Option<f64> {
    Some(passes.last()?.end_ns - passes.first()?.start_ns)
}

/// Returns one timing per pass name: the total time of all passes with that name in a frame, since a build may run one
/// pass per map. The names are in the order of the frame with the most passes, since a frame in which nothing has moved
/// has fewer.
pub fn pass_timings(frames: &[Vec<PassTime>]) -> Vec<PassTiming> {
    let longest = frames.iter().rev().max_by_key(|passes| passes.len());
    let mut names: Vec<&str> = Vec::new();
    for pass in longest.into_iter().chain(frames).flatten() {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    let timing = |name: &str| {
        let frame_ns = |f: &Vec<PassTime>| f.iter().filter(|p| p.name == name).map(|p| p.end_ns - p.start_ns).sum();
        let timing = Timing::of(&frames.iter().map(frame_ns).collect::<Vec<f64>>())?;
        let raster = frames.iter().flatten().any(|pass| pass.name == name && pass.raster);
        let (median_ns, p05_ns, p95_ns) = (timing.median, timing.p05, timing.p95);
        Some(PassTiming { name: name.into(), median_ns, p05_ns, p95_ns, raster: Some(raster) })
    };
    names.into_iter().filter_map(timing).collect()
}

/// Returns the counts of passes, one entry per name, in the order in which they first ran, leaving out passes that did
/// not count.
pub fn pass_counts(passes: &[PassTime]) -> Vec<PassCount> {
    let mut all: Vec<PassCount> = Vec::new();
    for (name, counts) in passes.iter().filter_map(|pass| Some((&pass.name, pass.counts?))) {
        match all.iter_mut().find(|known| known.name == *name) {
            Some(known) => (known.runs, known.counts) = (known.runs + 1, known.counts.plus(counts)),
            None => all.push(PassCount { name: name.clone(), runs: 1, counts }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_of_one_name_are_summed() {
        let pass = |name: &str, start_ns: f64, end_ns: f64| PassTime {
            name: name.into(),
            start_ns,
            end_ns,
            raster: false,
            began: 0,
            counts: None,
        };
        let frame = |by: f64| {
            vec![pass("a", 0.0, by), pass("b", 10.0, 12.0), pass("a", 20.0, 21.0), pass("b", 30.0, 30.0 + by)]
        };
        let timings = pass_timings(&[frame(1.0), frame(3.0), frame(5.0)]);
        let medians: Vec<_> = timings.iter().map(|t| (t.name.as_str(), t.median_ns)).collect();
        assert_eq!(medians, [("a", 4.0), ("b", 5.0)]);
        // Passes that only some frames have are listed where they occur in those frames.
        let timings = pass_timings(&[vec![pass("b", 0.0, 1.0)], frame(1.0), frame(3.0)]);
        let medians: Vec<_> = timings.iter().map(|t| (t.name.as_str(), t.median_ns)).collect();
        assert_eq!(medians, [("a", 2.0), ("b", 3.0)]);
    }
}
