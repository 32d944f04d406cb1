//! `report`: devices side by side. Its output must equal figures recomputed from the JSON files.

use crate::errors::fails;
use crate::page::findings;
use crate::support::{is_long, log};
use crate::{folder, gobo, ok, small_scene, text};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Builds a row as another program would write it: milliseconds of a build and of a picture, half the width of both times' bands, a space
/// error.
fn row(nodes: &str, path: &str, build: f64, draw: f64, half: f64, error: f64) -> Value {
    let timing =
        |ms: f64| json!({ "median": ms * 1e6, "p05": (ms - half) * 1e6, "p95": (ms + half) * 1e6, "samples": 30 });
    let space = gobo::bench::PointError { mean_abs: error, ..Default::default() };
    json!({
        "scene": "s", "technique": "avsm", "variant": { "nodes": nodes, "path": path }, "path": path, "status": "ok", "reason": "",
        "build_ns": timing(build), "draw_ns": timing(draw), "frame_ns": (build + draw) * 1e6, "passes": [], "counters": {},
        "error": { "space": space },
    })
}

fn refused(nodes: &str, path: &str) -> Value {
    let mut row = row(nodes, path, 1.0, 1.0, 0.0, 0.0);
    for key in ["build_ns", "draw_ns", "frame_ns", "error"] {
        row[key] = Value::Null;
    }
    (row["status"], row["reason"]) = ("refused".into(), "needs fragmentShaderPixelInterlock".into());
    row
}

fn results(device: &str, rows: &[Value]) -> Value {
    let features = json!({ "geometry_shader": device == "a", "subgroup_size": 32 });
    json!({
        "schema": 3, "gobo": "0.1.0", "command": "gobo compare s", "rows": rows,
        "conditions": { "--frames": "30", "--picture": "640x360", "--truth": "full", "--quick": "false", "scene s": "12345678" },
        "device": { "name": device, "driver": format!("{device}-driver 1"), "api": "1.3", "type": "cpu", "features": features },
    })
}

fn write(folder: &Path, name: &str, results: &Value) -> String {
    let path = folder.join(name);
    std::fs::write(&path, results.to_string()).expect("written");
    text(&path).to_owned()
}

/// Reads the lines of a CSV file, keyed by column name.
fn csv(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).expect("devices.csv");
    reader.deserialize().map(|line| line.expect("a line")).collect()
}

