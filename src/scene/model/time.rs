//! Functions of time alone: valid times, and swinging motion.

use crate::{Error, Result};

/// The largest allowed `time_s`, in seconds.
const MAX_TIME_S: f64 = 3600.0;

/// Checks that a time is in range for animated scenes; `scene` is the name used in messages.
///
/// # Errors
/// [`Error::Usage`] if `time_s` is not in [0, 3600].
pub fn check_time(scene: &str, time_s: f64) -> Result<()> {
    if (0.0..=MAX_TIME_S).contains(&time_s) {
        return Ok(());
    }
    let cause = format!("time {time_s} s is not in [0, {MAX_TIME_S}]");
    Err(Error::usage(scene, cause, "give a time in seconds in that range"))
}

/// Returns a wave of period 1 and amplitude 1 made of two parabolas. It replaces a sine, whose bits depend on the machine.
pub(in crate::scene) fn wave(periods: f64) -> f64 {
    // Rounds towards zero instead of calling `floor`, which is a function call on x86-64 without SSE 4.1.
    let rest = periods - periods as i64 as f64;
    let saw = 2.0 * (if rest < 0.0 { rest + 1.0 } else { rest }) - 1.0;
    4.0 * saw * (saw.abs() - 1.0)
}
