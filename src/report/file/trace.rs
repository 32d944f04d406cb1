//! Passes over time as Chrome trace events, which Perfetto opens too: the *Trace Event Format*, with complete events ("X") only, in
//! microseconds.

use crate::bench::{DeviceFacts, LookupTimes, Row, TimedBuilds, TimedRun, frame_ns};
use crate::gpu::{Calibration, PassTime};
use serde_json::{Value, json};
use std::time::Instant;

const DEVICE: u32 = 1;
const HOST: u32 = 2;

/// Nanoseconds added to a build's slice, so that its last pass still ends within the slice after a reader of the file rounds the times.
const ROUNDED: f64 = 4.0;

/// Returns the timed builds, look-ups and pictures of the rows on two tracks. On the host's track, each is a slice from the start of
/// recording to the end of settling. On the device's track, each is a slice that contains its passes. Both tracks use the host's clock,
/// starting at the first build.
pub fn trace(device: &DeviceFacts, rows: &[(Row, TimedBuilds)]) -> String {
    let named = |process: u32, name: &str| json!({"ph": "M", "pid": process, "tid": process, "name": "process_name", "args": {"name": name}});
    let mut events = vec![named(DEVICE, &format!("device: {}", device.name)), named(HOST, "host")];
    let mut slice = |process: u32, name: &str, [start, end]: [f64; 2], arguments: Value| {
        let (start, duration) = (start / 1e3, (end - start) / 1e3);
        events.push(
            json!({"ph": "X", "pid": process, "tid": process, "name": name, "ts": start, "dur": duration, "args": arguments}),
        );
    };
    let first = rows.iter().flat_map(|(_, timed)| &timed.builds).map(|build| build.each.began).min();
    for (row, timed) in rows {
        for (frame, build) in timed.builds.iter().enumerate() {
            for (ran, passes) in
                std::iter::once((&build.each, "each")).chain(build.whole.iter().map(|w| (w, "together")))
            {
                let start = first.map_or(0.0, |first| ran.began.duration_since(first).as_nanos() as f64);
                let counted = std::ptr::eq(ran, build.counted());
                let arguments = |ns: f64| {
                    json!({
                        "scene": row.scene, "spec": row.spec(), "frame": frame, "passes_timed": passes, "counted": counted, "ns": ns,
                    })
                };
                slice(HOST, "build", [start, start + ran.host_ns], arguments(ran.host_ns));
                let spans = spans(timed.clock, ran, first, start);
                let begin = spans.iter().map(|span| span[0]).reduce(f64::min);
                let end = spans.iter().map(|span| span[1]).reduce(f64::max);
                if let (Some(begin), Some(end), Some(ns)) = (begin, end, frame_ns(&ran.passes)) {
                    slice(DEVICE, &row.technique, [begin, end + ROUNDED], arguments(ns));
                }
                for (pass, span) in ran.passes.iter().zip(spans) {
                    slice(DEVICE, &pass.name, span, json!({}));
                }
            }
        }
        let mut alone = |name: &str, ran: &TimedRun, clock: Option<Calibration>, arguments: &dyn Fn(f64) -> Value| {
            let start = first.map_or(0.0, |first| ran.began.duration_since(first).as_nanos() as f64);
            slice(HOST, name, [start, start + ran.host_ns], arguments(ran.host_ns));
            let spans = spans(clock, ran, first, start);
            let begin = spans.iter().map(|span| span[0]).reduce(f64::min);
            let end = spans.iter().map(|span| span[1]).reduce(f64::max);
            if let (Some(begin), Some(end), Some(ns)) = (begin, end, frame_ns(&ran.passes)) {
                slice(DEVICE, name, [begin, end + ROUNDED], arguments(ns));
            }
            for (pass, span) in ran.passes.iter().zip(spans) {
                slice(DEVICE, &pass.name, span, json!({}));
            }
        };
        for (frame, LookupTimes { ran, points }) in timed.lookups.iter().enumerate() {
            let arguments =
                |ns: f64| json!({"scene": row.scene, "asked": row.spec(), "frame": frame, "points": points, "ns": ns});
            alone("look-ups", ran, timed.lookups_clock, &arguments);
        }
        for (frame, ran) in timed.draws.iter().enumerate() {
            let arguments = |ns: f64| json!({"scene": row.scene, "drawn": row.spec(), "frame": frame, "ns": ns});
            alone("picture", ran, timed.draws_clock, &arguments);
        }
    }
    let clocks: Vec<_> = rows
        .iter()
        .flat_map(|(_, timed)| [timed.clock, timed.lookups_clock, timed.draws_clock].into_iter().flatten())
        .map(|clock| clock.deviation_ns)
        .collect();
    let clocks = match clocks.into_iter().reduce(f64::max) {
        Some(deviation) => format!("calibrated by VK_EXT_calibrated_timestamps, to {deviation} ns"),
        None => "not calibrated: the device begins each build when the host does".into(),
    };
    let other = json!({"device": device.name, "driver": device.driver, "clocks": clocks});
    json!({"displayTimeUnit": "ms", "otherData": other, "traceEvents": events}).to_string()
}

/// Returns when the passes of a build, of look-ups or of a picture ran, in nanoseconds since the first build began. If the device's clock
/// cannot be related to the host's, the device is assumed to have begun with the build, at `start`.
fn spans(clock: Option<Calibration>, ran: &TimedRun, first: Option<Instant>, start: f64) -> Vec<[f64; 2]> {
    let clock = clock.zip(first);
    let span = |pass: &PassTime| {
        let begin = clock.map_or(start + pass.start_ns, |(clock, first)| clock.ns_since(first, pass.began));
        [begin, begin + pass.end_ns - pass.start_ns]
    };
    ran.passes.iter().map(span).collect()
}