/// Runs `gobo report` into the folder `out`, and returns what it prints.
fn report(out: &Path, files: &[&str]) -> String {
    let mut arguments = vec!["report"];
    arguments.extend(files);
    arguments.extend(["-o", text(out)]);
    ok(&arguments).lines().next().expect("a sentence").to_owned()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

/// Recomputes every figure of the committed results of several drivers from their files.
#[test]
fn figures_are_those_of_the_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let devices = ["nvidia-h200", "lavapipe-22.3", "swiftshader"];
    let of = |device: &&str| ["devices", "devices-meshes"].map(|name| root.join(device).join(format!("{name}.json")));
    let files: Vec<PathBuf> = devices.iter().flat_map(of).collect();
    let out = folder();
    report(out.path(), &files.iter().map(|path| text(path)).collect::<Vec<_>>());
    let mut rows: BTreeMap<(String, String, String), Value> = BTreeMap::new();
    for path in &files {
        let all = read(path);
        for row in all["rows"].as_array().expect("rows") {
            let variant = row["variant"].as_object().expect("keys").iter();
            let keys: Vec<_> = variant.map(|(key, value)| format!("{key}={}", value.as_str().expect("text"))).collect();
            let spec = format!("{}:{}", row["technique"].as_str().expect("text"), keys.join(","));
            let key = (
                all["device"]["driver"].as_str().expect("text").to_owned(),
                row["scene"].as_str().expect("text").to_owned(),
                spec,
            );
            assert!(rows.insert(key, row.clone()).is_none());
        }
    }
    let lines = csv(&out.path().join("devices.csv"));
    assert_eq!(lines.len(), rows.len(), "a line a row");
    let (mut ratios, mut first) = (0, None);
    for line in &lines {
        let row = &rows[&(line["driver"].clone(), line["scene"].clone(), line["variant"].clone())];
        let is = |column: &str, value: &Value| {
            assert_eq!(line[column].parse::<f64>().ok(), value.as_f64(), "{column} of {line:?}");
        };
        assert_eq!(line["status"], row["status"].as_str().expect("text"));
        is("median_ns", &row["frame_ns"]);
        is("build_median_ns", &row["build_ns"]["median"]);
        is("seen_mean", &row["error"]["seen"]["mean"]);
        is("cost_ns", &row["cost_ns"]);
        is("space_mean_abs", &row["error"]["space"]["mean_abs"]);
        is("image_flip_mean", &row["error"]["image"]["flip_mean"]);
        if line["status"] == "ok" {
            let medians = ["build_ns", "draw_ns"].map(|time| row[time]["median"].as_f64().expect("timed"));
            // In older files, frame times include bakes.
            let is_baked = row["technique"] == "voxelized" && row["frame_ns"].as_f64() == Some(medians[1]);
            let ends = ["p05", "p95"].map(|end| {
                let build = if is_baked { 0.0 } else { row["build_ns"][end].as_f64().expect("timed") };
                build + row["draw_ns"][end].as_f64().expect("timed")
            });
            assert_eq!([&line["p05_ns"], &line["p95_ns"]].map(|end| end.parse::<f64>().expect("a number")), ends);
        }
        let frame = line["median_ns"].parse::<f64>();
        let (is_measured, is_marked) = (line["status"] == "ok", !line["marks"].is_empty());
        match line["ratio_to_first"].as_str() {
            // The first unmarked column.
            "" if is_measured && !is_marked => first = Some((row, frame)),
            _ if !line["ratio_to_first"].is_empty() => {
                assert!(line["marks"].is_empty(), "{line:?}");
                let (other, first) = first.as_ref().expect("the first column comes first");
                for key in ["scene", "technique"] {
                    assert_eq!(row[key], other[key], "{line:?}");
                }
                for key in ["nodes", "path", "size"] {
                    assert_eq!(row["variant"][key], other["variant"][key], "{line:?}");
                }
                let ratio: f64 = line["ratio_to_first"].parse().expect("a number");
                let wanted = frame.expect("timed") / first.clone().expect("timed");
                assert!((ratio / wanted - 1.0).abs() < 1e-12, "{line:?}");
                ratios += 1;
            }
            _ => {}
        }
    }
    assert!(ratios > 16, "eight specs on two scenes and those of meshes, on SwiftShader: {ratios}");
    let page = std::fs::read_to_string(out.path().join("devices.html")).expect("a page");
    assert!(
        page.contains("refused: needs fragmentShaderPixelInterlock")
            && page.contains("<code>fragment_shader_pixel_interlock</code>")
    );
}

/// results/report must equal the output of its command in docs/guide/compare-devices.md.
#[test]
fn the_committed_report_is_of_the_committed_rows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide =
        std::fs::read_to_string(root.join("docs/guide/compare-devices.md")).expect("the guide").replace("\\\n", " ");
    let command = guide
        .lines()
        .map(str::trim)
        .find(|line| line.starts_with("gobo report") && line.ends_with("-o results/report"));
    let out = folder();
    let words = command.expect("the command").split_whitespace().map(|word| match word {
        "results/report" => text(out.path()),
        word => word,
    });
    let output = gobo().args(words.skip(1)).current_dir(root).output().expect("the program starts");
    assert!(output.status.success(), "{output:?}");
    for name in ["devices.md", "devices.csv", "devices.html"] {
        let [made, committed] = [out.path(), &root.join("results/report")]
            .map(|folder| std::fs::read_to_string(folder.join(name)).expect(name));
        assert!(made == committed, "{name} is another by now: {}", command.unwrap_or_default());
    }
}

