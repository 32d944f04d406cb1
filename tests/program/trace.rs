//! `compare --trace`: the events of a row must match its figures. `--pipeline-statistics`: work counts of passes.

use crate::errors::fails;
use crate::support::{log, skipped};
use crate::{device, folder, ok, results, runs, small_scene, text};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Returns the median of a few numbers, by sorting.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    if numbers.len() % 2 == 1 { numbers[middle] } else { 0.5 * (numbers[middle - 1] + numbers[middle]) }
}

fn number(event: &Value, name: &str) -> f64 {
    event[name].as_f64().unwrap_or_else(|| panic!("{name} of {event}"))
}

/// Returns the start and the end of an event, in nanoseconds.
fn span(event: &Value) -> [f64; 2] {
    let start = 1e3 * number(event, "ts");
    [start, start + 1e3 * number(event, "dur")]
}

/// Opens the trace with Perfetto's own trace processor, if installed.
fn opens_in_perfetto(trace: &Path, out: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/open_trace.py");
    let arguments = [script.as_path(), trace, &out.join("results.json")];
    // setup.sh installs the trace processor's packages here.
    let cache = ["XDG_CACHE_HOME", "HOME"].iter().find_map(|name| Some((name, std::env::var_os(name)?)));
    let packages = cache.map(|(name, folder)| Path::new(&folder).join(if *name == "HOME" { ".cache" } else { "" }));
    let mut python = Command::new("python3");
    if let Some(packages) = packages.map(|cache| cache.join("gobo/perfetto")).filter(|folder| folder.is_dir()) {
        python.env("PYTHONPATH", packages);
    }
    let Ok(output) = python.args(arguments).output() else {
        return skipped("opens_in_perfetto", "python3 is not installed");
    };
    match output.status.code() {
        Some(0) => {}
        Some(3) => skipped("opens_in_perfetto", String::from_utf8_lossy(&output.stdout).trim()),
        _ => panic!("{}", String::from_utf8_lossy(&output.stderr)),
    }
}

