//! Passes over time, as Chrome's trace events, which Perfetto opens too: the *Trace Event Format*, complete events ("X") alone, in
//! microseconds.

use crate::measure::{BuildTimes, DeviceFacts, Row};
use serde_json::{Value, json};

const DEVICE: u32 = 1;
const HOST: u32 = 2;

/// Between two builds, so that they are told apart, nanoseconds.
const GAP: f64 = 1000.0;

/// The timed builds of rows: a track of the device's clock, where a build is a slice and its passes lie within, and a track of the
/// host's, where it is from the beginning of recording to the end of settling.
pub fn trace(device: &DeviceFacts, rows: &[(Row, Vec<BuildTimes>)]) -> String {
    let named = |process: u32, name: &str| json!({"ph": "M", "pid": process, "tid": 1, "name": "process_name", "args": {"name": name}});
    let mut events = vec![named(DEVICE, &format!("device: {}", device.name)), named(HOST, "host")];
    let mut now = 0.0;
    let mut slice = |process: u32, name: &str, start: f64, duration: f64, arguments: Value| {
        let (start, duration) = (start / 1e3, duration / 1e3);
        events.push(
            json!({"ph": "X", "pid": process, "tid": 1, "name": name, "ts": start, "dur": duration, "args": arguments}),
        );
    };
    for (row, builds) in rows {
        for (frame, build) in builds.iter().enumerate() {
            let whole =
                json!({"scene": row.scene, "spec": row.spec(), "frame": frame, "untimed_passes_ns": build.whole_ns});
            slice(HOST, "build", now, build.host_ns, whole.clone());
            let end = build.passes.iter().map(|pass| pass.end_ns).fold(0.0, f64::max);
            if let (Some(first), Some(last)) = (build.passes.first(), build.passes.last()) {
                slice(DEVICE, &row.technique, now + first.start_ns, last.end_ns - first.start_ns, whole);
            }
            for pass in &build.passes {
                slice(DEVICE, &pass.name, now + pass.start_ns, pass.end_ns - pass.start_ns, json!({}));
            }
            now += build.host_ns.max(end) + GAP;
        }
    }
    let other = json!({
        "device": device.name,
        "driver": device.driver,
        "clocks": "not calibrated: the device's track begins each build where the host's does",
    });
    json!({"displayTimeUnit": "ms", "otherData": other, "traceEvents": events}).to_string()
}