/// Overlapping bands must count as no difference, separate bands as one; a different error must be found, with its device.
#[test]
fn what_differs_is_said_and_what_does_not_is_not() {
    let (files, out) = (folder(), folder());
    let rows = |build: f64, error: f64| {
        [
            row("4", "binned", 1.0, 1.0, 0.1, 0.01),
            row("8", "binned", build, 1.0, 0.1, error),
            row("16", "binned", 4.0, 1.0, 0.1, 0.001),
        ]
    };
    let a = write(files.path(), "a.json", &results("a", &rows(2.0, 0.005)));
    // The bands of a frame are twice as wide as these.
    let b = write(files.path(), "b.json", &results("b", &rows(2.3, 0.005 * 1.0005)));
    let same = report(out.path(), &[&a, &b]);
    assert_eq!(
        same,
        "No difference in time: noise bands overlap in all 3 rows that each two have; all 3 errors that two or more have agree to rounding."
    );
    let markdown = || std::fs::read_to_string(out.path().join("devices.md")).expect("a table");
    assert!(
        markdown()
            .contains("| `avsm:nodes=8,path=binned` | 3.00 [2.80–3.20] | 3.30 [3.10–3.50] ×1.10, no difference |"),
        "{}",
        markdown()
    );
    let c = write(files.path(), "c.json", &results("c", &rows(3.0, 0.006)));
    let said = report(out.path(), &[&a, &b, &c]);
    assert!(
        said.contains(
            "1 of 3 errors that two or more have differ by more than rounding (c alone in 1), by 0.00100 at most"
        ),
        "{said}"
    );
    assert!(
        markdown().contains(
            "| s | `avsm:nodes=8,path=binned` | space error | 0.00500 | 0.00500 | 0.00600 | 0.00100 | 20.0 % |"
        ),
        "{}",
        markdown()
    );
    for line in csv(&out.path().join("devices.csv")) {
        let of_c = line["device"] == "c" && line["variant"].contains("nodes=8");
        let (verdict, differs) = (line["verdict"].as_str(), line["differs"].as_str());
        assert_eq!((verdict == "slower", verdict.is_empty()), (of_c, line["device"] == "a"), "{line:?}");
        assert_eq!(differs, if line["variant"].contains("nodes=8") { "space error" } else { "" }, "{line:?}");
    }
    // If the scene or the points differ, nothing may be compared.
    let mut other = results("c", &rows(3.0, 0.006));
    other["conditions"]["scene s"] = "87654321".into();
    let other = write(files.path(), "other.json", &other);
    assert_eq!(
        report(out.path(), &[&a, &other]),
        "No two devices have a time of the same rows; no error is in two of them."
    );
    let page = std::fs::read_to_string(out.path().join("devices.html")).expect("a page");
    assert!(page.contains("its fingerprint is 87654321, and 12345678 on a"));
    let mut quick = results("c", &rows(3.0, 0.006));
    quick["conditions"]["--quick"] = "true".into();
    let quick = write(files.path(), "quick.json", &quick);
    assert!(report(out.path(), &[&a, &quick]).ends_with("; no error is in two of them."));
}

#[test]
fn interlock_is_held_against_what_does_without() {
    let (files, out) = (folder(), folder());
    let rows = |interlock: Value| {
        [
            interlock,
            row("8", "two-pass", 6.0, 1.0, 0.1, 0.01),
            row("8", "raster-order", 3.0, 1.0, 0.1, 0.01),
            row("8", "binned", 4.5, 1.0, 0.1, 0.01),
        ]
    };
    let a = write(files.path(), "a.json", &results("a", &rows(row("8", "interlock", 2.0, 1.0, 0.1, 0.01))));
    let b = write(files.path(), "b.json", &results("b", &rows(row("8", "interlock", 9.0, 1.0, 0.1, 0.01))));
    let c = write(files.path(), "c.json", &results("c", &rows(refused("8", "interlock"))));
    report(out.path(), &[&a, &b, &c]);
    let page = std::fs::read_to_string(out.path().join("devices.html")).expect("a page");
    let short = "What interlock buys: ×1.50 over raster-order, the next, on a; nothing on b, where raster-order is faster; refused on c.";
    assert!(page.contains(short), "{page}");
    let markdown = std::fs::read_to_string(out.path().join("devices.md")).expect("a table");
    let line = |device: &str| {
        markdown
            .lines()
            .find(|line| line.starts_with(&format!("| s `avsm` | {device} |")))
            .unwrap_or_else(|| panic!("{markdown}"))
    };
    assert!(line("a").ends_with("| 2.00 | 6.00 ×3.00 | 3.00 ×1.50 | 4.50 ×2.25 |"), "{markdown}");
    assert!(line("b").ends_with("| 9.00 | 6.00 ×0.667 | 3.00 ×0.333 | 4.50 ×0.500 |"), "{markdown}");
    assert!(line("c").contains("| refused: needs fragmentShaderPixelInterlock | 6.00 |"), "{markdown}");
}

