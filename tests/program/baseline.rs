//! `compare --baseline`: what has changed must be reported and fail the run; what has not must do neither.

use crate::errors::fails;
use crate::support::{is_long, log, skipped};
use crate::{folder, gobo, ok, results, run, runs, small_scene, text};
use gobo::bench::{Results, Status};
use std::collections::BTreeSet;
use std::path::Path;

fn arguments<'a>(scene: &'a Path, out: &'a Path) -> Vec<&'a str> {
    let effort = ["--quick", "--frames", "6", "--picture", "16x16", "--out", text(out)];
    let specs = ["--technique", "beer-shadow-map:size=8|16", "--technique", "avsm:path=interlock,size=8"];
    ["compare", text(scene)].into_iter().chain(effort).chain(specs).collect()
}

/// Writes the results with `change` applied, and returns the file's path.
fn changed(before: &Results, folder: &Path, change: impl Fn(&mut Results)) -> String {
    let mut results = before.clone();
    change(&mut results);
    let path = folder.join("baseline.json");
    std::fs::write(&path, serde_json::to_vec(&results).expect("JSON")).expect("write");
    text(&path).to_owned()
}

#[test]
fn a_run_is_held_against_its_baseline() {
    if crate::support::is_costly("a_run_is_held_against_its_baseline") {
        return;
    }
    log("exercised", "a_run_is_held_against_its_baseline", &runs("beer-shadow-map", "binned").0);
    let (scenes, first, out) = (folder(), folder(), folder());
    let scene = small_scene(scenes.path());
    ok(&arguments(&scene, first.path()));
    let before = results(first.path());
    let measured = before.rows.iter().filter(|row| row.status == Status::Ok).count();
    assert!(measured >= 2);
    let is_timed = before.rows.iter().any(|row| row.build_ns.is_some());
    let against = |path: &str, more: &[&str]| {
        let mut all = arguments(&scene, out.path());
        all.extend(["--baseline", path]);
        all.extend(more);
        let output = run(&all);
        let [said, complained] =
            [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        (output.status.success(), said, complained)
    };
    let (xml, json) = (out.path().join("junit.xml"), out.path().join("bencher.json"));
    // Unchanged results must pass: the errors are the same, and times are not compared on a busy machine.
    let as_it_was = changed(&before, scenes.path(), |_| {});
    let files = ["--fail-worse", "--junit", text(&xml), "--bencher", text(&json)];
    let (holds, said, complained) = against(&as_it_was, &files);
    assert!(holds && said.contains("space error") && !said.contains("WORSE"), "{said}{complained}");
    // The files for CI must contain the rows.
    let now = results(out.path());
    let document = std::fs::read_to_string(&xml).expect("JUnit's XML");
    let document = roxmltree::Document::parse(&document).expect("XML");
    let cases: Vec<_> = document.descendants().filter(|node| node.has_tag_name("testcase")).collect();
    let named: Vec<_> = cases.iter().map(|case| case.attribute("name").expect("a name").to_owned()).collect();
    assert_eq!(named, now.rows.iter().map(gobo::bench::Row::spec).collect::<Vec<_>>());
    for (case, row) in cases.iter().zip(&now.rows) {
        let refused = row.status == Status::Refused;
        assert_eq!(case.children().any(|node| node.has_tag_name("skipped")), refused, "{}", row.spec());
        assert!(!case.children().any(|node| node.has_tag_name("failure")));
        let seconds = case.attribute("time").expect("a time").parse::<f64>().ok();
        let median = row.build_ns.map(|timing| timing.median / 1e9);
        assert_eq!(seconds.is_some(), median.is_some());
        assert!(seconds.zip(median).is_none_or(|(a, b)| (a - b).abs() < 1e-9));
    }
    let bencher: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&json).expect("Bencher's JSON")).expect("JSON");
    for row in now.rows.iter().filter(|row| row.build_ns.is_some()) {
        let build = &bencher[format!("{}/{}", row.scene, row.spec())]["build_ns"];
        let timing = row.build_ns.expect("measured");
        assert_eq!(build["value"].as_f64(), Some(timing.median));
        assert_eq!(build["upper_value"].as_f64(), Some(timing.p95));
    }
    // Errors were half as large.
    let halved = changed(&before, scenes.path(), |results| {
        for points in results.rows.iter_mut().filter_map(|row| row.error.as_mut()?.space.as_mut()) {
            points.mean_abs *= 0.5;
        }
    });
    let (holds, said, complained) = against(&halved, &["--fail-worse", "--junit", text(&xml)]);
    assert!(!holds && said.contains("WORSE") && said.contains("+100.0 %"), "{said}");
    assert_eq!(complained.matches("worse than the baseline").count(), measured, "{complained}");
    let document = std::fs::read_to_string(&xml).expect("JUnit's XML");
    let document = roxmltree::Document::parse(&document).expect("XML");
    assert_eq!(document.descendants().filter(|node| node.has_tag_name("failure")).count(), measured);
    // A change within the margin of 150 % must pass.
    assert!(against(&halved, &["--fail-worse", "150%"]).0);
    if !is_timed {
        return skipped("baseline::times", "needs timestamps");
    }
    // Builds took a thousandth of the time.
    let quicker = changed(&before, scenes.path(), |results| {
        for timing in results.rows.iter_mut().filter_map(|row| row.build_ns.as_mut()) {
            (timing.median, timing.p05, timing.p95) = (timing.median / 1e3, timing.p05 / 1e3, timing.p95 / 1e3);
        }
    });
    let (holds, said, complained) = against(&quicker, &["--fail-slower", "5%"]);
    assert!(!holds && said.contains("SLOWER"), "{said}{complained}");
    assert_eq!(complained.matches("slower than the baseline").count(), measured, "{complained}");
}

