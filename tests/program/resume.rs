//! `compare --resume`, after any kind of interruption.

use crate::errors::fails;
use crate::support::scenes::Random;
use crate::support::{all, is_long, log};
use crate::{folder, gobo, ok, results, run, runs, small_scene, text};
use gobo::bench::{Results, Row, Status};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Returns a row without its times, as another run of the same command must have it, and whether it had device times.
pub fn rows_and_times_apart(row: &Row) -> (Row, bool) {
    let mut rest = row.clone();
    let times = [rest.host_ns.take(), rest.build_ns.take(), rest.lookup_ns_per_million.take(), rest.draw_ns.take()];
    let whole_ns = [rest.frame_ns.take(), rest.first_ns.take(), rest.cost_ns.take()];
    (rest.first_host_ns, rest.steadiness, rest.cost_band_ns) = (None, None, None);
    // The error of the unshadowed picture is not a time.
    if let Some(bare) = &mut rest.unshadowed {
        bare.draw_ns = None;
    }
    let timed = times[1..].iter().any(Option::is_some) || whole_ns.iter().any(Option::is_some);
    for pass in rest.passes.iter_mut().chain(&mut rest.draw_passes) {
        (pass.median_ns, pass.p05_ns, pass.p95_ns) = (0.0, 0.0, 0.0);
    }
    (rest, timed)
}

/// Returns the unfinished files in a folder.
pub fn unfinished(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("there");
    let names = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with('.')).collect()
}

/// Returns all rows with [`rows_and_times_apart`] applied.
pub fn untimed(results: &Results) -> Vec<Row> {
    results.rows.iter().map(|row| rows_and_times_apart(row).0).collect()
}

/// Returns arguments for rows that take a moment each.
fn arguments<'a>(scene: &'a Path, out: &'a Path) -> Vec<&'a str> {
    let mut all = vec!["compare", text(scene), "--quick", "--frames", "2", "--picture", "16x16", "--out", text(out)];
    for spec in
        ["beer-shadow-map:path=binned,size=8|16", "avsm:path=interlock,size=8", "translucency-map:path=raster,size=8"]
    {
        all.extend(["--technique", spec]);
    }
    all
}

