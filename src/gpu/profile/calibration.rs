//! Relates the device's clock to the host's.

use crate::gpu::{Context, Features};
use ash::{ext, vk};
use std::time::Instant;

/// Number of readings, of which the quickest is kept: the host may be interrupted in the middle of one.
const READINGS: usize = 8;

/// One moment on both clocks, the host's and the device's. The clocks drift apart by a few microseconds per second, so
/// only times near this moment convert accurately.
#[derive(Clone, Copy, Debug)]
pub struct Calibration {
    /// The moment on the host's clock.
    host: Instant,
    /// The moment on the device's clock, in ticks.
    ticks: u64,
    /// Error bound of `host` as the moment of `ticks`, in nanoseconds: half the time that the reading took.
    pub deviation_ns: f64,
    tick_ns: f64,
    valid_bits: u32,
}

/// Returns the function that reads the device's clock, if it may be called.
pub(in crate::gpu) fn clock(
    entry: &ash::Entry,
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    device: &ash::Device,
    features: &Features,
) -> Option<ext::calibrated_timestamps::Device> {
    if !features.calibrated_timestamps || features.timestamp_valid_bits == 0 {
        return None;
    }
    let domains = ext::calibrated_timestamps::Instance::new(entry, instance);
    // SAFETY: `physical` belongs to this instance and supports the extension.
    let domains = unsafe { domains.get_physical_device_calibrateable_time_domains(physical) }.unwrap_or_default();
    let has = domains.contains(&vk::TimeDomainEXT::DEVICE);
    has.then(|| ext::calibrated_timestamps::Device::new(instance, device))
}

impl Context {
    /// Reads the device's clock between two readings of the host's clock; `None` if the device's clock cannot be read.
    pub fn calibrate(&self) -> Option<Calibration> {
        let clock = self.device().clock()?;
        let features = self.features();
        let wanted = [vk::CalibratedTimestampInfoEXT::default().time_domain(vk::TimeDomainEXT::DEVICE)];
        let read = |_| {
            let before = Instant::now();
            // SAFETY: the device was opened with the extension, and supports this time domain.
            let (ticks, _) = unsafe { clock.get_calibrated_timestamps(&wanted) }.ok()?;
            let half = before.elapsed() / 2;
            Some(Calibration {
                host: before + half,
                ticks: *ticks.first()?,
                deviation_ns: half.as_nanos() as f64,
                tick_ns: f64::from(features.timestamp_period_ns),
                valid_bits: features.timestamp_valid_bits.clamp(1, 64),
            })
        };
        (0..READINGS).filter_map(read).min_by(|a, b| a.deviation_ns.total_cmp(&b.deviation_ns))
    }
}

impl Calibration {
    /// Converts a device time of `ticks` to nanoseconds after `moment`, which must be earlier than this calibration.
    pub fn ns_since(&self, moment: Instant, ticks: u64) -> f64 {
        self.host.saturating_duration_since(moment).as_nanos() as f64 + self.later_ns(ticks)
    }

    /// Returns how many nanoseconds after this calibration `ticks` is. The counter may have wrapped in between, so the
    /// smaller difference is used.
    fn later_ns(&self, ticks: u64) -> f64 {
        let unused = 64 - self.valid_bits;
        let difference = (ticks.wrapping_sub(self.ticks) << unused) as i64 >> unused;
        difference as f64 * self.tick_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_may_wrap() {
        let later = |ticks: u64, valid_bits: u32, of: u64| {
            Calibration { host: Instant::now(), ticks, deviation_ns: 0.0, tick_ns: 2.0, valid_bits }.later_ns(of)
        };
        assert_eq!(later(10, 64, 15), 10.0);
        assert_eq!(later(10, 64, 5), -10.0);
        assert_eq!(later(u64::MAX, 64, 4), 10.0);
        assert_eq!(later((1 << 36) - 1, 36, 4), 10.0);
        assert_eq!(later(4, 36, (1 << 36) - 1), -10.0);
        // Clock bits above the valid bits of a timestamp are ignored.
        assert_eq!(later((7 << 36) + 4, 36, 9), 10.0);
    }
}
