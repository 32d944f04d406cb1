//! How long files take to load, and how much memory: `GOBO_LOAD="a.spz b.vdb" cargo test --release --test host loading -- --nocapture`.

use crate::scene::*;
use std::time::{Duration, Instant};

/// Number of times that each file is loaded; the fastest counts.
const TIMES: usize = 5;

/// Prints seconds, and bytes in use at most per caster, or per sample that is not 0 in a volume.
#[test]
fn files_of_ones_own_are_timed() {
    let Ok(names) = std::env::var("GOBO_LOAD") else {
        return println!("skipped: GOBO_LOAD names no files");
    };
    for name in names.split_whitespace() {
        let mut fastest = Duration::MAX;
        let mut told = String::new();
        for _ in 0..TIMES {
            let begin = Instant::now();
            let mut scene = None;
            let most = allocation_counter::measure(|| scene = Some(load(Path::new(name)))).bytes_max;
            fastest = fastest.min(begin.elapsed());
            let scene = scene.expect("loaded").unwrap_or_else(|error| panic!("{error}"));
            let samples: usize = scene.volumes.iter().map(|volume| volume.field().samples()).sum();
            let (count, what) = if samples > 0 { (samples, "samples") } else { (scene.casters().len(), "casters") };
            told = format!("{count} {what}, {:.1} bytes each at most", most as f64 / count as f64);
        }
        println!("{name}: {:.3} s, {told}", fastest.as_secs_f64());
    }
}