/// Ends a run by a signal at random times and resumes it: rows must be complete and existing ones unchanged, and the final results must
/// equal those of an uninterrupted run.
#[test]
fn a_run_ends_at_any_time_and_goes_on() {
    if crate::support::is_costly("a_run_ends_at_any_time_and_goes_on") {
        return;
    }
    log("exercised", "a_run_ends_at_any_time_and_goes_on", &runs("beer-shadow-map", "binned").0);
    let (scenes, whole) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let start = Instant::now();
    ok(&arguments(&scene, whole.path()));
    let took = start.elapsed();
    let whole = results(whole.path());
    let mut random = Random::new(14);
    for attempt in 0..if all() { 12 } else { 2 } {
        let out = folder();
        let arguments = arguments(&scene, out.path());
        let signal = ["INT", "KILL"][attempt % 2];
        let mut child = gobo().args(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        std::thread::sleep(took.mul_f32(random.between(0.05, 0.95)));
        let ended_before = end(&mut child, signal);
        let left = if out.path().join("results.json").exists() { results(out.path()).rows } else { Vec::new() };
        println!("SIG{signal}: {} rows, {} unfinished files", left.len(), unfinished(out.path()).len());
        let expected = untimed(&whole);
        for (row, expected) in left.iter().zip(&expected) {
            assert_eq!(rows_and_times_apart(row).0, *expected);
            assert!(row.picture.iter().all(|name| image::open(out.path().join(name)).is_ok()));
        }
        assert!(!ended_before || left.len() == expected.len());
        // A file that a killed process left unfinished.
        std::fs::write(out.path().join(".results.json.abc123.unfinished"), "{").expect("written");
        ok(&[&arguments[..], &["--resume"]].concat());
        let after = results(out.path());
        assert_eq!(untimed(&after), expected);
        assert_eq!(after.rows[..left.len()], left[..], "kept as they were");
        assert_eq!(after.command.replace(text(out.path()), ""), whole.command.replace(&whole_folder(&whole), ""));
        assert_eq!(unfinished(out.path()), [""; 0]);
        let page = std::fs::read_to_string(out.path().join("report.html")).expect("written");
        assert!(page.contains("data:image/png;base64,"));
    }
}

/// Returns the folder that a command names.
fn whole_folder(results: &Results) -> String {
    results.command.split("--out ").nth(1).and_then(|rest| rest.split(' ').next()).expect("named").to_owned()
}

/// Ends the process by a signal; returns whether it had ended by itself.
pub fn end(child: &mut Child, signal: &str) -> bool {
    let id = child.id().to_string();
    let sent = Command::new("kill").args(["-s", signal, &id]).stderr(Stdio::null()).status().expect("kill is there");
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("asked") {
            return status.success() || !sent.success();
        }
        assert!(start.elapsed() < Duration::from_secs(20), "SIG{signal} does not end it");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Failed rows and rows without their pictures must be measured again; more rows may be requested, in another order; existing rows must not
/// get lost.
#[test]
fn what_is_kept() {
    if is_long("what_is_kept") {
        return;
    }
    log("exercised", "what_is_kept", &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let base = [
        "compare",
        text(&scene),
        "--quick",
        "--frames",
        "1",
        "--picture",
        "16x16",
        "--no-truth",
        "--out",
        text(out.path()),
    ];
    let with = |more: &[&'static str]| [&base[..], more].concat();
    let (one, two) =
        (["--technique", "beer-shadow-map:path=binned,size=8"], ["--technique", "beer-shadow-map:path=binned,size=16"]);
    let three = ["--technique", "translucency-map:path=raster,size=8"];
    // There is nothing to resume.
    ok(&with(&[&one[..], &three, &["--resume"]].concat()));
    let first = results(out.path());
    let pictures: Vec<_> = first.rows.iter().map(|row| row.picture.clone().expect("drawn")).collect();

    // A new row before the existing ones must not take one of their pictures.
    let all = [&two[..], &one, &three, &["--resume"]].concat();
    ok(&with(&all));
    let second = results(out.path());
    let sizes: Vec<_> = second.rows.iter().map(|row| row.variant["size"].as_str()).collect();
    assert_eq!(sizes, ["16", "8", "8"]);
    assert_eq!(second.rows[1..], first.rows[..]);
    assert!(!pictures.contains(second.rows[0].picture.as_ref().expect("drawn")));

    // One row has failed, one has lost its picture; the third must stay.
    let mut broken = second.clone();
    broken.rows[0].status = Status::Failed;
    broken.rows[0].host_ns = None;
    let json = serde_json::to_string(&broken).expect("JSON");
    std::fs::write(out.path().join("results.json"), json).expect("written");
    std::fs::remove_file(out.path().join(&pictures[0])).expect("removed");
    ok(&with(&all));
    let third = results(out.path());
    // Pictures may be renumbered if one is missing.
    let figures =
        |results: &Results| untimed(results).into_iter().map(|row| Row { picture: None, ..row }).collect::<Vec<_>>();
    assert_eq!(figures(&third), figures(&second));
    assert!(third.rows[0].host_ns.is_some() && third.rows[1].host_ns != second.rows[1].host_ns);
    assert_eq!(third.rows[2], second.rows[2]);

    // Anything that would mix unlike rows, or lose one, must be refused and change nothing.
    let file = std::fs::read(out.path().join("results.json")).expect("there");
    let other: Vec<&str> = base.iter().map(|word| if *word == "16x16" { "17x16" } else { word }).collect();
    let less = [&one[..], &three, &["--resume"]].concat();
    fails(&[&other[..], &all].concat(), &["--resume", "--picture 16x16", "17x16"]);
    fails(&with(&less), &["--resume", "size=16", "not asked for"]);
    fails(&with(&[&all[..], &["--validation"]].concat()), &["--validation false", "true"]);
    let ground = scenes.path().join("ground.ply");
    let lower = std::fs::read_to_string(&ground).expect("there").replace("-4 -4 0", "-4 -4 -1");
    std::fs::write(&ground, lower).expect("written");
    fails(&with(&all), &["--resume", "scene small"]);
    std::fs::write(out.path().join("results.json"), &file[..file.len() / 2]).expect("written");
    fails(&with(&all), &["results.json", "no whole results.json"]);
    // Without --resume the run starts over.
    let anew = run(&with(&one));
    assert!(anew.status.success() && results(out.path()).rows.len() == 1);
}

/// A bake that has changed in the meantime must be refused; one named for the first time does not count as changed.
#[test]
fn a_bake_that_has_changed() {
    log("exercised", "a_bake_that_has_changed", &runs("voxelized", "tiles").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let file = scenes.path().join("small.gobo");
    let bake = |technique: &str| ok(&["bake", text(&scene), "--technique", technique, "--out", text(&file)]);
    let spec = format!("voxelized:file={}", text(&file));
    let base = ["compare", text(&scene), "--quick", "--frames", "1", "--picture", "16x16", "--no-truth", "--resume"];
    let base = [&base[..], &["--out", text(out.path()), "--technique", "beer-shadow-map:path=binned,size=8"]].concat();
    let with = [&base[..], &["--technique", &spec]].concat();
    bake("voxelized:size=64");
    ok(&base);
    ok(&with);
    let before = results(out.path());
    ok(&with);
    assert_eq!(results(out.path()).rows, before.rows, "nothing is measured again");
    bake("voxelized:size=128");
    fails(&with, &["--resume", "small.gobo", "begin anew"]);
    assert_eq!(results(out.path()).rows, before.rows, "and nothing is lost");
    bake("voxelized:size=64");
    ok(&with);
}

/// On a device without timestamps, times must be absent, not zero, in everything written.
#[test]
fn without_timestamps_there_are_no_times() {
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let arguments = arguments(&scene, out.path());
    let output = gobo().args(&arguments).arg("--passes").env("GOBO_TEST_FEATURES", "none").output().expect("it starts");
    assert!(output.status.success(), "{output:?}");
    log("exercised", "without_timestamps_there_are_no_times", "a device without timestamps");
    let results = results(out.path());
    assert_eq!(results.device.features["timestamp_valid_bits"], 0);
    assert_eq!(results.device.copy_bytes_per_second, None);
    let measured: Vec<_> = results.rows.iter().filter(|row| row.status == Status::Ok).collect();
    assert_eq!(measured.len(), 3);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.path().join("results.json")).expect("there")).expect("JSON");
    let mut csv = csv::Reader::from_path(out.path().join("results.csv")).expect("there");
    let names = csv.headers().expect("names").clone();
    let lines: Vec<_> = csv.records().map(|line| line.expect("a line")).collect();
    for (i, row) in results.rows.iter().enumerate() {
        assert!(!rows_and_times_apart(row).1 && row.passes.is_empty() && row.draw_passes.is_empty(), "{row:?}");
        for time in ["build_ns", "lookup_ns_per_million", "draw_ns", "frame_ns", "first_ns", "cost_ns"] {
            assert!(json["rows"][i][time].is_null(), "{time}");
        }
        for (name, field) in names.iter().zip(&lines[i]) {
            let of_device =
                name.ends_with("_ns") || name.contains("_ns_") || name == "samples" || name == "draw_samples";
            assert!(!of_device || name.contains("host") || field.is_empty(), "{name} is {field}");
        }
    }
    // The host's times must be present; columns without any value must not.
    assert!(measured.iter().all(|row| row.host_ns.is_some_and(|host| host.median > 0.0)));
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    let page = std::fs::read_to_string(out.path().join("report.html")).expect("there");
    assert!(table.contains("host ms") && page.contains("host"));
    for column in ["build ms", "look-up ms/M", "draw ms", "frame ms"] {
        assert!(!table.contains(column), "{table}");
    }
    for plot in ["time-vs-error.svg", "frame-vs-error.svg", "frame-vs-surface.svg"] {
        assert!(!out.path().join(plot).exists(), "{plot} of no times");
    }
}