/// Marks a row, so that its times decide nothing.
fn marked(mut row: Value) -> Value {
    row["marks"] = json!(["81 % raster work, on 4 of 132 processors"]);
    row
}

/// Builds the results of a device that draws on few of its processors.
fn lopsided(device: &str, rows: &[Value]) -> Value {
    let mut results = results(device, rows);
    results["device"]["stages"] = json!({ "fragment_slowdown": 32.9, "fragment_processors": 4, "processors": 132 });
    results
}

/// Marked rows must be shown, but affect neither the answer nor the sentence on interlock.
#[test]
fn what_is_marked_decides_nothing() {
    let (files, out) = (folder(), folder());
    let paths = |nodes: &str, times: [f64; 4]| {
        let named = ["interlock", "two-pass", "raster-order", "binned"];
        std::array::from_fn::<_, 4, _>(|path| row(nodes, named[path], times[path], 1.0, 0.1, 0.01))
    };
    let (few, many) = (paths("8", [29.0, 20.0, 30.0, 40.0]), paths("16", [2.0, 6.0, 3.0, 4.5]));
    // With all rows, raster-order would take √(30/29 · 1.5) = 1.25 times as long as interlock.
    let [interlock, others @ ..] = few.clone();
    let some = [&[marked(interlock)][..], &others, &many].concat();
    let a = write(files.path(), "a.json", &lopsided("a", &some));
    let b = write(files.path(), "b.json", &lopsided("b", &[few.map(marked), many.map(marked)].concat()));
    // Frames on c take a quarter of the time with nodes=8, half with nodes=16, and a tenth in the row marked on a. With all rows, the
    // median would be √(2 · 4).
    let c = [paths("8", [2.0, 4.25, 6.75, 9.25]), paths("16", [0.5, 2.5, 1.0, 1.75])].concat();
    let c = write(files.path(), "c.json", &results("c", &c));
    let said = report(out.path(), &[&a, &b, &c]);
    assert!(
        said.starts_with(
            "Without b, whose times are marked, c is the fastest: a frame takes 2.00 times as long on a (median of the 7 rows that both have);"
        ),
        "{said}"
    );
    let [markdown, page] =
        ["devices.md", "devices.html"].map(|name| std::fs::read_to_string(out.path().join(name)).expect(name));
    for text in [&markdown, &page] {
        let sentence = |rows: &str| {
            format!("fragments run on 4 of 132 processors, 33 times slower; {rows} marked †: more than a quarter of")
        };
        assert!(text.contains(&format!("a: {} its time is raster work", sentence("1 row is"))), "{text}");
        assert!(text.contains(&format!("b: {} their time is raster work", sentence("8 rows are"))), "{text}");
        assert!(!text.contains("c: fragments"), "{text}");
    }
    assert!(
        page.contains(
            "What interlock buys: ×1.50 over raster-order, the next, on a; not known on b, where rows are marked;"
        ),
        "{page}"
    );
    let long = "a: ×1.50 over raster-order, the next,; of interlock's build time two-pass takes ×3.00, raster-order takes ×1.50 and binned takes ×2.25; 1 of 8 rows is marked and left out";
    assert!(
        markdown.contains(long) && markdown.contains("- b: not known; 8 of 8 rows are marked and left out"),
        "{markdown}"
    );
    // Marked rows must be shown, with their marks.
    assert!(markdown.contains("| 29.0† | 20.0 | 30.0 | 40.0 |"), "{markdown}");
    let marks: Vec<bool> = csv(&out.path().join("devices.csv")).iter().map(|line| !line["marks"].is_empty()).collect();
    assert_eq!(marks.iter().filter(|marked| **marked).count(), 1 + 8);
    let alone = folder();
    assert_eq!(
        report(alone.path(), &[&b, &c]),
        "No two devices have a time of the same rows that is not marked; all 8 errors that two or more have agree to rounding."
    );
    report(alone.path(), &[&c]);
    assert!(csv(&alone.path().join("devices.csv")).iter().all(|line| !line.contains_key("marks")));
}

