//! How long frames take: the lowest of many, which is the least disturbed by whatever else the machine does.

use crate::gpu::PassTime;
use std::time::Duration;

/// Lowest times of frames, also of those in which nothing had to be drawn, milliseconds; none where nothing was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// The host's part: all of a frame but what it waits for the device.
    host_ms: Option<f64>,
    /// The sum of a frame's passes.
    passes_ms: Option<f64>,
    /// From the begin of a frame to that of the next.
    frame_ms: Option<f64>,
}

impl Pace {
    /// The host's part of a frame, and how long ago the one before it began.
    pub fn frame(&mut self, host: Duration, since: Duration) {
        lower(&mut self.host_ms, host.as_secs_f64() * 1e3);
        lower(&mut self.frame_ms, since.as_secs_f64() * 1e3);
    }

    /// The passes of a frame that is over.
    pub fn passes(&mut self, passes: &[PassTime]) {
        if !passes.is_empty() {
            lower(&mut self.passes_ms, passes.iter().map(|pass| pass.end_ns - pass.start_ns).sum::<f64>() * 1e-6);
        }
    }

    /// In words.
    pub fn text(&self) -> String {
        let parts =
            [(self.host_ms, "of the host's"), (self.passes_ms, "of passes"), (self.frame_ms, "to the next frame")];
        let said = parts.iter().filter_map(|(ms, what)| ms.map(|ms| format!(", {ms:.3} ms {what}")));
        said.collect()
    }
}

fn lower(lowest: &mut Option<f64>, is: f64) {
    *lowest = Some(lowest.map_or(is, |lowest| lowest.min(is)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_each_is_kept() {
        let pass = |ns: f64| PassTime { name: String::new(), start_ns: 1e6, end_ns: 1e6 + ns, began: 0, counts: None };
        let mut pace = Pace::default();
        assert_eq!(pace.text(), "", "what was not measured is absent");
        pace.frame(Duration::from_millis(2), Duration::from_millis(9));
        pace.frame(Duration::from_millis(3), Duration::from_millis(8));
        pace.passes(&[]);
        assert_eq!(pace.text(), ", 2.000 ms of the host's, 8.000 ms to the next frame");
        pace.passes(&[pass(2e6), pass(1e6)]);
        pace.passes(&[pass(4e6)]);
        assert_eq!(pace.text(), ", 2.000 ms of the host's, 3.000 ms of passes, 8.000 ms to the next frame");
    }
}
