//! Frame times: three medians over the same frames, of the host's time, of the device's passes, and of the time to the next frame.

use crate::gpu::PassTime;
use std::time::Duration;

/// Largest number of frames remembered.
const MOST: usize = 10_000;

/// Times of one frame, in milliseconds.
#[derive(Clone, Copy, Debug)]
struct Frame {
    number: u64,
    /// Host time of the frame, without waits for the device or the screen.
    host_ms: f64,
    /// Sum of the frame's passes, once the frame is complete. `None` if nothing was drawn, or if the device has no timestamps.
    passes_ms: Option<f64>,
    /// Time from the start of the frame to the start of the next one.
    next_ms: Option<f64>,
}

/// Frames since the last report.
#[derive(Clone, Debug, Default)]
pub struct Pace(Vec<Frame>);

impl Pace {
    /// Adds a recorded frame, with the host's time for it.
    pub fn frame(&mut self, number: u64, host: Duration) {
        if self.0.len() == MOST {
            self.0.drain(..MOST / 2);
        }
        self.0.push(Frame { number, host_ms: ms(host), passes_ms: None, next_ms: None });
    }

    /// Records that the next frame begins, `since` after the last one began.
    pub fn next(&mut self, since: Duration) {
        if let Some(last) = self.0.last_mut() {
            last.next_ms.get_or_insert(ms(since));
        }
    }

    /// Adds the passes of a completed frame.
    pub fn passes(&mut self, number: u64, passes: &[PassTime]) {
        let frame = self.0.iter_mut().rfind(|frame| frame.number == number);
        if let Some(frame) = frame.filter(|_| !passes.is_empty()) {
            frame.passes_ms = Some(passes.iter().map(|pass| pass.end_ns - pass.start_ns).sum::<f64>() * 1e-6);
        }
    }

    /// Formats the medians over the complete frames that drew something or, if there are none, over all complete frames.
    pub fn text(&self) -> String {
        let whole = |frame: &&Frame| frame.next_ms.is_some();
        let drawn: Vec<&Frame> = self.0.iter().filter(whole).filter(|frame| frame.passes_ms.is_some()).collect();
        let frames = if drawn.is_empty() { self.0.iter().filter(whole).collect() } else { drawn };
        let of = |what: fn(&Frame) -> Option<f64>| median(frames.iter().filter_map(|frame| what(frame)).collect());
        let parts = [
            (of(|frame| Some(frame.host_ms)), "of the host's"),
            (of(|frame| frame.passes_ms), "of passes"),
            (of(|frame| frame.next_ms), "to the next frame"),
        ];
        let said: String = parts.iter().filter_map(|(ms, what)| ms.map(|ms| format!(", {ms:.3} ms {what}"))).collect();
        if said.is_empty() { said } else { format!(", medians of {} frames{said}", frames.len()) }
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Returns the median; for an even count, the lower of the two middle numbers.
fn median(mut of: Vec<f64>) -> Option<f64> {
    of.sort_by(f64::total_cmp);
    of.get(of.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All three medians are over the same frames: a short frame that drew nothing must not lower any of them.
    #[test]
    fn medians_are_of_frames_that_drew() {
        let pass = |ms: f64| PassTime {
            name: String::new(),
            start_ns: 1e6,
            end_ns: 1e6 + ms * 1e6,
            raster: false,
            began: 0,
            counts: None,
        };
        let mut pace = Pace::default();
        assert_eq!(pace.text(), "", "what was not measured is absent");
        for (number, (host, next)) in
            [(0.125, 0.25), (2.0, 9.0), (3.0, 8.0), (4.0, 7.0), (0.125, 0.25)].into_iter().enumerate()
        {
            pace.frame(number as u64, Duration::from_secs_f64(host * 1e-3));
            pace.next(Duration::from_secs_f64(next * 1e-3));
        }
        assert_eq!(pace.text(), ", medians of 5 frames, 2.000 ms of the host's, 7.000 ms to the next frame");
        for (number, passes) in [
            (1, vec![pass(2.0), pass(1.0)]),
            (2, vec![pass(6.0)]),
            (3, vec![pass(5.0)]),
            (4, vec![]),
            (9, vec![pass(1.0)]),
        ] {
            pace.passes(number, &passes);
        }
        pace.frame(5, Duration::from_secs(1));
        pace.passes(5, &[pass(100.0)]);
        let said = ", medians of 3 frames, 3.000 ms of the host's, 5.000 ms of passes, 8.000 ms to the next frame";
        assert_eq!(pace.text(), said, "what has no next frame yet is left out");
    }
}