#[test]
fn a_trace_is_of_the_builds_that_were_timed() {
    if crate::support::is_costly("a_trace_is_of_the_builds_that_were_timed") {
        return;
    }
    log("exercised", "a_trace_is_of_the_builds_that_were_timed", &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let (scene, path) = (small_scene(scenes.path()), out.path().join("trace.json"));
    let specs = ["--technique", "beer-shadow-map:size=8|16"];
    let arguments =
        ["compare", text(&scene), "--quick", "--frames", "5", "--picture", "16x16", "--out", text(out.path())];
    ok(&[&arguments[..], &specs, &["--trace", text(&path)]].concat());
    if results(out.path()).rows.iter().any(|row| row.build_ns.is_some()) {
        opens_in_perfetto(&path, out.path());
    } else {
        skipped("opens_in_perfetto", "needs timestamps");
    }
    let trace: Value = serde_json::from_slice(&std::fs::read(&path).expect("a trace")).expect("JSON");
    let events = trace["traceEvents"].as_array().expect("events");
    let slices = |pid: u64| events.iter().filter(move |e| e["ph"] == "X" && e["pid"] == pid);
    let clocks = trace["otherData"]["clocks"].as_str().expect("words");
    // Without calibrated clocks, each device build is shown to begin with the host's.
    let off_ns = match clocks.strip_prefix("calibrated by VK_EXT_calibrated_timestamps, to ") {
        Some(words) => words.strip_suffix(" ns").and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds"),
        None => 0.0,
    };
    let facts = device()["facts"].clone();
    let tick_ns = number(&facts, "timestamp_period_ns");
    let can = facts["calibrated_timestamps"] == true && facts["timestamp_valid_bits"] != 0;
    assert_eq!(off_ns > 0.0, can, "{clocks}");
    let mut last = 0.0;
    for row in results(out.path()).rows {
        let of_row = |event: &&Value| event["args"]["spec"] == row.spec().as_str();
        let counts = |event: &&Value| event["args"]["counted"] == true;
        let host: Vec<f64> = slices(2).filter(of_row).filter(counts).map(|e| 1e3 * number(e, "dur")).collect();
        assert_eq!(host.len(), 5, "{}", row.spec());
        let wanted = row.host_ns.expect("timed").median;
        assert!((median(host) - wanted).abs() < 1e-6 * wanted);
        // Slices must not overlap.
        for slice in slices(2).filter(of_row) {
            assert!(span(slice)[0] >= last, "{slice}");
            last = span(slice)[1] - 1.0;
        }
        let Some(build_ns) = row.build_ns else { continue };
        let builds: Vec<&Value> = slices(1).filter(of_row).collect();
        let counted = builds.iter().filter(|build| counts(build)).map(|build| number(&build["args"], "ns"));
        assert!((median(counted.collect()) - build_ns.median).abs() < 1e-6 * build_ns.median);
        // The device must build within the host's span, which includes recording and waiting.
        for (host, device) in slices(2).filter(of_row).zip(&builds) {
            let (host, device) = (span(host), span(device));
            let off = off_ns + 1e-6 * host[1] + tick_ns;
            assert!(host[0] - off <= device[0] && device[1] <= host[1] + off, "{device:?} in {host:?}, {clocks}");
        }
        // A pass must lie within its build, and the passes of one name must add up to the row's figure.
        let within = |build: &Value, pass: &Value| {
            let (build, pass) = (span(build), span(pass));
            pass[0] >= build[0] - 1.0 && pass[1] <= build[1] + 1.0
        };
        let each: Vec<&&Value> = builds.iter().filter(|build| build["args"]["passes_timed"] == "each").collect();
        for pass in &row.passes {
            let named: Vec<&Value> = slices(1).filter(|e| e["name"] == pass.name.as_str()).collect();
            let sums = each.iter().map(|build| {
                named.iter().filter(|pass| within(build, pass)).map(|pass| 1e3 * number(pass, "dur")).sum::<f64>()
            });
            let sum = median(sums.collect());
            assert!((sum - pass.median_ns).abs() < 1.0 + 1e-6 * pass.median_ns, "{}: {sum}", pass.name);
        }
        // Look-ups must follow the builds, each a slice that contains its only pass, and the time per million must be the row's.
        let of_lookups = |event: &&Value| event["args"]["asked"] == row.spec().as_str();
        let lookups: Vec<&Value> = slices(1).filter(of_lookups).collect();
        let passes: Vec<&Value> = slices(1).filter(|e| e["name"] == "query.points").collect();
        let million = lookups.iter().map(|asked| {
            let passes: Vec<&&Value> = passes.iter().filter(|pass| within(asked, pass)).collect();
            assert_eq!(passes.len(), 1, "{asked}");
            let ns = 1e3 * number(passes[0], "dur");
            assert!((ns - number(&asked["args"], "ns")).abs() < 1.0 + 1e-6 * ns, "{asked} of {ns} ns");
            ns * 1e6 / number(&asked["args"], "points")
        });
        let (million, wanted) = (median(million.collect()), row.lookup_ns_per_million.expect("timed"));
        assert_eq!(lookups.len(), wanted.samples, "{}", row.spec());
        let points = if device()["facts"]["type"] == "cpu" { 125e3 } else { 1e6 };
        assert!(lookups.iter().all(|asked| number(&asked["args"], "points") == points), "{lookups:?}");
        assert!((million - wanted.median).abs() < 1.0 + 1e-6 * wanted.median, "{million} and {wanted:?}");
        for asked in slices(2).filter(of_lookups) {
            assert!(span(asked)[0] >= last, "{asked}");
            last = span(asked)[1] - 1.0;
        }
        // Pictures must follow the look-ups, and their times must be the row's.
        let of_picture = |event: &&Value| event["args"]["drawn"] == row.spec().as_str();
        let pictures: Vec<&Value> = slices(1).filter(of_picture).collect();
        let times = pictures.iter().map(|picture| number(&picture["args"], "ns"));
        let draw_ns = row.draw_ns.expect("timed").median;
        assert!((median(times.collect()) - draw_ns).abs() < 1e-6 * draw_ns);
        for pass in &row.draw_passes {
            let named: Vec<&Value> = slices(1).filter(|e| e["name"] == pass.name.as_str()).collect();
            let sums = pictures.iter().map(|picture| {
                named.iter().filter(|pass| within(picture, pass)).map(|pass| 1e3 * number(pass, "dur")).sum::<f64>()
            });
            let sum = median(sums.collect());
            assert!((sum - pass.median_ns).abs() < 1.0 + 1e-6 * pass.median_ns, "{}: {sum}", pass.name);
        }
        for picture in slices(2).filter(of_picture) {
            assert!(span(picture)[0] >= last, "{picture}");
            last = span(picture)[1] - 1.0;
        }
        // Passes and the gaps between them must add up to the build: between passes the device only waits.
        for build in each {
            let inner = slices(1).filter(|e| e["args"] == serde_json::json!({}) && within(build, e));
            let inner: Vec<[f64; 2]> = inner.map(span).collect();
            let all: f64 = inner.iter().map(|[start, end]| end - start).sum();
            let between: f64 = inner.windows(2).map(|two| two[1][0] - two[0][1]).sum();
            assert!(inner.windows(2).all(|two| two[1][0] - two[0][1] >= -1.0), "{inner:?}");
            let whole = span(build)[1] - span(build)[0];
            assert!((all + between - whole).abs() < 6.0 + 1e-6 * whole, "{all} + {between} of {whole}");
        }
    }
}

#[test]
fn passes_say_what_they_did() {
    const TEST: &str = "passes_say_what_they_did";
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let specs = ["--technique", "beer-shadow-map:size=16", "--no-truth", "--pipeline-statistics"];
    let arguments =
        ["compare", text(&scene), "--quick", "--frames", "2", "--picture", "32x16", "--out", text(out.path())];
    let all = [&arguments[..], &specs].concat();
    if device()["facts"]["pipeline_statistics_query"] == false {
        fails(&all, &["pipelineStatisticsQuery", "--pipeline-statistics"]);
        return skipped(TEST, "no pipelineStatisticsQuery");
    }
    let said = ok(&all);
    let row = results(out.path()).rows.remove(0);
    // All timed passes must be counted, and no others.
    let mut timed: Vec<&str> = row.passes.iter().chain(&row.draw_passes).map(|pass| pass.name.as_str()).collect();
    let mut counted: Vec<&str> = row.counts.iter().map(|pass| pass.name.as_str()).collect();
    timed.sort_unstable();
    counted.sort_unstable();
    assert_eq!(counted, timed);
    for pass in &row.counts {
        let line = said.lines().rfind(|line| line.split_whitespace().next() == Some(&pass.name)).expect("a line");
        let counts = pass.counts;
        let numbers = [pass.runs, counts.vertices, counts.primitives, counts.fragments, counts.threads];
        let words: Vec<String> = line.split_whitespace().skip(1).map(str::to_owned).collect();
        assert_eq!(words, numbers.map(|number| number.to_string()), "{line}");
    }
    assert!(row.counts.iter().any(|pass| pass.counts.threads > 0), "{:?}", row.counts);
    // Every figure that the driver reports about a program must be printed, and the driver queried once per pipeline.
    let executables = results(out.path()).executables;
    if device()["facts"]["pipeline_executable_info"] == false {
        assert_eq!(executables, []);
    }
    for program in &executables {
        let is_of = |line: &&str| line.trim_start().starts_with(&program.pipeline) && line.contains(&program.name);
        let told = |(name, value): &(String, f64)| {
            said.lines().filter(is_of).any(|line| line.contains(&format!("{name}: {value}")))
        };
        assert!(program.figures.iter().all(told), "{program:?} in {said}");
        assert!(executables.iter().filter(|other| *other == program).count() <= 4, "{executables:?}");
    }
    assert!(
        row.counts.iter().any(|pass| pass.counts.vertices >= 3 * pass.counts.primitives.max(1)),
        "{:?}",
        row.counts
    );
}