/// Parts of one run must form one column; older files must be readable, and editions on one device named by their files.
#[test]
fn parts_are_one_and_editions_two() {
    let (files, out) = (folder(), folder());
    let all = ["4", "8", "16"].map(|nodes| row(nodes, "binned", 1.0, 1.0, 0.1, 0.01));
    let whole = write(files.path(), "whole.json", &results("b", &all));
    let one = write(files.path(), "one.json", &results("a", &all[..1]));
    let two = write(files.path(), "two.json", &results("a", &all[1..]));
    report(out.path(), &[&whole, &one, &two]);
    let lines = csv(&out.path().join("devices.csv"));
    let of_a: Vec<_> = lines.iter().filter(|line| line["device"] == "a").map(|line| line["files"].as_str()).collect();
    assert_eq!(of_a, vec![format!("{one} {two}"); 3]);
    // A repeated row belongs to another run.
    let again = write(files.path(), "again.json", &results("a", &all[..2]));
    let said = report(out.path(), &[&one, &again]);
    assert!(said.contains("in all 1 row that"), "{said}");
    let markdown = std::fs::read_to_string(out.path().join("devices.md")).expect("a table");
    assert!(markdown.contains("/one.json)") && markdown.contains("/again.json)"), "{markdown}");
    assert_eq!(report(out.path(), &[&one, &two]), "All 3 rows are of one device, a; no error is in two of them.");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let [old, new] =
        ["tests/program/report/schema-1.json", "results/nvidia-h200/results.json"].map(|path| root.join(path));
    report(out.path(), &[text(&old), text(&new)]);
    assert!(
        csv(&out.path().join("devices.csv"))
            .iter()
            .any(|line| line["files"].ends_with("schema-1.json") && line["compared"] == "build")
    );
}

/// Two commits on one device must stand side by side under their names; parts of one commit must form one column, and an older file has no
/// commit.
#[test]
fn commits_are_side_by_side() {
    let (files, out) = (folder(), folder());
    let of = |commit: &str, changed: bool, rows: &[Value]| {
        let mut results = results("a", rows);
        (results["commit"], results["changed"]) = (commit.into(), changed.into());
        results
    };
    let rows = |build: f64| ["4", "8"].map(|nodes| row(nodes, "binned", build, 1.0, 0.1, 0.01));
    let (one, two) = ("1".repeat(40), "2".repeat(40));
    let before = write(files.path(), "before.json", &of(&one, false, &rows(4.0)));
    let parts = rows(2.0);
    let after = ["after.json", "rest.json"];
    let after = [0, 1].map(|part| write(files.path(), after[part], &of(&two, true, &parts[part..=part])));
    let said = report(out.path(), &[&before, &after[0], &after[1]]);
    let [old, new] = ["a-driver 1, gobo 0.1.0, commit 111111111", "a-driver 1, gobo 0.1.0, commit 222222222, changed"];
    assert!(said.starts_with(&format!("{new} is the fastest")) && said.contains(old), "{said}");
    let [page, markdown] =
        ["devices.html", "devices.md"].map(|name| std::fs::read_to_string(out.path().join(name)).expect(name));
    assert!(page.contains("gobo 0.1.0, commit 111111111; 2 rows"), "{page}");
    assert!(markdown.contains(&format!("| {new} | a-driver 1 | 0.1.0, commit 222222222, changed | 2 |")), "{markdown}");
    for line in csv(&out.path().join("devices.csv")) {
        let is_old = line["files"] == before;
        assert_eq!((&line["commit"], line["changed"].as_str()), if is_old { (&one, "false") } else { (&two, "true") });
    }
    // An older file names no commit, so it must not join the files of a commit.
    let older = write(files.path(), "older.json", &results("a", &rows(2.0)[..1]));
    report(out.path(), &[&after[0], &older, &after[1]]);
    assert!(
        csv(&out.path().join("devices.csv")).iter().any(|line| line["commit"].is_empty() && line["files"] == older)
    );
    // New results must name the commit that the program was built from, if there is one.
    let scene = small_scene(files.path());
    ok(&[
        "compare",
        text(&scene),
        "--quick",
        "--frames",
        "2",
        "--picture",
        "16x16",
        "--no-truth",
        "--technique",
        "none",
        "--out",
        text(out.path()),
    ]);
    let now = read(&out.path().join("results.json"));
    let is_hash = |commit: &Value| {
        commit.as_str().is_some_and(|hash| hash.len() == 40 && hash.chars().all(|c| c.is_ascii_hexdigit()))
    };
    assert_eq!(
        (is_hash(&now["commit"]), now["changed"].is_boolean()),
        (!now["commit"].is_null(), !now["commit"].is_null()),
        "{now}"
    );
}

