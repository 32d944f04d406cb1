//! `compare --trace`: the events of a row are its figures.

use crate::support::log;
use crate::{folder, ok, results, runs, small_scene, text};
use serde_json::Value;

/// Medians of a few numbers, by sorting.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    if numbers.len() % 2 == 1 { numbers[middle] } else { 0.5 * (numbers[middle - 1] + numbers[middle]) }
}

#[test]
fn a_trace_is_of_the_builds_that_were_timed() {
    log("exercised", "a_trace_is_of_the_builds_that_were_timed", &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let (scene, path) = (small_scene(scenes.path()), out.path().join("trace.json"));
    let specs = ["--technique", "beer-shadow-map:size=8|16"];
    let arguments =
        ["compare", text(&scene), "--quick", "--frames", "5", "--picture", "16x16", "--out", text(out.path())];
    ok(&[&arguments[..], &specs, &["--trace", text(&path)]].concat());
    let trace: Value = serde_json::from_slice(&std::fs::read(&path).expect("a trace")).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    let number = |event: &Value, name: &str| event[name].as_f64().expect("microseconds");
    let slices = |pid: u64| events.iter().filter(move |e| e["ph"] == "X" && e["pid"] == pid);
    for row in results(out.path()).rows {
        let of_row = |event: &&Value| event["args"]["spec"] == row.spec().as_str();
        let host: Vec<f64> = slices(2).filter(of_row).map(|e| 1e3 * number(e, "dur")).collect();
        assert_eq!(host.len(), 5, "{}", row.spec());
        let wanted = row.host_ns.expect("timed").median;
        assert!((median(host) - wanted).abs() < 1e-6 * wanted);
        let Some(build_ns) = row.build_ns else { continue };
        let builds: Vec<&Value> = slices(1).filter(of_row).collect();
        let whole = |e: &&Value| e["args"]["untimed_passes_ns"].as_f64().expect("timed");
        assert!((median(builds.iter().map(whole).collect()) - build_ns.median).abs() < 1e-6 * build_ns.median);
        // A pass lies within its build, and all of one name are what its row says.
        let within = |build: &Value, pass: &Value| {
            let (start, end) = (number(build, "ts"), number(build, "ts") + number(build, "dur"));
            number(pass, "ts") >= start - 1e-3 && number(pass, "ts") + number(pass, "dur") <= end + 1e-3
        };
        for pass in &row.passes {
            let named: Vec<&Value> = slices(1).filter(|e| e["name"] == pass.name.as_str()).collect();
            let sums = builds.iter().map(|build| {
                named.iter().filter(|pass| within(build, pass)).map(|pass| 1e3 * number(pass, "dur")).sum::<f64>()
            });
            let sum = median(sums.collect());
            assert!((sum - pass.median_ns).abs() < 1.0 + 1e-6 * pass.median_ns, "{}: {sum}", pass.name);
        }
    }
}