/// Gives builds extra work, as a regression would: they must be reported as slower, and no error as larger. Other tests keep the processors
/// busy, and a noisy row must take twice its time to count as slower, so the extra work amounts to about three builds (results/baseline.sh
/// shows how small a change is found on a quiet machine).
#[test]
fn a_slower_build_is_found() {
    if is_long("a_slower_build_is_found") {
        return;
    }
    let scenes = folder();
    let scene = small_scene(scenes.path());
    let (mut last, mut slow) = (String::new(), BTreeSet::new());
    for _ in 0..8 {
        let (first, out) = (folder(), folder());
        ok(&arguments(&scene, first.path()));
        let before = results(first.path());
        let timed = before.rows.iter().filter(|row| row.build_ns.is_some()).count();
        if timed == 0 {
            return skipped("baseline::a_slower_build_is_found", "needs timestamps");
        }
        // Takes the quickest builds as the baseline, to exclude interference from other processes.
        let baseline = changed(&before, scenes.path(), |results| {
            for timing in results.rows.iter_mut().filter_map(|row| row.build_ns.as_mut()) {
                (timing.median, timing.p95) = (timing.p05, timing.p05);
            }
        });
        let mut slower = gobo();
        slower.env("GOBO_TEST_BURDEN", "960").args(arguments(&scene, out.path()));
        slower.args(["--baseline", &baseline, "--fail-slower", "--fail-worse"]);
        let output = slower.output().expect("the program starts");
        let [said, complained] =
            [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        assert!(!said.contains("WORSE"), "{said}{complained}");
        let found: Vec<_> = complained.lines().filter(|line| line.ends_with("slower than the baseline")).collect();
        assert_eq!(output.status.code() == Some(1), !found.is_empty(), "{said}{complained}");
        slow.extend(found.into_iter().map(str::to_owned));
        if slow.len() == timed {
            return log("exercised", "a_slower_build_is_found", &before.device.name);
        }
        last = said + &complained;
    }
    panic!("not found in eight runs: {last}");
}

/// A row in the baseline that the run lacks must be a skipped test case, or a failed one on request; but not in a shard, since another
/// shard may have the row.
#[test]
fn what_is_gone_is_told() {
    let (scenes, first, out) = (folder(), folder(), folder());
    let scene = small_scene(scenes.path());
    ok(&arguments(&scene, first.path()));
    let more = changed(&results(first.path()), scenes.path(), |results| {
        let mut row = results.rows[0].clone();
        row.technique = "another".into();
        results.rows.push(row);
    });
    let xml = out.path().join("junit.xml");
    for (options, fails) in [(&[][..], false), (&["--fail-gone"], true), (&["--fail-gone", "--shard", "1/2"], false)] {
        let mut all = arguments(&scene, out.path());
        all.extend(["--baseline", &more, "--junit", text(&xml)]);
        all.extend(options);
        let output = run(&all);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(i32::from(fails)), "{options:?}: {said}");
        assert_eq!(
            said.lines().any(|line| line.contains("another:") && line.ends_with("gone since the baseline")),
            fails
        );
        let document = std::fs::read_to_string(&xml).expect("JUnit's XML");
        let document = roxmltree::Document::parse(&document).expect("XML");
        let cases = document.descendants().filter(|node| node.has_tag_name("testcase"));
        let gone: Vec<_> =
            cases.filter(|case| case.attribute("name").expect("a name").starts_with("another:")).collect();
        assert_eq!(gone.len(), usize::from(!options.contains(&"--shard")), "{options:?}");
        for case in gone {
            let has = |tag| case.children().any(|node| node.has_tag_name(tag));
            assert_eq!((has("failure"), has("skipped")), (fails, !fails), "{options:?}");
            assert_eq!(case.attribute("time"), Some(""), "the run has no time of it");
        }
    }
}

#[test]
fn what_is_no_baseline_is_refused() {
    let (scenes, first) = (folder(), folder());
    let scene = small_scene(scenes.path());
    ok(&arguments(&scene, first.path()));
    let before = results(first.path());
    let other = changed(&before, scenes.path(), |results| results.device.driver = "another".into());
    let mut against = arguments(&scene, first.path());
    against.extend(["--baseline", &other]);
    fails(&against, &["--baseline", "it was measured with driver another"]);
    // Rows that all belong to another technique, then no rows at all.
    let others = changed(&before, scenes.path(), |results| {
        results.rows.iter_mut().for_each(|row| row.technique = "another".into());
    });
    let mut against = arguments(&scene, first.path());
    against.extend(["--baseline", &others]);
    fails(&against, &["--baseline", "another:", "beer-shadow-map:", "none is in this run", "repeat its command"]);
    let none = changed(&before, scenes.path(), |results| results.rows.clear());
    let mut against = arguments(&scene, first.path());
    against.extend(["--baseline", &none]);
    fails(&against, &["--baseline", "of its rows, none,"]);
    let more = changed(&before, scenes.path(), |results| {
        results.conditions.insert("--frames".into(), "7".into());
    });
    let mut against = arguments(&scene, first.path());
    against.extend(["--baseline", &more]);
    fails(&against, &["it was measured with --frames 7, and this is 6"]);
    let mut missing = arguments(&scene, first.path());
    missing.extend(["--baseline", "missing.json"]);
    fails(&missing, &["missing.json"]);
    let without = arguments(&scene, first.path());
    for option in ["--fail-slower", "--fail-gone"] {
        let mut without = without.clone();
        without.push(option);
        let output = run(&without);
        assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("--baseline"));
    }
}
