//! End-to-end tests of the program as a user runs it: the files that it writes, its error messages, and what an interrupted run leaves.

#![cfg(feature = "program")]

mod report;
mod stress;
#[path = "../support/mod.rs"]
mod support;

mod bake;
mod baseline;
mod colors;
mod devices;
mod errors;
mod faults;
mod footprints;
mod glsl;
mod help;
mod json;
mod moving;
mod page;
mod paint;
mod pictures;
mod recommend;
mod resume;
mod shards;
mod submit;
mod trace;

use gobo::bench::{Results, Status};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use support::log;
use tempfile::TempDir;

/// Returns a command that starts the program as this test was started: GOBO_RUNNER runs programs on another driver (setup.sh writes it).
/// Test hooks are enabled.
fn gobo() -> Command {
    let mut command = match std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty()) {
        Some(runner) => {
            let mut command = Command::new(runner);
            command.arg(env!("CARGO_BIN_EXE_gobo"));
            command
        }
        None => Command::new(env!("CARGO_BIN_EXE_gobo")),
    };
    command.arg("--test-hooks");
    command
}

fn run(arguments: &[&str]) -> Output {
    gobo().args(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

/// Runs the program, expects success, and returns its standard output.
#[track_caller]
fn ok(arguments: &[&str]) -> String {
    let output = run(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {}\n{error}", output.status);
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

/// Writes a scene file with a few particles above a ground: every feature at next to no cost.
fn small_scene(folder: &Path) -> PathBuf {
    let rows = [[0.0, 0.0, 1.0, 0.6, 1.2], [0.3, 0.2, 1.6, 0.4, 2.0], [-0.5, 0.1, 2.2, 0.5, 0.7]];
    write_scene(folder, "small", &rows.map(|row| row.map(|v: f64| v.to_string()).join(" ")))
}

/// Writes a scene file `name`.toml with these particles.
fn write_scene(folder: &Path, name: &str, rows: &[String]) -> PathBuf {
    let properties = ["x", "y", "z", "radius", "extinction"].map(|p| format!("property float {p}\n")).concat();
    let header = format!("ply\nformat ascii 1.0\nelement vertex {}\n{properties}end_header\n", rows.len());
    std::fs::write(folder.join(format!("{name}.ply")), header + &rows.join("\n") + "\n").expect("write particles");
    let ground = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n-4 -4 0\n4 -4 0\n4 4 0\n-4 4 0\n4 0 1 2 3\n";
    std::fs::write(folder.join("ground.ply"), ground).expect("write the ground");
    let scene = format!(
        "[[particles]]\nfile = \"{name}.ply\"\n[[meshes]]\nfile = \"ground.ply\"\n[light]\nkind = \"directional\"\n\
         direction = [0.5, 0.3, -0.81]\n[camera]\nposition = [6.0, -6.0, 5.0]\ntarget = [0.0, 0.0, 1.0]\n\
         up = [0.0, 0.0, 1.0]\nfov_y_degrees = 38.0\n"
    );
    let path = folder.join(format!("{name}.toml"));
    std::fs::write(&path, scene).expect("write the scene");
    path
}

/// Returns the default device's entry in `gobo devices --json`; cached, since every run of the program opens a device.
fn device() -> &'static serde_json::Value {
    static DEVICE: LazyLock<serde_json::Value> = LazyLock::new(|| {
        let devices: serde_json::Value = serde_json::from_str(&ok(&["devices", "--json"])).expect("JSON");
        let rank =
            |kind: &str| ["discrete", "integrated", "virtual", "cpu"].iter().position(|k| *k == kind).unwrap_or(4);
        let list = devices.as_array().expect("a list").iter();
        list.min_by_key(|d| rank(d["facts"]["type"].as_str().expect("a type"))).expect("a device").clone()
    });
    &DEVICE
}

/// Returns the name of the default device, and whether the path runs there.
fn runs(technique: &str, path: &str) -> (String, bool) {
    let device = device();
    let paths = device["paths"].as_array().expect("paths");
    let found = paths.iter().find(|p| p["technique"] == technique && p["path"] == path).expect("a known path");
    let runs = found["runs"].as_bool().expect("yes or no");
    assert_eq!(runs, found["missing"].is_null(), "what is missing is named: {found}");
    let fact = |name: &str| device["facts"][name].as_str().expect("text").to_owned();
    (format!("{}, {}", fact("name"), fact("driver")), runs)
}

fn results(folder: &Path) -> Results {
    Results::read(&folder.join("results.json")).expect("results.json")
}

/// Checks everything that `compare` promises, under validation.
#[test]
fn compare_writes_everything() {
    if crate::support::is_costly("compare_writes_everything") {
        return;
    }
    let (device, interlock) = runs("avsm", "interlock");
    if !runs("uncompressed", "list").1 {
        return support::skipped("compare_writes_everything", "needs fragmentStoresAndAtomics");
    }
    log("exercised", "compare_writes_everything", &device);
    let out = folder();
    // At 1.5 s the emitters have released about a hundred particles.
    let arguments = ["compare", "three-emitters", "--time", "1.5", "--quick", "--frames", "2", "--validation"];
    let lighting = if runs("any", "lighting=vertex").1 { "vertex" } else { "fragment" };
    let lists = format!("uncompressed:size=64,lighting={lighting}");
    let techniques = ["avsm:nodes=4,path=two-pass|interlock,size=64", &lists];
    let mut all = arguments.to_vec();
    techniques.iter().for_each(|t| all.extend(["--technique", t]));
    all.extend(["--out", text(out.path())]);
    let table = ok(&all);
    assert!(table.contains("draw ms"), "{table}");

    let results = results(out.path());
    assert_eq!((results.schema, results.gobo.as_str()), (4, env!("CARGO_PKG_VERSION")));
    assert_eq!(format!("{}, {}", results.device.name, results.device.driver), device);
    assert_eq!(results.device.features["fragment_shader_pixel_interlock"], interlock);
    assert!(results.command.starts_with("gobo compare three-emitters"), "{}", results.command);
    let rows: Vec<_> = results.rows.iter().map(|r| (r.technique.as_str(), r.path.as_str(), r.status)).collect();
    let second = if interlock { Status::Ok } else { Status::Refused };
    assert_eq!(
        rows,
        [("avsm", "two-pass", Status::Ok), ("avsm", "interlock", second), ("uncompressed", "list", Status::Ok)]
    );
    let opaque = support::opaque_passes(results.device.kind == "cpu");
    let culling = [opaque, &["bins.clear", "bins.horizon", "bins.count", "bins.place"]].concat();
    let passes = [
        [&culling[..], &["bins.mark", "bins.scan", "bins.compact", "list.clear", "list.capture", "avsm.resolve"]]
            .concat(),
        [&culling[..], &["bins.mark", "bins.scan", "bins.compact", "avsm.clear", "avsm.insert", "avsm.pack"]].concat(),
        [opaque, &["list.clear", "list.capture"]].concat(),
    ];
    for (row, passes) in results.rows.iter().zip(passes) {
        assert!(table.contains(&row.technique) && table.contains(&row.path), "{table}");
        if row.status == Status::Refused {
            assert!(row.reason.contains("fragmentShaderPixelInterlock"), "{}", row.reason);
            assert!(row.error.is_none() && row.picture.is_none() && row.bytes_resident.is_none());
            continue;
        }
        assert_eq!(row.passes.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), passes);
        let build = row.build_ns.expect("timed");
        let host = row.host_ns.expect("timed");
        assert_eq!((build.samples, host.samples), (2, 2));
        let draw = row.draw_ns.expect("timed");
        assert!((1..=2).contains(&draw.samples) && draw.p05 > 0.0, "{draw:?}");
        assert!(row.passes.iter().all(|p| p.p05_ns <= p.median_ns && p.median_ns <= p.p95_ns), "{:?}", row.passes);
        let sum: f64 = row.passes.iter().map(|p| p.p05_ns).sum();
        assert!(0.0 < sum && sum <= build.p95 * 1.001, "passes are parts of the build: {:?} {build:?}", row.passes);
        let error = row.error.as_ref().expect("measured");
        for points in [error.map.expect("maps"), error.space.expect("a look-up")] {
            assert!(points.mean_abs < 0.05 && points.points.is_some_and(|n| n > 0), "{error:?}");
        }
        assert!(error.image.expect("a truth").rmse < 0.1, "{error:?}");
        assert!(row.bytes_resident.is_some_and(|bytes| bytes >= 64 * 64 * 8), "{:?}", row.bytes_resident);
        for name in [&row.picture, &row.difference] {
            decodes(&out.path().join(name.as_ref().expect("a picture")), [320, 180]);
        }
    }
    // Exact lists must be closer to the truth than four nodes, and report every segment of the reference's map.
    let (compressed, exact) = (&results.rows[0], &results.rows[2]);
    let mean = |r: &gobo::bench::Row| r.error.as_ref().and_then(|e| e.map).expect("measured").mean_abs;
    assert!(mean(exact) < mean(compressed), "{} and {}", mean(exact), mean(compressed));
    let (counted, expected) = (exact.counters["fragments"], exact.counters["reference_fragments"]);
    assert!(counted.abs_diff(expected) <= expected / 1000, "{counted} fragments, the reference has {expected}");
    assert!(compressed.limit_mean_abs.expect("a limit") <= mean(compressed));

    decodes(&out.path().join("three-emitters-reference.png"), [320, 180]);
    let read = |name: &str| std::fs::read_to_string(out.path().join(name)).expect(name);
    assert_eq!(read("results.csv").lines().count(), 4, "a header and three rows");
    assert!(read("time-vs-error.svg").contains("</svg>") && read("frame-vs-error.svg").contains("</svg>"));
    let html = read("report.html");
    assert!(html.contains("data:image/png;base64,"), "pictures are in the page");
    // The only address allowed in the page is SVG's XML namespace, which nothing fetches.
    let html = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!html.contains("http://") && !html.contains("https://"), "the page needs no network");
}

#[track_caller]
fn decodes(path: &Path, size: [u32; 2]) {
    let picture = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert_eq!([picture.width(), picture.height()], size, "{}", path.display());
}

/// A killed run must leave complete files with the rows measured so far.
#[test]
fn an_interrupted_run_keeps_its_rows() {
    let (device, lists) = runs("avsm", "two-pass");
    if !lists {
        return support::skipped("an_interrupted_run_keeps_its_rows", "needs fragmentStoresAndAtomics");
    }
    log("exercised", "an_interrupted_run_keeps_its_rows", &device);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    // The first rows take moments, the last would take minutes, so the run never ends on its own.
    let technique = "avsm:path=two-pass,nodes=4|8|16,curve=linear|exponential,size=8|16|256|512";
    let arguments = ["compare", text(&scene), "--frames", "40", "--quick", "--technique", technique, "--out"];
    let mut child = gobo()
        .args(arguments)
        .arg(out.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let start = std::time::Instant::now();
    let file = out.path().join("results.json");
    while !file.exists() {
        assert!(start.elapsed().as_secs() < 60, "no row within a minute");
        assert!(child.try_wait().expect("asked").is_none(), "it ended before its first row");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().expect("killed");
    assert!(!child.wait().expect("ended").success(), "it had finished already");
    let rows = results(out.path()).rows;
    assert!((1..24).contains(&rows.len()), "{} of 24 rows", rows.len());
    for row in &rows {
        assert_eq!(row.status, Status::Ok, "{}", row.reason);
        assert!(row.error.is_some());
        decodes(&out.path().join(row.picture.as_ref().expect("a picture")), [320, 180]);
    }
}