#[test]
fn what_cannot_be_held_against_anything_is_one_line() {
    let files = folder();
    let here = |name: &str, value: &Value| write(files.path(), name, value);
    let a = here("a.json", &results("a", &[row("4", "binned", 1.0, 1.0, 0.1, 0.01)]));
    let b = here("b.json", &results("b", &[row("8", "binned", 1.0, 1.0, 0.1, 0.01)]));
    let copy = here("copy.json", &read(Path::new(&a)));
    let mut later = results("b", &[]);
    later["schema"] = 99.into();
    let later = here("later.json", &later);
    let no_json = files.path().join("no.json");
    std::fs::write(&no_json, "gobo").expect("written");
    let out: PathBuf = files.path().join("out");
    for (second, words) in [
        (a.as_str(), &[a.as_str(), "named twice"][..]),
        (&copy, &[copy.as_str(), "the same as", &a]),
        (&b, &[b.as_str(), "no row of it is in", "nodes=4", "nodes=8", "measure the same"]),
        (&later, &[later.as_str(), "schema 99"]),
        (text(&no_json), &["no.json", "no whole results.json"]),
        ("/nowhere/results.json", &["/nowhere/results.json"]),
    ] {
        fails(&["report", &a, second, "-o", text(&out)], words);
        assert!(!out.exists(), "nothing is written");
    }
}

/// Opens the page in Chromium, at three widths and in both themes: the console must stay empty, the network unused, and marks must be at
/// their times.
#[test]
fn the_page_holds_in_a_browser() {
    if is_long("the_page_holds_in_a_browser") {
        return;
    }
    log("exercised", "the_page_holds_in_a_browser", "Chromium");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let files = ["nvidia-h200/devices.json", "lavapipe-22.3/devices.json", "swiftshader/devices.json"]
        .map(|path| root.join(path));
    let out = folder();
    report(out.path(), &files.each_ref().map(|path| text(path)));
    let rows = csv(&out.path().join("devices.csv"));
    // A technique measured on one device only is compared with nothing, and has no marks.
    let is_shared = |row: &&BTreeMap<String, String>| {
        let key = |row: &BTreeMap<String, String>| ["scene", "technique"].map(|name| row[name].clone());
        rows.iter().filter(|other| key(other) == key(row)).count() > 1
    };
    let times: Vec<f64> = rows.iter().filter(is_shared).filter_map(|row| row["median_ns"].parse().ok()).collect();
    for dark in [false, true] {
        for found in findings(&out.path().join("devices.html"), include_str!("devices.js"), dark) {
            let number = |key: &str| found[key].as_f64().unwrap_or_else(|| panic!("no {key}: {found}"));
            assert!(
                found["failed"].is_null() && found["errors"] == json!([]) && found["resources"] == json!([]),
                "{found}"
            );
            let themes = ["rgb(255, 255, 255)", "rgb(20, 23, 26)"];
            let is = [&found["background"], &found["toggled"]];
            assert_eq!(is, if dark { [themes[1], themes[0]] } else { themes }, "{found}");
            assert!(number("overflow") <= 0.0 && number("letters") >= 13.0, "{found}");
            assert!(number("outside") == 0.0 && number("overlaps") == 0.0 && number("moved").abs() < 1.0, "{found}");
            let marks: Vec<[f64; 4]> = serde_json::from_value(found["marks"].clone()).expect("marks");
            assert!(marks.len() == times.len() && times.len() > 40, "a mark a time: {}, {}", marks.len(), times.len());
            // Each mark must name its time, and all marks of a scene must be on one logarithmic axis.
            for scene in marks.chunks(marks.len() / 2) {
                let [first, last] = [0, scene.len() - 1].map(|place| scene[place]);
                for [_, ms, at, said] in scene {
                    assert!(
                        (said / ms - 1.0).abs() < 6e-3 && times.iter().any(|ns| (ns / 1e6 / ms - 1.0).abs() < 1e-9),
                        "{found}"
                    );
                    let along =
                        |of: [f64; 4]| (ms / of[1]).ln() / (last[1] / first[1]).ln() * (last[2] - first[2]) + of[2];
                    assert!((along(first) - at).abs() < 0.004, "{ms} ms is at {at}: {found}");
                }
            }
        }
    }
}
